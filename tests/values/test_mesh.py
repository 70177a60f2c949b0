"""Meshes: yarn frames against closed forms, what files may hold, and one-line errors for what they may not."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
import trimesh

from glcloth import progress
from glcloth.errors import InputError
from glcloth.geometry import mesh_files
from glcloth.geometry.camera import Camera
from glcloth.geometry.coincident import split_vertices
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.mesh_files import BUILTIN_MESHES, load_mesh, load_view, save_mesh
from glcloth.geometry.shapes import cylinder, sphere

SHARED = Path(os.environ.get("GLCLOTH_SHARED") or Path(__file__).resolve().parents[3] / "shared") / "assets" / "meshes"

QUAD = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
QUAD_TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def yarn_2(mesh):
    return mesh.tangents[:, 3:] * np.cross(mesh.normals, mesh.tangents[:, :3])


def assert_frames(mesh):
    """The invariants every mesh keeps: finite, unit, orthogonal, w = +-1."""
    x, w = mesh.tangents[:, :3], mesh.tangents[:, 3]
    assert np.isfinite(mesh.normals).all() and np.isfinite(mesh.tangents).all()
    assert np.allclose(np.linalg.norm(x, axis=1), 1, atol=2e-6)
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=2e-6)
    assert np.abs(np.sum(x * mesh.normals, axis=1)).max() < 2e-6
    assert set(np.unique(w)) <= {-1.0, 1.0}


def test_frame_is_the_gradient_of_the_uvs():
    # P(u, v) = origin + u a + v b, with a turned, stretched and sheared map: x must be a, yarn 2 the rest of b.
    rng = np.random.default_rng(1)
    for _ in range(50):
        a, b = rng.normal(size=(2, 3))
        uv = rng.uniform(size=(30, 2))
        triangles = np.array([[i, j, k] for i, j, k in rng.integers(0, 30, size=(60, 3)) if len({i, j, k}) == 3])
        d_1, d_2 = uv[triangles[:, 1]] - uv[triangles[:, 0]], uv[triangles[:, 2]] - uv[triangles[:, 0]]
        S = d_1[:, 0] * d_2[:, 1] - d_1[:, 1] * d_2[:, 0]
        triangles[S < 0] = triangles[S < 0][:, ::-1]
        # Triangles that overlap have no winding in common: the normals say which side is which.
        normals = np.tile(np.cross(a, b), (30, 1))
        mesh = build_mesh("affine", uv[:, :1] * a + uv[:, 1:] * b, triangles[np.abs(S) > 1e-3], uv, normals)
        used = np.unique(mesh.triangles)
        assert np.allclose(mesh.tangents[used, :3], a / np.linalg.norm(a), atol=1e-4)
        rest = b - a * (a @ b) / (a @ a)
        assert np.allclose(yarn_2(mesh)[used], rest / np.linalg.norm(rest), atol=1e-4)


@pytest.mark.parametrize("shape, along", [(sphere, "longitude"), (cylinder, "longitude")])
def test_round_shapes_have_their_closed_form_frames(shape, along):
    positions, triangles, uv, normals = shape()
    mesh = build_mesh(shape.__name__, positions, triangles, uv)
    assert_frames(mesh)
    inner = np.abs(positions[:, 1]) < 0.49 if shape is sphere else np.ones(len(positions), bool)
    assert np.degrees(np.arccos(np.clip(np.sum(mesh.normals * normals, axis=1)[inner], -1, 1))).max() < 1.0
    east = np.column_stack([normals[:, 2], np.zeros(len(normals)), -normals[:, 0]])[inner]
    east /= np.linalg.norm(east, axis=1, keepdims=True)
    assert np.degrees(np.arccos(np.clip(np.sum(mesh.tangents[inner, :3] * east, axis=1), -1, 1))).max() < 1.0
    assert (mesh.tangents[:, 3] == 1).all()


def test_seam_is_invisible_in_the_frames():
    # The two rims of the seam lie at the same places; normals and yarns must agree there as if there were no seam.
    positions, triangles, uv, _ = sphere(parallels=24, meridians=48)
    mesh = build_mesh("sphere", positions, triangles, uv)
    grid = mesh.normals.reshape(25, 49, 3)
    assert np.array_equal(grid[:, 0], grid[:, -1])
    tangent = mesh.tangents.reshape(25, 49, 4)[1:-1]
    # Each rim sees only its own half of the turning field: half a step of 7.5 degrees apart on either side.
    turn = np.degrees(np.arccos(np.clip(np.sum(tangent[:, 0, :3] * tangent[:, -1, :3], axis=1), -1, 1)))
    assert turn.max() < 7.5


def test_mirrored_half_gets_negative_handedness_and_its_own_vertices():
    # A strip of two quads; u runs outward from the middle on both sides, so the left one is mirrored.
    positions = np.array([[-1, 0, 0], [0, 0, 0], [1, 0, 0], [-1, 1, 0], [0, 1, 0], [1, 1, 0]], float)
    uv = np.column_stack([np.abs(positions[:, 0]), positions[:, 1]])
    triangles = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    mesh = build_mesh("mirrored", positions, triangles, uv)
    assert len(mesh.positions) == 8 and np.array_equal(mesh.positions[:6], positions)
    assert np.array_equal(mesh.positions[6:], positions[[1, 4]]) or np.array_equal(
        mesh.positions[6:], positions[[4, 1]]
    )
    w = mesh.tangents[:, 3][mesh.triangles]
    assert (w[:2] == -1).all() and (w[2:] == 1).all()
    x = mesh.tangents[:, :3][mesh.triangles]
    assert np.allclose(x[:2], [-1, 0, 0]) and np.allclose(x[2:], [1, 0, 0])
    assert np.allclose(yarn_2(mesh), [0, 1, 0])


def test_handedness_counts_against_the_normals_of_the_file():
    # Normals on the far side of the winding: the same UVs now run the other way round.
    mesh = build_mesh("flipped", QUAD, QUAD_TRIANGLES, QUAD[:, :2], np.tile([0.0, 0.0, -1.0], (4, 1)))
    assert (mesh.tangents[:, 3] == -1).all()
    assert np.allclose(yarn_2(mesh), [0, 1, 0])


def test_normals_do_not_depend_on_the_triangulation():
    # A cube corner: three faces, one of them cut in two. Angle weights give (1, 1, 1) / sqrt 3, area weights do not.
    e = np.eye(3)
    positions = np.array([[0, 0, 0], *e, [1, 1, 0], [0, 1, 1], [1, 0, 1]], float)
    triangles = np.array([[0, 2, 1], [1, 2, 4], [0, 3, 2], [3, 5, 2], [0, 1, 6], [0, 6, 3]])
    mesh = build_mesh("corner", positions, triangles, positions[:, :2])
    assert np.allclose(np.abs(mesh.normals[0]), 1 / np.sqrt(3), atol=1e-6)


def test_degenerate_triangles_poison_nothing():
    positions = np.vstack([QUAD, [[0.5, 0.5, 0], [2, 2, 0], [7, 7, 7]]])
    triangles = np.vstack([QUAD_TRIANGLES, [[0, 4, 2], [0, 0, 1], [5, 5, 5]]])
    uv = np.vstack([QUAD[:, :2], [[0.1, 0.9], [0, 0], [np.nan, 0]]])
    mesh = build_mesh("degenerate", positions, triangles, uv)
    assert_frames(mesh)
    assert np.allclose(mesh.normals[:4], [0, 0, 1]) and np.allclose(mesh.tangents[:4], [1, 0, 0, 1])
    assert mesh.triangles.tolist() == QUAD_TRIANGLES.tolist()
    assert mesh.bounds[1][0] == 1.0, "vertices of no triangle must not count"


def test_faces_without_uv_area_fall_back_alone():
    positions = np.vstack([QUAD, QUAD + np.array([3, 0, 0])])
    triangles = np.vstack([QUAD_TRIANGLES, QUAD_TRIANGLES + 4])
    uv = np.vstack([QUAD[:, [1, 0]] * [1, -1], np.full((4, 2), 0.5)])
    mesh = build_mesh("half", positions, triangles, uv)
    assert_frames(mesh)
    assert np.allclose(mesh.tangents[:4, :3], [0, 1, 0])
    assert np.allclose(mesh.tangents[4:, :3], [1, 0, 0])


@pytest.mark.parametrize("apart", [0, 4])
def test_front_and_back_faces_are_one_sheet(apart):
    triangles = np.vstack([QUAD_TRIANGLES, QUAD_TRIANGLES[:, ::-1] + apart])
    mesh = build_mesh("double", np.vstack([QUAD, QUAD]), triangles)
    assert mesh.triangles.tolist() == QUAD_TRIANGLES.tolist() and np.allclose(mesh.normals[:4], [0, 0, 1])


def test_fallback_frame_follows_a_world_axis(tmp_path, capsys):
    positions, triangles, _, normals = sphere(parallels=48, meridians=96)
    path = tmp_path / "bare.ply"
    save_mesh(path, build_mesh("bare", positions, triangles))
    progress._warned.clear()
    mesh = load_mesh(path)
    load_mesh(path)
    message = capsys.readouterr().err.strip().splitlines()
    assert len(message) == 1 and "bare.ply" in message[0] and "UV" in message[0]
    assert mesh.uv is None
    assert_frames(mesh)
    inside = np.abs(normals[:, 0]) < 0.99
    expected = np.array([1.0, 0, 0]) - normals * normals[:, :1]
    expected /= np.maximum(np.linalg.norm(expected, axis=1, keepdims=True), 1e-9)
    assert np.sum(mesh.tangents[:, :3] * expected, axis=1)[inside].min() > 0.999
    # A wall that faces X cannot use X: the next axis serves it.
    wall = build_mesh("wall", QUAD[:, [2, 0, 1]], QUAD_TRIANGLES)
    assert np.allclose(wall.normals, [1, 0, 0]) and np.allclose(wall.tangents[:, :3], [0, 0, 1])


def test_split_keeps_the_order():
    corner, source, first = split_vertices(np.array([2, 0, 2, 0, 2]), np.array([[1], [0], [2], [0], [1]]), 3)
    assert corner.tolist() == [2, 0, 3, 0, 2] and source.tolist() == [0, 1, 2, 2] and first.tolist() == [1, -1, 0, 2]


OBJ = """# a roof: one edge with a UV seam, a quad, relative indices, separate v/vt
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
f 1/1 2/2 3/3 4/4
v 2 0 -1
v 2 1 -1
vt 5 5
vt 5 6
vt 6 5
vt 6 6
f 2/5 -2/7 -1/8 3/-3
"""


def test_obj_with_separate_indices_splits_at_the_seam(tmp_path):
    path = tmp_path / "roof.obj"
    path.write_text(OBJ)
    mesh = load_mesh(path)
    assert mesh.triangles.shape == (4, 3) and len(mesh.positions) == 8
    assert np.array_equal(mesh.positions[:4], QUAD.astype("f4"))
    assert np.array_equal(mesh.uv[:4], [[0, 0], [1, 0], [1, 1], [0, 1]])
    # Vertices 1 and 2 lie on the seam: their twins are appended, with the other UVs and the same smooth normal.
    assert np.array_equal(mesh.positions[6:], mesh.positions[[1, 2]])
    assert np.array_equal(mesh.uv[6:], [[5, 5], [5, 6]])
    assert np.allclose(mesh.normals[6], mesh.normals[1])
    half = np.array([1, 0, 1 + np.sqrt(2)]) / np.linalg.norm([1, 0, 1 + np.sqrt(2)])
    assert np.allclose(mesh.normals[[1, 2, 6, 7]], half, atol=1e-6)


def test_the_files_own_normals_win(tmp_path):
    path = tmp_path / "hard.obj"
    path.write_text(OBJ.replace("vt 0 0\n", "vn 0 0 2\nvn 1 0 1\nvt 0 0\n", 1)
                    .replace("f 1/1 2/2 3/3 4/4", "f 1/1/1 2/2/1 3/3/1 4/4/1")
                    .replace("f 2/5 -2/7 -1/8 3/-3", "f 2/5/2 -2/7/2 -1/8/2 3/-3/2"))  # fmt: skip
    mesh = load_mesh(path)
    assert np.allclose(mesh.normals[:4], [0, 0, 1]) and np.allclose(mesh.normals[4:], np.array([1, 0, 1]) / np.sqrt(2))


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".glb"])
def test_round_trip(tmp_path, suffix):
    mesh = load_mesh("cylinder")
    path = tmp_path / f"mesh{suffix}"
    save_mesh(path, mesh)
    back = load_mesh(path)
    assert np.array_equal(back.positions, mesh.positions) and np.array_equal(back.triangles, mesh.triangles)
    assert np.allclose(back.normals, mesh.normals, atol=1e-6) and np.allclose(back.uv, mesh.uv, atol=2e-6)
    assert np.allclose(back.tangents, mesh.tangents, atol=1e-4)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name], "no temporary file may stay"


def test_scene_parts_are_joined_with_their_transforms(tmp_path):
    quad = trimesh.Trimesh(QUAD, QUAD_TRIANGLES, process=False, visual=trimesh.visual.TextureVisuals(uv=QUAD[:, :2]))
    scene = trimesh.Scene()
    shift, mirror = np.eye(4), np.diag([-1.0, 1, 1, 1])
    shift[:3, 3] = 5, 6, 7
    scene.add_geometry(quad, node_name="a", transform=shift)
    scene.add_geometry(quad, node_name="b", transform=mirror)
    path = tmp_path / "two.glb"
    path.write_bytes(scene.export(file_type="glb"))
    mesh = load_mesh(path)
    assert mesh.triangles.shape == (4, 3)
    low, high = mesh.bounds
    assert np.allclose(low, [-1, 0, 0]) and np.allclose(high, [6, 7, 7])
    assert np.allclose(mesh.normals, [0, 0, 1]), "a mirrored part must not be turned inside out"
    left = mesh.positions[:, 0] < 1
    assert np.allclose(mesh.tangents[left], [-1, 0, 0, -1]) and np.allclose(mesh.tangents[~left], [1, 0, 0, 1])


def _spoiled(tmp_path):
    save_mesh(tmp_path / "whole.ply", load_mesh("plane"))
    save_mesh(tmp_path / "whole.glb", load_mesh("plane"))
    return (tmp_path / "whole.ply").read_bytes(), (tmp_path / "whole.glb").read_bytes()


def test_bad_files_end_in_one_line(tmp_path):
    ply, glb = _spoiled(tmp_path)
    triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    cases = {
        "empty.obj": (b"", "empty"),
        "words.obj": (b"hello world\nthis is no mesh\n", "no vertices"),
        "points.obj": (triangle.encode(), "no faces"),
        "cut.obj": ((triangle + "f 1 2").encode(), "cut.obj:4"),
        "cutvertex.obj": (b"v 0 0 0\nv 1 0", "cutvertex.obj:2"),
        "range.obj": ((triangle + "f 1 2 4\n").encode(), "out of range"),
        "rangeuv.obj": ((triangle + "vt 0 0\nf 1/1 2/1 3/2\n").encode(), "vt index 2"),
        "zero.obj": ((triangle + "f 0 1 2\n").encode(), "out of range"),
        "relative.obj": ((triangle + "f -1 -2 -4\n").encode(), "out of range"),
        "nan.obj": ((triangle.replace("1 0 0", "nan 0 0") + "f 1 2 3\n").encode(), "finite"),
        "huge.obj": ((triangle.replace("1 0 0", "1e39 0 0") + "f 1 2 3\n").encode(), "finite"),
        "letters.obj": ((triangle + "f a b c\n").encode(), "whole number"),
        "badnumber.obj": (b"v 0 zero 0\n", "numbers"),
        "binary.obj": (bytes(range(256)) * 20, "no vertices"),
        "empty.ply": (b"\n", "empty"),
        "words.ply": (b"hello", "ply"),
        "cut.ply": (ply[: len(ply) // 2], "ply"),
        "header.ply": (ply[:80], "ply"),
        "points.ply": (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                       b"property float z\nend_header\n0 0 0\n", "no triangles"),
        "range.ply": (b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                      b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"
                      b"0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n", "out of range"),
        "cut.glb": (glb[: len(glb) // 2], "glb"),
        "words.glb": (b"glTF but not really", "glb"),
        "words.gltf": (b"{}", "gltf"),
        "bad.gltf": (b"{", "gltf"),
        "some.stl": (b"solid but cut off", "stl"),
        "picture.png": (b"\x89PNG", "suffix"),
    }  # fmt: skip
    for name, (blob, word) in cases.items():
        path = tmp_path / name
        path.write_bytes(blob)
        with pytest.raises(InputError) as caught:
            load_mesh(path)
        message = str(caught.value)
        assert word in message and name in message and "\n" not in message and len(message) < 400, (name, message)
    with pytest.raises(InputError, match="no such file"):
        load_mesh(tmp_path / "absent.obj")
    with pytest.raises(InputError, match="is a folder"):
        load_mesh(tmp_path)
    with pytest.raises(InputError, match="did you mean sphere"):
        load_mesh("spher")
    with pytest.raises(InputError, match="cannot save"):
        save_mesh(tmp_path / "mesh.xyz", load_mesh("plane"))


def test_arrays_are_read_only_and_shapes_are_checked():
    mesh = load_mesh("plane")
    with pytest.raises(ValueError, match="read-only"):
        mesh.positions[0] = 0
    with pytest.raises(InputError, match="finite"):
        build_mesh("nan", np.full((3, 3), np.nan), [[0, 1, 2]])
    with pytest.raises(InputError, match="out of range"):
        build_mesh("range", np.eye(3), [[0, 1, 3]])


@pytest.mark.parametrize("name", ["teapot.obj", "skirt_mh.obj"])
def test_public_meshes(name):
    if not (SHARED / name).is_file():
        pytest.skip("the shared meshes are not here")
    mesh = load_mesh(SHARED / name)
    assert_frames(mesh)
    # Winding and normals agree nearly everywhere on these closed, consistently wound surfaces.
    p = mesh.positions[mesh.triangles].astype(float)
    S = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    facing = np.sum(S[:, None] * mesh.normals[mesh.triangles], axis=2)
    assert (facing[np.linalg.norm(S, axis=1) > 0] > 0).mean() > 0.98
    if name.startswith("skirt"):
        assert mesh.uv is not None
        # dP/du by least squares over each vertex's own triangles is an independent way to the same direction.
        worst = []
        for vertex in np.random.default_rng(0).choice(len(mesh.positions), 60, replace=False):
            ring = np.unique(mesh.triangles[(mesh.triangles == vertex).any(axis=1)])
            d, e = mesh.uv[ring] - mesh.uv[vertex], mesh.positions[ring] - mesh.positions[vertex]
            gradient = np.linalg.lstsq(d.astype(float), e.astype(float), rcond=None)[0][0]
            gradient -= mesh.normals[vertex] * (gradient @ mesh.normals[vertex])
            worst.append(gradient @ mesh.tangents[vertex, :3] / np.linalg.norm(gradient))
        assert np.median(worst) > 0.99 and min(worst) > 0.8


def covered(mesh, camera, size=(64, 48)):
    """Share of the picture that the mesh's triangles cover, by point-in-triangle tests at the pixel centres."""
    low, high = mesh.bounds
    clip = np.column_stack([mesh.positions, np.ones(len(mesh.positions))]) @ (
        camera.clip_from_world(size, *camera.depth_range(low, high)).T
    )
    assert (clip[:, 3] > 0).all(), "the mesh must lie before the camera"
    corners = ((clip[:, :2] / clip[:, 3:] + 1) * np.array(size) / 2)[mesh.triangles]
    picture = np.zeros(size[::-1], bool)
    first = np.maximum(np.ceil(corners.min(axis=1) - 0.5), 0).astype(int)
    last = np.minimum(np.floor(corners.max(axis=1) - 0.5), np.array(size) - 1).astype(int)
    for (a, b, c), (x_0, y_0), (x_1, y_1) in zip(corners, first, last, strict=True):
        if x_1 >= x_0 and y_1 >= y_0:
            x, y = np.meshgrid(np.arange(x_0, x_1 + 1) + 0.5, np.arange(y_0, y_1 + 1) + 0.5)
            sides = [(q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]) for p, q in ((a, b), (b, c), (c, a))]
            inside = (np.min(sides, axis=0) >= 0) | (np.max(sides, axis=0) <= 0)
            picture[y_0 : y_1 + 1, x_0 : x_1 + 1] |= inside
    return picture.mean()


