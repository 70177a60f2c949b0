"""Method `path`: a frame's surfaces and lights for the path tracer, and its pictures on a target."""

from __future__ import annotations

from collections.abc import Iterator

import moderngl

from ..errors import InputError
from ..gpu.environment_map import EnvironmentMap
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..gpu.screen import draw_screen
from ..light.environment import rotation_y
from ..tracing.denoise import check_denoiser
from ..tracing.path import PathSums, PathTracer, PathView, PathWorld, Progress, followed, samples_of
from .frame import Frame
from .looks import is_matt
from .pace import Pace


def check_path(frame: Frame) -> None:
    """Raise InputError for what paths cannot show."""
    scene = frame.scene
    if scene.denoise:
        check_denoiser()
    if scene.shadows != "full":
        raise InputError(f"method path: shadows {scene.shadows}, but rays always meet what is there; leave it out")
    if any(cloth.print or cloth.opacity or cloth.mask for cloth in frame.cloths):
        raise InputError(
            "method path: prints, openings and fabric masks are not for it; leave them out, or take method direct"
        )
    objects = frame.objects
    if objects is None:
        return
    if objects.ground is not None and objects.ground.catcher:
        raise InputError(
            "method path: a ground that shows its shadow alone is not for it; give --ground auto, or method direct"
        )
    for mesh, materials in zip(objects.meshes, objects.materials or ((),) * len(objects.meshes), strict=True):
        if not all(is_matt(material) for material in materials):
            raise InputError(
                f"method path: object {mesh.name} has gloss, metal or a picture, expected matt colours; take method direct"
            )


def world_of(frame: Frame) -> PathWorld:
    """What paths meet in a frame."""
    cloths = tuple((cloth.mesh, cloth.fabric) for cloth in frame.cloths)
    if frame.objects is None:
        return PathWorld(cloths)
    ground = frame.objects.ground
    solids = tuple(zip(frame.objects.meshes, frame.objects.reflectances, strict=True))
    return PathWorld(cloths, solids, None if ground is None else (ground.height, ground.color))


class PathPictures:
    """Traces frames, and draws what the samples so far come to."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._tracer: PathTracer | None = None
        self._map = EnvironmentMap(ctx)
        self._world: Last[PathWorld] = Last()

    @property
    def tracer(self) -> PathTracer:
        """Made at first use."""
        if self._tracer is None:
            self._tracer = PathTracer(self.ctx)
        return self._tracer

    def steps(self, frame: Frame, target: moderngl.Framebuffer, pace: Pace) -> Iterator[tuple[int, int]]:
        """Trace a frame into a framebuffer; yields (samples finished, samples at most) after each step. Raises InputError."""
        check_path(frame)
        scene, tracer = frame.scene, self.tracer
        tracer.take(self._world.get(lambda: world_of(frame), frame.cloths, frame.objects))
        if scene.light == "map":
            tracer.sky.take_map(frame.environment, rotation_y(scene.env_rotate))
        else:
            tracer.sky.take_lights(frame.lights)
        behind = {
            "environment_map": self._map.texture(frame.environment),
            "map_from_world": rotation_y(-scene.env_rotate),
        }
        view = PathView(frame.camera, scene.size, behind, scene.background, 24 if scene.bounce else 1)
        total = samples_of(scene.spp, scene.noise)
        steps: Iterator[Progress] = tracer.steps(view, total, scene.noise)
        if pace.announce:
            steps = followed(steps, tracer.batch, total, scene.noise)
        for progress in steps:
            if progress.pixels == 0 and not pace.announce:
                self.draw(target)
            yield progress.samples, total
        self.draw(target)

    def draw(self, target: moderngl.Framebuffer) -> None:
        """Draw the mean of the samples of all pixels so far."""
        tracer = self.tracer
        program = programs(self.ctx).screen("passes/picture/path.frag")
        draw_screen(program, target, tracer.inputs(), samples=float(max(tracer.progress.samples, 1)))

    def sums(self) -> PathSums:
        """Of the last picture."""
        return self.tracer.sums()

    def release(self) -> None:
        """Free the GPU's memory."""
        self._map.release()
        if self._tracer is not None:
            self._tracer.release()

    @property
    def progress(self) -> Progress:
        """Of the last picture."""
        return self.tracer.progress
