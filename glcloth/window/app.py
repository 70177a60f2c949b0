"""The window itself: a glfw window, the panels over the picture, and a loop that draws only when something changes."""

from __future__ import annotations

import gc
import time
from dataclasses import replace
from pathlib import Path

# imgui-bundle first: it brings the glfw library that both then share.
import imgui_bundle  # isort: skip
from imgui_bundle import imgui, implot  # isort: skip
import glfw
import moderngl
import numpy as np
from OpenGL import GL

from .. import __version__
from ..context import REQUIRED, is_software
from ..environment import rotation_y
from ..errors import InputError, NoOpenGLError, ShaderError
from ..image import check_output, write_image
from ..renderer import METHODS, Frame, Renderer, default_camera
from ..scene import Scene, View, load_scene
from . import orbit, sharing
from .panels import Panels
from .refine import BUDGET, Refiner
from .resources import Ready, Resources
from .screen import Screen
from .state import Document, Session
from .watch import SHADERS, Watcher

DEFAULT_SIZE = (1280, 720)
FONT = 16.0  # points
PANEL = 400  # width of the panels at 96 dpi
WAKE = 3  # pictures of the panels after an event: hovering and fading settle within these


class App:
    """One window on one session.

    Parameters
    ----------
    scene : what to show first; a size that it does not give is chosen
    watch : reload shaders, fabric, mesh, environment and scene files when they change
    source : the file the scene came from, if any

    Raises NoOpenGLError without a display or OpenGL 4.3.
    """

    def __init__(self, scene: Scene, watch: bool = False, source: str | None = None):
        check_shown(scene)
        wanted = scene.size if "size" in scene.model_fields_set else DEFAULT_SIZE
        self.session = Session(scene.model_copy(update={"size": tuple(wanted)}))
        self.session.resolve(scene.fabric)
        self.source = source
        self.messages: list[tuple[str, str]] = []  # kind ("error" or "note"), text
        self.show_panels = True
        self._awake = WAKE
        self._drag: str | None = None
        self._typed: list[tuple[str, int, int, bool]] = []
        self._shown: Document | None = None
        self.pending = True
        self.ready: list[Ready | None] = []
        self.frames: list[Frame] = []
        self._save: tuple[Path, bool] | None = None
        self._ui_seconds = 0.01
        self.covered: int | None = None
        self.full_ms: float | None = None
        self._full_begin = 0.0
        self.watcher = Watcher() if watch else None
        self._open_window(tuple(wanted))
        try:
            self.renderer = Renderer(ctx=self.ctx)
            self.refiner = Refiner(self.renderer)
            self._screen = Screen(self.ctx)
        except BaseException:
            self._close_window()
            raise
        self.resources = Resources()
        self.panels = Panels(self)
        self.follow = self._area() == tuple(wanted)

    # -- window and context ------------------------------------------------------------------------------------------

    def _open_window(self, wanted: tuple[int, int]) -> None:
        glfw.ERROR_REPORTING = "ignore"
        if not glfw.init():
            _, reason = glfw.get_error()
            reason = reason.decode(errors="replace") if isinstance(reason, bytes) else reason
            raise NoOpenGLError(
                f"no display for a window ({reason or 'glfw does not start'}); `glcloth render` needs none, "
                "or set DISPLAY or WAYLAND_DISPLAY"
            )
        glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, REQUIRED // 100)
        glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, REQUIRED // 10 % 10)
        glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
        glfw.window_hint(glfw.SCALE_TO_MONITOR, glfw.TRUE)
        monitor = glfw.get_primary_monitor()
        _, _, width, height = glfw.get_monitor_workarea(monitor) if monitor else (0, 0, 1920, 1080)
        size = min(wanted[0] + PANEL, width), min(wanted[1], height)
        self.window = glfw.create_window(*size, "glcloth", None, None)
        if not self.window:
            _, reason = glfw.get_error()
            glfw.terminate()
            raise NoOpenGLError(
                f"no window with OpenGL {REQUIRED // 100}.{REQUIRED // 10 % 10} ({reason}); `glcloth render` finds "
                "other devices, `glcloth info` lists them"
            )
        glfw.make_context_current(self.window)
        # Software rendering is late already; waiting for the screen as well would halve its rate.
        self.ctx = moderngl.create_context(require=REQUIRED)
        self.software = is_software(self.ctx)
        glfw.swap_interval(0 if self.software else 1)
        self.ctx.gc_mode = "context_gc"
        for listen in (
            glfw.set_cursor_pos_callback,
            glfw.set_mouse_button_callback,
            glfw.set_scroll_callback,
            glfw.set_char_callback,
            glfw.set_window_focus_callback,
            glfw.set_window_refresh_callback,
            glfw.set_framebuffer_size_callback,
        ):
            listen(self.window, self._heard)
        glfw.set_key_callback(self.window, self._key)
        glfw.set_drop_callback(self.window, self._dropped)
        imgui.create_context()
        implot.create_context()
        imgui.get_io().set_ini_filename("")
        self.scale = glfw.get_window_content_scale(self.window)[0]
        frame, screen = glfw.get_framebuffer_size(self.window), glfw.get_window_size(self.window)
        if frame[0] != screen[0]:
            self.scale = 1.0  # points: imgui scales by itself
        font = Path(imgui_bundle.__file__).parent / "assets" / "fonts" / "Roboto" / "Roboto-Regular.ttf"
        if font.is_file():
            imgui.get_io().fonts.add_font_from_file_ttf(str(font), FONT)
        imgui.get_style().scale_all_sizes(self.scale)
        imgui.get_style().font_scale_dpi = self.scale
        import ctypes

        address = ctypes.cast(self.window, ctypes.c_void_p).value
        imgui.backends.glfw_init_for_opengl(address, True)
        imgui.backends.opengl3_init("#version 330")

    def _close_window(self) -> None:
        imgui.backends.opengl3_shutdown()
        imgui.backends.glfw_shutdown()
        implot.destroy_context()
        imgui.destroy_context()
        gc.collect()
        self._collect()
        glfw.destroy_window(self.window)
        glfw.terminate()

    def close(self) -> None:
        """Free everything and close the window."""
        self.resources.close()
        self.refiner.release()
        self._screen.release()
        self.renderer = self.refiner = self._screen = self.panels = None
        self._close_window()

    def _collect(self) -> None:
        """Free what Python has dropped; what was released by hand is in moderngl's list as well, as an empty shell."""
        while self.ctx.objects:
            thing = self.ctx.objects.popleft()
            if hasattr(thing, "release"):
                thing.release()

    def _heard(self, *_) -> None:
        self._awake = WAKE

    def _key(self, _, key: int, scancode: int, action: int, mods: int) -> None:
        # Kept with their modifiers: between two slow pictures a key and its Ctrl may both have come and gone.
        self._heard()
        if action != glfw.RELEASE:
            name = glfw.get_key_name(key, scancode) or ""
            self._typed.append((name.lower(), key, mods, action == glfw.REPEAT))

    def _dropped(self, _, paths) -> None:
        self._heard()
        for path in paths:
            self.open(path)

    # -- the loop ----------------------------------------------------------------------------------------------------

    def run(self) -> None:
        """Until the window is closed or Ctrl-C. Raises InputError when the first scene cannot be shown."""
        try:
            while not glfw.window_should_close(self.window):
                self.step()
        finally:
            self.close()

    def step(self) -> None:
        """Hear what happened, draw for a while, show it; or wait when there is nothing to do."""
        self._wait()
        begin = time.perf_counter()
        if glfw.get_window_attrib(self.window, glfw.ICONIFIED):
            return
        self._watch()
        self._panels()
        changed = self._follow_document()
        drawn = 0.0
        if not self.refiner.idle:
            start = time.perf_counter()
            budget = max(BUDGET - self._ui_seconds, 0.012)
            changed |= self._work(budget)
            drawn = time.perf_counter() - start
        if changed or self._awake > 0:
            self._present()
            self._awake -= 1
            # Only drawing is in the budget's hands; the panels' share is what it must leave.
            self._ui_seconds += 0.2 * (min(time.perf_counter() - begin - drawn, 0.1) - self._ui_seconds)
        self._collect()

    def _wait(self) -> None:
        if self._awake > 0 or not self.refiner.idle:
            glfw.poll_events()
        elif self.pending:
            glfw.wait_events_timeout(0.03)
            self._awake = max(self._awake, 1)
        elif imgui.get_io().want_text_input:
            glfw.wait_events_timeout(0.4)  # the caret blinks
            self._awake = max(self._awake, 1)
        elif self.watcher is not None:
            glfw.wait_events_timeout(0.25)
        else:
            glfw.wait_events()

    def _work(self, budget: float) -> bool:
        try:
            changed = self.refiner.work(budget)
        except ShaderError as error:
            self.tell("error", errors_of(error))
            return True
        if self.refiner.idle:
            self.full_ms = 1e3 * (time.perf_counter() - self._full_begin)
            self.covered = self.renderer.covered_pixels()
            self._awake = max(self._awake, 2)  # the overlay says so, and fits its new text
            if self._save is not None:
                self._write(*self._save)
        return changed

    def _panels(self) -> None:
        imgui.backends.opengl3_new_frame()
        imgui.backends.glfw_new_frame()
        imgui.new_frame()
        try:
            self._navigate()
            self.panels.draw()
        finally:
            imgui.render()
        if not imgui.is_any_item_active() and self._drag is None:
            self.session.end_gesture()

    # -- from the document to frames ---------------------------------------------------------------------------------

    def _follow_document(self) -> bool:
        """Hand the refiner what the document asks for; True when that is something new."""
        self._follow_size()
        document = self.session.document
        if document is self._shown and not self.pending:
            return False
        fresh = document is not self._shown
        scenes = document.sides()
        try:
            ready = [self.resources.ask(scene, self.session.resolve(scene.fabric)) for scene in scenes]
        except InputError as error:
            if not self.frames:
                raise
            self.tell("error", str(error))
            self.session.reject()
            self.pending = True
            return True
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
        if not only_look or self.refiner.sides == []:
            self.refiner.show(frames)
            self._full_begin = time.perf_counter()
        return True

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
        )

    def _area(self) -> tuple[int, int]:
        """Pixels that the panels leave for the picture."""
        width, height = glfw.get_framebuffer_size(self.window)
        return max(width - self.panel_width(), 16), max(height, 16)

    def panel_width(self) -> int:
        """Width of the panels in pixels of the framebuffer."""
        if not self.show_panels:
            return 0
        points = glfw.get_window_size(self.window)[0] or 1
        return round(PANEL * self.scale * glfw.get_framebuffer_size(self.window)[0] / points)

    def _follow_size(self) -> None:
        if self.follow and (area := self._area()) != self.session.scene.size:
            self.session.move(size=area)

    def rectangle(self) -> tuple[int, int, int, int]:
        """Where the picture is in the framebuffer: left, bottom, width, height. Shrunk to fit, never enlarged."""
        area, size = self._area(), self.session.scene.size
        factor = min(1.0, area[0] / size[0], area[1] / size[1])
        width, height = max(1, round(size[0] * factor)), max(1, round(size[1] * factor))
        return (area[0] - width) // 2, (area[1] - height) // 2, width, height

    # -- on the screen -----------------------------------------------------------------------------------------------

    def _present(self) -> None:
        self._paint()
        imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())
        glfw.swap_buffers(self.window)
        self.presented()

    def presented(self) -> None:
        """Called after each picture on the screen."""

    def _paint(self) -> None:
        screen = self.ctx.detect_framebuffer(0)
        screen.use()
        full = glfw.get_framebuffer_size(self.window)
        self.ctx.viewport = (0, 0, *full)
        screen.clear(0.09, 0.09, 0.09, 1.0, viewport=(0, 0, *full))
        document = self.session.document
        self._screen.draw(
            self.refiner.sides,
            document.scene,
            self.rectangle(),
            document.compare,
            document.split,
            document.difference_scale,
        )

    def tell(self, kind: str, text: str) -> None:
        """Show a line to the user until it is closed (errors) or pushed out by newer ones."""
        self.messages = [*[m for m in self.messages if m != (kind, text)][-4:], (kind, text)]
        self._awake = WAKE

    # -- mouse and keys ----------------------------------------------------------------------------------------------

    def camera(self):
        """The camera of the picture."""
        scene = self.session.scene
        if scene.camera.eye is not None or not self.frames:
            view = scene.camera
            if view.eye is not None and view.target is not None and view.fov_deg is not None:
                return orbit.Camera(view.eye, view.target, view.up, view.fov_deg)
        return default_camera(self.frames[0].mesh, scene)

    def _navigate(self) -> None:
        io = imgui.get_io()
        if not self.frames:
            self._typed.clear()
            return
        points_to_pixels = io.display_framebuffer_scale.x
        left, _, width, height = self.rectangle()
        mouse_x = io.mouse_pos.x * points_to_pixels
        inside = not io.want_capture_mouse
        if self._drag is not None:
            # The motion of a picture comes before its release, which would otherwise swallow it.
            self._dragged(io.mouse_delta.x * points_to_pixels, io.mouse_delta.y * points_to_pixels, height)
            if self._drag == "split":
                share = float(np.clip((mouse_x - left) / width, 0.0, 1.0))
                self.session.compare(self.session.document.compare, "split", split=share)
            if not imgui.is_mouse_down(self._button):
                self._drag = None
                self.session.end_gesture()
        elif inside:
            for button in (0, 1, 2):
                if imgui.is_mouse_clicked(button):
                    self._drag = self._drag_kind(button, io.key_shift, mouse_x, left, width)
                    self._button = button
        if inside and io.mouse_wheel:
            radius = self.frames[0].mesh.radius
            self.look(orbit.zoom(self.camera(), 0.9**io.mouse_wheel, radius))
        typed, self._typed = self._typed, []
        if not io.want_text_input:
            for name, key, mods, repeated in typed:
                self._command(name, key, mods, repeated)

    def _drag_kind(self, button: int, shift: bool, x: float, left: int, width: int) -> str:
        document = self.session.document
        if document.compare == "split" and button == 0 and abs(x - left - document.split * width) < 8 * self.scale:
            return "split"
        if button == 2 or (button == 0 and shift):
            return "pan"
        return "orbit" if button == 0 else "turn"

    def _dragged(self, dx: float, dy: float, height: int) -> None:
        if dx == 0.0 and dy == 0.0:
            return
        if self._drag == "orbit":
            self.look(orbit.orbit(self.camera(), -180.0 * dx / height, 180.0 * dy / height))
        elif self._drag == "pan":
            self.look(orbit.pan(self.camera(), -dx / height, dy / height))
        elif self._drag == "turn":
            turned = self.session.scene.env_rotate - 180.0 * dx / height
            self.session.edit_scene("turn", env_rotate=round((turned + 180.0) % 360.0 - 180.0, 2))

    def look(self, camera) -> None:
        """Take another camera."""
        self.session.look(orbit.view_of(camera))

    def frame_mesh(self) -> None:
        """The whole mesh into the picture, from where the eye looks."""
        if self.frames:
            size = self.session.scene.size
            self.look(orbit.frame(self.camera(), self.frames[0].mesh, size[0] / size[1]))

    def home(self) -> None:
        """The view that the mesh comes with."""
        self.session.look(View())

    def _command(self, name: str, key: int, mods: int, repeated: bool) -> None:
        """What a key does; `name` is what the keyboard's layout prints on it."""
        if mods & glfw.MOD_CONTROL:
            if name == "z":
                self.redo() if mods & glfw.MOD_SHIFT else self.undo()
            elif name == "y":
                self.redo()
            elif name == "s" and not repeated:
                self.panels.save_scene()
        elif repeated:
            return
        elif name == "f":
            self.frame_mesh()
        elif key == glfw.KEY_HOME:
            self.home()
        elif key == glfw.KEY_TAB:
            self.show_panels = not self.show_panels
        elif name == "b":
            self.session.edit_scene(background=not self.session.scene.background)

    def undo(self) -> None:
        """One edit back."""
        if self.session.undo():
            self._awake = WAKE

    def redo(self) -> None:
        """One undo back."""
        if self.session.redo():
            self._awake = WAKE

    # -- files -------------------------------------------------------------------------------------------------------

    def attempt(self, action, *arguments, **options) -> None:
        """Run an edit; an error becomes a message and nothing else changes."""
        try:
            action(*arguments, **options)
        except InputError as error:
            self.tell("error", str(error))

    def open(self, path: str) -> None:
        """Open a file by what it is: scene, picture, fabric, mesh or environment. Errors become messages."""
        self.attempt(self._open, str(path))

    def _open(self, path: str) -> None:
        kind = sharing.kind_of(path)
        if kind == "fabric":
            self.session.choose_fabric(path)
        elif kind == "scene":
            scene = load_scene(path)
            check_shown(scene)
            self.session.open(scene)
            self.source = path
            self.follow = False
        else:
            self.session.edit_scene(**{kind: path})

    def save_picture(self, path: str, panels: bool = False) -> None:
        """Write the picture (.png, .exr) once it is refined, or the window as it is (.png). Raises InputError."""
        target = check_output(path)
        if panels and target.suffix.lower() != ".png":
            raise InputError(f"{target}: the window with its panels is saved as .png")
        if self.refiner.idle and not self.pending and self.session.document is self._shown:
            self._write(target, panels)
        else:
            self._save = target, panels
            self.tell("note", f"{target} will be written as soon as the picture is refined")

    def picture(self) -> np.ndarray:
        """What `render` returns for the scene: float32 [H, W, 3 or 4], linear, top row first; once refined."""
        scene = self.session.scene
        data = np.frombuffer(self.refiner.sides[0].texture.read(), "f4").reshape(scene.size[1], scene.size[0], 4)[::-1]
        return data[..., :3].copy() if scene.background else data.copy()

    def screen(self) -> np.ndarray:
        """The window as it is, uint8 [H, W, 3], top row first."""
        self._paint()
        imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())
        size = glfw.get_framebuffer_size(self.window)
        self.ctx.detect_framebuffer(0).use()
        GL.glReadBuffer(GL.GL_BACK)
        GL.glPixelStorei(GL.GL_PACK_ALIGNMENT, 1)
        data = GL.glReadPixels(0, 0, *size, GL.GL_RGB, GL.GL_UNSIGNED_BYTE)
        return np.frombuffer(data, "u1").reshape(size[1], size[0], 3)[::-1].copy()

    def _write(self, path: Path, panels: bool) -> None:
        self._save = None
        scene = self.session.scene
        settings = {"glcloth": __version__, "scene": scene.model_dump(mode="json")}
        try:
            if panels:
                from ..color import srgb_decode

                write_image(path, srgb_decode(self.screen() / 255.0), settings)
            else:
                write_image(
                    path, self.picture(), settings, exposure=scene.exposure, view_transform=scene.view_transform
                )
        except InputError as error:
            self.tell("error", str(error))
            return
        self.tell("note", f"wrote {path}")

    def copy(self, text: str, what: str) -> None:
        """Put text into the clipboard."""
        glfw.set_clipboard_string(self.window, text)
        self.tell("note", f"copied {what}")

    # -- files that change -------------------------------------------------------------------------------------------

    def _watch(self) -> None:
        if self.watcher is None:
            return
        scene = self.session.scene
        names = [scene.mesh, scene.env, self.source, self.session.document.origin]
        for name in self.watcher.changed({n for n in names if isinstance(n, str) and Path(n).is_file()}):
            if name == SHADERS:
                self._reload_shaders()
            elif name == self.session.document.origin:
                self.attempt(self._reload_fabric, name)
            elif name == self.source:
                self.open(name)
            self.pending = True
            self._awake = WAKE

    def _reload_fabric(self, name: str) -> None:
        self.session.reread(name)
        self.session.choose_fabric(name)
        self._shown = None

    def _reload_shaders(self) -> None:
        """Take the shaders as they are now; when they do not compile, keep the old ones and say why."""
        fresh = Renderer(ctx=self.ctx)
        try:
            display = Screen(self.ctx)
            refiner = Refiner(fresh)
            if self.frames:
                small = [replace(f, scene=f.scene.model_copy(update={"size": (16, 16), "spp": 1})) for f in self.frames]
                for frame in small:
                    fresh.draw(frame)
        except ShaderError as error:
            self.tell("error", errors_of(error))
            return
        self.refiner.release()
        self._screen.release()
        self.renderer, self.refiner, self._screen = fresh, refiner, display
        self._shown = None
        self.frames = []
        self.tell("note", "shaders reloaded")


def _same_light(new: Frame, old: Frame) -> bool:
    """True when two frames have the same linear picture: they differ in how it is shown at most."""
    shown = ("exposure", "view_transform")
    same = replace(new, scene=new.scene.model_copy(update={n: getattr(old.scene, n) for n in shown}))
    return (
        same.scene == old.scene
        and same.fabric is old.fabric
        and same.mesh is old.mesh
        and same.environment is old.environment
        and same.lights is old.lights
        and same.camera == old.camera
    )


def check_shown(scene: Scene) -> None:
    """Raise InputError for a scene that the window cannot show."""
    if scene.method not in METHODS:
        raise InputError(
            f"method {scene.method}: the window shows {', '.join(METHODS)}; "
            "use `glcloth render` or `glcloth animate` for this scene"
        )


def errors_of(error: ShaderError) -> str:
    """What does not compile, without a driver's warnings and headings."""
    lines = str(error).splitlines()
    return "\n".join([line for line in lines if "error" in line.lower()] or lines)
