"""Fuzz: the hairs of spun yarns that stand out beyond the outline of a cloth, drawn over its finished picture.   [own]"""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ..color import luminance
from ..fabric import Fabric
from ..geometry.hairs import RANDOM, Hairs, hairs_in_view, rim_edges
from ..gpu.buffers import TextureBuffer
from ..gpu.gbuffer import GBuffer
from ..gpu.memo import Last
from ..gpu.programs import programs
from ..light.lights import Lights, Suns
from ..twins.scatter import f_s
from ..visibility.pixels import PixelVisibility
from .frame import Cloth, Frame
from .prints import texel_means

DIAMETER = 20e-6  # metres, of a hair: between cotton (12 to 20 micrometres) and wool (18 to 40)
SEGMENTS = 5  # of a hair
TABLE_SIDE = 20  # directions of hairs
NODES = 48  # directions of a light
# Hair lengths before the cloth, from which on a hair shows, and shows whole: from straight above to 80 degrees none does, on
# cloth that is flat.
CLEAR = 5.0, 9.0
FARTHEST = 0.75  # of the longest hair, in a pixel: from there on hairs are dots, which say nothing of hairs
ONE_MINUS_SRC1_COLOR = 0x88FA  # of OpenGL: 1 - the second output of a fragment
SOFTEST = 0.25  # of hair_horizon, at least: hairs stand above the plane at their root


