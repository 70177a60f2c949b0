"""Many processes share pictures: one that is killed costs its picture, and all have the bits of one process."""

import csv
import json
import os
import signal
import subprocess
import sys
from dataclasses import fields, replace
from multiprocessing.process import BaseProcess
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np
import pytest
from fake_job import Fake, Surroundings, Wrong
from test_doors import fails, run

from glcloth import cli
from glcloth.cli.many import missing
from glcloth.cli.options import SceneOptions, scene_of
from glcloth.errors import DriverError, InputError, NoOpenGLError, ShaderError
from glcloth.farm import cluster, pool
from glcloth.farm.film import Film, numbers_of
from glcloth.farm.openjd import film_template, sweep_template
from glcloth.farm.sweep import Sweep, parse_vary
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.mesh_files import load_mesh
from glcloth.image import read_image, write_image
from glcloth.picture import sequence
from glcloth.picture.options import OPTIONS, SEVERAL
from glcloth.scene import Scene, load_scene

QUICK = ["--mesh", "sphere", "--size", "16x12", "--shadows", "off", "--quality", "draft"]


def test_a_process_killed_costs_its_picture_which_another_makes(tmp_path, capsys, monkeypatch):
    monkeypatch.delenv("LP_NUM_THREADS", raising=False)
    done = [result["number"] for result in pool.share(Fake(tmp_path, (2, 3)), range(7), 2)]
    assert sorted(done) == list(range(7)) and "another makes it" in capsys.readouterr().err
    assert [(tmp_path / f"{n}.txt").read_text().split()[0] for n in range(7)] == [str(3 * n) for n in range(7)]
    assert (tmp_path / "0.txt").read_text().split()[1] == str(pool.threads_of(2))
    assert not list(tmp_path.glob(".*")), "half a picture is left"
    assert "LP_NUM_THREADS" not in os.environ


def test_processes_have_the_surroundings_of_their_job_and_leave_ctrl_c_to_it(monkeypatch):
    start, heard = BaseProcess.start, []
    monkeypatch.setattr(
        BaseProcess, "start", lambda self: (heard.append(signal.getsignal(signal.SIGINT)), start(self))[1]
    )
    before = signal.getsignal(signal.SIGINT)
    for cache in ("one", "other", None):
        monkeypatch.delenv("GLCLOTH_CACHE") if cache is None else monkeypatch.setenv("GLCLOTH_CACHE", cache)
        (found,) = pool.share(Surroundings(), [0], 1)
        assert found == {"cache": cache, "deaf": True}
    # Not even while the first one starts, which takes as long as glcloth does.
    assert set(heard) == {before}


def test_a_picture_that_kills_every_process_is_given_up(tmp_path):
    with pytest.raises(RuntimeError, match=r"0\.txt: 3 processes died"):
        list(pool.share(Fake(tmp_path, (0,), always=True), [0], 1))


def test_errors_of_processes_are_those_of_one_process(monkeypatch):
    """One through a real process, all through what a process runs."""
    with pytest.raises(NoOpenGLError, match=r"^no OpenGL here$"):
        list(pool.share(Wrong(NoOpenGLError("no OpenGL here")), [0], 1))
    sent = []
    pipe = SimpleNamespace(recv=lambda: 0, send=sent.append)
    monkeypatch.setattr(sys, "stderr", sys.stderr)  # which a process takes over
    for error in (InputError("a"), ShaderError("b"), DriverError("c"), MemoryError("d"), KeyError("e")):
        pool._work(pipe, Wrong(error), 1, dict(os.environ))
        kind, text = sent.pop()
        assert pool.KINDS.get(kind, KeyError) is type(error) and str(error) in text


