"""Runs the window in this process and prints what it did as JSON; real events come from xdotool.

DISPLAY=:1 python tests/window/window_driver.py events          # orbit, wheel, keys, panels, files
DISPLAY=:1 python tests/window/window_driver.py curtain         # the curtain: frames, live changes, files, trees
DISPLAY=:1 python tests/window/window_driver.py drops           # files dropped on the window
DISPLAY=:1 python .../window_driver.py rates           # how often input is heard, how long pictures take (cloth ground curtain)
DISPLAY=:1 python tests/window/window_driver.py monkey 1000     # random actions: memory and GL objects before and after
"""

import contextlib
import ctypes
import gc
import itertools
import json
import resource
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path

import glfw
import numpy as np
from imgui_bundle import imgui
from OpenGL import GL
from xdnd import Source

from glcloth.curtain.show import CurtainShow
from glcloth.errors import InputError
from glcloth.fabric import Transmission, load_fabric, save_fabric
from glcloth.geometry.mesh_files import load_mesh, save_mesh
from glcloth.image import write_image
from glcloth.light.lights import Lights, SphericalGaussians
from glcloth.light.lights_file import save_lights
from glcloth.methods.registry import METHODS
from glcloth.picture.renderer import Renderer
from glcloth.scene import CurtainParameters, Scene, load_scene
from glcloth.window import curve, orbit, sharing
from glcloth.window.app import App
from glcloth.window.controls import controls, curtain_controls

HANG = 600.0  # CPU seconds of waiting, after which it hangs


def until(app, done, what="what was waited for"):
    """Step until `done()`; gives up after CPU seconds of this process, which no other program's load counts into."""
    begin = time.process_time()
    while not done():
        if time.process_time() - begin > HANG:
            raise TimeoutError(f"{what} does not come")
        glfw.post_empty_event()
        app.step()


def settle(app):
    """Step until the picture is complete."""
    app.clock.heard()
    steps = itertools.count()
    until(
        app,
        lambda: next(steps) > 3 and not app.drawing.busy and not app.drawing.pending and app.drawing.shows_something,
        "the picture",
    )


def during(app, *commands, wait=True):
    """Step while xdotool sends events, and until all of them are taken; then, unless told not to `wait`, settle."""

    def send():
        for command in commands:
            subprocess.run(["xdotool", *map(str, command)], check=True)
            time.sleep(0.03)

    thread = threading.Thread(target=send)
    thread.start()
    until(app, lambda: not thread.is_alive(), "xdotool's end")
    glfw.get_cursor_pos(app.host.window)  # asks the server, which answers after the events that it has sent
    app.clock.heard()
    for _ in range(2):
        app.step()
    # imgui takes them one after the other, some only at the next picture.
    queue = imgui.get_current_context().input_events_queue
    until(app, lambda: queue.size() == 0, "the last event")
    app.clock.heard()
    app.step()
    if wait:
        settle(app)


def distance(app):
    camera = app.actions.camera
    return float(np.linalg.norm(np.subtract(camera.eye, camera.target)))


