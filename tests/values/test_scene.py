"""Scenes: one value for cloth and curtain, its files and pictures, and what is made from its fields."""

import dataclasses
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from glcloth.cli import generate
from glcloth.cli.options import scene_of
from glcloth.cli.scene_options import SceneOptions
from glcloth.color import VIEW_TRANSFORMS
from glcloth.errors import InputError
from glcloth.fabric import Fabric, Transmission, Yarn, load_fabric
from glcloth.fields import entries
from glcloth.image import write_image
from glcloth.picture.frame import Frames
from glcloth.scene import (
    CurtainParameters,
    FabricMaskMap,
    OpacityMap,
    PrintMap,
    Scene,
    View,
    builtin_scenes,
    header,
    load_scene,
    save_scene,
)

CURTAIN = Scene(curtain=CurtainParameters(wind=2.0), depth=2, frame=7)


@pytest.mark.parametrize("path", generate.files(), ids=lambda path: path.name)
def test_what_is_made_from_the_fields_is_as_they_are(path):
    assert path.read_text(encoding="utf-8") == generate.files()[path], "run: python -m glcloth.cli.generate"


@pytest.mark.parametrize("model", [Scene, View, CurtainParameters, Fabric, Yarn, Transmission])
def test_every_field_says_what_it_is(model):
    for entry in entries(model):
        assert entry.help or entry.kind in ("table", "other"), entry.name
        assert not entry.help.endswith("."), "a phrase: sentences are made of it"


def test_options_are_fields():
    wanted = [entry.name for model in (Scene, View, CurtainParameters) for entry in entries(model) if entry.option]
    # Maps of the cloth are tables, whose file has the map's own option.
    for field, of_map in (("print", PrintMap), ("opacity", OpacityMap), ("fabric_mask", FabricMaskMap)):
        wanted += [f"{field}_{name}" for name in of_map.model_fields if name != "file"]
    assert [field.name for field in dataclasses.fields(SceneOptions)] == wanted
    assert tuple(VIEW_TRANSFORMS) == entries(Scene, ("view_transform",))[0].choices


@pytest.mark.parametrize("name", builtin_scenes())
def test_built_in_scenes_and_their_files(name, tmp_path):
    scene = load_scene(name)
    assert scene.kind == ("curtain" if name == "curtain" else "cloth")
    others = [scene.changed(exposure=1.0, fabric=load_fabric("lace"), camera=View(eye=(1, 2, 3)))]
    if scene.kind == "cloth":
        roses = {"file": str(tmp_path / "roses.png"), "repeat": 0.3, "unit": "m"}
        others += [scene.changed(print=roses, opacities={"Skirt": roses}), scene.changed(opacity=roses)]
    for value in (scene, *others):
        save_scene(tmp_path / "scene.toml", value)
        assert load_scene(tmp_path / "scene.toml") == value
        write_image(tmp_path / "picture.exr", np.ones((2, 2, 3)), header(value))
        assert load_scene(tmp_path / "picture.exr") == value
        assert Scene.model_validate(value.differences()) == value


def test_a_curtain_begins_with_its_own():
    assert load_scene("curtain") == Scene(curtain=CurtainParameters()) == Scene.parse({"curtain": {}})
    assert (CURTAIN.fabric, CURTAIN.env, CURTAIN.size, CURTAIN.method) == ("sheer_voile", "sky", (640, 640), "trace")
    assert CURTAIN.changed(env="studio").changed(depth=3).env == "studio"
    assert "mesh" not in CURTAIN.model_dump() and "depth" not in Scene().model_dump()


def test_who_says_how_bright_even_light_is_wants_it(tmp_path):
    scene = Scene(curtain={})
    assert scene.gi == "radiosity" and scene.changed(ambient=(1, 1, 1)).gi == "off"
    both = scene.changed(gi="radiosity", ambient=(1, 1, 1))
    save_scene(tmp_path / "both.toml", both)
    assert both.gi == load_scene(tmp_path / "both.toml").gi == Scene.parse(both.differences()).gi == "radiosity"
    # Scenes of cloth have no such light.
    assert not {"gi", "ambient"} & Scene().model_dump().keys()


def test_a_file_holds_a_frame_only_where_the_scene_says_one(tmp_path):
    for scene, said in ((load_scene("curtain"), False), (CURTAIN, True)):
        save_scene(tmp_path / "a.toml", scene)
        assert ("frame" in load_scene(tmp_path / "a.toml").model_fields_set) == said


