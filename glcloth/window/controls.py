"""Controls from fields: what a panel shows for each parameter, read from the models that define them."""

from __future__ import annotations

import types
from dataclasses import dataclass, fields
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from ..curtain.hanging import CurtainParameters
from ..curtain.show import CurtainScene
from ..scene import Scene

CURVE = ("curve_angles_deg", "curve_lengths", "samples", "tangents_deg")  # edited together, in a plot
# Scene's fields are the options of `render`; here is what a panel says about those it shows.
_SCENE_HELP = {
    "quality": ("", "nodes per light: draft is fastest, high is closest to the reference"),
    "segments": ("", "theta segments per Gaussian (the paper: 6)"),
    "grid": ("", "directions per axis of the tables; a change makes new tables"),
    "contribution": ("", "share of the singular values kept; a change makes new tables"),
    "cube": ("texels", "edge of the cube map whose directions are summed"),
    "light": ("", "sg: the fitted lights; map: the environment itself"),
    "lobes": ("", "spherical Gaussians fitted to the environment, K"),
    "env_rotate": ("degrees", "turns the environment about +Y (or drag with the right button)"),
    "exposure": ("stops", "brightness of the picture on screen and in PNG files; EXR files keep the light itself"),
    "spp": ("", "samples per pixel once the picture is refined"),
    "ground_color": ("", "what the ground reflects"),
    "background": ("", "show the environment behind the cloth"),
    "adaptive": ("", "shade one pixel in four where neighbours are alike; small pictures always do while you edit"),
    "shadows": ("", "what the cloth hides from itself: nothing, the suns, or all the light"),
    "depth": ("", "generations of rays: through the cloth and mirrored by it"),
    "spread": ("", "blur what is seen through the yarns; needs many samples per pixel"),
    "accelerator": ("", "what rays are traced through; all give the same picture"),
    "lamp_position": ("m", "the lamp outside the window, x y z; +y up, the window at z = 0"),
    "lamp_intensity": ("W/sr", "of the lamp, red green blue"),
    "ambient": ("", "even light in the room, red green blue"),
}
# Fields that only one method reads: shown with that method.
METHOD_FIELDS = {
    "direct": ("quality", "adaptive"),
    "paper": ("segments", "grid", "contribution"),
    "reference": ("cube", "light"),
}
_SCENE_RANGES = {
    "env_rotate": (-180.0, 180.0), "exposure": (-8.0, 8.0), "lobes": (1, 64), "spp": (1, 64),
    "lamp_position": (-12.0, 12.0), "lamp_intensity": (0.0, 1000.0), "ambient": (0.0, 2.0),
}  # fmt: skip
# The curtain's own parameters: unit, help, range. The first ones change while it moves, the others hang it anew.
_CURTAIN = {
    "wind": ("m/s", "into the room, perpendicular to the window", -3.0, 3.0),
    "gustiness": ("", "share of the wind that comes and goes", 0.0, 1.0),
    "stretch": ("N/m", "how stiff the threads are along themselves", 200.0, 20000.0),
    "shear": ("N/m", "how stiff the weave is on the bias", 0.0, 200.0),
    "bending": ("N m", "how stiff the cloth is to bend", 1e-6, 1e-3),
    "mass": ("kg/m\u00b2", "of the cloth; sheers 0.03 to 0.1", 0.02, 0.6),
    "hem": ("", "how much heavier the lowest row is", 1.0, 20.0),
    "damping": ("1/s", "how fast motion dies away", 0.0, 4.0),
    "fullness": ("", "width of the cloth over that of the rail", 1.0, 3.0),
    "pleats": ("", "folds along the rail", 3, 24),
    "irregularity": ("", "how unequal the folds are", 0.0, 1.0),
    "drop": ("m", "length of the cloth", 0.5, 2.4),
    "clearance": ("m", "from the window to the backs of the folds", 0.02, 0.5),
    "heading": ("", "tape holds the whole upper edge, rings the front of each fold", None, None),
    "settle": ("s", "without wind before the first frame", 0.0, 5.0),
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


def controls(model: type[BaseModel], names: tuple[str, ...] | None = None) -> list[Control]:
    """The controls of a model's fields (all, or those named), in their order; models inside it have their own."""
    out = []
    for name in names or tuple(model.model_fields):
        control = _control(model, name, model.model_fields[name])
        if control is not None:
            out.append(control)
    return out


def _control(model: type[BaseModel], name: str, field: FieldInfo) -> Control | None:
    kind, inner = _kind(name, field.annotation)
    if kind is None:
        return None
    unit, text = (field.json_schema_extra or {}).get("unit", ""), field.description or ""
    low, high = _limits([*field.metadata, *inner])
    ours = model in (Scene, CurtainScene)
    if ours:
        unit, text = _SCENE_HELP.get(name, (unit, text))
        low, high = _SCENE_RANGES.get(name, (low, high))
    choices = tuple(get_args(field.annotation)) if kind == "choice" else ()
    label = name.removesuffix("_deg").replace("_", " ") if ours else name.removesuffix("_deg")
    return Control(name, label, kind, unit, text, low, high, choices)


def _kind(name: str, annotation: Any) -> tuple[str | None, list]:
    """The kind of a field and the limits that its type itself carries."""
    if name in CURVE:
        return "curve", []
    if get_origin(annotation) in (Union, types.UnionType):
        parts = [a for a in get_args(annotation) if a is not types.NoneType]
        numbers = [a for a in parts if a in (int, float)]
        annotation = numbers[0] if numbers else parts[0]
    inner = []
    if get_origin(annotation) is Annotated:
        annotation, *inner = get_args(annotation)
    if get_origin(annotation) is Literal:
        return "choice", inner
    if get_origin(annotation) is tuple:
        first = get_args(annotation)
        if len(first) == 3 and Ellipsis not in first:
            inner = list(getattr(first[0], "__metadata__", ()))
            _, high = _limits(inner)
            return ("color" if high == 1.0 else "triple"), inner
        return None, []
    return {bool: "bool", int: "int", float: "float", str: "text"}.get(annotation), inner


def _limits(metadata: list) -> tuple[float | None, float | None]:
    low = high = None
    for item in metadata:
        if isinstance(item, FieldInfo):
            inner = _limits(item.metadata)
            low, high = (inner[0] if inner[0] is not None else low), (inner[1] if inner[1] is not None else high)
        low = getattr(item, "ge", low) if getattr(item, "ge", None) is not None else low
        # A limit that itself is not allowed: the slider ends a thousandth before it.
        low = item.gt + 1e-3 if getattr(item, "gt", None) is not None else low
        high = item.le if getattr(item, "le", None) is not None else high
    return low, high


def scene_controls(method: str) -> list[Control]:
    """The controls of a method's own settings."""
    return controls(Scene, METHOD_FIELDS.get(method, ()))


def curtain_controls(names: tuple[str, ...] = ()) -> list[Control]:
    """The controls of the curtain itself (all, or those named), in the order of the table above."""
    found = {field.name: field for field in fields(CurtainParameters)}
    out = []
    for name in names or tuple(_CURTAIN):
        unit, text, low, high = _CURTAIN[name]
        default = found[name].default
        choices = get_args(get_type_hints(CurtainParameters)[name]) if isinstance(default, str) else ()
        kind = "choice" if choices else "int" if isinstance(default, int) else "float"
        out.append(Control(name, name, kind, unit, text, low, high, choices, low is not None and high > 90 * low > 0))
    return out