def events(folder):
    """What the test looks at."""
    app = App(Scene(size=(120, 96), mesh="sphere", env="sky"))
    glfw.set_window_pos(app.host.window, 0, 0)
    settle(app)
    out = {"follow": app.layout.follow, "size": app.session.scene.size, "screen": list(app.actions.screen().shape)}
    first, scene = app.actions.picture(), app.session.scene
    home, far = app.actions.camera, distance(app)
    during(app, ["mousemove", 60, 50], ["mousedown", 1], ["mousemove", 70, 50], ["mousemove", 80, 55], ["mouseup", 1])
    out["orbited"] = app.actions.camera.eye != home.eye and abs(distance(app) - far) < 1e-6
    during(app, ["click", "--repeat", 3, 4])
    out["zoomed"] = distance(app) < 0.8 * far
    during(app, ["key", "Home"])
    out["home"] = bool(app.actions.camera == home)
    out["home_picture"] = bool(np.array_equal(app.actions.picture(), first))
    during(app, ["mousemove", 60, 50], ["mousedown", 3], ["mousemove", 75, 50], ["mousemove", 90, 50], ["mouseup", 3])
    out["turned"] = app.session.scene.env_rotate
    during(app, ["key", "ctrl+z"])
    out["undone"] = app.session.scene.env_rotate
    during(app, ["key", "ctrl+shift+z"])
    out["redone"] = app.session.scene.env_rotate
    app.session.undo()
    settle(app)
    # A bookmark: kept, gone to, and a step of undo.
    during(app, ["key", "ctrl+2"])
    app.actions.zoom(1.3)
    away = distance(app)
    during(app, ["key", "2"])
    kept = app.session.scene.bookmark("2")
    out["bookmark"] = [away > 1.05 * far, bool(app.actions.camera == home), kept is not None and kept.eye == home.eye]
    app.actions.choose_view("side")
    settle(app)
    out["view"] = app.actions.camera.axes[2].round(6).tolist()
    app.actions.look(replace(app.actions.camera, ortho=1.5, aperture=0.1, focus=2.0))
    settle(app)
    out["parallel"] = app.actions.camera.ortho
    during(app, ["key", "ctrl+z"], ["key", "Home"])
    out["bookmark"].append(app.session.scene.bookmarks == ())
    # Files: a bad one leaves everything as it was.
    (folder / "bad.hdr").write_bytes(b"nothing")
    before = app.session.document
    app.files.open(str(folder / "bad.hdr"))
    settle(app)
    out["bad_file"] = app.messages.lines[-1][1]
    out["kept"] = app.session.document == before and bool(np.array_equal(app.actions.picture(), first))
    # Ten parameters, saved and opened again.
    app.session.edit_yarn(0, gamma_s_deg=7.5, albedo=(0.3, 0.1, 0.2), eta=1.5, k_d=0.3, gamma_v_deg=14.0)
    app.session.edit_yarn(1, **curve.move(app.session.fabric.yarn[1], 1, 0.7, 22.0))
    app.session.edit_fabric(app.session.fabric.changed(sigma_deg=25.0, normalization="paper"))
    app.session.edit_scene(env_rotate=33.0, spp=2, exposure=0.5)
    app.actions.look(orbit.orbit(app.actions.camera, 20.0, 10.0))
    settle(app)
    edited, edited_scene = app.actions.picture(), app.session.scene
    for name in ("p.exr", "p.png"):
        app.files.save_picture(str(folder / name))
    app.files.save_scene(str(folder / "s.toml"))
    app.files.save_picture(str(folder / "w.png"), panels=True)
    settle(app)
    out["messages"] = [kind for kind, _ in app.messages.lines[1:]]
    same = []
    for name in ("s.toml", "p.exr", "p.png"):
        app.session.open(Scene(size=(120, 96)))
        app.files.open(str(folder / name))
        settle(app)
        same.append(bool(np.array_equal(app.actions.picture(), edited)))
    out["reopened"] = same
    out["parts"] = parts(app, folder)
    app.session.compare("split")
    app.session.edit_other(method="paper", fabric="linen")
    app.session.compare("difference")
    settle(app)
    out["sides"] = [side.share for side in app.drawing.refiner.sides]
    out["gl_error"] = app.host.ctx.error
    app.close()
    with Renderer() as renderer:
        out["as_render"] = [
            bool(np.array_equal(renderer.render(scene), first)),
            bool(np.array_equal(renderer.render(edited_scene), edited)),
            bool(np.array_equal(renderer.render(load_scene(folder / "p.png")), edited)),
        ]
    return out


def parts(app, folder):
    """A scene of two parts: which ones the window knows, and what of the picture an edit of one changes."""
    (folder / "two.obj").write_text(
        "v -1 -1 0\nv 0 -1 0\nv 0 1 0\nv -1 1 0\nv 1 -1 0\nv 1 1 0\nusemtl Left\nf 1 2 3 4\nusemtl Right\nf 2 5 6 3\n"
    )
    (folder / "two.toml").write_text(
        'mesh = "two.obj"\nfabric = "linen"\nsize = [60, 48]\nshadows = "off"\n[fabrics]\nRight = "velvet"\n'
        "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\northo = 2.0\n"
    )
    app.files.open(str(folder / "two.toml"))
    settle(app)
    before = app.actions.picture()
    app.session.choose_part("Right")
    app.session.edit_yarn(0, albedo=(0.9, 0.1, 0.1))
    settle(app)
    changed = np.abs(app.actions.picture() - before).max(-1) > 0
    left, right = changed[4:44, 12:28], changed[4:44, 32:48]
    app.session.undo()
    app.session.choose_part("")
    return [app.actions.parts, bool(left.any()), bool(right.all()), picks(app)]


