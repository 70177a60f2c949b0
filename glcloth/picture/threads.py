"""Threads near by, and prints: which pixels of a cloth show them, and what their program reads beside that of the others.
[own]"""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..fabric import Fabric
from ..geometry.mesh import Mesh
from ..gpu.buffers import TextureBuffer
from ..gpu.gbuffer import GBuffer, MeshBuffers
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..methods.method import Method
from ..methods.weave_maps import WeaveMaps, even_shares, far_footprint
from .frame import Frame
from .prints import Print, PrintTexture
from .uv_scale import guessed_scale

EVERYWHERE = 1e30  # metres: larger than any pixel


class Threads:
    """The threads of one cloth, and what is printed on it.

    A pixel that covers more than half a repeat of the weave, and more than two yarns, shows no thread; `woven` says whether a
    frame may have others. These have a program of their own, whose mean is that of the far cloth; all pixels of a printed
    cloth have it. `shown` says whether any pixel has it.
    """

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.shown = self.woven = False
        self.printed: tuple[Print, np.ndarray] | None = None  # with its mean
        self._maps = WeaveMaps(ctx)
        self._print = PrintTexture(ctx)
        self._uv = TextureBuffer(ctx, 16)
        self._written: Last[None] = Last()
        self._scale: Last[float] = Last()
        self._buffers: MeshBuffers
        self.in_metres, self.far = 1.0, 0.0
        self._fabric: Fabric

    def prepare(
        self,
        fabric: Fabric,
        buffers: MeshBuffers,
        frame: Frame,
        printed: tuple[Print, np.ndarray] | None = None,
    ) -> None:
        """Take a frame; cheap where nothing changed, and where none of its pixels can show threads.

        `printed`: what is printed on the cloth, and its mean colour, in which `fabric` is dyed.
        """
        self.woven, self.printed = self._near(fabric, buffers, frame), printed
        self.shown = self.woven or self.printed is not None
        if self.shown:
            mesh = buffers.mesh
            in_metres = self.woven or (self.printed is not None and self.printed[0].in_metres)
            self.in_metres = self.unit(mesh, frame) if in_metres else 1.0
            self._written.get(lambda: self._write(mesh, self.in_metres), mesh, self.in_metres)
            self._buffers, self._fabric = buffers, fabric

    def unit(self, mesh: Mesh, frame: Frame) -> float:
        """Metres in a UV unit."""
        return frame.scene.uv_scale or self._scale.get(lambda: guessed_scale(mesh), mesh)

    def _near(self, fabric: Fabric, buffers: MeshBuffers, frame: Frame) -> bool:
        """Whether a pixel may be near enough to show threads."""
        if not frame.scene.threads or fabric.weave is None or buffers.mesh.uv is None:
            return False
        self.far = far_footprint(fabric)
        return least_footprint(frame, buffers.low, buffers.high) < self.far

    def _write(self, mesh: Mesh, scale: float) -> None:
        assert mesh.uv is not None
        uv = np.zeros((len(mesh.uv), 4), "f4")
        uv[:, :2] = scale * np.asarray(mesh.uv, float)
        self._uv.write(uv)

    def _inputs(self, buffer: GBuffer) -> dict[str, Any]:
        """What inputs/picture/pixel_uv.glsl reads beside the G-buffer."""
        assert buffer.drawn is not None
        mesh = self._buffers
        return {
            "thread_points": mesh.vertices,
            "thread_corners": mesh.indices,
            "thread_uv": self._uv,
            "viewpoint": buffer.drawn.camera.viewpoint,
            "step_from_pixel": buffer.drawn.camera.step_from_pixel(buffer.size),
            "far_footprint": self.far,
        }

    def choose(self, buffer: GBuffer, near: bool) -> moderngl.Framebuffer:
        """The picture of a G-buffer, where only the pixels that show threads are covered, or only the others."""
        key = buffer.drawings, self.in_metres, self.far, self.printed is not None
        return buffer.part(near, lambda target: self._draw(target, buffer, near), *key)

    def _draw(self, target: moderngl.Framebuffer, buffer: GBuffer, near: bool) -> None:
        program = programs(self.ctx).screen("passes/picture/near.frag")
        own = {"wants_near": near, "depth": buffer.depth}
        limit = {"far_footprint": EVERYWHERE} if self.printed is not None else {}
        buffer.choose(target, program, {**self._inputs(buffer), **limit}, own)

    @property
    def source(self) -> str:
        """The file that stands for inputs/methods/threads.glsl."""
        return "inputs/methods/weave.glsl" if self.woven else "inputs/methods/printed.glsl"

    def defines(self, method: Method) -> dict[str, Any]:
        """Constants of the program for pixels that show threads, beside the method's own."""
        groups, lanes = method.woven_packing()
        each = " ".join(f"F({g});" for g in range(groups))
        weave = self._fabric.weave
        relief = {"RELIEF": 1} if self.woven and weave is not None and weave.relief else {}
        plain = {"ONE_COLOR": 1} if weave is not None and weave.thread_colors is None else {}
        ink = {} if self.printed is None else {"PRINT": 1}
        return {
            **method.defines(),
            **method.woven_defines(),
            "WEAVE": 1,
            "GROUPS": groups,
            "LANE_COUNT": lanes,
            "EACH_GROUP(F)": each,
            **relief,
            **plain,
            **ink,
        }

    def inputs(self, method: Method, buffer: GBuffer) -> dict[str, Any]:
        """What that program reads, beside the method's inputs."""
        if self.woven:
            maps = self._maps.inputs(self._fabric, *method.woven_packing())
        else:
            colors = np.array([yarn.albedo for yarn in self._fabric.yarn], "f4")
            maps = {"weave_A": colors, **even_shares(self._fabric, *method.woven_packing())}
        return {**self._inputs(buffer), **maps, **self.print_inputs(), **method.woven_inputs()}

    def print_inputs(self) -> dict[str, Any]:
        """What inputs/picture/print.glsl reads; nothing without a print."""
        if self.printed is None:
            return {}
        scale = 1.0 if self.printed[0].in_metres else self.in_metres
        return self._print.inputs(*self.printed, scale)


def least_footprint(frame: Frame, low: np.ndarray, high: np.ndarray) -> float:
    """Metres of cloth that a pixel covers at least on its shorter side, wherever a mesh may be in its box."""
    eye, (width, height) = np.asarray(frame.camera.eye), frame.scene.size
    if frame.camera.ortho is not None:
        return frame.camera.ortho / height
    distance = float(np.linalg.norm(np.maximum(np.maximum(low - eye, eye - high), 0.0)))
    distance = max(distance - 0.5 * frame.camera.aperture, 0.0)
    rays = frame.camera.ray_from_pixel((width, height))
    corners = rays @ np.array([[x, y, 1.0] for x in (0, width) for y in (0, height)]).T
    # A ray at the picture's corner is longer, and its pixel, seen along it, smaller.
    return distance * float(np.linalg.norm(rays[:, :2], axis=0).min() / (corners**2).sum(0).max())
