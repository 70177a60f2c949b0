"""The paper method's tables: texels against quadrature, the SVD against a dense one, mirror images, and the cache."""

import numpy as np
import pytest

from glcloth.errors import InputError
from glcloth.fabric import Fabric, load_fabric
from glcloth.methods.paper import azimuth, precompute, tables
from glcloth.methods.paper.shapes import shapes_of
from glcloth.twins import convolution
from glcloth.twins.azimuth import T_l, azimuth_mass
from glcloth.twins.frame import tangent_axes


def weave(tilts_1, tilts_2, **changes):
    yarn = dict(albedo=[0.5, 0.4, 0.3], eta=1.5, k_d=0.2, gamma_s_deg=8, gamma_v_deg=15)
    yarns = [dict(yarn, area=a, tangents_deg=t) for a, t in ((0.6, tilts_1), (0.3, tilts_2))]
    return Fabric.parse(dict(name="test", yarn=yarns, **changes))


def T_at(found, placement, level):
    """T [theta_k, phi_k, theta_o, phi_o] of one tangent at the nodes, its mirror image undone."""
    xi, o = found.xi[placement.shape][level], found.o[placement.shape][level]
    T = np.einsum("rab,rcd->abcd", xi.astype(float), o.astype(float))
    return T[:: placement.theta, :: placement.phi, :: placement.theta, :: placement.phi]


@pytest.fixture(scope="module")
def skew():
    """An asymmetric weave and its tables on a small grid, nothing truncated; upright tangents among them."""
    fabric = weave([-35, 10, 40, 90], [15, -52, -70], sigma_deg=20)
    return fabric, precompute.compute_tables(fabric, 12, 0.9999)


def test_T_l_at_texels_and_between(rng):
    """[Miz 14]  Nodes to rounding; between them within 2 % of what matters, at the 95th percentile 0.7 %."""
    from scipy.interpolate import RegularGridInterpolator

    from glcloth.twins.coordinates import unit_from_kappa

    phi_o, phi_k, kappa = azimuth.azimuth_axes()
    table = azimuth.azimuth_table()
    for i, j, k in zip(rng.integers(0, 31, 40), rng.integers(0, 31, 40), rng.integers(0, 48, 40), strict=True):
        for power in (1, 4, 10):
            exact = T_l(power, phi_o[k], phi_k[j], kappa[i]) / azimuth_mass(phi_k[j], kappa[i])
            assert table[i, j, k, power - 1] == pytest.approx(exact, rel=1e-9, abs=1e-12)
    axes = unit_from_kappa(kappa, kappa[-1]), phi_k, phi_o
    look_up = RegularGridInterpolator(axes, table)
    at = rng.uniform([0, 0, -np.pi / 2], [1500, np.pi * 0.7, np.pi / 2], (400, 3))
    at[:, 0] = np.expm1(rng.uniform(0, np.log(1500), 400))
    mass = azimuth_mass(at[:, 1], at[:, 0])
    got = look_up(np.stack([unit_from_kappa(at[:, 0], kappa[-1]), at[:, 1], at[:, 2]], -1))
    for power in (1, 2, 6, 10):
        exact = T_l(power, at[:, 2], at[:, 1], at[:, 0])
        error = np.abs(got[:, power - 1] * mass - exact) / mass
        assert np.percentile(error, 95) < 0.007 and error.max() < 0.02


def test_T_W_at_texels(skew, rng):
    """[Miz 9]  Against brute force, for tangents of both yarns, light from the whole sphere and every level."""
    fabric, found = skew
    theta, phi_k, phi_o = precompute.weight_axes(found.grid)
    levels = precompute.sharpness_levels()
    errors = []
    for n in range(48):
        t, level = n % len(fabric.tangents), rng.integers(0, 13)
        a, b = rng.integers(1, 11, 2)
        c, d = rng.integers(1, 11, 2)
        tangent = fabric.tangents[t]
        axes = np.stack(tangent_axes(tangent.yarn, np.cos(tangent.tilt), np.sin(tangent.tilt)))
        xi, omega_o = (precompute._directions(theta[[i]], phi) @ axes for i, phi in ((a, phi_k[[b]]), (c, phi_o[[d]])))
        got = T_at(found, found.placements[t], level)[a, b, c, d]
        weights = np.stack([np.ones(len(fabric.tangents)), fabric.weights[:, 1]], -1)
        args = fabric.tangents, weights, fabric.gap, fabric.sigma
        exact = convolution.T_W(t, xi[0], omega_o[0], levels[level], *args, panels=10)
        errors.append([abs(got - exact), exact])
    difference, exact = np.array(errors).T
    # Cells of 1.9 degrees; W is 0.4 on average here and up to 3.
    assert exact.max() > 1 and np.median(difference) < 1e-3 and difference.max() < 0.03