def picks(app):
    """Clicks on the parts and beside them: which part is edited after each; and which part a fabric goes to."""
    for line in list(app.messages.lines):  # in so small a window they lie over the picture
        app.messages.close(line)
    settle(app)
    left, bottom, width, height = app.layout.rectangle()
    top = int(imgui.get_io().display_size.y) - bottom - height

    def click(x, y):
        during(app, ["mousemove", left + int(x * width), top + int(y * height)], ["mousedown", 1], ["mouseup", 1])
        return app.session.part

    click(0.7, 0.5)
    steps = len(app.session._undo)
    out = [click(0.7, 0.5), click(0.3, 0.5), click(0.98, 0.5), len(app.session._undo) - steps]
    app.session.choose_fabric("velvet_ruby")
    settle(app)
    out.append(dict(app.session.scene.fabrics))
    app.session.undo()
    out.append(dict(app.session.scene.fabrics))
    app.session.pick_part("")
    return out


def drop(app, *paths):
    """Drop files on the window, by the protocol of X11's desktops; whether the window took them."""
    x, y = glfw.get_window_pos(app.host.window)
    source = Source(glfw.get_x11_window(app.host.window), paths, x + 40, y + 40)
    source.start()
    until(app, lambda: not source.is_alive(), "the end of the drop")
    settle(app)
    return source.accepted


def drops(folder):
    """Every kind of file dropped, and some that are none."""
    app = App(Scene(size=(120, 96), mesh="plane", env="studio"))
    session, out = app.session, {}
    settle(app)
    first = app.session.scene
    picture, fabric, mesh, light, lights = (
        folder / name for name in ("ours é.png", "mine 100%.toml", "a ball.obj", "light #1.hdr", "few.json")
    )
    app.files.save_picture(str(picture))
    save_fabric(fabric, load_fabric("linen").changed(name="Mine"))
    save_mesh(mesh, load_mesh("sphere"))
    light.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes([128, 128, 128, 129]) * 32)
    save_lights(lights, Lights(SphericalGaussians(((0.0, 1.0, 0.0),), (3.0,), ((1.0, 1.0, 1.0),))))
    out["fabric"] = drop(app, fabric), session.fabric.name
    out["mesh"] = (
        drop(app, mesh),
        app.drawing.refiner.frames[0].mesh.positions.shape == load_mesh("sphere").positions.shape,
    )
    out["light"] = drop(app, light), float(app.drawing.refiner.frames[0].environment.radiance.max())
    out["lights"] = drop(app, lights), len(app.drawing.refiner.frames[0].lights.gaussians)
    before = session.document
    (folder / "text.txt").write_text("nothing")
    (folder / "bad.obj").write_text("nothing")
    write_image(folder / "other.png", np.zeros((4, 4, 3), "f4"))
    out["wrong"] = []
    for name in ("text.txt", "bad.obj", "other.png", "gone.exr", ""):
        drop(app, folder / name)
        kind, text = app.messages.lines[-1]
        out["wrong"].append([kind, (folder / name).name in text and "\n" not in text, session.document == before])
    out["picture"] = drop(app, picture), session.scene.model_copy(update={"camera": first.camera}) == first
    out["two"] = drop(app, fabric, mesh), session.fabric.name, Path(session.scene.mesh).name
    out["gl_error"] = app.host.ctx.error
    app.close()
    return out


def seen(app, number):
    """The picture of one side: float32 [H, W, 3], top row first."""
    texture = app.drawing.drawer.sides[number].texture
    return np.frombuffer(texture.read(), "f4").reshape(texture.height, texture.width, 4)[::-1, :, :3]


def traced_as(show, scene):
    """The picture of a curtain as it hangs, with the fabric and the rays of another scene."""
    show.build()
    return show.tracer.trace(show.lit(show.shot(scene), scene))


