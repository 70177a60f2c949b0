"""From small to full size within a time budget: a picture that always answers, and ends as `render` makes it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import moderngl

from ..gpu import shader
from ..picture.frame import Frame
from ..picture.renderer import Renderer
from ..visibility.vertices import FEWEST
from .slices import BUDGET, Slices

PREVIEW = 0.028  # seconds of shading a picture while something changes
HASTE = 1.7  # by how much the first picture after a rest is smaller still
LADDER = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)  # by how much a preview is smaller than the picture
HALF_FROM = 0.8  # seconds of full size from which something quicker comes first
SLICE = 0.016  # seconds of work that is not split further, between two looks
FINAL_UNIT, BASE_UNIT, COVER_UNIT = 0, 1, 2


@dataclass
class Side:
    """What a side shows now.

    Parameters
    ----------
    texture : linear, premultiplied, bottom row first; None before the first preview
    scale : by how much it is smaller than the picture
    version : changes with every new picture
    share : 0 to 1, how much of the full picture is done; 1 only when it is `render`'s, bit for bit
    """

    texture: moderngl.Texture | None = None
    scale: float = 1.0
    share: float = 0.0
    version: int = 0


class Refiner(Slices):
    """Draws one or two frames with one renderer. `show` says what; `work` draws for a while."""

    def __init__(self, renderer: Renderer):
        super().__init__()
        self.renderer = renderer
        self.ctx = renderer.ctx
        self.sides: list[Side] = []
        self.preview_ms = 0.0
        self._frames: list[Frame] = []
        self._scale = 6.0
        self._shading = 0.0  # seconds that the last preview took, but for its G-buffer
        self._seconds_per_row: dict[tuple, float] = {}
        self._targets: dict[tuple, tuple[moderngl.Texture, moderngl.Framebuffer]] = {}
        self._copy = shader.program(self.ctx, "passes/picture/screen.vert", "passes/window/refine.frag")
        self._directions = 4  # of the shadows, at a time

    def show(self, frames: list[Frame]) -> None:
        """Draw these frames from now on. A small picture under way is finished first: else the edits of a drag, one
        after the other, would let none be seen."""
        self._frames = frames
        while len(self.sides) < len(frames):
            self.sides.append(Side())
        del self.sides[len(frames) :]
        for side in self.sides:
            side.share = 0.0
        self._begin()

    def finish(self) -> None:
        """Draw until all is at full quality."""
        while not self.idle:
            self.work(10.0)

    def release(self) -> None:
        """Free the textures."""
        self._plan = None
        for texture, framebuffer in self._targets.values():
            framebuffer.release()
            texture.release()
        self._targets = {}
        self.sides = []

    # -- the plan ----------------------------------------------------------------------------------------------------

    def _all(self) -> Iterator[bool]:
        """Previews of all sides, then each at full size; yields whether something new is to be seen."""
        self._refining = False
        hasty = True
        while True:
            self._again = False
            frames = list(self._frames)
            yield from self._shadows(frames, FEWEST)
            for number, frame in enumerate(frames):
                yield from self._preview(number, frame, hasty)
            yield True
            # The first answer comes soon rather than sharp; who goes on moving sees more.
            hasty = False
            if not self._again:
                break
        self._refining = True
        yield from self._shadows(frames)
        for number, frame in enumerate(frames):
            yield from self._between(number, frame)
        for number, frame in enumerate(frames):
            yield from self._at(number, frame, 1.0, "full")

    def _preview(self, number: int, frame: Frame, hasty: bool) -> Iterator[bool]:
        """A small picture that takes little time, and the size of the next one from how long it took."""
        scale = self._scale if not hasty else next((s for s in LADDER if s >= HASTE * self._scale), LADDER[-1])
        small = _preview(frame, scale, adaptive=not hasty)
        height = small.scene.size[1]
        bands = 1 if hasty else max(1, round(self._shading / SLICE))
        placing = True  # until the first row is asked for, which takes no time that the size has a say in

        def rows() -> int:
            nonlocal placing
            placing = False
            return -(-height // bands)

        last = time.perf_counter()
        spent = shading = 0.0
        for _ in self.renderer.steps(small, rows, preview=True):
            now = time.perf_counter()
            spent, shading = spent + now - last, shading + (0.0 if placing else now - last)
            yield False
            last = time.perf_counter()
        if number < len(self.sides):
            self._take(number, "preview", small, scale)
            self.ctx.finish()
        rest = time.perf_counter() - last
        self.preview_ms = 1e3 * (spent + rest)
        if not hasty:
            self._shading = shading + rest
            self._learn(self._shading)

    def _between(self, number: int, frame: Frame) -> Iterator[bool]:
        """What is shown between a preview and a full picture that takes long: the adaptive rate, or half the size."""
        scene = frame.scene
        rows = self._seconds_per_row.get(_cost_key(frame), 1e-3)
        long = rows * scene.size[1] * scene.spp > HALF_FROM
        if self._scale <= 1.0 or not (long or scene.method == "reference"):
            return
        method = "direct" if scene.method == "reference" else scene.method
        quality = "normal" if scene.quality == "high" else scene.quality
        if method == "direct":
            quick = scene.model_copy(update={"adaptive": True, "spp": 1, "method": method, "quality": quality})
            if quick != scene:
                settings = replace(frame.settings, quality=quality)
                yield from self._at(number, replace(frame, scene=quick, settings=settings), 1.0, "quick")
        elif self._scale > 2.0:
            yield from self._at(number, _smaller(frame, 2.0), 2.0, "half")

    def _shadows(self, frames: list[Frame], enough: int | None = None) -> Iterator[bool]:
        """Trace what the shadows of these frames lack, or only the directions that a first impression needs."""
        for frame in frames:
            last = time.perf_counter()
            for _ in self.renderer.trace_visibility(frame, self._directions, enough):
                now = time.perf_counter()
                share = SLICE / max(now - last, 1e-4)
                self._directions = max(1, min(32, round(self._directions * min(share, 2.0))))
                yield False
                last = time.perf_counter()

    def _learn(self, seconds: float) -> None:
        """Choose the next preview's size from how long the shading of this one took."""
        place = LADDER.index(self._scale)
        if seconds > 1.4 * PREVIEW and place + 1 < len(LADDER):
            self._scale = LADDER[place + 1]
        elif place > 0 and seconds * (self._scale / LADDER[place - 1]) ** 2 < PREVIEW:
            self._scale = LADDER[place - 1]

    def _at(self, number: int, frame: Frame, scale: float, stage: str) -> Iterator[bool]:
        """Draw one frame in bands as high as the time left allows."""
        key = _cost_key(frame, scale)
        whole = 0
        last = time.perf_counter()
        guess = BUDGET if frame.scene.method == "reference" else BUDGET / 16
        wanted = [0]  # rows of the step under way; 0: it shades none

        def rows() -> int:
            pace = self._seconds_per_row.get(key, guess)
            left = max(self._until - time.perf_counter(), 0.25 * BUDGET)
            wanted[0] = max(1, int(left / pace))
            return wanted[0]

        final = stage == "full"
        done = total = rows_done = 0
        # What the pixels see of narrow lights is not waited for but at the end.
        for done, total in self.renderer.steps(frame, rows, preview=not final):
            now = time.perf_counter()
            shaded = min(wanted[0], frame.scene.size[1])
            wanted[0] = 0
            if shaded:
                pace = (now - last) / shaded
                before = self._seconds_per_row.get(key, pace)
                self._seconds_per_row[key] = 0.7 * before + 0.3 * min(pace, 4 * before)
            if final and number < len(self.sides):
                rows_done += shaded
                self.sides[number].share = min(max(done, rows_done / frame.scene.size[1]) / total, 0.999)
            if final and done > whole and done < total:
                whole = done
                self._take(number, "partial", frame, scale, done, total)
                yield True
            else:
                yield False
            last = time.perf_counter()
        self.ctx.finish()
        yield False  # the background was a step of its own
        self._take(number, stage, frame, scale)
        if final:
            self.sides[number].share = 1.0
        yield True

    # -- what the sides show -----------------------------------------------------------------------------------------

    def _take(self, number: int, stage: str, frame: Frame, scale: float, done: int = 1, total: int = 1) -> None:
        """Copy the renderer's target into a texture of the side; a part of a sum is filled up with what is shown."""
        side = self.sides[number]
        texture, framebuffer = self._target(number, stage, frame.scene.size)
        source = self.renderer.gbuffer
        base = side.texture or texture
        spp = frame.scene.spp
        samples = done * spp // total
        partial = stage == "partial"
        gain = (spp / samples if samples else float(spp)) if partial else 1.0
        source.color.use(FINAL_UNIT)
        base.use(BASE_UNIT)
        source.frame("frame_N").use(COVER_UNIT)
        shader.set_uniforms(self._copy, gain=gain, mode=0 if not partial else 1 if samples else 2)
        framebuffer.use()
        self.ctx.enable_only(moderngl.NOTHING)
        array = self.ctx.vertex_array(self._copy, [])
        array.render(moderngl.TRIANGLES, vertices=3)
        array.release()
        if partial and frame.scene.background:
            self.renderer.draw_background(frame, framebuffer)
        side.texture, side.scale = texture, scale
        side.version += 1

    def _target(self, number: int, stage: str, size: tuple[int, int]):
        # A part is filled up with the picture shown so far, so it must not overwrite that one: two take turns.
        if stage == "partial":
            current = self.sides[number].texture
            for turn in ("partial 0", "partial 1"):
                found = self._targets.get((number, turn))
                if found is None or found[0] is not current:
                    stage = turn
                    break
        key = (number, stage)
        found = self._targets.get(key)
        if found is None or found[0].size != size:
            if found is not None:
                if self.sides[number].texture is found[0]:
                    self.sides[number].texture = None
                self.ctx.detect_framebuffer(0).use()
                found[1].release()
                found[0].release()
            texture = self.ctx.texture(size, 4, dtype="f4")
            texture.filter = moderngl.LINEAR, moderngl.LINEAR
            texture.repeat_x = texture.repeat_y = False
            self._targets[key] = texture, self.ctx.framebuffer([texture])
        return self._targets[key]


def _smaller(frame: Frame, scale: float) -> Frame:
    """The same view in fewer pixels, one sample each; the reference, which no budget holds, is stood in for by direct."""
    size = tuple(max(1, round(side / scale)) for side in frame.scene.size)
    method = "direct" if frame.scene.method == "reference" else frame.scene.method
    return replace(frame, scene=frame.scene.model_copy(update={"size": size, "spp": 1, "method": method}))


def _preview(frame: Frame, scale: float, adaptive: bool) -> Frame:
    """What is drawn while something changes: small, and no finer than normal; the smallest gain nothing by the adaptive
    rate."""
    small = _smaller(frame, scale)
    quality = "normal" if frame.scene.quality == "high" else frame.scene.quality
    return replace(
        small,
        scene=small.scene.model_copy(update={"adaptive": adaptive, "quality": quality}),
        settings=replace(small.settings, quality=quality),
    )


def _cost_key(frame: Frame, scale: float = 1.0) -> tuple:
    scene = frame.scene
    return scene.method, scene.quality, scene.adaptive, scene.shadows, scene.light, scene.size[0], scale
