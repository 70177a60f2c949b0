"""The command line as a user meets it: right input makes files, wrong input one line and exit code 2."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from glcloth import cli
from glcloth.errors import InputError
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.mesh_files import load_mesh, save_mesh
from glcloth.image import read_image, read_settings, write_image
from glcloth.picture.layers import Layers
from glcloth.picture.renderer import Renderer
from glcloth.picture.sequence_files import pose_files
from glcloth.progress import track, warn

ROOT = Path(__file__).resolve().parents[2]
# Two directions per edge keep the reference quick; what is tested here is the door, not the light.
QUICK = ["--mesh", "sphere", "--method", "reference", "--cube", "4", "--size", "32x24", "--lobes", "2"]


def quick_but(*options):
    """QUICK without the options that are given anew; an option may be given once."""
    pairs = zip(QUICK[::2], QUICK[1::2], strict=True)
    return [word for pair in pairs if pair[0] not in options for word in pair] + [str(o) for o in options]


def run(*arguments):
    """Exit code of one command in this process."""
    try:
        cli.main([str(a) for a in arguments])
    except SystemExit as stop:
        return stop.code
    return 0


def fails(capsys, *arguments):
    """The one line that a wrong command prints; asserts that it is one line, exit code 2 and nothing on stdout."""
    capsys.readouterr()
    code = run(*arguments)
    out, err = capsys.readouterr()
    lines = [line for line in err.strip().splitlines() if not line.startswith("glcloth: warning")]
    assert code == 2, (code, err)
    assert len(lines) == 1 and lines[0].startswith("glcloth: "), err
    assert "Traceback" not in err and out == ""
    return lines[0]


def test_render_writes_png_and_exr_with_their_scene(tmp_path, capsys):
    for name in ("a.png", "a.exr"):
        assert run("render", "-o", tmp_path / name, *QUICK, "--json") == 0
        out, _ = capsys.readouterr()
        result = json.loads(out)
        assert out.count("\n") == 1 and result["width"] == 32 and result["covered_pixels"] > 100
        assert read_image(tmp_path / name).shape == (24, 32, 3)
        assert read_settings(tmp_path / name)["scene"]["mesh"] == "sphere"


def test_ground_and_objects_travel_with_the_picture(tmp_path, capsys):
    (tmp_path / "box.obj").write_text("v 0.6 0 0\nv 0.9 0 0\nv 0.6 0.5 0\nf 1 2 3\n")
    options = quick_but("--shadows", "off", "--object", tmp_path / "box.obj", "--ground-color", "0.2,0.3,0.4")
    assert run("render", "-o", tmp_path / "a.exr", *options, "--object", "plane", "--ground") == 0
    scene = read_settings(tmp_path / "a.exr")["scene"]
    assert scene["ground"] == "auto" and scene["ground_color"] == [0.2, 0.3, 0.4]
    assert scene["objects"] == [str((tmp_path / "box.obj").resolve()), "plane"]
    assert run("render", tmp_path / "a.exr", "-o", tmp_path / "b.exr") == 0
    assert np.array_equal(read_image(tmp_path / "a.exr"), read_image(tmp_path / "b.exr"))
    out = ["render", "-o", tmp_path / "c.exr"]
    assert "--ground" not in fails(capsys, *out, "--object", "nothing.obj")
    assert "sphere" in fails(capsys, *out, "--object", "spere")
    assert "height" in fails(capsys, *out, "--ground", "1m")
    assert "R,G,B" in fails(capsys, *out, "--ground-color", "1,2")
    # What only tells the colours may be missing.
    (tmp_path / "d.obj").write_text("mtllib d.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert run("render", "-o", tmp_path / "d.exr", *QUICK, "--object", tmp_path / "d.obj") == 0
    assert "d.mtl" in capsys.readouterr().err


def test_a_picture_renders_again_to_the_same_picture(tmp_path):
    assert run("render", "-o", tmp_path / "a.exr", *QUICK, "--fabric", "linen", "--env-rotate", "-40") == 0
    assert run("render", tmp_path / "a.exr", "-o", tmp_path / "b.exr") == 0
    assert np.array_equal(read_image(tmp_path / "a.exr"), read_image(tmp_path / "b.exr"))


def test_no_background_leaves_alpha(tmp_path):
    assert run("render", "-o", tmp_path / "a.exr", *QUICK, "--no-background") == 0
    picture = read_image(tmp_path / "a.exr")
    assert picture.shape == (24, 32, 4) and set(np.unique(picture[..., 3])) == {0.0, 1.0}
    assert not picture[picture[..., 3] == 0].any()


def test_samples_per_pixel_give_fractional_coverage(tmp_path):
    assert run("render", "-o", tmp_path / "a.exr", *QUICK, "--no-background", "--spp", "4") == 0
    alpha = read_image(tmp_path / "a.exr")[..., 3]
    assert alpha.max() == 1.0 and ((alpha > 0) & (alpha < 1)).any()


def test_diff_measures_and_draws(tmp_path, capsys):
    a, b = np.full((8, 8, 3), 0.75, "f4"), np.full((8, 8, 3), 0.25, "f4")
    write_image(tmp_path / "a.exr", a)
    write_image(tmp_path / "b.exr", b)
    assert run("diff", tmp_path / "a.exr", tmp_path / "b.exr", "--json", "-o", tmp_path / "d.exr", "--scale", "4") == 0
    result = json.loads(capsys.readouterr().out)
    assert result["rmse"] == pytest.approx(0.5) and result["relmse"] == pytest.approx(0.5**2 / (0.25**2 + 0.01))
    assert result["psnr"] == pytest.approx(20 * np.log10(0.25 / 0.5), abs=1e-6) and 0 < result["flip"] <= 1
    assert np.allclose(read_image(tmp_path / "d.exr"), 2.0)


def test_diff_counts_pixels_of_a_mask_and_knows_a_limit(tmp_path, capsys):
    a, mask = np.zeros((8, 8, 3), "f4"), np.zeros((8, 8), "f4")
    a[:4], mask[:4] = 0.5, 1.0
    files = [write_image(tmp_path / "a.exr", a), write_image(tmp_path / "b.exr", np.zeros_like(a))]
    layers = Layers()
    layers["mask"] = mask
    layered = write_image(tmp_path / "m.exr", np.full_like(a, 0.9), layers=layers)
    alpha = write_image(tmp_path / "m.png", np.dstack([a, mask]))
    assert run("diff", *files, "--json") == 0
    whole, flips = json.loads(capsys.readouterr().out)["flip"], []
    for counts in (layered, alpha):
        assert run("diff", *files, "--mask", counts, "--json") == 0
        result = json.loads(capsys.readouterr().out)
        assert result["rmse"] == pytest.approx(0.5) and result["flip"] > 1.2 * whole
        flips.append(result["flip"])
    assert flips[0] == flips[1]
    assert run("diff", *files, "--metric", "rmse", "--limit", "0.36") == 0  # the whole picture's is sqrt(1/8)
    assert run("diff", *files, "--metric", "rmse", "--limit", "0.35") == 4
    assert "rmse 0.353553 is beyond the limit, 0.35" in capsys.readouterr().err
    assert run("diff", files[1], files[0], "--metric", "psnr", "--limit", "3") == 0
    assert run("diff", files[1], files[0], "--metric", "psnr", "--limit", "3.1") == 4
    assert "say --metric" in fails(capsys, "diff", *files, "--limit", "1")
    write_image(tmp_path / "black.png", np.zeros_like(a))
    assert "no pixel counts" in fails(capsys, "diff", *files, "--mask", tmp_path / "black.png")


def test_quiet_says_only_errors_and_results(tmp_path, capsys):
    words = "weave", ROOT / "glcloth/fabrics/poplin.toml", "-o", tmp_path / "a.toml"
    assert run(*words) == 0
    loud = capsys.readouterr()
    assert run("--quiet", *words) == 0
    warn("not said")
    assert list(track([1, 2], "work")) == [1, 2]
    quiet = capsys.readouterr()
    assert loud.out == quiet.out and "sett" in loud.out
    assert str(tmp_path / "a.toml") in loud.err and quiet.err == ""
    assert "no such file" in fails(capsys, "-q", "diff", tmp_path / "none.png", tmp_path / "b.png")
    assert run(*words) == 0 and capsys.readouterr().err == loud.err


def test_closed_streams_are_no_fault():
    code = "import sys; from glcloth import cli, progress; cli._open_streams(); progress.warn('x'); "
    code += "print(*progress.track(['y'], 'work'), sys.stdin.read())"
    words = ["sh", "-c", f'{sys.executable} -c "{code}" 2>&- <&-']
    done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT)
    assert (done.returncode, done.stdout) == (0, "y \n")  # and no warning among the results


def test_info_names_the_renderer(capsys):
    assert run("info", "--json") == 0
    assert json.loads(capsys.readouterr().out)["gl_renderer"]


def test_module_runs_from_any_folder(tmp_path):
    result = subprocess.run(
        [sys.executable, "-m", "glcloth", "--version"], cwd=tmp_path, capture_output=True, text=True
    )
    assert result.returncode == 0 and result.stdout.strip()


def bad_fabric(tmp_path, change):
    text = (ROOT / "glcloth/fabrics/linen.toml").read_text()
    path = tmp_path / "mine.toml"
    path.write_text(change(text))
    return path


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t: t.replace("eta =", "etta =", 1), "yarn 1: etta: unknown key; did you mean eta?"),
        (lambda t: t.replace("gamma_s_deg = 12", "gamma_s_deg = -1", 1), "yarn 1: gamma_s_deg = -1"),
        (lambda t: t + t[t.index("[[yarn]]") : t.index("# What threads")], "has 4 yarns, expected exactly two"),
        (lambda t: t.replace("samples = 2", "", 1), "needs curve_angles_deg, curve_lengths and samples"),
        (lambda t: t.replace("curve_lengths = [1]", "curve_lengths = [1, 1]", 1), "expected 1, one between"),
        (lambda t: t.replace("area = 0.33", "area = 0.8"), "areas add up to 1.6"),
        (lambda t: t.replace('"sadeghi"', '"other"'), "normalization"),
        (lambda t: "eta = = 3", "not TOML"),
        (lambda t: "", "name"),
    ],
)
def test_wrong_fabric_files(tmp_path, capsys, change, said):
    path = bad_fabric(tmp_path, change)
    line = fails(capsys, "render", "-o", tmp_path / "a.png", *QUICK, "--fabric", path)
    assert said in line and "mine.toml" in line
    assert not (tmp_path / "a.png").exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--fabric", "linnen"], 'did you mean "linen"'),
        (["--fabric", "nothere.toml"], "no such file"),
        (["--env", "stduio"], "did you mean studio"),
        (["--env", "nothere.exr"], "nothere.exr"),
        (["--mesh", "spere"], "did you mean sphere"),
        (["--mesh", "nothere.obj"], "nothere.obj"),
        (["--size", "0x0"], "16384"),
        (["--size", "20000x20000"], "16384"),
        (["--size", "wide"], "WIDTHxHEIGHT"),
        (["--lobes", "0"], "1 to 64"),
        (["--lobes", "65"], "1 to 64"),
        (["--method", "fast"], "direct, paper"),
        (["--quality", "best"], "draft, normal"),
        (["--spp", "0"], "spp"),
        (["--spp", "1.5"], "--spp: expected a whole number, not '1.5'"),
        (["--subdivide", "1.5"], "--subdivide: expected a whole number"),
        (["--segments", "1"], "segments"),
        (["--cube", "1"], "cube"),
        (["--contribution", "1.5"], "contribution"),
        (["--env-rotate", "north"], "env-rotate"),
        (["--fabrik", "linen"], "--fabric"),
        (["--device", "77"], "device"),
        (["--device", "-1"], "device"),
        (["--view-transform", "nice"], "standard"),
    ],
)
def test_wrong_options(tmp_path, capsys, options, said):
    line = fails(capsys, "render", "-o", tmp_path / "a.png", *quick_but(*options))
    assert said in line
    assert not (tmp_path / "a.png").exists()


def test_wrong_outputs(tmp_path, capsys):
    assert "xyz" in fails(capsys, "render", "-o", tmp_path / "a.xyz", *QUICK)
    assert "does not exist" in fails(capsys, "render", "-o", tmp_path / "none/a.png", *QUICK)
    assert "folder" in fails(capsys, "render", "-o", tmp_path, *QUICK)
    assert "--output" in fails(capsys, "render", *QUICK)
    if os.geteuid() != 0:  # root may write anywhere
        (tmp_path / "locked").mkdir(mode=0o500)
        assert "permission" in fails(capsys, "render", "-o", tmp_path / "locked/a.png", *QUICK)


def test_wrong_commands(capsys):
    assert "render" in fails(capsys, "rendr")
    assert "nothere" in fails(capsys, "render", "nothere", "-o", "a.png")
    assert "render: --output (-o) is missing: Picture to write" in fails(capsys, "render", "--fabric", "linen")
    assert "diff: B is missing" in fails(capsys, "diff", "a.png")
    assert "c.png: more than glcloth diff takes" in fails(capsys, "diff", "a.png", "b.png", "c.png")
    assert "--fabric: expected a value" in fails(capsys, "render", "-o", "a.png", "--fabric")


def test_what_is_no_scene_names_its_option(tmp_path, capsys):
    for name, option in (("linen.toml", "--fabric"), ("map.exr", "--env"), ("ball.obj", "--mesh")):
        if name == "map.exr":
            write_image(tmp_path / name, np.ones((4, 8, 3), "f4"))
        else:
            (tmp_path / name).write_text((ROOT / "glcloth/fabrics/linen.toml").read_text())
        assert option in fails(capsys, "render", tmp_path / name, "-o", tmp_path / "a.png")


@pytest.mark.parametrize("name", ["a.exr", "a.hdr", "a.png"])
def test_damaged_pictures(tmp_path, capsys, name):
    path = tmp_path / name
    good = tmp_path / f"good{path.suffix}"
    if path.suffix == ".hdr":
        good.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n" + bytes([128, 128, 128, 129]) * 128)
    else:
        write_image(good, np.ones((32, 64, 3), "f4"))
    for content in (b"", b"this is not a picture\n" * 20, good.read_bytes()[: len(good.read_bytes()) // 2]):
        path.write_bytes(content)
        line = fails(capsys, "render", "-o", tmp_path / "out.png", *QUICK, "--env", path)
        assert name in line


def test_an_hdri_with_bad_samples_warns_once_and_renders(tmp_path, capsys):
    radiance = np.full((16, 32, 3), 0.7, "f4")
    radiance[3, 4] = np.nan
    radiance[5, 6, 1] = -2.0
    radiance[7, 8, 2] = np.inf
    write_image(tmp_path / "bad.exr", radiance)
    assert run("render", "-o", tmp_path / "a.exr", *QUICK, "--env", tmp_path / "bad.exr") == 0
    err = capsys.readouterr().err
    assert err.count("warning") == 1 and "bad.exr" in err
    assert np.isfinite(read_image(tmp_path / "a.exr")).all()


def obj(tmp_path, text):
    path = tmp_path / "mine.obj"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "text",
    [
        "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n",
        "v 1e30 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
        "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
        "hello\n",
    ],
    ids=["no area", "huge", "empty", "no faces", "nan", "index", "text"],
)
def test_damaged_meshes(tmp_path, capsys, text):
    assert "mine.obj" in fails(capsys, "render", "-o", tmp_path / "a.png", *quick_but("--mesh", obj(tmp_path, text)))


def test_a_mesh_without_uvs_warns_once_and_renders(tmp_path, capsys):
    path = obj(tmp_path, "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nv 0 1 0\nf 1 2 3\nf 3 4 4\n")  # the second face is degenerate
    assert run("render", "-o", tmp_path / "a.exr", *quick_but("--mesh", path)) == 0
    err = capsys.readouterr().err
    assert err.count("warning") == 1 and "mine.obj" in err
    picture = read_image(tmp_path / "a.exr")
    assert np.isfinite(picture).all() and picture.max() > 0


def test_every_mesh_format_gives_the_same_picture(tmp_path, capsys):
    sphere = load_mesh("sphere")
    pictures = []
    for suffix in ("obj", "ply", "glb"):
        save_mesh(tmp_path / f"s.{suffix}", sphere)
        assert run("render", "-o", tmp_path / f"{suffix}.exr", *quick_but("--mesh", tmp_path / f"s.{suffix}")) == 0
        pictures.append(read_image(tmp_path / f"{suffix}.exr"))
    assert np.abs(pictures[0] - pictures[1]).max() < 1e-3 and np.abs(pictures[0] - pictures[2]).max() < 1e-3


# Runs `python -m glcloth` and tells when it begins to listen: how soon the interpreter gets there is not for us to time.
LISTENED_TO = """
import runpy, signal
set_handler = signal.signal
def set_and_tell(*of):
    set_handler(*of)
    print("listening", flush=True)