def curtain(folder):
    """Played, changed on the way, saved and opened again; shaders reloaded; side by side with `render`."""
    small = CurtainParameters(quads=(48, 12), pleats=4, settle=0.2)
    scene = Scene(size=(96, 64), curtain=small, spp=2)
    app = App(scene)
    out = {}
    settle(app)
    first = app.actions.picture()
    app.drawing.player.step(3)
    settle(app)
    third = app.actions.picture()
    out["frames"] = [app.actions.frame, bool(np.abs(third - first).max() > 0.01)]
    for name in ("c.exr", "c.png"):
        app.files.save_picture(str(folder / name))
    app.files.save_scene(str(folder / "c.toml"))
    settle(app)
    out["untouched"] = "otherwise" not in app.messages.lines[-1][1]
    with CurtainShow(app.host.ctx, scene) as show:
        show.advance(3)
        out["as_render"] = bool(np.array_equal(show.picture(), third))
        # B is the same curtain with rays and a fabric of its own, traced or as layers.
        app.session.compare("split")
        app.session.edit_other(depth=1, fabric="lace")
        settle(app)
        lace = scene.changed(depth=1, fabric="lace")
        out["B"] = [
            bool(np.array_equal(seen(app, 0), third)),
            bool(np.array_equal(traced_as(show, lace), seen(app, 1))),
        ]
        app.session.draw_other(True)
        app.session.compare("difference")
        settle(app)
        out["B"].append(bool(np.array_equal(show.layers(other=lace), seen(app, 1))))
        out["B"].append([side.share for side in app.drawing.player.sides])
        app.session.swap()
        app.session.compare("off")
        settle(app)
        out["swapped"] = [
            app.session.curtain.depth,
            app.session.fabric.name,
            len(app.drawing.player.sides),
            app.actions.frame,
        ]
        for _ in range(3):
            app.session.undo()
        settle(app)
    same = []
    for name in ("c.exr", "c.png"):
        app.drawing.player.step(2)
        settle(app)
        app.files.open(str(folder / name))
        settle(app)
        same.append(bool(np.array_equal(app.actions.picture(), third)))
    out["reopened"] = same
    app.files.open(str(folder / "c.toml"))
    settle(app)
    out["scene_reopened"] = bool(np.array_equal(app.actions.picture(), first)) and app.actions.frame == 0
    # What changes while it moves, and what hangs it anew.
    app.drawing.player.step(2)
    settle(app)
    app.session.hang("wind", wind=2.0, bending=1e-4, mass=0.1)
    app.drawing.player.step(1)
    settle(app)
    out["live"] = [
        app.actions.frame,
        app.drawing.player.touched,
        app.drawing.player.curtain.simulation.cloth.parameters.mass,
    ]
    app.session.edit_transmission(rho=0.2)
    settle(app)
    out["openness"] = [app.actions.frame, round(app.drawing.player.curtain.simulation.parameters.openness, 6)]
    app.session.hang(fullness=1.5)
    settle(app)
    out["anew"] = [app.actions.frame, app.drawing.player.touched]
    app.session.undo()
    settle(app)
    out["undone"] = app.session.curtain.curtain.fullness
    pictures = []
    for name in ("kdtree", "lbvh", "brute"):
        app.session.edit_curtain(accelerator=name)
        settle(app)
        pictures.append(app.actions.picture())
    out["accelerators"] = [bool(np.allclose(p, pictures[0], rtol=1e-5, atol=1e-6)) for p in pictures]
    app.actions.toggle_tree()
    settle(app)
    out["brute_has_no_tree"] = app.drawing.tree.boxes
    app.session.edit_curtain(accelerator="lbvh")
    settle(app)
    out["tree"] = [app.drawing.tree.boxes > 20, app.drawing.tree.frame == app.actions.frame]
    app.actions.reload_shaders()
    settle(app)
    out["reloaded"] = [app.messages.lines[-1][1], bool(np.array_equal(app.actions.picture(), pictures[1]))]
    app.actions.choose_fabric("linen")
    settle(app)
    out["linen"] = [app.session.fabric.transmission is not None, "white sheer" in app.messages.lines[-1][1]]
    before = app.session.document
    app.actions.attempt(app.session.edit_curtain, room=str(folder / "no_room.obj"))
    settle(app)
    out["bad_room"] = "no_room.obj" in app.messages.lines[-1][1] and app.session.document == before
    text = sharing.as_command(app.session.curtain, frame=app.actions.frame)
    out["command"] = text.splitlines()[-1]
    out["gl_error"] = app.host.ctx.error
    app.close()
    return out


