"""Hostile input through the doors: one printable line, exit code 2, no file, and no more memory than is reasonable."""

import os
import subprocess
import sys
import time

import numpy as np
import pytest
from PIL import Image
from PIL.PngImagePlugin import PngInfo
from test_doors import QUICK, fails, quick_but

from glcloth import load_fabric
from glcloth.errors import MAX_LINE, InputError
from glcloth.files import MARK, STALE, _swept, atomic_write
from glcloth.methods.paper import tables
from glcloth.progress import say, show, warn

ESCAPE = "\x1b]0;owned\x07\x1b[31mred\u202e\nnext"


def is_a_line(text):
    return text.rstrip("\n").isprintable() and len(text.rstrip("\n")) <= MAX_LINE


def test_whatever_is_printed_is_one_printable_line(capsys):
    """By every way to a terminal: errors, warnings, information and tables; the place and the remedy stay."""
    long = "place: " + 9000 * "x" + ESCAPE + "; remedy"
    for text in (str(InputError(long)), *_lines(capsys, say, long), *_lines(capsys, warn, long)):
        assert is_a_line(text) and "place" in text and text.rstrip().endswith("; remedy"), text
    show(["a  b" + ESCAPE])
    out = capsys.readouterr().out
    assert is_a_line(out) and out.startswith("a  b?]0;owned??[31mred? next")


def _lines(capsys, print_it, text):
    print_it(text)
    return [capsys.readouterr().err]


@pytest.mark.parametrize("name", ["mesh.obj", "fabric.toml", "lights.json", "scene.toml"])
def test_names_in_files_cannot_steer_the_terminal(tmp_path, capsys, name):
    texts = {
        "mesh.obj": f"v 0 0 0\nv 1 0 0\nf 1 2 {ESCAPE}\n",
        "fabric.toml": 'name = "a"\n"\\u001b[31m' + 500 * "x" + '" = 1\n',
        "lights.json": '{"format": "glcloth lights 1", "gaussian": [{"axis": "\\u001b[31m' + 500 * "x" + '"}]}',
        "scene.toml": 'mesh = "\\u001b[31m' + 500 * "x" + '"\n',
    }
    path = tmp_path / name
    path.write_text(texts[name])
    option = {"mesh.obj": "--mesh", "fabric.toml": "--fabric", "lights.json": "--lights"}.get(name)
    what = quick_but(option, path) if option else [path, *QUICK]
    if name == "scene.toml":
        what = [path, "--size", "32x24"]
    assert is_a_line(fails(capsys, "render", "-o", tmp_path / "a.png", *what))
    assert is_a_line(fails(capsys, "render", "-o", tmp_path / "\x1b[31m/a.png", *QUICK))


SCENES = {
    "size is a number": "size = 5",
    "size has one": "size = [5]",
    "size of words": 'size = ["a", "b"]',
    "size of fractions": "size = [5.5, 7.5]",
    "lobes is a list": "lobes = [1]",
    "lobes is a table": "lobes = {a = 1}",
    "lobes is true": "lobes = true",
    "a ground far away": "ground = 1e300",
    "a ground of many digits": f"ground = 0x{9000 * 'f'}",
    "colours that are none": "ground_color = 3",
    "colours of many digits": f"ground_color = [0x{9000 * 'f'}, 1, 1]",
    "deep lists": f"a = {9000 * '['}",
    "deep tables": 900 * "a = {" + "b = 1" + 900 * "}",
    "a long dotted key": "a." * 20_000 + "a = 1",
    "a number of many digits": f"spp = {5000 * '9'}",
    "the same in base 16": f"spp = 0x{9000 * 'f'}",
    "infinite turn": "env_rotate = inf",
    "far eye": "[camera]\neye = [1e20, 1, 1]",
    "a name of zeros": 'mesh = "a\\u0000.obj"',
    "a long name": f'mesh = "{5000 * "x"}.obj"',
    "no text": "\ud800",
    "objects of numbers": "objects = [1, 2]",
    "bright lamp": "lamp_intensity = [1e39, 1, 1]\n[curtain]\n",
}


