"""One control on a panel: drawn as its field says, with help, unit and reset."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from imgui_bundle import imgui  # isort: skip
import numpy as np

from ..color import srgb_decode, srgb_encode
from .actions import Actions
from .controls import Control

UNITS = {"degrees": "\u00b0", "stops": " stops", "texels": "", "m/s": " m/s", "m": " m", "s": " s"}
RED, AMBER, GREY = (1.0, 0.45, 0.4, 1.0), (1.0, 0.8, 0.35, 1.0), (0.62, 0.62, 0.62, 1.0)
CLAMP = imgui.SliderFlags_.always_clamp.value
LOG = imgui.SliderFlags_.logarithmic.value


def neat(value: float) -> float:
    """A slider's float32 as a person would write it."""
    return float(f"{value:.6g}")


def control(control: Control, value: Any, high: float | None = None, scale: float = 1.0) -> tuple[bool, Any]:
    """Draw a control; returns (changed, value).

    high : narrows its range; scale : points per pixel
    """
    unit = UNITS.get(control.unit, "")
    top = control.high if high is None else high
    label = control.label
    if control.kind == "float":
        digits = (
            ("%.0f" if control.high > 100 else "%.3g")
            if control.log
            else "%.1f"
            if control.unit in ("degrees", "stops")
            else "%.3f"
        )
        flags = CLAMP | (LOG if control.log else 0)
        changed, new = imgui.slider_float(label, value, control.low, max(top, control.low), digits + unit, flags)
        new = neat(new)
    elif control.kind == "int":
        changed, new = imgui.slider_int(label, value, int(control.low), int(top), "%d" + unit, CLAMP)
    elif control.kind == "bool":
        changed, new = imgui.checkbox(label, value)
    elif control.kind == "choice":
        new = chooser(label, value, list(control.choices)) or value
        changed = new != value
    elif control.kind == "color":
        # The picker works on the screen's values, the sliders on the linear shares.
        code = [float(c) for c in srgb_encode(np.array(value))]
        flags = imgui.ColorEditFlags_
        picked, code = imgui.color_edit3(f"##{label} colour", code, flags.float | flags.no_inputs | flags.no_label)
        help_text(control)
        imgui.same_line()
        imgui.set_next_item_width(imgui.calc_item_width() - 30 * scale)
        changed, new = imgui.slider_float3(label, [float(v) for v in value], control.low, top, "%.3f", CLAMP)
        new = tuple(neat(v) for v in (srgb_decode(np.clip(code, 0.0, 1.0)) if picked else new))
        changed = changed or picked
    elif control.kind == "pair":
        digits = "%.1f" if control.unit == "degrees" else "%.2f"
        changed, new = imgui.slider_float2(label, [float(v) for v in value], control.low, top, digits + unit, CLAMP)
        new = tuple(neat(v) for v in new)
    else:
        changed, new = imgui.slider_float3(label, [float(v) for v in value], control.low, top, "%.3g", CLAMP)
        new = tuple(neat(v) for v in new)
    help_text(control)
    return changed, new


def hovered() -> bool:
    """Whether the pointer rests on the last item."""
    return imgui.is_item_hovered(imgui.HoveredFlags_.delay_short.value)


def help_text(control: Control) -> None:
    """Explain the last item while the pointer rests on it."""
    if not hovered():
        return
    parts = [control.help or control.label]
    if control.unit:
        parts.append(f"in {control.unit}")
    if (
        control.low is not None
        and control.high is not None
        and control.kind in ("float", "int", "color", "triple", "pair")
    ):
        parts.append(f"{control.low:g} to {control.high:g}; Ctrl+click to type")
    imgui.set_tooltip("\n".join(parts))


def tip(text: str) -> None:
    """Say something about the last item, while the pointer rests on it."""
    if hovered():
        imgui.set_tooltip(text)


def reset(key: str) -> bool:
    """A button that takes back changes of the chosen fabric; True when it is pressed."""
    imgui.same_line()
    pressed = imgui.small_button(f"reset##{key}")
    tip("back to the value of the chosen fabric")
    return pressed


def chooser(label: str, value: str, names: list[str]) -> str | None:
    """A list of built-in names; a file that is in use stands among them. Returns the choice, if any."""
    shown = Path(value).name if value not in names else value
    chosen = None
    if imgui.begin_combo(label, shown, imgui.ComboFlags_.height_largest):
        for name in names if value in names else [value, *names]:
            if imgui.selectable(name, name == value)[0] and name != value:
                chosen = name
            if name == value:
                imgui.set_item_default_focus()
        imgui.end_combo()
    return chosen


def buttons(*row: tuple[str, Callable[[], object], bool], small: bool = False) -> None:
    """A row of buttons: label, action, and whether it is enabled, of each."""
    for number, (label, action, enabled) in enumerate(row):
        if number:
            imgui.same_line()
        imgui.begin_disabled(not enabled)
        pressed = (imgui.small_button if small else imgui.button)(label)
        imgui.end_disabled()
        if pressed:
            action()


class Panel:
    """A part of the panels: draws controls, and turns their input into edits."""

    def __init__(self, actions: Actions):
        self.actions, self.session = actions, actions.session
        self.attempt = actions.attempt

    def field(
        self,
        item: Control,
        holder: Any,
        edit: Callable[..., None],
        gesture: str,
        origin: Any = None,
        high: float | None = None,
    ) -> None:
        """The control of a field of `holder`; `edit(gesture, **changes)` applies it.

        origin : the holder that a reset goes back to, if there is one; high : narrows the range
        """
        value = getattr(holder, item.name)
        changed, new = control(item, value, high, self.actions.layout.scale)
        if changed:
            self.attempt(edit, gesture, **{item.name: new})
        first = value if origin is None else getattr(origin, item.name)
        if value != first and reset(item.name):
            self.attempt(edit, None, **{item.name: first})
