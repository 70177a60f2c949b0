"""Pictures over the UVs of cloth, as a scene names them: prints, openings, and which fabric is where."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict

from ..fields import Value, about

# The fields of a scene with such a map: of all cloth, and of its parts.
MAPS = {"print": "prints", "opacity": "opacities", "fabric_mask": "fabric_masks"}


class ClothMap(Value):
    """A picture over the UVs of cloth, which repeats; its upper edge is at growing v."""

    file: str = about("", "PNG, JPEG, OpenEXR or Radiance picture", min_length=1)
    repeat: float = about(
        "", "how much of the cloth one repeat covers, along u; in metres it keeps its proportions along v",
        default=1.0, gt=0, le=1e6,
    )  # fmt: skip
    unit: Literal["uv", "m"] = about(
        "", "of the repeat: UV units, where it is as high as wide, or metres", default="uv"
    )


class PrintMap(ClothMap):
    """A print: what it multiplies the colours of the yarns by."""

    model_config = ConfigDict(title="print")

    space: Literal["srgb", "linear"] = about(
        "", "of the codes in a PNG or JPEG: sRGB, or linear; OpenEXR and Radiance are always linear", default="srgb")  # fmt: skip


class OpacityMap(ClothMap):
    """Where cloth is: the alpha of a picture that has some, else its codes, as they are; 0 is open."""

    model_config = ConfigDict(title="opacity")


class FabricMaskMap(ClothMap):
    """Which fabric a place has: that of the listed colour nearest to the picture's codes there; the part's own where none is
    within a quarter of their range."""

    model_config = ConfigDict(title="fabric_mask")
