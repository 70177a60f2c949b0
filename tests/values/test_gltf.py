"""glTF: accessors, nodes, skins, morph targets, modes and extensions; each file holds the same sheet, or says why not."""

import base64
import copy
import io
import json
import struct

import numpy as np
import pytest
from PIL import Image
from sheets import AREA, REFERENCE, UV, P, T, area, assert_is_the_sheet

from glcloth.errors import InputError
from glcloth.geometry.mesh_files import load_mesh, load_object, load_solid

KINDS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
DOWN = np.column_stack([UV[:, 0], 1 - UV[:, 1]])  # v as glTF has it


class Glb:
    """A glTF document under construction, and its one buffer."""

    def __init__(self):
        self.body = b""
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "meshes": [], "accessors": [], "bufferViews": []}  # fmt: skip

    def view(self, data, **more):
        self.body += bytes(-len(self.body) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.body), "byteLength": len(data), **more})
        self.body += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, rows, kind="f4", view=True, **more):
        rows = np.asarray(rows)
        rows = rows.reshape(len(rows), -1)
        table = {"componentType": KINDS[kind], "count": len(rows), "type": TYPES[rows.shape[1]], **more}
        if view:
            table["bufferView"] = self.view(np.ascontiguousarray(rows, "<" + kind).tobytes())
        self.json["accessors"].append(table)
        return len(self.json["accessors"]) - 1

    def sheet(self, corners=T, positions=P, uv=DOWN, **primitive):
        """A mesh that is the sheet."""
        attributes = {"POSITION": self.accessor(positions), "TEXCOORD_0": self.accessor(uv)}
        primitive.setdefault("indices", self.accessor(np.ravel(corners), "u2"))
        primitive["attributes"] = {**attributes, **primitive.pop("attributes", {})}
        self.json["meshes"].append({"primitives": [primitive]})
        return primitive

    def blob(self):
        document = {**self.json, "buffers": [{"byteLength": len(self.body)}]} if self.body else self.json
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        body = self.body + bytes(-len(self.body) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def plain(_):
    """As it comes."""


def no_material_two_byte_colors(glb):
    colors = glb.accessor(np.full((25, 4), 65535), "u2", normalized=True)
    glb.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = colors


def u8_indices(glb):
    glb.json["meshes"][0]["primitives"][0]["indices"] = glb.accessor(T.ravel(), "u1")


def no_indices(glb):
    p = glb.json["meshes"][0]["primitives"][0]
    p["attributes"] = {"POSITION": glb.accessor(P[T.ravel()]), "TEXCOORD_0": glb.accessor(DOWN[T.ravel()])}
    del p["indices"]


def interleaved(glb):
    rows = np.column_stack([P, np.zeros((25, 2)), DOWN]).astype("<f4")
    view = glb.view(rows.tobytes(), byteStride=28)
    glb.json["accessors"][0] |= {"bufferView": view}
    glb.json["accessors"][1] |= {"bufferView": view, "byteOffset": 20}


def normalised_shorts(glb):
    rows = np.column_stack([np.round(P * 32767), np.zeros(25)]).astype("<i2")
    view = glb.view(rows.tobytes(), byteStride=8)
    glb.json["accessors"][0] |= {"componentType": 5122, "normalized": True, "bufferView": view}
    glb.json |= {"extensionsRequired": ["KHR_mesh_quantization"]}


def shorts_under_a_scale(glb):
    rows = np.column_stack([np.round(P * 20000), np.zeros(25)]).astype("<i2")
    view = glb.view(rows.tobytes(), byteStride=8)
    glb.json["accessors"][0] |= {"componentType": 5122, "bufferView": view}
    glb.json["nodes"][0]["scale"] = [1 / 20000] * 3


def normalised_uv(glb):
    glb.json["accessors"][1] = glb.json["accessors"][glb.accessor(np.round(DOWN * 65535), "u2", normalized=True)]


def sparse_over_nothing(glb):
    places = glb.view(np.arange(25).astype("<u2").tobytes())
    values = glb.view(P.astype("<f4").tobytes())
    glb.json["accessors"][0] = {
        "componentType": 5126, "count": 25, "type": "VEC3",
        "sparse": {"count": 25, "indices": {"bufferView": places, "componentType": 5123}, "values": {"bufferView": values}},
    }  # fmt: skip


def sparse_over_others(glb):
    wrong = P.copy()
    wrong[[3, 9, 20]] = 7
    accessor = glb.json["accessors"][glb.accessor(wrong)]
    places = glb.view(np.array([3, 9, 20], "<u1").tobytes())
    values = glb.view(P[[3, 9, 20]].astype("<f4").tobytes())
    glb.json["accessors"][0] = accessor | {
        "sparse": {
            "count": 3,
            "indices": {"bufferView": places, "componentType": 5121},
            "values": {"bufferView": values},
        }
    }


def skinned(glb):
    """Two joints share the vertices and stand where the bind matrices undo it; the node's own transform says nothing."""
    move = np.eye(4)
    move[:3, 3] = 3, 1, 2
    bind = np.stack([np.linalg.inv(move).T, np.eye(4)])
    weights = np.column_stack([UV[:, 0], 1 - UV[:, 0], 0 * UV])
    glb.json["skins"] = [{"joints": [1, 2], "inverseBindMatrices": glb.accessor(bind.reshape(2, 16))}]
    glb.json["nodes"] = [{"mesh": 0, "skin": 0, "scale": [0.01] * 3, "translation": [50, 0, 0]},
                         {"translation": [3, 1, 2]}, {}]  # fmt: skip
    glb.json["scenes"][0]["nodes"] = [0, 1, 2]
    glb.json["meshes"][0]["primitives"][0]["attributes"] |= {
        "JOINTS_0": glb.accessor(np.tile([0, 1, 0, 0], (25, 1)), "u1"),
        "WEIGHTS_0": glb.accessor(np.round(weights * 255), "u1", normalized=True),
    }


def skinned_and_bent(glb):
    """Every vertex hangs from one of two joints, which carry the halves back to their places."""
    turn = {"rotation": [0, 0, np.sqrt(0.5), np.sqrt(0.5)], "translation": [1, 0, 0]}  # x to y, y to -x
    apart = P.copy()
    right = P[:, 0] > 0
    apart[right] = np.column_stack([P[right, 1], 1 - P[right, 0], P[right, 2]])
    glb.json["accessors"][0] = glb.json["accessors"][glb.accessor(apart)]
    glb.json["skins"] = [{"joints": [1, 2]}]
    glb.json["nodes"] = [{"mesh": 0, "skin": 0}, {}, turn]
    glb.json["scenes"][0]["nodes"] = [0, 1, 2]
    joints = np.column_stack([right, 0 * right, 0 * right, 0 * right]).astype(int)
    glb.json["meshes"][0]["primitives"][0]["attributes"] |= {
        "JOINTS_0": glb.accessor(joints, "u2"), "WEIGHTS_0": glb.accessor(np.tile([1, 0, 0, 0], (25, 1))),
    }  # fmt: skip


def morphed(glb):
    flat = P * [1, 1, 0]
    glb.json["accessors"][0] = glb.json["accessors"][glb.accessor(flat)]
    half = glb.accessor((P - flat) * 2)
    glb.json["meshes"][0] |= {"weights": [1.0, 0.5]}
    glb.json["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": glb.accessor(0 * P)}, {"POSITION": half}]