def test_broad_gaussians_at_few_nodes_equal_the_cells(rng, monkeypatch):
    theta, phi_k, _ = precompute.weight_axes(10)
    q = precompute._cells()
    solid_angle = np.repeat(np.cos(q), precompute.CELLS)[:, None]
    columns = np.concatenate([rng.uniform(0, 1, (len(solid_angle), 3)) * solid_angle, solid_angle], 1)
    columns = columns.reshape(precompute.CELLS, precompute.CELLS, 4).astype(np.float32)
    for sharpness in (0.0, 2.0, 30.0, 80.0):
        few = precompute._convolved(sharpness, theta, phi_k, columns)
        with monkeypatch.context() as patch:
            patch.setattr(precompute, "_nodes", lambda sharpness, columns, rows: (q, q, columns))
            all_cells = precompute._convolved(sharpness, theta, phi_k, columns)
        assert np.allclose(few, all_cells, rtol=3e-5)


@pytest.fixture(scope="module")
def spectrum():
    """T of linen on a 20 x 20 grid at the sharpest level as a dense matrix, its SVD, and the columns of W."""
    shape = shapes_of(load_fabric("linen"))[0][0]
    theta, phi_k, phi_o = precompute.weight_axes(20)
    q = precompute._cells()
    solid_angle = np.repeat(np.cos(q), precompute.CELLS)[:, None].astype(np.float32)
    W = precompute._W_of_cells(shape, theta, phi_o)
    W *= solid_angle * precompute.horizon_share(shape.tilt, q, q)[:, None].astype(np.float32)
    columns = np.concatenate([W, solid_angle], 1).reshape(precompute.CELLS, precompute.CELLS, -1)
    T = precompute._convolved(1500.0, theta, phi_k, columns).astype(float)
    return W, solid_angle, theta, phi_k, T, np.linalg.svd(T, compute_uv=False)


def test_the_working_rank_finds_the_rank_of_a_dense_svd(spectrum):
    W, solid_angle, theta, phi_k, T, values = spectrum
    dense = np.searchsorted(np.cumsum(values), 0.9 * values.sum()) + 1
    left, basis = precompute._factor(W, precompute.working_rank(0.9, 400))
    columns = np.concatenate([left, solid_angle], 1).reshape(precompute.CELLS, precompute.CELLS, -1)
    C = precompute._convolved(1500.0, theta, phi_k, columns)
    xi, o, found = precompute._compressed(C, basis, 0.9)
    assert abs(len(xi) - dense) <= 1
    assert np.allclose(found[:20], values[:20], rtol=2e-3)
    # The truncated product is as good as the best of its rank.
    best = np.sqrt(np.sum(values[len(xi) :] ** 2))
    assert np.linalg.norm(T - xi.T.astype(float) @ o) < 1.05 * best


def test_the_error_falls_as_the_contribution_rises(spectrum):
    T, values = spectrum[4:]
    errors, ranks = [], []
    for contribution in (0.5, 0.9, 0.99, 0.999):
        xi, o, _ = precompute._compressed(T.astype(np.float32), np.eye(T.shape[1], dtype=np.float32), contribution)
        kept = values[: len(xi)].sum() / values.sum()
        assert kept >= contribution * (1 - 1e-6) and values[: len(xi) - 1].sum() / values.sum() < contribution
        errors.append(np.linalg.norm(T - xi.T.astype(float) @ o) / np.linalg.norm(T))
        ranks.append(len(xi))
    assert ranks == sorted(ranks) and errors == sorted(errors, reverse=True) and errors[1] < 0.05 and errors[3] < 1e-3


@pytest.mark.parametrize("name", ["silk_crepe_de_chine", "satin_charmeuse_back"])
def test_ranks_grow_with_sharpness(name):
    """Figures 8 and 9 of paper A: few singular values, more for sharper Gaussians; the same for mirrored tangents."""
    fabric = load_fabric(name)
    found = precompute.compute_tables(fabric, 24, 0.9)
    assert (np.diff(found.ranks, axis=1) >= 0).all()
    assert (found.ranks[:, 0] == 1).all() and found.ranks.min() >= 1
    assert found.ranks[:, -1].min() >= 7 and found.ranks.max() <= 16
    by_tilt = {(t.yarn, t.tilt): p.shape for t, p in zip(fabric.tangents, found.placements, strict=True)}
    assert all(by_tilt[yarn, tilt] == by_tilt[yarn, -tilt] for yarn, tilt in by_tilt)


def test_mirror_images_share_tables():
    linen = shapes_of(load_fabric("linen"))
    assert len(linen[0]) == 1 and len(linen[1]) == 4
    assert len(shapes_of(weave([-35, 10, 40], [15]))[0]) == 4
    assert len(shapes_of(weave([-30, 30], [-10, 10]))[0]) == 2
    # The weave mirrored in x: theta turns around for yarn 1, phi for yarn 2.
    one, two = weave([20, -5], [30]), weave([-20, 5], [30])
    T_1, T_2 = (precompute.compute_tables(f, 8, 0.9999) for f in (one, two))
    for t, tangent in enumerate(one.tangents):
        image = (0, -tangent.tilt) if tangent.yarn == 0 else (1, tangent.tilt)
        other = [u[:2] == image for u in two.tangents].index(True)
        a, b = T_at(T_1, T_1.placements[t], 8), T_at(T_2, T_2.placements[other], 8)
        flip = b[::-1, :, ::-1, :] if tangent.yarn == 0 else b[:, ::-1, :, ::-1]
        assert np.allclose(a, flip, atol=2e-4)


