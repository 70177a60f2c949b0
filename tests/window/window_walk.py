"""Walks through the window by real events (xdotool) and keeps a picture before and after each step.

DISPLAY=:1 python tests/window/window_walk.py FOLDER [WIDTHxHEIGHT]   # everything; prints what was found as JSON
DISPLAY=:1 python tests/window/window_walk.py FOLDER newcomer MAP     # a new user's path to an edited silk under a map, timed
"""

import json
import os
import sys
import time
from pathlib import Path

import glfw
import numpy as np
from imgui_bundle import imgui, implot
from window_driver import distance, during, settle, until

from glcloth.image import write_image
from glcloth.scene import Scene
from glcloth.window.app import App

RECORDED = ("button", "small_button", "radio_button", "collapsing_header", "checkbox", "selectable", "slider_float")
RECORDED += ("slider_int", "slider_float3", "begin_combo", "combo", "input_text_with_hint", "input_text")
RECORDED += ("begin_tab_item_simple",)


class Places:
    """Where each control was drawn last, by its label; pixels of the window."""

    def __init__(self):
        self.of = {}
        for name in RECORDED:
            setattr(imgui, name, self._recording(getattr(imgui, name)))
        drag_point = implot.drag_point

        def point(number, x, y, *rest):
            at = implot.plot_to_pixels(x, y)
            self.of[f"point {number}"] = (at.x, at.y, at.x, at.y)
            return drag_point(number, x, y, *rest)

        implot.drag_point = point

    def _recording(self, draw):
        def recorded(label, *arguments, **options):
            low = imgui.get_cursor_screen_pos()
            result = draw(label, *arguments, **options)
            if draw.__name__ == "begin_combo" and (result is True):
                self.of[label] = (low.x, low.y, low.x + 180, low.y + 20)
            else:
                a, b = imgui.get_item_rect_min(), imgui.get_item_rect_max()
                self.of[label] = (a.x, a.y, b.x, b.y)
            return result

        return recorded


class Hand:
    """Moves the mouse and types, by labels, while the window goes on."""

    def __init__(self, app, folder):
        self.app, self.folder, self.places, self.count = app, folder, Places(), 0
        self.log = []

    def at(self, label, share=0.5):
        """A place on a control; the panel is scrolled to it where it is out of sight."""
        self.app.clock.heard()
        self.app.step()
        for _ in range(40):
            x0, y0, x1, y1 = self.places.of[label]
            height = glfw.get_window_size(self.app.host.window)[1]
            if 10 < (y0 + y1) / 2 < height - 10:
                break
            button = 5 if y0 > height / 2 else 4
            left = glfw.get_window_size(self.app.host.window)[0] - 300
            self.do(["mousemove", left, 300], ["click", button])
        # A slider's rectangle ends with its label; the slider itself is the first part.
        return round(x0 + share * (x1 - x0)), round((y0 + y1) / 2)

    def do(self, *commands, wait=True):
        during(self.app, *commands, wait=wait)

    def click(self, label, share=0.5, **options):
        self.do(["mousemove", *self.at(label, share)], ["click", 1], **options)

    def drag(self, label, share, to, dy=0, **options):
        x, y = self.at(label, share)
        end, _ = self.at(label, to)
        steps = [["mousemove", round(x + k * (end - x) / 6), round(y + k * dy / 6)] for k in range(1, 7)]
        self.do(["mousemove", x, y], ["mousedown", 1], *steps, ["mouseup", 1], **options)

    def type(self, text):
        """Type a text and Return."""
        self.do(["type", "--delay", "5", text], ["key", "Return"])

    def keep(self, name):
        """Save what the window shows."""
        self.app.clock.heard()
        self.app.step()
        self.count += 1
        pixels = self.app.actions.screen()
        write_image(self.folder / f"{self.count:02d}_{name}.png", linear(pixels))
        return pixels

    def frames(self, count):
        """Let the curtain play on by so many frames."""
        end = self.app.actions.frame + count
        until(self.app, lambda: self.app.actions.frame >= end, f"frame {end}")


