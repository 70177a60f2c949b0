"""Coarse meshes made smooth: Loop's surface, rims, corners, seams of UVs, parts."""

import numpy as np
import pytest
import trimesh

from glcloth.errors import InputError
from glcloth.geometry.mesh import Mesh
from glcloth.geometry.parts import joined
from glcloth.geometry.smoothed import smoothed


def test_it_is_loops_surface():
    ball = trimesh.creation.icosphere(1)
    made = smoothed(Mesh.from_arrays(ball.vertices, ball.faces), 2)
    expected, _ = trimesh.remesh.subdivide_loop(ball.vertices, ball.faces, 2)
    found = made.positions[np.lexsort(np.round(made.positions, 4).T)]
    np.testing.assert_allclose(found, expected[np.lexsort(np.round(expected.astype("f4"), 4).T)], atol=1e-6)
    outward = (made.normals * made.positions).sum(1) / np.linalg.norm(made.positions, axis=1)
    assert outward.min() > 0.995, "normals are the smooth surface's"


def test_a_sheet_keeps_its_corners_seams_and_parts():
    """Two squares side by side, each with UVs of its own; the square corners stay, the seam stays closed and flat."""
    x = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0]], float)
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]] * 2, float) + np.repeat([[0.0, 0.0], [5.0, 0.0]], 4, 0)
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    one = Mesh.from_arrays(x[:4], faces[:2], uv[:4], name="left")
    two = Mesh.from_arrays(x[4:], faces[:2], uv[4:], name="right")
    made = smoothed(joined([one, two]), 2)
    assert len(made.triangles) == 64 and [made.parts[k][-1] for k in (0, 1)] == ["left", "right"]
    assert np.bincount(made.part_of).tolist() == [32, 32]
    for corner in ((0, 0), (0, 1), (2, 0), (2, 1)):
        assert (np.abs(made.positions[:, :2] - corner).max(1) < 1e-7).any(), corner
    left = made.part_of[:, None] == 0
    assert made.uv[made.triangles][np.broadcast_to(left, (64, 3))].max() == 1.0, "UVs of the parts stay apart"
    seam = [made.positions[np.unique(made.triangles[made.part_of == k])] for k in (0, 1)]
    ends = [set(map(tuple, np.round(p[np.abs(p[:, 0] - 1.0) < 1e-6], 6))) for p in seam]
    assert ends[0] == ends[1] and len(ends[0]) == 5
    area = np.linalg.norm(
        np.cross(*(made.positions[made.triangles][:, k] - made.positions[made.triangles][:, 0] for k in (1, 2))), axis=1
    )
    assert 0.5 * area.sum() == pytest.approx(2.0, rel=1e-6)


def test_too_many_triangles_are_refused_and_a_scene_says_it(renderer):
    ball = trimesh.creation.icosphere(5)
    with pytest.raises(InputError, match=r"subdivide 4: mesh .* at most"):
        smoothed(Mesh.from_arrays(ball.vertices, ball.faces), 4)
    coarse = trimesh.creation.icosphere(0)
    mesh = Mesh.from_arrays(coarse.vertices, coarse.faces)
    frame = renderer.prepare(mesh=mesh, subdivide=3)
    assert len(frame.mesh.triangles) == 20 * 64 and renderer.prepare(mesh=mesh, subdivide=3).mesh is frame.mesh
    assert renderer.prepare(mesh=mesh).mesh is mesh