class Fuzz:
    """The hairs of one cloth."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self._hairs: Last[Hairs] = Last()
        self._written: Last[None] = Last()
        self._rim: Last[np.ndarray] = Last()
        self._lights: Last[dict[str, Any]] = Last()
        self._scale: Last[float] = Last()
        self._table: moderngl.TextureArray | None = None
        self._hair_data = TextureBuffer(ctx, 16)
        self._light_data = TextureBuffer(ctx, 16)
        self._nodes = TextureBuffer(ctx, 16)
        self._no_means = TextureBuffer(ctx, 16, "r32ui")

    def hairs(self, cloth: Cloth, scale: float, buffer: GBuffer, metres: float, far: float, frame: Frame) -> Hairs:
        """Those that may show in a G-buffer as it is drawn; `scale`: of a UV unit in the unit of the opacity map."""
        assert buffer.drawn is not None and cloth.fabric.weave is not None
        mesh, weave = buffer.drawn.mesh.mesh, cloth.fabric.weave
        whole = mesh if cloth.mask is None else cloth.mask.whole  # where a mask parts cloth, it does not end
        edges = self._rim.get(lambda: rim_edges(whole), whole.triangles)
        length = 1e-3 * weave.fuzz_length
        measures = 1e6 * weave.fuzz, length, DIAMETER, min(far, FARTHEST * length)
        return self._hairs.get(
            lambda: hairs_in_view(
                mesh,
                whole.positions[edges],
                metres,
                frame.camera,
                buffer.size,
                *measures,
                lambda uv: _closed(cloth, scale, uv),
            ),
            *(mesh, metres, frame.camera, buffer.size, measures, cloth.opacity, scale, cloth.mask),
        )

    @property
    def last(self) -> Hairs | None:
        """The hairs of the last picture near by."""
        return self._hairs.value

    def draw(
        self,
        fabric: Fabric,
        albedo: np.ndarray,
        hairs: Hairs,
        buffer: GBuffer,
        nearest: moderngl.Texture,
        visibility: PixelVisibility,
        frame: Frame,
        inputs: dict[str, Any],
    ) -> None:
        """Draw hairs over the picture of a G-buffer.

        albedo : [3] what the cloth reflects of even light. nearest : the depth of all that is in the picture.
        inputs : `Threads.inputs`.
        """
        drawn, weave = buffer.drawn, fabric.weave
        assert drawn is not None and weave is not None
        self._written.get(lambda: self._hair_data.write(_records(hairs, 1e-3 * weave.fuzz_length)), hairs)
        camera, full = drawn.camera, visibility.mode == "full"
        right, up, forward = camera.axes
        view_from_world = np.stack([right, up, -forward])
        light = self._lights.get(
            lambda: self._light(fabric, albedo, frame.lights, view_from_world),
            *(fabric, albedo.tobytes(), frame.lights, view_from_world.tobytes()),
        )
        width, height = buffer.size
        at_one = camera.ortho or 2.0 * float(np.tan(np.radians(camera.fov_deg) / 2))
        ink = {"PRINT": 1} if "print_map" in inputs else {}
        program = programs(self.ctx).draw("passes/picture/fuzz.vert", "passes/picture/fuzz.frag", ink)
        program.bind(
            buffer.inputs(),
            inputs,
            light,
            hair_data=self._hair_data,
            clip_from_world=camera.clip_from_world(buffer.size, *drawn.depths),
            view_from_world=view_from_world,
            half_size=(0.5 * width, 0.5 * height),
            metres_in_pixel=at_one / height,
            diameter=DIAMETER,
            segments=SEGMENTS,
            mean_data=visibility.vertices.means if full else self._no_means,
            group_count=visibility.vertices.groups if full else 0,
            nearest=nearest,
            own_depth=buffer.depth,
            clear_way=tuple(1e-3 * weave.fuzz_length * n for n in CLEAR),
        )
        target = self.ctx.framebuffer([buffer.color])
        target.use()
        target.viewport = (0, 0, width, height)
        self.ctx.enable_only(moderngl.BLEND)
        self.ctx.blend_func = moderngl.ONE, ONE_MINUS_SRC1_COLOR
        program.screen.render(moderngl.TRIANGLE_STRIP, vertices=2 * (SEGMENTS + 1), instances=len(hairs))
        # Mesa refuses to draw into several pictures while this is set, even where nothing is blended.
        self.ctx.blend_func = moderngl.ONE, moderngl.ZERO
        self.ctx.enable_only(moderngl.NOTHING)
        self.ctx.detect_framebuffer(0).use()
        target.release()

    def _light(self, fabric: Fabric, albedo: np.ndarray, lights: Lights, view_from_world: np.ndarray) -> dict[str, Any]:
        """What passes/picture/fuzz.vert reads of the lights, and its table."""
        if not len(lights.gaussians) + len(lights.suns):  # the shader takes one at least
            lights = Lights(lights.gaussians, Suns(np.array([[0.0, 1.0, 0.0]]), np.zeros((1, 3))))
        axes, soft, flux, nodes = _light_nodes(lights)
        self._nodes.write(np.pad(nodes.reshape(-1, 3) @ view_from_world.T, ((0, 0), (0, 1))).astype("f4"))
        records = np.zeros((len(axes), 2, 4), "f4")
        records[:, 0, :3], records[:, 0, 3], records[:, 1, :3] = axes, soft, flux * evenness(fabric, albedo)
        self._light_data.write(records)
        if self._table is None or self._table.layers != len(axes):
            if self._table is not None:
                self._table.release()
            self._table = self.ctx.texture_array((TABLE_SIDE, TABLE_SIDE, len(axes)), 4, dtype="f2")
            self._table.repeat_x = self._table.repeat_y = False
        optics = np.array([_optics(fabric, j) for j in (0, 1)], "f4")
        programs(self.ctx).compute("passes/picture/hair_light.comp").run(
            TABLE_SIDE**2 * len(axes),
            light_nodes=self._nodes,
            node_count=NODES,
            light_count=len(axes),
            side=TABLE_SIDE,
            optics=optics,
            hair_table=self._table,
        )
        areas = [yarn.area for yarn in fabric.yarn]
        return {
            "hair_table": self._table,
            "hair_lights": self._light_data,
            "light_count": len(axes),
            "gaussian_count": float(len(lights.gaussians)),
            "warp_share": areas[0] / max(sum(areas), 1e-9),
        }


def _closed(cloth: Cloth, scale: float, uv: np.ndarray) -> np.ndarray:
    """Whether a cloth is at UVs [N, 2], and is not cut out nor of another fabric."""
    here = np.ones(len(uv), bool)
    if cloth.opacity is not None:
        here &= texel_means(cloth.opacity.shares, uv * (scale / np.array(cloth.opacity.repeat)))[:, 0] >= 0.5
    if cloth.mask is not None:
        here &= cloth.mask.shown_at(uv)
    return here


def _optics(fabric: Fabric, j: int) -> tuple[float, float, float, float]:
    yarn = fabric.yarn[j]
    return yarn.eta, yarn.k_d, float(np.radians(yarn.gamma_s_deg)), float(np.radians(yarn.gamma_v_deg))


def _records(hairs: Hairs, length: float) -> np.ndarray:
    """Four texels a hair, as passes/picture/fuzz.vert reads them."""
    out = np.zeros((len(hairs), 16), "f4")
    out[:, 0], out[:, 1:3], out[:, 3] = hairs.triangle, hairs.weights, length * hairs.length
    out[:, 4 : 4 + RANDOM], out[:, 12], out[:, 13] = hairs.random, hairs.width, hairs.side
    return out


def _light_nodes(lights: Lights) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Of each Gaussian and then of each sun: axis [L, 3], how wide it is as a sine [L], its light [L, 3] (radiance times
    solid angle), and directions [L, NODES, 3] that stand for it evenly."""
    gaussians, suns = lights.gaussians, lights.suns
    s = np.maximum(np.append(gaussians.sharpness, np.full(len(suns), 1e6)), 1e-3)[:, None]
    axes = np.concatenate([gaussians.axis, suns.direction])
    left = -np.expm1(-2.0 * s)
    u = (np.arange(NODES) + 0.5) / NODES
    z = 1.0 + np.log1p(-u * left) / s
    turn = np.arange(NODES) * np.pi * (3.0 - np.sqrt(5.0))
    r = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    own = np.where(abs(axes[:, :1]) < 0.7, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    x = np.cross(axes, own)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(axes, x)
    nodes = (
        (r * np.cos(turn))[..., None] * x[:, None]
        + (r * np.sin(turn))[..., None] * y[:, None]
        + z[..., None] * axes[:, None]
    )
    flux = np.concatenate([gaussians.amplitude * (2.0 * np.pi * left / s)[: len(gaussians)], suns.irradiance])
    soft = np.clip(np.sqrt(1.0 / s[:, 0]), SOFTEST, 30.0)
    return axes, soft, flux, nodes


def evenness(fabric: Fabric, albedo: np.ndarray) -> float:
    """The factor that makes hairs under even light from everywhere as bright as the cloth under it: half of that light comes
    from where the cloth is, and does not reach them. Cloth's masking, which keeps its light to what comes, hairs lack."""
    rng = np.random.default_rng(5)
    omega_i, omega_o = (d / np.linalg.norm(d, axis=1, keepdims=True) for d in rng.normal(size=(2, 8192, 3)))
    seen = np.hypot(omega_o[:, 1], omega_o[:, 2])  # how long a hair looks
    cosine = (np.hypot(omega_i[:, 1], omega_i[:, 2]) * seen / seen.mean())[:, None]
    light = np.zeros(3)
    for j, yarn in enumerate(fabric.yarn):
        surface, volume = 4.0 * np.pi * (cosine * f_s(omega_i, omega_o, *_optics(fabric, j))).mean(0)
        light += yarn.area * (surface + volume * np.array(yarn.albedo))
    light /= max(sum(yarn.area for yarn in fabric.yarn), 1e-9)
    return float(luminance(np.asarray(albedo, float)[:3]) / max(0.5 * luminance(light), 1e-9))
