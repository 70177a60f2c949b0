"""Method `path`: a frame's surfaces and lights for the path tracer, and its pictures on a target."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import moderngl
import numpy as np

from ..color import srgb_decode
from ..errors import InputError
from ..geometry.materials import base_picture
from ..geometry.raw import Material
from ..gpu.environment_map import EnvironmentMap
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..gpu.screen import draw_screen
from ..light.environment import rotation_y
from ..tracing.denoise import check_denoiser
from ..tracing.path import PathSums, PathTracer, PathView, Progress, followed, samples_of
from ..tracing.path_world import Catcher, Map, Maps, Painted, PathWorld
from .cloths import Cloth
from .frame import Frame
from .openings import Opacity
from .pace import Pace
from .prints import Print
from .solids import FADE
from .uv_scale import guessed_scale


def check_path(frame: Frame) -> None:
    """Raise InputError for what paths cannot show."""
    scene = frame.scene
    if scene.denoise:
        check_denoiser()
    if scene.shadows != "full":
        raise InputError(f"method path: shadows {scene.shadows}, but rays always meet what is there; leave it out")
    if any(cloth.mask for cloth in frame.cloths):
        raise InputError("method path: fabric masks are not for it; leave them out, or take method direct")
    objects = frame.objects
    if objects is None:
        return
    for mesh, materials in zip(objects.meshes, objects.materials or ((),) * len(objects.meshes), strict=True):
        if any(material.roughness < 1.0 or material.metalness > 0.0 for material in materials):
            raise InputError(
                f"method path: object {mesh.name} has gloss or metal, expected matt colours; take method direct"
            )


def world_of(frame: Frame) -> PathWorld:
    """What paths meet in a frame."""
    cloths = tuple((cloth.mesh, cloth.fabric) for cloth in frame.cloths)
    maps: tuple[Maps, ...] = ()
    if any(cloth.print or cloth.opacity for cloth in frame.cloths):
        maps = tuple(_maps(cloth, frame.scene.uv_scale) for cloth in frame.cloths)
    if (objects := frame.objects) is None:
        return PathWorld(cloths, maps=maps)
    painted = tuple(
        _painted(materials, of) for materials, of in zip(objects.materials, objects.material_of, strict=True)
    )
    reflectances = (
        [
            reflectance if paint is None else _under(reflectance, paint, materials, of)
            for reflectance, paint, materials, of in zip(
                objects.reflectances, painted, objects.materials, objects.material_of, strict=True
            )
        ]
        if painted
        else objects.reflectances
    )
    ground, catcher = objects.ground, None
    if ground is not None and ground.catcher:
        catcher = Catcher(ground.center, (FADE[0] * ground.scale, FADE[1] * ground.scale))
    return PathWorld(
        cloths, tuple(zip(objects.meshes, reflectances, strict=True)),
        None if ground is None else (ground.height, ground.color), catcher, maps, painted,
    )  # fmt: skip


def _maps(cloth: Cloth, uv_scale: float) -> Maps:
    """The maps of a cloth; `uv_scale`: metres in a UV unit, 0: measured."""

    def over(texels: np.ndarray, of: Print | Opacity) -> Map:
        unit = (uv_scale or guessed_scale(cloth.mesh)) if of.in_metres else 1.0
        return Map(texels, (unit / of.repeat[0], unit / of.repeat[1]))

    return Maps(
        None if cloth.print is None else over(cloth.print.colors, cloth.print),
        None if cloth.opacity is None else over(cloth.opacity.shares, cloth.opacity),
    )


def _painted(materials: Sequence[Material], material_of: np.ndarray) -> Painted | None:
    """The pictures of an object; None where it has none."""
    pictures: list[np.ndarray] = []
    number = np.full(len(materials), -1)
    for k, material in enumerate(materials):
        if (codes := base_picture(material)) is not None:
            number[k] = len(pictures)
            pictures.append(srgb_decode(codes[::-1, :, :3].astype(np.float32)))
    return Painted(tuple(pictures), number[material_of]) if pictures else None


def _under(reflectance: np.ndarray, paint: Painted, materials: Sequence[Material], of: np.ndarray) -> np.ndarray:
    """What triangles reflect, but for their pictures: these multiply the materials' own colours."""
    own = np.array([material.color for material in materials], np.float32)[of]
    return np.where(paint.picture_of[:, None] < 0, reflectance, own)


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

    def steps(
        self, frame: Frame, target: moderngl.Framebuffer, pace: Pace, patience: Callable[[], float] | None = None
    ) -> Iterator[tuple[int, int]]:
        """Trace a frame into a framebuffer; yields (samples finished, samples at most) after each step. Raises InputError.

        patience : seconds that a step may take; with it the framebuffer is left alone until the end, see `draw`
        """
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
        steps: Iterator[Progress] = tracer.steps(view, total, scene.noise, patience)
        if pace.announce:
            steps = followed(steps, tracer.batch, total, scene.noise)
        for progress in steps:
            if progress.pixels == 0 and not pace.announce and patience is None:
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