def test_some_frames_of_cloth_that_moves_have_the_bits_of_all(renderer):
    """With a cut in the middle, from where rays start anew."""
    sheet = load_mesh("plane")

    def pose(i):
        positions = sheet.positions.astype(float)
        wave = 0.15 * np.sin(9 * positions[:, 0] + 0.1 * i + (1.5 if i > 1 else 0.0))
        positions += wave[:, None] * sheet.normals.mean(0)
        return build_mesh("pose", positions, sheet.triangles, sheet.uv)

    scene = Scene(fabric="linen", size=(24, 18), mesh="plane", quality="draft")
    motion = sequence.Motion(6, pose, turn_env=60.0)
    whole = list(sequence.pictures(renderer, scene, motion))
    some = list(sequence.chosen(renderer, scene, motion, iter([1, 3, 5])))
    renderer.follow_poses(False)
    assert all(np.array_equal(some[k], whole[n]) for k, n in enumerate((1, 3, 5)))
    assert not np.array_equal(whole[3], whole[5])


def test_sweep_makes_pictures_a_sheet_and_a_table(tmp_path, capsys):
    vary = ["--vary", "fabric=linen,silk_shot", "--vary", "warp.gamma_s_deg=4:12:8"]
    command = ["sweep", "-o", tmp_path / "s", *vary, *QUICK, "--workers", "1", "--json"]
    assert run(*command) == 0
    assert json.loads(capsys.readouterr().out)["pictures"] == 4
    assert sorted(p.name for p in (tmp_path / "s").iterdir())[:4] == [f"000{i}.png" for i in range(4)]
    rows = list(csv.DictReader((tmp_path / "s/table.csv").open()))
    assert [(r["fabric"], r["warp.gamma_s_deg"]) for r in rows][1:3] == [("linen", "12"), ("silk_shot", "4")]
    assert float(rows[1]["mean_luminance"]) == pytest.approx(read_image(tmp_path / "s/0001.png").mean(), rel=0.3)
    assert read_image(tmp_path / "s/sheet.png").shape[0] > 2 * 12
    # A picture is rendered as the command line renders it, and only what is missing or of another scene is made again.
    assert run("render", "-o", tmp_path / "one.png", *QUICK, "--fabric", "silk_shot") == 0
    (tmp_path / "s/0001.png").write_bytes((tmp_path / "one.png").read_bytes())
    capsys.readouterr()
    before = (tmp_path / "s/0000.png").stat().st_mtime_ns
    assert run(*command, "--resume") == 0
    assert json.loads(capsys.readouterr().out)["pictures"] == 1
    assert (tmp_path / "s/0000.png").stat().st_mtime_ns == before


def test_resume_keeps_frames_of_the_same_film_that_are_whole(tmp_path):
    film = Film(Scene(size=(8, 6)), str(tmp_path / "%d.png"), 4)
    for number in range(4):
        film.write(number, np.random.default_rng(number).random((60, 80, 3), np.float32))
    assert load_scene(tmp_path / "1.png") == film.scene and missing(film, [0, 1, 2, 3]) == []
    for other in ({"frames": 8}, {"turntable": False}, {"turn_env": 90.0}, {"wind": 2.0}, {"rate": 25}):
        assert missing(replace(film, **other), [0, 1, 2, 3]) == [0, 1, 2, 3], other
    both = replace(film, turn_env=90.0)
    both.write(0, np.ones((6, 8, 3)))
    assert missing(both, [0]) == [] and missing(replace(both, turntable=True), [0]) == [0]
    # The frames of a film in which nothing turns do not know how many they are.
    rests = replace(film, turntable=False)
    rests.write(0, np.ones((6, 8, 3)))
    assert missing(replace(rests, frames=9), [0]) == []
    # Of before glcloth kept what film a frame is of, damaged, and cut off behind the header.
    old = {name: value for name, value in film.header(0).items() if name != "film"}
    write_image(tmp_path / "0.png", np.ones((6, 8, 3)), old)
    (tmp_path / "1.png").write_bytes(b"no picture")
    (tmp_path / "2.png").write_bytes((tmp_path / "2.png").read_bytes()[:-5000])
    assert missing(film, [0, 1, 2, 3]) == [0, 1, 2]


def test_wrong_sweeps_are_said_before_anything_is_rendered(tmp_path, capsys):
    command = ["sweep", "-o", tmp_path / "s", *QUICK]
    for vary, said in (
        ("fabri=linen", "did you mean fabric"),
        ("fabric=", "expected values"),
        ("env-rotate=0:9:-1", "first:last:step"),
        ("warp.eta=0.5,1.5", "eta"),
        ("wind=1,2", "curtain"),
        ("fabric=linnen", "linen"),
    ):
        assert said in fails(capsys, *command, "--vary", vary)
    assert "--only" in fails(capsys, *command, "--vary", "spp=1,2", "--only", "2")
    assert not (tmp_path / "s").exists()