def morphed_by_the_node(glb):
    morphed(glb)
    glb.json["meshes"][0]["weights"] = [0, 0]
    glb.json["nodes"][0]["weights"] = [0, 0.5]


def under_matrices(glb):
    glb.json["accessors"][0] = glb.json["accessors"][glb.accessor(P[:, [1, 2, 0]] - [5, 0, 0])]
    cycle = [0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 5, 0, 1]  # columns: x to y, y to z, z to x
    glb.json["nodes"] = [{"children": [1]}, {"mesh": 0, "matrix": cycle}]


def mirrored(glb):
    glb.json["accessors"][0] = glb.json["accessors"][glb.accessor(P * [-1, 1, 1])]
    normals = REFERENCE().normals * [-1, 1, 1]
    glb.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = glb.accessor(normals)
    glb.json["nodes"] = [{"mesh": 0, "scale": [-1, 1, 1]}]


def stretched_with_normals(glb):
    """Normals turn by the inverse transpose."""
    scale = np.array([0.5, 4.0, 2.0])
    glb.json["accessors"][0] = glb.json["accessors"][glb.accessor(P / scale)]
    normals = REFERENCE().normals * scale
    glb.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = glb.accessor(normals)
    glb.json["nodes"] = [{"mesh": 0, "scale": scale.tolist()}]


def two_primitives_of_one_buffer(glb):
    first = glb.json["meshes"][0]["primitives"][0]
    first["indices"] = glb.accessor(T[:20].ravel(), "u4")
    glb.json["meshes"][0]["primitives"].append({**first, "indices": glb.accessor(T[20:].ravel(), "u4")})


