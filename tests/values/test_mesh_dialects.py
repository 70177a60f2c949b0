"""OBJ, MTL, PLY, STL and OFF as programs write them: each file holds the same sheet, or says in one line why not."""

import numpy as np
import pytest
from sheets import AREA, REFERENCE, UV, P, T, area, assert_is_the_sheet, facing, obj

from glcloth import progress
from glcloth.errors import InputError
from glcloth.geometry.mesh import Mesh, build_mesh
from glcloth.geometry.mesh_files import load_mesh, load_solid, read_mesh, save_mesh
from glcloth.geometry.polygons import triangulate
from glcloth.geometry.props import arrange, load_solids
from glcloth.light.environment import Environment

RNG = np.random.default_rng(12)
NORMALS = REFERENCE().normals.astype(float)
MIXED = np.where(RNG.random(len(T))[:, None] < 0.5, T[:, ::-1], T)
PANEL = np.where((np.arange(len(T)) < len(T) // 3)[:, None], T[:, ::-1], T)


def written(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


# -- OBJ -----------------------------------------------------------------------------------------------------------

LINES = obj().splitlines()
SHEETS = {
    "plain": obj(),
    "byte order marks, one of them in the middle": "\ufeff" + "\n".join([*LINES[:9], "\ufeff" + LINES[9], *LINES[10:]]),
    "Windows' ends of lines": obj().replace("\n", "\r\n"),
    "an old Macintosh's ends of lines": obj().replace("\n", "\r"),
    "continued lines": obj(corner="{0}/{0} \\\n").replace(" \\\n\n", "\n"),
    "continued lines of Windows": obj(corner="{0}/{0} \\\n").replace(" \\\n\n", "\n").replace("\n", "\r\n"),
    "UTF-16": obj(head="# größe\n").encode("utf-16"),
    "no end of the last line": obj().rstrip("\n"),
    "tabs and indents": "\n".join("\t " + line.replace(" ", "\t  ") for line in LINES),
    "comments behind numbers": "\n".join(line + " # 1 2 3" for line in LINES),
    "three texture coordinates": obj(uv="vt {:.6f} {:.6f} 0.0"),
    "a fourth coordinate": "\n".join(line + " 1.0" if line.startswith("v ") else line for line in LINES),
    "colours of vertices": "\n".join(line + " .5 .2 .1" if line.startswith("v ") else line for line in LINES),
    "relative indices": obj(faces=T - 26),
    "exponents": "\n".join(
        "v {:.9e} {:.9E} {:+.9e}".format(*map(float, line.split()[1:])) if line.startswith("v ") else line for line in LINES
    ),
    "v/vt and v/vt/vn in one file": obj(normals=NORMALS, faces=T[:9])
    + "".join("f " + " ".join(f"{i + 1}/{i + 1}/{i + 1}" for i in face) + "\n" for face in T[9:].tolist()),
    "v/vt and v/vt/vn in one face": obj(normals=NORMALS, faces=T[:-1])
    + "f {0}/{0} {1}/{1}/{1} {2}/{2}\n".format(*(T[-1] + 1).tolist()),
    "faces before vertices": "\n".join([*LINES[50:], *LINES[:50]]),
    "lines nobody knows": obj(head="mg 1 0.5\nvp 0.5\ncstype bezier\ncall a.obj 1\n") + "l 1 2 3\np 4\ns off\n",
    "inverted normals": obj(corner="{0}/{0}/{0}", normals=-NORMALS),
    "winding at random, normals right": obj(corner="{0}/{0}/{0}", normals=NORMALS, faces=MIXED),
    "winding at random, no normals": obj(faces=MIXED),
    "a panel the other way round": obj(faces=PANEL),
    "everything the other way round": obj(faces=T[:, ::-1]),
    "faces twice, front and back": obj(faces=np.vstack([T, T[:, ::-1]])),
    "faces ten times": obj(faces=np.tile(T, (10, 1))),
    "corners out of turn, twice": obj(faces=np.vstack([T, np.roll(T, 1, 1)])),
    "triangles without area": obj(faces=np.vstack([T, np.column_stack([T[:, 0], T[:, 0], T[:, 1]])])),
    "normals of zero": obj(corner="{0}/{0}/{0}", normals=0 * NORMALS),
    "normals that are no numbers": obj(corner="{0}/{0}/{0}", normals=np.nan * NORMALS),
}  # fmt: skip


@pytest.mark.parametrize("name", SHEETS)
def test_obj_dialects_hold_the_same_sheet(tmp_path, name, capfd):
    mesh = load_mesh(written(tmp_path, "sheet.obj", SHEETS[name]))
    assert_is_the_sheet(mesh)
    assert capfd.readouterr() == ("", "")


def test_sewn_panels_are_one_surface(tmp_path):
    """Panels with vertices of their own meet at a seam; one is wound the other way round."""
    left, right = T[P[T][..., 0].max(1) <= 0], T[P[T][..., 0].min(1) >= 0]
    assert len(left) + len(right) == len(T)
    mesh = build_mesh("sewn", np.vstack([P, P]), np.vstack([left, right[:, ::-1] + 25]), np.vstack([UV, UV]))
    assert_is_the_sheet(mesh)


@pytest.mark.parametrize("twist", [0, 1], ids=["a ring", "a Moebius strip"])
def test_winding_of_bands_agrees_as_far_as_it_can(twist):
    n = 40
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
    half = angle / 2 * twist
    radial = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    across = radial * np.sin(half)[:, None] + np.outer(np.cos(half), [0, 0, 1])
    positions = np.vstack([radial * 2 - 0.4 * across, radial * 2 + 0.4 * across])
    i, j = np.arange(n), (np.arange(n) + 1) % n
    low, high = np.where(j == 0, n * twist, 0) + j, np.where(j == 0, -n * twist, 0) + j + n
    triangles = np.vstack([np.column_stack([i, low, high]), np.column_stack([i, high, i + n])])
    flip = np.random.default_rng(3).random(2 * n) < 0.5
    mesh = build_mesh("band", positions, np.where(flip[:, None], triangles[:, ::-1], triangles))
    edges = np.concatenate([mesh.triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    twice = len(edges) - len(np.unique(edges, axis=0))
    assert twice == twist, "over one cut of the strip with one side, and nowhere else, neighbours disagree"


@pytest.mark.parametrize("offset", [(1e3, 0, -5e3), (0, 1e6, 0), (9e6, -9e6, 3e6)])
def test_far_meshes_keep_their_shape(tmp_path, offset, capsys):
    text = obj(places=P + np.array(offset))
    mesh = load_mesh(written(tmp_path, "far.obj", text))
    assert_is_the_sheet(mesh, tolerance=1e-4 if max(offset) > 1e6 else 2e-5)
    assert np.allclose(np.array(mesh.origin), offset, atol=1e-9)
    assert "far.obj: lies far from the origin" in capsys.readouterr().err
    # What stands in the same space stays beside it; what stands at the origin is far.
    solids = load_solids([str(written(tmp_path, "object.obj", text)), "sphere"])
    objects = arrange(solids, float(offset[1]) - 1, (0.3,) * 3, mesh)
    assert np.allclose(objects.meshes[0].bounds, mesh.bounds, atol=1e-4)
    assert np.allclose(objects.meshes[1].center, -np.array(offset), rtol=1e-6)
    assert objects.ground.height == pytest.approx(-1)


POLYGONS = {
    "L": ([(0, 0), (1, 0), (1, 0.3), (0.3, 0.3), (0.3, 1), (0, 1)], 0.51),
    "arrow (a quadrilateral)": ([(0, 0), (1, 1), (0, 2), (0.5, 1)], 0.5),
    "arrow, from its notch": ([(0.5, 1), (0, 0), (1, 1), (0, 2)], 0.5),
    "U": ([(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)], 7.0),
    "star": ([(np.cos(a) * r, np.sin(a) * r) for a, r in zip(np.arange(10) * np.pi / 5, [2, 0.7] * 5, strict=True)],
             5 * 2 * 0.7 * np.sin(np.pi / 5)),
    "hole by bridge edges": ([(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)], 12.0),
    "straight corners": ([(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)], 4.0),
    "spiral": ([(0, 0), (5, 0), (5, 5), (1, 5), (1, 2), (3, 2), (3, 3), (2, 3), (2, 4), (4, 4), (4, 1), (0, 1)], 15.0),
}  # fmt: skip


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("name", POLYGONS)
def test_simple_polygons_of_any_shape(name, axis, way):
    corners, expected = POLYGONS[name]
    flat = np.array(corners, float)[::way]
    positions = np.insert(flat, axis, 0.7, axis=1)
    cut, polygon = triangulate(positions, np.arange(len(flat)), np.array([len(flat)]))
    p = positions[cut]
    S = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) / 2
    assert np.linalg.norm(S.sum(0)) == pytest.approx(expected) and (polygon == 0).all()
    assert np.linalg.norm(S, axis=1).sum() == pytest.approx(expected), "all on one side, none over another"


def test_polygons_of_several_sizes_keep_their_order_and_owner():
    positions = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0.2, 0.2, 0], [0, 1, 0]], float)
    cut, polygon = triangulate(positions, np.array([0, 1, 2, 0, 1, 2, 3, 4, 0, 1, 2, 4]), np.array([3, 5, 4]))
    assert polygon.tolist() == [0, 1, 1, 1, 2, 2] and cut[0].tolist() == [0, 1, 2]
    assert ((cut[1:4] >= 3) & (cut[1:4] < 8)).all() and cut[4:].tolist() == [[8, 9, 10], [8, 10, 11]]


def test_parts_are_named_by_material_group_and_object(tmp_path):
    text = "o Dress\n" + obj(faces=T[:4]) + "g sleeve\nusemtl Red silk\n"
    text += "".join("f " + " ".join(f"{i + 1}/{i + 1}" for i in face) + "\n" for face in T[4:10].tolist())
    text += "usemtl Lining # of the collar\no Collar\ng\n" + obj(faces=T[10:]).split("f ", 1)[0]
    text += "".join("f " + " ".join(f"{i + 1}/{i + 1}" for i in face) + "\n" for face in T[10:].tolist())
    mesh = load_mesh(written(tmp_path, "parts.obj", text))
    assert mesh.parts == (("Dress",), ("Red silk", "sleeve", "Dress"), ("Lining", "Collar"))
    assert np.bincount(mesh.part_of).tolist() == [4, 6, len(T) - 10]
    # Triangles that are left out take their part with them.
    raw = read_mesh(written(tmp_path, "more.obj", text + "g a\nf 1/1 1/1 2/2\n"))
    assert len(raw.part_of) == len(T) + 1
    again = load_mesh(tmp_path / "more.obj")
    assert [again.parts[p] for p in again.part_of] == [mesh.parts[p] for p in mesh.part_of]


def test_errors_name_the_line_of_the_file(tmp_path):
    for text, place, word in (
        ("v 0 0 0 \\\r\n\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 9\r\n", ":5:", "out of range"),
        ("\ufeff# a\nv 0 0 0\nv 1 0 x\n", ":3:", "expected numbers"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n\n\nf 1 2/ 3/1/\n", ":6:", "vt index"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1/1 2 3\n", ":4:", "expected v, v/vt"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", ":4:", "out of range"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1.0 2 3\n", ":4:", "whole number"),
    ):
        with pytest.raises(InputError, match=word) as caught:
            load_mesh(written(tmp_path, "a.obj", text))
        assert f"a.obj{place}" in str(caught.value) if word != "vt index" else ":6:" in str(caught.value)


# -- MTL -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "head, files, color, said",
    [
        ("mtllib nowhere.mtl\nusemtl Wood\n", {}, 0.5, "nowhere.mtl"),
        ("mtllib a.mtl b.mtl\nusemtl Wood\n", {"a.mtl": "newmtl Wood\nKd .6 .3 .1", "b.mtl": "newmtl Iron\nKd 1 1 1"},
         (0.6, 0.3, 0.1), ""),
        ("mtllib my cloth.mtl\nusemtl Wood\n", {"my cloth.mtl": "newmtl Wood\r\nKd .6 .3 .1\r\n"}, (0.6, 0.3, 0.1), ""),
        ("mtllib A.MTL\nusemtl Wood\n", {"a.mtl": "newmtl Wood\nKd .6 .3 .1"}, (0.6, 0.3, 0.1), ""),
        ("mtllib .\\a.mtl\nusemtl Wood\n", {"a.mtl": "newmtl Wood\nKd .6 .3 .1"}, (0.6, 0.3, 0.1), ""),
        ("mtllib a.mtl\nusemtl Iron\n", {"a.mtl": "newmtl Iron\nKd 1.2 1 -1"}, (1, 1, 0), "clamped"),
        ("mtllib a.mtl\nusemtl Iron\n", {"a.mtl": "newmtl Iron\nKd 0.25"}, 0.25, ""),
        ("mtllib a.mtl\nusemtl Iron\n", {"a.mtl": "\tnewmtl Iron\n\tKd spectral file.rfl 1"}, 0.5, "no colour"),
        ("mtllib a.mtl\nusemtl Iron\n", {"a.mtl": "newmtl Iron\nKs 1 1 1"}, 0.7, ""),
        ("mtllib a.mtl\nusemtl Oak #2\n", {"a.mtl": "newmtl Oak #1\nKd 0 0 0\nnewmtl Oak #2\nKd 1 1 1"}, 1.0, ""),
        ("mtllib a.mtl\nusemtl Gone\n", {"a.mtl": "newmtl Iron\nKd 1 1 1"}, 0.5, "Gone"),
        ("mtllib a.mtl\nusemtl Wood\n", {"a.mtl": "newmtl Wood\nKd .1 .1 .1\nnewmtl Wood\nKd 1 1 1"}, 0.1, ""),
        ("mtllib ../a.mtl\nusemtl Wood\n", {"a.mtl": "newmtl Wood\nKd .6 .3 .1"}, 0.5, "../a.mtl"),
        ("mtllib \nusemtl Wood\n", {}, 0.5, ""),
    ],
)  # fmt: skip
def test_materials_of_objects(tmp_path, capsys, head, files, color, said):
    folder = tmp_path / "in"
    folder.mkdir()
    for name, text in files.items():
        written(tmp_path if "../" in head else folder, name, text)
    progress._warned.clear()
    _, reflectances = load_solid(written(folder, "o.obj", obj(head=head)))
    assert np.allclose(reflectances, color)
    errors = capsys.readouterr().err
    assert said in errors if said else not errors