def linear(pixels):
    from glcloth.color import srgb_decode

    return srgb_decode(pixels / 255.0)


def picture_of(pixels, app):
    """The part of the window left of the panels."""
    return pixels[:, : app.layout.rectangle()[2]].astype(int)


def walk(folder, size):
    """Every kind of action, with what it did."""
    app = App(Scene(size=size))
    glfw.set_window_pos(app.host.window, 0, 0)
    hand, out = Hand(app, folder), {}
    imgui.get_io().config_debug_highlight_id_conflicts = True
    settle(app)
    start, far = hand.keep("start"), distance(app)
    eye = app.actions.camera.eye
    middle = size[0] // 2, size[1] // 2
    hand.do(
        ["mousemove", *middle], ["mousedown", 1], *[["mousemove", middle[0] + 8 * k, middle[1]] for k in range(1, 6)],
        ["mouseup", 1],
    )  # fmt: skip
    orbited = hand.keep("orbit")
    out["orbit"] = app.actions.camera.eye != eye and abs(distance(app) - far) < 1e-6
    out["orbit_seen"] = changed(start, orbited, app)
    hand.do(["key", "Home"])

    before = app.actions.picture()
    hand.drag("gamma_s", 0.05, 0.2)
    hand.keep("slider")
    out["slider"] = app.session.fabric.yarn[0].gamma_s_deg
    out["slider_seen"] = float(np.abs(app.actions.picture() - before).max())
    hand.do(["mousemove", *middle], ["key", "ctrl+z"])
    hand.keep("undo")
    out["undo"] = bool(np.array_equal(app.actions.picture(), before))
    hand.drag("point 2", 0.5, 0.5, dy=-25)
    hand.keep("curve")
    out["curve"] = app.session.fabric.yarn[0].curve_angles_deg
    out["curve_seen"] = float(np.abs(app.actions.picture() - before).max())

    hand.click("Compare A and B", 0.3)
    hand.click("split", 0.2)
    hand.click("B = A")
    hand.click("fabric of B", 0.3)
    hand.click("linen")
    out["split"] = [app.session.document.compare, app.session.resolve(app.session.document.other.fabric).name]
    hand.keep("split")
    x = round(app.session.document.split * size[0])
    hand.do(
        ["mousemove", x, 60], ["mousedown", 1], ["mousemove", x - 20, 60], ["mousemove", x - 50, 60], ["mouseup", 1]
    )
    hand.keep("split_moved")
    out["split_at"] = app.session.document.split
    hand.click("difference", 0.1)
    hand.keep("difference")
    hand.click("off", 0.1)
    hand.click("Compare A and B", 0.3)

    sky = folder / "map.exr"
    y = np.linspace(2.0, 0.05, 32)[:, None, None]
    write_image(sky, (y * np.array([0.4, 0.6, 1.0]) * np.ones((32, 64, 1))).astype("f4"))
    hand.click("##open", 0.5)
    hand.type(str(sky))
    hand.keep("opened_map")
    out["opened"] = app.session.scene.env == str(sky)
    (folder / "bad.hdr").write_bytes(b"#?RADIANCE nothing")
    hand.do(["key", "ctrl+a"])
    hand.click("##open", 0.5)
    hand.do(["key", "ctrl+a"])
    hand.type(str(folder / "bad.hdr"))
    hand.keep("bad_map")
    out["bad"] = [app.messages.lines[-1][0], "bad.hdr" in app.messages.lines[-1][1], app.session.scene.env == str(sky)]
    hand.do(["key", "Escape"])
    out["cloth_messages"] = [text for kind, text in app.messages.lines if kind == "error"]

    hand.click("Curtain", 0.2)
    still = hand.keep("curtain")
    hand.do(["mousemove", *middle], ["key", "space"], wait=False)
    hand.frames(12)
    moved = hand.keep("curtain_playing")
    out["played"] = app.drawing.player.playing and app.actions.frame >= 12
    out["played_seen"] = changed(still, moved, app)
    hand.drag("wind", 0.3, 0.55, wait=False)
    out["wind"] = app.session.curtain.curtain.wind
    hand.drag("openness", 0.2, 0.5, wait=False)
    out["openness"] = app.session.curtain.fabric.transmission.openness
    out["still_playing"] = app.drawing.player.playing
    hand.do(["mousemove", *middle], ["key", "t"], wait=False)
    until(app, lambda: app.drawing.tree.boxes > 100, "the tree's first picture")
    first = app.drawing.tree.frame
    until(app, lambda: app.drawing.tree.frame > first, "its next frame")
    write_image(folder / "tree_playing.png", linear(app.drawing.tree.pixels()))
    # How far it lags depends on the machine; it leaves out frames rather than holding the curtain up.
    out["tree"] = [app.drawing.tree.boxes > 100, app.drawing.tree.frame <= app.actions.frame]
    hand.do(["mousemove", *middle], ["key", "space"])
    hand.keep("curtain_paused")
    out["paused"] = not app.drawing.player.playing and app.drawing.drawer.sides[0].share == 1.0
    hand.click("leaves only", 0.05)
    write_image(folder / "tree_level.png", linear(app.drawing.tree.pixels()))
    out["level"] = [app.drawing.tree.level, app.drawing.tree.frame == app.actions.frame]
    hand.click("tree in a window of its own", 0.05)
    out["tree_closed"] = app.drawing.tree is None
    hand.click("accelerator", 0.3)
    hand.click("lbvh")
    out["accelerator"] = app.session.curtain.accelerator
    hand.keep("lbvh")
    hand.do(["mousemove", *middle], ["key", "ctrl+z"])
    out["accelerator_undone"] = app.session.curtain.accelerator
    hand.click("Cloth", 0.2)
    hand.keep("cloth_again")
    out["cloth_again"] = app.session.document.mode
    out["gl_error"], out["messages"] = (
        app.host.ctx.error,
        [text for kind, text in app.messages.lines if kind == "error"][1:],
    )
    app.close()
    return out