signal.signal = set_and_tell
runpy.run_module("glcloth", run_name="__main__", alter_sys=True)
"""


@pytest.mark.parametrize("seconds", [0, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.3, 2.8])
def test_ctrl_c_is_heard_at_any_moment(tmp_path, seconds):
    """While modules load, which swallow it, as well as later: exit 130, one line, nothing left behind.

    Whichever of both it meets on this machine; the picture is so large that none has it done within seconds.
    """
    command = [sys.executable, "-c", LISTENED_TO, "render", "-o", "a.png", *QUICK[:-2], "--spp", "256"]
    command[command.index("32x24")] = "1920x1440"
    command[command.index("4")] = "32"
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "listening\n"
    time.sleep(seconds)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=3600)  # against waiting for ever
    assert process.returncode == 130 and "stopped" in err and "Traceback" not in err and list(tmp_path.iterdir()) == []


def test_ctrl_c_leaves_no_file(tmp_path, monkeypatch, capsys):
    from glcloth.picture import renderer

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(renderer.Renderer, "draw", interrupted)
    assert run("render", "-o", tmp_path / "a.png", *QUICK) == 130
    assert list(tmp_path.iterdir()) == []


def test_animate_writes_whole_frames_and_resumes(tmp_path, capsys):
    pattern = tmp_path / "frames/%03d.exr"
    assert run("animate", "-o", pattern, *QUICK, "--frames", "3", "--json") == 0
    assert json.loads(capsys.readouterr().out)["frames"] == 3
    names = sorted(p.name for p in pattern.parent.iterdir())
    assert names == ["000.exr", "001.exr", "002.exr"]
    last = read_image(pattern.parent / "002.exr")
    (pattern.parent / "002.exr").unlink()
    assert run("animate", "-o", pattern, *QUICK, "--frames", "3", "--start", "2") == 0
    assert np.array_equal(read_image(pattern.parent / "002.exr"), last)
    assert run("animate", "-o", pattern, *QUICK, "--frames", "3", "--resume") == 0
    assert "no frame was missing" in capsys.readouterr().err
    layered = tmp_path / "l%d.exr"
    assert run("animate", "-o", layered, *QUICK, "--frames", "1", "--aov", "depth,mask") == 0
    assert {"Z", "mask.A", "R"} <= set(OpenEXR.File(str(tmp_path / "l0.exr"), separate_channels=True).channels())
    assert "expected frames" in fails(capsys, "animate", "-o", tmp_path / "%d.png", *QUICK, "--aov", "depth")
    assert "%04d" in fails(capsys, "animate", "-o", tmp_path / "a.png", *QUICK)
    assert "start" in fails(capsys, "animate", "-o", pattern, *QUICK, "--frames", "3", "--start", "3")


def test_poses_may_begin_at_any_number(tmp_path):
    for number in (3, 4, 5, 8):
        (tmp_path / f"p{number:02d}.ply").touch()
    pattern = str(tmp_path / "p%02d.ply")
    assert list(pose_files(pattern, 6, 4)) == [3, 4, 5], "and those before it, for what the vertices have seen"
    assert list(pose_files(pattern, 9, 8)) == [8]
    for count, start, words in ((6, 0, "begin at 3: choose --start 3"), (8, 3, "3 from 3 on: choose --frames 6"),
                                (2, 0, "there is none")):  # fmt: skip
        with pytest.raises(InputError, match=words):
            pose_files(pattern, count, start)


def test_animate_follows_poses_from_files_and_resumes(tmp_path, capsys):
    sheet = load_mesh("plane")
    for i in range(6):
        positions = sheet.positions.astype(float)
        positions[:, 1] += (0.05 + 0.01 * i) * np.sin(9 * positions[:, 0] + 0.2 * i)
        pose = build_mesh("pose", positions, sheet.triangles, sheet.uv)
        save_mesh(tmp_path / f"{i:02d}.ply", pose)
    quick = ["--mesh", tmp_path / "%02d.ply", "--fabric", "linen", "--size", "32x24", "--shadows", "full"]
    command = ["animate", *quick, "--turn-env", "60", "--frames", "6"]
    assert run(*command, "-o", tmp_path / "a/%d.exr") == 0
    assert run(*command, "-o", tmp_path / "b/%d.exr", "--start", "4") == 0
    assert sorted(p.name for p in (tmp_path / "b").iterdir()) == ["4.exr", "5.exr"]
    pictures = [read_image(tmp_path / f"a/{i}.exr") for i in range(6)]
    for i in (4, 5):
        assert np.array_equal(read_image(tmp_path / f"b/{i}.exr"), pictures[i])
    assert np.abs(pictures[1] - pictures[0]).max() > 1e-3
    # A frame knows its pose and its light: rendered for itself it is the same but for the poses before it.
    scene = read_settings(tmp_path / "a/3.exr")["scene"]
    assert scene["mesh"] == str(tmp_path / "03.ply") and scene["env_rotate"] == 30.0
    # Seen from where the whole sequence is seen from, which is chosen for the first pose.
    with Renderer() as renderer:
        camera = renderer.prepare(mesh=str(tmp_path / "00.ply"), size=(32, 24)).camera
        alone = renderer.render(
            mesh=str(tmp_path / "03.ply"), env_rotate=30.0, fabric="linen", size=(32, 24), camera=camera
        )
    assert np.abs(alone - pictures[3]).mean() < 0.02 * alone.mean()
    (tmp_path / "05.ply").unlink()
    line = fails(capsys, *command, "-o", tmp_path / "c/%d.png")
    assert "05.ply" in line and "--frames 5" in line
    assert "%04d" in fails(capsys, "animate", "-o", tmp_path / "c/%d.png", "--mesh", "a%d/%d.ply")


def test_only_the_built_in_cloth_and_the_curtain_know_the_wind(tmp_path, capsys):
    frames = tmp_path / "%d.png"
    assert "poses" in fails(capsys, "animate", "-o", frames, *QUICK, "--wind", "1")
    assert "20" in fails(capsys, "animate", "-o", frames, "--wind", "21")
    assert "curtain" in fails(capsys, "animate", "curtain", "-o", frames, "--turn-env", "90")
    assert "degrees" in fails(capsys, "animate", "-o", frames, *QUICK, "--turn-env", "nan")


def test_blended_layers_trace_no_paths(tmp_path, capsys):
    picture = tmp_path / "a.png"
    assert "--layers" in fails(capsys, "render", "curtain", "-o", picture, "--layers", "--method", "path")
    assert not picture.exists()


def test_the_environment_turns_and_the_camera_rests(tmp_path):
    quick = [*QUICK, "--env", "studio", "--shadows", "off"]
    turning = ["animate", *quick, "--frames", "2", "--turn-env", "180"]
    assert run(*turning, "-o", tmp_path / "%d.exr") == 0
    assert run(*turning, "--turntable", "-o", tmp_path / "both%d.exr") == 0
    assert run("render", *quick, "--env-rotate", "90", "-o", tmp_path / "one.exr") == 0
    one, both = (read_image(tmp_path / name) for name in ("1.exr", "both1.exr"))
    assert np.array_equal(one, read_image(tmp_path / "one.exr"))
    assert np.abs(both - one).max() > 1e-3


def test_bench_cloth_tells_what_shadows_cost_at_rest_and_in_motion(capsys):
    quick = ["--mesh", "plane", "--env", "studio", "--lobes", "3", "--size", "32x24", "--frames", "1"]
    assert run("bench", "cloth", "--methods", "direct", *quick, "--json") == 0
    result = json.loads(capsys.readouterr().out)
    assert result["methods"]["direct_shadows"]["shadows_ratio"] > 0
    costs, moving = result["shadows"], result["moving"]
    assert {"place_ms", "trace_ms", "trace_own_ms", "means_ms", "edges_ms", "edges_cpu_ms"} < set(costs)
    assert {"ms", "cpu_ms", "off_ms", "off_cpu_ms", "sway_edges"} < set(moving)
    assert 0 <= moving["error_percent"] < 10
    assert run("bench", "cloth", "--methods", "direct", *quick, "--shadows", "off", "--json") == 0
    result = json.loads(capsys.readouterr().out)
    assert result["shadows"] == result["moving"] == {}


def test_a_fault_of_ours_is_one_line_too(tmp_path, monkeypatch, capsys):
    from glcloth.picture import renderer

    def broken(*_):
        raise RuntimeError("something\nunforeseen")

    monkeypatch.setattr(renderer.Renderer, "draw", broken)
    monkeypatch.delenv("GLCLOTH_DEBUG", raising=False)
    assert run("render", "-o", tmp_path / "a.png", *QUICK) == 1
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and "unforeseen" in err and "GLCLOTH_DEBUG" in err


def test_a_garment_of_several_fabrics_travels_with_its_picture(tmp_path, capsys):
    (tmp_path / "a.obj").write_text(
        "v 0 0 0\nv 90 0 0\nv 0 90 0\nv 90 90 9\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
        "usemtl Shell\nf 1/1 2/2 3/3\nusemtl Lining\nf 2/2 4/4 3/3\n"
    )
    options = quick_but("--mesh", tmp_path / "a.obj", "--shadows", "off")
    parts = ["--fabric", "linen", "--fabric", "Lin*=voile", "--mesh", "plane", "--object", "stand@0,-2,0,0.1"]
    assert run("render", "-o", tmp_path / "a.exr", *options, *parts, "--json") == 0
    out, err = capsys.readouterr()
    assert "Cotton voile" in json.loads(out)["fabric"] and err.count("taken for cm") == 1
    scene = read_settings(tmp_path / "a.exr")["scene"]
    assert scene["fabrics"] == {"Lin*": "voile"} and scene["mesh"] == [str((tmp_path / "a.obj").resolve()), "plane"]
    assert run("render", tmp_path / "a.exr", "-o", tmp_path / "b.exr") == 0
    assert np.array_equal(read_image(tmp_path / "a.exr"), read_image(tmp_path / "b.exr"))
    out = ["render", "-o", tmp_path / "c.exr", "--mesh", tmp_path / "a.obj"]
    assert "did you mean Lining?" in fails(capsys, *out, "--fabric", "Linin=voile")
    assert "PART=voile" in fails(capsys, *out, "--fabric", "linen", "--fabric", "voile")
    assert "@x,y,z,scale,turn" in fails(capsys, *out, "--object", "stand@1,a")
    assert not (tmp_path / "c.exr").exists()


def test_drape_says_which_pieces_there_are(tmp_path, capsys):
    assert "did you mean skirt?" in fails(capsys, "drape", "skrit", "-o", tmp_path / "a.ply")
    assert ".npz" in fails(capsys, "drape", "skirt", "-o", tmp_path / "a.stl")
    assert list(tmp_path.iterdir()) == []
