"""The panels beside the picture: every control is made from the field it edits."""

from __future__ import annotations

from pathlib import Path

from imgui_bundle import imgui, implot  # isort: skip
import numpy as np

from ..color import VIEW_TRANSFORMS, srgb_decode, srgb_encode
from ..environment import BUILT_IN_NAMES
from ..errors import InputError
from ..fabric import Fabric, Yarn, builtin_fabrics, save_fabric
from ..fit import FABRICS
from ..mesh import BUILTIN_MESHES
from ..renderer import METHODS
from ..scene import Scene, save_scene
from . import curve, sharing
from .controls import Control, controls, scene_controls

YARN = [c for c in controls(Yarn) if c.kind != "curve"]
WEAVE = [c for c in controls(Fabric) if c.kind != "text"]
LIGHT = {c.name: c for c in controls(Scene, ("lobes", "env_rotate", "exposure", "spp", "background"))}
UNITS = {"degrees": "\u00b0", "stops": " stops", "texels": ""}
RED, AMBER, GREY = (1.0, 0.45, 0.4, 1.0), (1.0, 0.8, 0.35, 1.0), (0.62, 0.62, 0.62, 1.0)
CLAMP = imgui.SliderFlags_.always_clamp.value


def neat(value: float) -> float:
    """A slider's float32 as a person would write it."""
    return float(f"{value:.6g}")