# -- PLY -----------------------------------------------------------------------------------------------------------


def ply(kind="ascii", faces=T, vertex="", face="", data=None, strips=None):
    """A PLY file of the sheet: kind, more properties of vertices and faces and their values."""
    order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[kind]
    head = f"ply\nformat {kind} 1.0\ncomment TextureFile cloth.png\nobj_info x\nelement vertex 25\nproperty double x\n"
    head += f"property float y\nproperty float z\n{vertex}"
    name = "face" if strips is None else "tristrips"
    rows = [row.tolist() for row in faces] if strips is None else strips
    count = "uchar" if strips is None else "int"
    head += f"element {name} {len(rows)}\nproperty list {count} int vertex_indices\n{face}end_header\n"
    data = data or {}
    body = b""
    for i, p in enumerate(P.tolist()):
        row = [(v, k) for v, k in zip([*p, *data.get("vertex", [[]] * 25)[i]], "dff" + "f" * 9, strict=False)]
        body += _row(row, order)
    for i, f in enumerate(rows):
        row = [(len(f), "B" if strips is None else "i"), *((v, "i") for v in f), *data.get("face", [[]] * len(rows))[i]]
        body += _row(row, order)
    return head.encode() + body


def _row(row, order):
    import struct

    if not order:
        return (" ".join(f"{v:.9g}" for v, _ in row) + "\n").encode()
    return struct.pack(order + "".join(k for _, k in row), *(v for v, _ in row))