def test_sweeps_know_all_options_of_render():
    assert {field.name for field in fields(SceneOptions)} == OPTIONS
    assert {name for name in OPTIONS if "list" in str(SceneOptions.__annotations__[name])} == SEVERAL
    words = {"fov": "30", "eye": "0,1,4", "target": "0,0,0", "print": "a.png", "print-repeat": "0.25", "env-rotate": "20",
             "object": "sphere@1,0,0", "fabric": "Lining=voile", "background": "false"}  # fmt: skip
    sweep = Sweep(Scene(), Path("s"), *parse_vary([f"{name}={value};" for name, value in words.items()]))
    given = [part for name, value in words.items() if name != "background" for part in (f"--{name}", value)]
    arguments = known(["render", *given, "--no-background", "-o", "a.png"])
    assert sweep.scene_at(0) == scene_of(None, arguments["options"]) != Scene()
    bookmarked = Scene(bookmarks=[{"name": "mine", "camera": {"eye": (0, 0, 9)}}])
    sweep = Sweep(bookmarked, Path("s"), *parse_vary(["view=mine,front"]))
    assert [(s.camera.eye, s.camera.view) for s in map(sweep.scene_at, (0, 1))] == [((0, 0, 9), None), (None, "front")]
    curtain = Sweep(load_scene("curtain"), Path("s"), *parse_vary(["wind=1,2", "frame=9"]))
    assert (curtain.scene_at(1).curtain.wind, curtain.scene_at(1).frame) == (2.0, 9)


def test_values_of_sweeps_and_numbers_of_frames():
    assert parse_vary(["env-rotate=0:180:60", "ground_color=0.1,0.2,0.3;0,0,0"]) == (
        ("env_rotate", "ground_color"),
        ((0, 60, 120, 180), ("0.1,0.2,0.3", "0,0,0")),
    )
    assert parse_vary(["exposure=0:0.3:0.1"])[1] == ((0, 0.1, 0.2, 0.3),)
    assert numbers_of("3,0-1,7", 8) == [0, 1, 3, 7] and numbers_of(None, 2) == [0, 1]
    with pytest.raises(InputError, match="0 to 7"):
        numbers_of("8", 8)


def farmed(folder, template, scene, output, number):
    """The command line of each step of a template, as a farm's machine runs it: its words."""
    fake = folder / "bin" / "glcloth"
    fake.parent.mkdir(exist_ok=True)
    fake.write_text("#!/bin/sh\nprintf '%s\\0' \"$@\"\n")
    fake.chmod(0o755)
    script = folder / "run.sh"
    given = {"Task.File.Run": script, "Param.Scene": scene, "Param.Output": output, "Task.Param.Number": number}
    for step in template["steps"]:
        script.write_text(step["script"]["embeddedFiles"][0]["data"])
        action = step["script"]["actions"]["onRun"]
        words = [action["command"], *(str(given[text.strip("{}")]) for text in action["args"])]
        path = f"{fake.parent}:{os.environ['PATH']}"
        said = subprocess.run(words, capture_output=True, text=True, check=True, env=os.environ | {"PATH": path})
        yield said.stdout.split("\0")[:-1]


def known(words):
    """What the command line makes of words."""
    return cli.app.parse_args(words, exit_on_error=False, print_error=False)[1].arguments


