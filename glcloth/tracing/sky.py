"""The light from far away for the path tracer: a map without its suns or the fitted Gaussians, and how both are drawn."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import moderngl
import numpy as np

from ..color import luminance
from ..gpu.buffers import TextureBuffer
from ..gpu.environment_map import EnvironmentMap
from ..gpu.memo import Last
from ..gpu.scene_buffers import light_records
from ..light import equirect
from ..light.environment import Environment
from ..light.lights import Lights, Suns
from ..light.suns import split_suns
from ..twins.lambert import gaussian_irradiance

CELLS = 512, 256  # across and down; a draw chooses among them by 24 bits, which they divide evenly
EVEN = 0.02  # of the draws are even, for light that the cells do not show


class Sky:
    """What the path tracer reads of "sky.glsl", and the suns."""

    def __init__(self, ctx: moderngl.Context):
        self._map = EnvironmentMap(ctx)
        self._cells = TextureBuffer(ctx, 16)
        self._lights, self._shares, self._suns = TextureBuffer(ctx, 16), TextureBuffer(ctx, 16), TextureBuffer(ctx, 16)
        self._portals = TextureBuffer(ctx, 16)
        self._split: Last[tuple[Suns, Environment]] = Last()
        self._taken: Last[dict[str, Any]] = Last()
        self._sun: Last[None] = Last()
        self.suns = Suns()
        self.source = ""
        self._up: Callable[[], np.ndarray] = lambda: np.zeros(3)  # irradiance from above, but for the suns

    def take_map(self, environment: Environment, rotation: np.ndarray, suns: bool = True) -> None:
        """The light of a map turned by a rotation [3, 3], with its suns, which are even discs, or without."""
        self.source = "inputs/tracing/path_sky_map.glsl"
        split, rest = self._split.get(lambda: _split(environment), environment)
        self._take_suns(split.rotated(rotation) if suns else Suns())
        inputs = self._taken.get(lambda: self._put_map(rest), rest)
        self._inputs = inputs | {"environment_from_world": np.asarray(rotation).T}
        up = np.asarray(rotation).T @ [0.0, 1.0, 0.0]
        self._up = lambda: _irradiance(rest.radiance, up)

    def take_portal(self, environment: Environment, rotation: np.ndarray, portals: np.ndarray) -> None:
        """The light of a map without its suns as it shines in through rectangles, [W, 3, 3]: a corner and two sides, m."""
        self.source = "inputs/tracing/path_sky_portal.glsl"
        _, rest = self._split.get(lambda: _split(environment), environment)
        self._take_suns(Suns())
        self._portals.write(portal_records(portals))
        self._inputs = {
            "sky_map": self._map.texture(rest),
            "portal_data": self._portals,
            "portal_count": len(portals),
            "environment_from_world": np.asarray(rotation).T,
        }

    def take_lights(self, lights: Lights) -> None:
        """The light of Gaussians and suns, in world space."""
        self.source = "inputs/tracing/path_sky_sg.glsl"
        self._take_suns(lights.suns)
        self._inputs = self._taken.get(lambda: self._put_lights(lights), lights)
        g = lights.gaussians
        self._up = lambda: (gaussian_irradiance(g.sharpness, g.axis[:, 1])[:, None] * g.amplitude).sum(0)

    def _put_map(self, rest: Environment) -> dict[str, Any]:
        self._cells.write(alias_cells(rest.radiance))
        return {"sky_map": self._map.texture(rest), "sky_cells": self._cells, "sky_size": CELLS}

    def _put_lights(self, lights: Lights) -> dict[str, Any]:
        g = lights.gaussians
        sharpness = np.maximum(g.sharpness, 1e-6)
        flux = np.abs(luminance(g.amplitude)) * 2 * np.pi * -np.expm1(-2 * sharpness) / sharpness
        rows = np.zeros((max(len(g), 1), 4), "f4")
        if len(g):
            share = (flux + 1e-3 * flux.sum() / len(g) + 1e-30) / (flux.sum() * 1.001 + 1e-30 * len(g))
            rows[:, 0], rows[:, 1] = share, np.cumsum(share)
        self._lights.write(light_records(lights))
        self._shares.write(rows)
        return {"light_data": self._lights, "gaussian_count": len(g), "share_data": self._shares}

    def _take_suns(self, suns: Suns) -> None:
        self.suns = suns
        key = (np.asarray(array).tobytes() for array in (suns.direction, suns.irradiance, suns.radius))
        self._sun.get(lambda: self._suns.write(sun_records(suns)), *key)

    def open_irradiance(self) -> np.ndarray:
        """Irradiance [3] of a level ground that sees all of what was taken."""
        rest = self._up()
        return rest + (np.maximum(self.suns.direction[:, 1:2], 0.0) * self.suns.irradiance).sum(0)

    def inputs(self) -> dict[str, Any]:
        """By their names in GLSL."""
        return self._inputs | {"sun_data": self._suns, "drawn_suns": len(self.suns)}

    def release(self) -> None:
        """Free the GPU's memory."""
        for one in (self._map, self._cells, self._lights, self._shares, self._suns, self._portals):
            one.release()