def rates(wanted=("cloth", "ground", "curtain"), seconds=4.0):
    """How often input is heard, and how long a picture takes, at 1280 x 720 in each kind of work. Figures of docs/window.md."""
    app = App(Scene(size=(1280, 720)))
    glfw.set_window_pos(app.host.window, 0, 0)
    settle(app)
    session, out = app.session, {}

    def wait(_):
        """Only look on while a picture is refined."""

    def orbit_on(_):
        app.actions.look(orbit.orbit(app.actions.camera, 1.0, 0.0))

    def slide(k):
        session.edit_yarn(0, "s", gamma_s_deg=5.0 + 0.01 * (k % 500))

    def hear(name, act=wait):
        gaps, pictures = [], app.drawing.drawer.sides[0].version
        begin = last = time.perf_counter()
        while last - begin < seconds and (app.drawing.busy or act is not wait):
            act(len(gaps))
            glfw.post_empty_event()
            app.step()
            now = time.perf_counter()
            gaps.append(1e3 * (now - last))
            last = now
        g = np.array(gaps)
        out[name] = {
            "hz": round(len(g) / (last - begin), 1), "median_ms": round(float(np.median(g)), 1),
            "p95_ms": round(float(np.percentile(g, 95)), 1), "over_33_ms": round(float((g > 33.4).mean()), 3),
            "pictures_per_s": round((app.drawing.drawer.sides[0].version - pictures) / (last - begin), 1),
        }  # fmt: skip

    if "cloth" in wanted:
        hear("orbit", orbit_on)
        hear("slider", slide)
        session.edit_scene(method="reference")
        app.step()
        hear("reference refines")
        session.edit_scene(method="direct")
        settle(app)
        out["latency"] = latency(app)
        session.edit_scene(shadows="off")
        settle(app)
        hear("orbit, no shadows", orbit_on)
        out["latency, no shadows"] = latency(app)
    if "ground" in wanted:
        session.edit_scene(shadows="full", ground="auto", objects=("sphere",))
        settle(app)
        hear("ground and a sphere: orbit", orbit_on)
        hear("ground and a sphere: slider", slide)
        hear("ground and a sphere: light turns", lambda k: session.edit_scene("t", env_rotate=float(k % 90)))
        settle(app)
        out["latency, ground and a sphere"] = latency(app)
    if "curtain" in wanted:
        session.choose_mode("curtain")
        settle(app)
        app.actions.toggle_play()
        hear("curtain plays")
        app.actions.toggle_tree()
        hear("curtain plays, tree open")
        out["curtain_ms"] = {k: round(v, 1) for k, v in vars(app.drawing.player.timings).items()}
        app.actions.toggle_tree()
        session.compare("split")
        session.edit_other(fabric="lace")
        hear("curtain plays, A and B")
        session.compare("off")
        app.actions.toggle_play()
        hear("curtain refines")
    app.close()
    return out


def latency(app, times=5):
    """Milliseconds from the arrival of a mouse's motion (by xdotool) to the first changed picture on the screen and to the
    refined one; medians."""
    during(app, ["mousemove", 400, 300], ["mousedown", 1])
    first, refined, heard = [], [], []

    def note():
        heard.append(time.perf_counter())
        app.clock.heard()

    app.host.heard = note
    for k in range(times):
        before, seen = app.drawing.drawer.sides[0].version, None
        heard.clear()
        process = subprocess.Popen(["xdotool", "mousemove", str(404 + 4 * k), "300"])
        while seen is None or app.drawing.busy or app.drawing.pending:
            glfw.post_empty_event()
            app.step()
            if seen is None and app.drawing.drawer.sides[0].version != before and not app._owed:
                seen = 1e3 * (time.perf_counter() - heard[0])
        first.append(seen)
        refined.append(1e3 * (time.perf_counter() - heard[0]))
        process.wait()
    app.host.heard = app.clock.heard
    during(app, ["mouseup", 1])
    return {"first_ms": round(float(np.median(first)), 1), "refined_ms": round(float(np.median(refined)), 1)}


