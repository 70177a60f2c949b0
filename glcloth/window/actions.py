"""The actions and questions open to panels, keys and files; they touch nothing else of the window."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace
from itertools import count

import glfw
import moderngl
import numpy as np

from ..geometry.camera import Camera
from ..geometry.parts import fit, names_of
from ..geometry.raw import Names
from ..gpu.memo import Last
from ..light.fit_report import FitReport
from ..picture.masks import mask_colors, part_pattern
from ..picture.uv_scale import guessed_scale
from ..scene import View
from . import orbit
from .curtain import Player
from .drawing import Drawing
from .layout import Layout
from .messages import Messages
from .state import Session
from .thread_counter import Glass, glass_at
from .tree_window import TreeWindow


def free_name(names: Container[str]) -> str:
    """The first number that is none of the names."""
    return next(str(n) for n in count(1) if str(n) not in names)


class Actions:
    """Edits go to `session`, by `attempt` where they may fail; `layout` places the panels, `messages` holds the notes.

    Everything else that can be done is a method, everything that can be asked a property.
    """

    def __init__(self, session: Session, drawing: Drawing, layout: Layout, messages: Messages):
        self.session, self.layout, self.messages = session, layout, messages
        self.attempt, self.note = messages.attempt, messages.note
        self.go_to, self.toggle_tree, self.picture = drawing.go_to, drawing.toggle_tree, drawing.picture
        self.reload_shaders = drawing.reload_shaders
        self._drawing = drawing
        self._scale: Last[float] = Last()  # metres a UV unit of the mesh

    # -- questions ---------------------------------------------------------------------------------------------------

    @property
    def shows_something(self) -> bool:
        return self._drawing.shows_something

    @property
    def complete(self) -> bool:
        """True when the picture is what `render` makes of the scene."""
        return self._drawing.complete

    @property
    def waits_for(self) -> str:
        """The part of the picture that is still being made, in words; empty for none."""
        return self._drawing.resources.doing if self._drawing.pending else ""

    @property
    def status(self) -> list[str]:
        """The work under way, in words."""
        return self._drawing.drawer.status(self.session.shown)

    @property
    def device(self) -> tuple[str, bool]:
        """The device that draws, and whether it is software."""
        host = self._drawing.host
        return host.ctx.info["GL_RENDERER"], host.software

    @property
    def light(self) -> FitReport | None:
        """How the lights of the cloth were fitted."""
        ready = self._drawing.ready
        return ready[0].report if ready and ready[0] is not None else None

    @property
    def player(self) -> Player:
        """The curtain: its state and progress."""
        return self._drawing.player

    @property
    def frame(self) -> int:
        """The frame of the curtain that is shown; 0 for a cloth."""
        return self.player.frame if self.session.in_curtain else 0

    @property
    def tree(self) -> TreeWindow | None:
        """The tree's window, while it is open."""
        return self._drawing.tree

    def screen(self) -> np.ndarray:
        """The window as it is, uint8 [H, W, 3], top row first."""
        self.paint()
        return self._drawing.host.pixels()

    @property
    def parts(self) -> list[str]:
        """The parts of the cloth that a fabric can be given to, by the first of their names; none where it is all one."""
        meshes = next((ready.meshes for ready in self._drawing.ready if ready is not None), ())
        names = list(dict.fromkeys(part_pattern(part[0]) for mesh in meshes for part in names_of(mesh)))
        return names if len(names) > 1 and not self.session.in_curtain else []

    # -- actions -----------------------------------------------------------------------------------------------------

    def paint(self) -> None:
        """Draw the window: the picture and the panels over it."""
        host = self._drawing.host
        host.clear()
        self._drawing.paint(self.layout.rectangle())
        host.draw_panels()

    def copy(self, text: str) -> None:
        """Put a text into the clipboard."""
        glfw.set_clipboard_string(self._drawing.host.window, text)

    def choose_fabric(self, name: str) -> None:
        """Take another fabric; in the curtain one without transmission gets a sheer's. Raises InputError."""
        self.session.choose_fabric(name)
        if self.session.in_curtain and self.session.resolve(name).transmission is None:
            self.note(f"{name} has no [transmission]: a white sheer's was added")

    @property
    def camera(self) -> Camera:
        """The camera of the picture."""
        return self._drawing.drawer.camera(self.session.shown)

    def look(self, camera: Camera) -> None:
        """Take another camera: no step of undo."""
        self.session.look(orbit.view_of(camera))

    def home(self) -> None:
        """The view that the scene comes with."""
        self.session.look(View())

    def choose_view(self, name: str) -> None:
        """Look from where a view by name does. Raises InputError for one that is unknown here."""
        view = View(view=name)
        self._drawing.drawer.camera(self.session.shown.model_copy(update={"camera": view}))
        self.session.look(view)

    def keep_bookmark(self, name: str = "") -> None:
        """Keep the present camera in the scene, under the first free number where no name is given."""
        shown = self.session.shown
        name = name or free_name([one.name for one in shown.bookmarks])
        self.session.edit_shown(bookmarks=shown.with_bookmark(name, View.of(self.camera)))
        self.note(f"bookmark {name}: this view")

    def go_to_bookmark(self, name: str) -> None:
        """Look as a bookmark does; without one of this name nothing happens."""
        if (view := self.session.shown.bookmark(name)) is not None:
            self.session.look(view)

    def drop_bookmark(self, name: str) -> None:
        """Take a bookmark out of the scene."""
        self.session.edit_shown(bookmarks=self.session.shown.with_bookmark(name, None))

    def frame_mesh(self) -> None:
        """All of the cloth into the picture, from where the eye looks."""
        if (mesh := self._drawing.drawer.mesh) is not None:
            width, height = self.session.shown.size
            self.look(orbit.frame(self.camera, mesh, width / height))

    def zoom(self, factor: float) -> None:
        """Scale the eye's distance."""
        radius = 2.0 if self.session.in_curtain else self._drawing.refiner.frames[0].whole.radius
        self.look(orbit.zoom(self.camera, factor, radius))

    def near_picture(self) -> tuple[moderngl.Texture | None, float]:
        """The cloth near by as the screen takes it, or None while it is made, and its width over its height.

        It is drawn as long as it is asked for.
        """
        near = self._drawing.look_near()
        return near.texture(self._drawing.look), near.aspect

    def go_near(self) -> None:
        """Come so near to what the eye looks at that the picture is four centimetres wide."""
        camera, (width, height) = self.camera, self.session.shown.size
        glass = self.glass(width / 2, height / 2)
        target = np.asarray(camera.target if glass is None else glass.middle)
        back = np.subtract(camera.eye, target)
        distance = 0.02 / np.tan(np.radians(camera.fov_deg / 2)) * height / width
        eye = target + back / np.linalg.norm(back) * distance
        parallel = {} if camera.ortho is None else {"ortho": 0.04 * height / width}
        self.look(replace(camera, eye=tuple(eye), target=tuple(target), **parallel))

    def glass(self, x: float, y: float) -> Glass | None:
        """The square centimetre of the cloth under a place of the picture, from its top left corner."""
        mesh = self._drawing.drawer.mesh if not self.session.in_curtain else None
        if mesh is None or mesh.uv is None:
            return None
        scale = self.session.scene.uv_scale or self._scale.get(lambda: guessed_scale(mesh), mesh)
        return glass_at(mesh, self.camera, self.session.shown.size, x, y, scale)

    def pick(self, x: float, y: float) -> None:
        """Edit the fabric of what is at a place of the picture, from 0 to 1 from its top left corner: a part, or a colour of
        its fabric mask."""
        session = self.session
        found = None if session.in_curtain else self._drawing.refiner.renderer.pick(x, y)
        if found is None or not (self.parts or session.scene.fabrics):
            return
        colors = mask_colors(session.scene.fabrics)
        patterns = [name for name in session.scene.fabrics if name not in colors]
        if found.mask > len(colors):  # the picture is of an earlier scene
            return
        if found.mask:
            part = colors[found.mask - 1]
        else:
            names = self._names(found.names)
            fits = [(how, name) for name in patterns if (how := fit(name, names))]
            part = max(fits)[1] if fits else part_pattern(names[0])
        session.pick_part(part)

    def _names(self, part: Names) -> Names:
        """All names of a part of the meshes."""
        meshes = [mesh for ready in self._drawing.ready if ready is not None for mesh in ready.meshes]
        known = [names for mesh in meshes for names in names_of(mesh)]
        return next((names for names in known if names == part), None) or next(
            (names for names in known if names[:-1] == part), part or ("",)
        )

    def toggle_play(self) -> None:
        """Let the wind blow, or stop it."""
        (self.player.pause if self.player.playing else self.player.play)()

    def look_again(self, anew: bool = False) -> None:
        """Look at the files again, which may have changed; `anew`: and draw, whatever has been drawn."""
        self._drawing.pending = True
        if anew:
            self._drawing.forget()
