"""How a curtain is sewn and hung, what its cloth is like, and the wind."""

from __future__ import annotations

import math
from typing import Any, Literal

from pydantic import ConfigDict, field_validator, model_validator

from ..color import srgb_decode
from ..errors import InputError, short
from ..fabric import Fabric
from ..fields import Value, about
from .kinds import Share, option

# Of each heading: length of rail that a fold takes (m), cells across it, irregularity.
FOLDS = {
    "tape": (2.5 / 13, 158 / 13, 0.2), "rings": (2.5 / 13, 158 / 13, 0.2), "pencil": (0.1, 10.0, 0.4),
    "eyelet": (0.16, 12.0, 0.03), "rod": (0.09, 10.0, 0.2),
}  # fmt: skip
NARROWEST = 0.2  # m, half of a pair
ABOVE_ROD = 0.07  # m, that cloth on a rod stands above the rail's height, which is just under the rod


def color_of(text: str) -> tuple[float, ...]:
    """Linear Rec. 709 of R,G,B (linear), of #rrggbb or of a colour's name (sRGB). Raises ValueError."""
    from PIL import ImageColor

    parts = text.split(",")
    try:
        if len(parts) == 3:
            return tuple(float(part) for part in parts)
        return tuple(float(srgb_decode(code / 255.0)) for code in ImageColor.getrgb(text)[:3])
    except ValueError:
        raise ValueError(f"expected R,G,B from 0 to 1, #rrggbb or a colour's name, not {short(text)}") from None


def _sewn(width: float, drop: float, fullness: float, heading: str, pleats: int | None = None) -> dict[str, Any]:
    """What follows for a curtain: pleats, if they are not said, cells of the grid, irregularity."""
    fold, across, irregularity = FOLDS[heading]
    pleats = pleats or max(1, round(width / fold))
    quads = max(6 * pleats, round(across * max(1.0, fullness / 2.6) * pleats)), max(6, round(40 * drop / 2.3))
    return {"pleats": pleats, "quads": quads, "irregularity": irregularity}