def gl_objects():
    """How many names of textures, buffers and framebuffers are alive. Names are not used again: all are asked for."""
    kinds = {
        "textures": (GL.glGenTextures, GL.glIsTexture, GL.glDeleteTextures),
        "buffers": (GL.glGenBuffers, GL.glIsBuffer, GL.glDeleteBuffers),
        "framebuffers": (GL.glGenFramebuffers, GL.glIsFramebuffer, GL.glDeleteFramebuffers),
    }
    counts = {}
    for kind, (make, alive, delete) in kinds.items():
        last = make(1)
        counts[kind] = sum(bool(alive(name)) for name in range(1, int(last)))
        delete(1, [last])
    return counts


def memory_mb():
    """Megabytes in memory: as they are, and without what the C library keeps of what was freed."""
    gc.collect()
    held = resident_mb()
    with contextlib.suppress(AttributeError):  # no GNU C library
        ctypes.CDLL(None).malloc_trim(0)
    return [held, resident_mb()]


def resident_mb():
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return round(pages * resource.getpagesize() / 2**20)


def act(app, rng):
    """One random thing that a user can do."""
    session = app.session
    index, pick = int(rng.integers(2)), lambda items: items[int(rng.integers(len(items)))]
    yarn = session.fabric.yarn[index]
    actions = (
        lambda: app.actions.look(orbit.orbit(app.actions.camera, *rng.uniform(-40, 40, 2))),
        lambda: app.actions.look(orbit.pan(app.actions.camera, *rng.uniform(-0.2, 0.2, 2))),
        lambda: app.actions.look(orbit.zoom(app.actions.camera, rng.uniform(0.7, 1.4), 1.0)),
        app.actions.home,
        app.actions.frame_mesh,
        lambda: session.edit_scene("turn", env_rotate=float(rng.uniform(-180, 180))),
        lambda: session.edit_scene("exposure", exposure=float(rng.uniform(-9, 9))),
        lambda: session.edit_scene(background=bool(rng.integers(2))),
        lambda: session.edit_scene(quality=pick(("draft", "normal", "high"))),
        lambda: session.edit_scene(method=pick(list(METHODS))),
        lambda: session.edit_scene(adaptive=bool(rng.integers(2))),
        lambda: session.edit_scene(shadows=pick(("off", "off", "sun", "full"))),
        lambda: session.edit_scene(view_transform=pick(("standard", "filmic", "neutral", "agx"))),
        lambda: session.edit_scene(env=pick(("studio", "sky", "no_such.hdr"))),
        lambda: session.edit_scene(mesh=pick(("sphere", "plane", "cylinder"))),
        lambda: session.edit_yarn(index, "s", gamma_s_deg=float(rng.uniform(0, 61))),
        lambda: session.edit_yarn(index, "a", albedo=tuple(rng.uniform(0, 1, 3))),
        lambda: session.edit_yarn(index, **curve.add(yarn)),
        lambda: session.edit_yarn(index, **curve.remove(yarn)),
        lambda: session.edit_yarn(index, "c", **curve.move(yarn, 0, 0.0, float(rng.uniform(-99, 99)))),
        lambda: session.choose_fabric(pick(("linen", "velvet", "silk_shot"))),
        session.reset_fabric,
        app.session.undo,
        app.session.redo,
        session.swap,
        lambda: session.compare(pick(("off", "split", "difference"))),
        lambda: glfw.set_window_size(app.host.window, int(rng.integers(440, 520)), int(rng.integers(40, 120))),
        lambda: app.layout.toggle_panels(),
        lambda: app.files.open(pick(("missing.obj", "README.md"))),
        lambda: session.choose_mode(pick(("cloth", "curtain"))),
        *curtain_actions(app, rng, pick),
    )
    try:
        pick(actions)()
    except InputError:
        pass