def test_only_the_weave_changes_the_tables():
    linen = load_fabric("linen")
    yarns = tuple(y.model_copy(update=dict(albedo=(1, 1, 1), k_d=0.9, gamma_v_deg=50, eta=1.3)) for y in linen.yarn)
    assert shapes_of(linen.model_copy(update=dict(yarn=yarns)))[0] == shapes_of(linen)[0]
    for change in (dict(sigma_deg=15), dict(normalization="paper")):
        changed = linen.model_validate(linen.model_dump() | change)
        assert shapes_of(changed)[0] != shapes_of(linen)[0]


# -- cache -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path))
    return tmp_path


def same(a, b):
    return all(
        np.array_equal(x, y)
        for side in ("xi", "o", "values")
        for p, q in zip(getattr(a, side), getattr(b, side), strict=True)
        for x, y in zip(p, q, strict=True)
    )


def test_the_cache_returns_what_was_computed(cache):
    fabric = weave([-20, 20], [0])
    first = tables.tables_for(fabric, 8)
    assert first.seconds > 0 and len(list(cache.rglob("*.npz"))) == 1
    again = tables.tables_for(fabric, 8)
    assert again.seconds == 0 and same(first, again) and again.placements == first.placements
    assert same(first, precompute.compute_tables(fabric, 8))  # remade, to the bit
    for other in ((fabric, 10), (fabric, 8, 0.99), (weave([-20, 20], [5]), 8)):
        assert tables.tables_for(*other).seconds > 0
    assert len(list(cache.rglob("*.npz"))) == 4


@pytest.mark.parametrize("damage", ["truncated", "garbage", "flipped", "empty", "other format", "wrong shapes"])
def test_damaged_files_are_made_anew(cache, damage, monkeypatch):
    fabric = weave([-20, 20], [0])
    good = tables.tables_for(fabric, 8)
    (path,) = cache.rglob("*.npz")
    raw = path.read_bytes()
    if damage == "truncated":
        path.write_bytes(raw[: len(raw) // 2])
    elif damage == "garbage":
        path.write_bytes(b"not a table" * 50)
    elif damage == "flipped":
        path.write_bytes(raw[:-2000] + bytes([raw[-2000] ^ 255]) + raw[-1999:])
    elif damage == "empty":
        path.write_bytes(b"")
    else:
        with np.load(path) as file:
            content = dict(file)
        if damage == "other format":
            content["format"] = content["format"] + 1
        else:
            content["xi"] = content["xi"][:-1]
        np.savez(path, **content)
    remade = tables.tables_for(fabric, 8)
    assert remade.seconds > 0 and same(good, remade)
    assert tables.tables_for(fabric, 8).seconds == 0


def test_an_unwritable_cache_is_no_obstacle(cache, monkeypatch):
    (cache / "tables").write_text("a file where the folder should be")
    assert tables.tables_for(weave([-20, 20], [0]), 8).seconds > 0


def test_parameters_out_of_range():
    for grid, contribution in ((4, 0.9), (200, 0.9), (48, 0.0), (48, 1.0), (48, float("nan"))):
        with pytest.raises(InputError, match="expected"):
            tables.tables_for("linen", grid, contribution)


# -- texels ----------------------------------------------------------------------------------------------------------


def test_slices_hold_the_factors(skew):
    _, found = skew
    texels, first = tables.slices(found.xi), tables.slice_index(found)
    assert len(texels) == first[-1, -1]
    for shape, levels in enumerate(found.xi):
        for level, factors in enumerate(levels):
            part = texels[first[shape, level] : first[shape, level + 1]]
            back = part.transpose(0, 3, 1, 2).reshape(-1, found.grid, found.grid)
            assert np.array_equal(back[: len(factors)], factors) and not back[len(factors) :].any()
    volume, depth, columns = tables.tiled(texels, 7)
    assert depth <= 7 and columns * depth >= len(texels)
    for s in range(len(texels)):
        row = (s // depth) * found.grid
        assert np.array_equal(volume[s % depth, row : row + found.grid], texels[s])


def test_the_report_adds_up():
    facts = tables.tables_report("linen", precompute.compute_tables(load_fabric("linen"), 8))
    ranks = np.array(facts["tangents"][0]["ranks"])
    assert facts["bytes"] == 2 * 16 * 64 * np.sum(-(-ranks // 4)) and facts["seconds"] > 0
    assert len(facts["tangents"]) == 4 and len(facts["sharpness"]) == len(ranks)


@pytest.fixture
def rng():
    return np.random.default_rng(5)


@pytest.mark.parametrize("tilt", [90, -90, 89.99999999])
def test_an_upright_tangent_is_not_turned_over_by_rounding(tilt):
    """Rounded to nine digits pi / 2 would be more than a right angle."""
    for shape in shapes_of(weave([tilt], [15]))[0]:
        assert np.cos(shape.tilt) > 0.0 and abs(shape.tilt) <= np.pi / 2
