"""What the tables of a fabric's tangents depend on, so that equal ones and mirror images share one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...fabric import Fabric


@dataclass(frozen=True)
class Shape:
    """What T of one tangent depends on: its tilt, and every term of W's normaliser.

    Tilts in radians. `own` are the tangents of its own yarn, `other` those of the other one, whose direction is the
    tangent's b; both as (tilt, share in the normaliser).
    """

    tilt: float
    own: tuple[tuple[float, float], ...]
    other: tuple[tuple[float, float], ...]
    gap: float
    sigma: float

    def mirrored(self, theta: int, phi: int) -> Shape:
        """The shape whose T at (theta, phi) is this one's at (-theta, phi) or (theta, -phi) where the sign is -1."""
        own = tuple(sorted((theta * tilt + 0.0, share) for tilt, share in self.own))
        other = tuple(sorted((phi * tilt + 0.0, share) for tilt, share in self.other))
        return Shape(theta * self.tilt + 0.0, own, other, self.gap, self.sigma)

    @property
    def order(self) -> tuple:
        return self.tilt, self.own, self.other


@dataclass(frozen=True)
class Placement:
    """Where the table of a tangent is: the index of its shape, and the signs to give theta and phi before reading."""

    shape: int
    theta: int
    phi: int


def _rounded(tilt: float) -> float:
    """A tilt to nine digits, never beyond a right angle: its cosine would be negative and turn the horizon over."""
    return float(np.clip(round(tilt, 9), -np.pi / 2, np.pi / 2))


def shapes_of(fabric: Fabric) -> tuple[tuple[Shape, ...], tuple[Placement, ...]]:
    """The different shapes among a fabric's tangents, and the placement of each tangent: mirror images share a table."""
    # Rounded, so that mirror images are recognised; 1e-9 is far below the tables' error.
    terms = [
        (t.yarn, _rounded(t.tilt), round(float(w[1]), 9)) for t, w in zip(fabric.tangents, fabric.weights, strict=True)
    ]
    shapes: list[Shape] = []
    placements = []
    for yarn, tilt, _ in terms:
        own = tuple(sorted((angle, share) for j, angle, share in terms if j == yarn))
        # Yarn 2 runs along b of yarn 1, but yarn 1 runs against b of yarn 2 (b = n x t).
        side = 1 if yarn == 0 else -1
        other = tuple(sorted((side * angle + 0.0, share) for j, angle, share in terms if j != yarn))
        shape = Shape(tilt, own, other, round(fabric.gap, 9), round(fabric.sigma, 9))
        images = [(shape.mirrored(theta, phi), theta, phi) for theta in (1, -1) for phi in (1, -1)]
        chosen, theta, phi = max(images, key=lambda image: (image[0].order, image[1], image[2]))
        if chosen not in shapes:
            shapes.append(chosen)
        placements.append(Placement(shapes.index(chosen), theta, phi))
    return tuple(shapes), tuple(placements)
