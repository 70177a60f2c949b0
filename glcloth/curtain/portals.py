"""Where light comes from into a room: the lamp, and the sky, through the openings in the box that bounds the room. Photons
begin there, as many as there is power.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..color import luminance
from ..tracing.sky import alias_table
from ..twins.random import cosine_direction

CELLS = (32, 64)  # of directions through an opening, from its normal down and around: each has the same share of even light
EVEN = 0.05  # of the photons of the sky go everywhere alike
LEAST_SHARE = 0.1  # of the photons, of lamp and sky, where either has any power


@dataclass(frozen=True)
class Emission:
    """What passes/curtain/photon_trace.comp reads of light.

    portals : [C, 3, 4] float32, cells of openings; sky_draws : [F, K, 2, 4] float32 for F faces of the box
    lamp_inside : whether the lamp stands in the box. lamp, sky : [3], the power that comes in, W
    """

    portals: np.ndarray
    sky_draws: np.ndarray
    lamp_inside: bool
    lamp: np.ndarray
    sky: np.ndarray

    def counts(self, photons: int) -> tuple[int, int]:
        """How many of the photons the lamp and the sky get."""
        lamp, sky = (float(luminance(power)) for power in (self.lamp, self.sky))
        if lamp <= 0 or sky <= 0:
            return (photons, 0) if lamp > 0 else (0, photons) if sky > 0 else (0, 0)
        of_lamp = round(photons * float(np.clip(lamp / (lamp + sky), LEAST_SHARE, 1 - LEAST_SHARE)))
        return of_lamp, photons - of_lamp


def emission(
    openings: np.ndarray,
    box: tuple[np.ndarray, np.ndarray],
    lamp: np.ndarray,
    intensity: np.ndarray,
    radiance: Callable[[np.ndarray], np.ndarray],
) -> Emission:
    """The light that comes into a room.

    openings : [C, 4, 3] corners of parallelograms, counter-clockwise seen from the room. box : low and high corner [3] of
    the room. lamp, intensity : [3], m and W/sr. radiance : of the sky along directions [..., 3] away from the room
    """
    C = len(openings)
    inside = bool(((lamp > box[0]) & (lamp < box[1])).all())
    corner, u, v = openings[:, 0], openings[:, 1] - openings[:, 0], openings[:, 3] - openings[:, 0]
    across = np.cross(u, v)
    area = np.linalg.norm(across, axis=1)
    normals = across / np.maximum(area, 1e-30)[:, None]
    faces, face = np.unique(np.round(normals, 6), axis=0, return_inverse=True)
    draws, even = _sky_draws(faces, face.reshape(-1), u, radiance)
    solid = _solid_angles(corner, u, v, across, lamp)
    portals = np.zeros((max(C, 1), 3, 4))
    portals[:C, 0, :3], portals[:C, 1, :3], portals[:C, 2, :3] = corner, u, v
    portals[:C, 2, 3] = face.reshape(-1)
    sky = even[face.reshape(-1)] * area[:, None] if C else np.zeros((0, 3))
    portals[:C, 0, 3], portals[:C, 1, 3] = _shares(solid), _shares(luminance(sky))
    through = 4 * np.pi if inside else float(solid.sum())
    return Emission(portals.astype(np.float32), draws.astype(np.float32), inside, intensity * through, sky.sum(0))


def _shares(power: np.ndarray) -> np.ndarray:
    """Cumulated shares of powers [C]."""
    whole = power.sum()
    sums = np.cumsum(power) / whole if whole > 0 else np.arange(1, len(power) + 1) / max(len(power), 1)
    # Behind the last that has any nothing must be drawn.
    return np.where(np.arange(len(power)) >= np.flatnonzero(power > 0).max(initial=-1), 1.0, sums)


def _solid_angles(corner: np.ndarray, u: np.ndarray, v: np.ndarray, across: np.ndarray, lamp: np.ndarray) -> np.ndarray:
    """About the solid angles [C] that openings take up from the lamp; 0 where it stands on their other side."""
    out = np.zeros(len(corner))
    for s in (np.arange(4) + 0.5) / 4:
        for t in (np.arange(4) + 0.5) / 4:
            way = corner + s * u + t * v - lamp
            r2 = np.maximum((way * way).sum(1), 1e-12)
            out += np.maximum((across * way).sum(1), 0) / r2**1.5 / 16
    return out


def _sky_draws(faces: np.ndarray, face: np.ndarray, u: np.ndarray, radiance) -> tuple[np.ndarray, np.ndarray]:
    """[F, K, 2, 4]: by which cell of directions the sky's photons are drawn, and their irradiance; and that of all, [F, 3]."""
    up, around = CELLS
    K = up * around
    draws, even = np.zeros((max(len(faces), 1), K, 2, 4)), np.zeros((max(len(faces), 1), 3))
    i, j = (a.ravel() for a in np.meshgrid(np.arange(up), np.arange(around), indexing="ij"))
    for f, n in enumerate(faces):
        x = u[np.flatnonzero(face == f)[0]]
        x = x / np.linalg.norm(x)
        frame = np.stack([x, np.cross(n, x), n])
        L = np.zeros((K, 3))
        for s, t in ((0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)):
            L += radiance(-cosine_direction(np.stack([(i + s) / up, (j + t) / around], 1)) @ frame) / 4
        Y = np.maximum(luminance(L), 0)
        share = (1 - EVEN) * Y / max(Y.sum(), 1e-30) + EVEN / K
        share /= share.sum()
        draws[f, :, 0, 0], draws[f, :, 0, 1] = alias_table(share)
        draws[f, :, 1, :3] = np.pi * L / K / share[:, None]
        even[f] = np.pi * L.mean(0)
    return draws, even
