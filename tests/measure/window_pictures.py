"""The window's pictures in the documents, made anew by real events (xdotool), on a display of its own.

xvfb-run -a -s '-screen 0 1920x1080x24' python tests/measure/window_pictures.py docs [cloth weave curtain]

Writes window.png, window_weave.jpg and window_curtain.png into the folder: some minutes of CPU.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "window"))
import glfw
import numpy as np
import window_weave
from PIL import Image
from window_driver import settle, until
from window_walk import Hand

from glcloth.scene import Scene, load_scene
from glcloth.window.app import App


def opened(scene, hand=Hand):
    """A window of a scene at the screen's corner, complete, and a hand in it."""
    app = App(scene)
    glfw.set_window_pos(app.host.window, 0, 0)
    settle(app)
    return app, hand(app, Path())


def shot(app):
    """What the window shows, as a PIL picture."""
    app.clock.heard()
    app.step()
    return Image.fromarray(np.ascontiguousarray(app.actions.screen()))


def cloth(folder):
    """A slider and a point of the tangent curve were dragged."""
    app, hand = opened(Scene(size=(1280, 720), spp=4))
    hand.drag("gamma_s", 0.05, 0.14)
    hand.drag("point 2", 0.5, 0.5, dy=-12)
    hand.do(["mousemove", 40, 600])
    settle(app)
    shot(app).save(folder / "window.png")
    app.close()


def weave(folder):
    """One crossing of raw denim turned over, two ends painted, and its threads being counted."""
    window_weave.window_walk.RECORDED += ("invisible_button",)
    app, hand = opened(Scene(size=(880, 720), fabric="denim_raw", mesh="plane", quality="draft"), window_weave.Weaver)
    for section in ("Scene", "Fabric", "Light"):
        hand.click(section, 0.3)
    hand.click("Weave", 0.3)
    for _ in range(4):
        hand.click("+##ends")
        hand.click("+##picks")
    hand.mark(("drawdown", 2, 4))
    hand.mark(("warp", 0, 5), ("warp", 0, 6))
    hand.click("Go near", 0.5)
    settle(app)
    hand.do(["mousemove", 433, 390], ["keydown", "n"])
    shot(app).save(folder / "window_weave.jpg", quality=88)
    hand.do(["keyup", "n"])
    app.close()


def curtain(folder):
    """The curtain paused in the wind at frame 50, and its tree at level 11, in its own window, two thirds as large."""
    app, hand = opened(load_scene("curtain").changed(size=(1280, 720), frame=0))
    hand.do(["mousemove", 600, 300], ["key", "space"], wait=False)
    until(app, lambda: app.actions.frame >= 49, "frame 49")
    hand.do(["key", "space"])
    while app.actions.frame < 50:
        hand.do(["key", "Right"])
    hand.do(["key", "t"], wait=False)
    until(app, lambda: app.drawing.tree is not None and app.drawing.tree.boxes > 100, "the tree")
    app.drawing.tree.show_level(11)  # without a window manager its window lies over the panels
    settle(app)
    window, tree = shot(app), Image.fromarray(app.drawing.tree.pixels())
    both = Image.new("RGB", (window.width + 8 + tree.width, max(window.height, tree.height)), (24, 24, 24))
    both.paste(window, (0, 0))
    both.paste(tree, (window.width + 8, (both.height - tree.height) // 2))
    both.resize((both.width * 2 // 3, both.height * 2 // 3), Image.Resampling.LANCZOS).save(
        folder / "window_curtain.png"
    )
    app.close()


if __name__ == "__main__":
    makers = {"cloth": cloth, "weave": weave, "curtain": curtain}
    for name in sys.argv[2:] or makers:
        makers[name](Path(sys.argv[1]))
        print(name, flush=True)
