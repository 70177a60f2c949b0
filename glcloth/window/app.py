"""The window itself: panels over the picture, and a loop that draws only when something changes."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

from .host import Host  # first: it brings the glfw library that imgui-bundle shares   # isort: skip
from imgui_bundle import imgui  # isort: skip
import glfw
import numpy as np

from ..curtain.show import camera_of
from ..errors import InputError, ShaderError
from ..light.environment import rotation_y
from ..picture.renderer import Frame, Renderer
from ..scene import CurtainParameters, Scene
from .curtain import Player
from .files import Files, frame_of
from .navigation import Navigation
from .panels import Panels
from .refine import Refiner
from .resources import Ready, Resources
from .screen import Look, Screen
from .slices import BUDGET
from .state import Document, Session
from .tree_window import TreeWindow

DEFAULT_SIZE = (1280, 720)  # points
PANEL = 400  # points: width of the panels
LATE = 0.012  # seconds into a step after which the screen waits for the next one
PATIENCE = 0.06  # seconds
QUIET = 0.7  # seconds without an event after which nobody is taken to be at work
WAKE = 3  # pictures of the panels after an event: hovering and fading settle within these
NOT_LIGHT = ("exposure", "view_transform")  # how a picture is shown
_CURTAIN_LOOK = Scene(curtain=CurtainParameters())


class App:
    """One window on one session.

    Parameters
    ----------
    scene : what to show first; a size that it does not give is chosen
    watch : reload shaders, fabric, mesh, environment and scene files when they change
    source : the file the scene came from, if any

    Raises NoOpenGLError without a display or OpenGL 4.3, and InputError for a scene that cannot be shown.
    """

    def __init__(self, scene: Scene, watch: bool = False, source: str | None = None):
        given = "size" in scene.model_fields_set
        wanted = tuple(scene.size if given else DEFAULT_SIZE)
        self.session = Session(scene.model_copy(update={"size": wanted}))
        self.session.resolve(scene.fabric)
        self.messages: list[tuple[str, str]] = []  # kind ("error" or "note"), text
        self.show_panels = True
        self.frames: list[Frame] = []
        self.ready: list[Ready | None] = []
        self.pending = True
        self.covered: int | None = None
        self.full_ms: float | None = None
        self._full_begin = 0.0
        self._awake = WAKE
        self._shown: Document | None = None
        self._curtain_drawn: tuple[list[Scene], bool] | None = None  # the sides, and whether B is layered
        self._go_to: int | None = frame_of(scene) if scene.curtain is not None else None
        self._ui_seconds = 0.005  # what the panels take of a step
        self._presented = 0.0
        self._last_heard = 0.0
        self._warming: Iterator[None] | None = None
        self._warm = False
        self._owed = False  # something is drawn and not yet shown
        self.navigation = Navigation(self)
        self.host = Host(wanted, PANEL, not given, self._heard, self.navigation.type, self._dropped)
        self.ctx = self.host.ctx
        self.scale = self.host.scale
        self.player: Player | None = None
        self.tree: TreeWindow | None = None
        try:
            self.renderer = Renderer(ctx=self.ctx)
            self.refiner = Refiner(self.renderer)
            self._screen = Screen(self.ctx)
        except BaseException:
            self.host.close()
            raise
        self.resources = Resources()
        self.files = Files(self, source, watch)
        self.panels = Panels(self)
        self.follow = not given or self._area() == wanted

    def close(self) -> None:
        """Free everything and close the window."""
        self.files.close()
        self.resources.close()
        if self.tree is not None:
            self.tree.close()
        if self.player is not None:
            self.player.release()
        self.refiner.release()
        self._screen.release()
        self.renderer = self.refiner = self._screen = self.panels = self.player = self.tree = None
        self.host.close()

    def _heard(self) -> None:
        self._awake = WAKE
        self._last_heard = time.perf_counter()

    def _dropped(self, paths: list[str]) -> None:
        for path in paths:
            self.files.open(path)

    # -- the loop ----------------------------------------------------------------------------------------------------

    def run(self) -> None:
        """Until the window is closed or Ctrl-C. Raises InputError when the first scene cannot be shown."""
        try:
            while not glfw.window_should_close(self.host.window):
                self.step()
        finally:
            self.close()

    def step(self) -> None:
        """Hear what happened, draw for a while, show it; or wait when there is nothing to do."""
        self._wait()
        begin = time.perf_counter()
        if glfw.get_window_attrib(self.host.window, glfw.ICONIFIED):
            return
        self.files.watch()
        self.files.dialogs.poll()
        self._panels()
        before = self._shown
        changed = self._follow_document()
        if self._shown is not before:
            self._presented = begin  # the answer has so long before the panels are shown without it
        # What was drawn in the last step is shown in this one, so that neither takes longer than a look at the input may.
        owed, self._owed = self._owed, False
        if self.busy and not owed:
            changed |= self._work(max(BUDGET - self._ui_seconds - 0.003, 0.012))
            self._owed = changed and time.perf_counter() - begin > LATE
        # While an answer is on its way the panels alone are shown again only now and then: it shows them too.
        soon = self.drawer.previewing and begin - self._presented < PATIENCE
        if not self._owed and (owed or changed or (self._awake > 0 and not soon)):
            self._present()
            self._presented = time.perf_counter()
            self._awake -= 1
        self.host.collect()

    @property
    def drawer(self) -> Refiner | Player:
        """What draws the scene that is shown."""
        return self.player if self.session.in_curtain and self.player is not None else self.refiner

    @property
    def busy(self) -> bool:
        """True while there is something to draw."""
        return not self.drawer.idle or (self.tree is not None and not self.tree.idle)

    @property
    def complete(self) -> bool:
        """True when the picture is what `render` makes of the scene."""
        return self.drawer.idle and not self.pending and self.session.document is self._shown

    @property
    def shows_something(self) -> bool:
        if self.session.in_curtain:
            return self.player is not None and self.player.sides != []
        return self.frames != []

    @property
    def frame(self) -> int:
        """The frame of the curtain that is shown; 0 for a cloth."""
        return self.player.frame if self.session.in_curtain and self.player else 0

    def _wait(self) -> None:
        if self._awake > 0 or self.busy or self._owed:
            glfw.poll_events()
        elif self.pending or self.files.dialogs.waiting:
            glfw.wait_events_timeout(0.03)
            self._awake = max(self._awake, 1)
        elif imgui.get_io().want_text_input:
            glfw.wait_events_timeout(0.4)  # the caret blinks
            self._awake = max(self._awake, 1)
        elif self._warming is not None and not self.session.in_curtain:
            glfw.wait_events_timeout(QUIET)
            if time.perf_counter() - self._last_heard > QUIET and next(self._warming, self) is self:
                self._warming, self._warm = None, True
        elif self.files.watching:
            glfw.wait_events_timeout(0.25)
        else:
            glfw.wait_events()

    def _work(self, budget: float) -> bool:
        until = time.perf_counter() + budget
        changed = False
        try:
            if not self.drawer.idle:
                # The tree's window shares the time, so that it follows while the curtain moves.
                share = 0.6 if self.tree is not None and not self.tree.idle else 1.0
                changed = self.drawer.work(share * budget)
                if self.drawer.idle:
                    self._refined()
            left = until - time.perf_counter()
            if self.tree is not None and not self.tree.idle and left > 0.003:
                self.tree.work(left)
                if self.tree.missed and self.tree.idle and self.player is not None:
                    self.player.tell_again()
                changed = True  # the panel says how many boxes there are
        except ShaderError as error:
            self.tell("error", errors_of(error))
            return True
        except InputError as error:
            self.tell("error", str(error))
            return True
        return changed

    def _refined(self) -> None:
        self.full_ms = 1e3 * (time.perf_counter() - self._full_begin)
        if not self.session.in_curtain:
            self.covered = self.renderer.covered_pixels()
            if not self._warm and self._warming is None and self.session.scene.method == "direct":
                # What edits of the weave may need is compiled while nobody does anything.
                self._warming = self.renderer.warm_up(self.frames[0])
        self._awake = max(self._awake, 2)  # the overlay says so, and fits its new text
        self.files.save_later()

    def _panels(self) -> None:
        begin = time.perf_counter()
        imgui.backends.opengl3_new_frame()
        imgui.backends.glfw_new_frame()
        imgui.new_frame()
        try:
            self.navigation.update()
            self.panels.draw()
        finally:
            imgui.render()
        self._ui_seconds += 0.2 * (min(time.perf_counter() - begin, 0.02) - self._ui_seconds)
        if not imgui.is_any_item_active() and self.navigation.drag is None:
            self.session.end_gesture()

    # -- from the document to pictures -------------------------------------------------------------------------------

    def forget(self) -> None:
        """Draw anew, whatever has been drawn."""
        self._shown = self._curtain_drawn = None

    def look_again(self) -> None:
        """Look at the files again, which may have changed."""
        self.pending = True
        self._awake = WAKE

    def _follow_document(self) -> bool:
        """Hand what the document asks for to what draws it; True when what is drawn already is to be shown otherwise."""
        self._follow_size()
        if self.tree is not None and self.tree.closed:
            self.toggle_tree()
        document = self.session.document
        if document is self._shown and not self.pending:
            return False
        try:
            return (self._follow_curtain if document.mode == "curtain" else self._follow_cloth)(document)
        except ShaderError as error:
            if not self.shows_something:
                raise
            self.tell("error", errors_of(error))
            self._shown, self.pending = document, False
            return True
        except InputError as error:
            if not self.shows_something:
                raise
            self.tell("error", str(error))
            self.session.reject()
            self.pending = True
            return True

    def _follow_cloth(self, document: Document) -> bool:
        fresh = document is not self._shown
        scenes = document.sides()
        ready = [self.resources.ask(scene, self.session.resolve(scene.fabric)) for scene in scenes]
        complete = all(r is not None for r in ready)
        if not fresh and not complete:
            return False
        self.pending = not complete
        self._shown = document
        last = [r for r in self.ready if r is not None]
        frames = []
        for number, scene in enumerate(scenes):
            have = ready[number] or (self.ready[number] if number < len(self.ready) else None) or (last or [None])[0]
            if have is None:
                return True
            frames.append(self._frame(scene, have, ready[number] is not None))
        if complete:
            self.ready = ready
        only_look = (
            bool(self.frames)
            and len(frames) == len(self.frames)
            and all(_same_light(new, old) for new, old in zip(frames, self.frames, strict=True))
        )
        self.frames = frames
        if only_look and self.refiner.sides:
            return True
        self.refiner.show(frames)
        self._full_begin = time.perf_counter()
        return False

    def _frame(self, scene: Scene, ready: Ready, complete: bool) -> Frame:
        """A frame of what is there; while tables or a fit are being made, the last light and the direct method serve."""
        lights = ready.lights if complete else ready.report.lights.rotated(rotation_y(scene.env_rotate))
        if not complete and scene.method == "paper":
            scene = scene.model_copy(update={"method": "direct"})
        return self.renderer.prepare(
            scene,
            fabric=self.session.resolve(scene.fabric),
            mesh=ready.mesh,
            environment=ready.environment,
            lights=lights,
            objects=ready.objects,
        )

    def _follow_curtain(self, document: Document) -> bool:
        scene, *others = document.sides()
        environment = self.resources.ask_curtain(scene, self.session.fabric)
        if others:
            # Read once, so that it is one and the same object from picture to picture.
            others = [others[0].model_copy(update={"fabric": self.session.resolve(others[0].fabric)})]
            if self.resources.ask_curtain(others[0], others[0].fabric) is None:
                environment = None
        fresh = document is not self._shown
        self._shown, self.pending = document, environment is None
        if environment is None:
            return fresh
        if self.player is None:
            self.player = Player(self.ctx, self._tree_follows)
        look = {name: getattr(_CURTAIN_LOOK, name) for name in NOT_LIGHT}
        wanted = [side.model_copy(update=look) for side in (scene, *others)], bool(others) and document.layered
        if wanted != self._curtain_drawn:
            self.player.show(scene, environment, others[0] if others else None, document.layered)
            self._full_begin = time.perf_counter()
            if self.tree is not None:
                self.tree.look_as(camera_of(scene))
            fresh = False
        self._curtain_drawn = wanted
        if self._go_to is not None:
            self.player.go_to(self._go_to)
            self._go_to = None
        return fresh

    def _tree_follows(self, curtain) -> None:
        if self.tree is not None:
            self.tree.follow(curtain)

    # -- where it is on the screen -----------------------------------------------------------------------------------

    def _area(self) -> tuple[int, int]:
        """Pixels that the panels leave for the picture."""
        width, height = self.host.framebuffer_size
        return max(width - self.panel_width(), 16), max(height, 16)

    def panel_width(self) -> int:
        """Width of the panels in pixels of the framebuffer."""
        return round(PANEL * self.scale * self.host.pixels_per_point) if self.show_panels else 0

    def _follow_size(self) -> None:
        if self.follow and (area := self._area()) != self.session.shown.size:
            self.session.move(size=area)

    def rectangle(self) -> tuple[int, int, int, int]:
        """Where the picture is in the framebuffer: left, bottom, width, height. Shrunk to fit, never enlarged."""
        area, size = self._area(), self.session.shown.size
        factor = min(1.0, area[0] / size[0], area[1] / size[1])
        width, height = max(1, round(size[0] * factor)), max(1, round(size[1] * factor))
        return (area[0] - width) // 2, (area[1] - height) // 2, width, height

    def _present(self) -> None:
        self._paint()
        self.host.draw_panels()
        glfw.swap_buffers(self.host.window)
        self.presented()

    def presented(self) -> None:
        """Called after each picture on the screen."""

    def _paint(self) -> None:
        screen = self.ctx.detect_framebuffer(0)
        screen.use()
        full = self.host.framebuffer_size
        self.ctx.viewport = (0, 0, *full)
        screen.clear(0.09, 0.09, 0.09, 1.0, viewport=(0, 0, *full))
        document = self.session.document
        shown = document.shown
        look = Look(shown.exposure, shown.view_transform, getattr(shown, "background", True))
        if document.mode == "cloth" or self.player is not None:
            self._screen.draw(
                self.drawer.sides, look, self.rectangle(), document.compare, document.split, document.difference_scale
            )

    def screen(self) -> np.ndarray:
        """The window as it is, uint8 [H, W, 3], top row first."""
        self._paint()
        self.host.draw_panels()
        return self.host.pixels()

    def tell(self, kind: str, text: str) -> None:
        """Show a line to the user until it is closed (errors) or pushed out by newer ones."""
        self.messages = [*[m for m in self.messages if m != (kind, text)][-4:], (kind, text)]
        self._awake = WAKE

    # -- what panels and keys do -------------------------------------------------------------------------------------

    def attempt(self, action, *arguments, **options) -> None:
        """Run an edit; an error becomes a message and nothing else changes."""
        try:
            action(*arguments, **options)
        except InputError as error:
            self.tell("error", str(error))

    def undo(self) -> None:
        """One edit back."""
        if self.session.undo():
            self._awake = WAKE

    def redo(self) -> None:
        """One undo back."""
        if self.session.redo():
            self._awake = WAKE

    def choose_fabric(self, name: str) -> None:
        """Take another fabric; in the curtain one without transmission gets a sheer's. Raises InputError."""
        self.session.choose_fabric(name)
        if self.session.in_curtain and self.session.resolve(name).transmission is None:
            self.tell("note", f"{name} has no [transmission]: that of a white sheer was added")

    def toggle_play(self) -> None:
        """Let the wind blow, or stop it."""
        if self.player is not None:
            if self.player.playing:
                self.player.pause()
                self._full_begin = time.perf_counter()
            else:
                self.player.play()

    def go_to(self, frame: int) -> None:
        """Show a frame of the moving curtain, from the beginning on."""
        self._go_to = frame
        self.pending = True

    def toggle_tree(self) -> None:
        """Open or close the window of the tree."""
        if self.tree is not None:
            self.tree.close()
            self.tree = None
            return
        try:
            self.tree = TreeWindow(self.host, self._typed_elsewhere)
        except RuntimeError as error:
            self.tell("error", f"the tree's window: {error}")
            return
        if self.player is not None:
            self.player.tell_again()

    def _typed_elsewhere(self, *key) -> None:
        self.navigation.type(*key)
        self._heard()

    def reload_shaders(self) -> None:
        """Take the shaders as they are now; when they do not compile, keep the old ones and say why."""
        fresh = Renderer(ctx=self.ctx)
        player = None
        try:
            display = Screen(self.ctx)
            refiner = Refiner(fresh)
            small = [replace(f, scene=f.scene.model_copy(update={"size": (16, 16), "spp": 1})) for f in self.frames]
            for frame in small:
                fresh.draw(frame)
            if self.player is not None and self.player.curtain is not None:
                trial = Player(self.ctx)
                trial.show(self.player.curtain.scene.changed(size=(16, 16), spp=1), self.player.curtain.environment)
                trial.hurry()
                trial.release()
                player = Player(self.ctx, self._tree_follows)
        except ShaderError as error:
            self.tell("error", errors_of(error))
            return
        self.refiner.release()
        self._screen.release()
        if player is not None:
            self._go_to = self.player.frame
            self.player.release()
            self.player = player
        self.renderer, self.refiner, self._screen = fresh, refiner, display
        self.forget()
        self.frames = []
        self.tell("note", "shaders reloaded")


def _same_light(new: Frame, old: Frame) -> bool:
    """True when two frames have the same linear picture: they differ in how it is shown at most."""
    same = replace(new, scene=new.scene.model_copy(update={n: getattr(old.scene, n) for n in NOT_LIGHT}))
    return (
        same.scene == old.scene
        and same.fabric is old.fabric
        and same.mesh is old.mesh
        and same.environment is old.environment
        and same.lights is old.lights
        and same.objects is old.objects
        and same.camera == old.camera
    )


def errors_of(error: ShaderError) -> str:
    """What does not compile, without a driver's warnings and headings."""
    lines = str(error).splitlines()
    return "\n".join([line for line in lines if "error" in line.lower()] or lines)
