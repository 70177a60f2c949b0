"""Method `paper` on the GPU: golden values, the float64 twin, suns, passes, and what may change without new tables."""

import numpy as np
import pytest
from golden import golden_samples, luminance_errors
from scipy.interpolate import RegularGridInterpolator
from test_truth import model

from glcloth.errors import InputError
from glcloth.fabric import load_fabric
from glcloth.gpu.programs import programs
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.methods.paper import method as paper
from glcloth.methods.paper import precompute, tables
from glcloth.twins import convolution
from glcloth.twins.coordinates import level_from_sharpness
from glcloth.twins.frame import tangent_from_surface
from glcloth.twins.scatter import angles

VIEWS = np.array([[0, 0, 1], [0.5, 0.2, 0.84], [-0.3, 0.8, 0.52], [0.9, -0.3, 0.32], [-0.6, -0.75, 0.28]])
VIEWS /= np.linalg.norm(VIEWS, axis=1, keepdims=True)
LOBES = SphericalGaussians(
    [[0.2, 0.1, 1], [-0.7, 0.3, 0.5], [0.4, -0.9, 0.3], [0, 0.3, -1], [0.5, 0.5, -0.1]],
    [0.01, 3.0, 40.0, 0.8, 500.0],
    [[0.2, 0.3, 0.4], [1, 0.9, 0.8], [3, 3, 2], [1, 1, 1], [20, 15, 10]],
)


def read(fabric, found):
    """T as the shader reads it from the tables: linear between nodes and levels, mirror images undone; in float64."""
    theta, phi_k, phi_o = precompute.weight_axes(found.grid)

    def T(t, xi, omega_o, sharpness, *_):
        tangent, place = fabric.tangents[t], found.placements[t]
        where = []
        for omega in (xi, omega_o):
            local = tangent_from_surface(
                np.asarray(omega, float), tangent.yarn, np.cos(tangent.tilt), np.sin(tangent.tilt)
            )
            at_theta, at_phi = angles(local)
            where.append((place.theta * np.clip(at_theta, -np.pi / 2, np.pi / 2), place.phi * at_phi))
        level = float(level_from_sharpness(sharpness, 0.5, 1500.0, precompute.LEVELS))
        low = min(int(level), precompute.LEVELS - 2)
        total = 0.0
        for n, share in ((low, low + 1 - level), (low + 1, level - low)):
            xi_factor = RegularGridInterpolator((theta, phi_k), found.xi[place.shape][n].transpose(1, 2, 0))(where[0])
            o_factor = RegularGridInterpolator((theta, phi_o), found.o[place.shape][n].transpose(1, 2, 0))(where[1])
            total += share * np.sum(xi_factor * o_factor)
        return max(total, 0.0)

    return T


@pytest.mark.parametrize("name", ["silk_crepe_de_chine", "velvet"])
@pytest.mark.parametrize("segments", [6, 7, 32])
def test_the_shader_is_its_twin(renderer, name, segments):
    """The printed equations in float64 with the same T; T_l by quadrature, so its table shows: 1 % of the brightest."""
    fabric = load_fabric(name)
    found = tables.tables_for(fabric, 16, 0.9)
    got = renderer.radiance(fabric, VIEWS, LOBES, method="paper", segments=segments, grid=16, contribution=0.9)
    T = read(fabric, found)
    lights = LOBES.axis, LOBES.sharpness, LOBES.amplitude
    expected = [convolution.L_o(o, *lights, *model(fabric), segments=segments, T=T) for o in VIEWS]
    assert np.allclose(got, expected, rtol=0.01, atol=0.002 * np.max(expected))


def test_golden_at_16_segments_and_at_6(renderer, shared):
    """[Miz 8-16]  Within 3 % (median) of T times I, both exact, at 16 segments; of exact T with 6 segments at 6.

    Tables of 24 x 24 directions and 95 %, which are quick; docs/paper.md has the figures for those of the paper.
    """
    for segments, key, most in ((16, "L_paper_exactTI", 0.02), (6, "L_paper_6seg", 0.015)):
        errors, quick = [], dict(grid=24, contribution=0.95)
        for fabric, omega_o, lights, expected in golden_samples(shared, "paper", key):
            got = renderer.radiance(fabric, omega_o, lights, method="paper", segments=segments, **quick)
            errors.append(luminance_errors(got, expected))
        errors = np.concatenate(errors)
        assert np.median(errors) < most and np.percentile(errors, 95) < 0.05


def test_suns_are_exact_and_counted_once(renderer, monkeypatch):
    fabric = load_fabric("linen")
    suns = Suns([[0.3, 0.4, 0.8], [-0.5, 0.1, -0.2]], [[2.0, 1.5, 1.0], [5, 5, 5]])
    alone = Lights(SphericalGaussians(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3))), suns)
    exact = renderer.radiance(fabric, VIEWS, alone, method="reference", cube=2)
    settings = dict(method="paper", grid=16)
    assert np.allclose(renderer.radiance(fabric, VIEWS, alone, **settings), exact, rtol=1e-4, atol=1e-6)
    both = renderer.radiance(fabric, VIEWS, Lights(LOBES, suns), **settings)
    lobes = renderer.radiance(fabric, VIEWS, LOBES, **settings)
    assert np.allclose(both, lobes + exact, rtol=1e-4, atol=1e-6)
    # In as many passes as there are Gaussians the sum is the same.
    monkeypatch.setattr(paper, "MOST_ITERATIONS", 1)
    assert len(list(renderer.method("paper").passes())) == len(LOBES)
    split = renderer.radiance(fabric, VIEWS, Lights(LOBES, suns), **settings)
    assert np.allclose(split, both, rtol=1e-5, atol=1e-6)


