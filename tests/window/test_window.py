"""The window under Xvfb, by real events; skipped where Xvfb or xdotool is missing (`make tools` brings them)."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
HANG = 3600  # seconds, against waiting for ever; what is slow takes as long as it takes
DRIVER = ROOT / "tests" / "window" / "window_driver.py"


@pytest.fixture(scope="module")
def display():
    """The number of a display of its own."""
    if not (shutil.which("Xvfb") and shutil.which("xdotool")):
        pytest.skip("the window needs Xvfb and xdotool")
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x800x24", "+extension", "GLX"]
    server = subprocess.Popen(command, pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as pipe:
        number = pipe.readline().strip()
    if not number:
        pytest.skip("the window needs Xvfb, which does not start")
    yield f":{number}"
    server.terminate()
    server.wait()


def drive(display, *arguments, script=DRIVER):
    env = {**os.environ, "DISPLAY": display, "PYTHONPATH": str(ROOT)}
    run = subprocess.run(
        [sys.executable, script, *arguments], env=env, cwd=ROOT, capture_output=True, text=True, timeout=HANG
    )
    assert run.returncode == 0, run.stderr[-3000:]
    return json.loads(run.stdout.splitlines()[-1])


@pytest.fixture(scope="module")
def done(display):
    return drive(display, "events")


def test_the_refined_picture_is_renders_to_the_bit(done):
    assert done["as_render"] == [True, True, True] and done["gl_error"] == "GL_NO_ERROR"


def test_mouse_and_keys_do_what_they_should(done):
    assert done["orbited"] and done["zoomed"] and done["home"] and done["home_picture"]
    assert done["bookmark"] == [True] * 4 and done["view"] == [-1, 0, 0] and done["parallel"] == 1.5
    assert done["turned"] == -56.25 and done["undone"] == 0.0 and done["redone"] == done["turned"]
    assert done["follow"] and done["size"] == [120, 96] and done["screen"] == [96, 520, 3]


def test_a_bad_file_is_a_message_and_nothing_is_lost(done):
    assert "bad.hdr" in done["bad_file"] and done["kept"]


def test_a_scene_of_two_parts_is_edited_part_by_part(done):
    assert done["parts"][:3] == [["Left", "Right"], False, True]


def test_a_click_on_the_cloth_picks_the_part_that_is_there(done):
    right, left, beside, steps, dressed, undone = done["parts"][3]
    assert [right, left, beside, steps] == ["Right", "Left", "Left", 0], (
        "a click beside the cloth, and any, edits nothing"
    )
    assert dressed == {"Left": "velvet_ruby", "Right": "velvet"} and undone == {"Right": "velvet"}


def test_saved_scenes_and_pictures_open_to_the_same_picture(done):
    assert done["reopened"] == [True, True, True] and set(done["messages"]) == {"note"}


def test_both_sides_of_a_comparison_are_refined(done):
    assert done["sides"] == [1.0, 1.0]


def test_dropped_files_are_opened(display):
    done = drive(display, "drops")
    assert done["fabric"] == [True, "Mine"] and done["mesh"] == [True, True] and done["light"] == [True, 1.0]
    assert done["lights"] == [True, 1] and done["picture"] == [True, True]
    assert done["two"] == [True, "Mine", "a ball.obj"] and done["gl_error"] == "GL_NO_ERROR"
    assert done["wrong"] == 5 * [["error", True, True]], "one line each, and all stays as it was"


@pytest.fixture(scope="module")
def curtain(display):
    return drive(display, "curtain")


def test_a_curtain_is_renders_to_the_bit_and_opens_again(curtain):
    assert curtain["frames"] == [3, True] and curtain["as_render"] and curtain["untouched"]
    assert curtain["reopened"] == [True, True] and curtain["scene_reopened"]


def test_a_curtain_is_compared_with_itself_otherwise_woven_and_drawn(curtain):
    """A stays; B is traced with its own fabric and depth, or blended, to the bit; swapped, A has them."""
    assert curtain["B"] == [True, True, True, [1.0, 1.0]] and curtain["swapped"] == [1, "Lace", 1, 3]


def test_wind_and_cloth_change_while_the_curtain_moves(curtain):
    assert curtain["live"] == [3, True, 0.1] and curtain["openness"] == [3, 0.8]
    assert curtain["anew"] == [0, False] and curtain["undone"] == 1.8
    assert curtain["linen"] == [True, True] and curtain["bad_room"] and curtain["gl_error"] == "GL_NO_ERROR"


def test_every_accelerator_and_its_tree(curtain):
    assert curtain["accelerators"] == [True, True, True]
    assert curtain["brute_has_no_tree"] == 0 and curtain["tree"] == [True, True]
    assert curtain["reloaded"] == ["shaders reloaded", True]


@pytest.fixture(scope="module")
def walked(display, tmp_path_factory):
    return drive(
        display, str(tmp_path_factory.mktemp("walk")), "200x720", script=ROOT / "tests" / "window" / "window_walk.py"
    )


def test_panels_are_driven_by_the_mouse(walked):
    assert walked["orbit"] and walked["orbit_seen"] > 0.05
    assert walked["slider"] > 6.0 and walked["slider_seen"] > 0.01 and walked["undo"]
    assert walked["curve"] != [-35.0, -35.0, 35.0, 35.0] and walked["curve_seen"] > 0.01
    assert walked["split"] == ["split", "Linen plain"] and walked["split_at"] < 0.45
    assert walked["opened"] and walked["bad"] == ["error", True, True] and len(walked["cloth_messages"]) == 1


def test_the_curtain_plays_and_its_tree_follows(walked):
    assert walked["played"] and walked["played_seen"] > 0.02 and walked["still_playing"] and walked["paused"]
    assert walked["wind"] != 0.5 and walked["openness"] != 0.35
    assert all(walked["tree"]) and walked["level"] == [8, True] and walked["tree_closed"]
    assert walked["accelerator"] == "lbvh" and walked["accelerator_undone"] == "kdtree"
    assert walked["cloth_again"] == "cloth" and walked["gl_error"] == "GL_NO_ERROR" and walked["messages"] == []


def test_random_actions_leave_no_error_and_no_objects(display):
    result = drive(display, "monkey", "40")
    begin, *_, end = result["objects"]
    assert all(end[kind] <= begin[kind] + 8 for kind in begin), result


def test_without_a_display_one_line_names_render():
    env = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    run = subprocess.run([sys.executable, "-m", "glcloth", "view"], env=env, cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 3 and run.stderr.count("\n") == 1 and "glcloth render" in run.stderr


@pytest.fixture(scope="module")
def woven(display, tmp_path_factory):
    folder = str(tmp_path_factory.mktemp("weave"))
    return drive(display, folder, script=ROOT / "tests" / "window" / "window_weave.py")


def test_the_draft_is_drawn_on_by_the_mouse(woven):
    """A click toggles a crossing, drags thread, tie and tread; each is one step of undo, and the near view follows."""
    assert woven["clicked"] == [[0, 0], [0, 1]] and woven["undone"] == [[[1, 0], [0, 1]], True]
    assert woven["near_is_woven"] > 0.1 and woven["near_changed"] > 0.02 and woven["same_again"]
    assert woven["goes_on"] == [[0, 1, 0, 1, 0], "plain, edited", [0, 1, 0, 1, 0, 1], "plain"], (
        "repeats are the same cloth"
    )
    assert woven["twill"] and woven["threaded"] and woven["drag_is_one_step"] and woven["trodden"]
    assert woven["tied"] == [True, [False, False]] and woven["crimp"]


def test_threads_are_painted_on_the_strips(woven):
    """A drag of the pen colours the threads it passes in one step of undo; the right button takes up a colour."""
    assert woven["painted"] == [[False, True, True, False], True, True] and woven["taken_up"]


def test_drafts_are_saved_loaded_and_dropped(woven):
    assert woven["saved"] and woven["fabric_saved"] and woven["loaded"]
    assert woven["dropped"] == [True, True] and woven["bad"] == [True, True, True] and woven["errors"] == 1


def test_threads_are_counted_near_by_and_any_fabric_gets_a_weave(woven):
    assert woven["counter"][0] > 200 and woven["counter"][1] and woven["near_by"][0]
    assert woven["given"] == ["yarns", True] and woven["gl_error"] == "GL_NO_ERROR"
