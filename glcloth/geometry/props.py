"""Solid objects about the cloth and a ground, all matt, as plain values; `visibility` and `picture.solids` light them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..place import Place, split_place
from . import shapes
from .graded import graded
from .mesh import Mesh, build_mesh, relative_to
from .mesh_files import BUILTIN_MESHES, BUILTIN_SOLIDS, load_object
from .placing import METRES, guessed_unit, placed
from .raw import Material

GAP = 0.002  # of the cloth's radius: how far below the lowest point a ground lies that is given no height
FARTHEST = 3.0  # radii of the cloth: how far about it the ground is drawn finely for the sake of objects
RINGS, SECTORS = 84, 112
FAR = 64.0


@dataclass(frozen=True)
class Ground:
    """A horizontal plane without end.

    Parameters
    ----------
    height : y, metres
    center : x, z of the middle of the drawn part
    scale : metres; the rings about the middle are scale / (RINGS / 2) apart at it, four times that at `scale` from it
    color : diffuse reflectance, linear Rec. 709
    catcher : it shows only its shadow, which fades out with the distance
    """

    height: float
    center: tuple[float, float]
    scale: float
    color: tuple[float, float, float]
    catcher: bool = False

    @cached_property
    def mesh(self) -> Mesh:
        """Rings of triangles, finest in the middle: vertex 1 + SECTORS r + s is number s of ring r, 0 is the middle."""
        positions, triangles, normals = shapes.rings(self.radii[1:], SECTORS)
        positions += (self.center[0], self.height, self.center[1])
        return build_mesh("ground", positions, triangles, None, normals)

    @property
    def radii(self) -> np.ndarray:
        """Metres [RINGS + 1], from 0: scale t / (1 - t) for t even from 0 on, which has an end at infinity; the last one
        so far that from a person's height the plane ends less than a pixel below the horizon."""
        t = np.arange(RINGS + 1) / (RINGS + 1)
        radii = self.scale * t / (1.0 - t)
        radii[-1] *= FAR
        return radii


@dataclass(frozen=True, eq=False)
class Objects:
    """Objects and an optional ground.

    Parameters
    ----------
    meshes : of the objects
    reflectances : of each mesh [T, 3], linear Rec. 709
    ground : None where there is none
    graded : whether the triangles of each mesh grow with their distance from the cloth; (): of none
    materials, material_of : of each mesh its materials, and the number of each triangle's among them [T]; none: all matt
    """

    meshes: tuple[Mesh, ...] = ()
    reflectances: tuple[np.ndarray, ...] = field(default=())
    ground: Ground | None = None
    graded: tuple[bool, ...] = ()
    materials: tuple[tuple[Material, ...], ...] = ()
    material_of: tuple[np.ndarray, ...] = ()

    @property
    def empty(self) -> bool:
        """Whether there is nothing."""
        return not self.meshes and self.ground is None

    def same_shape(self, other: Objects | None) -> bool:
        """Whether these hide the same light as others."""
        if other is None or len(self.meshes) != len(other.meshes):
            return False
        places = [g and (g.height, g.center, g.scale) for g in (self.ground, other.ground)]
        return places[0] == places[1] and all(a is b for a, b in zip(self.meshes, other.meshes, strict=True))


class Solid(NamedTuple):
    """A mesh, the reflectances [T, 3] of its triangles, its materials and the number of each triangle's among them [T]."""

    mesh: Mesh
    reflectances: np.ndarray
    materials: tuple[Material, ...]
    material_of: np.ndarray


def load_solids(names: Sequence[str], unit: str = "m", guessed: bool = True) -> tuple[Solid, ...]:
    """Read meshes of built-in names or files with their colours, and set each where it stands.

    Parameters
    ----------
    names : NAME@x,y,z,scale,turn; what follows the name may be missing
    unit : of the lengths in files
    guessed : from the cloth; a glTF, whose lengths ought to be metres, then has to be too large for metres itself

    Raises InputError as `load_solid`.
    """
    split = [split_place(name) for name in names]
    known = {name: Solid(*load_object(name)) for name in dict.fromkeys(name for name, _ in split)}
    return tuple(_standing(known[name], name, Place.of(place), unit, guessed) for name, place in split)


def _standing(solid: Solid, name: str, place: Place, unit: str, guessed: bool) -> Solid:
    in_metres = name in (*BUILTIN_MESHES, *BUILTIN_SOLIDS)
    if guessed and Path(name).suffix.lower() in (".glb", ".gltf"):
        in_metres |= guessed_unit([solid.mesh]) == "m"
    scale = place.scale * (1.0 if in_metres else METRES[unit])
    return solid._replace(mesh=placed(solid.mesh, scale, place.turn_deg, place[:3]))


def arrange(solids: Sequence[Solid], ground: float | str, color, cloth: Mesh) -> Objects:
    """Objects and ground about a cloth, as a scene says: `ground` is a height, "auto", "catcher" or "off"."""
    # A cloth far from the origin was moved there, and what stands about it with it.
    whole = [relative_to(solid.mesh, cloth.origin) for solid in solids]
    cut = [graded(mesh, tuple(cloth.center.tolist()), cloth.radius) for mesh in whole]
    sources = [source for _, source in cut]
    objects = Objects(
        tuple(mesh for mesh, _ in cut),
        tuple(solid.reflectances[source] for solid, source in zip(solids, sources, strict=True)),
        graded=tuple(mesh is not before for (mesh, _), before in zip(cut, whole, strict=True)),
        materials=tuple(solid.materials for solid in solids),
        material_of=tuple(solid.material_of[source] for solid, source in zip(solids, sources, strict=True)),
    )
    if ground == "off":
        return objects
    height = None if ground in ("auto", "catcher") else float(ground) - cloth.origin[1]
    stands = replace(stand_on(cloth, objects.meshes, height, color), catcher=ground == "catcher")
    return replace(objects, ground=stands)


def stand_on(cloth: Mesh, meshes: Sequence[Mesh], height: float | None, color) -> Ground:
    """The ground below a cloth and objects, at a height (m) or, if None, just under the lowest point of all."""
    boxes = np.array([mesh.bounds for mesh in (cloth, *meshes)])
    if height is None:
        height = float(boxes[:, 0, 1].min() - GAP * cloth.radius)
    middle = cloth.center[[0, 2]]
    reach = np.abs(boxes[..., [0, 2]] - middle).max()
    scale = 2.0 * float(np.clip(reach, 0.5 * cloth.radius, FARTHEST * cloth.radius))
    return Ground(height, (float(middle[0]), float(middle[1])), scale, tuple(map(float, color)))
