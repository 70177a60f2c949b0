"""The window of the operating system: glfw, its OpenGL context, and imgui on it. Knows nothing of cloth."""

from __future__ import annotations

import ctypes
import gc
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

# imgui-bundle first: it brings the glfw library that both then share.
import imgui_bundle  # isort: skip
from imgui_bundle import imgui, implot  # isort: skip
import glfw
import moderngl
import numpy as np
from OpenGL import GL

from ..errors import InputError, NoOpenGLError
from ..gpu.context import REQUIRED, ask_display_for, is_software

FONT = 16.0  # points


class Typed(NamedTuple):
    """A key that went down, with its modifiers: between two slow pictures a key and its Ctrl may both come and go."""

    name: str  # as the keyboard's layout prints it
    key: int
    mods: int
    repeated: bool


class Host:
    """One window with panels. `window` is glfw's, `ctx` its moderngl context, `scale` its own units to a point (96 dpi),
    `typed` the keys and `dropped` the files that nobody has taken yet.

    Parameters
    ----------
    size : width and height of the picture, in pixels
    panel : points that the panels take beside it
    points : the size is in points instead: as large to the eye on any screen
    heard : called at any event
    device : number or name of the one that shall draw; None: the display's own

    Raises NoOpenGLError without a display or OpenGL 4.3, InputError where another device draws on the display.
    """

    def __init__(
        self,
        size: tuple[int, int],
        panel: int,
        points: bool,
        heard: Callable[[], None],
        device: int | str | None = None,
    ):
        glfw.ERROR_REPORTING = "ignore"
        wanted = None if device is None else ask_display_for(device)
        if not glfw.init():
            raise NoOpenGLError(
                f"no display for a window ({_reason() or 'glfw does not start'}); `glcloth render` needs none, "
                "or set DISPLAY or WAYLAND_DISPLAY"
            )
        context_hints()
        glfw.window_hint(glfw.VISIBLE, glfw.FALSE)  # until its size is known
        self.window = glfw.create_window(640, 360, "glcloth", None, None)
        if not self.window:
            reason = _reason()
            glfw.terminate()
            raise NoOpenGLError(
                f"no window with OpenGL {REQUIRED // 100}.{REQUIRED // 10 % 10} ({reason}); `glcloth render` finds "
                "other devices, `glcloth info` lists them"
            )
        glfw.make_context_current(self.window)
        self.ctx = moderngl.create_context(require=REQUIRED)
        if wanted not in (None, name := self.ctx.info["GL_RENDERER"]):
            glfw.terminate()
            raise InputError(f"--device {device}: is {wanted}, but {name} draws on this display; leave --device out")
        self.software = is_software(self.ctx)
        # Software rendering is late already; waiting for the screen as well would halve its rate.
        glfw.swap_interval(0 if self.software else 1)
        self.ctx.gc_mode = "context_gc"
        self.heard = heard
        self.typed: list[Typed] = []
        self.dropped: list[str] = []
        self.scale = glfw.get_window_content_scale(self.window)[0]
        if self.pixels_per_point != 1.0:
            self.scale = 1.0  # the window's own unit is the point: imgui scales by itself
        unit = self.scale if points else 1.0 / self.pixels_per_point
        self._show(unit * size[0] + self.scale * panel, unit * size[1])
        self._listen()
        self._start_imgui()

    def _show(self, width: float, height: float) -> None:
        """Show the window in a size of its own unit, no larger than the screen."""
        monitor = glfw.get_primary_monitor()
        _, _, most_x, most_y = glfw.get_monitor_workarea(monitor) if monitor else (0, 0, 1920, 1080)
        glfw.set_window_size(self.window, min(round(width), most_x), min(round(height), most_y))
        glfw.show_window(self.window)

    def _listen(self) -> None:
        for listen in (
            glfw.set_cursor_pos_callback,
            glfw.set_mouse_button_callback,
            glfw.set_scroll_callback,
            glfw.set_char_callback,
            glfw.set_window_focus_callback,
            glfw.set_window_refresh_callback,
            glfw.set_framebuffer_size_callback,
        ):
            listen(self.window, lambda *_: self.heard())
        glfw.set_key_callback(self.window, lambda _, *event: self.type(*event))
        glfw.set_drop_callback(self.window, self._drop)

    def _start_imgui(self) -> None:
        imgui.create_context()
        implot.create_context()
        imgui.get_io().set_ini_filename("")
        imgui.get_io().config_debug_highlight_id_conflicts = False  # tests/window/window_walk.py looks for them
        font = Path(imgui_bundle.__file__).parent / "assets" / "fonts" / "Roboto" / "Roboto-Regular.ttf"
        if font.is_file():
            imgui.get_io().fonts.add_font_from_file_ttf(str(font), FONT)
        imgui.get_style().scale_all_sizes(self.scale)
        imgui.get_style().font_scale_dpi = self.scale
        address = ctypes.cast(self.window, ctypes.c_void_p).value
        imgui.backends.glfw_init_for_opengl(address, True)
        imgui.backends.opengl3_init("#version 330")

    def type(self, key: int, scancode: int, action: int, mods: int) -> None:
        """Remember a key that went down, in this window or another one."""
        self.heard()
        if action != glfw.RELEASE:
            name = glfw.get_key_name(key, scancode) or ""
            self.typed.append(Typed(name.lower(), key, mods, action == glfw.REPEAT))

    def _drop(self, _, paths) -> None:
        self.heard()
        self.dropped += paths

    @property
    def framebuffer_size(self) -> tuple[int, int]:
        return glfw.get_framebuffer_size(self.window)

    @property
    def pixels_per_point(self) -> float:
        return self.framebuffer_size[0] / (glfw.get_window_size(self.window)[0] or 1)

    def clear(self) -> None:
        """Begin a picture of the window."""
        screen = self.ctx.detect_framebuffer(0)
        screen.use()
        self.ctx.viewport = (0, 0, *self.framebuffer_size)
        screen.clear(0.09, 0.09, 0.09, 1.0, viewport=self.ctx.viewport)

    def draw_panels(self) -> None:
        """Draw imgui's panels over the window."""
        imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())

    def pixels(self) -> np.ndarray:
        """The picture drawn and not yet shown: uint8 [H, W, 3], top row first."""
        size = self.framebuffer_size
        self.ctx.detect_framebuffer(0).use()
        GL.glReadBuffer(GL.GL_BACK)
        GL.glPixelStorei(GL.GL_PACK_ALIGNMENT, 1)
        data = GL.glReadPixels(0, 0, *size, GL.GL_RGB, GL.GL_UNSIGNED_BYTE)
        return np.frombuffer(data, "u1").reshape(size[1], size[0], 3)[::-1].copy()

    def collect(self) -> None:
        """Free the objects that Python has dropped; those released by hand are in moderngl's list as empty shells."""
        while self.ctx.objects:
            thing = self.ctx.objects.popleft()
            if hasattr(thing, "release"):
                thing.release()

    def close(self) -> None:
        """Close the window."""
        imgui.backends.opengl3_shutdown()
        imgui.backends.glfw_shutdown()
        implot.destroy_context()
        imgui.destroy_context()
        gc.collect()
        self.collect()
        glfw.destroy_window(self.window)
        glfw.terminate()


def context_hints() -> None:
    """Ask glfw for the OpenGL that we need, for the next window."""
    glfw.default_window_hints()
    glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, REQUIRED // 100)
    glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, REQUIRED // 10 % 10)
    glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)


def _reason() -> str:
    _, reason = glfw.get_error()
    return reason.decode(errors="replace") if isinstance(reason, bytes) else reason or ""
