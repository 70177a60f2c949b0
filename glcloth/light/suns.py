"""Tell small bright lights from the rest of a map and hand them over as directional suns; no light is lost."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..color import luminance
from . import equirect
from .lights import SUN_RADIUS, Suns

RADIUS = np.radians(2.5)  # of the disc whose light may become a sun; the ring around it reaches twice as far
SHARE = 0.02  # of the map's light: a weaker sun is not worth a light of its own
CONTRAST = 4.0  # the disc must hold so many times the light that rises above the background in the ring
LIMIT = 6
_TRIES = 48
_STEPS = 16  # of the disc toward the middle of its light


class _Place(NamedTuple):
    """The map about a direction: an index of its texels, which of them [h, w] are in the disc and which in the ring about it,
    and the light above the background there."""

    index: tuple
    disc: np.ndarray
    ring: np.ndarray
    values: np.ndarray  # [h, w, 3]
    background: np.ndarray  # [3]
    omega: np.ndarray  # [h, w, 3]
    omega_i: np.ndarray  # [h, w] solid angles
    excess: np.ndarray  # [h, w, 3]

    @property
    def light(self) -> np.ndarray:
        """Of each texel of the disc, above the background, [n, 3]."""
        return self.excess[self.disc] * self.omega_i[self.disc, None]

    @property
    def middle(self) -> np.ndarray:
        """The mean direction of that light, not unit."""
        return (self.omega[self.disc] * luminance(self.light)[:, None]).sum(axis=0)

    @property
    def radius(self) -> float:
        """Of a disc as even as this light: of its area (sum L)^2 / sum L^2, to which a faint glow adds little, less a texel."""
        L, omega_i = luminance(self.excess[self.disc]), self.omega_i[self.disc]
        area = (L * omega_i).sum() ** 2 / max((L * L * omega_i).sum(), 1e-300) - omega_i.mean()
        return float(np.clip(np.sqrt(max(area, 0.0) / np.pi), SUN_RADIUS, RADIUS))


def split_suns(radiance: np.ndarray, limit: int = LIMIT) -> tuple[Suns, np.ndarray]:
    """Return (suns, rest): at most `limit` directional lights and the map [H, W, 3] without them.

    Around the brightest texel the light above the background (the ring's median) becomes a sun, with the mean
    direction of that light and its extent, when it is at least SHARE of the map and stands out from the ring; the disc
    keeps min(radiance, background). So total(rest) + sum(irradiance) = total(radiance). A lamp as bright everywhere has
    its brightest texel anywhere, so the disc moves to the middle of its light first. A map whose texels are coarser than
    the disc has no suns; a Gaussian can follow such a texel.
    """
    height, width = radiance.shape[:2]
    if limit < 1 or np.pi / height > RADIUS:
        return Suns(), radiance
    Y = luminance(radiance)
    weight = equirect.row_solid_angles(height, width)
    whole = float(weight @ Y.sum(axis=1, dtype=np.float64))
    disc_angle = 2 * np.pi * (1 - np.cos(RADIUS))
    rest, directions, irradiances, radii = radiance, [], [], []
    # Rows remember their brightest texel, so that only rows that change are looked at again.
    brightest = Y.max(axis=1)
    for _ in range(_TRIES):
        row = int(np.argmax(brightest))
        column = int(np.argmax(Y[row]))
        # Even a disc as bright as this texel would be too weak, so no other can be enough.
        if len(directions) >= limit or Y[row, column] * disc_angle < SHARE * whole:
            break
        start = _place(rest, equirect.direction_from_uv((column + 0.5) / width, (row + 0.5) / height), weight)
        place = _in_the_middle(rest, start, (row, column), weight)
        around = float((luminance(place.excess[place.ring]) * place.omega_i[place.ring]).sum())
        strength = float(luminance(place.light.sum(axis=0)))
        if strength >= SHARE * whole and strength >= CONTRAST * around:
            directions.append(place.middle)
            irradiances.append(place.light.sum(axis=0))
            radii.append(place.radius)
            if rest is radiance:
                rest = np.array(radiance)
            values = place.values
            values[place.disc] = np.minimum(values[place.disc], place.background)
            rest[place.index] = values
        # Done with this place either way; a rejected one is a broad light, whose neighbours would be rejected too.
        for one in (start, place):
            seen = Y[one.index]
            seen[one.disc | one.ring] = 0.0
            Y[one.index] = seen
            rows = one.index[0][:, 0]
            brightest[rows] = Y[rows[0] : rows[-1] + 1].max(axis=1)
    return Suns(np.reshape(directions, (-1, 3)), np.reshape(irradiances, (-1, 3)), np.array(radii)), rest


def _in_the_middle(radiance: np.ndarray, start: _Place, texel: tuple[int, int], weight: np.ndarray) -> _Place:
    """The place whose disc has its light's middle in its own, from one that is about a texel; the start where that leads
    farther than a lamp as wide as the disc is: such a light is broad."""
    height, width = radiance.shape[:2]
    uv = (texel[1] + 0.5) / width, (texel[0] + 0.5) / height
    first = centre = equirect.direction_from_uv(*uv)
    place = start
    for _ in range(_STEPS):
        length = np.linalg.norm(place.middle)
        if length <= 0.0:
            return start
        middle = place.middle / length
        # A small lamp is in the disc wherever it is there, a wide one wants to be in it to its rim.
        if middle @ centre >= np.cos((1.0 if place.radius < 0.5 * RADIUS else 0.05) * np.pi / height):
            return place
        if middle @ first < np.cos(RADIUS + np.pi / height):
            return start
        centre, place = middle, _place(radiance, middle, weight)
    return place


def _place(radiance: np.ndarray, centre: np.ndarray, weight: np.ndarray) -> _Place:
    """The map about a direction."""
    index, omega = _neighbourhood(centre, *radiance.shape[:2])
    cos = omega @ centre
    disc, ring = cos > np.cos(RADIUS), (cos <= np.cos(RADIUS)) & (cos > np.cos(2 * RADIUS))
    values = radiance[index].astype(np.float64)
    background = np.median(values[ring], axis=0) if ring.any() else np.zeros(3)
    omega_i = np.broadcast_to(weight[index[0]], cos.shape)
    return _Place(index, disc, ring, values, background, omega, omega_i, np.maximum(values - background, 0.0))


def _neighbourhood(centre: np.ndarray, height: int, width: int):
    """An index of the map's texels within two radii of a direction, and their directions [h, w, 3]."""
    u, v = equirect.uv_from_direction(centre)
    row, column = min(int(v * height), height - 1), int(u * width) % width
    reach = int(np.ceil(2 * RADIUS / np.pi * height)) + 1
    rows = np.arange(max(row - reach, 0), min(row + reach + 1, height))
    # The widest row decides how far in longitude the cap extends; over a pole it is the whole circle.
    sin = np.sin(np.pi * (row + 0.5) / height)
    half = np.arcsin(min(np.sin(2 * RADIUS) / max(sin, 1e-9), 1.0)) if sin > np.sin(2 * RADIUS) else np.pi
    wide = min(int(np.ceil(half / (2 * np.pi) * width)) + 1, (width - 1) // 2)
    columns = np.arange(column - wide, column + wide + 1) if half < np.pi else np.arange(width)
    omega = equirect.direction_from_uv(((columns + 0.5) / width)[None, :], ((rows + 0.5) / height)[:, None])
    return np.ix_(rows, columns % width), omega