def test_64_gaussians_and_64_segments(renderer):
    """One Gaussian split into 64 equal ones gives the same light; no loop ends early."""
    fabric = load_fabric("satin_charmeuse_front")
    one = SphericalGaussians([[0.3, 0.2, 0.9]], [4.0], [[1.0, 2.0, 3.0]])
    many = SphericalGaussians(np.tile(one.axis, (64, 1)), np.full(64, 4.0), np.tile(one.amplitude / 64, (64, 1)))
    settings = dict(method="paper", segments=64, grid=16)
    few = renderer.radiance(fabric, VIEWS, one, **settings)
    assert few.min() > 0
    assert np.allclose(renderer.radiance(fabric, VIEWS, many, **settings), few, rtol=1e-4)


def test_parameters_change_without_new_tables(renderer, monkeypatch):
    linen = load_fabric("linen")
    settings = dict(method="paper", grid=16)
    before = renderer.radiance(linen, VIEWS, LOBES, **settings)

    def refuse(*_):
        raise AssertionError("tables were asked for")

    monkeypatch.setattr(paper, "tables_for", refuse)
    compiled = len(programs(renderer.ctx))
    change = dict(albedo=(0.5, 0.4, 0.3), eta=1.3, k_d=0.6, gamma_s_deg=20, gamma_v_deg=30)
    edited = linen.model_copy(update=dict(yarn=tuple(y.model_copy(update=change) for y in linen.yarn)))
    after = renderer.radiance(edited, VIEWS, LOBES, segments=9, **settings)
    assert len(programs(renderer.ctx)) == compiled and np.abs(after - before).min() > 1e-4
    turned = renderer.radiance(edited, VIEWS, LOBES.rotated(np.diag([-1.0, -1.0, 1.0])), segments=9, **settings)
    assert not np.allclose(turned, after, rtol=1e-3)
    retilted = linen.model_copy(update=dict(sigma_deg=25.0))
    with pytest.raises(AssertionError, match="asked for"):
        renderer.radiance(retilted, VIEWS, LOBES, **settings)


def test_extreme_lights_are_finite(renderer):
    """Sharper than the last level, constant, along a thread, behind, and black."""
    axis = [[0, 0, 1], [0, 0, 1], [1, 0, 0], [0, 0, -1], [0, -1, 0]]
    lights = SphericalGaussians(axis, [1e6, 0.0, 300.0, 2.0, 0.5], [[1e4] * 3, [1] * 3, [9] * 3, [1] * 3, [0] * 3])
    poles = np.array([[0, 0, 1], [1, 0, 1e-3], [0, 1, 1e-3], [-1, 0, 1e-3], [0.7071, 0.7071, 0]])
    for name in ("linen", "velvet"):
        got = renderer.radiance(name, poles, lights, method="paper", grid=16)
        assert np.isfinite(got).all() and got.min() >= 0


def test_wide_volumes_of_slices_are_tiled(renderer, monkeypatch):
    """More slices than a 3D texture is deep lie side by side and read the same."""
    whole = renderer.radiance("linen", VIEWS, LOBES, method="paper", grid=16, contribution=0.95)
    method = paper.Paper(renderer.ctx)
    monkeypatch.setattr(paper, "DEEPEST", 5)
    monkeypatch.setitem(renderer.stage.cloths[0].methods, "paper", method)
    tiled = renderer.radiance("linen", VIEWS, LOBES, method="paper", grid=16, contribution=0.95)
    assert method.inputs()["tiling"][1] > 1 and np.allclose(tiled, whole, rtol=1e-3, atol=1e-5)
    method.release()


@pytest.mark.parametrize("settings", [dict(segments=1), dict(segments=65), dict(grid=2), dict(contribution=1.5)])
def test_wrong_settings_are_refused(renderer, settings):
    with pytest.raises(InputError, match="expected"):
        renderer.radiance("linen", VIEWS, LOBES, method="paper", **settings)


def test_light_below_the_horizon_does_not_reach_upright_fibres(renderer):
    """A narrow Gaussian below the horizon of N: T of an upright tangent is 0 there, as the reference has it."""
    below = SphericalGaussians([[0.6, 0.1, -0.79]], [200.0], [[1.0, 1.0, 1.0]])
    above = SphericalGaussians([[0.6, 0.1, 0.79]], [200.0], [[1.0, 1.0, 1.0]])
    settings = dict(method="paper", grid=16)
    lit = renderer.radiance("velvet", VIEWS, above, **settings).max()
    assert renderer.radiance("velvet", VIEWS, below, **settings).max() < 0.02 * lit