KINDS = ("ascii", "binary_little_endian", "binary_big_endian")
ST = "property float s\nproperty float t\n"
CORNER_UV = [[(6, "B"), *((v, "f") for v in UV[face].ravel())] for face in T.tolist()]


@pytest.mark.parametrize("kind", KINDS)
def test_ply_dialects_hold_the_same_sheet(tmp_path, kind, capfd):
    files = {
        "uv of vertices": ply(kind, vertex=ST, data={"vertex": UV.tolist()}),
        "uv of corners": ply(kind, face="property list uchar float texcoord\n", data={"face": CORNER_UV}),
        "a number after the list": ply(kind, vertex=ST, face="property uchar flags\n",
                                       data={"vertex": UV.tolist(), "face": [[(3, "B")]] * len(T)}),
    }  # fmt: skip
    for name, blob in files.items():
        assert_is_the_sheet(load_mesh(written(tmp_path, f"{name}.ply", blob)))
    mixed = [list(row) for row in T[2:].tolist()] + [[0, 1, 6, 5]]
    polygons = ply(kind, faces=[np.array(row) for row in mixed])
    assert len(load_mesh(written(tmp_path, "mixed.ply", polygons)).triangles) == len(T)
    strip = [v for j in range(4) for i in range(5) for v in (5 * (j + 1) + i, 5 * j + i)]
    strips = [[v for j in range(4) for v in [*strip[10 * j : 10 * j + 10], -1]]]
    mesh = load_mesh(written(tmp_path, "strips.ply", ply(kind, strips=strips)))
    assert len(mesh.triangles) == 32 and area(mesh) == pytest.approx(AREA, rel=2e-2) and facing(mesh) == 1
    out, err = capfd.readouterr()
    assert not out and "Traceback" not in err and len(err.splitlines()) == 2, "no UVs, twice"


