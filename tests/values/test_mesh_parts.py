"""Parts of meshes and their fabrics; units and places; paths of a scene file."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from glcloth.cli.options import scene_of
from glcloth.cli.scene_options import SceneOptions
from glcloth.errors import InputError
from glcloth.fabric import load_fabric
from glcloth.geometry.mesh_files import load_mesh
from glcloth.geometry.parts import chosen, grouped, joined, names_of
from glcloth.geometry.placing import guessed_unit, placed
from glcloth.geometry.props import load_solids
from glcloth.light.lights import Lights, SphericalGaussians
from glcloth.picture.cloths import Cloth, Dressing, load_meshes
from glcloth.picture.frame import Frames
from glcloth.place import Place, split_place
from glcloth.scene import Scene, load_scene, save_scene

LINEN, VOILE = load_fabric("linen"), load_fabric("voile")
OBJ = """
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 2 0 0
v 2 1 0
v 3 0 0
v 3 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
o Dress
g Front panel_a
usemtl Silk Shell
f 1/1 2/2 3/3 4/4
usemtl Lining
f 2/1 5/2 6/3 3/4
g Back
f 5/1 7/2 8/3 6/4
"""


@pytest.fixture
def dress(tmp_path):
    (tmp_path / "dress.obj").write_text(OBJ)
    return load_mesh(tmp_path / "dress.obj")


def test_parts_of_an_obj_have_the_names_of_material_groups_and_object(dress):
    assert names_of(dress) == (
        ("Silk Shell", "Front panel_a", "Dress", "dress"),
        ("Lining", "Front panel_a", "Dress", "dress"),
        ("Lining", "Back", "Dress", "dress"),
    )
    assert dress.part_of.tolist() == [0, 0, 1, 1, 2, 2]


def test_parts_of_a_glb_have_the_names_of_material_mesh_and_node(tmp_path):
    scene = trimesh.Scene()
    for name, x in (("Sleeve", 0.0), ("Cuff", 2.0)):
        material = trimesh.visual.material.PBRMaterial(name=f"{name} cloth")
        visual = trimesh.visual.TextureVisuals(uv=np.zeros((8, 2)), material=material)
        box = trimesh.creation.box()
        box.visual = visual
        box.apply_translation((x, 0, 0))
        scene.add_geometry(box, geom_name=f"{name}Mesh", node_name=f"{name}Node")
    (tmp_path / "a.glb").write_bytes(scene.export(file_type="glb"))
    mesh = load_mesh(tmp_path / "a.glb")
    found = {names[:3]: number for number, names in enumerate(names_of(mesh))}
    assert set(found) == {(f"{name} cloth", f"{name}Mesh", f"{name}Node") for name in ("Sleeve", "Cuff")}
    right = mesh.positions[mesh.triangles].mean(1)[:, 0] > 1.0
    assert np.array_equal(mesh.part_of == found["Cuff cloth", "CuffMesh", "CuffNode"], right)


def test_the_pattern_that_fits_best_holds_whatever_their_order(dress):
    assert chosen([dress], ["lining"]) == ((-1, 0, 0),)
    assert chosen([dress], ["LIN*", "back"]) == ((-1, 0, 1),), "a name before a pattern"
    assert chosen([dress], ["back", "lin*"]) == ((-1, 1, 0),)
    assert chosen([dress], ["*", "lin*", "l*"]) == ((0, 1, 1),), "the longer pattern"
    assert chosen([dress], ["Back", "Lining", "Dress"]) == ((2, 1, 1),), "the material before the group"
    assert chosen([dress, load_mesh("plane")], ["plane"]) == ((-1, -1, -1), (0,))
    with pytest.raises(InputError, match=r"no part is called Linning, expected Silk Shell, .*did you mean Lining\?$"):
        chosen([dress], ["Linning"])
    with pytest.raises(InputError, match=r"did you mean \*ilk\*\?$"):
        chosen([dress], ["ilk"])


def test_parts_are_taken_apart_and_joined_without_a_change(dress):
    plane = load_mesh("plane")
    pieces = grouped([dress, plane], [(0, 1, 0), (1,)])
    assert [number for number, _ in pieces] == [0, 1]
    first, second = (mesh for _, mesh in pieces)
    corners = dress.positions[dress.triangles]
    assert np.array_equal(first.positions[first.triangles], corners[dress.part_of != 1])
    assert len(first.positions) == 8, "vertices that no triangle uses are left behind"
    both = np.concatenate([corners[dress.part_of == 1], plane.positions[plane.triangles]])
    assert np.array_equal(second.positions[second.triangles], both)
    assert np.array_equal(second.uv[second.triangles][2:], plane.uv[plane.triangles])
    assert np.array_equal(second.tangents[second.triangles][2:], plane.tangents[plane.triangles])
    assert grouped([dress], [(4, 4, 4)]) == [(4, dress)], "a mesh alone stays the same object"
    assert joined([dress, replace(plane, uv=None)]).uv is None
    assert len(grouped([dress, replace(plane, uv=None)], [(0, 0, 0), (0,)])) == 2, "UVs are not invented"


def test_parts_of_one_fabric_are_one_cloth(dress):
    dressing = Dressing()
    assert [(c.mesh, c.fabric) for c in dressing.dress((dress,), LINEN, {})] == [(dress, LINEN)]
    again = load_fabric("linen")
    assert [(c.mesh, c.fabric) for c in dressing.dress((dress,), LINEN, {"Lining": again})] == [(dress, LINEN)]
    two = dressing.dress((dress,), LINEN, {"Lining": VOILE})
    assert [len(c.mesh.triangles) for c in two] == [2, 4] and two[1].fabric is VOILE
    edited = dressing.dress((dress,), LINEN, {"Lining": VOILE.changed(sigma_deg=30.0)})
    assert [c.mesh for c in edited] == [c.mesh for c in two], "an edit of a fabric leaves the meshes as they are"


# -- units and places ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("extent", "unit"),
    [(0.2, "m"), (6.0, "m"), (19.0, "m"), (45.0, "cm"), (180.0, "cm"), (390.0, "cm"), (700.0, "mm"), (2500.0, "mm"),
     (50_000.0, "m")],
)  # fmt: skip
def test_a_unit_is_guessed_where_metres_cannot_be(dress, extent, unit):
    assert guessed_unit([placed(dress, extent / 3.0, 0.0, (1e5, 0.0, 0.0))]) == unit, "where it lies does not count"


def test_files_are_read_in_their_unit(tmp_path, dress, capfd):
    (tmp_path / "big.obj").write_text(OBJ.replace("v 3", "v 170"))
    path = str(tmp_path / "big.obj")
    (mesh, plane), unit = load_meshes([path, "plane"])
    assert unit == "cm" and mesh.bounds[1][0] == pytest.approx(1.7) and plane.bounds[1][0] == pytest.approx(0.5)
    assert capfd.readouterr().err.count("its lengths are taken for cm") == 1
    for unit, metres in (("m", 170.0), ("dm", 17.0), ("mm", 0.17), ("in", 4.318)):
        assert load_meshes([path], unit)[0][0].bounds[1][0] == pytest.approx(metres)
    # Objects of OBJ files are in the cloth's unit; a glTF of two metres is two metres, one of 200 is in centimetres, too.
    for size, scale in ((2.0, 1.0), (200.0, 0.01)):
        trimesh.Scene([trimesh.creation.box((size, size, size))]).export(tmp_path / "box.glb")
        objects = load_solids([path, str(tmp_path / "box.glb"), "plane"], "cm")
        heights = [solid[0].bounds[1][1] for solid in objects]
        assert heights == pytest.approx([0.01, size / 2 * scale, 0.5])


def test_a_session_reads_objects_in_the_unit_of_the_present_cloth(tmp_path, dress):
    """Whatever cloth it had in between: one of metres, or the file's again, which is not read anew."""
    (tmp_path / "big.obj").write_text(OBJ.replace("v 3", "v 170"))
    path = str(tmp_path / "big.obj")
    frames, sizes = Frames(), []
    for given in ({"mesh": path}, {"mesh": dress}, {"mesh": path}, {"cloths": [Cloth(dress, load_fabric("linen"))]}):
        mesh = frames.make(**given, objects=(path,), lights=Lights(SphericalGaussians([], [], []))).objects.meshes[0]
        sizes.append(float(mesh.positions.max()))
    assert sizes == pytest.approx([1.7, 170.0, 1.7, 170.0])


