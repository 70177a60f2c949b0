"""The window's state without a window: history, generated controls, the curve's edits, the eye, sharing."""

import contextlib
import os
import shlex
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from glcloth import cli
from glcloth.cli.options import scene_of
from glcloth.errors import InputError
from glcloth.fabric import Fabric, Yarn, load_fabric, save_fabric
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh_files import load_mesh
from glcloth.image import write_image
from glcloth.methods.registry import METHODS
from glcloth.picture.cloths import Cloth
from glcloth.picture.frame import Frame
from glcloth.scene import CurtainParameters, Scene, View, load_scene, save_scene
from glcloth.window import curve, files, messages, orbit, refine, sharing, state
from glcloth.window.controls import METHOD_FIELDS, controls
from glcloth.window.slices import Slices
from glcloth.window.state import Session


def test_a_drag_is_one_step_of_undo_and_redo_brings_it_back():
    session = Session(Scene())
    before = session.document
    for width in (6.0, 7.0, 8.0):
        session.edit_yarn(0, "drag", gamma_s_deg=width)
    session.end_gesture()
    session.edit_yarn(0, "drag", gamma_s_deg=9.0)
    assert session.fabric.yarn[0].gamma_s_deg == 9.0
    session.undo()
    assert session.fabric.yarn[0].gamma_s_deg == 8.0
    session.undo()
    assert session.document == before and not session.can_undo
    session.redo()
    assert session.fabric.yarn[0].gamma_s_deg == 8.0
    session.edit_scene(exposure=1.0)
    assert not session.can_redo and not session.redo()


def test_moving_the_eye_is_no_edit_and_undo_leaves_it():
    session = Session(Scene())
    session.edit_scene(exposure=1.0)
    session.look(View(eye=(1, 2, 3)))
    session.move(size=(100, 50))
    session.undo()
    assert session.scene.exposure == 0.0 and session.scene.camera.eye == (1, 2, 3) and session.scene.size == (100, 50)
    assert not session.can_undo


def test_a_wrong_edit_raises_and_changes_nothing():
    session = Session(Scene())
    before = session.document
    for wrong in (
        lambda: session.edit_yarn(1, eta=0.5),
        lambda: session.edit_yarn(0, area=0.9),  # with yarn 2 above 1
        lambda: session.edit_scene(exposure=99.0),
        lambda: session.choose_fabric("no_such_fabric"),
        lambda: session.open(Scene(fabric="nothing.toml")),
    ):
        with pytest.raises(InputError):
            wrong()
        assert session.document is before and not session.can_undo


def test_each_part_has_a_fabric_that_is_edited_reset_and_undone_by_itself():
    session = Session(Scene(mesh="skirt", fabric="linen", fabrics={"Waistband": "velvet"}))
    assert session.part == "" and session.fabric.name == load_fabric("linen").name
    session.choose_part("Waistband")
    session.edit_yarn(0, gamma_s_deg=33.0)
    assert session.scene.fabric == "linen" and session.scene.fabrics["Waistband"].yarn[0].gamma_s_deg == 33.0
    session.reset_fabric()
    assert session.scene.fabrics == {"Waistband": "velvet"}
    session.choose_fabric("taffeta")
    assert session.scene.fabrics == {"Waistband": "taffeta"} and session.origin == load_fabric("taffeta")
    # A part without a fabric of its own begins with that of all others.
    session.choose_part("Skirt")
    assert session.scene.fabrics == {"Waistband": "taffeta", "Skirt": "linen"}
    session.undo()
    assert session.part == "" and session.scene.fabrics == {"Waistband": "taffeta"}
    session.choose_fabric("voile")
    assert session.scene.fabric == "voile" and session.scene.fabrics == {"Waistband": "taffeta"}
    session.open(Scene(fabrics={"Waistband": "denim_raw"}))
    session.choose_part("Waistband")
    assert session.chosen == "denim_raw"


def test_resetting_returns_to_the_origin_and_its_name():
    session = Session(Scene(fabric="linen"))
    session.edit_fabric(session.fabric.changed(sigma_deg=33.0))
    assert isinstance(session.scene.fabric, Fabric)
    session.reset_fabric()
    assert session.scene.fabric == "linen"
    session.edit_fabric(session.fabric.changed(sigma_deg=33.0))
    session.choose_fabric("velvet")
    assert session.origin == load_fabric("velvet")
    session.undo()
    assert session.fabric.sigma_deg == 33.0 and session.origin == load_fabric("linen")


