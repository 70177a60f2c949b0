"""Method `path`: a frame's surfaces and lights for the path tracer, and its pictures on a target."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import moderngl
import numpy as np

from ..accel.queries import RayQueries
from ..color import srgb_decode
from ..errors import InputError
from ..geometry.materials import base_picture
from ..geometry.mesh import Mesh
from ..geometry.raw import Material
from ..gpu.environment_map import EnvironmentMap
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..gpu.screen import draw_screen
from ..light.environment import rotation_y
from ..methods.weave_maps import far_footprint
from ..tracing.denoise import check_denoiser
from ..tracing.path import PathSums, PathTracer, PathView, Progress, followed, samples_of
from ..tracing.path_world import Catcher, Map, Maps, Mask, Painted, PathWorld
from .cloths import Cloth
from .frame import Frame
from .openings import Opacity
from .pace import Pace
from .picked import OPEN, Picked
from .prints import Print, texel_means
from .solids import FADE
from .threads import least_footprint
from .uv_scale import guessed_scale

MOST_OPEN = 64  # places that are cut out, one behind the other, which a look goes through


def check_path(frame: Frame) -> None:
    """Raise InputError for what paths cannot show."""
    scene = frame.scene
    if scene.denoise:
        check_denoiser()
    if scene.shadows != "full":
        raise InputError(f"method path: shadows {scene.shadows}, but rays always meet what is there; leave it out")
    if any(cloth.mask is not None and cloth.mesh is not cloth.mask.piece for cloth in frame.cloths):
        raise InputError(
            "method path: a piece of a fabric mask has moved by itself; move the mesh that it is of, or take method direct"
        )
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
    wholes = whole_cloths(frame.cloths)
    masks: tuple[Mask | None, ...] = tuple(_mask(pieces) for pieces in wholes)
    cloths = tuple((_whole(pieces[0]), pieces[0].fabric) for pieces in wholes)
    maps: tuple[Maps, ...] = ()
    if any(cloth.print or cloth.opacity for cloth in frame.cloths):
        maps = tuple(_maps(pieces[0], frame.scene.uv_scale) for pieces in wholes)
    masks = masks if any(masks) else ()
    if (objects := frame.objects) is None:
        return PathWorld(cloths, maps=maps, masks=masks)
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
        None if ground is None else (ground.height, ground.color), catcher, maps, painted, masks,
    )  # fmt: skip


def whole_cloths(cloths: Sequence[Cloth]) -> list[list[Cloth]]:
    """The cloths of a frame, those together that are pieces of one by a fabric mask; the first has the least number."""
    out: list[list[Cloth]] = []
    for cloth in cloths:
        before = out[-1][0].mask if out else None
        if cloth.mask is not None and before is not None and before.whole is cloth.mask.whole:
            out[-1].append(cloth)
        else:
            out.append([cloth])
    return out


def _whole(piece: Cloth) -> Mesh:
    return piece.mesh if piece.mask is None else piece.mask.whole


def _mask(pieces: Sequence[Cloth]) -> Mask | None:
    """The mask that parts a cloth. Its first fabric stands for 0 and for numbers that no triangle shows."""
    if (mask := pieces[0].mask) is None:
        return None
    of_number = {piece.mask.number: piece.fabric for piece in pieces if piece.mask is not None}
    own = pieces[0].fabric
    fabrics = tuple(of_number.get(number, own) for number in range(1, int(mask.numbers.max()) + 1))
    return Mask(mask.numbers, (1.0 / mask.repeat[0], 1.0 / mask.repeat[1]), fabrics)


def _maps(cloth: Cloth, uv_scale: float) -> Maps:
    """The maps of a cloth; `uv_scale`: metres in a UV unit, 0: measured."""

    def over(texels: np.ndarray, of: Print | Opacity) -> Map:
        unit = (uv_scale or guessed_scale(_whole(cloth))) if of.in_metres else 1.0
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


def _cloth_at(frame: Frame, triangle: int, at: np.ndarray) -> Picked | None:
    """What a hit of the frame's tree is of: cloth, OPEN where that is cut out, or None."""
    number = 0
    for pieces in whole_cloths(frame.cloths):
        mesh = _whole(pieces[0])
        if triangle < len(mesh.triangles):
            break
        triangle, number = triangle - len(mesh.triangles), number + len(pieces)
    else:
        return None
    uv = None if mesh.uv is None else _uv_at(mesh, triangle, at)
    cloth = pieces[0]
    if cloth.mask is not None and uv is not None:
        of = [piece.mask.number for piece in pieces if piece.mask is not None]
        shown = cloth.mask.number_at(uv)
        place = of.index(shown) if shown in of else 0
        cloth, number = pieces[place], number + place
    if cloth.opacity is not None and uv is not None:
        unit = (frame.scene.uv_scale or guessed_scale(mesh)) if cloth.opacity.in_metres else 1.0
        if texel_means(cloth.opacity.shares, uv * (unit / np.array(cloth.opacity.repeat)))[0] < 0.5:
            return OPEN
    part = () if mesh.part_of is None or not mesh.parts else mesh.parts[int(mesh.part_of[triangle])]
    return Picked(number, part, 0 if cloth.mask is None else cloth.mask.number)


