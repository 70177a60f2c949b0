"""View transforms of an OpenColorIO config: its codes, which one serves, PNG files, and wrong names."""

import numpy as np
import PyOpenColorIO
import pytest
from PIL import Image

from glcloth.cli import main
from glcloth.color import srgb_decode, srgb_encode, view
from glcloth.errors import InputError
from glcloth.image import write_image
from glcloth.ocio import LUT_EDGE, LUT_STOPS, ocio_view
from glcloth.scene import Scene, load_scene, save_scene

PLAIN = """ocio_profile_version: 2
roles: {default: raw, scene_linear: lin_rec709}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays:
  Desk: [!<View> {name: Film, colorspace: curve}, !<View> {name: Half, colorspace: half}]
  Wall sRGB: [!<View> {name: Film, colorspace: curve}]
active_displays: [Desk, Wall sRGB]
colorspaces:
  - !<ColorSpace> {name: raw, isdata: true}
  - !<ColorSpace> {name: lin_rec709}
  - !<ColorSpace> {name: curve, from_scene_reference: !<ExponentTransform> {value: 2.0, direction: inverse}}
  - !<ColorSpace>
    name: half
    from_scene_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}
"""


@pytest.fixture
def config(tmp_path, monkeypatch):
    monkeypatch.delenv("OCIO", raising=False)
    path = tmp_path / "config.ocio"
    path.write_text(PLAIN)
    return str(path)


def test_codes_are_those_of_the_config(config):
    rgb = np.array([[[0.25, 0.04, 0.0], [0.81, 1.0, 9.0]]])
    np.testing.assert_allclose(view(rgb, ocio_view(config)), np.minimum(rgb, 1) ** 0.5, atol=1e-5)
    np.testing.assert_allclose(view(rgb, ocio_view(config, "Desk", "Half"), 1.0), np.minimum(rgb, 1), atol=1e-5)
    # A view without a tone curve of OpenColorIO's own config, whose linear space is another than ours.
    srgb = ocio_view("ocio://default", "sRGB - Display", "Un-tone-mapped")
    np.testing.assert_allclose(view(rgb, srgb), srgb_encode(rgb), atol=2e-4)


def test_the_table_of_the_window_is_close_to_the_codes(config):
    aces = ocio_view("ocio://default")
    lut = aces.lut
    assert lut.shape == (LUT_EDGE, LUT_EDGE, LUT_EDGE, 3)
    stops = np.linspace(*LUT_STOPS, LUT_EDGE)
    assert np.abs(lut[10, 20, 40] - aces(np.exp2(stops[[40, 20, 10]]))).max() < 1e-5


def test_which_one_serves(config, monkeypatch):
    assert Scene().transform == "standard" and Scene(view_transform="agx").transform == "agx"
    assert Scene(ocio=config, display="Wall sRGB").transform.srgb
    monkeypatch.setenv("OCIO", config)
    assert (Scene().transform.display, Scene().transform.view) == ("Desk", "Film")
    assert Scene(ocio_view="Half").transform.view == "Half"
    assert Scene(view_transform="agx").transform == "agx" and Scene(ocio="off").transform == "standard"


def test_a_config_of_the_library_survives_a_scene_file(tmp_path):
    save_scene(tmp_path / "a.toml", Scene(ocio="ocio://default"))
    assert load_scene(tmp_path / "a.toml").ocio == "ocio://default"


def test_pictures(config, tmp_path):
    rgb = np.full((2, 2, 3), 0.25, np.float32)
    for display in ("Desk", "Wall sRGB"):
        scene = Scene(ocio=config, display=display)
        write_image(tmp_path / "a.png", rgb, view_transform=scene.transform)
        with Image.open(tmp_path / "a.png") as picture:
            assert np.asarray(picture).tolist() == np.full((2, 2, 3), 128).tolist()
            assert ("srgb" in picture.info) == (display != "Desk"), "only codes of sRGB are said to be"
    assert srgb_decode(0.5) != 0.25


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--ocio", "nothing.ocio"], "ocio nothing.ocio: no such file"),
        (["--ocio", "bad.ocio"], "ocio bad.ocio: cannot be used"),
        (["--ocio", "config.ocio", "--display", "desk"], "did you mean Desk? it has Desk, Wall sRGB"),
        (["--ocio", "config.ocio", "--ocio-view", "Flim"], "did you mean Film? it has Film, Half"),
        (["--display", "Desk"], "name one by --ocio CONFIG or $OCIO"),
    ],
)
def test_wrong_names_are_one_line(words, said, config, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.ocio").write_text("ocio_profile_version: 99\n")
    with pytest.raises(SystemExit) as stop:
        main(["render", *words, "-o", "a.png"])
    lines = capsys.readouterr().err.strip().splitlines()
    assert stop.value.code == 2 and len(lines) == 1 and said in lines[0] and not (tmp_path / "a.png").exists()


def test_without_the_package(config, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "PyOpenColorIO", None)
    with pytest.raises(InputError, match=r"pip install 'glcloth\[ocio\]'"):
        ocio_view(config)
    monkeypatch.setenv("OCIO", config)
    assert Scene().transform == "standard" and PyOpenColorIO