def test_an_edit_keeps_what_it_does_not_touch_identical():
    session = Session(Scene())
    session.edit_yarn(0, gamma_s_deg=6.0)
    fabric = session.scene.fabric
    session.edit_scene(exposure=1.0)
    assert session.scene.fabric is fabric


def test_b_of_the_curtain_has_fabric_and_rays_of_its_own():
    session = Session(Scene(fabric="lace", depth=2, curtain=CurtainParameters()))
    session.compare("split")
    assert session.document.sides() == [session.curtain, session.curtain]
    session.edit_other(accelerator="lbvh", depth=5)
    session.hang(wind=2.0)
    session.move(size=(80, 60))
    a, b = session.document.sides()
    assert (a.accelerator, a.depth, b.accelerator, b.depth) == ("kdtree", 2, "lbvh", 5)
    assert b.curtain == a.curtain and b.size == (80, 60), "the same curtain"
    session.edit_other(fabric="linen")
    assert session.document.sides()[1].fabric.transmission is not None, "a sheer's"
    session.swap()
    assert session.curtain.depth == 5 and session.fabric.name == "Linen plain"
    assert session.document.sides()[1].depth == 2 and session.document.sides()[1].fabric == "lace"
    session.choose_mode("cloth")
    assert session.document.other is None and session.document.sides() == [session.scene]


def test_undo_keeps_so_many_steps_and_no_more(monkeypatch):
    monkeypatch.setattr(state, "MOST_STEPS", 3)
    session = Session(Scene())
    for n in range(6):
        session.edit_scene(exposure=float(n + 1))
    while session.undo():
        pass
    assert session.scene.exposure == 3.0


def test_a_rejected_edit_leaves_no_trace():
    session = Session(Scene())
    before = session.document
    session.edit_scene(env="broken.hdr")
    session.reject()
    assert session.document == before and not session.can_undo and not session.can_redo


def test_comparing_shares_the_view_and_swapping_twice_is_nothing():
    session = Session(Scene())
    session.compare("split")
    session.edit_other(method="paper")
    session.edit_scene(env_rotate=30.0)
    a, b = session.document.sides()
    assert (a.method, b.method, b.env_rotate) == ("direct", "paper", 30.0)
    session.swap()
    assert [s.method for s in session.document.sides()] == ["paper", "direct"]
    session.swap()
    assert session.document.sides() == [a, b]


@pytest.mark.parametrize("model", [Yarn, Fabric], ids=["yarn", "fabric"])
def test_every_parameter_has_a_control_whose_ends_are_valid(model):
    fabric = load_fabric("silk_crepe_de_chine")
    value = fabric.yarn[0].changed(area=0.0) if model is Yarn else fabric
    found = controls(model)
    assert {c.name for c in found} >= set(model.model_fields) - {"yarn", "transmission", "weave", "shares"}
    for control in found:
        if control.kind not in ("float", "int", "color"):
            continue
        assert control.help, control.name
        for end in (control.low, control.high):
            new = (end,) * 3 if control.kind == "color" else end
            assert getattr(value.changed(**{control.name: new}), control.name) == new
        step = 1e-2 * (control.high - control.low)
        for outside in (control.low - step, control.high + step):
            with pytest.raises(InputError):
                value.changed(**{control.name: (outside,) * 3 if control.kind == "color" else outside})


def test_every_method_shows_its_own_settings():
    assert set(METHODS) <= set(METHOD_FIELDS)
    assert all(len(controls(Scene, names)) == len(names) for names in METHOD_FIELDS.values())


def test_dragging_a_point_keeps_the_curves_length_and_the_ends_hold():
    yarn = load_fabric("silk_crepe_de_chine").yarn[0]
    moved = yarn.changed(**curve.move(yarn, 1, 1.5, 12.34))
    assert moved.curve_angles_deg[1] == 12.3 and moved.curve_lengths == (1.5, 0.5, 1.0)
    far = yarn.changed(**curve.move(yarn, 1, 99.0, 500.0))
    assert far.curve_angles_deg[1] == 90.0 and far.curve_lengths == (2.0, 0.0, 1.0)
    last = yarn.changed(**curve.move(yarn, 3, 3.5, 35.0))
    assert last.curve_lengths == (1.0, 1.0, 1.5)
    flat = load_fabric("linen").yarn[0]
    while (changes := curve.remove(flat)) and len(flat.curve_angles_deg or ()) > 2:
        flat = flat.changed(**changes)
    assert curve.remove(flat) == {} and sum(flat.changed(**curve.set_length(flat, 0, -1)).curve_lengths) > 0