def _uv_at(mesh: Mesh, triangle: int, at: np.ndarray) -> np.ndarray:
    """The UV [2] of a place [3] on a triangle."""
    assert mesh.uv is not None
    a, b, c = np.asarray(mesh.positions, float)[mesh.triangles[triangle]]
    weights = np.linalg.lstsq(np.stack([b - a, c - a], 1), at - a, rcond=None)[0]
    return (
        np.array([1.0 - weights.sum(), *weights]) @ np.nan_to_num(np.asarray(mesh.uv, float))[mesh.triangles[triangle]]
    )


class PathPictures:
    """Traces frames, and draws what the samples so far come to."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._tracer: PathTracer | None = None
        self._map = EnvironmentMap(ctx)
        self._world: Last[PathWorld] = Last()
        self._units: dict[int, Last[float]] = {}  # of each cloth
        self._queries: RayQueries | None = None

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
        near = self._near(frame)
        if scene.light == "map":
            tracer.sky.take_map(frame.environment, rotation_y(scene.env_rotate))
        else:
            tracer.sky.take_lights(frame.lights)
        behind = {
            "environment_map": self._map.texture(frame.environment),
            "map_from_world": rotation_y(-scene.env_rotate),
        }
        view = PathView(frame.camera, scene.size, behind, scene.background, 24 if scene.bounce else 1, threads=near)
        total = samples_of(scene.spp, scene.noise)
        steps: Iterator[Progress] = tracer.steps(view, total, scene.noise, patience)
        if pace.announce:
            steps = followed(steps, tracer.batch, total, scene.noise)
        for progress in steps:
            if progress.pixels == 0 and not pace.announce and patience is None:
                self.draw(target)
            yield progress.samples, total
        self.draw(target)

    def _take(self, frame: Frame) -> PathWorld:
        world = self._world.get(lambda: world_of(frame), frame.cloths, frame.objects, frame.scene.uv_scale)
        self.tracer.take(world)
        return world

    def _near(self, frame: Frame) -> tuple[float | None, ...]:
        """Of each fabric that is worn the metres in a UV unit, where pixels may be near enough to show its threads, else None."""
        world, units = self._take(frame), []
        for k, fabric in world.worn:
            mesh, unit = world.cloths[k][0], None
            if frame.scene.threads and fabric.weave is not None and mesh.uv is not None:
                low, high = (np.asarray(bound(mesh.positions, axis=0), float) for bound in (np.min, np.max))
                if least_footprint(frame, low, high) < far_footprint(fabric):
                    scale = self._units.setdefault(k, Last())
                    unit = frame.scene.uv_scale or scale.get(lambda mesh=mesh: guessed_scale(mesh), mesh)  # type: ignore[misc]
            units.append(unit)
        return tuple(units)

    def shows_hairs(self, frame: Frame) -> bool:
        """Whether hairs may show beyond outlines of a frame's cloth."""
        worn = zip(self._take(frame).worn, self._near(frame), strict=True)
        return not frame.camera.aperture and any(
            unit is not None and fabric.weave is not None and fabric.weave.fuzz > 0.0 for (_, fabric), unit in worn
        )

    def pick(self, frame: Frame, x: float, y: float) -> Picked | None:
        """The cloth at a place of a frame's picture, as `picked.pick`: a ray looks, which goes through open places."""
        self._take(frame)
        (width, height), camera = frame.scene.size, frame.camera
        pixel = np.array([min(int(x * width), width - 1) + 0.5, min(int((1.0 - y) * height), height - 1) + 0.5, 1.0])
        o, d = camera.origin_from_pixel((width, height)) @ pixel, camera.ray_from_pixel((width, height)) @ pixel
        if self._queries is None:
            self._queries = RayQueries(self.ctx)
        begin = 0.0
        for _ in range(MOST_OPEN):
            hits = self._queries.closest_hit(self.tracer.structure, o[None], d[None], begin)
            found = _cloth_at(frame, int(hits.triangle[0]), o + float(hits.t[0]) * d) if hits.triangle[0] >= 0 else None
            if found is not OPEN:
                return found
            begin = float(hits.t[0]) * (1.0 + 1e-5)
        return None

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
        if self._queries is not None:
            self._queries.release()
        if self._tracer is not None:
            self._tracer.release()

    @property
    def progress(self) -> Progress:
        """Of the last picture."""
        return self.tracer.progress