def test_ply_with_concave_polygons_and_colours(tmp_path):
    corners, expected = POLYGONS["L"]
    text = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
    text += "property list uchar int vertex_index\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    text += "end_header\n" + "".join(f"{x} {y} 0\n" for x, y in corners) + "6 0 1 2 3 4 5 255 0 188\n2 0 1 9 9 9\n"
    mesh, colors = load_solid(written(tmp_path, "L.ply", text))
    assert area(mesh) == pytest.approx(expected) and np.allclose(colors, [1, 0, 0.5029], atol=1e-3)


# -- STL and OFF ---------------------------------------------------------------------------------------------------


def test_stl_and_off_hold_the_same_sheet(tmp_path):
    corners = P[T].astype("<f4")
    record = np.zeros(len(T), [("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")])
    record["c"] = corners
    binary = b"solid misleading".ljust(80) + np.uint32(len(T)).tobytes() + record.tobytes()
    facets = ["facet normal 0 0 0\nouter loop\n" + "".join("vertex {:.6e} {:.6e} {:.6e}\n".format(*p) for p in t)
              + "endloop\nendfacet\n" for t in corners.tolist()]  # fmt: skip
    text = "solid front\n" + "".join(facets[:7]) + "endsolid front\nsolid back\n" + "".join(facets[7:]) + "endsolid\n"
    vertices = "".join("{:.6f} {:.6f} {:.6f}\n".format(*p) for p in P.tolist())
    faces = "".join("3 {} {} {} 200 10 10\n".format(*t) for t in T.tolist())
    off = f"OFF # by hand\n\n25 {len(T)} 0\n{vertices}{faces}"
    textured = f"STOFF 25 {len(T)} 0\n" + "".join(
        "{:.6f} {:.6f} {:.6f} {:.4f} {:.4f}\n".format(*p, *t) for p, t in zip(P.tolist(), UV.tolist(), strict=True)
    )
    for name, blob in {"b.stl": binary, "t.stl": text, "T.stl": text.upper(), "a.off": off}.items():
        mesh = load_mesh(written(tmp_path, name, blob))
        assert_is_the_sheet(mesh, uv=False)
        assert len(mesh.positions) == 25, "corners at one place are one vertex"
    assert load_mesh(tmp_path / "t.stl").parts == (("front",), ("back",))
    assert_is_the_sheet(load_mesh(written(tmp_path, "st.off", textured + faces)))
    with pytest.raises(InputError, match="lines, too few"):
        load_mesh(written(tmp_path, "short.off", off.rstrip("\n").rsplit("\n", 1)[0] + "\n"))
    quads = f"OFF\n25 16 0\n{vertices}" + "".join(
        f"4 {a} {a + 1} {a + 6} {a + 5}\n" for a in range(24) if a % 5 < 4 and a < 20
    )
    assert len(load_mesh(written(tmp_path, "q.off", quads)).triangles) == 32


