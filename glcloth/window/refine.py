"""The cloth in the window, from small to full size within a time budget: it always answers, and ends as `render`'s.

The only file of the window that speaks with the Renderer.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import moderngl
import numpy as np

from ..errors import InputError
from ..fabric import Fabric
from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..gpu.screen import draw_screen
from ..light.environment import rotation_y
from ..methods import registry
from ..picture.frame import Frame, default_camera
from ..picture.path import check_path
from ..picture.renderer import Renderer
from ..picture.warm_up import warm_up
from ..progress import warn
from ..scene import MAPS, Scene
from ..tracing.denoise import denoised
from ..visibility.vertices import FEWEST
from .clock import now, timed
from .pictures import Targets
from .resources import Ready
from .slices import BUDGET, Slices, refining

METHODS = (*registry.METHODS, "path")
AFRESH = 0.3  # seconds between two looks at a path-traced picture that goes on
PREVIEW = 0.028  # seconds of shading a picture while something changes
HASTE = 1.7  # by how much the first picture after a rest is smaller still
LADDER = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)  # by how much a preview is smaller than the picture
HALF_FROM = 0.8  # seconds of full size from which something quicker comes first
SLICE = 0.016  # seconds of work that is not split further, between two looks
COPY = "passes/window/refine.frag"
# A scene that names no part and no map of its mesh.
OF_PARTS: dict[str, Any] = {"fabrics": {}} | {name: None for name in MAPS} | {name: {} for name in MAPS.values()}
NOT_LIGHT = ("exposure", "view_transform", "ocio", "display", "ocio_view", "bookmarks")  # how a picture is shown


class Refiner(Slices):
    """Draws one or two frames with one renderer. `show` takes them, `work` draws for a while."""

    def __init__(self, ctx: moderngl.Context):
        super().__init__()
        self.ctx = ctx
        self.renderer = Renderer(ctx=ctx)
        self.frames: list[Frame] = []
        self.preview_ms = 0.0
        self.covered = 0  # pixels of the complete picture that show cloth
        self._scale = 6.0
        self._shading = 0.0  # seconds that the last preview took, but for its G-buffer
        self._seconds_per_row: dict[tuple, float] = {}
        self._targets = Targets(ctx)
        self._directions = 4  # of the shadows, at a time
        self._mapped: list[Fabric] = []  # those of the last complete picture
        self._sketch: Last[Fabric] = Last()
        self._samples = 0  # of a path-traced picture under way
        self._stands_in = False  # whether direct shows what method path cannot
        self._cold = True  # some programs that edits of the weave may need are not compiled
        self._warming: Iterator[None] | None = None

    def frame(self, scene: Scene, fabric: Fabric, ready: Ready, complete: bool) -> Frame:
        """A frame of all that is ready; until tables or a fit are made, the last light and the direct method serve."""
        lights = ready.lights if complete else ready.report.lights.rotated(rotation_y(scene.env_rotate))
        if not complete and scene.method == "paper":
            scene = scene.model_copy(update={"method": "direct"})
        prepare = partial(
            self.renderer.prepare,
            fabric=fabric,
            mesh=ready.meshes,
            environment=ready.environment,
            lights=lights,
            objects=ready.objects,
        )
        try:
            return prepare(scene)
        except InputError:
            if complete:
                raise
            # The last mesh, which stands in until that of the scene is read, has other parts.
            return prepare(scene.model_copy(update=OF_PARTS))

    @property
    def mesh(self) -> Mesh | None:
        """The cloth of the present frames; None before the first."""
        return self.frames[0].whole if self.frames else None

    def camera(self, scene: Scene) -> Camera:
        """The camera that shows it as a scene says."""
        return default_camera(self.frames[0].whole, scene)

    def show(self, frames: list[Frame]) -> bool:
        """Draw these frames from now on; False where only the look differs and nothing is to be drawn."""
        same = len(frames) == len(self.frames) and all(map(_same_light, frames, self.frames))
        self.frames = frames
        if same and self.sides:
            return False
        self._begin(len(frames))
        return True

    def status(self, scene: Scene) -> list[str]:
        """How far the picture is, in words."""
        unfinished = [side for side in self.sides if side.share < 1.0]
        state = f"{self.full_ms:.0f} ms, {self.covered} pixels covered" if self.full_ms else "done"
        if self._samples and unfinished:
            return [f"path: {self._samples} samples; preview {self.preview_ms:.0f} ms"]
        if unfinished:
            state = refining(min(unfinished, key=lambda side: side.share))
        return [f"{'direct' if self._stands_in else scene.method}: {state}; preview {self.preview_ms:.0f} ms"]

    @property
    def cold(self) -> bool:
        """Whether something is left to compile that edits of the weave may need."""
        return self._cold and self.frames != [] and self.frames[0].scene.method == "direct"

    def warm_up(self) -> None:
        """Compile one such thing."""
        if self._warming is None:
            self._warming = warm_up(self.renderer, self.frames[0])
        self._cold = next(self._warming, self) is not self

    def try_out(self, frames: list[Frame]) -> None:
        """Draw frames as small as can be, and show nothing. Raises ShaderError."""
        programs(self.ctx).screen(COPY)
        for frame in frames:
            method = "direct" if frame.scene.method == "path" else frame.scene.method
            tiny = frame.scene.model_copy(update={"size": (16, 16), "spp": 1, "method": method})
            self.renderer.draw(replace(frame, scene=tiny))

    def release(self) -> None:
        """Free the textures."""
        self._plan = None
        self._targets.release()
        self.sides = []

    # -- the plan ----------------------------------------------------------------------------------------------------

    def _all(self) -> Iterator[bool]:
        """Previews of all sides, then each at full size; yields whether something new is to be seen."""
        self._refining, self._samples, self._stands_in = False, 0, False
        hasty = True
        while True:
            self._again = False
            frames = [self._sketched(frame) for frame in self.frames]
            yield from self._shadows(frames, FEWEST)
            for number, frame in enumerate(frames):
                yield from self._preview(number, frame, hasty)
            yield True
            # The first answer comes soon rather than sharp; who goes on moving sees more.
            hasty = False
            if not self._again:
                break
        self._refining = True
        frames = list(self.frames)
        yield from self._shadows(frames)
        for number, frame in enumerate(frames):
            yield from self._between(number, frame)
        for number, frame in enumerate(frames):
            by_paths = _by_paths(frame)
            self._stands_in |= frame.scene.method == "path" and not by_paths
            yield from self._paths(number, frame) if by_paths else self._at(number, frame, 1.0, "full")
        self._mapped = [frame.fabric for frame in frames]
        self.covered = self.renderer.covered_pixels()

    def _sketched(self, frame: Frame) -> Frame:
        """A frame whose threads are drawn from coarse maps, unless its own are made: those of a new weave take long."""
        fabric = frame.fabric
        if not frame.scene.threads or fabric.weave is None or any(fabric is known for known in self._mapped):
            return frame
        return frame.with_cloth(fabric=self._sketch.get(lambda: fabric.sketch(), fabric))

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

        spent = shading = 0.0
        for _, seconds in timed(self.renderer.steps(small, rows, preview=True)):
            spent, shading = spent + seconds, shading + (0.0 if placing else seconds)
            yield False
        begin = now()
        if number < len(self.sides):
            self._take(number, "preview", small, scale)
            self.ctx.finish()
        rest = now() - begin
        self.preview_ms = 1e3 * (spent + rest)
        if not hasty:
            self._shading = shading + rest
            self._learn(self._shading)

    def _between(self, number: int, frame: Frame) -> Iterator[bool]:
        """The stage between a preview and a full picture that takes long: the adaptive rate, or half the size."""
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
        """Trace the missing directions of these frames' shadows, or only enough for a first impression."""
        for frame in frames:
            for _, seconds in timed(self.renderer.trace_visibility(frame, self._directions, enough)):
                share = SLICE / max(seconds, 1e-4)
                self._directions = max(1, min(32, round(self._directions * min(share, 2.0))))
                yield False

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
        guess = BUDGET if frame.scene.method == "reference" else BUDGET / 16
        height, final = frame.scene.size[1], stage == "full"
        wanted = 0  # rows of the step under way; 0: it shades none

        def rows() -> int:
            nonlocal wanted
            left = max(self._until - now(), 0.25 * BUDGET)
            wanted = max(1, int(left / self._seconds_per_row.get(key, guess)))
            return wanted

        whole = rows_done = 0
        # Only the final picture waits for the pixels' own rays into narrow lights.
        for (done, total), seconds in timed(self.renderer.steps(frame, rows, preview=not final)):
            shaded, wanted = min(wanted, height), 0
            if shaded:
                pace = seconds / shaded
                before = self._seconds_per_row.get(key, pace)
                self._seconds_per_row[key] = 0.7 * before + 0.3 * min(pace, 4 * before)
            rows_done += shaded
            if final:
                self.sides[number].share = min(max(done, rows_done / height) / total, 0.999)
            more = final and whole < done < total
            if more:
                whole = done
                self._take(number, "partial", frame, scale, done, total)
            yield more
        self.ctx.finish()
        yield False  # the background was a step of its own
        self._take(number, stage, frame, scale)
        if final:
            self.sides[number].share = 1.0
        yield True

    def _paths(self, number: int, frame: Frame) -> Iterator[bool]:
        """Trace one frame by paths; what its samples come to so far is shown now and then, until all are there."""
        side = self.sides[number]
        target = self._targets.get(f"paths {number}", frame.scene.size, side.texture)
        shown, seen = 0, 0.0
        steps = self.renderer.path_steps(frame, target.framebuffer, lambda: max(self._until - now(), 0.25 * BUDGET))
        for (done, total), _ in timed(steps):
            side.share, self._samples = min(done / total, 0.999), done
            fresh = shown < done < total and now() - seen > AFRESH
            if fresh:
                self.renderer.draw_paths(target.framebuffer)
                side.show(target.texture)
                shown, seen = done, now()
            yield fresh
        if frame.scene.denoise:
            target.texture.write(np.ascontiguousarray(denoised(self.renderer.path_sums())[::-1], "f4"))
            for _ in self.renderer.path_hairs(frame, target.framebuffer):
                yield False
        side.show(target.texture)
        side.share = 1.0
        yield True

    def _take(self, number: int, stage: str, frame: Frame, scale: float, done: int = 1, total: int = 1) -> None:
        """Copy the renderer's picture into a texture of the side; a partial sum is filled up with the shown picture."""
        side, spp = self.sides[number], frame.scene.spp
        target = self._targets.get(f"{stage} {number}", frame.scene.size, side.texture)
        source = self.renderer.gbuffer
        samples = done * spp // total
        partial = stage == "partial"
        draw_screen(
            programs(self.ctx).screen(COPY),
            target.framebuffer,
            drawn=source.color,
            shown=side.texture or source.color,
            frame_N=source.frame("frame_N"),
            gain=float(spp) / max(samples, 1) if partial else 1.0,
            mode=0 if not partial else 1 if samples else 2,
        )
        if partial and frame.scene.background:
            self.renderer.draw_background(frame, target.framebuffer)
        side.show(target.texture, scale)