def test_objects_stand_where_a_scene_says():
    mesh, still = (solid.mesh for solid in load_solids(["stand@1,2,3,0.5,30", "stand"]))
    # Counter-clockwise seen from +Y: +Z goes toward +X. By quaternions, so that a turn that mirrors is seen.
    turn = Rotation.from_rotvec([0.0, np.pi / 6.0, 0.0])
    assert np.allclose(mesh.positions, 0.5 * turn.apply(still.positions) + (1, 2, 3), atol=1e-6)
    assert np.allclose(mesh.normals, turn.apply(still.normals), atol=1e-6)
    assert np.allclose(mesh.tangents[:, :3], turn.apply(still.tangents[:, :3]), atol=1e-6)
    with pytest.raises(InputError, match="no file can have such a name"):
        load_solids(["x" * 300 + ".obj"])
    assert Place.of("1,2") == (1.0, 2.0, 0.0, 1.0, 0.0)
    assert split_place("a@b.obj") == ("a@b.obj", "") and split_place("a.obj@.5") == ("a.obj", ".5")
    for wrong in ("1,a", "1,2,3,0", "1,2,3,1,2,3", "nan,0,0"):
        with pytest.raises(InputError, match="expected @x,y,z,scale,turn"):
            Scene.parse({"objects": [f"stand@{wrong}"]})


