"""The curtain's panel: play and step, wind and stiffness, rays, lamp, and the window of the tree."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from imgui_bundle import imgui  # isort: skip

from ..curtain.hanging import LIVE
from ..fabric import builtin_fabrics
from ..scene import Scene
from .controls import controls, curtain_controls
from .state import OWN
from .widgets import CLAMP, GREY, button_if, chooser, control, tip

if TYPE_CHECKING:
    from .app import App

RAYS = controls(Scene, ("accelerator", "depth", "spp", "spread"))
OTHER = [item for item in RAYS if item.name in OWN]
LAMP = controls(Scene, ("lamp_position", "lamp_intensity", "ambient"))
MOVING = [c for c in curtain_controls() if c.name in LIVE]
HANGING = [c for c in curtain_controls() if c.name not in LIVE]


class CurtainPanel:
    """Draws the controls of the curtain that an App shows, and turns what is done in them into edits."""

    def __init__(self, app: App):
        self.app = app
        self._draft: dict[str, Any] = {}  # what is being dragged and hangs the curtain anew when it is let go

    def draw(self) -> None:
        """Everything of the curtain but its fabric and what lights it from far."""
        app = self.app
        session, player = app.session, app.player
        scene = session.curtain
        origin = session.chosen
        if new := chooser("fabric", origin if isinstance(origin, str) else origin.name, builtin_fabrics()):
            app.attempt(app.choose_fabric, new)
        playing = player is not None and player.playing
        if imgui.button("Pause" if playing else "Play") and player is not None:
            app.toggle_play()
        imgui.same_line()
        if button_if("Step", player is not None and not playing):
            player.step()
        imgui.same_line()
        if button_if("Restart", player is not None):
            player.restart()
        imgui.same_line()
        imgui.text_colored(GREY, f"frame {app.frame}, {app.frame / scene.rate:.2f} s")
        for item in RAYS:
            changed, new = control(item, getattr(scene, item.name))
            if changed:
                app.attempt(session.edit_curtain, item.name, **{item.name: new})
        self._tree()
        imgui.separator_text("wind and cloth")
        for item in MOVING:
            if item.name == "openness":
                continue
            changed, new = control(item, getattr(scene.curtain, item.name))
            if changed:
                app.attempt(session.hang, f"curtain {item.name}", **{item.name: new})
        if imgui.tree_node("hang it anew"):
            self._hanging(scene)
            imgui.tree_pop()
        if imgui.tree_node("lamp and room"):
            for item in LAMP:
                changed, new = control(item, getattr(scene, item.name))
                if changed:
                    app.attempt(session.edit_curtain, item.name, **{item.name: new})
            imgui.text_colored(GREY, f"room: {scene.room or 'built in'}")
            imgui.tree_pop()

    def _hanging(self, scene: Scene) -> None:
        """Shape and size: applied when the slider is let go, for the curtain must settle again."""
        session = self.app.session
        for item in HANGING:
            value = self._draft.get(item.name, getattr(scene.curtain, item.name))
            changed, new = control(item, value)
            if changed:
                self._draft[item.name] = new
            done = item.kind == "choice" or imgui.is_item_deactivated_after_edit() or not imgui.is_any_item_active()
            if item.name in self._draft and done:
                self.app.attempt(session.hang, None, **{item.name: self._draft.pop(item.name)})

    def other(self, scene: Scene) -> None:
        """What side B has of its own beside its fabric."""
        session = self.app.session
        changed, layered = imgui.checkbox("blended layers, without shadows", session.document.layered)
        if changed:
            session.draw_other(layered)
        if layered:
            return
        imgui.push_id("b")
        for item in OTHER:
            changed, new = control(item, getattr(scene, item.name))
            if changed:
                self.app.attempt(session.edit_other, f"b {item.name}", **{item.name: new})
        imgui.pop_id()

    def _tree(self) -> None:
        """The second window and the level that it shows."""
        app = self.app
        changed, _ = imgui.checkbox("tree in a window of its own", app.tree is not None)
        tip("the acceleration structure of the frame: boxes green, lamp yellow, axes grey; follows the curtain")
        if changed:
            app.toggle_tree()
        tree = app.tree
        if tree is None:
            return
        leaves = tree.level is None
        changed, leaves = imgui.checkbox("leaves only", leaves)
        if changed:
            tree.show_level(None if leaves else min(8, tree.deepest))
        if tree.level is not None:
            changed, level = imgui.slider_int("level", tree.level, 0, max(tree.deepest, 1), "%d", CLAMP)
            if changed:
                tree.show_level(level)
        imgui.same_line()
        imgui.text_colored(GREY, f"{tree.boxes} boxes, {tree.deepest + 1} levels")
