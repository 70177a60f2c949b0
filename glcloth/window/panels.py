"""The panels beside the picture, and what is written over it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from imgui_bundle import imgui  # isort: skip

from ..color import VIEW_TRANSFORMS
from ..fabric import builtin_fabrics
from ..geometry.mesh_files import BUILTIN_MESHES
from ..light.environment import BUILT_IN_NAMES
from ..light.fit import FABRICS
from ..methods.registry import METHODS
from ..scene import Scene
from .controls import Control, controls, scene_controls
from .curtain_panel import CurtainPanel
from .dialogs import available
from .fabric_panel import FabricPanel
from .widgets import AMBER, CLAMP, GREY, RED, button_if, chooser, control, help_text, neat, tip

if TYPE_CHECKING:
    from .app import App

LIGHT = {
    c.name: c
    for c in controls(Scene, ("lobes", "shadows", "env_rotate", "exposure", "spp", "background", "ground_color"))
}


class Panels:
    """Draws the panels of an App and turns what is done in them into edits of its session."""

    def __init__(self, app: App):
        self.app = app
        self.fabric, self.curtain = FabricPanel(app), CurtainPanel(app)
        self.open_path = ""
        self._focus_path = False
        self.scene_path, self.fabric_path, self.picture_path = "scene.toml", "fabric.toml", "picture.png"
        self.with_panels = False

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
        self._mode()
        in_curtain = self.session.in_curtain
        opened = imgui.TreeNodeFlags_.default_open.value
        if in_curtain and imgui.collapsing_header("Curtain##section", opened):
            self.curtain.draw()
        if not in_curtain and imgui.collapsing_header("Scene", opened):
            self._scene()
        if imgui.collapsing_header("Fabric", opened):
            self.fabric.draw()
        if imgui.collapsing_header("Light", opened):
            self._light()
        if imgui.collapsing_header("View"):
            self._view()
        if imgui.collapsing_header("Compare A and B"):
            self._compare()
        if imgui.collapsing_header("Files"):
            self._files()
        if imgui.collapsing_header("Keys and mouse"):
            self._keys()
        imgui.pop_item_width()
        imgui.end()

    # -- sections ----------------------------------------------------------------------------------------------------

    def _history(self) -> None:
        if button_if("Undo", self.session.can_undo):
            self.app.undo()
        imgui.same_line()
        if button_if("Redo", self.session.can_redo):
            self.app.redo()
        imgui.same_line()
        if imgui.button("Home"):
            self.app.navigation.home()
        imgui.same_line()
        if imgui.button("Frame"):
            self.app.navigation.frame_mesh()
        imgui.same_line()
        if imgui.button("Hide panels"):
            self.app.show_panels = False

    def _mode(self) -> None:
        mode = self.session.document.mode
        for number, (label, name) in enumerate((("Cloth", "cloth"), ("Curtain", "curtain"))):
            if number:
                imgui.same_line()
            if imgui.radio_button(label, mode == name) and mode != name:
                self.session.choose_mode(name)
            tip(("draped under an environment", "in the wind before a window, ray traced")[number])

    def _scene(self) -> None:
        app, session, scene = self.app, self.session, self.session.scene
        origin = session.chosen
        if new := chooser("fabric", origin if isinstance(origin, str) else origin.name, builtin_fabrics()):
            app.attempt(app.choose_fabric, new)
        if new := chooser("mesh", scene.mesh, list(BUILTIN_MESHES)):
            app.attempt(session.edit_scene, mesh=new)
        if new := chooser("environment", scene.env, list(BUILT_IN_NAMES)):
            app.attempt(session.edit_scene, env=new)
        self._open_field()
        self._around(scene)
        if new := chooser("method", scene.method, list(METHODS)):
            app.attempt(session.edit_scene, method=new)
        self._settings(scene, session.edit_scene, "a")
        self._value(LIGHT["spp"])

    def _around(self, scene: Scene) -> None:
        """What stands about the cloth."""
        app, session = self.app, self.session
        changed, on = imgui.checkbox("ground", scene.ground != "off")
        tip("a matt plane under the cloth and the objects")
        if changed:
            app.attempt(session.edit_scene, ground="auto" if on else "off")
        imgui.same_line()
        if imgui.button("Object"):
            app.files.choose_object(str(Path(self.open_path.strip()).expanduser()) if self.open_path.strip() else "")
        tip("sets the mesh of the path above, or a file to be chosen, beside the cloth")
        for number, name in enumerate(scene.objects):
            if imgui.small_button(f"x##object {number}"):
                left = scene.objects[:number] + scene.objects[number + 1 :]
                app.attempt(session.edit_scene, objects=left)
            imgui.same_line()
            imgui.text_colored(GREY, f"object: {Path(name).name}")
        if scene.ground != "off":
            self._value(LIGHT["ground_color"])

    def _settings(self, scene: Scene, edit, key: str) -> None:
        imgui.push_id(key)
        for item in scene_controls(scene.method):
            changed, new = control(item, getattr(scene, item.name))
            if changed:
                self.app.attempt(edit, f"{key} {item.name}", **{item.name: new})
        imgui.pop_id()

    def _value(self, item: Control) -> None:
        changed, new = control(item, getattr(self.session.shown, item.name))
        if changed:
            self.app.attempt(self.session.edit_shown, item.name, **{item.name: new})

    def _view(self) -> None:
        app, shown = self.app, self.session.shown
        self._value(LIGHT["exposure"])
        if new := chooser("view transform", shown.view_transform, list(VIEW_TRANSFORMS)):
            app.attempt(self.session.edit_shown, view_transform=new)
        if not self.session.in_curtain:
            self._value(LIGHT["background"])
        width, height = shown.size
        changed, app.follow = imgui.checkbox(f"size follows the window ({width} x {height})", app.follow)
        if not app.follow:
            changed, new = imgui.input_int2("size", [width, height], imgui.InputTextFlags_.enter_returns_true.value)
            if changed:
                app.attempt(self._set_size, tuple(new))

    def _set_size(self, size: tuple[int, int]) -> None:
        self.session.move(size=self.session.shown.changed(size=size).size)

    def focus_path(self) -> None:
        """Put the caret into the field for a file's path."""
        self.app.show_panels, self._focus_path = True, True

    def _open_field(self) -> None:
        if self._focus_path:
            imgui.set_keyboard_focus_here()
            self._focus_path = False
        enter = imgui.InputTextFlags_.enter_returns_true.value
        done, self.open_path = imgui.input_text_with_hint("##open", "path of a file", self.open_path, enter)
        imgui.same_line()
        if imgui.button("Open") or done:
            if self.open_path.strip():
                self.app.files.open(str(Path(self.open_path.strip()).expanduser()))
            else:
                self.app.files.choose()
        tip(
            "a fabric, scene or lights (.toml .json), a mesh (.obj .glb .ply), an environment (.hdr .exr), a picture of\n"
            "ours (.png .exr); without a path the desktop's dialog asks for one; or drop a file on the window"
        )

    def _light(self) -> None:
        app, session = self.app, self.session
        if session.in_curtain:
            if new := chooser("environment", session.curtain.env, list(BUILT_IN_NAMES)):
                app.attempt(session.edit_curtain, env=new)
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
        if app.ready and app.ready[0] is not None:
            report = app.ready[0].report
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
            self.app.attempt(edit, lobes="auto" if auto else 10)
        if auto:
            return
        item = LIGHT["lobes"]
        shown = scene.lobes if scene.lobes != "auto" else 10
        changed, new = imgui.slider_int("K, Gaussians", shown, int(item.low), int(item.high), "%d", CLAMP)
        help_text(item)
        if changed:
            self.app.attempt(edit, "lobes", lobes=new)

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
        if button_if("Swap A and B", document.shown_other is not None):
            session.swap()
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
                self.app.attempt(session.edit_other, method=new)
            self._settings(other, session.edit_other, "b")
        value = other.fabric if isinstance(other.fabric, str) else other.fabric.name
        if new := chooser("fabric of B", value, builtin_fabrics()):
            self.app.attempt(session.edit_other, fabric=new)

    def _files(self) -> None:
        files = self.app.files
        for name, label, kinds, save in (
            ("scene_path", "Save scene", ["Scene", "*.toml"], files.save_scene),
            ("fabric_path", "Save fabric", ["Fabric", "*.toml"], files.save_fabric),
            ("picture_path", "Save picture", ["Picture", "*.png *.exr"], self._save_picture),
        ):
            self._save_row(name, label, kinds, save)
        _, self.with_panels = imgui.checkbox("with panels (.png)", self.with_panels)
        if imgui.button("Copy command line"):
            files.copy_command()
        imgui.same_line()
        if imgui.button("Copy Python"):
            files.copy_python()

    def _save_row(self, name: str, label: str, kinds: list[str], save: Callable[[str], None]) -> None:
        imgui.push_id(name)
        _, path = imgui.input_text("##path", getattr(self, name))
        setattr(self, name, path)
        imgui.same_line()
        if imgui.button(label):
            save(path)
        if available():
            imgui.same_line()

            def chosen(new: str) -> None:
                setattr(self, name, new)
                save(new)

            if imgui.button("..."):
                self.app.files.dialogs.save(label, path, kinds, chosen)
        imgui.pop_id()

    def _save_picture(self, path: str) -> None:
        self.app.files.save_picture(path, self.with_panels)

    def _keys(self) -> None:
        for keys, what in KEYS:
            imgui.text_colored(GREY, keys)
            imgui.same_line(150 * self.app.scale)
            imgui.text(what)

    # -- over the picture --------------------------------------------------------------------------------------------

    def _overlay(self) -> None:
        app = self.app
        imgui.set_next_window_pos((8 * app.scale, 8 * app.scale))
        imgui.set_next_window_bg_alpha(0.55)
        flags = imgui.WindowFlags_
        imgui.begin(
            "overlay",
            None,
            flags.no_decoration | flags.always_auto_resize | flags.no_inputs | flags.no_nav | flags.no_saved_settings,
        )
        if not app.shows_something:
            imgui.text(app.resources.doing or "starting")
        else:
            for line in self._curtain_lines() if self.session.in_curtain else self._cloth_lines():
                imgui.text(line)
            if app.resources.doing and app.pending:
                imgui.text_colored(AMBER, f"{app.resources.doing} ...")
        imgui.text_colored(GREY, app.ctx.info["GL_RENDERER"])
        if app.host.software:
            imgui.text_colored(AMBER, "software rendering: no GPU driver in use")
        imgui.end()

    def _cloth_lines(self) -> list[str]:
        app, refiner = self.app, self.app.refiner
        share = min((side.share for side in refiner.sides), default=0.0)
        scale = max((side.scale for side in refiner.sides), default=1.0)
        if share >= 1.0:
            state = f"{app.full_ms:.0f} ms, {app.covered} pixels covered" if app.full_ms else "done"
        else:
            state = _refining(share, scale)
        return [f"{app.session.scene.method}: {state}; preview {refiner.preview_ms:.0f} ms"]

    def _curtain_lines(self) -> list[str]:
        player, scene = self.app.player, self.session.curtain
        if player.hung < 1.0:
            return [f"hanging the curtain: {10 * int(10 * player.hung)} %"]
        side, times = player.sides[0], player.timings
        if player.playing:
            rate = f"{1e3 / times.frame:.1f} frames/s" if times.frame else "starting"
            state = f"playing, {rate}, shown at 1/{side.scale:g}"
        elif player.frame < player.wanted:
            state = f"on its way to frame {player.wanted}"
        elif side.share >= 1.0:
            state = "done"
        else:
            state = _refining(side.share, side.scale)
        return [
            f"frame {player.frame}: {state}",
            f"{scene.accelerator}: build {times.build:.0f} ms, trace {times.trace:.0f} ms; simulation {times.simulate:.0f} ms",
        ]

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


def _refining(share: float, scale: float) -> str:
    # In tenths, so that the line stays calm.
    return f"refining {10 * int(10 * share)} %" + (f", shown at 1/{scale:g}" if scale > 1 else "")


KEYS = (
    ("left drag", "orbit"),
    ("middle, Shift+left drag", "pan"),
    ("wheel", "zoom"),
    ("right drag", "turn the environment"),
    ("C", "cloth or curtain"),
    ("Space, Right", "play or pause, one frame on"),
    ("T", "the tree's window"),
    ("F", "frame the cloth"),
    ("Home", "the first view"),
    ("B", "background on or off"),
    ("Tab", "panels on or off"),
    ("Ctrl+Z", "undo"),
    ("Ctrl+Shift+Z, Ctrl+Y", "redo"),
    ("Ctrl+S, Ctrl+O", "save the scene, open a file"),
)
