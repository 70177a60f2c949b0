"""The contracts of what rays go through and of acceleration structures, and these by their names."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

import moderngl
import numpy as np

from ..errors import InputError
from ..gpu.buffers import Buffer
from .brute import Brute
from .kdtree import KdTree, MedianKdTree
from .lbvh import Lbvh
from .triangles import Triangles


class Traced(Protocol):
    """What rays go through; a pass traces it by `#include "accel.glsl"`.

    source: the GLSL file with `traverse`. ordered_hits: whether that finds hits in their order, so that a visitor may ask
    for all layers. triangles: those it was built of.
    """

    @property
    def source(self) -> str: ...

    @property
    def ordered_hits(self) -> bool: ...

    @property
    def triangles(self) -> Triangles | None: ...

    def inputs(self) -> dict[str, Any]:
        """The inputs of `source`, by their names there."""

    def chunks(self) -> Iterator[dict[str, int]]:
        """The uniforms of each dispatch that one query takes."""


class Structure(Traced, Protocol):
    """An acceleration structure over `Triangles`. timings: ms of each stage of the last build."""

    @property
    def node_count(self) -> int: ...

    @property
    def leaf_ref_count(self) -> int: ...

    @property
    def timings(self) -> dict[str, float]: ...

    def build(self, triangles: Triangles) -> None:
        """Build it of the triangles as they are now."""

    def build_steps(self, triangles: Triangles, later: bool = False) -> Iterator[None]:
        """As `build`, in steps, for a caller with other things to do in between. later : see `unread`."""

    @property
    def unread(self) -> Buffer | None:
        """What says whether a build that was to be looked at later had room; None: it is known."""

    def fits(self, data: bytes) -> bool:
        """Whether it had, by the content of `unread`; else there is more now, and it is to be built anew."""

    def arrays(self) -> dict[str, np.ndarray]:
        """The structure as NumPy arrays: axis [N] (3 = leaf), count [N], depth [N] of its nodes, and triangles [R]."""

    def release(self) -> None:
        """Free the GPU's memory."""


STRUCTURES: dict[str, type[KdTree | Lbvh | Brute]] = {
    "kdtree": KdTree,
    "kdtree_median": MedianKdTree,
    "lbvh": Lbvh,
    "brute": Brute,
}


def make_structure(ctx: moderngl.Context, name: str) -> Structure:
    """A new structure of a name. Raises InputError for an unknown one."""
    if name not in STRUCTURES:
        raise InputError(f"accelerator {name!r}: expected one of {', '.join(STRUCTURES)}")
    return STRUCTURES[name](ctx)


def tracing(structure: Traced) -> dict[str, str]:
    """The virtual includes of a pass that casts rays through a structure and counts nothing."""
    return {"accel.glsl": structure.source, "count.glsl": "inputs/accel/count_none.glsl"}