class CurtainParameters(Value):
    """A curtain on a rail along x, the window in the plane z = 0 behind it, the floor at y = 0; SI units."""

    model_config = ConfigDict(title="curtain")

    # fmt: off
    width: float = option("m", "length of the rail", default=2.5, gt=0)
    top: float = about("m", "height of the rail", default=2.41)
    clearance: float = about("m", "from the window to the backs of the folds", default=0.06, gt=0, slider=(0.02, 0.5))
    drop: float = option("m", "length of the cloth", default=2.3, gt=0, slider=(0.5, 2.4))
    fullness: float = option("", "width of the cloth over that of the rail", default=1.8, ge=1, le=4, slider=(1.0, 3.0))
    pleats: int = about(
        "", "folds along the rail, at least six quads each; where it is not said, as width and heading ask for", default=13,
        ge=1, slider=(3, 24))
    irregularity: float = about("", "how unequal the folds are", default=0.2, ge=0, le=1)
    quads: tuple[int, int] = about(
        "", "cells of the grid along the rail and down the cloth; where it is not said, as the pleats and the drop ask for",
        default=(158, 40))
    heading: Literal["tape", "rings", "pencil", "eyelet", "rod"] = option(
        "", "tape holds the whole upper edge in deep folds, pencil in narrow ones; rings hold the front of each fold; with "
        "eyelet even folds, with rod narrow gathers stand about the rod, and a little above it", default="tape")
    color: tuple[Share, Share, Share] | None = option(
        "linear Rec. 709", "colour of the cloth instead of its fabric's own, which colours what shines through as well: R,G,B, "
        "#rrggbb, or a name such as crimson; none: the fabric's", default=None)
    open: float = option(
        "m", "the curtain is a pair, drawn so far apart in the middle; 0: one piece", default=0.0, ge=0, slider=(0.0, 2.0))
    behind: str | Fabric = option(
        "", "fabric of a second curtain between this one and the window, such as blackout behind a sheer; none: there is "
        "none", default="", file=True)
    behind_open: float = option(
        "m", "the second curtain is a pair, drawn so far apart in the middle; 0: one piece", default=0.0, ge=0,
        slider=(0.0, 2.0))
    behind_color: tuple[Share, Share, Share] | None = about(
        "linear Rec. 709", "of the second curtain, as color", default=None)
    behind_fullness: float = about("", "of the second curtain, as fullness", default=1.8, ge=1, le=4, slider=(1.0, 3.0))
    behind_mass: float = about("kg/m\u00b2", "of the second curtain", default=0.2, gt=0, slider=(0.02, 0.6))
    mass: float = about("kg/m\u00b2", "of the cloth; sheers 0.03 to 0.1", default=0.06, gt=0, slider=(0.02, 0.6))
    stretch: float = about(
        "N/m", "how stiff the threads are along themselves", default=3000.0, gt=0, slider=(200.0, 20000.0), log=True)
    shear: float = about("N/m", "how stiff the weave is on the bias", default=15.0, slider=(0.0, 200.0))
    bending: float = about("N m", "how stiff the cloth is to bend", default=3e-5, slider=(1e-6, 9e-4), log=True)
    hem: float = about("", "how much heavier the lowest row is", default=2.0, gt=0, slider=(1.0, 20.0))
    wind: float = option(
        "m/s", "wind into the room, perpendicular to the window; animate: along the built-in cloth", default=0.5, ge=-20,
        le=20, slider=(-3.0, 3.0))
    gustiness: float = about("", "share of the wind that comes and goes", default=1.0, ge=0, le=1)
    openness: float = about(
        "", "share of the cloth that lets air through, if its fabric does not say", default=0.35, ge=0, le=1)
    damping: float = about("1/s", "how fast motion dies away", default=0.6, slider=(0.0, 4.0))
    settle: float = about("s", "without wind before the first frame", default=1.5, ge=0, le=60, slider=(0.0, 5.0))
    # fmt: on

    @model_validator(mode="before")
    @classmethod
    def _as_it_is_sewn(cls, data: Any) -> Any:
        """What follows from width, drop and heading where it is not said."""
        if not isinstance(data, dict) or not data.keys() & {"width", "drop", "heading"}:
            return data
        sizes = {name: data.get(name, cls.model_fields[name].default) for name in ("width", "drop", "fullness")}
        heading = data.get("heading", "tape")
        if (
            not isinstance(heading, str)
            or heading not in FOLDS
            or not all(isinstance(v, int | float) and 0 < v < 1e6 for v in sizes.values())
        ):
            return data
        pleats = data.get("pleats")
        own = _sewn(**sizes, heading=heading, pleats=pleats if isinstance(pleats, int) else None)
        return {**{name: value for name, value in own.items() if value != cls.model_fields[name].default}, **data}

    @model_validator(mode="after")
    def _still_unsaid(self):
        """What followed follows anew where another width, drop or heading is said."""
        own = _sewn(self.width, self.drop, self.fullness, self.heading, self.pleats) | {
            "pleats": _sewn(self.width, self.drop, self.fullness, self.heading)["pleats"]
        }
        for name, value in own.items():
            if getattr(self, name) == value:
                self.__pydantic_fields_set__.discard(name)
        return self

    @field_validator("color", "behind_color", mode="before")
    @classmethod
    def _color(cls, value):
        return color_of(value) if isinstance(value, str) else value

    @property
    def upper(self) -> float:
        """Height of the cloth's upper edge, m."""
        return self.top + (ABOVE_ROD if self.heading in ("eyelet", "rod") else 0.0)

    @model_validator(mode="after")
    def _folds_on_the_grid(self):
        if not self.drop <= self.upper - 0.009:
            raise ValueError(
                f"drop = {self.drop:g}: the rail is at {self.upper:g} m, expected at most {self.upper - 0.01:.3g}, a "
                "centimetre above the floor; change drop or top"
            )
        if min(self.quads) < 6:
            raise ValueError(f"quads = {self.quads}, must be 6 or more each; change them")
        for name in ("open", "behind_open"):
            if getattr(self, name) > self.width - 2 * NARROWEST:
                raise ValueError(
                    f"{name} = {getattr(self, name):g}: the rail is {self.width:g} m long, expected at most "
                    f"{max(0.0, self.width - 2 * NARROWEST):.3g}, {100 * NARROWEST:g} cm for each half; change it or width"
                )
        if self.pleats > self.quads[0] // 6:
            raise ValueError(
                f"pleats = {self.pleats} on {self.quads[0]} quads, must be 1 to {self.quads[0] // 6}, six quads each; "
                "change one of them"
            )
        return self

    def with_triangles(self, count: int) -> CurtainParameters:
        """Return a curtain of about `count` triangles in the same proportions, with as many pleats as they can show."""
        if count < 144:
            raise InputError(f"curtain: {count} triangles, expected 144 or more")
        across = max(12, round(math.sqrt(count / 2 * self.quads[0] / self.quads[1])))
        return self.changed(
            quads=(across, max(6, round(count / 2 / across))), pleats=max(1, min(self.pleats, across // 12))
        )

    @property
    def triangle_count(self) -> int:
        """How many triangles a curtain of one piece has."""
        return 2 * self.quads[0] * self.quads[1]