def test_damaged_files_end_in_one_line(tmp_path, capfd):
    good = {"a.ply": ply("binary_little_endian"), "b.ply": ply(), "c.off": b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
            "d.stl": b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
                     b"endfacet\nendsolid\n", "e.obj": obj().encode()}  # fmt: skip
    rng = np.random.default_rng(5)
    for name, blob in good.items():
        load_mesh(written(tmp_path, name, blob))
        for _ in range(120):
            spoiled = bytearray(blob)
            for _ in range(int(rng.integers(1, 4))):
                at = int(rng.integers(0, len(blob)))
                spoiled[at : at + int(rng.integers(0, 3))] = rng.integers(
                    0, 256, int(rng.integers(0, 4)), "u1"
                ).tobytes()
            try:
                load_mesh(written(tmp_path, name, bytes(spoiled)))
            except InputError as error:
                assert str(error).isprintable() and len(str(error)) <= 300
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.parametrize(
    "name, blob",
    [
        ("a.ply", b"ply\nformat binary_little_endian 1.0\nelement vertex 900000000\nproperty float x\nproperty float y\n"
                  b"property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"),
        ("b.ply", b"ply\nformat ascii 1.0\nelement vertex 4000000\nproperty float x\nproperty float y\nproperty float z\n"
                  b"element face 4000000\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n"),
        ("c.stl", bytes(80) + b"\xff\xff\xff\x7f" + bytes(50)),
        ("d.off", b"OFF\n900000000 900000000 0\n0 0 0\n"),
    ],
)  # fmt: skip
def test_counts_are_checked_before_anything_is_made(tmp_path, name, blob):
    import tracemalloc

    path = written(tmp_path, name, blob)
    tracemalloc.start()
    with pytest.raises(InputError):
        load_mesh(path)
    assert tracemalloc.get_traced_memory()[1] < 5e6
    tracemalloc.stop()


