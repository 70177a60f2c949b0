"""By which way pixels are shaded on a device: fragments or compute, measured once for each method and kept.   [own]"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import get_args

import moderngl
import numpy as np

from .. import __version__
from ..errors import ShaderError
from ..gpu.buffers import read_texture
from ..gpu.context_local import of_context
from ..gpu.covered import Way
from ..gpu.gbuffer import GBuffer
from ..kept import keep, kept_path, read_kept
from ..scene import MethodName, Scene
from ..visibility.pixels import PixelView
from .cloth import ClothSurface
from .surface import Surface

LEAST_PIXELS = 250 * 190  # of a picture: for less a choice is not worth its compiler
LEAST_COVERED = 1000
BAND_MS = 5.0  # what a band of the picture takes that is measured,
ROUNDS = 5  # so often by each way
GAIN = 0.9  # of the fragments' time: compute must take less, so that noise chooses nothing
ALIKE = 1e-3  # relative: where the two differ by more, one of them is wrong, and it is not chosen
NEVER = 1e9  # milliseconds of a way that a driver does not compile
TRIES = 3  # pictures with too little cloth


@dataclass(frozen=True)
class Measured:
    """Milliseconds of a band of a picture by each way, and how much its pixels differ, relative."""

    fragment: float
    compute: float
    apart: float

    @property
    def way(self) -> Way:
        """The one to take."""
        return "compute" if self.compute < GAIN * self.fragment and self.apart <= ALIKE else "fragment"

    def __str__(self) -> str:
        if self.compute == NEVER:
            return f"{self.way} (the driver does not compile compute)"
        ratio = self.fragment / max(self.compute, 1e-9)
        same = "equal to the bit" if self.apart == 0.0 else f"at most {100 * self.apart:.2g} % apart"
        return f"{self.way} (compute {ratio:.2f} times as fast; {same})"


class Ways:
    """What was measured on the device of a context."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._measured: dict[str, Measured | None] = {}
        self._drawn: set[str] = set()  # methods of which a pass was drawn
        self._tries: dict[str, int] = {}

    def measured(self, method: str) -> Measured | None:
        """What is known of a method; None: nothing yet."""
        if method not in self._measured:
            kept = read_kept(self._path(method), (3,), NEVER)
            self._measured[method] = None if kept is None else Measured(*map(float, kept))
        return self._measured[method]

    def _path(self, method: str):
        info = self.ctx.info
        return kept_path("shade", __version__, info["GL_VENDOR"], info["GL_RENDERER"], info["GL_VERSION"], method)

    def of(self, scene: Scene) -> Way:
        """The way of a scene's pixels; fragments where nothing is known."""
        if scene.shade != "auto":
            return scene.shade
        known = self.measured(_method(scene))
        return "fragment" if known is None else known.way

    def take(self, scene: Scene, surfaces: Sequence[Surface]) -> None:
        """Tell surfaces."""
        way = self.of(scene)
        for surface in surfaces:
            surface.way = way

    def due(self, scene: Scene) -> bool:
        """Whether it is worth while to measure: with the second pass of a large picture, for a single one is drawn before a
        second program is compiled."""
        method = _method(scene)
        large = scene.size[0] * scene.size[1] >= LEAST_PIXELS
        open_yet = scene.shade == "auto" and self._tries.get(method, 0) < TRIES and large
        return open_yet and method in self._drawn and self.measured(method) is None

    def drew(self, scene: Scene) -> None:
        """A pass of a picture was drawn."""
        self._drawn.add(_method(scene))

    def measure(self, scene: Scene, surface: ClothSurface, buffer: GBuffer, view: PixelView) -> None:
        """Shade the pixels of a surface by both ways, into a picture that nobody sees, and keep what it took."""
        method = _method(scene)
        self._tries[method] = self._tries.get(method, 0) + 1
        try:
            found = None if buffer.parts else self._compared(surface, buffer, view)
        except ShaderError:
            found = Measured(0.0, NEVER, 0.0)
        if found is not None:
            self._measured[method] = found
            keep(self._path(method), np.array([found.fragment, found.compute, found.apart], np.float32))

    def _compared(self, surface: ClothSurface, buffer: GBuffer, view: PixelView) -> Measured | None:
        inputs = surface.shade_inputs(view, 0, 1.0)
        pictures = {way: self.ctx.texture(buffer.size, 4, bytes(16 * buffer.size[0] * buffer.size[1]), dtype="f4")
                    for way in get_args(Way)}  # fmt: skip
        targets = {way: self.ctx.framebuffer([pictures[way]], buffer.depth) for way in pictures}
        rows = 16

        def run(way: Way) -> None:
            first = max(buffer.size[1] - rows, 0) // 2
            count = min(rows, buffer.size[1])
            buffer.shade(surface.program(buffer, way), *inputs, rows=(first, count), onto=targets[way])

        try:
            while True:
                for way in pictures:
                    run(way)  # compiles
                if rows >= buffer.size[1] or self._milliseconds(run, "fragment") >= BAND_MS:
                    break
                rows *= 2
            times = [{way: self._milliseconds(run, way) for way in pictures} for _ in range(ROUNDS)]
            a, b = (np.frombuffer(read_texture(pictures[way]), "f4").reshape(-1, 4) for way in pictures)
            if (a[:, 3] > 0).sum() < LEAST_COVERED:
                return None
            best = {way: min(one[way] for one in times) for way in pictures}
            return Measured(best["fragment"], best["compute"], apart(a, b))
        finally:
            self.ctx.detect_framebuffer(0).use()
            for target, picture in zip(targets.values(), pictures.values(), strict=True):
                target.release()
                picture.release()

    def _milliseconds(self, run: Callable[[Way], None], way: Way) -> float:
        self.ctx.finish()
        begin = time.perf_counter()
        run(way)
        self.ctx.finish()
        return 1000 * (time.perf_counter() - begin)


def apart(a: np.ndarray, b: np.ndarray) -> float:
    """How far the pixels of two pictures differ at most, of the brighter of the pixel and the picture's mean."""
    a, b = a.astype(float), b.astype(float)
    return float((np.abs(a - b) / np.maximum(np.abs(a), np.abs(a).mean() + 1e-30)).max())


def ways(ctx: moderngl.Context) -> Ways:
    """What was measured on the device of a context."""
    return of_context(Ways, ctx)


def known_ways(ctx: moderngl.Context) -> Mapping[str, str]:
    """For each method what was measured, in words."""
    found = {method: ways(ctx).measured(method) for method in get_args(MethodName)}
    return {method: "not measured yet, so fragment" if one is None else str(one) for method, one in found.items()}


def _method(scene: Scene) -> str:
    return "direct" if scene.method == "path" else scene.method  # as its previews are shown