def with_points_and_lines(glb):
    first = glb.json["meshes"][0]["primitives"][0]
    glb.json["meshes"][0]["primitives"] += [{**first, "mode": 0}, {**first, "mode": 1}, {**first, "mode": 3}]


def as_strips(glb):
    strip = [v for j in range(4) for v in _row_strip(j)]
    primitive = glb.json["meshes"][0]["primitives"][0]
    primitive |= {"indices": glb.accessor(strip, "u2"), "mode": 5}


def _row_strip(j):
    """Row j as a strip, the first and the last vertex twice, so that rows join by triangles without area."""
    row = [v for i in range(5) for v in (5 * j + i, 5 * (j + 1) + i)]
    return [row[0], *row, row[-1]]


def instanced(glb):
    extension = {"attributes": {"TRANSLATION": glb.accessor(np.array([[0.0, 0, 0]]))}}
    glb.json["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": extension}
    glb.json["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]


def compressed_with_a_copy(glb):
    """An extension that is used, not required: its data are there without it."""
    extension = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}}
    glb.json["meshes"][0]["primitives"][0]["extensions"] = extension
    glb.json["extensionsUsed"] = ["KHR_draco_mesh_compression"]


def not_the_first_scene(glb):
    glb.json |= {"scene": 1, "scenes": [{"nodes": []}, {"nodes": [1]}], "nodes": [{"mesh": 0}, {"mesh": 0}]}


SHEETS = (plain, no_material_two_byte_colors, u8_indices, no_indices, interleaved, normalised_shorts, shorts_under_a_scale,
          normalised_uv, sparse_over_nothing, sparse_over_others, skinned, skinned_and_bent, morphed, morphed_by_the_node,
          under_matrices, mirrored, stretched_with_normals, two_primitives_of_one_buffer, with_points_and_lines, as_strips,
          instanced, compressed_with_a_copy, not_the_first_scene)  # fmt: skip


@pytest.mark.parametrize("change", SHEETS, ids=lambda change: change.__name__)
def test_the_same_sheet(tmp_path, change, capfd):
    glb = Glb()
    glb.sheet()
    change(glb)
    (tmp_path / "sheet.glb").write_bytes(glb.blob())
    mesh = load_mesh(tmp_path / "sheet.glb")
    assert (mesh.normals[:, 2] > 0.5).all()
    if change is as_strips:  # other diagonals
        assert len(mesh.triangles) == 32 and area(mesh) == pytest.approx(AREA, rel=0.02)
    else:
        assert_is_the_sheet(mesh, tolerance=1e-4)
    assert capfd.readouterr() == ("", "")


def test_colors_of_vertices_are_the_reflectance(tmp_path):
    """White where the material says nothing else: COLOR_0 multiplies the base colour, whose default is 1."""
    glb = Glb()
    glb.sheet()
    glb.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = glb.accessor(
        np.tile(np.array([52428, 26214, 0, 65535]), (25, 1)), "u2", normalized=True
    )
    (tmp_path / "sheet.glb").write_bytes(glb.blob())
    assert np.allclose(load_solid(tmp_path / "sheet.glb")[1], (0.8, 0.4, 0.0), atol=1e-4)


def test_a_material_that_is_used_twice_is_one(tmp_path):
    glb = Glb()
    glb.sheet()
    glb.json["materials"] = [{"name": "m", "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.4, 0.6, 1]}}]
    primitive = glb.json["meshes"][0]["primitives"][0] | {"material": 0}
    glb.json["meshes"][0]["primitives"] = [primitive, primitive]
    (tmp_path / "sheet.glb").write_bytes(glb.blob())
    _, colors, materials, numbers = load_object(tmp_path / "sheet.glb")
    assert len(materials) == 1 and not numbers.any() and np.allclose(colors, (0.2, 0.4, 0.6))


def test_a_node_that_is_hidden_is_not_there(tmp_path):
    glb = Glb()
    glb.sheet()
    glb.json["nodes"].append(
        {"mesh": 0, "translation": [5, 0, 0], "extensions": {"KHR_node_visibility": {"visible": False}}}
    )
    glb.json["scenes"][0]["nodes"].append(len(glb.json["nodes"]) - 1)
    (tmp_path / "sheet.glb").write_bytes(glb.blob())
    assert_is_the_sheet(load_mesh(tmp_path / "sheet.glb"), tolerance=1e-4)


def test_a_fan(tmp_path):
    angle = np.linspace(0, 2 * np.pi, 13)
    glb = Glb()
    rim = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    glb.json["meshes"] = [
        {"primitives": [{"attributes": {"POSITION": glb.accessor(np.vstack([[0, 0, 0], rim]))}, "mode": 6}]}
    ]
    (tmp_path / "fan.glb").write_bytes(glb.blob())
    mesh = load_mesh(tmp_path / "fan.glb")
    assert len(mesh.triangles) == 12 and area(mesh) == pytest.approx(3.0) and np.allclose(mesh.normals, [0, 0, 1])


def test_instances_stand_in_their_places(tmp_path):
    glb = Glb()
    glb.sheet()
    attributes = {"TRANSLATION": glb.accessor(np.array([[0.0, 0, 0], [2, 0, 0], [4, 0, 0]])),
                  "SCALE": glb.accessor(np.array([[1.0, 1, 1], [1, 1, 1], [2, 2, 2]]))}  # fmt: skip
    glb.json["nodes"][0] |= {
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}},
        "translation": [0, 1, 0],
    }
    (tmp_path / "three.glb").write_bytes(glb.blob())
    mesh = load_mesh(tmp_path / "three.glb")
    assert area(mesh) == pytest.approx(6 * AREA, rel=1e-4) and np.allclose(mesh.bounds[1][:2], [5, 2])


