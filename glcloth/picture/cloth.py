"""A cloth as a surface: a fabric on a mesh, shaded by one of the methods."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import moderngl
import numpy as np

from ..fabric import Fabric, Transmission
from ..geometry.hairs import Hairs
from ..geometry.mesh import Mesh
from ..gpu.covered import Way, shading
from ..gpu.gbuffer import GBuffer, MeshBuffers
from ..gpu.memo import Last
from ..gpu.programs import Compute, Draw, programs
from ..gpu.scene_buffers import SceneBuffers
from ..light.lights import Lights
from ..methods.albedo import diffuse_albedo
from ..methods.method import Method
from ..methods.registry import make_method
from ..tracing.energy import mean_albedo, reflection_limit
from ..visibility.furnace import Given
from ..visibility.hit_vertices import HitSurface
from ..visibility.irradiance import irradiance_table
from ..visibility.pixels import SEEN_ALL, PixelView
from ..visibility.probes import lift_off_facets, subdivided
from ..visibility.sheets import Passed, sees_through
from ..visibility.vertices import FLAT
from .adaptive import AdaptiveRate, Shown
from .cut_textures import CutTextures
from .frame import Cloth, Frame
from .fuzz import Fuzz
from .openings import mostly_closed, open_last
from .pace import Pace
from .prints import Print
from .surface import Surface
from .threads import Threads

SHADE, SHADE_THROUGH = "inputs/picture/shade_cloth.glsl", "inputs/picture/shade_through.glsl"
SHADE_TERMS = "inputs/picture/shade_terms.glsl"
WOVEN_HOLES = {"inputs/picture/straight.glsl": "inputs/picture/straight_woven.glsl"}
SHARE_STEP = 0.01  # relative, of the reflectance that bounced light is gathered with: half of it is the most it is off


class ClothSurface(Surface):
    """Cloth number n of a frame; it keeps its methods, its fabric's records and what its vertices see."""

    method: Method
    transmission: Transmission | None = None
    mask_number = 0  # which fabric of a mask it is; 0: that of its part
    _worn: tuple[Cloth, float]  # what was taken last, and its UV unit in the unit of its opacity map

    def __init__(self, ctx: moderngl.Context):
        super().__init__(ctx, FLAT)
        self.scene_buffers = SceneBuffers(ctx)
        self.methods: dict[str, Method] = {}
        self._finer: Last[Mesh] = Last()
        self._passed: Last[Passed] = Last()
        self._limit: Last[float] = Last()
        self._mean: Last[np.ndarray] = Last()  # of the print
        self._dyed: Last[Fabric] = Last()
        self._glare: Last[np.ndarray] = Last()
        self._print: tuple[Print, np.ndarray] | None = None
        self._open: Last[tuple[Mesh, int]] = Last()
        self._cut = CutTextures(ctx)
        self.adaptive_rate: AdaptiveRate | None = None
        self.threads = Threads(ctx)
        self.fuzz = Fuzz(ctx)

    def named_method(self, name: str) -> Method:
        """The method of a name, made at first use. Raises InputError for an unknown one."""
        if name not in self.methods:
            self.methods[name] = make_method(self.ctx, name)
        return self.methods[name]

    def prepare(self, cloth: Cloth, frame: Frame, finer: bool) -> None:
        """Take another mesh, fabric, light or method; cheap where nothing changed.

        `finer`: the mesh is drawn with more vertices, for the sake of its shadows.
        """
        scene = frame.scene
        fabric = self._printed(cloth, frame)
        self.scene_buffers.prepare(fabric, frame.lights)
        self.method = self.named_method("direct" if scene.method == "path" else scene.method)
        self.method.prepare(fabric, frame.lights, frame.settings)
        self.passes = list(self.method.passes())
        self.pass_count = len(self.passes)
        self.original, self._hiding, scale = self._opened(cloth, frame)
        self.adaptive = scene.adaptive and scene.method == "direct" and scene.quality != "high" and scene.spp == 1
        yarns = cloth.fabric.yarn
        self._narrowest = float(np.radians(min(min(yarn.gamma_s_deg, yarn.gamma_v_deg) for yarn in yarns)))
        mesh = self.original
        drawn = self._finer.get(lambda: subdivided(mesh), mesh) if finer else mesh
        self._worn = cloth, scale
        self._place(lambda: self._uploaded(drawn, mesh, cloth, scale), drawn, cloth.opacity, scale, cloth.mask)
        self._take_transmission(cloth.fabric, frame)
        self.threads.prepare(fabric, self.buffers, frame, self._print)

    def _printed(self, cloth: Cloth, frame: Frame) -> Fabric:
        """The fabric, dyed in the mean of what is printed on it."""
        self._print, self._fabric = None, cloth.fabric
        if (design := cloth.print) is None:
            return cloth.fabric
        scale = self.threads.unit(cloth.mesh, frame) if design.in_metres else 1.0
        mean = self._mean.get(lambda: design.mean_on(cloth.mesh, scale), design, cloth.mesh, scale)
        self._print, self._scale = (design, mean), scale
        return self._dyed.get(lambda: cloth.fabric.dyed(tuple(mean.tolist())), cloth.fabric, mean)

    def _take_transmission(self, fabric: Fabric, frame: Frame) -> None:
        """Where light passes through the fabric: how much evenly, whether straight on, and what is left to reflect."""
        self.transmission, self._lights = fabric.transmission, frame.lights
        self.sheer = sees_through(self.transmission)
        limit = 1.0
        if self.transmission is not None:
            limit = self._limit.get(lambda: reflection_limit(fabric), fabric)
            self._mirror_albedo = limit * mean_albedo(fabric)
        self.visibility.passed = self._passed.get(lambda: Passed.of(fabric.transmission), fabric)
        self.visibility.limit = limit
        self.adaptive &= limit == 1.0  # its passes have no weight

    def _opened(self, cloth: Cloth, frame: Frame) -> tuple[Mesh, int | None, float]:
        """The mesh, how many of its triangles hide light, and what its UV unit is in the unit of its opacity map."""
        opacity, mask, mesh = cloth.opacity, cloth.mask, cloth.mesh
        self.mask_number = 0 if mask is None else mask.number
        if opacity is None and mask is None:
            return mesh, None, 1.0
        scale = self.threads.unit(mesh, frame) if opacity is not None and opacity.in_metres else 1.0

        def ordered() -> tuple[Mesh, int]:
            hides = np.ones(len(mesh.triangles), bool)
            if opacity is not None:
                hides &= mostly_closed(mesh, opacity, scale)
            return open_last(mesh, hides if mask is None else hides & mask.mostly(mesh))

        return *self._open.get(ordered, mesh, opacity, scale, mask), scale

    def _uploaded(self, drawn: Mesh, original: Mesh, cloth: Cloth, scale: float) -> MeshBuffers:
        lift = lift_off_facets(drawn, original) if drawn is not original else None
        cut_out = None
        if cloth.opacity is not None or cloth.mask is not None:
            cut_out = self._cut.cut_out(drawn, cloth.opacity, scale, cloth.mask)
        return MeshBuffers(self.ctx, drawn, lift, cut_out=cut_out)

    @property
    def broad(self) -> np.ndarray:
        return self.method.broad

    @property
    def hit_surface(self) -> HitSurface:
        return HitSurface(self.mesh, self.original, hiding=self._hiding)

    @property
    def reflectance(self) -> np.ndarray:
        """In steps, so that bounced light is gathered anew only for edits that it shows; what a pixel makes of it has none."""
        albedo = self.visibility.furnace.albedo(self.scene_buffers) * self.visibility.limit
        return np.exp(SHARE_STEP * np.round(np.log(np.maximum(albedo, 1e-6)) / SHARE_STEP))

    @property
    def given(self) -> Given:
        return self.visibility.furnace.given(self.scene_buffers)

    def albedo_at(self, triangles: np.ndarray, uv: np.ndarray) -> np.ndarray:
        if self._print is None:
            return super().albedo_at(triangles, uv)
        # What a fabric reflects is linear in a colour that all its yarns have in common.
        design, mean = self._print
        black, dyed = self._fabric.dyed((0.0, 0.0, 0.0)), self._fabric.dyed(tuple(mean.tolist()))
        share = self._glare.get(
            lambda: diffuse_albedo(black) / np.maximum(diffuse_albedo(dyed), 1e-9), self._fabric, mean
        )
        ratio = design.at(uv * self._scale) / np.where(mean > 0.0, mean, 1.0)
        return self.reflectance * (share + (1.0 - share) * ratio)

    # -- shading -----------------------------------------------------------------------------------------------------

    def _virtual(self) -> dict[str, str]:
        seen = SEEN_ALL if self.visibility.mode == "off" else self.visibility.source
        return {"method.glsl": self.method.source, "seen.glsl": seen, **self.method.includes()}

    def program(self, buffer: GBuffer, way: Way | None = None) -> Draw | Compute:
        """The program that shades the pixels of a G-buffer; `way`: this one and not the frame's."""
        defines = {**self.method.defines(), **buffer.defines()}
        return shading(self.ctx, SHADE, defines, self._virtual(), way or self.way)

    def woven_program(self, buffer: GBuffer) -> Draw | Compute:
        """As `program`, for pixels that show threads."""
        virtual = {**self._virtual(), "inputs/methods/threads.glsl": self.threads.source}
        defines = {**self.threads.defines(self.method), **buffer.defines()}
        return shading(self.ctx, SHADE, defines, virtual, self.way)

    @property
    def list_program(self) -> Compute:
        """The program that shades the pixels of a list."""
        return programs(self.ctx).compute("passes/picture/shade_list.comp", self.method.defines(), self._virtual())

    def inputs(self, view: PixelView) -> dict[str, Any]:
        """What these programs read beside the G-buffer."""
        seen = {} if self.visibility.mode == "off" else view.inputs(self.scene_buffers)
        if self.method.traced:
            seen = seen | view.drawn_inputs()
        return {**self.scene_buffers.inputs(), **seen, **self.method.inputs()}

    def shade_inputs(self, view: PixelView, number: int, weight: float) -> tuple[Mapping[str, Any], ...]:
        """What `program` reads beside the G-buffer; parameters as for `shade`."""
        share = {"pass_weight": weight * self.visibility.limit, "pass_cover": 0.0 if number else weight}
        return self.inputs(view), {**share, "pixel_stride": 1}, self.passes[number]

    def shade(
        self, buffer: GBuffer, view: PixelView, number: int, weight: float, add: bool, rows: tuple[int, int] | None
    ) -> None:
        if number >= self.pass_count:
            return
        inputs = self.shade_inputs(view, number, weight)
        if not self.threads.shown:
            buffer.shade(self.program(buffer), *inputs, add=add, rows=rows)
        else:
            self._shade_threads(buffer, inputs, add, rows)
        if self.transmission is not None:
            self._shade_through(buffer, view, number, weight, rows)

    def _shade_threads(self, buffer: GBuffer, inputs: tuple, add: bool, rows: tuple[int, int] | None) -> None:
        for near in (False, True):
            self.threads.choose(buffer, near)
        buffer.shade(self.program(buffer), *inputs, add=add, rows=rows, part=False)
        woven = self.threads.inputs(self.method, buffer)
        buffer.shade(self.woven_program(buffer), *inputs, woven, add=add, rows=rows, part=True)

    def hairs(self, buffer: GBuffer, frame: Frame) -> Hairs | None:
        """The hairs that may show beyond its outline in a G-buffer; None: it has none."""
        weave = self._fabric.weave
        if not self.threads.woven or weave is None or not weave.fuzz or frame.camera.aperture:
            return None
        return self.fuzz.hairs(*self._worn, buffer, self.threads.in_metres, self.threads.far, frame) or None

    def draw_hairs(self, hairs: Hairs, buffer: GBuffer, nearest: moderngl.Texture, frame: Frame) -> None:
        """Draw them over the finished picture; `nearest`: the depth of all that is in it."""
        albedo = self.visibility.furnace.albedo(self.scene_buffers)
        inputs = self.threads.inputs(self.method, buffer)
        self.fuzz.draw(self._fabric, albedo, hairs, buffer, nearest, self.visibility, frame, inputs)

    def straight_program(self, buffer: GBuffer) -> Draw:
        if not self.threads.woven:
            return super().straight_program(buffer)
        return programs(self.ctx).screen("passes/picture/left.frag", self.threads.defines(self.method), WOVEN_HOLES)

    def straight_inputs(self, buffer: GBuffer) -> dict[str, Any]:
        if self.transmission is None:
            return {}
        threads = self.threads.inputs(self.method, buffer) if self.threads.shown else {}
        return {**self.transmission.model_dump(), **threads}

    def _shade_through(
        self, buffer: GBuffer, view: PixelView, number: int, weight: float, rows: tuple[int, int] | None
    ) -> None:
        """Add what comes through from the other side, but for what goes straight on, which is drawn."""
        sums = self.method.lights_solids  # over the directions of each pass
        if not sums and number:
            return
        virtual = {"behind.glsl": self.method.behind, **self.method.behind_includes()}
        defines = {**(self.method.defines() if sums else {}), **buffer.defines()}
        if self.threads.shown:
            holes = WOVEN_HOLES if self.threads.woven else {}
            virtual, defines = {**virtual, **holes}, {**self.threads.defines(self.method), **defines}
        program = shading(self.ctx, SHADE_THROUGH, defines, virtual, self.way)
        if sums:
            light = {**self.method.inputs(), **view.drawn_inputs(), **self.passes[number]}
        else:
            view.resolve_behind()
            table = irradiance_table(self.ctx, self._lights)
            light = {**self.scene_buffers.inputs(), **table, **view.behind_inputs()}
        own = {"pass_weight": weight, "mirror_albedo": self._mirror_albedo}
        buffer.shade(program, self.straight_inputs(buffer), light, own, add=True, rows=rows)

    def shade_adaptively(self, buffer: GBuffer, view: PixelView, pace: Pace) -> Iterator[None]:
        if self.adaptive_rate is None:
            self.adaptive_rate = AdaptiveRate(self.ctx)
        inputs: Callable[[], Mapping[str, Any]] = lambda: self.inputs(view)  # noqa: E731
        shown = self._shown(buffer) if self.threads.shown else None
        yield from self.adaptive_rate.steps(
            buffer, self.program(buffer), self.list_program, self._narrowest, inputs, pace, shown
        )
        if self.transmission is not None:
            self._shade_through(buffer, view, 0, 1.0, None)

    def _shown(self, buffer: GBuffer) -> Shown:
        """What the adaptive rate must know of the pixels that show threads."""
        far, near = (self.threads.choose(buffer, which) for which in (False, True))
        defines = self.threads.defines(self.method)
        groups, lanes = self.method.woven_packing()
        terms = {**self.method.defines(), **self.method.woven_defines(), "TERMS": 1, "LANE_COUNT": lanes}
        woven = {"inputs/methods/threads.glsl": self.threads.source}
        virtual = {**self._virtual(), "inputs/methods/threads.glsl": "inputs/methods/terms.glsl"}
        return Shown(
            near,
            far,
            shading(self.ctx, SHADE_TERMS, terms, virtual, self.way),
            7 * groups + 2,
            programs(self.ctx).compute("passes/picture/shade_list.comp", defines, {**self._virtual(), **woven}),
            defines,
            woven,
            lambda: {**self.threads.inputs(self.method, buffer), "term_scale": term_scale(self._lights)},
        )


def term_scale(lights: Lights) -> float:
    """A power of two that makes what cloth reflects of lights about 1, so that half floats hold it, whatever their unit."""
    gaussians, suns = lights.gaussians, lights.suns
    solid = -np.pi * np.expm1(-2.0 * np.maximum(gaussians.sharpness, 1e-6)) / np.maximum(gaussians.sharpness, 1e-6)
    total = float(np.abs(gaussians.amplitude * solid[:, None]).sum() + np.abs(suns.irradiance).sum())
    return float(2.0 ** -round(np.log2(total))) if total > 0.0 else 1.0
