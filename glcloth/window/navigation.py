"""Mouse and keys over the picture: the eye, the split, the light's turn, and shortcuts for the panels."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from imgui_bundle import imgui  # isort: skip
import glfw
import numpy as np

from . import orbit
from .actions import Actions
from .files import Files
from .host import Typed

SPLIT_REACH = 8  # points to either side of the split that take hold of it

STILL = 2  # points that the mouse may move in a click


class Navigation:
    """Turns mouse and keys over the picture into moves and edits."""

    def __init__(self, actions: Actions, files: Files):
        self.actions, self.files, self.session = actions, files, actions.session
        self.drag: str | None = None
        self._held = 0  # the mouse button that drags
        self._moved = 0.0  # pixels since it was pressed

    # -- the mouse ---------------------------------------------------------------------------------------------------

    def update(self, typed: list[Typed]) -> None:
        """Apply the input since the last call, and these keys."""
        io = imgui.get_io()
        if not self.actions.shows_something:
            return
        points_to_pixels = io.display_framebuffer_scale.x
        left, bottom, width, height = self.actions.layout.rectangle()
        mouse_x = io.mouse_pos.x * points_to_pixels
        inside = not io.want_capture_mouse
        if self.drag is not None:
            # The motion of a picture comes before its release, which would otherwise swallow it.
            dx, dy = io.mouse_delta.x * points_to_pixels, io.mouse_delta.y * points_to_pixels
            self._moved += abs(dx) + abs(dy)
            self._dragged(dx, dy, height)
            if self.drag == "split":
                share = float(np.clip((mouse_x - left) / width, 0.0, 1.0))
                self.session.compare(self.session.document.compare, "split", split=share)
            if not imgui.is_mouse_down(self._held):
                if self.drag == "orbit" and self._moved <= STILL * self.actions.layout.scale:
                    top = io.display_size.y * points_to_pixels - bottom - height
                    y = (io.mouse_pos.y * points_to_pixels - top) / height
                    self.actions.pick((mouse_x - left) / width, y)
                self.drag = None
                self.session.end_gesture()
        elif inside:
            for button in (0, 1, 2):
                if imgui.is_mouse_clicked(button):
                    self.drag = self._kind(button, io.key_shift, mouse_x, left, width)
                    self._held, self._moved = button, 0.0
        if inside and io.mouse_wheel:
            self.actions.zoom(0.9**io.mouse_wheel)
        if not io.want_text_input:
            for key in typed:
                self._command(key)

    def _kind(self, button: int, shift: bool, x: float, left: int, width: int) -> str:
        document = self.session.document
        near = abs(x - left - document.split * width) < SPLIT_REACH * self.actions.layout.scale
        if document.compare == "split" and button == 0 and near:
            return "split"
        if button == 2 or (button == 0 and shift):
            return "pan"
        return "orbit" if button == 0 else "turn"

    def _dragged(self, dx: float, dy: float, height: int) -> None:
        if dx == 0.0 and dy == 0.0:
            return
        actions = self.actions
        if self.drag == "orbit":
            actions.look(orbit.orbit(actions.camera, -180.0 * dx / height, 180.0 * dy / height))
        elif self.drag == "pan":
            actions.look(orbit.pan(actions.camera, -dx / height, dy / height))
        elif self.drag == "turn":
            turned = self.session.shown.env_rotate - 180.0 * dx / height
            self.session.edit_shown("turn", env_rotate=round((turned + 180.0) % 360.0 - 180.0, 2))

    # -- keys --------------------------------------------------------------------------------------------------------

    def _command(self, typed: Typed) -> None:
        control, shift = typed.mods & glfw.MOD_CONTROL, typed.mods & glfw.MOD_SHIFT
        while_held, once = self._with_control(bool(shift)) if control else self._plain()
        for key in (typed.name, typed.key):
            if key in while_held:
                while_held[key]()
            elif key in once and not typed.repeated:
                once[key]()

    def _with_control(self, shift: bool) -> tuple[dict[str | int, Callable], dict[str | int, Callable]]:
        session, files = self.session, self.files
        save = lambda: files.save_scene(files.names["scene"])  # noqa: E731
        keep = {str(n): partial(self.actions.keep_bookmark, str(n)) for n in range(1, 10)}
        undo = {"z": session.redo if shift else session.undo, "y": session.redo}
        return undo, {"s": save, "o": files.choose, **keep}

    def _plain(self) -> tuple[dict[str | int, Callable], dict[str | int, Callable]]:
        actions, session = self.actions, self.session
        once = {
            "c": lambda: session.choose_mode("cloth" if session.in_curtain else "curtain"),
            "f": actions.frame_mesh,
            glfw.KEY_HOME: actions.home,
            glfw.KEY_TAB: actions.layout.toggle_panels,
            **{str(n): partial(actions.go_to_bookmark, str(n)) for n in range(1, 10)},
        }
        if session.in_curtain:
            return {glfw.KEY_RIGHT: actions.player.step}, {
                **once,
                glfw.KEY_SPACE: actions.toggle_play,
                "t": actions.toggle_tree,
            }
        return {}, {**once, "b": lambda: session.edit_scene(background=not session.scene.background)}