@pytest.mark.parametrize("uri", ["my%20data.bin", "my data.bin", "sub/a.bin", "data:application/octet-stream;base64,"])
def test_buffers_beside_the_file(tmp_path, uri):
    glb = Glb()
    glb.sheet()
    if uri.startswith("data:"):
        uri += base64.b64encode(glb.body).decode()
    else:
        (tmp_path / "sub").mkdir()
        (tmp_path / uri.replace("%20", " ")).write_bytes(glb.body)
    document = {**glb.json, "buffers": [{"byteLength": len(glb.body), "uri": uri}]}
    (tmp_path / "a.gltf").write_text("\ufeff" + json.dumps(document), encoding="utf-8")
    assert_is_the_sheet(load_mesh(tmp_path / "a.gltf"))


def test_names_materials_and_pictures(tmp_path):
    picture = io.BytesIO()
    Image.new("RGB", (2, 2), (188, 0, 255)).save(picture, "PNG")
    glb = Glb()
    first = glb.sheet(corners=T[:10], material=0)
    second = {**first, "indices": glb.accessor(T[10:].ravel(), "u2"), "material": 1}
    glb.json["meshes"][0] |= {"name": "Gown", "primitives": [first, second]}
    glb.json["nodes"][0]["name"] = "Anna"
    glb.json["materials"] = [
        {"name": "Silk", "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.4, 0.8, 1], "roughnessFactor": 0.3}},
        {
            "name": "Print",
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 0.5, 1]},
        },
    ]
    glb.json["textures"], glb.json["images"] = [{"source": 0}], [{"bufferView": glb.view(picture.getvalue())}]
    (tmp_path / "a.glb").write_bytes(glb.blob())
    mesh, colors = load_solid(tmp_path / "a.glb")
    assert mesh.parts == (("Silk", "Gown", "Anna"), ("Print", "Gown", "Anna"))
    assert np.bincount(mesh.part_of).tolist() == [10, 22]
    assert np.allclose(colors[:10], [0.2, 0.4, 0.8]) and np.allclose(colors[10:], [0.5029, 0, 0.5], atol=1e-3)


def _wrong():
    """{name: (document changed, words of the error)}."""

    def change(words, *path, **values):
        def make():
            glb = Glb()
            glb.sheet()
            at = glb.json
            for key in path:
                at = at[key]
            at.update(values)
            return glb, words

        return make

    yield change("Draco.*without compression", extensionsRequired=["KHR_draco_mesh_compression"])
    yield change("meshopt.*without compression", extensionsRequired=["EXT_meshopt_compression"])
    yield change("X_unheard_of", extensionsRequired=["X_unheard_of"])
    yield change("beyond its buffer view", "accessors", 0, count=26)
    yield change("at most", "accessors", 0, count=10**9)
    yield change("beyond its buffer", "bufferViews", 0, byteLength=10**9)
    yield change("beyond", "accessors", 0, byteOffset=-4)
    yield change("is there no data|missing|damaged|cannot be read", "accessors", 0, componentType=5130)
    yield change("no list|cannot be read", nodes={"a": 1})
    yield change("hangs from two|hangs from itself", nodes=[{"mesh": 0, "children": [1]}, {"children": [0]}])
    yield change("two others|twice", nodes=[{"mesh": 0, "children": [2]}, {"children": [2]}, {}],
                 scenes=[{"nodes": [0, 1]}])  # fmt: skip
    yield change("scenes 4", scene=4)
    yield change("holds no triangles", scenes=[{"nodes": []}])
    yield change("out of range", "accessors", 0, count=20)
    yield change("TEXCOORD_0 has 20", "accessors", 1, count=20)
    yield change("glTF version 1.0", asset={"version": "1.0"})
    yield change("no glTF asset", asset=3)
    yield change("VEC2", "accessors", 0, type="VEC2")