def _by_paths(frame: Frame) -> bool:
    """Whether method `path` is chosen, and can show what is there; else `direct` stands in for it."""
    if frame.scene.method != "path":
        return False
    try:
        check_path(frame)
    except InputError as fault:
        warn(f"{fault}; the window shows direct")
        return False
    return True


def _same_light(new: Frame, old: Frame) -> bool:
    """True when two frames have the same linear picture: they differ in how it is shown at most."""
    same = replace(new, scene=new.scene.model_copy(update={n: getattr(old.scene, n) for n in NOT_LIGHT}))
    return (
        same.scene == old.scene
        and len(same.cloths) == len(old.cloths)
        and all(
            a.fabric is b.fabric and a.mesh is b.mesh and a.print is b.print and a.opacity is b.opacity
            for a, b in zip(same.cloths, old.cloths, strict=True)
        )
        and same.environment is old.environment
        and same.lights is old.lights
        and same.objects is old.objects
        and same.camera == old.camera
    )


def _smaller(frame: Frame, scale: float) -> Frame:
    """The same view in fewer pixels, one sample each; the reference, which no budget holds, is stood in for by direct."""
    size = tuple(max(1, round(side / scale)) for side in frame.scene.size)
    method = "direct" if frame.scene.method == "reference" else frame.scene.method
    return replace(frame, scene=frame.scene.model_copy(update={"size": size, "spp": 1, "method": method}))


def _preview(frame: Frame, scale: float, adaptive: bool) -> Frame:
    """The picture while something changes: small, and no finer than normal; the smallest gain nothing by the adaptive
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
