"""The cloths of a frame: which fabric each part of the meshes wears."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import InputError
from ..fabric import Fabric
from ..geometry.mesh import Mesh, relative_to
from ..geometry.mesh_files import BUILTIN_MESHES, load_mesh
from ..geometry.parts import chosen, grouped
from ..geometry.placing import METRES, guessed_unit, placed
from ..gpu.memo import Last
from ..progress import warn
from .openings import Opacity
from .prints import Print


@dataclass(frozen=True, eq=False)
class Cloth:
    """One cloth of a frame: a mesh, its fabric, what is printed on that, and where it is cut out."""

    mesh: Mesh
    fabric: Fabric
    print: Print | None = None
    opacity: Opacity | None = None


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

    def dress(
        self,
        meshes: tuple[Mesh, ...],
        fabric: Fabric,
        fabrics: Mapping[str, Fabric],
        prints: Mapping[str, Print] | None = None,
        opacities: Mapping[str, Opacity] | None = None,
    ) -> tuple[Cloth, ...]:
        """The cloths of meshes.

        Parameters
        ----------
        fabric : of the parts that nothing in `fabrics` names
        fabrics : by patterns of parts' names
        prints, opacities : likewise; "" stands for the parts that nothing names

        Raises InputError for a pattern that fits no part, and for a map on a mesh without UVs.
        """
        wardrobe = [fabric, *fabrics.values()]
        # Equal fabrics are one: the first of them.
        first = [next(i for i, other in enumerate(wardrobe) if other is one or other == one) for one in wardrobe]
        worn = [[first[n + 1] for n in of] for of in chosen(meshes, list(fabrics))]
        printed, prints_of = _named(meshes, prints or {}, "prints")
        opened, opacities_of = _named(meshes, opacities or {}, "opacities")
        kinds = list(
            dict.fromkeys(kind for of in zip(worn, printed, opened, strict=True) for kind in zip(*of, strict=True))
        )
        groups = tuple(
            tuple(kinds.index(kind) for kind in zip(*of, strict=True)) for of in zip(worn, printed, opened, strict=True)
        )
        pieces = self._grouped.get(lambda: grouped(meshes, groups), meshes, groups)
        cloths = []
        for number, mesh in pieces:
            dress, design, openings = kinds[number]
            cloths.append(Cloth(mesh, wardrobe[dress], prints_of[design], opacities_of[openings]))
        for one in cloths:
            if one.mesh.uv is None and (one.print or one.opacity):
                raise InputError(
                    f"{'print' if one.print else 'opacity'}: mesh {one.mesh.name} has no UVs, expected some; unwrap it, or name "
                    "the parts that have them: PART=FILE"
                )
        return tuple(cloths)


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