@pytest.mark.parametrize("name", BUILTIN_MESHES)
def test_builtin_meshes_fill_their_view(name):
    mesh = load_mesh(name)
    assert_frames(mesh)
    assert mesh.uv is not None and mesh.name == name
    assert 0.45 <= covered(mesh, Camera(**load_view(name))) <= 0.65


def test_drape_is_cloth_in_metres():
    """UVs are metres of a square of 1.6 m that neither stretches nor tears: its edges are as long as in the UVs."""
    mesh = load_mesh("drape")
    assert 20_000 <= len(mesh.triangles) <= 50_000
    assert (Path(mesh_files.MESHES) / "drape.ply").stat().st_size <= 1.5e6
    assert np.allclose(mesh.uv.min(axis=0), 0, atol=1e-6) and np.allclose(mesh.uv.max(axis=0), 1.6, atol=1e-6)
    edges = np.concatenate([mesh.triangles[:, [0, 1]], mesh.triangles[:, [1, 2]], mesh.triangles[:, [2, 0]]])
    d = np.abs(mesh.uv[edges[:, 1]] - mesh.uv[edges[:, 0]])
    along = (d.min(axis=1) < 1e-6) & (d.max(axis=1) > 0)
    length = np.linalg.norm(np.diff(mesh.positions[edges[along]], axis=1)[:, 0], axis=1)
    strain = length / d[along].max(axis=1) - 1
    # In a tight fold a chord, and the spline, are shorter than the cloth; longer they must hardly be.
    assert np.percentile(strain, 99.9) < 0.01 and strain.max() < 0.05
    assert np.median(np.abs(strain)) < 0.005 and np.percentile(np.abs(strain), 95) < 0.06
    assert (mesh.tangents[:, 3] == 1).all() and len(mesh.positions) == 150 * 150