@pytest.mark.parametrize("text", SCENES.values(), ids=SCENES)
def test_a_scene_file_of_wrong_kinds_is_one_line(tmp_path, capsys, text):
    (tmp_path / "s.toml").write_bytes(text.encode("utf-8", "surrogatepass"))
    assert is_a_line(fails(capsys, "render", tmp_path / "s.toml", "-o", tmp_path / "a.png"))
    assert not (tmp_path / "a.png").exists()


LIGHT = '{"axis": [0, 1, 0], "sharpness": 9, "amplitude": [1, 1, 1]}'


@pytest.mark.parametrize(
    "light",
    [
        9000 * "[",
        LIGHT.replace("9", 5000 * "9"),
        LIGHT.replace("9", "1e20"),
        LIGHT.replace("1, 1, 1", "1e39, 1, 1"),
        LIGHT.replace("9", "NaN"),
        LIGHT.replace("9", '"\\ud800"'),
        LIGHT + '], "sun": [{"direction": [0, 1, 0], "irradiance": [1e38, 1, 1]}',
    ],
)
def test_lights_that_no_shader_can_sum_are_one_line(tmp_path, capsys, light):
    (tmp_path / "l.json").write_text('{"format": "glcloth lights 1", "gaussian": [' + light + "]}")
    assert is_a_line(fails(capsys, "render", "-o", tmp_path / "a.png", *QUICK, "--lights", tmp_path / "l.json"))


def test_a_deep_picture_header_is_one_line(tmp_path, capsys):
    info = PngInfo()
    info.add_itxt("glcloth", 9000 * "[")
    Image.new("RGB", (2, 2)).save(tmp_path / "a.png", pnginfo=info)
    assert "too deep" in fails(capsys, "render", tmp_path / "a.png", "-o", tmp_path / "b.png")


def test_a_large_text_and_a_pipe_are_refused_before_they_are_read(tmp_path, capsys):
    with open(tmp_path / "big.toml", "wb") as file:
        file.truncate(1 << 40)
    assert "larger than 4 MB" in fails(capsys, "render", tmp_path / "big.toml", "-o", tmp_path / "a.png")
    for name, what in (("s.toml", []), ("l.toml", ["--lights"]), ("f.toml", ["--fabric"])):
        os.mkfifo(tmp_path / name)
        assert "pipe" in fails(capsys, "render", *what, tmp_path / name, "-o", tmp_path / "a.png")
    os.mkfifo(tmp_path / "d.wif")
    assert "pipe" in fails(capsys, "render", *QUICK, "--fabric", tmp_path / "d.wif", "-o", tmp_path / "a.png")
    os.mkfifo(tmp_path / "o.png")
    assert "pipe" in fails(capsys, "render", *QUICK, "-o", tmp_path / "o.png")


def test_a_table_cache_with_one_other_bit_is_made_anew(tmp_path, monkeypatch, capsys):
    """A bit in the numbers, which the zip archive's own sum does not always notice."""
    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path))
    made = tables.tables_for("linen", 8, 0.5)
    (path,) = tmp_path.rglob("*.npz")
    with np.load(path) as file:
        content = {name: file[name] for name in file.files}
    content["xi"] = content["xi"].copy()
    content["xi"].view(np.uint32).ravel()[0] ^= 1
    np.savez(path, **content)
    again = tables.tables_for(load_fabric("linen"), 8, 0.5)
    assert "damaged" in capsys.readouterr().err
    assert np.array_equal(made.xi[0][0], again.xi[0][0])