class Panels:
    """Draws the panels of an App and turns what is done in them into edits of its session."""

    def __init__(self, app):
        self.app = app
        self.open_path = ""
        self.scene_path, self.fabric_path, self.picture_path = "scene.toml", "fabric.toml", "picture.png"
        self.with_panels = False
        self._other_yarn = 0

    @property
    def session(self):
        return self.app.session

    def draw(self) -> None:
        """All panels of one picture of the window."""
        self._overlay()
        self._messages()
        if not self.app.show_panels:
            return
        io = imgui.get_io()
        width = self.app.panel_width() / io.display_framebuffer_scale.x
        imgui.set_next_window_pos((io.display_size.x - width, 0))
        imgui.set_next_window_size((width, io.display_size.y))
        flags = imgui.WindowFlags_
        fixed = flags.no_move | flags.no_resize | flags.no_collapse | flags.no_title_bar | flags.no_saved_settings
        imgui.begin("panels", None, fixed)
        imgui.push_item_width(0.52 * width)
        self._history()
        opened = imgui.TreeNodeFlags_.default_open.value
        if imgui.collapsing_header("Scene", opened):
            self._scene()
        if imgui.collapsing_header("Fabric", opened):
            self._fabric()
        if imgui.collapsing_header("Light", opened):
            self._light()
        if imgui.collapsing_header("Compare A and B"):
            self._compare()
        if imgui.collapsing_header("Files"):
            self._files()
        if imgui.collapsing_header("Keys and mouse"):
            self._keys()
        imgui.pop_item_width()
        imgui.end()

    # -- one control -------------------------------------------------------------------------------------------------

    def control(self, control: Control, value, high: float | None = None):
        """Draw a control; returns (changed, value). `high` narrows its range."""
        unit = UNITS.get(control.unit, "")
        top = control.high if high is None else high
        label = control.label
        if control.kind == "float":
            digits = "%.1f" if control.unit in ("degrees", "stops") else "%.3f"
            changed, new = imgui.slider_float(label, value, control.low, max(top, control.low), digits + unit, CLAMP)
            new = neat(new)
        elif control.kind == "int":
            changed, new = imgui.slider_int(label, value, int(control.low), int(top), "%d" + unit, CLAMP)
        elif control.kind == "bool":
            changed, new = imgui.checkbox(label, value)
        elif control.kind == "choice":
            changed, at = imgui.combo(label, control.choices.index(value), list(control.choices))
            new = control.choices[at]
        elif control.kind == "color":
            # The picker works on what the screen shows, the sliders on the linear shares.
            code = [float(c) for c in srgb_encode(np.array(value))]
            flags = imgui.ColorEditFlags_
            picked, code = imgui.color_edit3(f"##{label} colour", code, flags.float | flags.no_inputs | flags.no_label)
            self._help(control)
            imgui.same_line()
            imgui.set_next_item_width(imgui.calc_item_width() - 30 * self.app.scale)
            changed, new = imgui.slider_float3(label, [float(v) for v in value], control.low, top, "%.3f", CLAMP)
            new = tuple(neat(v) for v in (srgb_decode(np.clip(code, 0.0, 1.0)) if picked else new))
            changed = changed or picked
        else:
            changed, new = imgui.slider_float3(label, [float(v) for v in value], control.low, top, "%.3f", CLAMP)
            new = tuple(neat(v) for v in new)
        self._help(control)
        return changed, new

    def _help(self, control: Control) -> None:
        if not imgui.is_item_hovered(imgui.HoveredFlags_.delay_short.value):
            return
        parts = [control.help or control.label]
        if control.unit:
            parts.append(f"in {control.unit}")
        if control.low is not None and control.high is not None and control.kind in ("float", "int", "color", "triple"):
            parts.append(f"{control.low:g} to {control.high:g}; Ctrl+click to type")
        imgui.set_tooltip("\n".join(parts))

    def _reset(self, key: str) -> bool:
        imgui.same_line()
        pressed = imgui.small_button(f"reset##{key}")
        if imgui.is_item_hovered(imgui.HoveredFlags_.delay_short.value):
            imgui.set_tooltip("back to what the fabric came with")
        return pressed

    # -- sections ----------------------------------------------------------------------------------------------------

    def _history(self) -> None:
        imgui.begin_disabled(not self.session.can_undo)
        if imgui.button("Undo"):
            self.app.undo()
        imgui.end_disabled()
        imgui.same_line()
        imgui.begin_disabled(not self.session.can_redo)
        if imgui.button("Redo"):
            self.app.redo()
        imgui.end_disabled()
        imgui.same_line()
        if imgui.button("Home"):
            self.app.home()
        imgui.same_line()
        if imgui.button("Frame"):
            self.app.frame_mesh()
        imgui.same_line()
        if imgui.button("Hide panels"):
            self.app.show_panels = False

    def _chooser(self, label: str, value: str, names: list[str]) -> str | None:
        """A list of built-in names; a file that is in use stands among them."""
        shown = Path(value).name if value not in names else value
        chosen = None
        if imgui.begin_combo(label, shown):
            for name in names if value in names else [value, *names]:
                if imgui.selectable(name, name == value)[0] and name != value:
                    chosen = name
            imgui.end_combo()
        return chosen

    def _scene(self) -> None:
        app, scene = self.app, self.session.scene
        origin = self.session.document.origin
        name = origin if isinstance(origin, str) else origin.name
        if new := self._chooser("fabric", name, builtin_fabrics()):
            app.attempt(self.session.choose_fabric, new)
        if new := self._chooser("mesh", scene.mesh, list(BUILTIN_MESHES)):
            app.attempt(self.session.edit_scene, mesh=new)
        if new := self._chooser("environment", scene.env, list(BUILT_IN_NAMES)):
            app.attempt(self.session.edit_scene, env=new)
        self._open_field()
        if new := self._chooser("method", scene.method, list(METHODS)):
            app.attempt(self.session.edit_scene, method=new)
        self._settings(scene, self.session.edit_scene, "a")
        self._value(LIGHT["spp"], "spp")
        changed, new = self.control(LIGHT["exposure"], scene.exposure)
        if changed:
            app.attempt(self.session.edit_scene, "exposure", exposure=new)
        names = list(VIEW_TRANSFORMS)
        changed, at = imgui.combo("view transform", names.index(scene.view_transform), names)
        if changed:
            app.attempt(self.session.edit_scene, view_transform=names[at])
        self._value(LIGHT["background"], "background")
        self._size()

    def _settings(self, scene: Scene, edit, key: str) -> None:
        imgui.push_id(key)
        for control in scene_controls(scene.method):
            changed, new = self.control(control, getattr(scene, control.name))
            if changed:
                self.app.attempt(edit, f"{key} {control.name}", **{control.name: new})
        imgui.pop_id()

    def _value(self, control: Control, gesture: str) -> None:
        changed, new = self.control(control, getattr(self.session.scene, control.name))
        if changed:
            self.app.attempt(self.session.edit_scene, gesture, **{control.name: new})

    def _size(self) -> None:
        app = self.app
        width, height = self.session.scene.size
        changed, app.follow = imgui.checkbox(f"size follows the window ({width} x {height})", app.follow)
        if not app.follow:
            changed, new = imgui.input_int2("size", [width, height], imgui.InputTextFlags_.enter_returns_true.value)
            if changed:
                app.attempt(self._set_size, tuple(new))

    def _set_size(self, size: tuple[int, int]) -> None:
        checked = self.session.scene.changed(size=size).size
        self.session.move(size=checked)

    def _open_field(self) -> None:
        enter = imgui.InputTextFlags_.enter_returns_true.value
        done, self.open_path = imgui.input_text_with_hint(
            "##open", "file: .toml .obj .glb .ply .hdr .exr .png", self.open_path, enter
        )
        imgui.same_line()
        if imgui.button("Open") or done:
            self.app.open(str(Path(self.open_path.strip()).expanduser()))
        if imgui.is_item_hovered(imgui.HoveredFlags_.delay_short.value):
            imgui.set_tooltip(
                "or drop a file on the window: a fabric, a scene, a mesh, an environment, a picture of ours"
            )

    def _fabric(self) -> None:
        session = self.session
        fabric, origin = session.fabric, session.origin
        imgui.text_colored(GREY, fabric.name)
        imgui.begin_disabled(fabric == origin)
        imgui.same_line()
        if imgui.small_button("reset all"):
            session.reset_fabric()
        imgui.end_disabled()
        for control in WEAVE:
            value = getattr(fabric, control.name)
            changed, new = self.control(control, value)
            if changed:
                self._edit_fabric(control.name, f"weave {control.name}", new)
            if value != getattr(origin, control.name) and self._reset(control.name):
                self._edit_fabric(control.name, None, getattr(origin, control.name))
        if imgui.begin_tab_bar("yarns"):
            for index, label in enumerate(("Yarn 1 (warp, along u)", "Yarn 2 (weft, along v)")):
                if imgui.begin_tab_item_simple(label):
                    imgui.push_id(index)
                    self._yarn(index, session.fabric.yarn[index], origin.yarn[index])
                    imgui.pop_id()
                    imgui.end_tab_item()
            imgui.end_tab_bar()

    def _edit_fabric(self, name: str, gesture: str | None, value) -> None:
        def edit():
            self.session.edit_fabric(self.session.fabric.changed(**{name: value}), gesture)

        self.app.attempt(edit)

    def _yarn(self, index: int, yarn: Yarn, origin: Yarn) -> None:
        edit = self.session.edit_yarn
        for control in YARN:
            value = getattr(yarn, control.name)
            # The two areas share one: a slider ends where the other yarn begins.
            other = self.session.fabric.yarn[1 - index].area
            high = neat(1.0 - other) if control.name == "area" else None
            changed, new = self.control(control, value, high)
            if changed:
                self.app.attempt(edit, index, f"yarn {index} {control.name}", **{control.name: new})
            if value != getattr(origin, control.name) and self._reset(control.name):
                self.app.attempt(edit, index, None, **{control.name: getattr(origin, control.name)})
        self._curve(index, yarn, origin)

    def _curve(self, index: int, yarn: Yarn, origin: Yarn) -> None:
        """The tangent curve as a plot whose points can be dragged."""
        app, edit = self.app, self.session.edit_yarn
        free = yarn.tangents_deg is not None
        place, angles = curve.points(yarn)
        at, tilts = curve.samples(yarn)
        end = max(float(place[-1]), 1e-3)
        imgui.text("tangents" if free else "tangent curve")
        if _curve_of(yarn) != _curve_of(origin) and self._reset("curve"):
            app.attempt(edit, index, None, **_curve_of(origin))
            return
        flags = implot.Flags_
        size = (imgui.get_content_region_avail().x, 150 * app.scale)
        if implot.begin_plot(
            "##curve", size, flags.no_legend | flags.no_mouse_text | flags.no_menus | flags.no_box_select
        ):
            locked = implot.AxisFlags_.lock.value
            implot.setup_axes("number" if free else "along the yarn", "degrees", locked, locked)
            held = self._held_end if getattr(self, "_held_end", None) and imgui.is_mouse_down(0) else end
            self._held_end = held
            margin = 0.04 * held + 1e-3
            implot.setup_axes_limits(-margin, held + 3 * margin, -95.0, 95.0, implot.Cond_.always.value)
            if not free:
                implot.plot_line("curve", np.ascontiguousarray(place), np.ascontiguousarray(angles))
            implot.plot_scatter("samples", np.ascontiguousarray(at), np.ascontiguousarray(tilts))
            for i, (x, y) in enumerate(zip(place, angles, strict=True)):
                moved, x, y, *_ = implot.drag_point(i, float(x), float(y), (1.0, 0.75, 0.2, 1.0), 6.0 * app.scale)
                if moved:
                    app.attempt(edit, index, f"yarn {index} curve", **curve.move(yarn, i, x, y))
            implot.end_plot()
        if imgui.small_button("add a point"):
            app.attempt(edit, index, None, **curve.add(yarn))
        imgui.same_line()
        if imgui.small_button("remove a point") and (changes := curve.remove(yarn)):
            app.attempt(edit, index, None, **changes)
        if free:
            imgui.same_line()
            if imgui.small_button("make it a curve"):
                app.attempt(edit, index, None, **curve.to_curve(yarn))
            return
        field = next(c for c in controls(Yarn, ("samples",)))
        changed, new = imgui.slider_int("samples", yarn.samples, int(field.low), int(field.high), "%d", CLAMP)
        self._help(field)
        if changed:
            app.attempt(edit, index, f"yarn {index} samples", samples=new)
        for i, length in enumerate(yarn.curve_lengths):
            changed, new = imgui.input_float(f"length {i + 1}", length, 0.1, 1.0, "%.2f")
            if changed:
                app.attempt(edit, index, None, **curve.set_length(yarn, i, neat(new)))

    def _light(self) -> None:
        app, scene = self.app, self.session.scene
        auto = scene.lobes == "auto"
        changed, auto = imgui.checkbox("K found automatically", auto)
        if changed:
            app.attempt(self.session.edit_scene, lobes="auto" if auto else 10)
        if not auto:
            control = LIGHT["lobes"]
            changed, new = imgui.slider_int(
                "K, Gaussians",
                scene.lobes if scene.lobes != "auto" else 10,
                int(control.low),
                int(control.high),
                "%d",
                CLAMP,
            )
            self._help(control)
            if changed:
                app.attempt(self.session.edit_scene, "lobes", lobes=new)
        self._value(LIGHT["env_rotate"], "turn")
        if app.ready and app.ready[0] is not None:
            report = app.ready[0].report
            origin = self.session.document.origin
            name = origin if isinstance(origin, str) and origin in FABRICS else "generic"
            suns = f", {len(report.lights.suns)} suns ({report.share_of_suns:.0%})" if len(report.lights.suns) else ""
            imgui.text_colored(GREY, f"{report.lobes} Gaussians{suns}; residual {report.residual:.1%}")
            imgui.text_colored(GREY, f"expected error of the light: {report.predicted[name]:.1%} ({name})")

    def _compare(self) -> None:
        session, document = self.session, self.session.document
        for how in ("off", "split", "difference"):
            if imgui.radio_button(how, document.compare == how):
                session.compare(how)
            imgui.same_line()
        imgui.new_line()
        if imgui.button("B = A"):
            session.keep_as_other()
        imgui.same_line()
        imgui.begin_disabled(document.other is None)
        if imgui.button("Swap A and B"):
            session.swap()
        imgui.end_disabled()
        document = session.document
        if document.compare == "split":
            changed, new = imgui.slider_float("split", document.split, 0.0, 1.0, "%.3f", CLAMP)
            if changed:
                session.compare("split", "split", split=neat(new))
        if document.compare == "difference":
            changed, new = imgui.slider_float("|A - B| x", document.difference_scale, 0.5, 64.0, "%.1f", CLAMP)
            if changed:
                session.compare("difference", "scale", difference_scale=neat(new))
        other = document.other
        if document.compare == "off" or other is None:
            return
        imgui.text_colored(GREY, f"B: {session.resolve(other.fabric).name}")
        if new := self._chooser("method of B", other.method, list(METHODS)):
            self.app.attempt(session.edit_other, method=new)
        self._settings(other, session.edit_other, "b")
        value = other.fabric if isinstance(other.fabric, str) else other.fabric.name
        if new := self._chooser("fabric of B", value, builtin_fabrics()):
            self.app.attempt(session.edit_other, fabric=new)

    def _files(self) -> None:
        app, scene = self.app, self.session.scene
        _, self.scene_path = imgui.input_text("##scene", self.scene_path)
        imgui.same_line()
        if imgui.button("Save scene"):
            self.save_scene()
        _, self.fabric_path = imgui.input_text("##fabric", self.fabric_path)
        imgui.same_line()
        if imgui.button("Save fabric"):
            app.attempt(self._save_fabric)
        _, self.picture_path = imgui.input_text("##picture", self.picture_path)
        imgui.same_line()
        if imgui.button("Save picture"):
            app.attempt(app.save_picture, self.picture_path.strip(), self.with_panels)
        _, self.with_panels = imgui.checkbox("with panels (.png)", self.with_panels)
        if imgui.button("Copy command line"):
            app.copy(sharing.as_command(scene), "a command line")
        imgui.same_line()
        if imgui.button("Copy Python"):
            app.copy(sharing.as_python(scene), "a Python script")

    def save_scene(self) -> None:
        """Write the scene to the file named in the panel."""

        def save():
            path = Path(self.scene_path.strip()).expanduser()
            if path.suffix != ".toml":
                raise InputError(f"{path}: expected a name that ends in .toml")
            save_scene(path, self.session.scene)
            self.app.tell("note", f"wrote {path}")

        self.app.attempt(save)

    def _save_fabric(self) -> None:
        path = Path(self.fabric_path.strip()).expanduser()
        if path.suffix != ".toml":
            raise InputError(f"{path}: expected a name that ends in .toml")
        save_fabric(path, self.session.fabric)
        self.app.tell("note", f"wrote {path}")

    def _keys(self) -> None:
        for keys, what in KEYS:
            imgui.text_colored(GREY, keys)
            imgui.same_line(150 * self.app.scale)
            imgui.text(what)

    # -- over the picture --------------------------------------------------------------------------------------------

    def _overlay(self) -> None:
        app = self.app
        refiner = app.refiner
        imgui.set_next_window_pos((8 * app.scale, 8 * app.scale))
        imgui.set_next_window_bg_alpha(0.55)
        flags = imgui.WindowFlags_
        imgui.begin(
            "overlay",
            None,
            flags.no_decoration | flags.always_auto_resize | flags.no_inputs | flags.no_nav | flags.no_saved_settings,
        )
        if not app.frames:
            imgui.text(app.resources.doing or "starting")
        else:
            share = min((side.share for side in refiner.sides), default=0.0)
            scale = max((side.scale for side in refiner.sides), default=1.0)
            if share >= 1.0:
                state = f"{app.full_ms:.0f} ms, {app.covered} pixels covered" if app.full_ms else "done"
            else:
                # In tenths, so that the line stays calm.
                state = f"refining {10 * int(10 * share)} %" + (f", shown at 1/{scale:g}" if scale > 1 else "")
            imgui.text(f"{app.session.scene.method}: {state}; preview {refiner.preview_ms:.0f} ms")
            if app.resources.doing and app.pending:
                imgui.text_colored(AMBER, f"{app.resources.doing} ...")
        imgui.text_colored(GREY, app.ctx.info["GL_RENDERER"])
        if app.software:
            imgui.text_colored(AMBER, "software rendering: no GPU driver in use")
        imgui.end()

    def _messages(self) -> None:
        app = self.app
        if not app.messages:
            return
        io = imgui.get_io()
        flags = imgui.WindowFlags_
        width = io.display_size.x - app.panel_width() / io.display_framebuffer_scale.x
        imgui.set_next_window_pos((8 * app.scale, io.display_size.y - 8 * app.scale), 0, (0.0, 1.0))
        imgui.set_next_window_bg_alpha(0.85)
        imgui.begin(
            "messages", None, flags.no_decoration | flags.always_auto_resize | flags.no_saved_settings | flags.no_nav
        )
        imgui.push_text_wrap_pos(max(width - 60 * app.scale, 100.0))
        for number, (kind, text) in enumerate(list(app.messages)):
            if imgui.small_button(f"x##{number}"):
                app.messages = [m for m in app.messages if m != (kind, text)]
            imgui.same_line()
            imgui.text_colored(RED if kind == "error" else GREY, text)
        imgui.pop_text_wrap_pos()
        imgui.end()


def _curve_of(yarn: Yarn) -> dict:
    return {name: getattr(yarn, name) for name in ("curve_angles_deg", "curve_lengths", "samples", "tangents_deg")}


KEYS = (
    ("left drag", "orbit"),
    ("middle, Shift+left drag", "pan"),
    ("wheel", "zoom"),
    ("right drag", "turn the environment"),
    ("F", "frame the cloth"),
    ("Home", "the first view"),
    ("B", "background on or off"),
    ("Tab", "panels on or off"),
    ("Ctrl+Z", "undo"),
    ("Ctrl+Shift+Z, Ctrl+Y", "redo"),
    ("Ctrl+S", "save the scene"),
)
