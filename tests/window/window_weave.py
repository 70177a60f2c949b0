"""Walks through the weave page by real events (xdotool), and keeps a picture after each step.

DISPLAY=:1 python tests/window/window_weave.py FOLDER   # prints what was found as JSON
"""

import json
import sys
from pathlib import Path

import glfw
import numpy as np
import window_walk
from window_driver import drop, settle

from glcloth.fabric import load_fabric
from glcloth.methods import relief
from glcloth.scene import Scene
from glcloth.weave.named import named_draft
from glcloth.weave.wif import load_draft
from glcloth.window import near_view
from glcloth.window.app import App
from glcloth.window.draft_grid import Cell, Grid
from glcloth.window.thread_colors import thread_colors


class Weaver(window_walk.Hand):
    """Draws on the grid by its cells."""

    def place(self, part, row, column):
        """Where a cell is, in pixels of the window."""
        panel = self.app.panels.weave
        grid = Grid.of(panel._loom)
        self.at("##draft grid")  # scrolls to it
        x0, y0, x1, _ = self.places.of["##draft grid"]
        cell = (x1 - x0) / grid.size[0]
        x, y = grid.corner(Cell(part, row, column))
        return round(x0 + (x + 0.5) * cell), round(y0 + (y + 0.5) * cell)

    def mark(self, *cells):
        """Press on the first cell, move over the others, let go."""
        places = [self.place(*cell) for cell in cells]
        moves = [["mousemove", *place] for place in places[1:]]
        self.do(["mousemove", *places[0]], ["mousedown", 1], *moves, ["mouseup", 1])


def near_of(app):
    """The picture of the cloth near by."""
    texture = app.drawing.near.side.texture
    return np.frombuffer(texture.read(), "f4").reshape(texture.height, texture.width, 4)


def colors_of(app):
    """Colours of the ends and of the picks."""
    return thread_colors(app.session.fabric)


