"""Files in and out of the window: opened by what they are, saved, copied as a command or a script, and watched."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import glfw
import numpy as np

from ..color import srgb_decode
from ..errors import InputError
from ..fabric import save_fabric
from ..geometry.mesh import load_solid
from ..image import check_output, write_image
from ..scene import Scene, header, load_scene, save_scene
from . import sharing
from .dialogs import Dialogs
from .watch import SHADERS, Watcher

if TYPE_CHECKING:
    from .app import App

OBJECTS = ["Meshes", "*.obj *.ply *.glb *.gltf"]
OPENABLE = [
    "Fabrics, scenes, lights, meshes, environments, pictures",
    "*.toml *.json *.obj *.ply *.glb *.gltf *.hdr *.exr *.png",
]


class Files:
    """What an App reads and writes. Nothing here raises InputError: it becomes a message, and all stays as it was."""

    def __init__(self, app: App, source: str | None = None, watch: bool = False):
        self.app = app
        self.source = source  # the scene's file, if any
        self.dialogs = Dialogs()
        self._watcher = Watcher() if watch else None
        self._later: tuple[Path, bool] | None = None  # a picture to save once it is refined

    @property
    def watching(self) -> bool:
        return self._watcher is not None

    # -- opening -----------------------------------------------------------------------------------------------------

    def open(self, path: str) -> None:
        """Open a file by what it is: scene, picture, fabric, lights, mesh or environment."""
        self.app.attempt(self._open, str(path))

    def choose(self) -> None:
        """Ask for a file in the desktop's dialog and open it; where there is none the field in the panel serves."""
        if not self.dialogs.waiting and not self.dialogs.open("Open", OPENABLE, self.open):
            self.app.tell("note", "no file dialog here (zenity or kdialog): type the path, or drop the file")
            self.app.panels.focus_path()

    def _open(self, path: str) -> None:
        kind = sharing.kind_of(path)
        session = self.app.session
        if kind == "fabric":
            self.app.choose_fabric(path)
        elif kind == "lights":
            session.choose_mode("cloth")
            session.edit_scene(lights=path)
        elif kind == "scene":
            scene = load_scene(path)
            session.open(scene)
            self.source = path
            self.app.follow = False
            if scene.curtain is not None:
                self.app.go_to(frame_of(scene))
        elif kind == "mesh":
            session.choose_mode("cloth")
            session.edit_scene(mesh=path)
        else:
            session.edit_shown(env=path)

    def choose_object(self, path: str = "") -> None:
        """Set a mesh of a path or built-in name beside the cloth; without one ask for it in the desktop's dialog."""
        if path:
            self.app.attempt(self._add_object, path)
        elif not self.dialogs.waiting and not self.dialogs.open("Object", OBJECTS, self.choose_object):
            self.app.tell("note", "no file dialog here (zenity or kdialog): type the path above, then press Object")

    def _add_object(self, path: str) -> None:
        load_solid(path)  # a wrong one is not taken
        session = self.app.session
        session.edit_scene(objects=(*session.scene.objects, path))

    # -- saving ------------------------------------------------------------------------------------------------------

    def save_scene(self, path: str) -> None:
        """Write the scene that is shown to a .toml file."""
        self.app.attempt(self._save_toml, path, lambda target: save_scene(target, self.app.session.shown))

    def save_fabric(self, path: str) -> None:
        """Write the fabric that is shown to a .toml file."""
        self.app.attempt(self._save_toml, path, lambda target: save_fabric(target, self.app.session.fabric))

    def _save_toml(self, path: str, save) -> None:
        target = Path(path.strip()).expanduser()
        if target.suffix != ".toml":
            raise InputError(f"{target}: expected a name that ends in .toml")
        save(target)
        self.app.tell("note", f"wrote {target}")

    def save_picture(self, path: str, panels: bool = False) -> None:
        """Write the picture (.png, .exr) once it is refined, or the window as it is (.png)."""
        self.app.attempt(self._save_picture, path, panels)

    def _save_picture(self, path: str, panels: bool) -> None:
        target = check_output(Path(path.strip()).expanduser())
        if panels and target.suffix.lower() != ".png":
            raise InputError(f"{target}: the window with its panels is saved as .png")
        if self.app.session.in_curtain and self.app.player.playing:
            self.app.toggle_play()
        if self.app.complete:
            self._write(target, panels)
        else:
            self._later = target, panels
            self.app.tell("note", f"{target} will be written as soon as the picture is refined")

    def save_later(self) -> None:
        """The picture is refined: write what waited for that."""
        if self._later is not None:
            later, self._later = self._later, None
            self.app.attempt(self._write, *later)

    def picture(self) -> np.ndarray:
        """What `render` returns for the scene: float32 [H, W, 3 or 4], linear, top row first; once refined."""
        scene = self.app.session.shown
        texture = self.app.drawer.sides[0].texture
        data = np.frombuffer(texture.read(), "f4").reshape(scene.size[1], scene.size[0], 4)[::-1]
        return data.copy() if not getattr(scene, "background", True) else data[..., :3].copy()

    def _write(self, path: Path, panels: bool) -> None:
        scene = self.app.session.shown
        settings = header(sharing.at_frame(scene, self.app.frame))
        if panels:
            write_image(path, srgb_decode(self.app.screen() / 255.0), settings)
        else:
            look = {"exposure": scene.exposure, "view_transform": scene.view_transform}
            write_image(path, self.picture(), settings, **look)
        touched = scene.curtain is not None and self.app.player.touched
        warning = "; wind or cloth changed while it moved: opened again it hangs otherwise" if touched else ""
        self.app.tell("note", f"wrote {path}{warning}")

    def copy_command(self) -> None:
        """Put a command line that renders the picture into the clipboard."""
        self._copy(sharing.as_command(self.app.session.shown, frame=self.app.frame), "a command line")

    def copy_python(self) -> None:
        """Put a Python script that renders the picture into the clipboard."""
        self._copy(sharing.as_python(self.app.session.shown, frame=self.app.frame), "a Python script")

    def _copy(self, text: str, what: str) -> None:
        glfw.set_clipboard_string(self.app.host.window, text)
        self.app.tell("note", f"copied {what}")

    # -- files that change -------------------------------------------------------------------------------------------

    def watch(self) -> None:
        """Read again what has changed on disk."""
        if self._watcher is None:
            return
        session = self.app.session
        shown = session.shown
        names = [getattr(shown, name, None) for name in ("mesh", "env", "lights", "room")]
        names += [*getattr(shown, "objects", ()), self.source, session.chosen]
        for name in self._watcher.changed({n for n in names if isinstance(n, str) and Path(n).is_file()}):
            if name == SHADERS:
                self.app.reload_shaders()
            elif name == session.chosen:
                self.app.attempt(self._reread_fabric, name)
            elif name == self.source:
                self.open(name)
            self.app.look_again()

    def _reread_fabric(self, name: str) -> None:
        self.app.session.reread(name)
        self.app.session.choose_fabric(name)
        self.app.forget()

    def close(self) -> None:
        """Close a dialog that is still open."""
        self.dialogs.close()


def frame_of(scene: Scene) -> int:
    """The frame that a curtain's scene asks for; 0, where its wind begins, when it says none."""
    return scene.frame if "frame" in scene.model_fields_set else 0