def rest(app):
    """Both modes at rest, in a state that is the same each time: what is kept for each is then there."""
    if app.drawing.tree is not None:
        app.actions.toggle_tree()
    glfw.set_window_size(app.host.window, 480, 80)
    app.layout.show_panels = True
    session = app.session
    session.compare("off")
    session.choose_mode("curtain")
    if app.drawing.player is not None and app.drawing.player.playing:
        app.actions.toggle_play()
    session.edit_curtain(accelerator="kdtree", depth=4, spp=1)
    session.hang(**{name: getattr(CurtainParameters(), name) for name in ("wind", "fullness")})
    settle(app)
    session.choose_mode("cloth")
    session.edit_scene(method="direct", shadows="off", adaptive=False, mesh="sphere", env="studio", spp=1)
    session.choose_fabric("linen")
    settle(app)


def curtain_actions(app, rng, pick):
    """What a user can do with the curtain."""
    session = app.session
    parameters = ("wind", "gustiness", "stretch", "shear", "bending", "mass", "hem", "damping")
    limits = {c.name: (c.low, c.high) for c in curtain_controls(parameters)}
    name = pick(parameters)
    terms = [c for c in controls(Transmission) if c.kind == "float"]
    term = pick(terms)
    return (
        app.actions.toggle_play,
        app.actions.toggle_play,
        app.actions.toggle_tree,
        lambda: app.drawing.player and app.drawing.player.step(),
        lambda: app.drawing.player and app.drawing.player.restart(),
        lambda: app.drawing.tree and app.drawing.tree.show_level(pick((None, 0, 3, 8, 40))),
        lambda: session.edit_curtain(accelerator=pick(("kdtree", "kdtree", "lbvh", "brute"))),
        lambda: session.edit_other(accelerator=pick(("kdtree", "lbvh")), depth=int(rng.integers(1, 5))),
        lambda: session.draw_other(bool(rng.integers(2))),
        lambda: session.edit_curtain("d", depth=int(rng.integers(1, 9))),
        lambda: session.hang(name, **{name: float(rng.uniform(*limits[name]))}),
        lambda: session.hang(fullness=float(rng.uniform(1.0, 2.2))),
        lambda: session.edit_transmission(term.name, **{term.name: float(rng.uniform(term.low, term.high))}),
        lambda: app.actions.choose_fabric(pick(("lace", "sheer_voile", "linen"))),
    )


def touch_everything(app):
    """Use each kind of thing once, so that what is kept for later is there before the first count."""
    session = app.session
    for changes in (
        *({"method": name} for name in METHODS),
        {"method": "direct", "shadows": "full", "env": "sky"},
        {"shadows": "sun"},
        {"shadows": "off", "adaptive": True, "spp": 2},
        {"quality": "high", "spp": 1},
    ):
        session.edit_scene(**changes)
        settle(app)
    session.compare("difference")
    settle(app)
    session.choose_mode("curtain")
    settle(app)
    app.actions.toggle_tree()
    for name in ("kdtree", "lbvh", "brute"):
        session.edit_curtain(accelerator=name, depth=8, spp=2)
        settle(app)


def monkey(count):
    """Random actions, with a picture or two after each; everything is used once before the first count."""
    rng = np.random.default_rng(0)
    app = App(Scene(size=(80, 60), mesh="sphere", method="direct", grid=12))
    small = CurtainParameters(quads=(48, 12), pleats=4, settle=0.1)
    app.session.edit_curtain(curtain=small, size=(80, 60))
    settle(app)
    touch_everything(app)
    objects, memory = [], []
    for number in range(count + 1):
        if number % max(count // 4, 1) == 0:
            rest(app)
            objects.append(gl_objects())
            memory.append(memory_mb())
        if number == count:
            break
        act(app, rng)
        app.clock.heard()
        for _ in range(int(rng.integers(1, 4))):
            glfw.post_empty_event()
            app.step()
        assert app.host.ctx.error == "GL_NO_ERROR", number
    app.close()
    return {"actions": count, "objects": objects, "memory_mb": memory}


if __name__ == "__main__":
    if sys.argv[1] == "monkey":
        print(json.dumps(monkey(int(sys.argv[2]))))
    elif sys.argv[1] == "rates":
        print(json.dumps(rates(sys.argv[2:]) if sys.argv[2:] else rates(), indent=1))
    else:
        with tempfile.TemporaryDirectory() as scratch:
            print(json.dumps({"events": events, "curtain": curtain, "drops": drops}[sys.argv[1]](Path(scratch))))