def test_a_file_written_over_keeps_its_permissions_and_a_link_its_target(tmp_path):
    real, link, old = tmp_path / "real.txt", tmp_path / "link.txt", tmp_path / f".a{MARK}xyz.txt"
    new = tmp_path / f".b{MARK}xyz.txt"
    real.write_text("before")
    real.chmod(0o640)
    link.symlink_to("real.txt")
    for left in (old, new):
        left.touch()
    os.utime(old, (time.time() - 2 * STALE,) * 2)
    _swept.discard(tmp_path)
    with atomic_write(link) as temporary:
        temporary.write_text("after")
    assert link.is_symlink() and real.read_text() == "after" and real.stat().st_mode & 0o777 == 0o640
    assert not old.exists() and new.exists()  # what a killed run left an hour ago; not what another run writes now
    with atomic_write(tmp_path / "fresh.txt") as temporary:
        temporary.write_text("x")
    mask = os.umask(0)
    os.umask(mask)
    assert (tmp_path / "fresh.txt").stat().st_mode & 0o777 == 0o666 & ~mask


STOPPED_WHILE_TABLES_ARE_WRITTEN = """
import os, signal, sys
import numpy as np
def half(file, **arrays):
    file.write(1000 * b"half ")
    file.flush()
    os.kill(os.getpid(), signal.{})
np.savez, sys.argv = half, ["glcloth", "tables", "linen", "--grid", "8"]
from glcloth.__main__ import main
main()
"""


@pytest.mark.parametrize("name", ["SIGINT", "SIGKILL"])
def test_tables_are_written_whole_or_not_at_all(tmp_path, monkeypatch, capsys, name):
    """Ctrl-C: exit 130, one line, nothing left. kill -9: what it left is gone by the next run, but not before an hour."""
    env = {**os.environ, "GLCLOTH_CACHE": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
    text = STOPPED_WHILE_TABLES_ARE_WRITTEN.format(name)
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, env=env)
    left = [path for path in tmp_path.rglob("*") if path.is_file()]
    if name == "SIGINT":
        assert done.returncode == 130 and not left and not done.stdout
        assert done.stderr == "glcloth: stopped; nothing was left half-written\n"
        return
    assert done.returncode == -9 and len(left) == 1 and MARK in left[0].name and b"half" in left[0].read_bytes()
    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path))
    for age, there in ((STALE / 2, True), (2 * STALE, False)):
        os.utime(left[0], (time.time() - age,) * 2)
        _swept.clear()  # as in another process
        made = tables.tables_for("linen", 8, 0.9 if there else 0.8)
        assert left[0].exists() == there and np.isfinite(made.xi[0][0]).all()
    kept = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert len(kept) == 2 and not capsys.readouterr().err


def test_ctrl_c_after_the_last_line_changes_nothing():
    """The interpreter tidies up for up to a tenth of a second, and then had no handler any more."""
    late = "import atexit, os, signal, sys, weakref\n"
    late += "class Late:\n    def __del__(self, kill=os.kill, me=os.getpid(), what=signal.SIGINT): kill(me, what)\n"
    late += "sys.late = Late()\nsys.argv = ['glcloth', '--version']\nfrom glcloth.__main__ import main\nmain()\n"
    done = subprocess.run([sys.executable, "-c", late], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.strip() and not done.stderr, done


def test_ctrl_c_in_code_from_text_does_not_outlive_it(tmp_path):
    """Named tuples are such code; after it `python -m` would end by the signal, whatever our exit code is."""
    text = "import sys, glcloth.cli\nfrom glcloth.__main__ import main\n"
    text += "def run():\n    exec('raise KeyboardInterrupt')\n"
    text += "glcloth.cli.app = lambda *_, **__: run()\nsys.argv = ['glcloth', 'info']\nmain()\n"
    (tmp_path / "stopped.py").write_text(text)
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    done = subprocess.run([sys.executable, "-m", "stopped"], capture_output=True, text=True, env=env)
    assert done.returncode == 130 and done.stderr == "glcloth: stopped; nothing was left half-written\n"