def test_a_farm_runs_commands_that_the_command_line_knows(tmp_path):
    odd = "a \"b\" 'c' $d"
    film = Film(Scene(), "my frames/%04d.png", 5, turn_env=-90.0, device="llvm pipe", since=2)
    template = film_template(film)
    assert template["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["range"] == "2-4"
    ((*words,),) = farmed(tmp_path, template, odd, odd, 3)
    found = known(words)
    assert (found["scene"], str(found["output"]), found["many"].only) == (odd, f"{odd}/%04d.png", "3")
    assert (found["start"], found["device"], found["turntable"], found["turn_env"]) == (2, "llvm pipe", False, -90.0)

    mine = tmp_path / "my linen.toml"
    mine.write_text("")
    sweep = Sweep(
        Scene(), tmp_path, *parse_vary([f"fabric=silk_shot,{mine}", "ground-color=0.1,0.2,0.3;0,0,0"]), ".exr", 1
    )
    template = sweep_template(sweep)
    assert template["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["range"] == "0-3"
    one, sheet = (known(words) for words in farmed(tmp_path, template, odd, odd, 3))
    assert one["many"].only == "3" and sheet["many"].resume and template["steps"][1]["dependencies"]
    for found in (one, sheet):
        assert (found["scene"], str(found["output"]), found["suffix"], found["device"]) == (odd, odd, ".exr", "1")
        assert parse_vary(found["vary"]) == (sweep.names, sweep.values)


def test_a_template_overwrites_nothing_of_the_user(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    own = 'fabric = "linen"\n'
    (tmp_path / "farm.toml").write_text(own)
    command = ["animate", "farm.toml", "-o", "f/%d.png", "--frames", "4", "--openjd"]
    for _ in range(2):  # what it wrote itself it writes again
        assert run(*command, "farm.json", "--json") == 0
        assert json.loads(capsys.readouterr().out) == {
            "template": "farm.json", "scene": "farm.json.toml", "pictures": 4}  # fmt: skip
    assert (tmp_path / "farm.toml").read_text() == own and load_scene("farm.json.toml").fabric == "linen"
    (tmp_path / "b.json.toml").write_text(own)
    assert "overwrite b.json.toml" in fails(capsys, *command, "b.json")
    (tmp_path / "d.json.toml").mkdir()
    assert "overwrite d.json.toml" in fails(capsys, *command, "d.json")
    assert "ends in .json" in fails(capsys, *command, "farm.toml")
    for more in (["--only", "1"], ["--resume"], ["--workers", "2"], ["--cluster", "tcp://1.2.3.4"]):
        assert f"leave {more[0]} out" in fails(capsys, *command, "c.json", *more)
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "b.json.toml",
        "d.json.toml",
        "f",
        "farm.json",
        "farm.json.toml",
        "farm.toml",
    ]


def test_a_cluster_makes_the_pictures(tmp_path):
    from distributed import LocalCluster

    options = {"n_workers": 2, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with LocalCluster(**options) as local:
        done = [r["number"] for r in cluster.share(Fake(tmp_path), [0, 2, 5], local.scheduler_address)]
    assert sorted(done) == [0, 2, 5] and (tmp_path / "5.txt").read_text().startswith("15 ")
    with pytest.raises(InputError, match="no scheduler answers"):
        list(cluster.share(Fake(tmp_path), [0], "not an address"))


def test_a_worker_goes_on_after_a_picture_that_failed(tmp_path):
    with pytest.raises(MemoryError):
        cluster._picture(Wrong(MemoryError("at 3")), 3)
    assert cluster._picture(Fake(tmp_path), 4)[0] == 4

    class Once(Fake):
        failed = False

        def pictures(self, numbers):
            for number in numbers:
                if number == 5 and not self.failed:
                    Once.failed = True
                    raise MemoryError("at 5")
                yield np.full(3, number)

    job = Once(tmp_path)
    assert cluster._picture(job, 4)[0] == 4
    with pytest.raises(MemoryError):
        cluster._picture(job, 5)
    assert [cluster._picture(job, n)[0] for n in (6, 7, 5)] == [6, 7, 5]


def test_jobs_of_a_scheduler_have_names_of_their_own(tmp_path, monkeypatch):
    """A job may lie where another client's lies in its memory."""
    import distributed

    client = MagicMock()
    monkeypatch.setattr(distributed, "Client", client)
    monkeypatch.setattr(distributed, "as_completed", lambda tasks: [])
    for _ in range(2):
        list(cluster.share(Fake(tmp_path), [0, 1], "x"))
    assert len({call.kwargs["key"] for call in client().submit.call_args_list}) == 4