def test_a_pipe_does_not_hang(tmp_path):
    import os

    for name in ("a.obj", "a.mtl", "a.glb"):
        os.mkfifo(tmp_path / name)
    for name in ("a.obj", "a.glb"):
        with pytest.raises(InputError, match="no ordinary file"):
            load_mesh(tmp_path / name)
    assert np.allclose(load_solid(written(tmp_path, "b.obj", obj(head="mtllib a.mtl\nusemtl x\n")))[1], 0.5)


# -- arrays --------------------------------------------------------------------------------------------------------


def test_meshes_and_environments_from_arrays(capsys):
    assert_is_the_sheet(Mesh.from_arrays(P.tolist(), T.tolist(), UV))
    positions = P.astype("f4")
    mesh = Mesh.from_arrays(positions, T.astype("u1"))
    positions[:] = 0
    assert mesh.uv is None and np.allclose(mesh.positions, P, atol=1e-6)
    for arguments, word in (
        ((P[:, :2], T), r"positions of shape \(25, 2\), expected \[N, 3\]"),
        ((P, T.astype(float)), "triangles of float64, expected whole numbers"),
        ((P, T, UV[:9]), r"uv of shape \(9, 2\), expected \[25, 2\]"),
        ((P, T + 1), "vertex 25, out of range"),
        ((P * np.nan, T), "finite"),
        ((P * 0, T), "no area"),
        (([[0, 0, 0], [1, 0]], T), "positions"),
    ):
        with pytest.raises(InputError, match=word):
            Mesh.from_arrays(*arguments)
    light = np.ones((4, 8, 3))
    environment = Environment.from_array(light)
    light[:] = 7
    assert environment.radiance.dtype == np.float32 and np.allclose(environment.mean, 1)
    for array, word in ((np.ones((4, 8)), "shape"), (np.zeros((4, 8, 3)), "every sample is 0"), ([["a"]], "numbers")):
        with pytest.raises(InputError, match=word):
            Environment.from_array(array)


def test_saved_meshes_come_back_by_another_reader(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    save_mesh(tmp_path / "a.glb", REFERENCE())
    theirs = trimesh.load(tmp_path / "a.glb", force="mesh", process=False)
    assert np.allclose(theirs.vertices, P, atol=1e-6) and np.array_equal(theirs.faces, T)
    assert np.allclose(theirs.visual.uv, UV, atol=1e-6) and np.allclose(theirs.vertex_normals, NORMALS, atol=1e-5)
