"""A frame by passes over its G-buffers: its surfaces are drawn, see the lights, are shaded and composited."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ..geometry.camera import lens_samples, sample_offsets
from ..progress import drain
from .background import Background
from .frame import Frame
from .layers import Gathering
from .pace import Pace
from .stage import Stage
from .target import Target
from .ways import ways


class Passes:
    """Draws the frame that a stage has taken."""

    def __init__(self, stage: Stage, background: Background):
        self.ctx, self.stage, self.background = stage.ctx, stage, background
        self.ways = ways(self.ctx)

    def steps(
        self, frame: Frame, target: Target, pace: Pace, gathering: Gathering | None = None
    ) -> Iterator[tuple[int, int]]:
        """Draw a frame; yields and `gathering` as for `Renderer.steps`."""
        surfaces = self.stage.surfaces
        self.ways.take(frame.scene, surfaces)
        self._trace(pace)
        passes = max(surface.pass_count for surface in surfaces)
        samples, cameras = sample_offsets(frame.scene.spp), lens_samples(frame.camera, frame.scene.spp)
        total = passes * len(samples)
        for job in pace.tracked(self.stage.geometry_jobs(frame), f"{frame.scene.method}: light on the folds"):
            job()
            yield 0, total
        target.clear()
        jobs = [(sample, number) for sample in range(len(samples)) for number in range(passes)]
        for done, (sample, number) in enumerate(pace.tracked(jobs, pace.announce or "") if total > 1 else jobs):
            if number == 0:
                seen = replace(frame, camera=cameras[sample])
                for _ in self._see(target, seen, samples[sample], (sample, len(samples)), pace):
                    yield done, total
                if gathering is not None:
                    gathering.see(target, surfaces, cameras[sample], sample)
            if pace.rows is None and self.ways.due(frame.scene):
                cloth = self.stage.cloths[0]
                self.ways.measure(frame.scene, cloth, *target.part(cloth))
                self.ways.take(frame.scene, surfaces)
            for finished in self._shade(target, frame, number, 1.0 / len(samples), total > 1, pace):
                yield done + finished, total
            self.ways.drew(frame.scene)
        self.stage.draw_hairs(target, frame)
        if gathering is not None:
            gathering.shaded(target)
        if frame.scene.background:
            self.background.draw(frame, target.framebuffer)

    def gather(self, frame: Frame, target: Target, gathering: Gathering) -> None:
        """Give `gathering` what all samples of a frame see; nothing is shaded."""
        samples, cameras = sample_offsets(frame.scene.spp), lens_samples(frame.camera, frame.scene.spp)
        for number, offset in enumerate(samples):
            seen = replace(frame, camera=cameras[number])
            drain(self._see(target, seen, offset, (number, len(samples)), Pace()))
            gathering.see(target, self.stage.surfaces, cameras[number], number)

    def _trace(self, pace: Pace) -> None:
        """Trace the missing directions of the vertices, or as many as a first impression needs."""
        seeing = [surface.visibility for surface in self.stage.surfaces]
        if pace.preview:
            for visibility in seeing:
                visibility.preview()
        elif total := sum(visibility.total() for visibility in seeing):
            drain(pace.tracked(self.stage.trace(), "shadows: directions", total))

    def _see(
        self, target: Target, frame: Frame, offset: tuple[float, float], sample: tuple[int, int], pace: Pace
    ) -> Iterator[None]:
        """Draw the surfaces, and find the visibility of their pixels."""
        for _ in target.draw(self.stage.surfaces, frame.camera, offset, pace.draw_rows(target.size)):
            yield from pace.pause(self.ctx)
        yield from self.stage.see(target, frame, sample, pace)

    def _shade(self, target: Target, frame: Frame, number: int, weight: float, add: bool, pace: Pace) -> Iterator[bool]:
        """Shade the surfaces, pass by pass; yields after each part whether the pass is finished."""
        parts = [(surface, *part) for surface, part in target.parts(self.stage.surfaces)]
        target.clear_layers()
        for surface, buffer, view in parts:
            if surface.adaptive:
                for _ in surface.shade_adaptively(buffer, view, pace):
                    yield False
        in_bands = [part for part in parts if not part[0].adaptive]
        for band in pace.bands(target.size[1]) if in_bands else ():
            for surface, buffer, view in in_bands:
                surface.shade(buffer, view, number, weight, add, band)
            if add or band is not None:
                self.ctx.finish()  # so that progress tells the truth and Ctrl-C is heard between passes
            last = band is None or sum(band) >= target.size[1]
            if last:
                self._composite(target, frame, number, weight)
            yield last
        if not in_bands:
            self._composite(target, frame, number, weight)
            yield True

    def _composite(self, target: Target, frame: Frame, number: int, weight: float) -> None:
        """Add what is seen through cloth to the picture of a pass."""
        if not target.layered:
            return
        surfaces = self.stage.surfaces
        if number == 0:
            target.attenuate(surfaces)
        environment = None
        if frame.scene.background:
            ray_from_pixel = target.part(surfaces[0]).buffer.ray_from_pixel
            environment = self.background.inputs(frame, ray_from_pixel)
        catches = any(surface.catches for surface in surfaces)
        target.composite(weight if number == 0 else 0.0, environment, catches)