# -- scenes --------------------------------------------------------------------------------------------------------------


def test_paths_of_a_scene_file_are_relative_to_it(tmp_path, monkeypatch):
    (tmp_path / "in").mkdir()
    for name in ("a.obj", "b.obj"):
        (tmp_path / "in" / name).write_text(OBJ)
    (tmp_path / "in" / "s.toml").write_text(
        'mesh = ["a.obj", "sphere"]\nobjects = ["b.obj@1,2", "stand"]\nenv = "/maps/x.hdr"\nlights = "l.json"\n'
        '[fabrics]\nLining = "mine.toml"\nBack = "voile"\n'
    )
    scene = load_scene(tmp_path / "in" / "s.toml")
    folder = str(tmp_path / "in")
    assert scene.meshes == (f"{folder}/a.obj", "sphere") and scene.objects == (f"{folder}/b.obj@1,2", "stand")
    assert scene.fabrics == {"Lining": f"{folder}/mine.toml", "Back": "voile"}
    assert (scene.env, scene.lights, scene.fabric) == ("/maps/x.hdr", f"{folder}/l.json", Scene().fabric)
    # Written to another folder, it names the same files; the folder moved with its files still holds them.
    for target in (tmp_path / "in" / "t.toml", tmp_path / "u.toml"):
        save_scene(target, scene)
        assert load_scene(target) == scene
    assert '"b.obj@1,2"' in (tmp_path / "in" / "t.toml").read_text()
    # A picture keeps the whole path.
    monkeypatch.chdir(tmp_path / "in")
    assert load_scene("s.toml").stored()["mesh"] == [f"{folder}/a.obj", "sphere"]
    assert load_scene("s.toml").stored()["objects"][0] == f"{folder}/b.obj@1,2"


def test_fabrics_of_a_scene_may_be_tables(tmp_path):
    scene = Scene(fabrics={"Lining": LINEN.changed(sigma_deg=30.0), "Back": "voile"})
    save_scene(tmp_path / "s.toml", scene)
    assert load_scene(tmp_path / "s.toml") == scene and hash(scene) != hash(Scene())
    with pytest.raises(InputError, match="fabrics: yarn"):
        Scene.parse({"fabrics": {"Lining": {"name": "x", "yarn": [{"etta": 1}]}}})


def test_options_name_fabrics_and_meshes(tmp_path, monkeypatch):
    base = Scene(fabrics={"A": "linen", "B": "velvet"})
    save_scene(tmp_path / "s.toml", base)
    options = SceneOptions(fabric=["silk_shot", "A=voile", "C=lace"], mesh=["drape", "sphere"])
    scene = scene_of(str(tmp_path / "s.toml"), options)
    assert scene.fabrics == {"B": "velvet", "A": "voile", "C": "lace"}
    assert (scene.fabric, scene.mesh) == ("silk_shot", ("drape", "sphere"))
    assert scene_of(None, SceneOptions(mesh=["plane"])).mesh == "plane"
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a=b.toml").write_text("")
    assert scene_of(None, SceneOptions(fabric=["a=b.toml"])).fabric == "a=b.toml"
    for wrong, said in ((["linen", "voile"], "for a part say PART=voile"), (["=voile"], "expected PART=FABRIC")):
        with pytest.raises(InputError, match=said):
            scene_of(None, SceneOptions(fabric=wrong))