def _irradiance(radiance: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Of a surface that faces `up` [3], by a map [H, W, 3]: [3]."""
    height, width = radiance.shape[:2]
    cosine = np.maximum(equirect.texel_directions(height, width) @ up, 0.0)
    return np.einsum("h,hw,hwc->c", equirect.row_solid_angles(height, width), cosine, radiance.astype(float))


def _split(environment: Environment) -> tuple[Suns, Environment]:
    suns, rest = split_suns(environment.radiance)
    return suns, environment if rest is environment.radiance else Environment("without suns", rest)


def sun_records(suns: Suns) -> np.ndarray:
    """[S, 2, 4] float32: directions with the sum of shares, and irradiance over the share, by which one is drawn, with the
    tangent of the radius."""
    rows = np.zeros((max(len(suns), 1), 2, 4), "f4")
    if len(suns):
        bright = np.abs(luminance(suns.irradiance)) + 1e-30
        share = bright / bright.sum()
        rows[:, 0, :3], rows[:, 0, 3], rows[:, 1, :3] = (
            suns.direction,
            np.cumsum(share),
            suns.irradiance / share[:, None],
        )
        rows[:, 1, 3] = np.tan(suns.radius)
    return rows


def portal_records(portals: np.ndarray) -> np.ndarray:
    """[W, 3, 4] float32: a corner with the sum of shares, a side with the share, by which one is drawn, the other side."""
    portals = np.asarray(portals, float)
    area = np.linalg.norm(np.cross(portals[:, 1], portals[:, 2]), axis=1)
    rows = np.zeros((len(portals), 3, 4), "f4")
    rows[..., :3] = portals
    rows[:, 1, 3] = area / area.sum()
    rows[:, 0, 3] = np.cumsum(area / area.sum())
    return rows


def alias_cells(radiance: np.ndarray) -> np.ndarray:
    """Cells of a map [H, W, 3] by which light is drawn: [C, 4] float32, for each cell, row by row of CELLS: the chance that it
    keeps a draw, the cell that gets it else, and the density of draws within it, per solid angle.   [Walker 1977]
    """
    width, height = CELLS
    Y = luminance(radiance).astype(float)
    # What is read between texels reaches over their edges.
    Y = np.maximum(Y, 0.5 * (np.roll(Y, 1, 1) + np.roll(Y, -1, 1)))
    Y[1:-1] = np.maximum(Y[1:-1], 0.5 * (Y[:-2] + Y[2:]))
    solid = np.repeat(equirect.row_solid_angles(height, width), width)
    bright = equirect.resize(Y[..., None].astype(np.float32), height, width).astype(float).reshape(-1)
    flux = np.maximum(bright, 0.0) * solid
    share = (1 - EVEN) * flux / max(flux.sum(), 1e-30) + EVEN * solid / solid.sum()
    share /= share.sum()
    rows = np.zeros((len(share), 4), "f4")
    rows[:, 0], rows[:, 1] = alias_table(share)
    rows[:, 2] = share / solid
    return rows


def alias_table(share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Chances [N] to keep a draw and who gets it else [N], so that an even choice becomes one by shares [N].

    Vose 1991, "A linear algorithm for generating random numbers with a given distribution".
    """
    count = len(share)
    level = (np.asarray(share, float) * count).tolist()
    other = list(range(count))
    small = [i for i, x in enumerate(level) if x < 1.0]
    large = [i for i, x in enumerate(level) if x >= 1.0]
    keep = [1.0] * count
    while small and large:
        a, b = small.pop(), large[-1]
        keep[a], other[a] = level[a], b
        level[b] -= 1.0 - level[a]
        if level[b] < 1.0:
            small.append(large.pop())
    return np.array(keep), np.array(other)
