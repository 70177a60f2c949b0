"""Controls from fields: the widget of a panel for each parameter, read from the models that define them."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

from ..fields import Entry, Value, entries
from ..scene import CurtainParameters, MethodName, Scene

KINDS = ("float", "int", "color", "triple", "pair", "choice", "bool", "text", "curve")
# The curtain's own. The first ones change while it moves, the others hang it anew.
HUNG = (
    "wind", "gustiness", "stretch", "shear", "bending", "mass", "hem", "damping",
    "fullness", "pleats", "irregularity", "drop", "clearance", "heading", "settle", "open", "behind_open", "behind_fullness",
)  # fmt: skip
CURVE = ("curve_angles_deg", "curve_lengths", "samples", "tangents_deg")  # edited together, in a plot
# Fields that only one method reads: shown with that method.
METHOD_FIELDS = {
    method: tuple(entry.name for entry in entries(Scene) if entry.of == method)
    for method in (*get_args(MethodName), "path")
}


Control = Entry  # its limits are the slider's ends


def controls(model: type[Value], names: tuple[str, ...] | None = None) -> list[Control]:
    """The controls of a model's fields (all, or those named), in their order; models inside it have their own."""
    out = []
    for entry in entries(model, names):
        low, high = entry.slider or (entry.low, entry.high)
        control = replace(entry, low=low, high=high, kind="curve" if entry.name in CURVE else entry.kind)
        if control.kind in KINDS:
            out.append(control)
    return out


def scene_controls(method: str) -> list[Control]:
    """The controls of a method's own settings, and by which way it shades pixels."""
    shade = ("shade",) if method in get_args(MethodName) else ()
    return controls(Scene, (*METHOD_FIELDS.get(method, ()), *shade))


def curtain_controls(names: tuple[str, ...] = HUNG) -> list[Control]:
    """The controls of the curtain itself (all, or those named), in this order."""
    return controls(CurtainParameters, names)
