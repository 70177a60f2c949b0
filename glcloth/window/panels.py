"""The panels beside the picture, and the text over it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from imgui_bundle import imgui  # isort: skip

from ..color import VIEW_TRANSFORMS
from ..fabric import builtin_fabrics
from ..geometry.mesh_files import BUILTIN_MESHES
from ..light.bands import FABRICS
from ..light.environment import BUILT_IN_NAMES
from ..scene import Scene
from .actions import Actions
from .camera_panel import CameraPanel
from .controls import Control, controls, scene_controls
from .curtain_panel import CurtainPanel
from .dialogs import available
from .fabric_panel import FabricPanel
from .files import Files
from .refine import METHODS
from .thread_counter import pixel_of
from .weave_panel import WeavePanel
from .widgets import AMBER, CLAMP, GREY, RED, Panel, buttons, chooser, help_text, neat, tip

LIGHT = {
    c.name: c
    for c in controls(Scene, ("lobes", "shadows", "env_rotate", "exposure", "spp", "background", "ground_color"))
}
BLACK = (0.0, 0.0, 0.0, 0.8)
_FLAGS = imgui.WindowFlags_
FLOATING = (_FLAGS.no_decoration | _FLAGS.always_auto_resize | _FLAGS.no_nav | _FLAGS.no_saved_settings).value


class Panels(Panel):
    """All of the panels."""

    def __init__(self, actions: Actions, files: Files):
        super().__init__(actions)
        self.files = files
        self.fabric, self.curtain = FabricPanel(actions), CurtainPanel(actions)
        self.weave = WeavePanel(actions, files)
        self.camera = CameraPanel(actions)
        self.open_path = ""
        self.with_panels = False

    def draw(self) -> None:
        """All panels of one picture of the window."""
        self._overlay()
        self._thread_counter()
        self._messages()
        if not self.actions.layout.show_panels:
            return
        io = imgui.get_io()
        width = self.actions.layout.panel_width() / io.display_framebuffer_scale.x
        imgui.set_next_window_pos((io.display_size.x - width, 0))
        imgui.set_next_window_size((width, io.display_size.y))
        flags = imgui.WindowFlags_
        fixed = flags.no_move | flags.no_resize | flags.no_collapse | flags.no_title_bar | flags.no_saved_settings
        imgui.begin("panels", None, fixed)
        imgui.push_item_width(0.52 * width)
        actions, session = self.actions, self.session
        buttons(
            ("Undo", session.undo, session.can_undo),
            ("Redo", session.redo, session.can_redo),
            ("Home", actions.home, True),
            ("Frame", actions.frame_mesh, True),
            ("Hide panels", actions.layout.toggle_panels, True),
        )
        self._mode()
        in_curtain = self.session.in_curtain
        opened = imgui.TreeNodeFlags_.default_open.value
        for title, draw, flags in (
            ("Curtain##section", self.curtain.draw, opened) if in_curtain else ("Scene", self._scene, opened),
            ("Fabric", self.fabric.draw, opened),
            ("Weave", self.weave.draw, 0),
            ("Light", self._light, opened),
            ("View", self._view, 0),
            ("Camera", self.camera.draw, 0),
            ("Compare A and B", self._compare, 0),
            ("Files", self._files, 0),
            ("Keys and mouse", self._keys, 0),
        ):
            if imgui.collapsing_header(title, flags):
                if imgui.is_item_toggled_open():  # what one has just opened is to be seen
                    imgui.set_scroll_here_y(0.0)
                draw()
        imgui.pop_item_width()
        imgui.end()

    # -- sections ----------------------------------------------------------------------------------------------------

    def _mode(self) -> None:
        mode = self.session.document.mode
        for number, (label, name) in enumerate((("Cloth", "cloth"), ("Curtain", "curtain"))):
            if number:
                imgui.same_line()
            if imgui.radio_button(label, mode == name) and mode != name:
                self.session.choose_mode(name)
            tip(("draped under an environment", "in the wind before a window, ray traced")[number])

    def _scene(self) -> None:
        actions, session, scene = self.actions, self.session, self.session.scene
        origin = session.chosen
        if new := chooser("fabric", origin if isinstance(origin, str) else origin.name, builtin_fabrics()):
            self.attempt(actions.choose_fabric, new)
        if new := chooser("mesh", ", ".join(scene.meshes), list(BUILTIN_MESHES)):
            self.attempt(session.edit_scene, mesh=new, fabrics={})
        if new := chooser("environment", scene.env, list(BUILT_IN_NAMES)):
            self.attempt(session.edit_scene, env=new)
        self._open_field()
        self._around(scene)
        if new := chooser("method", scene.method, list(METHODS)):
            self.attempt(session.edit_scene, method=new)
        self._settings(scene, session.edit_scene, "a")
        self._value(LIGHT["spp"])

    def _around(self, scene: Scene) -> None:
        """The ground and the objects."""
        session = self.session
        changed, on = imgui.checkbox("ground", scene.ground != "off")
        tip("a matt plane under the cloth and the objects")
        if changed:
            self.attempt(session.edit_scene, ground="auto" if on else "off")
        if scene.ground in ("auto", "catcher"):
            imgui.same_line()
            changed, only = imgui.checkbox("only its shadow", scene.ground == "catcher")
            tip("of the ground only the shadow is seen, before the environment")
            if changed:
                self.attempt(session.edit_scene, ground="catcher" if only else "auto")
        imgui.same_line()
        if imgui.button("Object"):
            self.files.choose_object(self.open_path.strip())
        tip("sets the mesh of the path above, or a file to be chosen, beside the cloth")
        for number, name in enumerate(scene.objects):
            if imgui.small_button(f"x##object {number}"):
                left = scene.objects[:number] + scene.objects[number + 1 :]
                self.attempt(session.edit_scene, objects=left)
            imgui.same_line()
            imgui.text_colored(GREY, f"object: {Path(name).name}")
        if scene.ground != "off":
            self._value(LIGHT["ground_color"])

    def _settings(self, scene: Scene, edit, key: str) -> None:
        imgui.push_id(key)
        for item in scene_controls(scene.method):
            self.field(item, scene, edit, f"{key} {item.name}")
        imgui.pop_id()

    def _value(self, item: Control) -> None:
        self.field(item, self.session.shown, self.session.edit_shown, item.name)

    def _view(self) -> None:
        layout, shown = self.actions.layout, self.session.shown
        self._value(LIGHT["exposure"])
        if new := chooser("view transform", shown.view_transform, list(VIEW_TRANSFORMS)):
            self.attempt(self.session.edit_shown, view_transform=new)
        if not self.session.in_curtain:
            self._value(LIGHT["background"])
        width, height = shown.size
        _, layout.follow = imgui.checkbox(f"size follows the window ({width} x {height})", layout.follow)
        if not layout.follow:
            changed, new = imgui.input_int2("size", [width, height], imgui.InputTextFlags_.enter_returns_true.value)
            if changed:
                self.attempt(self._set_size, tuple(new))

    def _set_size(self, size: tuple[int, int]) -> None:
        self.session.move(size=self.session.shown.changed(size=size).size)

    def _open_field(self) -> None:
        if self.files.asks_path:
            imgui.set_keyboard_focus_here()
            self.files.asks_path = False
        enter = imgui.InputTextFlags_.enter_returns_true.value
        done, self.open_path = imgui.input_text_with_hint("##open", "path of a file", self.open_path, enter)
        imgui.same_line()
        if imgui.button("Open") or done:
            if self.open_path.strip():
                self.files.open(self.open_path.strip())
            else:
                self.files.choose()
        tip(
            "a fabric, scene or lights (.toml .json), a mesh (.obj .glb .ply), an environment (.hdr .exr), a picture of\n"
            "ours (.png .exr); without a path the desktop's dialog asks for one; or drop a file on the window"
        )

    def _light(self) -> None:
        actions, session = self.actions, self.session
        if session.in_curtain:
            if new := chooser("environment", session.curtain.env, list(BUILT_IN_NAMES)):
                self.attempt(session.edit_curtain, env=new)
            self._open_field()
            self._value(LIGHT["env_rotate"])
            return
        scene = session.scene
        if scene.lights:
            imgui.text_colored(GREY, f"lights: {Path(scene.lights).name}")
            imgui.same_line()
            if imgui.small_button("fit the environment instead"):
                session.edit_scene(lights="")
        else:
            self._lobes(scene)
        self._value(LIGHT["shadows"])
        self._value(LIGHT["env_rotate"])
        if (report := actions.light) is not None:
            origin = session.chosen
            name = origin if isinstance(origin, str) and origin in FABRICS else "generic"
            suns = f", {len(report.lights.suns)} suns ({report.share_of_suns:.0%})" if len(report.lights.suns) else ""
            imgui.text_colored(GREY, f"{report.lobes} Gaussians{suns}; residual {report.residual:.1%}")
            imgui.text_colored(GREY, f"expected error of the light: {report.predicted[name]:.1%} ({name})")

    def _lobes(self, scene: Scene) -> None:
        edit = self.session.edit_scene
        auto = scene.lobes == "auto"
        changed, auto = imgui.checkbox("K found automatically", auto)
        if changed:
            self.attempt(edit, lobes="auto" if auto else 10)
        if auto:
            return
        item = LIGHT["lobes"]
        shown = scene.lobes if scene.lobes != "auto" else 10
        changed, new = imgui.slider_int("K, Gaussians", shown, int(item.low), int(item.high), "%d", CLAMP)
        help_text(item)
        if changed:
            self.attempt(edit, "lobes", lobes=new)

    def _compare(self) -> None:
        session, document = self.session, self.session.document
        for how in ("off", "split", "difference"):
            if imgui.radio_button(how, document.compare == how):
                session.compare(how)
            imgui.same_line()
        imgui.new_line()
        there = document.shown_other is not None
        buttons(("B = A", session.keep_as_other, True), ("Swap A and B", session.swap, there))
        document = session.document
        if document.compare == "split":
            changed, new = imgui.slider_float("split at", document.split, 0.0, 1.0, "%.3f", CLAMP)
            if changed:
                session.compare("split", "split", split=neat(new))
        if document.compare == "difference":
            changed, new = imgui.slider_float("|A - B| x", document.difference_scale, 0.5, 64.0, "%.1f", CLAMP)
            if changed:
                session.compare("difference", "scale", difference_scale=neat(new))
        other = session.document.shown_other
        if document.compare == "off" or other is None:
            return
        imgui.text_colored(GREY, f"B: {session.resolve(other.fabric).name}")
        if session.in_curtain:
            self.curtain.other(other)
        else:
            if new := chooser("method of B", other.method, list(METHODS)):
                self.attempt(session.edit_other, method=new)
            self._settings(other, session.edit_other, "b")
        value = other.fabric if isinstance(other.fabric, str) else other.fabric.name
        if new := chooser("fabric of B", value, builtin_fabrics()):
            self.attempt(session.edit_other, fabric=new)

    def _files(self) -> None:
        files = self.files
        for name, kinds, save in (
            ("scene", ["Scene", "*.toml"], files.save_scene),
            ("fabric", ["Fabric", "*.toml"], files.save_fabric),
            ("picture", ["Picture", "*.png *.exr"], lambda path: files.save_picture(path, self.with_panels)),
        ):
            self._save_row(name, kinds, save)
        _, self.with_panels = imgui.checkbox("with panels (.png)", self.with_panels)
        buttons(("Copy command line", files.copy_command, True), ("Copy Python", files.copy_python, True))

    def _save_row(self, name: str, kinds: list[str], save: Callable[[str], None]) -> None:
        names, label = self.files.names, f"Save {name}"
        imgui.push_id(name)
        _, names[name] = imgui.input_text("##path", names[name])
        imgui.same_line()
        if imgui.button(label):
            save(names[name])
        if available():
            imgui.same_line()

            def chosen(new: str) -> None:
                names[name] = new
                save(new)

            if imgui.button("..."):
                self.files.dialogs.save(label, names[name], kinds, chosen)
        imgui.pop_id()

    def _keys(self) -> None:
        for keys, what in KEYS:
            imgui.text_colored(GREY, keys)
            imgui.same_line(150 * self.actions.layout.scale)
            imgui.text(what)

    # -- over the picture --------------------------------------------------------------------------------------------

    def _overlay(self) -> None:
        actions, scale = self.actions, self.actions.layout.scale
        imgui.set_next_window_pos((8 * scale, 8 * scale))
        imgui.set_next_window_bg_alpha(0.55)
        imgui.begin("overlay", None, FLOATING | imgui.WindowFlags_.no_inputs.value)
        if not actions.shows_something:
            imgui.text(actions.waits_for or "starting")
        else:
            for line in actions.status:
                imgui.text(line)
            if actions.waits_for:
                imgui.text_colored(AMBER, f"{actions.waits_for} ...")
        name, software = actions.device
        imgui.text_colored(GREY, name)
        if software:
            imgui.text_colored(AMBER, "software rendering: no GPU driver in use")
        imgui.end()

    def _thread_counter(self) -> None:
        """While N is held: a square centimetre of the cloth under the pointer, with its millimetres."""
        io = imgui.get_io()
        if io.want_text_input or io.want_capture_mouse or not imgui.is_key_down(imgui.Key.n):
            return
        actions, shown = self.actions, self.session.shown
        left, _, width, height = actions.layout.rectangle()
        unit = io.display_framebuffer_scale.x
        # The picture may be shown smaller than it is; its rectangle counts from below.
        top = io.display_size.y * unit - actions.layout.rectangle()[1] - height
        factor = width / shown.size[0]
        glass = actions.glass((io.mouse_pos.x * unit - left) / factor, (io.mouse_pos.y * unit - top) / factor)
        draw = imgui.get_foreground_draw_list()
        weave = self.session.fabric.weave
        text = "1 cm" if weave is None else f"1 cm: {weave.ends_per_cm:.4g} ends x {weave.picks_per_cm:.4g} picks"
        if glass is None:
            text = "no cloth here"
        for a, b in glass.lines() if glass is not None else ():
            ends = [pixel_of(actions.camera, shown.size, point) for point in (a, b)]
            if None in ends:
                continue
            (x0, y0), (x1, y1) = (((left + factor * x) / unit, (top + factor * y) / unit) for x, y in ends)
            for color, thick in ((BLACK, 3.0), (AMBER, 1.0)):
                code = imgui.color_convert_float4_to_u32(color)
                draw.add_line((x0, y0), (x1, y1), code, thick * actions.layout.scale)
        place = io.mouse_pos.x + 14 * actions.layout.scale, io.mouse_pos.y + 14 * actions.layout.scale
        size = imgui.calc_text_size(text)
        code = imgui.color_convert_float4_to_u32
        draw.add_rect_filled(place, (place[0] + size.x + 8, place[1] + size.y + 4), code((0.0, 0.0, 0.0, 0.7)))
        draw.add_text((place[0] + 4, place[1] + 2), code(AMBER), text)

    def _messages(self) -> None:
        layout, messages = self.actions.layout, self.actions.messages
        if not messages.lines:
            return
        io = imgui.get_io()
        width = io.display_size.x - layout.panel_width() / io.display_framebuffer_scale.x
        imgui.set_next_window_pos((8 * layout.scale, io.display_size.y - 8 * layout.scale), 0, (0.0, 1.0))
        imgui.set_next_window_bg_alpha(0.85)
        imgui.begin("messages", None, FLOATING)
        imgui.push_text_wrap_pos(max(width - 60 * layout.scale, 100.0))
        for number, (kind, text) in enumerate(messages.lines):
            if imgui.small_button(f"x##{number}"):
                messages.close((kind, text))
            imgui.same_line()
            imgui.text_colored(RED if kind == "error" else GREY, text)
        imgui.pop_text_wrap_pos()
        imgui.end()


KEYS = (
    ("left drag", "orbit"),
    ("left click", "edit the fabric of the part that is there"),
    ("middle, Shift+left drag", "pan"),
    ("wheel", "zoom"),
    ("right drag", "turn the environment"),
    ("C", "cloth or curtain"),
    ("Space, Right", "play or pause, one frame on"),
    ("T", "the tree's window"),
    ("hold N", "thread counter: 1 cm of the cloth under the pointer"),
    ("F", "frame the cloth"),
    ("Home", "the first view"),
    ("B", "background on or off"),
    ("Ctrl+1..9, 1..9", "keep this view, go to it"),
    ("Tab", "panels on or off"),
    ("Ctrl+Z", "undo"),
    ("Ctrl+Shift+Z, Ctrl+Y", "redo"),
    ("Ctrl+S, Ctrl+O", "save the scene, open a file"),
)
