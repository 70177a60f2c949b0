"""The cloth near by, beside the picture: two centimetres of it, flat, in the light of the scene."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import moderngl

from ..fabric import Fabric
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..gpu.screen import draw_screen
from ..picture.frame import Frame
from ..picture.patch import patch, patch_camera
from ..picture.renderer import Renderer
from .clock import now
from .pictures import Side, Targets
from .refine import OF_PARTS
from .screen import Look, Screen
from .slices import BUDGET

WIDE = 0.02  # metres of cloth that the view is wide
SIZE = 376, 188  # pixels
SAMPLES = 4
SMALLER = 3  # by how much the first answer is smaller
WARM_UP = 2.5, 5.0, 10.0, 25.0  # degrees, widths of lobes with few and many tangents
COPY = "passes/window/refine.frag"


class NearView:
    """Draws one fabric. `show` takes it, `work` draws for a while, `texture` is what to put on screen."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.renderer = Renderer(ctx=ctx)
        self.side = Side()
        self.answer_ms = 0.0  # from the last edit to its first picture
        self._mesh, self._camera = patch(2.0 * WIDE), patch_camera(WIDE, self.aspect)
        self._targets, self._screen = Targets(ctx), Screen(ctx)
        self._frame: Frame | None = None
        self._shown: Last[None] = Last()
        self._plan: Iterator[bool] | None = None
        self._begun = 0.0
        self._answered = True
        self._seconds_per_row = 2e-3
        self._lobes = list(WARM_UP)

    @property
    def idle(self) -> bool:
        """True when the picture is complete."""
        return self._plan is None

    @property
    def answering(self) -> bool:
        """True until the last edit has its first picture."""
        return self._plan is not None and not self._answered

    @property
    def aspect(self) -> float:
        """Width over height."""
        return SIZE[0] / SIZE[1]

    def show(self, fabric: Fabric, frame: Frame) -> None:
        """Draw a fabric from now on, in the light of a frame."""
        if not self._shown.changes(fabric, frame.lights, frame.environment):
            return
        scene = frame.scene.changed(
            method="direct", quality="normal", shadows="off", threads=True, adaptive=False, background=False,
            objects=(), ground="off", spp=SAMPLES, size=SIZE, uv_scale=1.0, subdivide=0, **OF_PARTS,
        )  # fmt: skip
        self._frame = self.renderer.prepare(
            scene, fabric=fabric, mesh=self._mesh, environment=frame.environment, lights=frame.lights,
            camera=self._camera,
        )  # fmt: skip
        self._begun, self._answered = now(), False
        self._plan = self._all(self._frame)

    @property
    def cold(self) -> bool:
        """Whether programs are left to compile that edits of the weave may need."""
        return self._frame is not None and bool(self._lobes)

    def warm_up(self) -> None:
        """Compile one of them: the weave's number of tangents, which programs are made for, follows from the lobes' width."""
        assert self._frame is not None
        fabric, gamma = self._frame.fabric.sketch(), self._lobes.pop()
        narrow = tuple(yarn.changed(gamma_s_deg=gamma) for yarn in fabric.yarn)
        scene = self._frame.scene.model_copy(update={"size": (24, 12), "spp": 1})
        self.renderer.draw(replace(self._frame, scene=scene).with_cloth(fabric=fabric.changed(yarn=narrow).sketch()))
        self.ctx.finish()

    def work(self, budget: float = BUDGET) -> bool:
        """Draw for about `budget` seconds; True when there is something new to see."""
        until = now() + budget
        try:
            while self._plan is not None:
                if next(self._plan):
                    return True
                if now() >= until:
                    return False
        except StopIteration:
            self._plan = None
        except BaseException:
            self._plan = None
            raise
        return False

    def texture(self, look: Look) -> moderngl.Texture | None:
        """The picture as the screen takes it; None before the first."""
        return None if self.side.texture is None else self._screen.encode(0, [self.side], look).texture

    def _all(self, frame: Frame) -> Iterator[bool]:
        """A small picture of coarse maps at once, then the whole in bands."""
        fabric = frame.fabric
        size = tuple(n // SMALLER for n in SIZE)
        scene = frame.scene.model_copy(update={"size": size, "spp": 1, "quality": "draft"})
        small = replace(frame, scene=scene, settings=replace(frame.settings, quality="draft"))
        for _ in self.renderer.steps(small.with_cloth(fabric=fabric.sketch()), preview=True):
            pass
        self._take(SMALLER)
        self.ctx.finish()
        self._answered = True
        self.answer_ms = 1e3 * (now() - self._begun)
        yield True
        wanted = 0

        def rows() -> int:
            nonlocal wanted
            wanted = max(1, int(0.6 * BUDGET / self._seconds_per_row))
            return wanted

        steps = self.renderer.steps(frame, rows)
        while True:
            begin, wanted = now(), 0
            if next(steps, None) is None:
                break
            self.ctx.finish()
            if wanted:
                self._seconds_per_row += 0.3 * ((now() - begin) / wanted - self._seconds_per_row)
            yield False
        self._take(1)
        yield True

    def _take(self, scale: float) -> None:
        """Copy the renderer's picture, which the next draw overwrites."""
        source = self.renderer.target.color
        target = self._targets.get("near", source.size, self.side.texture)
        program = programs(self.ctx).screen(COPY)
        draw_screen(
            program, target.framebuffer, drawn=source, shown=source,
            frame_N=self.renderer.gbuffer.frame("frame_N"), gain=1.0, mode=0,
        )  # fmt: skip
        self.side.show(target.texture, scale)

    def forget(self) -> None:
        """Draw anew, whatever has been drawn."""
        self._shown.forget()

    def release(self) -> None:
        """Free the textures."""
        self._plan = None
        self._targets.release()
        self._screen.release()
        self.side = Side()