def walk(folder):
    window_walk.RECORDED += ("invisible_button",)
    app = App(
        Scene(size=(64, 720), mesh="plane", quality="draft", fabric="linen_light", shadows="off", env="sky", lobes=3)
    )
    glfw.set_window_pos(app.host.window, 0, 0)
    hand, out = Weaver(app, folder), {}
    relief.SAMPLES = 256  # coarse slopes are enough here
    # Programs for other numbers of tangents are not needed here, and take long to compile.
    app.drawing.refiner._cold, near_view.WARM_UP, near_view.SIZE = False, (), (96, 48)
    drawdown = lambda: app.session.fabric.weave.drafted.drawdown.astype(int).tolist()  # noqa: E731
    settle(app)
    for section in ("Scene", "Fabric", "Light"):
        hand.click(section, 0.3)
    hand.click("Weave", 0.3)
    plain = hand.keep("page")
    first, document = near_of(app), app.session.document
    out["near_is_woven"] = float(first[..., 1].std() / first[..., 1].mean())

    hand.mark(("drawdown", 0, 0))
    hand.keep("clicked")
    out["clicked"] = drawdown()
    out["near_changed"] = float(np.abs(near_of(app) - first).mean() / first.mean())
    hand.do(["mousemove", 32, 300], ["key", "ctrl+z"])
    out["undone"] = [drawdown(), app.session.fabric == document.scene.fabric or app.session.document == document]
    out["same_again"] = bool(np.array_equal(near_of(app), first))

    hand.click("draft", 0.3)
    hand.click("twill_2_2")
    out["twill"] = drawdown() == named_draft("twill_2_2").drawdown.astype(int).tolist()
    hand.mark(("threading", 3, 3), ("threading", 2, 3), ("threading", 1, 3))
    out["threaded"] = [row[3] for row in drawdown()] == [row[1] for row in drawdown()]
    hand.do(["mousemove", 32, 300], ["key", "ctrl+z"])
    out["drag_is_one_step"] = drawdown() == named_draft("twill_2_2").drawdown.astype(int).tolist()
    loom = app.panels.weave._loom
    hand.mark(("tieup", 0, 0), ("tieup", 0, 1))
    tied = app.panels.weave._loom
    out["tied"] = [bool(loom.tieup[0, 0]), tied.tieup[:2, 0].tolist()]
    hand.mark(("treadling", 1, 1), ("treadling", 1, 3))
    out["trodden"] = drawdown()[1] == drawdown()[3]

    woven, app.panels.weave._pen.color = drawdown(), np.array([0.5, 0.02, 0.03])
    document = app.session.document
    hand.mark(("warp", 0, 1), ("warp", 0, 2))
    reds = lambda: [bool(np.allclose(c, app.panels.weave._pen.color, atol=5e-3)) for c in colors_of(app)[0]]  # noqa: E731
    out["painted"] = [reds(), drawdown() == woven]
    place = hand.place("warp", 0, 3)
    hand.do(["mousemove", *place], ["click", 3])
    out["taken_up"] = bool(np.allclose(app.panels.weave._pen.color, colors_of(app)[0][3]))
    hand.keep("painted")
    hand.do(["mousemove", 32, 300], ["key", "ctrl+z"])
    out["painted"].append(app.session.document == document)

    before = app.session.fabric.weave.crimp
    hand.drag("crimp", 0.3, 0.45)
    out["crimp"] = app.session.fabric.weave.crimp != before
    app.files.names["draft"] = str(folder / "saved.wif")
    hand.click("Save draft", 0.5)
    out["saved"] = load_draft(folder / "saved.wif").reduced().drawdown.astype(int).tolist() == drawdown()
    app.files.names["fabric"] = str(folder / "saved.toml")
    app.files.save_fabric(app.files.names["fabric"])
    out["fabric_saved"] = load_fabric(folder / "saved.toml") == app.session.fabric
    woven = drawdown()
    hand.click("draft", 0.3)
    hand.click("plain")
    hand.click("Load draft", 0.5)
    out["loaded"] = drawdown() == woven
    out["dropped"] = [drop(app, folder / "saved.wif"), drawdown() == woven]
    (folder / "bad.wif").write_text("[WIF]\n")
    out["bad"] = [drop(app, folder / "bad.wif"), "bad.wif" in app.messages.lines[-1][1], drawdown() == woven]

    # Their box grows with the length of the folder's name, up to the pointer.
    out["errors"] = sum(kind == "error" for kind, _ in app.messages.lines)
    app.messages.lines.clear()
    hand.do(["mousemove", 32, 250])
    bare = window_walk.picture_of(hand.keep("bare"), app)
    hand.do(["keydown", "n"])
    held = window_walk.picture_of(hand.keep("thread_counter"), app)
    hand.do(["keyup", "n"])
    out["counter"] = [
        int((np.abs(held - bare).max(-1) > 40).sum()),
        bool(np.array_equal(window_walk.picture_of(hand.keep("let_go"), app), bare)),
    ]
    hand.click("Go near", 0.5)
    camera = app.actions.camera
    out["near_by"] = [
        app.session.scene.threads,
        round(float(np.linalg.norm(np.subtract(camera.eye, camera.target))), 4),
    ]
    hand.do(["mousemove", 32, 250], ["key", "ctrl+z"])
    bare_fabric = app.session.fabric.changed(weave=None, name="Bare")
    app.session.choose_fabric(bare_fabric)
    settle(app)
    hand.keep("no_weave")
    hand.click("Give it a plain weave", 0.3)
    out["given"] = [app.session.fabric.weave.far, app.session.fabric.yarn == bare_fabric.yarn]
    out["goes_on"] = []
    for _ in range(2):
        hand.click("+##ends")
        out["goes_on"] += [app.panels.weave._loom.threading.tolist(), app.session.fabric.weave.drafted.title]
    out["gl_error"] = app.host.ctx.error
    out["errors"] += sum(kind == "error" for kind, _ in app.messages.lines)
    out["plain"] = list(plain.shape)
    app.close()
    return out


if __name__ == "__main__":
    target = Path(sys.argv[1]).resolve()
    target.mkdir(parents=True, exist_ok=True)
    print(json.dumps(walk(target)))
