"""Layers for compositing of the curtain: what the camera's rays meet first, and the kinds of light that they bring.   [own]

What shines through the curtain's holes has no depth of its own; its light is that of `transmission`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..accel.queries import RayQueries
from ..cryptomatte import ranked
from ..curtain.show import CLOTH, CurtainShow, camera_of
from ..geometry.camera import Camera, lens_samples, sample_offsets
from ..progress import check_stopped
from ..tracing.energy import mean_albedo, reflection_limit
from ..twins.octahedron import from_octahedral
from .layers import CHANNELS, CRYPTOMATTE, FAR, LIGHT, PATH_SAMPLES, Layers

RAYS = 1 << 18  # at a time


def curtain_layers(show: CurtainShow, names: Sequence[str], picture: np.ndarray) -> Layers:
    """The layers of a picture of the curtain as it hangs, with the samples of its scene; by method path with PATH_SAMPLES.

    Layers of light are those of the tracer's last picture, which was made with `parted`.
    """
    scene, camera = show.scene, camera_of(show.scene)
    width, height = scene.size
    soup = _Soup(show)
    queries = RayQueries(show.ctx)
    light = show.tracer.parts(scene.size) if set(names) & set(LIGHT) else {}
    sums = {
        name: np.zeros((height * width, len(CHANNELS[name])))
        for name in names
        if name in CHANNELS and name not in LIGHT
    }
    cover = np.zeros((height * width, len(soup.names))) if "cryptomatte" in names else None
    spp = PATH_SAMPLES if scene.method == "path" else scene.spp
    step = max(1, RAYS // width)
    blocks = [range(first, min(first + step, height)) for first in range(0, height, step)]
    for number, (offset, one) in enumerate(zip(sample_offsets(spp), lens_samples(camera, spp), strict=True)):
        for rows in blocks:
            here = slice(width * rows.start, width * rows.stop)
            origins, ways = _rays(one, scene.size, offset, rows)
            hits = queries.closest_hit(show.tracer.structure(scene.accelerator), origins, ways)
            met = np.flatnonzero(hits.triangle >= 0)
            triangle, way, pixel = hits.triangle[met], ways[met], here.start + met
            x = origins[met] + hits.t[met, None] * way
            if "depth" in sums and number == 0:  # that of the pixel's centre: distances of two things have no mean
                sums["depth"][here] = FAR
                sums["depth"][pixel, 0] = (x - one.eye) @ one.axes[2]
            for name in sums.keys() - {"depth"}:
                sums[name][pixel] += soup.values(name, triangle, hits.weights[met], x, way) / spp
            if cover is not None:
                cover[pixel, soup.thing[triangle]] += 1.0 / spp
            check_stopped()
    out = Layers()
    out["beauty"] = picture
    for name in names:
        if name in light:
            out[name] = light[name]
            continue
        if name in sums:
            array = sums[name].astype(np.float32).reshape(height, width, -1)
            out[name] = array[..., 0] if array.shape[-1] == 1 else array
            continue
        assert cover is not None
        used = np.flatnonzero(cover.any(0))
        for layer in CRYPTOMATTE:
            out.names[layer] = [soup.names[n] for n in used]
            out[layer] = ranked(cover[:, used].reshape(height, width, -1), out.names[layer])
    return out


def _rays(
    camera: Camera, size: tuple[int, int], offset: tuple[float, float], rows: range
) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions [N, 3] through the pixels of some rows, counted from the top; a direction is 1 along the view."""
    width, height = size
    y, x = np.mgrid[rows.start : rows.stop, 0:width]
    pixels = np.stack([x + 0.5, height - 0.5 - y, np.ones(x.shape)], -1).reshape(-1, 3)
    pixels[:, :2] += offset
    return pixels @ camera.origin_from_pixel(size).T, pixels @ camera.ray_from_pixel(size).T


class _Soup:
    """The triangles of the room and of the curtain, as hits look them up."""

    def __init__(self, show: CurtainShow):
        show.build()
        room, self.first, self._show = show.room, len(show.room.positions), show
        packed = np.frombuffer(show.triangles.corners.read(48 * show.triangles.count), np.uint32).reshape(-1, 3, 4)[
            ..., 3
        ]
        low, high = (packed & 0xFFFF).astype(np.uint16).view(np.int16), (packed >> 16).astype(np.uint16).view(np.int16)
        self._normals = from_octahedral(np.stack([low, high], -1) / 32767.0)
        self._cloth_albedo = mean_albedo(show.fabric) * reflection_limit(show.fabric)
        self.names = ["curtain", *room.names]
        self.thing = np.zeros(show.triangles.count, int)
        self.thing[: self.first] = room.material + CLOTH + 1

    def values(
        self, name: str, triangles: np.ndarray, weights: np.ndarray, x: np.ndarray, ways: np.ndarray
    ) -> np.ndarray:
        """A layer at hits [N]: [N, n]."""
        cloth = triangles >= self.first
        w = np.concatenate([1.0 - weights.sum(1, keepdims=True), weights], 1)[..., None]
        if name == "position":
            return x
        if name == "mask":
            return cloth[:, None].astype(float)
        if name == "albedo":
            return np.where(cloth[:, None], self._cloth_albedo, self._show.materials[self.thing[triangles]])
        if name == "normal":
            N = (self._normals[triangles] * w).sum(1)
            N /= np.maximum(np.linalg.norm(N, axis=1, keepdims=True), 1e-12)
            return np.where((N * ways).sum(1, keepdims=True) > 0.0, -N, N)
        return np.where(cloth[:, None], (self._uv(np.maximum(triangles - self.first, 0)) * w).sum(1), 0.0)

    def _uv(self, triangles: np.ndarray) -> np.ndarray:
        """UVs [N, 3, 2] of the corners of cloth, in metres as it lies flat: passes/accel/gather_grid.comp has their order."""
        simulation = self._show.simulation
        out, first = np.zeros((len(triangles), 3, 2)), 0
        for piece, count in zip(simulation.pieces, simulation.triangle_counts, strict=True):
            here = (triangles >= first) & (triangles < first + count)
            parameters = piece.parameters
            quad, second = np.divmod(triangles[here] - first, 2)
            row, column = np.divmod(quad, piece.columns - 1)
            places = np.array([[[0, 0], [1, 0], [0, 1]], [[0, 1], [1, 0], [1, 1]]])[
                second
            ]  # row, column of each corner
            u = (column[:, None] + places[..., 1]) / (piece.columns - 1) * parameters.width * parameters.fullness
            v = (1.0 - (row[:, None] + places[..., 0]) / (piece.rows - 1)) * parameters.drop
            out[here] = np.stack([u, v], -1)
            first += count
        return out
