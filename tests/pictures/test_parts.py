"""Radiance in parts, one for each tangent: by every method they add up to the whole, and each is its float64 twin's."""

import numpy as np
import pytest
from test_paper_method import LOBES, VIEWS, read

from glcloth.color import luminance
from glcloth.fabric import load_fabric
from glcloth.gpu.scene_buffers import SceneBuffers
from glcloth.light.environment import cube_map_of_gaussians
from glcloth.light.lights import Lights, Suns
from glcloth.methods.paper.tables import tables_for
from glcloth.methods.registry import make_method
from glcloth.methods.settings import Settings
from glcloth.twins import cloth, convolution, quadrature

SETTINGS = Settings(quality="high", segments=16, grid=16, cube=8)
# Narrow lobes with nodes of their own, broad ones without, gaps, both yarns on several tangents.
FABRICS = ("linen", "silk_crepe_de_chine", "velvet")


@pytest.fixture
def shared_buffers(ctx):
    buffers = SceneBuffers(ctx)
    yield buffers
    buffers.release()


def parts_and_whole(ctx, buffers, name, fabric, lights):
    method = make_method(ctx, name)
    parts = method.part_radiances(buffers, fabric, lights, SETTINGS, VIEWS)
    buffers.prepare(fabric, lights)
    method.prepare(fabric, lights, SETTINGS)
    whole = method.radiance(buffers, VIEWS)
    method.release()
    return parts, whole


@pytest.mark.parametrize("fabric", FABRICS)
@pytest.mark.parametrize("name", ["direct", "paper", "reference"])
def test_parts_add_up(ctx, shared_buffers, name, fabric):
    fabric = load_fabric(fabric)
    lights = Lights(LOBES, Suns([[0.3, 0.4, 0.8]], [[2.0, 1.5, 1.0]]))
    parts, whole = parts_and_whole(ctx, shared_buffers, name, fabric, lights)
    assert parts.shape == (len(VIEWS), len(fabric.tangents), 3)
    assert np.allclose(parts.sum(1), whole, rtol=1e-5, atol=1e-6 * whole.max())
    assert ((parts > 0).any((0, 2))).all()  # each tangent is seen from somewhere


@pytest.mark.parametrize("fabric", FABRICS)
def test_parts_of_the_reference_are_the_twins(ctx, shared_buffers, fabric):
    fabric = load_fabric(fabric)
    parts, _ = parts_and_whole(ctx, shared_buffers, "reference", fabric, Lights(LOBES))
    omega, solid_angle, radiance = cube_map_of_gaussians(LOBES, SETTINGS.cube)
    for part in range(len(fabric.tangents)):
        expected = cloth.L_o(VIEWS, omega, solid_angle[:, None] * radiance, *fabric.arrays(part))
        assert np.allclose(parts[:, part], expected, rtol=2e-3, atol=1e-5)


@pytest.mark.parametrize("fabric", ["linen", "silk_crepe_de_chine"])
def test_parts_of_the_paper_method_are_the_twins(ctx, shared_buffers, fabric):
    fabric = load_fabric(fabric)
    parts, whole = parts_and_whole(ctx, shared_buffers, "paper", fabric, Lights(LOBES))
    T = read(fabric, tables_for(fabric, SETTINGS.grid, SETTINGS.contribution))
    lights = LOBES.axis, LOBES.sharpness, LOBES.amplitude
    for part in range(len(fabric.tangents)):
        expected = [convolution.L_o(o, *lights, *fabric.arrays(part), segments=SETTINGS.segments, T=T) for o in VIEWS]
        assert np.allclose(parts[:, part], expected, rtol=0.01, atol=0.002 * whole.max())


@pytest.mark.parametrize("fabric", FABRICS)
def test_parts_of_direct_by_brute_force(ctx, shared_buffers, fabric):
    """Within the error that docs/direct.md states for the whole, of the whole's brightness."""
    fabric = load_fabric(fabric)
    parts, whole = parts_and_whole(ctx, shared_buffers, "direct", fabric, Lights(LOBES))
    A = np.array([fabric.yarn[tangent.yarn].albedo for tangent in fabric.tangents])
    expected = np.zeros(parts.shape)
    for v, omega_o in enumerate(VIEWS):
        for xi, sharpness, L in zip(LOBES.axis, LOBES.sharpness, LOBES.amplitude, strict=True):
            terms = quadrature.integrals(omega_o, xi, sharpness, *fabric.arrays(), panels=12)
            expected[v] += L * (terms[:, :1] + terms[:, 1:] * A)
    error = np.abs(luminance(parts) - luminance(expected)) / luminance(whole)[:, None]
    assert np.median(error) < 0.005 and error.max() < 0.02
