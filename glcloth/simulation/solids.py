"""Solids that keep cloth out: planes, balls, boxes and ellipsoids, and the GLSL that resolves a point against them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import InputError


@dataclass(frozen=True)
class Plane:
    """The half space dot(normal, p) <= offset is solid; `normal` is made unit, and the offset with it."""

    normal: tuple[float, float, float]
    offset: float = 0.0


@dataclass(frozen=True)
class Sphere:
    """A solid ball; metres."""

    center: tuple[float, float, float]
    radius: float


@dataclass(frozen=True)
class Box:
    """A solid box with outer half sides `half_size`, its edges rounded with `rounding`; metres."""

    center: tuple[float, float, float]
    half_size: tuple[float, float, float]
    rounding: float = 0.0


@dataclass(frozen=True)
class Ellipsoid:
    """A solid ellipsoid with half axes `axes` along x, y, z; metres."""

    center: tuple[float, float, float]
    axes: tuple[float, float, float]


Solid = Plane | Sphere | Box | Ellipsoid


def solids_glsl(solids: Sequence[Solid], backdrop: bool = False) -> str:
    """Return the GLSL that resolves a point against each solid in turn; their numbers become constants.

    backdrop : against a cloth behind it, too (glcloth/simulation/backdrop.py). Raises InputError for shapes that make no sense.
    """
    calls = (
        ["d_plane(point, vec3(0.0, 0.0, 1.0), min(backdrop_height(point), backdrop_reach(item())))"] if backdrop else []
    )
    for solid in solids:
        if isinstance(solid, Plane):
            length = math.hypot(*solid.normal)
            if not length > 0:
                raise InputError(f"plane: normal {solid.normal} has no direction; give another")
            normal = [c / length for c in solid.normal]
            calls.append(f"d_plane(point, {_glsl(normal)}, {_glsl(solid.offset / length)})")
        elif isinstance(solid, Sphere):
            if not solid.radius > 0:
                raise InputError(f"sphere: radius {solid.radius} must be > 0; change it")
            calls.append(f"d_sphere(point, {_glsl(solid.center)}, {_glsl(solid.radius)})")
        elif isinstance(solid, Ellipsoid):
            if not min(solid.axes) > 0:
                raise InputError(f"ellipsoid: half axes {solid.axes} must be > 0; change them")
            calls.append(f"d_ellipsoid(point, {_glsl(solid.center)}, {_glsl(solid.axes)})")
        else:
            if not 0 <= solid.rounding <= min(solid.half_size):
                raise InputError(
                    f"box: rounding {solid.rounding} must lie between 0 and the least half side; change it"
                )
            calls.append(f"d_box(point, {_glsl(solid.center)}, {_glsl(solid.half_size)}, {_glsl(solid.rounding)})")
    lines = [f"    point = resolve(point, before, {call});" for call in calls]
    include = ['#include "inputs/simulation/backdrop.glsl"'] if backdrop else []
    return "\n".join([*include, "vec3 resolve_solids(vec3 point, vec3 before) {", *lines, "    return point;", "}", ""])


def _glsl(value: float | Sequence[float]) -> str:
    """Return a GLSL constant for a number, or for three of them."""
    if isinstance(value, (int, float)):
        return f"{value:.9e}"
    return "vec3(" + ", ".join(_glsl(float(c)) for c in value) + ")"
