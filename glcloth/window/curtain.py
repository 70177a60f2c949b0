"""The curtain in the window: simulated, its tree built and traced in slices, so that the window always answers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import moderngl
import numpy as np

from ..curtain.show import CurtainShow, camera_of
from ..geometry.camera import Camera
from ..geometry.mesh import Mesh
from ..gpu.programs import programs
from ..gpu.screen import draw_screen
from ..light.environment import Environment
from ..scene import Scene
from .clock import now, timed
from .pictures import Target, Targets
from .refine import HALF_FROM, LADDER, NOT_LIGHT
from .slices import BUDGET, Slices, refining

SLICE = 0.018  # seconds of tracing between two looks at the input
PLAYING = 0.07  # seconds of tracing for a picture while the curtain moves
MOVING = BUDGET  # and while it hangs still and the eye moves
REVEAL = 0.4  # seconds between two looks at a picture that grows
FIRST_PACE = 2e-6  # seconds a pixel, before the first picture tells
FIXED = 0.006  # seconds of a tile of no pixels: every generation of rays has its passes
COPY = "passes/window/traced.frag"
_LOOK = {name: getattr(Scene(), name) for name in NOT_LIGHT}


@dataclass
class Timings:
    """Milliseconds of the last frame's parts, and of the last two frames' distance while it plays."""

    simulate: float = 0.0
    build: float = 0.0
    trace: float = 0.0
    frame: float = 0.0


class Player(Slices):
    """One curtain on the window's context. `show` says which, `play`, `pause`, `step`, `restart` move it, `work` draws."""

    caution = 0.5

    def __init__(self, ctx: moderngl.Context):
        super().__init__()
        self.ctx = ctx
        self.curtain: CurtainShow | None = None
        self.timings = Timings()
        self.playing = False
        self.hung = 0.0  # share of the hanging that is done
        self.touched = False  # wind or cloth changed on the way: no other run comes to this shape
        self.wanted = 0  # the frame that it is on its way to
        self._other: Scene | None = None  # side B, and whether it is drawn as layers
        self._layered = False
        self._shown: tuple | None = None  # the last arguments of `show`, but for the look
        self._hanging: Iterator[float] | None = None
        self._moving: Iterator[None] | None = None
        self._simulated = 0.0  # seconds of the frame under way
        self._pace: dict[tuple, float] = {}
        self._targets = Targets(ctx)
        self._last_frame = 0.0

    # -- the scene to show -------------------------------------------------------------------------------------------

    @property
    def frame(self) -> int:
        """The number of the frame that hangs now."""
        return self.curtain.frame if self.curtain else 0

    @property
    def mesh(self) -> Mesh | None:
        """The curtain as it hangs; None before the first."""
        return self.curtain.simulation.mesh() if self.curtain else None

    def camera(self, scene: Scene) -> Camera:
        """The camera that a scene says."""
        return camera_of(scene)

    @property
    def built(self) -> tuple | None:
        """The curtain, its frame and the structure that holds it; None while it moves or that is not built, or while photons,
        of whom there is a tree too, are being found."""
        curtain = self.curtain
        if curtain is None or self._hanging is not None or self._moving is not None:
            return None
        name, photons = curtain.scene.accelerator, curtain.scene.gi == "photons"
        if not curtain.is_built(name) or (photons and not curtain.is_lit):
            return None
        return curtain, curtain.frame, "photons" if photons else name

    def show(self, scene: Scene, environment: Environment, other: Scene | None = None, layered: bool = False) -> bool:
        """Draw this scene from now on, and beside it the same curtain as `other` has its fabric, structure and rays;
        `layered`: as blended layers without shadows. False where only how it is shown differs from what is drawn
        already. Raises InputError when its files cannot be read."""
        shown = [side and side.model_copy(update=_LOOK) for side in (scene, other)], layered
        if shown == self._shown and self.curtain is not None and self.curtain.environment is environment:
            return False
        before = None if self.curtain is None else self.curtain.simulation.parameters
        if before is None or not self.curtain.change(scene, environment):
            self._hang_anew(scene, environment)
        elif self.curtain.simulation.parameters != before:
            self.touched |= self.frame > 0 or self._moving is not None
        self._other, self._layered, self._shown = other, layered, shown
        self._draw()
        return True

    def forget(self) -> None:
        """Draw anew at the next `show`, whatever that is given."""
        self._shown = None

    def _hang_anew(self, scene: Scene, environment: Environment) -> None:
        new = CurtainShow(self.ctx, scene, environment=environment, settle=False)
        self._plan = None
        if self.curtain is not None:
            self.curtain.release()
        self.curtain, self._moving, self.touched, self.wanted = new, None, False, 0
        self._hanging = new.simulation.settling()

    def _draw(self) -> None:
        """Draw anew. A frame that is half simulated is gone on with."""
        if self.curtain is not None:
            self._begin(1 if self._other is None else 2)

    def play(self) -> None:
        """Let the wind blow."""
        if not self.playing and self.curtain is not None:
            self.playing = True
            self._last_frame = 0.0
            self._draw()

    def pause(self) -> None:
        """Stop after the frame under way, and refine its picture."""
        if self.playing:
            self.playing = False
            self._draw()

    def step(self, frames: int = 1) -> None:
        """Go on by so many frames."""
        if self.curtain is not None:
            self.wanted += frames
            self._draw()

    def go_to(self, frame: int) -> None:
        """Go to a frame from the beginning on, so that it hangs as in a picture of that frame."""
        if self.frame > 0 or self._moving is not None:
            self.restart()
        self.playing = False
        self.wanted = frame
        self._draw()

    def restart(self) -> None:
        """Hang the curtain anew: frame 0."""
        if self.curtain is not None:
            self._hang_anew(self.curtain.scene, self.curtain.environment)
            self._draw()

    # -- drawing -----------------------------------------------------------------------------------------------------

    def work(self, budget: float = BUDGET) -> bool:
        """Draw for about `budget` seconds; True when the picture has changed. It plays no more after an error."""
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
            if self.playing and self.wanted <= self.curtain.frame:
                self.wanted = self.curtain.frame + 1
            while self.curtain.frame < self.wanted:
                yield from self._simulate()
            scenes = self._scenes()
            for number, scene in enumerate(scenes):
                if not self._is_layered(number):
                    yield from self._build(scene)
            scale = self._scale(scenes, PLAYING if self.playing else MOVING)
            playing = self.playing
            yield from self._quick(scenes, "preview", scale)
            last, self._last_frame = self._last_frame, now()
            if playing and last:
                new = 1e3 * (self._last_frame - last)
                self.timings.frame += (0.2 if self.timings.frame else 1.0) * (new - self.timings.frame)
            yield True
            if not self.playing and not self._again:
                break
        self._refining = True
        if scale > 2.0 and self._guess(scenes, 1.0) * self.curtain.scene.spp > HALF_FROM:
            yield from self._quick(scenes, "half", 2.0)
            yield True
        yield from self._full(scenes, self.curtain.scene.spp)

    def _quick(self, scenes: list[Scene], stage: str, scale: float) -> Iterator[bool]:
        """Pictures of one sample."""
        for number, scene in enumerate(scenes):
            for _ in self._picture(number, scene, stage, scale, 1):
                yield False

    def _full(self, scenes: list[Scene], spp: int) -> Iterator[bool]:
        """The complete pictures, seen as they grow."""
        for number, scene in enumerate(scenes):
            seen = now()
            for done in self._picture(number, scene, "full", 1.0, spp):
                self.sides[number].share = min(done, 0.999)
                reveal = now() - seen > REVEAL and done < 1.0
                if reveal:
                    self._take(number, "partial", self._size(1.0), 1.0, spp)
                    seen = now()
                yield reveal
            self.sides[number].share = 1.0
            yield True

    def _hang(self) -> Iterator[bool]:
        # A for loop and not `yield from`: when the plan is dropped, half-done work must stay.
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
            self._moving, self._simulated = self.curtain.moving(), 0.0
        for _, seconds in timed(self._finished(self._moving)):
            self._simulated += seconds
            yield False
        self._moving = None
        self.timings.simulate = 1e3 * self._simulated

    def _finished(self, steps: Iterable[None]) -> Iterator[None]:
        """Each step once the GPU is done with it."""
        for _ in steps:
            self.ctx.finish()
            yield

    def _scenes(self) -> list[Scene]:
        """The scenes of the sides."""
        return [self.curtain.scene, *([] if self._other is None else [self._other])]

    def _is_layered(self, number: int) -> bool:
        return number == 1 and self._layered

    def _build(self, scene: Scene) -> Iterator[bool]:
        if self.curtain.is_built(scene.accelerator):
            return
        spent = 0.0
        # With a step more, for the work after its last yield.
        for _, seconds in timed(self._finished(chain(self.curtain.building(scene.accelerator), [None]))):
            spent += seconds
            yield False
        self.timings.build = 1e3 * spent

    # -- pictures ----------------------------------------------------------------------------------------------------

    def _picture(self, number: int, scene: Scene, stage: str, scale: float, spp: int) -> Iterator[float]:
        """Draw a side at a size and put it to be seen; yields the share that is done."""
        if self._is_layered(number):
            size = self._size(scale)
            picture = np.ones((size[1], size[0], 4), np.float32)
            picture[..., :3] = self.curtain.layers(size, scene)[::-1]
            self._put(number, stage, size, scale, lambda target: target.texture.write(picture.tobytes()))
            yield 1.0
        else:
            yield from self._trace(number, scene, stage, scale, spp)

    def _trace(self, number: int, scene: Scene, stage: str, scale: float, spp: int) -> Iterator[float]:
        """Trace the frame at a size, tile by tile, and put it to be seen."""
        size = self._size(scale)
        key = _key(scene)
        drawn = 0.0

        def pixels() -> int:
            return max(64, int(SLICE / self._pace.get(key, FIRST_PACE)))

        for done, seconds in timed(self.curtain.steps(size, spp, pixels, scene if number else None)):
            if done > drawn:  # else photons were found
                # The fixed cost of every tile is no reason for smaller ones.
                spent = max(seconds - FIXED, 0.25 * seconds)
                pace = spent / max((done - drawn) * size[0] * size[1] * spp, 1.0)
                # Tiles of sky alone are quick: the slow ones count more.
                before = self._pace.get(key, pace)
                self._pace[key] = before + (0.5 if pace > before else 0.1) * (pace - before)
                drawn = done
            yield done
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

        def copy(target: Target) -> None:
            draw_screen(
                programs(self.ctx).screen(COPY),
                target.framebuffer,
                Picture=self.curtain.tracer.picture,
                shown=self.sides[number].texture or target.texture,
                size=size,
                samples=float(spp),
            )
            # Mesa 22's llvmpipe lets the next picture into the buffer while fragments still read it.
            self.ctx.finish()

        self._put(number, stage, size, scale, copy)

    def _put(
        self, number: int, stage: str, size: tuple[int, int], scale: float, fill: Callable[[Target], None]
    ) -> None:
        """Fill a target and show it on a side."""
        if number < len(self.sides):  # else it is compared no longer
            side = self.sides[number]
            target = self._targets.get(f"{stage} {number}", size, side.texture)
            fill(target)
            side.show(target.texture, scale)

    def status(self, scene: Scene) -> list[str]:
        """Its state, in words."""
        if self.hung < 1.0:
            return [f"hanging the curtain: {10 * int(10 * self.hung)} %"]
        side, times = self.sides[0], self.timings
        if self.playing:
            rate = f"{1e3 / times.frame:.1f} frames/s" if times.frame else "starting"
            state = f"playing, {rate}, shown at 1/{side.scale:g}"
        elif self.frame < self.wanted:
            state = f"on its way to frame {self.wanted}"
        else:
            state = "done" if side.share >= 1.0 else refining(side)
        cost = f"build {times.build:.0f} ms, trace {times.trace:.0f} ms; simulation {times.simulate:.0f} ms"
        return [f"frame {self.frame}: {state}", f"{scene.accelerator}: {cost}"]

    def try_out(self, scene: Scene, environment: Environment) -> None:
        """Draw a scene as small as can be, without waiting for the curtain to settle. Raises ShaderError."""
        self.show(scene.changed(size=(16, 16), spp=1), environment)
        next(self._hanging, None)
        self._hanging = None
        self.finish()

    def release(self) -> None:
        """Free the GPU's memory."""
        self._plan = None
        self._targets.release()
        if self.curtain is not None:
            self.curtain.release()
        self.sides, self.curtain = [], None


def _key(scene: Scene) -> tuple:
    """The settings that decide how long a pixel takes."""
    return scene.accelerator, scene.depth
