"""Tell small bright lights from the rest of a map and hand them over as directional suns; no light is lost."""

from __future__ import annotations

import numpy as np

from ..color import luminance
from . import equirect
from .lights import Suns

RADIUS = np.radians(2.5)  # of the disc whose light may become a sun; the ring around it reaches twice as far
SHARE = 0.02  # of the map's light: a weaker sun is not worth a light of its own
CONTRAST = 4.0  # the disc must hold so many times the light that rises above the background in the ring
LIMIT = 6
_TRIES = 48


def split_suns(radiance: np.ndarray, limit: int = LIMIT) -> tuple[Suns, np.ndarray]:
    """Return (suns, rest): at most `limit` directional lights and the map [H, W, 3] without them.

    Around the brightest texel the light above the background (the ring's median) becomes a sun, with the mean
    direction of that light, when it is at least SHARE of the map and stands out from the ring; the disc keeps
    min(radiance, background). So total(rest) + sum(irradiance) = total(radiance). A map whose texels are coarser than
    the disc has no suns; a Gaussian can follow such a texel.
    """
    height, width = radiance.shape[:2]
    if limit < 1 or np.pi / height > RADIUS:
        return Suns(), radiance
    Y = luminance(radiance)
    weight = equirect.row_solid_angles(height, width)
    whole = float(weight @ Y.sum(axis=1, dtype=np.float64))
    disc_angle = 2 * np.pi * (1 - np.cos(RADIUS))
    rest, directions, irradiances = radiance, [], []
    # Rows remember their brightest texel, so that only rows that change are looked at again.
    brightest = Y.max(axis=1)
    for _ in range(_TRIES):
        row = int(np.argmax(brightest))
        column = int(np.argmax(Y[row]))
        # Even a disc as bright as this texel would be too weak, so no other can be enough.
        if len(directions) >= limit or Y[row, column] * disc_angle < SHARE * whole:
            break
        index, omega, centre = _neighbourhood(row, column, height, width)
        cos = omega @ centre
        disc, ring = cos > np.cos(RADIUS), (cos <= np.cos(RADIUS)) & (cos > np.cos(2 * RADIUS))
        values = rest[index].astype(np.float64)
        omega_i = np.broadcast_to(weight[index[0]], cos.shape)
        background = np.median(values[ring], axis=0) if ring.any() else np.zeros(3)
        excess = np.maximum(values - background, 0.0)
        light = excess[disc] * omega_i[disc, None]
        around = float((luminance(excess[ring]) * omega_i[ring]).sum())
        strength = float(luminance(light.sum(axis=0)))
        if strength >= SHARE * whole and strength >= CONTRAST * around:
            directions.append((omega[disc] * luminance(light)[:, None]).sum(axis=0))
            irradiances.append(light.sum(axis=0))
            if rest is radiance:
                rest = np.array(radiance)
            values[disc] = np.minimum(values[disc], background)
            rest[index] = values
        # Done with this place either way; a rejected one is a broad light, whose neighbours would be rejected too.
        seen = Y[index]
        seen[disc | ring] = 0.0
        Y[index] = seen
        rows = index[0][:, 0]
        brightest[rows] = Y[rows[0] : rows[-1] + 1].max(axis=1)
    return Suns(np.reshape(directions, (-1, 3)), np.reshape(irradiances, (-1, 3))), rest


def _neighbourhood(row: int, column: int, height: int, width: int):
    """An index of the map's texels within two radii of a texel, their directions [h, w, 3], and the texel's own."""
    centre = equirect.direction_from_uv((column + 0.5) / width, (row + 0.5) / height)
    reach = int(np.ceil(2 * RADIUS / np.pi * height)) + 1
    rows = np.arange(max(row - reach, 0), min(row + reach + 1, height))
    # The widest row decides how far in longitude the cap extends; over a pole it is the whole circle.
    sin = np.sin(np.pi * (row + 0.5) / height)
    half = np.arcsin(min(np.sin(2 * RADIUS) / max(sin, 1e-9), 1.0)) if sin > np.sin(2 * RADIUS) else np.pi
    wide = min(int(np.ceil(half / (2 * np.pi) * width)) + 1, (width - 1) // 2)
    columns = np.arange(column - wide, column + wide + 1) if half < np.pi else np.arange(width)
    omega = equirect.direction_from_uv(((columns + 0.5) / width)[None, :], ((rows + 0.5) / height)[:, None])
    return np.ix_(rows, columns % width), omega, centre
