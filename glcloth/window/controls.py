"""Controls from fields: what a panel shows for each parameter, read from the models that define them."""

from __future__ import annotations

from dataclasses import dataclass

from ..fields import Entry, Value, entries
from ..scene import CurtainParameters, Scene

KINDS = ("float", "int", "color", "triple", "choice", "bool", "text", "curve")
# The curtain's own. The first ones change while it moves, the others hang it anew.
HUNG = (
    "wind", "gustiness", "stretch", "shear", "bending", "mass", "hem", "damping",
    "fullness", "pleats", "irregularity", "drop", "clearance", "heading", "settle",
)  # fmt: skip
CURVE = ("curve_angles_deg", "curve_lengths", "samples", "tangents_deg")  # edited together, in a plot
# Fields that only one method reads: shown with that method.
METHOD_FIELDS = {
    method: tuple(entry.name for entry in entries(Scene) if entry.of == method)
    for method in ("direct", "paper", "reference")
}


@dataclass(frozen=True)
class Control:
    """One control.

    Parameters
    ----------
    name : the field; label : the same for people
    kind : "float", "int", "color" (three shares), "triple", "choice", "bool", "text" or "curve"
    low, high : range of the values; None where the field has no limit
    choices : for "choice"
    log : values of very different size, on a logarithmic scale
    """

    name: str
    label: str
    kind: str
    unit: str
    help: str
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    log: bool = False


def controls(model: type[Value], names: tuple[str, ...] | None = None) -> list[Control]:
    """The controls of a model's fields (all, or those named), in their order; models inside it have their own."""
    return [_control(model, entry) for entry in entries(model, names) if _kind(entry) in KINDS]


def _control(model: type[Value], entry: Entry) -> Control:
    label = entry.name.removesuffix("_deg")
    low, high = entry.slider or (entry.low, entry.high)
    return Control(
        entry.name,
        label.replace("_", " ") if model is Scene else label,
        _kind(entry),
        entry.unit,
        entry.help,
        low,
        high,
        entry.choices,
        entry.log,
    )


def _kind(entry: Entry) -> str:
    return "curve" if entry.name in CURVE else entry.kind


def scene_controls(method: str) -> list[Control]:
    """The controls of a method's own settings."""
    return controls(Scene, METHOD_FIELDS.get(method, ()))


def curtain_controls(names: tuple[str, ...] = HUNG) -> list[Control]:
    """The controls of the curtain itself (all, or those named), in this order."""
    return controls(CurtainParameters, names)
