"""What a pleated curtain does to light as a whole: how much goes straight on, comes back, comes through, and is sent of the
lamp's. Found by paths among its folds as it hangs without wind, once for a fabric and a lamp.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from ..accel.structure import Structure, make_structure, tracing
from ..accel.triangles import Triangles
from ..color import luminance
from ..gpu.buffers import Buffer, TextureBuffer
from ..gpu.programs import programs
from ..tracing.fabrics import fabric_defines
from .form_factors import Sheet

PATHS = 8192  # from each side
BINS = (12, 8)  # of directions, by their x and y: evenly spread over the disc they are distributed as their cosine
RAYS = 128  # for each of them
MARGIN = 0.2  # m, of the sheet's rim that paths keep away from
NEAR = 50.0  # m
STEEPEST = 0.12  # cosine of the flattest way through the sheet


@dataclass(frozen=True)
class Folds:
    """The curtain as a flat sheet, per flat area, linear Rec. 709.

    passes : [3], what goes straight through of even light; along_bins : [8, 12, 3], by direction
    reflected, transmitted : [2, 3], of even light, seen from the room and from behind: what comes from that side, and from
    the other
    lamp : [2, 3], exitance of either side for an irradiance of 1 by the lamp, on the cloth
    scattered : [2, 2, 3], of `reflected` and `transmitted` what is not mirrored alone
    lamp_hidden : [2, 3], of `lamp` what it does not send from layers that are seen, but by way of others
    directed : [2, 4], how the light that either side sends goes with the direction, by `basis`: 1 on average
    shown : [2, 2, 3], what is seen from the room and from behind of an irradiance on the front and on the back of the cloth
    """

    passes: np.ndarray
    along_bins: np.ndarray
    reflected: np.ndarray
    transmitted: np.ndarray
    lamp: np.ndarray
    scattered: np.ndarray
    lamp_hidden: np.ndarray
    directed: np.ndarray
    shown: np.ndarray

    def profile(self, side: int, direction: np.ndarray) -> np.ndarray:
        """How much more than on average a side sends in directions [..., 3]: [...]. Pleats hide one another."""
        return np.clip(basis(direction) @ self.directed[side], 0.1, 3.0)

    def seen(self) -> dict[str, list]:
        """The uniforms of passes/curtain/light_texels.comp: what folds send each other, for its cells."""
        C = np.moveaxis(self.shown, -1, 0)  # channels first
        determinant = C[:, 0, 0] * C[:, 1, 1] - C[:, 0, 1] * C[:, 1, 0]
        safe = determinant > 0.05 * (C[:, 0, 0] * C[:, 1, 1] + 1e-9)
        inverse = np.zeros_like(C)
        inverse[safe] = np.linalg.inv(C[safe])
        # Where both sides are lit as one another is, neither can be told from the other.
        both = C.sum(2)
        inverse[~safe] = np.array([[1.0, 0.0], [0.0, 1.0]]) / np.maximum(both[~safe], 1e-6)[:, :, None]
        flat = lambda m: np.ascontiguousarray(np.moveaxis(m, 0, -1).reshape(4, 3), "f4").tolist()  # noqa: E731
        return {
            "shown": flat(C),
            "unshown": flat(inverse),
            "scattered": self.scattered.reshape(4, 3).astype("f4").tolist(),
            "hidden": (self.lamp_hidden / np.maximum(self.lamp, 1e-9)).astype("f4").tolist(),
        }

    def along(self, direction: np.ndarray) -> np.ndarray:
        """What goes straight through along directions [..., 3]: [..., 3]."""
        d = direction * np.where(direction[..., 2:] > 0, 1.0, -1.0)
        x, y = ((np.clip((d[..., k] + 1) / 2, 0, 0.999) * BINS[k]).astype(int) for k in (0, 1))
        return self.along_bins[y, x]


class HangingCloth:
    """The curtain alone, as it hangs without wind: its triangles, and what rays need to go through them."""

    def __init__(self, ctx: moderngl.Context, triangles: Triangles, sheet: Sheet):
        self.ctx, self.triangles, self.sheet = ctx, triangles, sheet
        self._structure: Structure | None = None
        self._buffers = [TextureBuffer(ctx, 64) for _ in range(4)] + [TextureBuffer(ctx, 64, "r32ui")]

    @property
    def structure(self) -> Structure:
        """Built once."""
        if self._structure is None:
            self._structure = make_structure(self.ctx, "kdtree")
            self._structure.build(self.triangles)
        return self._structure

    def folds(self, inputs: Mapping[str, Any], chosen: np.ndarray) -> Folds:
        """What it does in a fabric and a lamp.

        inputs : of inputs/tracing/local_light.glsl. chosen : [C] triangles, evenly spread, where the lamp's light is measured
        """
        positions = self.triangles.positions()
        # From further away hits would lose digits.
        reach = 4.0 * (float(np.abs(positions).max()) + min(float(np.abs(inputs["lamp"]).max()), NEAR))
        inputs = {
            **inputs, "corner_data": self.triangles.corners, "attribute_data": self.triangles.attributes, "beyond": reach,
            "offset": 8 * self.triangles.padding,
        }  # fmt: skip
        inner = self._inner()
        thick = float(np.abs(positions[..., 2] - self.sheet.z).max()) + 0.01
        passes, bins = self._straight(inputs, inner, thick)
        fates = self._fates(inputs, inner, thick)
        middle = positions[chosen].mean(1)
        inside = (middle[:, :2] > inner[:2]).all(1) & (middle[:, :2] < inner[2:]).all(1)
        E_lamp = self._lit(inputs, chosen[inside] if inside.any() else chosen)
        sides = fates.reshape(PATHS, 2, 5, 4)
        kind, light = sides[:, :, 0, 3], sides[:, :, 0, :3]
        evenly = sides[:, :, 1, 3] > 0.0
        reflected, transmitted = (np.where((kind == k)[..., None], light, 0).mean(0) for k in (2, 3))
        scattered = np.stack([np.where(((kind == k) & evenly)[..., None], light, 0).mean(0) for k in (2, 3)])
        lamp, seen = (np.pi * sides[:, :, k, :3].mean(0) / np.maximum(E_lamp, 1e-12) for k in (1, 2))
        lit = E_lamp > 1e-9
        return Folds(
            passes, bins, reflected, transmitted, np.where(lit, lamp, 0.0), scattered, np.where(lit, lamp - seen, 0.0),
            np.stack([_directed(sides[:, k]) for k in (0, 1)]), sides[:, :, 3:5, :3].mean(0),
        )  # fmt: skip

    def _inner(self) -> np.ndarray:
        """The part of the sheet that paths begin at: least x and y, largest."""
        low, high = np.array(self.sheet.piece).reshape(2, 2)
        margin = np.minimum(MARGIN, 0.2 * (high - low))
        return np.concatenate([low + margin, high - margin])

    def _straight(self, inputs: Mapping[str, Any], inner: np.ndarray, thick: float) -> tuple[np.ndarray, np.ndarray]:
        """`passes` and `along_bins`."""
        rng = np.random.default_rng(3)
        nx, ny = BINS
        j, i = np.meshgrid(np.arange(ny), np.arange(nx), indexing="ij")
        disc = (np.stack([i, j], -1)[:, :, None] + rng.random((ny, nx, RAYS, 2))) / [nx, ny] * 2 - 1
        square = (disc**2).sum(-1)
        z = np.sqrt(np.maximum(1 - square, STEEPEST**2))
        d = np.concatenate([disc, z[..., None]], -1).reshape(-1, 3)
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        at = np.concatenate(
            [inner[:2] + rng.random((len(d), 2)) * (inner[2:] - inner[:2]), np.full((len(d), 1), self.sheet.z)], 1
        )
        way = thick / d[:, 2:] * d
        left = self._through(inputs, at - way, np.ones_like(at), at + way).reshape(ny, nx, RAYS, 3)
        # Ways round the curtain's edges say nothing of its cloth.
        low, high = np.array(self.sheet.piece).reshape(2, 2)
        ends = np.stack([at - way, at + way])[..., :2]
        inside = ((ends > low) & (ends < high)).all((0, 2)).reshape(square.shape)
        mean = (left * inside[..., None]).sum(2, dtype=float) / np.maximum(inside.sum(2), 1)[..., None]
        within = (square <= 1) & inside
        return left[within].mean(0, dtype=float), mean

    def _through(
        self, inputs: Mapping[str, Any], points: np.ndarray, light: np.ndarray, ends: np.ndarray
    ) -> np.ndarray:
        """What of light [N, 3] between points and ends passes the cloth."""
        from_, to, before, after, _ = self._buffers
        for buffer, values in ((from_, points), (to, ends), (before, light)):
            buffer.write(np.concatenate([values, np.zeros((len(values), 1))], 1).astype(np.float32))
        after.reserve(16 * len(points))
        attenuate(self.ctx, self.structure, inputs, from_, before, after, len(points), to)
        return np.frombuffer(after.read(16 * len(points)), np.float32).reshape(-1, 4)[:, :3]

    def _lit(self, inputs: Mapping[str, Any], chosen: np.ndarray) -> np.ndarray:
        """Mean irradiance [3] of triangles by the lamp, past the other cloth."""
        points, _, before, after, numbers = self._buffers
        for buffer in (points, before, after):
            buffer.reserve(16 * len(chosen))
        numbers.write(chosen.astype(np.uint32))
        programs(self.ctx).compute("passes/curtain/lit_cloth.comp").run(
            len(chosen), inputs, chosen=numbers, Points=points, Lights=before, chosen_count=len(chosen), first=0
        )
        attenuate(self.ctx, self.structure, inputs, points, before, after, len(chosen))
        light = np.frombuffer(after.read(16 * len(chosen)), np.float32).reshape(-1, 4)
        return light[:, :3].mean(0, dtype=float)

    def _fates(self, inputs: Mapping[str, Any], inner: np.ndarray, thick: float) -> np.ndarray:
        """What became of the paths, [2 PATHS, 5, 4]."""
        out = Buffer(self.ctx, 160 * PATHS)
        program = programs(self.ctx).compute(
            "passes/curtain/folds.comp", fabric_defines(inputs), tracing(self.structure)
        )
        program.run(
            2 * PATHS, self.structure.inputs(), inputs, Paths=out, path_count=2 * PATHS, sheet=tuple(inner),
            sheet_z=self.sheet.z, thick=thick,
        )  # fmt: skip
        paths = np.frombuffer(out.read(160 * PATHS), np.float32).astype(float).reshape(-1, 5, 4)
        out.release()
        return paths

    def release(self) -> None:
        """Free the GPU's memory, the triangles' too."""
        for thing in (*self._buffers, self.triangles, *([self._structure] if self._structure else [])):
            thing.release()


def basis(direction: np.ndarray) -> np.ndarray:
    """Functions [..., 4] of directions [..., 3] from the sheet: folds hang along y."""
    x, _, z = np.moveaxis(direction, -1, 0)
    return np.stack([np.ones_like(z), np.abs(z), z * z, x * x], -1)


def _directed(paths: np.ndarray) -> np.ndarray:
    """The weights [4] of `basis` that fit best what paths [N, 5, 4] of a side bring, over their mean."""
    light = luminance(paths[:, 1, :3])
    if not light.mean() > 0.0:  # no lamp: as of even light
        light = luminance(paths[:, 0, :3]) * (paths[:, 0, 3] > 1.0)
    if not light.mean() > 0.0:
        return np.array([1.0, 0.0, 0.0, 0.0])
    return np.linalg.lstsq(basis(paths[:, 2:5, 3]), light / light.mean(), rcond=None)[0]


def attenuate(
    ctx: moderngl.Context,
    structure: Structure,
    inputs: Mapping[str, Any],
    points: TextureBuffer,
    before: TextureBuffer,
    after: TextureBuffer,
    count: int,
    ends: TextureBuffer | None = None,
) -> None:
    """Write to `after` what of the light `before` arrives at points from the lamp, or from `ends`, past cloth and all else."""
    program = programs(ctx).compute("passes/curtain/through.comp", fabric_defines(inputs), tracing(structure))
    for k, chunk in enumerate(structure.chunks()):
        program.run(
            count, structure.inputs(), inputs, chunk, points=points, ends=ends or points, arriving=before, Lights=after,
            point_count=count, to_lamp=ends is None, first_chunk=k == 0,
        )  # fmt: skip
