"""The parts of meshes: named by the file's materials, groups and objects, and taken apart or joined by them."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase

import numpy as np

from ..errors import InputError, meant
from .mesh import Mesh, relative_to
from .raw import Names

SHOWN = 12  # names that an error lists


def names_of(mesh: Mesh) -> tuple[Names, ...]:
    """The names of each part of a mesh; the mesh's own is one of every part."""
    return tuple((*part, mesh.name) for part in mesh.parts) if mesh.parts else ((mesh.name,),)


def fit(pattern: str, names: Names) -> tuple | None:
    """How well a pattern with * and ? fits one of a part's names, the larger the better; None: not at all.

    Capitals do not count. A whole name fits better than a pattern, a long pattern better than a short one, a material
    better than a group, and that better than an object; so the order in which patterns are given tells nothing.
    """
    folded = pattern.casefold()
    for number, name in enumerate(names):
        if name.casefold() == folded:
            return 1, 0, -number, pattern
    for number, name in enumerate(names):
        if fnmatchcase(name.casefold(), folded):
            return 0, sum(c not in "*?" for c in folded), -number, pattern
    return None


def chosen(meshes: Sequence[Mesh], patterns: Sequence[str], what: str = "fabrics") -> tuple[tuple[int, ...], ...]:
    """For each part of each mesh the number of the pattern that fits it best; -1: none does.

    Raises InputError for a pattern that fits no part; `what` says whose patterns they are.
    """
    parts = [names_of(mesh) for mesh in meshes]
    known = list(dict.fromkeys(name for of_mesh in parts for names in of_mesh for name in names))
    for pattern in patterns:
        if not any(fit(pattern, names) for of_mesh in parts for names in of_mesh):
            listed = ", ".join(known[:SHOWN]) + (f" and {len(known) - SHOWN} more" if len(known) > SHOWN else "")
            longer = any(pattern.casefold() in name.casefold() for name in known) and not set("*?") & set(pattern)
            hint = meant(pattern, known, "; did you mean {}?") or (f"; did you mean *{pattern}*?" if longer else "")
            hint += "; a colour of a fabric mask is #rgb or #rrggbb" if pattern.startswith("#") and not hint else ""
            raise InputError(f"{what}: no part is called {pattern}, expected {listed}{hint}")

    def best(names: Names) -> int:
        fits = [(found, n) for n, pattern in enumerate(patterns) if (found := fit(pattern, names))]
        return max(fits)[1] if fits else -1

    return tuple(tuple(map(best, of_mesh)) for of_mesh in parts)


def taken(mesh: Mesh, wanted: np.ndarray) -> Mesh:
    """The triangles of a mesh where `wanted` [T] is true, with the vertices they use and the frames they had."""
    if wanted.all():
        return mesh
    triangles = mesh.triangles[wanted]
    used = np.unique(triangles)
    number = np.zeros(len(mesh.positions), np.int32)
    number[used] = np.arange(len(used))
    return Mesh(
        mesh.name,
        mesh.positions[used],
        number[triangles],
        mesh.normals[used],
        None if mesh.uv is None else mesh.uv[used],
        mesh.tangents[used],
        mesh.parts,
        None if mesh.part_of is None else mesh.part_of[wanted],
        mesh.origin,
        mesh.scale,
    )


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one, in their order; it has UVs where all of them have. Its parts' names end with their
    mesh's own."""
    if len(meshes) == 1:
        return meshes[0]
    meshes = [relative_to(mesh, meshes[0].origin) for mesh in meshes]
    begins = np.cumsum([0] + [len(mesh.positions) for mesh in meshes])
    with_uv = all(mesh.uv is not None for mesh in meshes)
    parts: list[Names] = []
    part_of = []
    for mesh in meshes:
        own = np.zeros(len(mesh.triangles), np.int32) if mesh.part_of is None else mesh.part_of
        part_of.append(own + len(parts))
        parts += names_of(mesh)
    return Mesh(
        meshes[0].name,
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([mesh.triangles + begin for mesh, begin in zip(meshes, begins, strict=False)]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.uv for mesh in meshes if mesh.uv is not None]) if with_uv else None,
        np.concatenate([mesh.tangents for mesh in meshes]),
        parts=tuple(parts),
        part_of=np.concatenate(part_of).astype(np.int32),
        origin=meshes[0].origin,
        scale=meshes[0].scale,
    )


def grouped(meshes: Sequence[Mesh], groups: Sequence[Sequence[int]]) -> list[tuple[int, Mesh]]:
    """Meshes taken apart and joined again: each group of parts is one mesh.

    `groups`: the group of each part of each mesh. Returns (group, mesh) in the order of the groups' first parts; meshes
    with and without UVs stay apart. A mesh that is a group alone stays the same object.
    """
    pieces: dict[tuple[int, bool], list[Mesh]] = {}
    for mesh, of_part in zip(meshes, groups, strict=True):
        part_of = np.zeros(len(mesh.triangles), np.int32) if mesh.part_of is None else mesh.part_of
        group = np.asarray(of_part)[part_of]
        for number in dict.fromkeys(of_part):
            if (wanted := group == number).any():
                pieces.setdefault((number, mesh.uv is not None), []).append(taken(mesh, wanted))
    return [(number, joined(of)) for (number, _), of in pieces.items()]