def test_a_point_added_leaves_the_tangents_and_tangents_become_their_curve():
    yarn = load_fabric("silk_crepe_de_chine").yarn[0]
    more = yarn.changed(**curve.add(yarn))
    assert len(more.curve_angles_deg) == 5
    np.testing.assert_allclose(more.tilts_deg, yarn.tilts_deg, atol=1e-6)
    free = yarn.changed(curve_angles_deg=None, curve_lengths=None, samples=None, tangents_deg=(-30.0, 5.0, 50.0))
    assert free.changed(**curve.to_curve(free)).tilts_deg == free.tilts_deg
    x, y = curve.samples(yarn)
    assert x[0] == 0.0 and x[-1] == 3.0 and tuple(y) == yarn.tilts_deg


def test_orbiting_keeps_the_distance_and_a_full_turn_returns():
    camera = Camera((1.0, 2.0, 3.0), (0.2, 0.1, 0.0))
    arm = np.linalg.norm(np.subtract(camera.eye, camera.target))
    turned = camera
    for _ in range(36):
        turned = orbit.orbit(turned, 10.0, 0.0)
        assert np.linalg.norm(np.subtract(turned.eye, turned.target)) == pytest.approx(arm, rel=1e-12)
    np.testing.assert_allclose(turned.eye, camera.eye, atol=1e-9)
    # Dragging far up stops short of the pole: the camera stays valid.
    top = orbit.orbit(camera, 0.0, 1e4)
    assert np.subtract(top.eye, top.target)[1] / arm == pytest.approx(np.sin(np.radians(89.0)))


def test_panning_by_one_moves_the_target_across_the_picture():
    camera = Camera((0.0, 0.0, 4.0), (0.0, 0.0, 0.0), fov_deg=60.0)
    moved = orbit.pan(camera, 0.0, 1.0)
    clip = camera.clip_from_world((100, 100), 0.1, 10.0) @ [*moved.target, 1.0]
    assert clip[1] / clip[3] == pytest.approx(2.0)  # from the centre, 0, by a height, -1..1


def test_framing_holds_the_mesh_and_keeps_the_direction():
    mesh = load_mesh("sphere")
    camera = orbit.frame(Camera((9.0, 1.0, 2.0), (3.0, 1.0, 0.0)), mesh, 1.5)
    clip = np.c_[mesh.positions, np.ones(len(mesh.positions))] @ camera.clip_from_world((150, 100), 0.01, 100.0).T
    inside = np.abs(clip[:, :2] / clip[:, 3:])
    assert inside.max() <= 1.0 + 1e-6 and inside.max() > 0.7
    np.testing.assert_allclose(camera.axes[2], Camera((9.0, 1.0, 2.0), (3.0, 1.0, 0.0)).axes[2], atol=1e-12)


def test_a_saved_session_reads_back_equal(tmp_path):
    session = Session(Scene())
    session.edit_yarn(0, gamma_s_deg=7.3, albedo=(0.1, 0.2, 0.3))
    session.edit_yarn(1, **curve.move(session.fabric.yarn[1], 1, 0.4, 11.0))
    session.look(View(eye=(0.1, 0.2, 0.3), target=(0, 0, 0)))
    save_scene(tmp_path / "s.toml", session.scene)
    assert load_scene(tmp_path / "s.toml") == session.scene
    for name in ("p.exr", "p.png"):
        write_image(tmp_path / name, np.ones((2, 2, 3), "f4"), {"scene": session.scene.model_dump(mode="json")})
        assert load_scene(tmp_path / name) == session.scene
    save_fabric(tmp_path / "f.toml", session.fabric)
    assert load_fabric(tmp_path / "f.toml") == session.fabric


def test_python_and_shell_copies_hold_the_same_scene(tmp_path):
    session = Session(Scene())
    session.edit_yarn(0, gamma_s_deg=7.3)
    session.edit_scene(env_rotate=-20.0, background=False, method="paper")
    session.move(size=(64, 48))
    made = {}
    code = sharing.as_python(session.scene)
    exec(compile(code.split("with glcloth")[0], "copy", "exec"), made)
    assert made["scene"] == session.scene
    compile(code, "copy", "exec")
    # An edited fabric travels as a file inside the command.
    text = sharing.as_command(session.scene)
    script = text.replace("glcloth render scene.toml -o picture.png", "true")
    subprocess.run(["bash", "-ec", script], cwd=tmp_path, check=True)
    assert load_scene(tmp_path / "scene.toml") == session.scene
    session.reset_fabric()
    line = sharing.as_command(session.scene)
    assert line.count("\n") == 1 and "--env-rotate=-20.0" in line
    assert "--no-background" in line and "--size 64x48" in line
    # A print and openings travel as options that the command line reads back; those of parts as a file.
    for scene in (
        Scene(print={"file": "my roses.png", "repeat": 0.3, "unit": "m", "space": "linear"}, opacity="holes.png"),
        Scene(prints={"Skirt": {"file": "roses.png", "repeat": 0.3}}),
    ):
        text = sharing.as_command(scene)
        if scene.print is not None:
            _, bound, _ = cli.app.parse_args(shlex.split(text)[1:], exit_on_error=False, print_error=False)
            assert scene_of(None, bound.arguments["options"]) == scene
        else:
            (tmp_path / "parts.toml").write_text("\n".join(text.splitlines()[1:-2]))
            assert load_scene(tmp_path / "parts.toml").prints["Skirt"].repeat == 0.3


