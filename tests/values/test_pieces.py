"""Built-in cloths that are kept as vertices of a simulation, and what they hang on."""

import numpy as np
import pytest
from test_simulation import crossings

from glcloth.geometry.mesh_files import BUILTIN_SOLIDS, MESHES, load_mesh, load_solid
from glcloth.geometry.parts import names_of
from glcloth.geometry.pieces import SAMPLES
from glcloth.geometry.spline import packed, surface_mesh, unpacked
from glcloth.geometry.supports import FORM, HEAD, PEDESTAL, SHRUNK
from glcloth.scene import builtin_scenes, load_scene
from glcloth.simulation.pieces import PIECES


@pytest.mark.parametrize("name", SAMPLES)
def test_a_piece_is_whole_and_does_not_cross_itself(name):
    mesh = load_mesh(name)
    assert (MESHES / f"{name}.npz").stat().st_size < 100_000
    assert np.isfinite(mesh.positions).all() and mesh.positions[:, 1].min() > -0.001
    if name != "skirt":  # whose pleats are pressed together under its band
        coarse = surface_mesh(name, *unpacked(MESHES / f"{name}.npz"), *(n // 2 for n in SAMPLES[name]))
        assert crossings(coarse.positions, coarse.triangles) == 0
    # UVs are metres: the cloth is hardly stretched anywhere.
    rows, columns = SAMPLES[name]  # what is sewn to it comes behind
    cloth = mesh.triangles[: 2 * (rows - 1) * (columns - 1)]
    corners, uv = (np.asarray(a, float)[cloth] for a in (mesh.positions, mesh.uv))
    longer = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1) / np.linalg.norm(uv[:, 1] - uv[:, 0], axis=1)
    assert np.median(longer) == pytest.approx(1.0, abs=0.02) and np.percentile(longer, 98) < 1.1
    assert PIECES[name].size == pytest.approx(np.ptp(mesh.uv[: rows * columns], axis=0), abs=1e-5)


def test_the_skirt_hangs_about_the_form_and_has_a_band():
    mesh = load_mesh("skirt")
    assert names_of(mesh) == (("Skirt", "skirt"), ("Waistband", "skirt"))
    skirt = mesh.positions[np.unique(mesh.triangles[mesh.part_of == 0])]
    for center, axes in FORM:
        assert np.linalg.norm((skirt - center) / axes, axis=1).min() > 0.98, "the spline may cut in by a few mm"


def test_the_throw_lies_on_the_ball_and_outside_of_the_pedestal():
    p = load_mesh("throw").positions.astype(float)
    assert np.linalg.norm(p - HEAD[0], axis=1).min() > HEAD[1] - 0.004
    center, half, rounding = PEDESTAL
    outside = np.maximum(np.abs(p - center) - (np.array(half) - rounding), 0)
    assert np.linalg.norm(outside, axis=1).min() > rounding - 0.004


@pytest.mark.parametrize("name", [name for name in BUILTIN_SOLIDS if name != "stand"])
def test_supports_face_outward_and_have_colours(name):
    mesh, colors = load_solid(name)
    assert colors.shape == (len(mesh.triangles), 3) and (colors > 0.0).all() and (colors < 0.6).all()
    corners = mesh.positions[mesh.triangles].astype(float)
    if name == "backdrop":  # toward the cloth before it
        assert (mesh.normals @ (0.0, 0.3, 1.0) > 0.2).all()
    else:  # the volume that it encloses
        assert np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0 > 0.02
    if name == "form":
        torso = mesh.positions[mesh.positions[:, 1] > 0.72]
        inside = [np.linalg.norm((torso - center) / axes, axis=1) < 1.0 for center, axes in FORM]
        assert np.any(inside, axis=0).mean() > 0.9 and 0.0 < SHRUNK < 0.01, "it lies within what the cloth met"


def test_vertices_are_packed_to_hundredths_of_a_millimetre(tmp_path):
    positions = np.random.default_rng(0).normal(size=(7, 5, 3))
    (tmp_path / "a.npz").write_bytes(packed(positions, (1.5, 0.75)))
    found, size = unpacked(tmp_path / "a.npz")
    assert size == (1.5, 0.75) and np.abs(found - positions).max() < 0.6 * np.ptp(positions) / 65535


@pytest.mark.parametrize("name", sorted(set(builtin_scenes()) & set(SAMPLES)))
def test_the_scenes_of_the_pieces_have_good_defaults(name):
    scene = load_scene(name)
    assert (scene.mesh, scene.spp, scene.view_transform) == (name, 4, "neutral") and scene.ground != "off"