def test_pictures_of_before_render_as_they_did(tmp_path):
    """Headers as glcloth wrote them when the curtain was a scene of another kind."""
    old = {name: value for name, value in CURTAIN.model_dump(mode="json").items() if name not in ("frame", "method")}
    write_image(tmp_path / "old.png", np.ones((2, 2, 3)), {"glcloth": "0.1.0", "curtain": old, "frame": 7})
    assert load_scene(tmp_path / "old.png") == CURTAIN
    cloth = {name: value for name, value in Scene(fabric="linen").model_dump(mode="json").items() if name != "curtain"}
    write_image(tmp_path / "old.exr", np.ones((2, 2, 3)), {"glcloth": "0.1.0", "scene": cloth})
    assert load_scene(tmp_path / "old.exr") == Scene(fabric="linen")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ({"depth": 2}, "scene: depth: belongs to the curtain; give its scene: glcloth render curtain"),
        ({"curtain": {}, "mesh": "sphere"}, "scene: mesh: belongs to cloth under an environment"),
        ({"curtain": {}, "method": "paper"}, "expected trace"),
        ({"method": "trace"}, "glcloth render curtain"),
        ({"curtain": {"windd": 1}}, "scene: curtain: windd: unknown key; did you mean wind?"),
        ({"curtain": {"pleats": 40}}, "scene: curtain: pleats = 40 on 158 quads"),
        ({"curtain": {"wind": float("nan")}}, "scene: curtain: wind = nan"),
        ({"camera": {"fov_deg": 200}}, "scene: camera: fov_deg = 200: input should be less than or equal to 170"),
        ({"qualty": "high"}, "scene: qualty: unknown key; did you mean quality?"),
        ({"quality": "best"}, "scene: quality = 'best': expected draft, normal or high"),
        ({"lobes": 1.5}, "scene: lobes = 1.5: input should be a valid integer"),
        ({"env_rotate": float("inf")}, "scene: env_rotate = inf"),
        ({"spp": 300}, "spp = 300: expected at most 256"),
        (
            {"fabric": {"name": "x", "yarn": [{"etta": 1}]}},
            "scene: fabric: yarn 1: etta: unknown key; did you mean eta?",
        ),
    ],
)
def test_errors_say_where_and_what(data, said):
    with pytest.raises(InputError) as error:
        Scene.parse(data)
    assert said in str(error.value) and "\n" not in str(error.value)


def test_a_change_leaves_the_rest_the_same_object():
    fabric = load_fabric("linen").changed(sigma_deg=30.0)
    assert Scene(fabric=fabric).changed(exposure=1.0).fabric is fabric
    with pytest.raises(InputError, match="scene: exposure = 99"):
        Scene().changed(exposure=99)


def test_a_curtain_as_it_is_ordered():
    """Pleats and grid follow from width, drop and heading, anew with each change, until they are said."""
    narrow = CurtainParameters(width=1.4, drop=1.15)
    assert (narrow.pleats, narrow.quads) == (7, (85, 20))
    assert narrow.changed(heading="pencil").pleats == 14 and narrow.changed(pleats=9).changed(width=2.5).pleats == 9
    assert narrow.changed(width=2.5, drop=2.3) == CurtainParameters()
    assert CurtainParameters(quads=(72, 18), pleats=6, width=1.0).quads == (72, 18)
    assert CurtainParameters.parse(narrow.model_dump()) == narrow
    for change, said in (
        ({"drop": 2.5}, "at most 2.4"), ({"color": "reddish"}, "a colour's name"), ({"color": (0.1, 0.2, 1.5)}, "color"),
        ({"heading": "hooks"}, "eyelet"), ({"heading": []}, "heading"), ({"width": "wide"}, "width"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=said) as caught:
            CurtainParameters.parse(change)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("said", "is_"),
    [
        ("0.5,0.25,0", (0.5, 0.25, 0.0)),
        ("#ff8000", (1.0, 0.2159, 0.0)),
        ("white", (1.0, 1.0, 1.0)),
        ("#f00", (1, 0, 0)),
    ],
)
def test_colours_of_curtains(said, is_):
    scene = scene_of("curtain", SceneOptions(color=said, width=1.8, heading="eyelet"))
    assert scene.curtain.color == pytest.approx(is_, abs=1e-4) and scene.curtain.pleats == 11
    assert Scene.parse(scene.model_dump()) == scene


def test_paths_are_names():
    """Wherever a name may stand, in lists and tables too."""
    one = Path("here") / "a.png"
    scene = Scene(
        mesh=[one, "sphere"], fabrics={"#ff0000": one}, objects=one, print=one, fabric_mask={"file": one}, env=one
    )
    assert scene.mesh == ("here/a.png", "sphere") and scene.fabrics == {"#ff0000": "here/a.png"}
    assert scene.objects == (scene.env,) == ("here/a.png",)
    assert scene.print.file == scene.fabric_mask.file == "here/a.png"
    assert scene.changed(curtain=None, opacities={"Hem": one}).opacities["Hem"].file == "here/a.png"
    assert Scene(curtain={"behind": one}, room=one).files() >= {"here/a.png"}
    with pytest.raises(InputError, match=r"here/a\.obj: no such file"):
        Frames().make(mesh=Path("here/a.obj"))


class Printer:
    """What a notebook's printer has, on one level."""

    def __init__(self):
        self.out = ""

    @contextmanager
    def group(self, _, first, last):
        self.out += first
        yield
        self.out += last

    def text(self, text):
        self.out += text

    def breakable(self):
        self.out += "\n"

    def pretty(self, value):
        self.out += repr(value)


def test_a_notebook_shows_what_was_said_of_a_value_on_lines_of_its_own():
    printer = Printer()
    scene = Scene(mesh="sphere", spp=4)
    scene._repr_pretty_(printer, False)
    assert printer.out == "Scene(mesh='sphere',\nspp=4)" and eval(printer.out) == scene
    printer = Printer()
    load_fabric("linen")._repr_pretty_(printer, False)
    assert printer.out.startswith("Fabric(name='Linen plain',\nnormalization=")