def test_files_are_known_by_what_they_are(tmp_path):
    session = Session(Scene(fabric="linen"))
    save_fabric(tmp_path / "f.toml", session.fabric)
    save_scene(tmp_path / "s.toml", session.scene)
    write_image(tmp_path / "map.exr", np.ones((2, 4, 3), "f4"))
    write_image(tmp_path / "ours.exr", np.ones((2, 4, 3), "f4"), {"scene": {}})
    for name in ("m.obj", "m.glb", "m.ply", "m.stl", "m.off", "e.hdr"):
        (tmp_path / name).write_bytes(b"x")
    kinds = {p.name: sharing.kind_of(p) for p in tmp_path.iterdir()}
    assert kinds == {
        "f.toml": "fabric", "s.toml": "scene", "map.exr": "env", "ours.exr": "scene",
        "m.obj": "mesh", "m.glb": "mesh", "m.ply": "mesh", "m.stl": "mesh", "m.off": "mesh", "e.hdr": "env",
    }  # fmt: skip
    (tmp_path / "bad.toml").write_text("= 1")
    (tmp_path / "a.txt").write_text("a")
    for name in ("bad.toml", "a.txt", "missing.obj"):
        with pytest.raises(InputError, match=name):
            sharing.kind_of(tmp_path / name)


def random_edit(session, rng):
    """One of all edits, with values in and a little out of range."""
    fields = [c for c in controls(Yarn) if c.kind in ("float", "color")]
    control = fields[rng.integers(len(fields))]
    index = int(rng.integers(2))
    yarn = session.fabric.yarn[index]
    value = rng.uniform(control.low - 0.1, control.high + 0.1, 3 if control.kind == "color" else None)
    value = tuple(value) if control.kind == "color" else float(value)
    point = int(rng.integers(len(curve.points(yarn)[1])))
    actions = (
        lambda: session.edit_yarn(index, control.name, **{control.name: value}),
        lambda: session.edit_yarn(index, "curve", **curve.move(yarn, point, *rng.uniform(-9, 99, 2))),
        lambda: session.edit_yarn(index, **curve.add(yarn)),
        lambda: session.edit_yarn(index, **curve.remove(yarn)),
        session.undo,
        session.redo,
        session.end_gesture,
        session.swap,
        lambda: session.compare(("off", "split", "difference")[rng.integers(3)]),
        lambda: session.choose_fabric(("linen", "velvet")[rng.integers(2)]),
    )
    actions[rng.integers(len(actions))]()


