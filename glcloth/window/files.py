"""Files in and out of the window: opened by kind, saved, copied as a command or a script, and watched."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..color import srgb_decode
from ..errors import InputError
from ..fabric import save_fabric
from ..files import is_file, typed_path
from ..geometry.mesh_files import MESH_SUFFIXES, load_solid
from ..image import check_output, write_image
from ..place import split_place
from ..scene import Scene, header, load_scene, save_scene
from ..weave.others import SUFFIXES
from ..weave.wif import load_draft, save_draft
from . import sharing
from .actions import Actions
from .clock import Clock
from .dialogs import Dialogs
from .watch import SHADERS, Watcher

DRAFTS = ["Drafts", " ".join(f"*{suffix}" for suffix in SUFFIXES)]
MESHES = " ".join(f"*{suffix}" for suffix in MESH_SUFFIXES)
OBJECTS = ["Meshes", MESHES]
OPENABLE = [
    "Fabrics, drafts, scenes, lights, meshes, environments, pictures",
    f"*.toml *.json {DRAFTS[1]} {MESHES} *.hdr *.exr *.png",
]


class Files:
    """The files of the window. Nothing raises InputError: it becomes a message, and all stays as it was.

    `names` are those that scene, fabric and picture are saved to; `asks_path` asks the panels for a path to open.
    """

    def __init__(self, actions: Actions, clock: Clock, source: str | None = None, watch: bool = False):
        self.actions, self.session = actions, actions.session
        self.source = source  # the scene's file, if any
        self.names = {"scene": "scene.toml", "fabric": "fabric.toml", "picture": "picture.png", "draft": "draft.wif"}
        self.asks_path = False
        self.dialogs = Dialogs()
        self._watcher = Watcher(clock) if watch else None
        self._later: tuple[Path, bool] | None = None  # a picture to save once it is refined

    @property
    def watching(self) -> bool:
        return self._watcher is not None

    # -- opening -----------------------------------------------------------------------------------------------------

    def open(self, path: str) -> None:
        """Open a file by its kind: scene, picture, fabric, lights, mesh or environment."""
        self.actions.attempt(self._open, str(path))

    def choose(self) -> None:
        """Ask for a file in the desktop's dialog and open it; where there is none the field in the panel serves."""
        if not self.dialogs.waiting and not self.dialogs.open("Open", OPENABLE, self.open):
            self.actions.note("no file dialog here (zenity or kdialog): type the path, or drop the file")
            self.actions.layout.show_panels = self.asks_path = True

    def _open(self, path: str) -> None:
        path, session = str(typed_path(path)), self.session
        kind = sharing.kind_of(path)
        if kind == "fabric":
            self.actions.choose_fabric(path)
        elif kind == "lights":
            session.choose_mode("cloth")
            session.edit_scene(lights=path)
        elif kind == "scene":
            scene = load_scene(path)
            session.open(scene)
            self.source = path
            self.actions.layout.follow = False
            if scene.curtain is not None:
                self.actions.go_to(frame_of(scene))
        elif kind == "mesh":
            session.choose_mode("cloth")
            session.edit_scene(mesh=path, fabrics={}, prints={}, opacities={}, fabric_mask=None, fabric_masks={})
        else:
            session.edit_shown(env=path)

    def choose_object(self, path: str = "") -> None:
        """Set a mesh of a path or built-in name beside the cloth; without one ask for it in the desktop's dialog."""
        if path:
            self.actions.attempt(self._add_object, path)
        elif not self.dialogs.waiting and not self.dialogs.open("Object", OBJECTS, self.choose_object):
            self.actions.note("no file dialog here (zenity or kdialog): type the path above, then press Object")

    def _add_object(self, path: str) -> None:
        path = str(typed_path(path))
        load_solid(split_place(path)[0])  # a wrong one is not taken
        self.session.edit_scene(objects=(*self.session.scene.objects, path))

    # -- saving ------------------------------------------------------------------------------------------------------

    def save_scene(self, path: str) -> None:
        """Write the scene that is shown to a .toml file."""
        self.actions.attempt(self._save_toml, path, lambda target: save_scene(target, self.session.shown))

    def save_fabric(self, path: str) -> None:
        """Write the fabric that is shown to a .toml file."""
        self.actions.attempt(self._save_toml, path, lambda target: save_fabric(target, self.session.fabric))

    def save_draft(self, path: str) -> None:
        """Write the draft of the fabric that is shown to a .wif file."""
        self.actions.attempt(self._save_draft, path)

    def _save_draft(self, path: str) -> None:
        target, fabric = typed_path(path.strip()), self.session.fabric
        if target.suffix.lower() != ".wif":
            raise InputError(f"{target}: expected a name that ends in .wif")
        if fabric.weave is None:
            raise InputError(f"fabric {fabric.name}: has no [weave], so no draft to save")
        save_draft(target, fabric.weave.as_draft([yarn.albedo for yarn in fabric.yarn]))
        self.actions.note(f"wrote {target}")

    def load_draft(self, path: str) -> None:
        """Weave the fabric that is shown after a draft's file, at its present sett and with its yarns."""
        self.actions.attempt(self._load_draft, path)

    def _load_draft(self, path: str) -> None:
        draft = load_draft(typed_path(path.strip()))
        self.session.take_draft(draft)
        for warning in draft.warnings:
            self.actions.note(f"{Path(path).name}: {warning}")

    def _save_toml(self, path: str, save: Callable[[Path], object]) -> None:
        target = typed_path(path.strip())
        if target.suffix != ".toml":
            raise InputError(f"{target}: expected a name that ends in .toml")
        save(target)
        self.actions.note(f"wrote {target}")

    def save_picture(self, path: str, panels: bool = False) -> None:
        """Write the picture (.png, .exr) once it is refined, or the window as it is (.png)."""
        self.actions.attempt(self._save_picture, path, panels)

    def _save_picture(self, path: str, panels: bool) -> None:
        target = check_output(typed_path(path.strip()))
        if panels and target.suffix.lower() != ".png":
            raise InputError(f"{target}: the window with its panels is saved as .png")
        if self.session.in_curtain and self.actions.player.playing:
            self.actions.toggle_play()
        if self.actions.complete:
            self._write(target, panels)
        else:
            self._later = target, panels
            self.actions.note(f"{target} will be written as soon as the picture is refined")

    def save_later(self) -> None:
        """Write the file that waits for the refined picture, once that is there."""
        if self._later is not None and self.actions.complete:
            later, self._later = self._later, None
            self.actions.attempt(self._write, *later)

    def _write(self, path: Path, panels: bool) -> None:
        scene = self.session.shown
        settings = header(sharing.at_frame(scene, self.actions.frame))
        if panels:
            write_image(path, srgb_decode(self.actions.screen() / 255.0), settings)
        else:
            look = {"exposure": scene.exposure, "view_transform": scene.transform}
            write_image(path, self.actions.picture(), settings, **look)
        touched = scene.curtain is not None and self.actions.player.touched
        warning = "; wind or cloth changed while it moved: opened again it hangs otherwise" if touched else ""
        self.actions.note(f"wrote {path}{warning}")

    def copy_command(self) -> None:
        """Put a command line that renders the picture into the clipboard."""
        self._copy(sharing.as_command(self.session.shown, frame=self.actions.frame), "a command line")

    def copy_python(self) -> None:
        """Put a Python script that renders the picture into the clipboard."""
        self._copy(sharing.as_python(self.session.shown, frame=self.actions.frame), "a Python script")

    def _copy(self, text: str, what: str) -> None:
        self.actions.copy(text)
        self.actions.note(f"copied {what}")

    # -- files that change -------------------------------------------------------------------------------------------

    def watch(self) -> None:
        """Read again the files that have changed on disk."""
        if self._watcher is None:
            return
        session, document = self.session, self.session.document
        names = set[str]().union(*(scene.files() for scene in document.sides()), session.known)
        for name in self._watcher.changed({n for n in (*names, self.source) if n is not None and is_file(n)}):
            if name == SHADERS:
                self.actions.reload_shaders()
            elif name in session.known:
                self.actions.attempt(self._reread_fabric, name)
            elif name == self.source:
                self.open(name)
            self.actions.look_again()

    def _reread_fabric(self, name: str) -> None:
        self.session.reread(name)
        self.actions.look_again(anew=True)

    def close(self) -> None:
        """Close a dialog that is still open."""
        self.dialogs.close()


def frame_of(scene: Scene) -> int:
    """The frame that a curtain's scene asks for; 0, where its wind begins, when it says none."""
    return scene.frame if "frame" in scene.model_fields_set else 0
