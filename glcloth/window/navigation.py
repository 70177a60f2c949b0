"""Mouse and keys over the picture: orbit, pan, zoom, turn the light, move the split; and what each key does."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from imgui_bundle import imgui  # isort: skip
import glfw
import numpy as np

from ..curtain.show import camera_of
from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from ..picture.renderer import default_camera
from ..scene import View
from . import orbit

if TYPE_CHECKING:
    from .app import App

SPLIT_REACH = 8  # points to either side of the split that take hold of it


class Typed(NamedTuple):
    """A key that went down, with its modifiers: between two slow pictures a key and its Ctrl may both come and go."""

    name: str  # what the keyboard's layout prints on it
    key: int
    mods: int
    repeated: bool


class Navigation:
    """Turns what the mouse and the keys do over the picture of an App into moves and edits."""

    def __init__(self, app: App):
        self.app = app
        self.drag: str | None = None
        self._held = 0  # the mouse button that drags
        self._typed: list[Typed] = []

    def type(self, *key) -> None:
        """Remember a key for the next picture."""
        self._typed.append(Typed(*key))

    # -- the eye -----------------------------------------------------------------------------------------------------

    @property
    def camera(self) -> Camera:
        """The camera of the picture."""
        shown = self.app.session.shown
        if self.app.session.in_curtain:
            return camera_of(shown)
        view = shown.camera
        if view.eye is not None and view.target is not None and view.fov_deg is not None:
            return Camera(view.eye, view.target, view.up, view.fov_deg)
        return default_camera(self.app.frames[0].mesh, shown)

    def look(self, camera: Camera) -> None:
        """Take another camera."""
        self.app.session.look(orbit.view_of(camera))

    def home(self) -> None:
        """The view that the scene comes with."""
        self.app.session.look(View())

    def _mesh(self) -> Mesh | None:
        """What is looked at; None before the first picture."""
        if self.app.session.in_curtain:
            curtain = self.app.player.curtain if self.app.player else None
            return curtain.simulation.mesh() if curtain else None
        return self.app.frames[0].mesh if self.app.frames else None

    def frame_mesh(self) -> None:
        """All of the cloth into the picture, from where the eye looks."""
        if (mesh := self._mesh()) is not None:
            width, height = self.app.session.shown.size
            self.look(orbit.frame(self.camera, mesh, width / height))

    # -- the mouse ---------------------------------------------------------------------------------------------------

    def update(self) -> None:
        """Do what was done since the last call."""
        io = imgui.get_io()
        if not self.app.shows_something:
            self._typed.clear()
            return
        points_to_pixels = io.display_framebuffer_scale.x
        left, _, width, height = self.app.rectangle()
        mouse_x = io.mouse_pos.x * points_to_pixels
        inside = not io.want_capture_mouse
        if self.drag is not None:
            # The motion of a picture comes before its release, which would otherwise swallow it.
            self._dragged(io.mouse_delta.x * points_to_pixels, io.mouse_delta.y * points_to_pixels, height)
            if self.drag == "split":
                share = float(np.clip((mouse_x - left) / width, 0.0, 1.0))
                self.app.session.compare(self.app.session.document.compare, "split", split=share)
            if not imgui.is_mouse_down(self._held):
                self.drag = None
                self.app.session.end_gesture()
        elif inside:
            for button in (0, 1, 2):
                if imgui.is_mouse_clicked(button):
                    self.drag = self._kind(button, io.key_shift, mouse_x, left, width)
                    self._held = button
        if inside and io.mouse_wheel:
            radius = 2.0 if self.app.session.in_curtain else self.app.frames[0].mesh.radius
            self.look(orbit.zoom(self.camera, 0.9**io.mouse_wheel, radius))
        typed, self._typed = self._typed, []
        if not io.want_text_input:
            for key in typed:
                self._command(key)

    def _kind(self, button: int, shift: bool, x: float, left: int, width: int) -> str:
        document = self.app.session.document
        near = abs(x - left - document.split * width) < SPLIT_REACH * self.app.scale
        if document.compare == "split" and button == 0 and near:
            return "split"
        if button == 2 or (button == 0 and shift):
            return "pan"
        return "orbit" if button == 0 else "turn"

    def _dragged(self, dx: float, dy: float, height: int) -> None:
        if dx == 0.0 and dy == 0.0:
            return
        if self.drag == "orbit":
            self.look(orbit.orbit(self.camera, -180.0 * dx / height, 180.0 * dy / height))
        elif self.drag == "pan":
            self.look(orbit.pan(self.camera, -dx / height, dy / height))
        elif self.drag == "turn":
            turned = self.app.session.shown.env_rotate - 180.0 * dx / height
            self.app.session.edit_shown("turn", env_rotate=round((turned + 180.0) % 360.0 - 180.0, 2))

    # -- keys --------------------------------------------------------------------------------------------------------

    def _command(self, typed: Typed) -> None:
        app, session = self.app, self.app.session
        if typed.mods & glfw.MOD_CONTROL:
            if typed.name == "z":
                app.redo() if typed.mods & glfw.MOD_SHIFT else app.undo()
            elif typed.name == "y":
                app.redo()
            elif typed.name == "s" and not typed.repeated:
                app.files.save_scene(app.panels.scene_path)
            elif typed.name == "o" and not typed.repeated:
                app.files.choose()
        elif session.in_curtain and typed.key == glfw.KEY_RIGHT:
            app.player.step()
        elif typed.repeated:
            return
        elif session.in_curtain and typed.key == glfw.KEY_SPACE:
            app.toggle_play()
        elif session.in_curtain and typed.name == "t":
            app.toggle_tree()
        elif typed.name == "c":
            session.choose_mode("cloth" if session.in_curtain else "curtain")
        elif typed.name == "f":
            self.frame_mesh()
        elif typed.key == glfw.KEY_HOME:
            self.home()
        elif typed.key == glfw.KEY_TAB:
            app.show_panels = not app.show_panels
        elif typed.name == "b" and not session.in_curtain:
            session.edit_scene(background=not session.scene.background)
