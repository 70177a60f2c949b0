"""One scene, one door: the curtain by its name, as a Scene, by the command line and by the window's script."""

import contextlib

import numpy as np
import pytest

import glcloth
from glcloth import cli
from glcloth.curtain.show import CurtainShow
from glcloth.errors import InputError
from glcloth.geometry.camera import Camera
from glcloth.image import read_image
from glcloth.picture.options import with_options
from glcloth.picture.renderer import Renderer
from glcloth.scene import CurtainParameters, Scene, View, load_scene
from glcloth.window.sharing import as_command, as_python

SMALL = CurtainParameters(quads=(48, 12), pleats=4, settle=0.2)
SCENE = Scene(curtain=SMALL, size=(48, 40), frame=2, gi="off")


def run(*arguments):
    """One command that goes well."""
    with contextlib.suppress(SystemExit):
        cli.main(list(arguments))


def test_the_curtain_is_the_same_by_every_door(tmp_path):
    with glcloth.Renderer() as renderer:
        by_name = renderer.render("curtain", size=(64, 48), frame=2)
        assert renderer.facts()["triangles"] == 12_786 and by_name.shape == (48, 64, 3)
    with glcloth.Renderer() as renderer:
        by_scene = renderer.render(Scene(curtain=CurtainParameters(), size=(64, 48)), frame=2)
    np.testing.assert_array_equal(by_name, by_scene)
    output = str(tmp_path / "a.exr")
    run("render", "curtain", "--size", "64x48", "--frame", "2", "-o", output)
    np.testing.assert_array_equal(read_image(output), by_name)
    assert load_scene(output) == Scene(curtain=CurtainParameters(), size=(64, 48), frame=2)


def test_the_windows_script_and_command_render_the_curtain(tmp_path, monkeypatch, ctx):
    monkeypatch.chdir(tmp_path)
    with CurtainShow(ctx, SCENE) as show:
        show.advance(2)
        wanted = show.picture()
    code = as_python(SCENE, "script.exr", frame=2)
    assert [line for line in code.splitlines() if "import" in line] == ["import glcloth"]
    exec(compile(code, "copy", "exec"), {})
    np.testing.assert_array_equal(read_image("script.exr"), wanted)
    cloth, *_, command = as_command(SCENE, "command.exr", frame=2).splitlines()
    assert cloth.startswith("cat > scene.toml")
    (tmp_path / "scene.toml").write_text("\n".join(as_command(SCENE, frame=2).splitlines()[1:-2]))
    run(*command.split()[1:])
    np.testing.assert_array_equal(read_image("command.exr"), wanted)
    assert as_command(load_scene("curtain").changed(depth=2), frame=5) == (
        "glcloth render curtain -o picture.png --depth=2 --frame=5\n"
    )


def test_a_curtain_that_goes_on_is_the_one_that_is_hung_anew():
    """Changes that the cloth does not feel leave it hanging; every other one hangs it anew, with the same bits."""
    other = dict(fabric="lace", env="studio", camera=Camera((0.5, 1.4, 3.0), (0.0, 1.2, 0.0)), depth=2)
    scenes = [
        (SCENE, {}), (SCENE, {"frame": 4}), (SCENE, {"frame": 4, "accelerator": "lbvh", "size": (40, 40)}), (SCENE, other),
        (SCENE, {"curtain": SMALL.changed(wind=2.0)}), (SCENE, {"frame": 1}), (SCENE, {}),
    ]  # fmt: skip
    with Renderer() as renderer:
        pictures = [renderer.render(scene, **changes) for scene, changes in scenes]
        show = renderer.show(SCENE)
        assert renderer.show(SCENE, frame=3) is show and renderer.show(SCENE, frame=1) is not show
        cloth = renderer.render("drape", mesh="sphere", method="reference", cube=4, size=(16, 12))
        assert cloth.shape == (12, 16, 3) and renderer.facts()["covered_pixels"] > 10
    for (scene, changes), picture in zip(scenes, pictures, strict=True):
        with Renderer() as renderer:
            np.testing.assert_array_equal(renderer.render(scene, **changes), picture)


@pytest.mark.parametrize("changes", [{"mesh": "sphere"}, {"lights": "a.json"}, {"objects": ("stand",)}, {"depht": 3}])
def test_what_the_curtain_does_not_have(changes):
    with Renderer() as renderer, pytest.raises(InputError, match=next(iter(changes))):
        renderer.render("curtain", **changes)


def test_frames_of_the_curtain_keep_their_scene(tmp_path):
    with contextlib.chdir(tmp_path):
        glcloth.save_scene("scene.toml", SCENE.changed(camera=View(eye=(0.5, 1.4, 3.0))))
        run("animate", "scene.toml", "--frames", "3", "-o", "%d.exr")
        run("animate", "scene.toml", "--frames", "3", "--start", "2", "-o", "again%d.exr")
        run("render", "1.exr", "-o", "one.exr")
        np.testing.assert_array_equal(read_image("one.exr"), read_image("1.exr"))
        np.testing.assert_array_equal(read_image("again2.exr"), read_image("2.exr"))
        assert load_scene("1.exr").frame == 1


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"noise": 1.0}, "--noise: of method path"),
        ({"denoise": True, "method": "direct"}, "--denoise: of method path"),
        ({"photons": 5000, "curtain": CurtainParameters()}, "--photons: of gi photons"),
        ({"light": "map"}, "--light map: of methods reference and path"),
        ({"layer": "sky"}, "--layer: of an environment's file, and studio is built in"),
        ({"env_layout": "cross", "env": "sky"}, "--env-layout: of an environment's file, and sky is built in"),
        ({"behind_open": 1.0, "curtain": CurtainParameters()}, "--behind-open: of a second curtain"),
    ],
)
def test_options_that_nothing_reads_are_one_line(changes, said):
    changes = dict(changes)
    with pytest.raises(InputError, match=said):
        with_options(Scene(curtain=changes.pop("curtain", None)), changes)
    assert with_options(Scene(), {"noise": 1.0, "method": "path", "light": "map"}).noise == 1.0
    assert with_options(Scene(), {"layer": "sky", "env": "hall.exr"}).layer == "sky"