def changed(a, b, app):
    """Share of the picture's pixels that differ by more than 8 codes."""
    return float((np.abs(picture_of(a, app) - picture_of(b, app)).max(-1) > 8).mean())


def newcomer(folder, path):
    """The path in docs/window.md: silk, its highlight, its colour, its curve, under one's own map; saved. Seconds of each."""
    begin = time.monotonic()
    app = App(Scene())
    glfw.set_window_pos(app.host.window, 0, 0)
    hand, log = Hand(app, folder), []

    def done(what):
        log.append([what, round(time.monotonic() - begin, 1)])
        hand.keep(what.split()[0])

    settle(app)
    done("window open, silk in the studio")
    hand.click("##open", 0.5)
    hand.type(str(path))
    done("own map opened, lights fitted")
    hand.drag("gamma_s", 0.05, 0.12)
    done("highlight widened by the slider gamma_s")
    x, y = hand.at("albedo", 0.2)
    hand.do(["keydown", "ctrl"], ["mousemove", x, y], ["click", 1], ["keyup", "ctrl"])
    hand.do(["key", "ctrl+a"])
    hand.type("0.3")
    done("albedo typed")
    hand.drag("point 2", 0.5, 0.5, dy=-20)
    done("curve's point dragged")
    hand.click("Files", 0.3)
    for label in ("Save fabric", "Save scene", "Save picture"):
        hand.click(label)
    done("saved")
    app.close()
    return {"log": log, "files": sorted(p.name for p in Path.cwd().iterdir() if p.suffix in (".toml", ".png"))}


if __name__ == "__main__":
    target = Path(sys.argv[1]).resolve()
    target.mkdir(parents=True, exist_ok=True)
    if sys.argv[2:3] == ["newcomer"]:
        path = Path(sys.argv[3]).resolve()
        os.chdir(target)  # what is saved there stays there
        print(json.dumps(newcomer(target, path)))
    else:
        wanted = tuple(map(int, sys.argv[2].split("x"))) if len(sys.argv) > 2 else (1280, 720)
        print(json.dumps(walk(target, wanted)))