@pytest.mark.parametrize("make", _wrong())
def test_wrong_documents_end_in_one_line(tmp_path, make):
    glb, words = make()
    (tmp_path / "a.glb").write_bytes(glb.blob())
    with pytest.raises(InputError, match=words) as caught:
        load_mesh(tmp_path / "a.glb")
    assert "a.glb" in str(caught.value) and str(caught.value).isprintable()


@pytest.mark.parametrize(
    "uri", ["../secret.bin", "/etc/hostname", "%2e%2e/secret.bin", "sub/../../secret.bin", "link.bin"]
)
def test_buffers_outside_the_folder_are_refused(tmp_path, uri):
    folder = tmp_path / "in"
    folder.mkdir()
    glb = Glb()
    glb.sheet()
    (tmp_path / "secret.bin").write_bytes(glb.body)
    (folder / "link.bin").symlink_to(tmp_path / "secret.bin")
    document = {**glb.json, "buffers": [{"byteLength": len(glb.body), "uri": uri}]}
    (folder / "a.gltf").write_text(json.dumps(document))
    with pytest.raises(InputError, match="not in its folder"):
        load_mesh(folder / "a.gltf")


def test_a_shared_mesh_cannot_be_multiplied_without_end(tmp_path):
    """A few kilobytes that mean a billion triangles, and a picture of gigabytes, are refused before they are made."""
    import tracemalloc

    glb = Glb()
    glb.sheet(corners=np.tile(T, (1000, 1)))
    glb.json["nodes"] = [{"mesh": 0} for _ in range(2_000)]
    glb.json["scenes"][0]["nodes"] = list(range(2_000))
    (tmp_path / "many.glb").write_bytes(glb.blob())
    picture = io.BytesIO()
    Image.new("1", (13_000, 13_000)).save(picture, "PNG")
    one = Glb()
    one.sheet(material=0)
    one.json["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    one.json["textures"], one.json["images"] = [{"source": 0}], [{"bufferView": one.view(picture.getvalue())}]
    (tmp_path / "bomb.glb").write_bytes(one.blob())
    tracemalloc.start()
    with pytest.raises(InputError, match=r"13000 x 13000 pixels"):
        load_solid(tmp_path / "bomb.glb")
    assert tracemalloc.get_traced_memory()[1] < 10e6
    with pytest.raises(InputError, match=r"triangles, at most 3,145,728"):
        load_mesh(tmp_path / "many.glb")
    assert tracemalloc.get_traced_memory()[1] < 40e6
    tracemalloc.stop()


def test_damaged_files_end_in_one_line(tmp_path, capfd):
    rng = np.random.default_rng(7)
    for number, change in enumerate((skinned, morphed, sparse_over_others, interleaved)):
        glb = Glb()
        glb.sheet()
        change(glb)
        blob = glb.blob()
        end = 20 + struct.unpack_from("<I", blob, 12)[0]
        for _ in range(60):
            spoiled = bytearray(blob)
            for _ in range(int(rng.integers(1, 3))):
                # Most of what can go wrong is in the JSON.
                at = int(rng.integers(0, end if rng.random() < 0.8 else len(blob)))
                spoiled[at] = int(rng.choice([*b'0123456789-{}[]",:e'])) if at >= 20 else int(rng.integers(0, 256))
            (tmp_path / "a.glb").write_bytes(spoiled)
            try:
                load_mesh(tmp_path / "a.glb")
            except InputError as error:
                assert str(error).isprintable() and len(str(error)) <= 300, number
    deep = Glb()
    deep.sheet()
    text = json.dumps(copy.deepcopy(deep.json))[:-1] + ', "extras": ' + "[" * 100_000 + "]" * 100_000 + "}"
    (tmp_path / "deep.gltf").write_text(text)
    with pytest.raises(InputError, match=r"nested too deeply|no data"):
        load_mesh(tmp_path / "deep.gltf")
    assert "Traceback" not in capfd.readouterr().err
