"""The curtain in the window: simulated, its tree built and traced in slices, so that the window always answers."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import moderngl
import numpy as np

from ..curtain.show import CurtainShow
from ..gpu import shader
from ..light.environment import Environment
from ..scene import Scene
from .refine import HALF_FROM, LADDER, Side
from .slices import BUDGET, Slices

SLICE = 0.018  # seconds of tracing between two looks at the input
PLAYING = 0.07  # seconds of tracing for a picture while the curtain moves
MOVING = BUDGET  # and while it hangs still and the eye moves
REVEAL = 0.4  # seconds between two looks at a picture that grows
FIRST_PACE = 2e-6  # seconds a pixel, before the first picture tells
FIXED = 0.006  # seconds of a tile of no pixels: every generation of rays has its passes


@dataclass
class Timings:
    """Milliseconds of the last frame's parts, and of the last two frames' distance while it plays."""

    simulate: float = 0.0
    build: float = 0.0
    trace: float = 0.0
    frame: float = 0.0


class Player(Slices):
    """One curtain on the window's context. `show` says which, `play`, `pause`, `step`, `restart` move it, `work` draws.

    `sides` holds what is to be seen, as the Refiner's does. `fresh` is called with the CurtainShow whenever its
    structure holds another frame.
    """

    caution = 0.5

    def __init__(self, ctx: moderngl.Context, fresh: Callable[[CurtainShow], None] | None = None):
        super().__init__()
        self.ctx = ctx
        self.sides: list[Side] = []
        self.curtain: CurtainShow | None = None
        self.timings = Timings()
        self.playing = False
        self.hung = 0.0  # share of the hanging that is done
        self.touched = False  # wind or cloth changed on the way: no other run comes to this shape
        self._fresh = fresh
        self._wanted = 0  # the frame to simulate up to
        self._other: Scene | None = None  # side B, and whether it is drawn as layers
        self._layered = False
        self._hanging: Iterator[float] | None = None
        self._moving: Iterator[None] | None = None
        self._pace: dict[tuple, float] = {}
        self._targets: dict[str, tuple[moderngl.Texture, moderngl.Framebuffer]] = {}
        self._copy = shader.program(ctx, "passes/picture/screen.vert", "passes/window/traced.frag")
        self._array = ctx.vertex_array(self._copy, [])
        self._told: tuple | None = None
        self._last_frame = 0.0

    # -- what is to be shown -----------------------------------------------------------------------------------------

    @property
    def frame(self) -> int:
        """The number of the frame that hangs now."""
        return self.curtain.frame if self.curtain else 0

    @property
    def wanted(self) -> int:
        """The frame that it is on its way to."""
        return self._wanted

    def show(self, scene: Scene, environment: Environment, other: Scene | None = None, layered: bool = False) -> None:
        """Draw this scene from now on, and beside it the same curtain as `other` has its fabric, structure and rays;
        `layered`: as blended layers without shadows. Raises InputError when its files cannot be read."""
        before = None if self.curtain is None else self.curtain.simulation.parameters
        if before is None or not self.curtain.change(scene, environment):
            self._hang_anew(scene, environment)
        elif self.curtain.simulation.parameters != before:
            self.touched |= self.frame > 0 or self._moving is not None
        self._other, self._layered = other, layered
        self._begin()

    def _hang_anew(self, scene: Scene, environment: Environment) -> None:
        new = CurtainShow(self.ctx, scene, environment=environment, settle=False)
        self._plan = None
        if self.curtain is not None:
            self.curtain.release()
            self._wanted = 0
        self.curtain, self._moving, self._told, self.touched = new, None, None, False
        self._hanging = new.simulation.settling()

    def _begin(self) -> None:
        """Draw anew. A frame that is half simulated is gone on with, and a small picture is finished first: else the
        edits of a drag, one after the other, would let none be seen."""
        if self.curtain is None:
            return
        count = 1 if self._other is None else 2
        self.sides = [*self.sides, Side(), Side()][:count]
        for side in self.sides:
            side.share = 0.0
        super()._begin()

    def play(self) -> None:
        """Let the wind blow."""
        if not self.playing:
            self.playing = True
            self._last_frame = 0.0
            self._begin()

    def pause(self) -> None:
        """Stop after the frame under way, and refine its picture."""
        if self.playing:
            self.playing = False
            self._begin()

    def step(self, frames: int = 1) -> None:
        """Go on by so many frames."""
        self._wanted += frames
        self._begin()

    def go_to(self, frame: int) -> None:
        """Go to a frame from the beginning on, so that it hangs as in a picture of that frame."""
        if self.frame > 0 or self._moving is not None:
            self.restart()
        self.playing = False
        self._wanted = frame
        self._begin()

    def restart(self) -> None:
        """Hang the curtain anew: frame 0."""
        if self.curtain is not None:
            self._hang_anew(self.curtain.scene, self.curtain.environment)
            self._begin()

    # -- drawing -----------------------------------------------------------------------------------------------------

    def work(self, budget: float = BUDGET) -> bool:
        """Draw for about `budget` seconds; True when what is to be seen has changed. It plays no more after an error."""
        try:
            return super().work(budget)
        except BaseException:
            self.playing = False
            raise

    def _all(self) -> Iterator[bool]:
        """Hang, move, build, trace; yields whether something new is to be seen."""
        self._refining = False
        while True:
            self._again = False
            yield from self._hang()
            if self.playing and self._wanted <= self.curtain.frame:
                self._wanted = self.curtain.frame + 1
            while self.curtain.frame < self._wanted:
                yield from self._simulate()
            scenes = self._scenes()
            for number, scene in enumerate(scenes):
                if not self._is_layered(number):
                    yield from self._build(scene)
            self._tell()
            scale = self._scale(scenes, PLAYING if self.playing else MOVING)
            playing = self.playing
            for number, scene in enumerate(scenes):
                for _ in self._picture(number, scene, "preview", scale, 1):
                    yield False
            now = time.perf_counter()
            if playing and self._last_frame:
                last, new = self.timings.frame, 1e3 * (now - self._last_frame)
                self.timings.frame = new if not last else last + 0.2 * (new - last)
            self._last_frame = now
            yield True
            if not self.playing and not self._again:
                break
        self._refining = True
        spp = self.curtain.scene.spp
        if scale > 2.0 and self._guess(scenes, 1.0) * spp > HALF_FROM:
            for number, scene in enumerate(scenes):
                for _ in self._picture(number, scene, "half", 2.0, 1):
                    yield False
            yield True
        for number, scene in enumerate(scenes):
            seen = time.perf_counter()
            for done in self._picture(number, scene, "full", 1.0, spp):
                self.sides[number].share = min(done, 0.999)
                if time.perf_counter() - seen > REVEAL and done < 1.0:
                    self._take(number, "partial", self._size(1.0), 1.0, spp)
                    seen = time.perf_counter()
                    yield True
                else:
                    yield False
            self.sides[number].share = 1.0
            yield True

    def _hang(self) -> Iterator[bool]:
        # A for loop and not `yield from`: when the plan is dropped, what is half done must stay.
        if self._hanging is None:
            return
        for share in self._hanging:
            self.hung = share
            self.ctx.finish()
            yield False
        self._hanging, self.hung = None, 1.0
        self.curtain.moved()

    def _simulate(self) -> Iterator[bool]:
        """One frame further, a few substeps at a time."""
        if self._moving is None:
            self._moving = self.curtain.moving()
            self._simulated = 0.0
        begin = time.perf_counter()
        for _ in self._moving:
            self.ctx.finish()
            self._simulated += time.perf_counter() - begin
            yield False
            begin = time.perf_counter()
        self._moving = None
        self.timings.simulate = 1e3 * self._simulated

    def _scenes(self) -> list[Scene]:
        """What the sides show."""
        return [self.curtain.scene, *([] if self._other is None else [self._other])]

    def _is_layered(self, number: int) -> bool:
        return number == 1 and self._layered

    def _build(self, scene: Scene) -> Iterator[bool]:
        if self.curtain.is_built(scene.accelerator):
            return
        spent, begin = 0.0, time.perf_counter()
        for _ in self.curtain.building(scene.accelerator):
            self.ctx.finish()
            spent += time.perf_counter() - begin
            yield False
            begin = time.perf_counter()
        self.ctx.finish()
        self.timings.build = 1e3 * (spent + time.perf_counter() - begin)
        yield False

    def _tell(self) -> None:
        """Say once that the structure holds another frame."""
        state = self.curtain, self.curtain.frame, self.curtain.scene.accelerator
        if self._fresh is not None and state != self._told:
            self._told = state
            self._fresh(self.curtain)

    def tell_again(self) -> None:
        """Call `fresh` for the present frame once more."""
        self._told = None
        curtain = self.curtain
        if curtain is None or self._hanging is not None or self._moving is not None:
            return
        if curtain.is_built(curtain.scene.accelerator):
            self._tell()

    # -- pictures ----------------------------------------------------------------------------------------------------

    def _picture(self, number: int, scene: Scene, stage: str, scale: float, spp: int) -> Iterator[float]:
        """Draw a side at a size and put it to be seen; yields the share that is done."""
        if self._is_layered(number):
            size = self._size(scale)
            picture = np.ones((size[1], size[0], 4), np.float32)
            picture[..., :3] = self.curtain.layers(size, scene)[::-1]
            self._put(number, stage, size, scale, lambda texture: texture.write(picture.tobytes()))
            yield 1.0
        else:
            yield from self._trace(number, scene, stage, scale, spp)

    def _trace(self, number: int, scene: Scene, stage: str, scale: float, spp: int) -> Iterator[float]:
        """Trace the frame at a size, tile by tile, and put it to be seen."""
        size = self._size(scale)
        key = _key(scene)
        drawn, last = 0.0, time.perf_counter()

        def pixels() -> int:
            return max(64, int(SLICE / self._pace.get(key, FIRST_PACE)))

        for done in self.curtain.steps(size, spp, pixels, scene if number else None):
            now = time.perf_counter()
            # What every tile costs, however small, is no reason for smaller ones.
            spent = max(now - last - FIXED, 0.25 * (now - last))
            pace = spent / max((done - drawn) * size[0] * size[1] * spp, 1.0)
            # Tiles of sky alone are quick: the slow ones count more.
            before = self._pace.get(key, pace)
            self._pace[key] = before + (0.5 if pace > before else 0.1) * (pace - before)
            drawn = done
            yield done
            last = time.perf_counter()
        if number == 0:
            self.timings.trace = self.curtain.tracer.statistics.total_ms
        self._take(number, stage, size, scale, spp)

    def _size(self, scale: float) -> tuple[int, int]:
        width, height = self.curtain.scene.size
        return max(1, round(width / scale)), max(1, round(height / scale))

    def _guess(self, scenes: list[Scene], scale: float) -> float:
        """Seconds that pictures of one sample take."""
        width, height = self._size(scale)
        return sum(FIXED + 0.7 * width * height * self._pace.get(_key(scene), FIRST_PACE) for scene in scenes)

    def _scale(self, scenes: list[Scene], seconds: float) -> float:
        """The largest pictures that are traced in so many seconds: how much smaller they are."""
        return next((scale for scale in LADDER if self._guess(scenes, scale) <= seconds), LADDER[-1])

    def _take(self, number: int, stage: str, size: tuple[int, int], scale: float, spp: int) -> None:
        """Copy the tracer's picture into a texture of the side."""

        def copy(texture: moderngl.Texture) -> None:
            self.curtain.tracer.picture.bind_to_storage_buffer(0)
            (self.sides[number].texture or texture).use(1)
            shader.set_uniforms(self._copy, size=size, samples=float(spp))
            self.ctx.viewport = (0, 0, *size)
            self.ctx.enable_only(moderngl.NOTHING)
            self._array.render(moderngl.TRIANGLES, vertices=3)
            # Mesa 22's llvmpipe lets the next picture into the buffer while fragments still read it.
            self.ctx.finish()

        self._put(number, stage, size, scale, copy)

    def _put(
        self, number: int, stage: str, size: tuple[int, int], scale: float, fill: Callable[[moderngl.Texture], None]
    ) -> None:
        """Show on a side what `fill` puts into a texture, or draws into its framebuffer."""
        if number >= len(self.sides):
            return  # it is compared no longer
        side = self.sides[number]
        texture, framebuffer = self._target(number, stage, size)
        framebuffer.use()
        fill(texture)
        side.texture, side.scale = texture, scale
        side.version += 1

    def _target(self, number: int, stage: str, size: tuple[int, int]) -> tuple[moderngl.Texture, moderngl.Framebuffer]:
        # What grows is filled up with what is shown, so it must not overwrite that: two take turns.
        current = self.sides[number].texture
        stage = f"{stage} {number}"
        if stage.startswith("partial") or (current is not None and self._targets.get(stage, (None,))[0] is current):
            turns = (stage, f"{stage} again")
            stage = next(name for name in turns if self._targets.get(name, (None,))[0] is not current)
        found = self._targets.get(stage)
        if found is None or found[0].size != size:
            if found is not None:
                self._free(found)
            texture = self.ctx.texture(size, 4, dtype="f4")
            texture.filter = moderngl.LINEAR, moderngl.LINEAR
            texture.repeat_x = texture.repeat_y = False
            self._targets[stage] = texture, self.ctx.framebuffer([texture])
        return self._targets[stage]

    def _free(self, target: tuple[moderngl.Texture, moderngl.Framebuffer]) -> None:
        self.ctx.detect_framebuffer(0).use()
        target[1].release()
        target[0].release()

    def hurry(self) -> None:
        """Draw the picture without waiting for the curtain to settle: a trial of the shaders."""
        if self._hanging is not None:
            next(self._hanging, None)
            self._hanging = None
        self.finish()

    def finish(self) -> None:
        """Draw until the picture is complete; pauses."""
        self.pause()
        while not self.idle:
            self.work(10.0)

    def release(self) -> None:
        """Free the GPU's memory."""
        self._plan = None
        for target in self._targets.values():
            self._free(target)
        if self.curtain is not None:
            self.curtain.release()
        for thing in (self._array, self._copy):
            thing.release()
        self._targets, self.sides, self.curtain = {}, [], None


def _key(scene: Scene) -> tuple:
    """What the seconds that a pixel takes depend on."""
    return scene.accelerator, scene.depth
