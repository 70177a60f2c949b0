"""The curtain's panel: play and step, wind and stiffness, rays, lamp, and the window of the tree."""

from __future__ import annotations

from functools import cache
from typing import Any

from imgui_bundle import imgui  # isort: skip

from ..curtain.hanging import LIVE
from ..fabric import builtin_fabrics, load_fabric
from ..scene import Scene
from .actions import Actions
from .controls import controls, curtain_controls
from .state import OWN
from .widgets import CLAMP, GREY, Panel, buttons, chooser, control, tip

RAYS = controls(Scene, ("accelerator", "depth", "spp", "spread"))
OTHER = [item for item in RAYS if item.name in OWN]
LAMP = controls(Scene, ("lamp_position", "lamp_intensity", "ambient"))
MOVING = [c for c in curtain_controls() if c.name in LIVE]
HANGING = [c for c in curtain_controls() if c.name not in LIVE]


@cache
def sheer_fabrics() -> list[str]:
    """What a curtain may be of; all fabrics are read for it, which takes a third of a second."""
    return [name for name in builtin_fabrics() if load_fabric(name).transmission is not None]


class CurtainPanel(Panel):
    """The controls of the curtain that is shown."""

    def __init__(self, actions: Actions):
        super().__init__(actions)
        self._draft: dict[str, Any] = {}  # values being dragged: they hang the curtain anew on release

    def draw(self) -> None:
        """Everything of the curtain but its fabric and its distant light."""
        actions, session, scene = self.actions, self.session, self.session.curtain
        origin = session.chosen
        if new := chooser("fabric", origin if isinstance(origin, str) else origin.name, builtin_fabrics()):
            self.attempt(actions.choose_fabric, new)
        player = actions.player
        there, playing = player.curtain is not None, player.playing
        buttons(
            ("Pause" if playing else "Play", actions.toggle_play, True),
            ("Step", player.step, there and not playing),
            ("Restart", player.restart, there),
        )
        imgui.same_line()
        imgui.text_colored(GREY, f"frame {actions.frame}, {actions.frame / scene.rate:.2f} s")
        for item in RAYS:
            self.field(item, scene, session.edit_curtain, item.name)
        self._tree()
        imgui.separator_text("wind and cloth")
        for item in MOVING:
            self.field(item, scene.curtain, session.hang, f"curtain {item.name}")
        if imgui.tree_node("hang it anew"):
            self._hanging(scene)
            imgui.tree_pop()
        if imgui.tree_node("lamp and room"):
            for item in LAMP:
                self.field(item, scene, session.edit_curtain, item.name)
            imgui.text_colored(GREY, f"room: {scene.room or 'built in'}")
            imgui.tree_pop()

    def _hanging(self, scene: Scene) -> None:
        """Shape and size: applied when the slider is let go, for the curtain must settle again."""
        behind = scene.curtain.behind
        behind = (behind or "none") if isinstance(behind, str) else behind.name
        if new := chooser("second curtain", behind, ["none", *sheer_fabrics()]):
            self.attempt(self.session.hang, None, behind="" if new == "none" else new)
        for item in HANGING:
            value = self._draft.get(item.name, getattr(scene.curtain, item.name))
            changed, new = control(item, value)
            if changed:
                self._draft[item.name] = new
            done = item.kind == "choice" or imgui.is_item_deactivated_after_edit() or not imgui.is_any_item_active()
            if item.name in self._draft and done:
                self.attempt(self.session.hang, None, **{item.name: self._draft.pop(item.name)})

    def other(self, scene: Scene) -> None:
        """The settings that side B has of its own beside its fabric."""
        session = self.session
        changed, layered = imgui.checkbox("blended layers, without shadows", session.document.layered)
        if changed:
            session.draw_other(layered)
        if layered:
            return
        imgui.push_id("b")
        for item in OTHER:
            self.field(item, scene, session.edit_other, f"b {item.name}")
        imgui.pop_id()

    def _tree(self) -> None:
        """The second window and the level that it shows."""
        actions = self.actions
        changed, _ = imgui.checkbox("tree in a window of its own", actions.tree is not None)
        tip("the acceleration structure of the frame: boxes green, lamp yellow, axes grey; follows the curtain")
        if changed:
            actions.toggle_tree()
        tree = actions.tree
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
