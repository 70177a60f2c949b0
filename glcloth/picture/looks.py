"""The looks of objects that are more than matt colours: pictures, roughness and metalness of each triangle, on the GPU."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import moderngl
import numpy as np

from ..color import srgb_decode
from ..geometry.materials import base_picture
from ..geometry.props import Objects
from ..geometry.raw import Material
from ..gpu.buffers import TextureBuffer
from ..gpu.gbuffer import GBuffer, MeshBuffers
from ..gpu.pictures import even_size, picture_array, resampled
from ..twins.gloss import gaussian_gloss_albedo, gloss_albedo

TAPS = 8.0  # places at which a pixel reads a picture
ALBEDO_SIDE = 24  # values a side of the table of what gloss reflects; one between each two, for what Gaussians do
MOST_TEXELS = 1 << 24  # of all pictures together, 128 MiB


class Looks:
    """What inputs/picture/shade_object.glsl reads beside light and G-buffer."""

    def __init__(self, ctx: moderngl.Context):
        self.ctx = ctx
        self.glossy = False  # whether any object needs that pass
        self._data, self._uv = TextureBuffer(ctx, 32), TextureBuffer(ctx, 16)
        self._pictures: moderngl.TextureArray | None = None
        self._albedo: moderngl.Texture | None = None

    def take(self, objects: Objects, shares: Sequence[int], uvs: Sequence[np.ndarray], triangles: int) -> None:
        """Take other objects.

        Parameters
        ----------
        shares : how many triangles each one of a mesh was cut into
        uvs : of each mesh as it is drawn, [V, 2], the ground's among them
        triangles : that are drawn, the ground's among them, which come last
        """
        used = {material for of_mesh in objects.materials for material in of_mesh}
        self.glossy = any(not is_matt(material) for material in used)
        if not self.glossy:
            return
        layers: dict[Material, int] = {}
        pictures: list[np.ndarray] = []
        for material in sorted((m for m in used if m.texture is not None), key=lambda m: m.name):
            if (codes := base_picture(material)) is not None:
                layers[material] = len(pictures)
                pictures.append(srgb_decode(codes[..., :3].astype(np.float32)))
        rows = np.zeros((triangles, 2, 4), "f4")
        rows[:, 0, 3], rows[:, 1, 0] = -1.0, 1.0
        first = 0
        for number, share in enumerate(shares):
            count = len(objects.meshes[number].triangles) * share
            mine = rows[first : first + count]
            mine[:, 0, :3] = np.repeat(objects.reflectances[number], share, axis=0)
            for which, material in enumerate(objects.materials[number] if number < len(objects.materials) else ()):
                of = np.repeat(objects.material_of[number] == which, share)
                mine[of, 1, 0], mine[of, 1, 1] = material.roughness, material.metalness
                if material in layers:
                    mine[of, 0, :3], mine[of, 0, 3] = material.color, layers[material]
            first += count
        if objects.ground is not None:
            rows[first:, 0, :3] = objects.ground.color
        if self._albedo is None:
            self._albedo = _albedo_table(self.ctx)
        self._data.write(rows)
        self._write_uv(uvs)
        self._put(pictures)

    def _write_uv(self, uvs: Sequence[np.ndarray]) -> None:
        flat = np.concatenate(uvs)
        self._uv.write(np.pad(flat, ((0, 0), (0, 2))).astype("f4"))

    def _put(self, pictures: list[np.ndarray]) -> None:
        """All pictures in one array, of the size of the largest as far as there is room."""
        if self._pictures is not None:
            self._pictures.release()
        height, width = (max((p.shape[k] for p in pictures), default=1) for k in (0, 1))
        size = even_size(height, width, MOST_TEXELS // max(len(pictures), 1))
        layers = [resampled(picture[::-1], size) for picture in pictures] or [np.ones((1, 1, 3), np.float32)]
        self._pictures = picture_array(self.ctx, np.stack(layers))

    def inputs(self, buffer: GBuffer, mesh: MeshBuffers) -> dict[str, Any]:
        """All of that."""
        assert buffer.drawn is not None and self._pictures is not None
        return {
            "look_data": self._data,
            "base_pictures": self._pictures,
            "gloss_albedo": self._albedo,
            "look_taps": TAPS,
            "thread_points": mesh.vertices,
            "thread_corners": mesh.indices,
            "thread_uv": self._uv,
            "viewpoint": buffer.drawn.camera.viewpoint,
            "step_from_pixel": buffer.drawn.camera.step_from_pixel(buffer.size),
        }


def _albedo_table(ctx: moderngl.Context) -> moderngl.Texture:
    """What inputs/picture/gloss.glsl reads: the shares of light that leave after one reflection, of directions and of Gaussians,
    for cosines t^2 along x and roughnesses along y, both from 0 to 1."""
    side = 2 * ALBEDO_SIDE - 1
    places, all_places = np.linspace(0.0, 1.0, ALBEDO_SIDE), np.linspace(0.0, 1.0, side)
    t, roughness = np.meshgrid(places, places)
    coarse = gloss_albedo(t.ravel() ** 2, roughness.ravel() ** 2, 48).reshape(t.shape)
    for axis in (0, 1):
        coarse = np.apply_along_axis(lambda row: np.interp(all_places, places, row), axis, coarse)
    t, roughness = np.meshgrid(all_places, all_places)
    shares = np.stack([coarse, gaussian_gloss_albedo(t**2, roughness**2)], -1)
    table = ctx.texture((side, side), 2, shares.astype("f4").tobytes(), dtype="f4")
    table.filter = moderngl.LINEAR, moderngl.LINEAR
    table.repeat_x = table.repeat_y = False
    return table


def is_matt(material: Material) -> bool:
    """Whether a material is one colour without gloss, as inputs/picture/shade_lambert.glsl shades it."""
    return material.texture is None and material.roughness >= 1.0 and material.metalness <= 0.0
