"""What the passes of visibility ask of an acceleration structure."""

from __future__ import annotations

from typing import Any, Protocol

from ..accel.triangles import Triangles


class Structure(Protocol):
    """Over the triangles that hide light: those of all surfaces, one after the other."""

    source: str
    triangles: Triangles | None

    def inputs(self) -> dict[str, Any]: ...


def tracing(structure: Structure) -> dict[str, str]:
    """The virtual includes of a pass that casts rays through a structure."""
    return {"accel.glsl": structure.source, "count.glsl": "inputs/accel/count_none.glsl"}