def test_names_that_nobody_can_have_are_messages(tmp_path, monkeypatch):
    """Whatever is typed, dropped or in the way: the window says so and stays."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ring.toml").symlink_to("ring.toml")
    os.mkfifo(tmp_path / "pipe.wif")
    (tmp_path / "dir.png").mkdir()
    clock = SimpleNamespace(wake=lambda: None)
    said = messages.Messages(clock)
    session = Session(Scene(mesh="sphere"))
    actions = SimpleNamespace(attempt=said.attempt, note=said.note, session=session, complete=False)
    opener = files.Files(actions, clock)
    names = ["", "\0", "a\0b", 300 * "x", "~nobody/x", "\ud800", "ring", "pipe", "dir", "nowhere/x", "/proc/x"]
    ways = [
        (opener.save_scene, ".toml"),
        (opener.save_draft, ".wif"),
        (opener.load_draft, ".wif"),
        (opener.open, ".png"),
    ]
    ways += [(opener.save_picture, ".png"), (opener.choose_object, ".obj"), (opener.save_fabric, ".toml")]
    for way, suffix in ways:
        for name in names:
            said.lines.clear()
            way(name + suffix)
            assert said.lines or (tmp_path / (name + suffix)).is_file(), name  # the draft that was just saved
            assert all(text.isprintable() and len(text) <= 300 for _, text in said.lines), name
    assert (tmp_path / "ring.toml").is_symlink(), "not replaced"
    session.choose_fabric("linen")
    opener.save_draft("a\nb.wif")
    assert (tmp_path / "a\nb.wif").is_file() and said.lines[-1] == ("note", "wrote a b.wif")


def test_thousand_random_edits_keep_the_state_valid_and_undo_to_the_start():
    rng = np.random.default_rng(1)
    session = Session(Scene())
    start = session.document
    for _ in range(1000):
        with contextlib.suppress(InputError):
            random_edit(session, rng)
        assert Fabric.model_validate(session.fabric.model_dump()) == session.fabric
        assert len(session.document.sides()) in (1, 2)
    while session.undo():
        pass
    assert session.document == start


def test_the_state_needs_no_display():
    code = (
        "import sys, glcloth.window.state, glcloth.window.controls, glcloth.window.curve, glcloth.window.sharing, "
        "glcloth.window.orbit; sys.exit('glfw' in sys.modules or 'imgui_bundle' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def test_the_answer_to_an_edit_is_shown_before_anything_else_is_drawn():
    """Without a limit of time `work` goes on to the end, but for the small picture, after which it returns at once."""

    class Plan(Slices):
        drawn = ()

        def _all(self):
            self._refining = False
            for slice_, seen in (("placed", False), ("answer", True), ("half", True), ("full", True)):
                self.drawn = (*self.drawn, slice_)
                yield seen
                self._refining = "answer" in self.drawn

    plan = Plan()
    plan._begin(1)
    assert plan.work(1e9) and plan.drawn == ("placed", "answer")
    assert plan.work(1e9) and plan.drawn[2:] == ("half", "full") and plan.idle


def test_watched_files_are_read_again_whichever_part_is_chosen(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("base", "part"):
        save_fabric(f"{name}.toml", load_fabric("linen").changed(name=name))
    for name in ("roses.png", "holes.png", "two.obj"):
        (tmp_path / name).write_text("")
    maps = {"print": "roses.png", "opacities": {"b": "holes.png"}}
    session = Session(Scene(fabric="base.toml", fabrics={"b": "part.toml"}, mesh="two.obj", **maps))
    session.choose_part("b")
    session.edit_yarn(0, gamma_s_deg=7.0)
    seen = []
    actions = SimpleNamespace(session=session, attempt=lambda act, *what: act(*what))
    actions.look_again = lambda anew=False: seen.append(anew)
    watcher = files.Files(actions, SimpleNamespace(every=lambda *_: True), watch=True)
    watcher.watch()
    assert not seen

    def write(name, **changes):
        if changes:
            save_fabric(name, load_fabric(name).changed(**changes))
        os.utime(name, (1, 1))
        watcher.watch()
        found = seen.copy()
        seen.clear()
        return found

    for name in ("roses.png", "holes.png", "two.obj"):
        assert write(name) == [False]
    assert True in write("base.toml", sigma_deg=11.0)
    assert session.resolve(session.scene.fabric).sigma_deg == 11.0 and session.fabric.yarn[0].gamma_s_deg == 7.0
    assert True in write("part.toml", sigma_deg=12.0)
    assert session.fabric == load_fabric("part.toml") and session.can_undo


def test_another_print_is_another_picture():
    """The scene is equal where its file has changed."""
    cloth = Cloth(load_mesh("plane"), load_fabric("linen"))
    frame = Frame(Scene(), (cloth,), None, None, None, None)
    assert refine._same_light(frame, frame)
    for change in ({"print": object()}, {"opacity": object()}):
        assert not refine._same_light(replace(frame, cloths=(replace(cloth, **change),)), frame)


def test_another_mesh_has_no_map_of_a_part_of_the_last_one(tmp_path):
    """A fabric mask would ask for the colours that go with the fabrics of parts."""
    masked = {
        "fabrics": {"#f00": "velvet"},
        "fabric_mask": "m.png",
        "fabric_masks": {"a": "n.png"},
        "prints": {"a": "p.png"},
    }
    session = Session(Scene(fabric="linen", **masked))
    opener = files.Files(SimpleNamespace(session=session), SimpleNamespace(every=lambda *_: True), watch=False)
    mesh = tmp_path / "two.obj"
    mesh.write_text("")
    opener._open(str(mesh))
    assert session.scene == Scene(fabric="linen", mesh=str(mesh))
