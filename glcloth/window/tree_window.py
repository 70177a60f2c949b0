"""The acceleration structure in a window of its own, which follows the curtain's animation.   [Mat section 4.3.3]"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import glfw
import numpy as np
from OpenGL import GL

from ..curtain.show import CurtainShow, camera_of, hides
from ..geometry.camera import Camera
from ..tracing.tree_view import TreeContent, TreePicture
from . import orbit
from .clock import now
from .host import Host, context_hints
from .pictures import Side
from .screen import Look, Screen

SIZE = 640  # points a side


class TreeWindow:
    """The structure as `level` (None: its leaves) shows it, from the curtain's eye until it is dragged.

    It shares the first window's textures; only the copy to the screen is made with its own context.
    """

    def __init__(self, host: Host):
        """Keys that mean nothing here are the host's: play and pause work in both windows."""
        self._host = host
        context_hints()
        glfw.window_hint(glfw.FOCUS_ON_SHOW, glfw.FALSE)
        glfw.window_hint(glfw.FOCUSED, glfw.FALSE)
        self._side_length = round(SIZE * host.scale)
        self.window = glfw.create_window(self._side_length, self._side_length, "tree", None, host.window)
        if not self.window:
            raise RuntimeError("no second window")
        self._put_beside()
        glfw.make_context_current(self.window)
        glfw.swap_interval(0)
        self._framebuffer = GL.glGenFramebuffers(1)
        glfw.make_context_current(host.window)
        self.level: int | None = None
        self.deepest = 0
        self.boxes = 0
        self.frame = -1
        self._camera: Camera | None = None  # None: the curtain's
        self._content: TreeContent | None = None
        self._name = ""
        self._picture = TreePicture(host.ctx)
        self._screen = Screen(host.ctx)
        self._side = Side()
        self._plan: Iterator[None] | None = None
        self._stale = self._shown = False
        self._drag: tuple[int, float, float] | None = None
        glfw.set_cursor_pos_callback(self.window, self._moved)
        glfw.set_mouse_button_callback(self.window, self._button)
        glfw.set_scroll_callback(self.window, self._wheel)
        glfw.set_key_callback(self.window, self._key)
        glfw.set_framebuffer_size_callback(self.window, lambda *_: self._again())
        glfw.set_window_refresh_callback(self.window, lambda *_: self._again(False))

    def _put_beside(self) -> None:
        """Right of the first window, as far as the screen goes."""
        monitor = glfw.get_primary_monitor()
        if monitor:
            left, top, width, height = glfw.get_monitor_workarea(monitor)
            x, y = glfw.get_window_pos(self._host.window)
            x += glfw.get_window_size(self._host.window)[0] + 8
            x, y = (
                min(x, left + width - self._side_length),
                min(max(y, top), top + height - self._side_length),
            )
            glfw.set_window_pos(self.window, max(x, left), max(y, top))

    @property
    def closed(self) -> bool:
        return bool(glfw.window_should_close(self.window))

    @property
    def idle(self) -> bool:
        """True when the window is up to date."""
        return self._plan is None and not self._stale and self._shown

    def follow(self, curtain: CurtainShow) -> bool:
        """Take the structure of the present frame; nothing is drawn yet. False while the last one is being drawn."""
        if self._plan is not None:
            return False
        accelerator = "photons" if curtain.scene.gi == "photons" else curtain.scene.accelerator
        if accelerator == "brute":
            self._content = None
            self._title("brute force has no tree: choose kdtree or lbvh")
            return True
        self._content = curtain.tree_content(camera_of(curtain.scene))
        self._name, self.frame = accelerator, curtain.frame
        self.deepest = int(self._content.tree["depth"].max())
        self._stale = True
        return True

    def look_as(self, camera: Camera) -> None:
        """The curtain's eye has moved."""
        if self._content is not None and self._camera is None and self._content.camera != camera:
            self._content = dataclasses.replace(self._content, camera=camera)
            self._stale = True

    def show_level(self, level: int | None) -> None:
        """Show the boxes of one level, or (None) of the leaves."""
        if level != self.level:
            self.level = level
            self._stale = True

    def work(self, seconds: float) -> None:
        """Draw for about so long; the picture is shown once it is complete."""
        until = now() + seconds
        try:
            while True:
                if self._plan is None:
                    if self._stale and self._content is not None:
                        self._stale = False
                        self._plan = self._draw()
                    else:
                        if not self._shown:
                            self._present()
                        return
                next(self._plan)
                self._host.ctx.finish()
                if now() >= until:
                    return
        except StopIteration:
            self._plan = None
            self._present()
        except BaseException:
            self._plan = None
            raise

    def _draw(self) -> Iterator[None]:
        camera = self._eye()
        content = dataclasses.replace(self._content, camera=camera, hidden=hides(self._content.positions, camera))
        level = None if self.level is None else min(self.level, self.deepest)
        size = glfw.get_framebuffer_size(self.window)
        if min(size) < 1:
            return
        yield from self._picture.steps(content, size, level)
        self.boxes = self._picture.boxes
        what = "leaves" if level is None else f"level {level} of {self.deepest}"
        self._title(f"{self._name}, frame {self.frame}: {what}, {self.boxes} boxes")

    def _title(self, text: str) -> None:
        glfw.set_window_title(self.window, text)

    def _present(self) -> None:
        self._shown = True
        if self._picture.texture is None:
            return
        self._side.show(self._picture.texture)
        code = self._screen.encode(0, [self._side], Look()).texture
        self._host.ctx.finish()
        glfw.make_context_current(self.window)
        try:
            size = glfw.get_framebuffer_size(self.window)
            GL.glBindFramebuffer(GL.GL_READ_FRAMEBUFFER, self._framebuffer)
            GL.glFramebufferTexture2D(GL.GL_READ_FRAMEBUFFER, GL.GL_COLOR_ATTACHMENT0, GL.GL_TEXTURE_2D, code.glo, 0)
            GL.glBindFramebuffer(GL.GL_DRAW_FRAMEBUFFER, 0)
            filter = GL.GL_NEAREST if code.size == tuple(size) else GL.GL_LINEAR
            GL.glBlitFramebuffer(0, 0, *code.size, 0, 0, *size, GL.GL_COLOR_BUFFER_BIT, filter)
            glfw.swap_buffers(self.window)
        finally:
            glfw.make_context_current(self._host.window)

    def pixels(self) -> np.ndarray:
        """The picture as it is shown: uint8 [H, W, 3], top row first."""
        code = self._screen.encode(0, [self._side], Look()).texture
        return np.frombuffer(code.read(), "u1").reshape(code.height, code.width, 4)[::-1, :, :3].copy()

    # -- mouse and keys ----------------------------------------------------------------------------------------------

    def _eye(self) -> Camera:
        return self._camera or self._content.camera

    def _again(self, draw: bool = True) -> None:
        self._stale |= draw
        self._shown = False

    def _look(self, camera: Camera) -> None:
        self._camera = camera
        self._stale = True

    def _moved(self, _, x: float, y: float) -> None:
        if self._drag is None or self._content is None:
            return
        button, last_x, last_y = self._drag
        self._drag = button, x, y
        height = max(glfw.get_window_size(self.window)[1], 1)
        dx, dy = (x - last_x) / height, (y - last_y) / height
        if button == glfw.MOUSE_BUTTON_LEFT:
            self._look(orbit.orbit(self._eye(), -180.0 * dx, 180.0 * dy))
        else:
            self._look(orbit.pan(self._eye(), -dx, dy))

    def _button(self, _, button: int, action: int, mods: int) -> None:
        if action == glfw.PRESS:
            pan = button != glfw.MOUSE_BUTTON_LEFT or mods & glfw.MOD_SHIFT
            self._drag = (glfw.MOUSE_BUTTON_MIDDLE if pan else button, *glfw.get_cursor_pos(self.window))
        else:
            self._drag = None

    def _wheel(self, _, __: float, dy: float) -> None:
        if self._content is not None:
            self._look(orbit.zoom(self._eye(), 0.9**dy, 1.0))

    def _key(self, _, key: int, scancode: int, action: int, mods: int) -> None:
        if action == glfw.RELEASE:
            return
        if key in (glfw.KEY_UP, glfw.KEY_KP_ADD, glfw.KEY_EQUAL):
            self.show_level(min((-1 if self.level is None else self.level) + 1, self.deepest))
        elif key in (glfw.KEY_DOWN, glfw.KEY_KP_SUBTRACT, glfw.KEY_MINUS):
            self.show_level(None if not self.level else self.level - 1)
        elif key == glfw.KEY_HOME:
            self._camera, self._stale = None, True
        elif key == glfw.KEY_ESCAPE:
            glfw.set_window_should_close(self.window, True)
        else:
            self._host.type(key, scancode, action, mods)

    def close(self) -> None:
        """Free everything and close the window."""
        self._plan = None
        glfw.make_context_current(self.window)
        GL.glDeleteFramebuffers(1, [self._framebuffer])
        glfw.make_context_current(self._host.window)
        self._picture.release()
        self._screen.release()
        glfw.destroy_window(self.window)
