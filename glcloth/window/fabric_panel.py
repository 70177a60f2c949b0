"""The fabric's panel: weave, yarns with their tangent curves, transmission; every control made from its field."""

from __future__ import annotations

from functools import partial

from imgui_bundle import imgui, implot  # isort: skip
import numpy as np

from ..fabric import Fabric, Transmission, Yarn
from . import curve
from .actions import Actions
from .controls import CURVE, controls
from .widgets import CLAMP, GREY, Panel, buttons, chooser, help_text, neat, reset, tip

YARN = [c for c in controls(Yarn) if c.kind != "curve"]
WEAVE = [c for c in controls(Fabric) if c.kind != "text"]
TRANSMISSION = controls(Transmission)
SAMPLES = controls(Yarn, ("samples",))[0]
OTHERS = "all other cloth"
NO_HELP = "light through a fabric that hangs before a light: read by the curtain"


class FabricPanel(Panel):
    """The controls of the fabric that is shown."""

    def __init__(self, actions: Actions):
        super().__init__(actions)
        self._held_end: float | None = None

    def draw(self) -> None:
        """All controls of the fabric."""
        session = self.session
        self._parts()
        fabric, origin = session.fabric, session.origin
        imgui.text_colored(GREY, fabric.name)
        imgui.same_line()
        buttons(("reset all", session.reset_fabric, fabric != origin), small=True)
        if session.in_curtain:
            self._transmission(fabric, origin)
        for item in WEAVE:
            self.field(item, fabric, self._edit, f"weave {item.name}", origin)
        if imgui.begin_tab_bar("yarns"):
            for index, label in enumerate(("Yarn 1 (warp, along u)", "Yarn 2 (weft, along v)")):
                if imgui.begin_tab_item_simple(label):
                    imgui.push_id(index)
                    self._yarn(index, session.fabric.yarn[index], origin.yarn[index])
                    imgui.pop_id()
                    imgui.end_tab_item()
            imgui.end_tab_bar()
        if not session.in_curtain:
            self._transmission(session.fabric, origin)

    def _parts(self) -> None:
        """Which part of the cloth it is the fabric of, where the mesh has several."""
        session = self.session
        parts = [] if session.in_curtain else [*session.scene.fabrics]
        parts += [part for part in self.actions.parts if part not in parts]
        if not parts:
            return
        chosen = chooser("part", session.part or OTHERS, [OTHERS, *parts])
        tip("the fabric below is of this part of the cloth; one that has none of its own gets one to edit")
        if chosen:
            self.attempt(session.choose_part, "" if chosen == OTHERS else chosen)

    def _edit(self, gesture: str | None, **changes) -> None:
        self.session.edit_fabric(self.session.fabric.changed(**changes), gesture)

    # -- transmission ------------------------------------------------------------------------------------------------

    def _transmission(self, fabric: Fabric, origin: Fabric) -> None:
        """Light through the weave: optional for a cloth, needed by the curtain."""
        value = fabric.transmission
        if not self.session.in_curtain:
            changed, has = imgui.checkbox("transmission (for the curtain)", value is not None)
            tip(NO_HELP)
            if changed:
                self.attempt(self._edit, None, transmission=(origin.transmission or Transmission()) if has else None)
        if value is None:
            return
        base = origin.transmission or Transmission()
        imgui.push_id("transmission")
        openness, edit = 1.0 - value.rho, self.session.edit_transmission
        changed, new = imgui.slider_float("openness", openness, 0.0, 1.0, "%.3f", CLAMP)
        tip("share of holes at normal incidence, 1 - rho\n0 to 1; Ctrl+click to type")
        if changed:
            self.attempt(edit, "transmission rho", rho=neat(1.0 - new))
        for item in TRANSMISSION:
            high = 4.0 if item.name == "tau" else None
            self.field(item, self.session.fabric.transmission, edit, f"transmission {item.name}", base, high)
        imgui.pop_id()

    # -- yarns -------------------------------------------------------------------------------------------------------

    def _yarn(self, index: int, yarn: Yarn, origin: Yarn) -> None:
        edit = partial(self.session.edit_yarn, index)
        for item in YARN:
            # The two areas share one: a slider ends where the other yarn begins.
            other = self.session.fabric.yarn[1 - index].area
            high = neat(1.0 - other) if item.name == "area" else None
            self.field(item, yarn, edit, f"yarn {index} {item.name}", origin, high)
        self._curve(index, yarn, origin)

    def _curve(self, index: int, yarn: Yarn, origin: Yarn) -> None:
        """The tangent curve as a plot whose points can be dragged."""
        attempt, edit = self.attempt, self.session.edit_yarn
        free = yarn.tangents_deg is not None
        imgui.text("tangents" if free else "tangent curve")
        if _curve_of(yarn) != _curve_of(origin) and reset("curve"):
            attempt(edit, index, None, **_curve_of(origin))
            return
        self._plot(index, yarn, free)
        row = [("add a point", curve.add), ("remove a point", curve.remove), ("make it a curve", curve.to_curve)]
        for label, change in row if free else row[:2]:
            if imgui.small_button(label):
                attempt(edit, index, None, **change(yarn))
            imgui.same_line()
        imgui.new_line()
        if free:
            return
        changed, new = imgui.slider_int("samples", yarn.samples, int(SAMPLES.low), int(SAMPLES.high), "%d", CLAMP)
        help_text(SAMPLES)
        if changed:
            attempt(edit, index, f"yarn {index} samples", samples=new)
        for i, length in enumerate(yarn.curve_lengths):
            changed, new = imgui.input_float(f"length {i + 1}", length, 0.1, 1.0, "%.2f")
            if changed:
                attempt(edit, index, None, **curve.set_length(yarn, i, neat(new)))

    def _plot(self, index: int, yarn: Yarn, free: bool) -> None:
        place, angles = curve.points(yarn)
        at, tilts = curve.samples(yarn)
        end = max(float(place[-1]), 1e-3)
        flags = implot.Flags_
        size = (imgui.get_content_region_avail().x, 150 * self.actions.layout.scale)
        plain = flags.no_legend | flags.no_mouse_text | flags.no_menus | flags.no_box_select
        if not implot.begin_plot("##curve", size, plain):
            return
        locked = implot.AxisFlags_.lock.value
        implot.setup_axes("number" if free else "along the yarn", "degrees", locked, locked)
        held = self._held_end if self._held_end and imgui.is_mouse_down(0) else end
        self._held_end = held
        margin = 0.04 * held + 1e-3
        implot.setup_axes_limits(-margin, held + 3 * margin, -95.0, 95.0, implot.Cond_.always.value)
        if not free:
            implot.plot_line("curve", np.ascontiguousarray(place), np.ascontiguousarray(angles))
        implot.plot_scatter("samples", np.ascontiguousarray(at), np.ascontiguousarray(tilts))
        for i, (x, y) in enumerate(zip(place, angles, strict=True)):
            moved, x, y, *_ = implot.drag_point(
                i, float(x), float(y), (1.0, 0.75, 0.2, 1.0), 6.0 * self.actions.layout.scale
            )
            if moved:
                self.attempt(self.session.edit_yarn, index, f"yarn {index} curve", **curve.move(yarn, i, x, y))
        implot.end_plot()


def _curve_of(yarn: Yarn) -> dict:
    return {name: getattr(yarn, name) for name in CURVE}
