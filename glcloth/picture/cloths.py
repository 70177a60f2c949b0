"""The cloths of a frame: which fabric each part of the meshes wears."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..errors import InputError
from ..fabric import Fabric
from ..geometry.mesh import Mesh, relative_to
from ..geometry.mesh_files import BUILTIN_MESHES, load_mesh
from ..geometry.parts import chosen, grouped
from ..geometry.placing import METRES, guessed_unit, placed
from ..gpu.memo import Last
from ..progress import warn
from ..scene import MAPS
from .masks import FabricMask, Masked, check_colors, mask_colors, split
from .openings import Opacity
from .prints import Print
from .uv_scale import guessed_scale


@dataclass(frozen=True, eq=False)
class Cloth:
    """One cloth of a frame: a mesh, its fabric, what is printed on that, where it is cut out, and where a mask has it."""

    mesh: Mesh
    fabric: Fabric
    print: Print | None = None
    opacity: Opacity | None = None
    mask: Masked | None = None


def unit_of(names: Sequence[str], meshes: Sequence[Mesh], units: str) -> str:
    """The unit of the lengths in mesh files, guessed for "auto", with a warning where it is not metres."""
    files = [mesh for name, mesh in zip(names, meshes, strict=True) if name not in BUILTIN_MESHES]
    if units != "auto" or not files:
        return "m" if units == "auto" else units
    if (unit := guessed_unit(files)) != "m":
        warn(f"{names[0]}: too large for metres, its lengths are taken for {unit}; --units m says they are not")
    return unit


def in_metres(names: Sequence[str], meshes: Sequence[Mesh], unit: str) -> tuple[Mesh, ...]:
    """Meshes of files in metres; the built-in ones are."""
    scales = [1.0 if name in BUILTIN_MESHES else METRES[unit] for name in names]
    placed_ones = [placed(mesh, scale) for mesh, scale in zip(meshes, scales, strict=True)]
    return tuple(relative_to(mesh, placed_ones[0].origin) for mesh in placed_ones)


class Dressing:
    """Gives each part of the meshes its fabric. Parts of the same fabric are one cloth; the meshes of the last time are
    kept as long as the same parts share a fabric, whichever it is."""

    def __init__(self) -> None:
        self._grouped: Last[list[tuple[int, Mesh]]] = Last()
        self._split: dict[int, Last[list[tuple[int, Mesh, Masked]]]] = {}  # of each of those that has a mask
        self._checked: Last[None] = Last()  # masks and colours; large masks take a while

    def dress(
        self,
        meshes: tuple[Mesh, ...],
        fabric: Fabric,
        fabrics: Mapping[str, Fabric],
        uv_scale: float = 0.0,
        prints: Mapping[str, Print] | None = None,
        opacities: Mapping[str, Opacity] | None = None,
        masks: Mapping[str, FabricMask] | None = None,
    ) -> tuple[Cloth, ...]:
        """The cloths of meshes.

        Parameters
        ----------
        fabric : of the parts that nothing in `fabrics` names
        fabrics : by patterns of parts' names, or by colours of the masks
        prints, opacities, masks : likewise by parts; "" stands for the parts that nothing names
        uv_scale : metres in a UV unit; 0: measured

        Raises InputError for a pattern that fits no part, a colour that no mask has, and a map on a mesh without UVs.
        """
        colors = mask_colors(fabrics)
        masks = masks or {}
        of_colors = [fabrics[color] for color in colors]
        fabrics = {part: one for part, one in fabrics.items() if part not in colors}
        wardrobe = [fabric, *fabrics.values()]
        # Equal fabrics are one: the first of them.
        first = [next(i for i, other in enumerate(wardrobe) if other is one or other == one) for one in wardrobe]
        worn = [[first[n + 1] for n in of] for of in chosen(meshes, list(fabrics))]
        self._checked.get(lambda: check_colors(masks, colors), *masks.values(), tuple(colors))
        printed, prints_of = _named(meshes, prints or {}, "prints")
        opened, opacities_of = _named(meshes, opacities or {}, "opacities")
        masked, masks_of = _named(meshes, masks, "fabric_masks")
        looks = [list(zip(*of, strict=True)) for of in zip(worn, printed, opened, masked, strict=True)]
        kinds = list(dict.fromkeys(kind for of in looks for kind in of))
        groups = tuple(tuple(map(kinds.index, of)) for of in looks)
        pieces = self._grouped.get(lambda: grouped(meshes, groups), meshes, groups)
        cloths = []
        self._split = {
            place: self._split.get(place, Last()) for place, (n, _) in enumerate(pieces) if masks_of[kinds[n][3]]
        }
        for place, (number, mesh) in enumerate(pieces):
            dress, design, openings, mask = kinds[number]
            one = Cloth(mesh, wardrobe[dress], prints_of[design], opacities_of[openings])
            found = [name for name, of in zip(MAPS, (one.print, one.opacity, masks_of[mask]), strict=True) if of]
            if mesh.uv is None and found:
                raise InputError(
                    f"{found[0]}: mesh {mesh.name} has no UVs, expected some; unwrap it, or name the parts that have them: "
                    "PART=FILE"
                )
            if masks_of[mask] is None:
                cloths.append(one)
            else:
                cloths += self._masked(one, place, masks_of[mask], colors, of_colors, uv_scale)
        return tuple(cloths)

    def _masked(
        self, cloth: Cloth, place: int, mask: FabricMask, colors: list[str], fabrics: list[Fabric], uv_scale: float
    ) -> list[Cloth]:
        """A cloth, number `place`, as one for each fabric of a mask; its own where the mask has none of the colours."""

        def pieces() -> list[tuple[int, Mesh, Masked]]:
            scale = (uv_scale or guessed_scale(cloth.mesh)) if mask.in_metres else 1.0
            return split(cloth.mesh, mask, colors, scale)

        made = self._split[place].get(pieces, cloth.mesh, mask, tuple(colors), uv_scale)
        worn = [cloth.fabric, *fabrics]
        return [replace(cloth, mesh=mesh, fabric=worn[number], mask=of) for number, mesh, of in made]


def _named(meshes: tuple[Mesh, ...], maps: Mapping[str, Any], what: str) -> tuple[list[list[int]], list[Any]]:
    """For each part of each mesh which map it has, and the maps, where the first is that of all others, or None."""
    names = [name for name in maps if name]
    numbers = [[n + 1 for n in of] for of in chosen(meshes, names, what)]
    return numbers, [maps.get(""), *(maps[name] for name in names)]


def load_meshes(names: Sequence[str], units: str = "auto") -> tuple[tuple[Mesh, ...], str]:
    """Read meshes of built-in names or files; returns them in metres, and the unit of the files. Raises InputError as
    `load_mesh`."""
    known = {name: load_mesh(name) for name in dict.fromkeys(names)}
    meshes = [known[name] for name in names]
    unit = unit_of(names, meshes, units)
    return in_metres(names, meshes, unit), unit
