"""What a session of the window is about: the scene, what it is compared with, and every edit undone and redone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from ..errors import InputError
from ..fabric import Fabric, load_fabric
from ..scene import Scene, View

Compare = Literal["off", "split", "difference"]
# What B takes from A: the two sides show the same view of the same cloth in the same light.
SHARED = ("mesh", "env", "env_rotate", "size", "exposure", "view_transform", "background", "camera")
# Moving around is no edit: undo leaves the eye where it is.
NAVIGATION = ("camera", "size")


@dataclass(frozen=True)
class Document:
    """One state of a session.

    Parameters
    ----------
    scene : side A; its fabric is a name or a file until something in it is edited, then the Fabric itself
    origin : the fabric that resets go back to, as it was chosen
    other : side B, kept in full; only what is not in SHARED counts
    compare : whether B is shown, and how
    split : where A ends and B begins, 0 to 1 of the picture's width
    difference_scale : brightness of |A - B|
    """

    scene: Scene
    origin: str | Fabric
    other: Scene | None = None
    compare: Compare = "off"
    split: float = 0.5
    difference_scale: float = 8.0

    def sides(self) -> list[Scene]:
        """The scenes to draw: A, and B while it is compared."""
        if self.compare == "off" or self.other is None:
            return [self.scene]
        return [self.scene, self.other.model_copy(update={name: getattr(self.scene, name) for name in SHARED})]


class Session:
    """A document with its history. Every method either succeeds or raises InputError and leaves all as it was."""

    def __init__(self, scene: Scene):
        self.document = Document(scene, scene.fabric)
        self._undo: list[Document] = []
        self._redo: list[Document] = []
        self._gesture: str | None = None
        self._fabrics: dict[str, Fabric] = {}

    # -- reading -----------------------------------------------------------------------------------------------------

    @property
    def scene(self) -> Scene:
        return self.document.scene

    @property
    def fabric(self) -> Fabric:
        """The fabric of side A as it is now."""
        return self.resolve(self.scene.fabric)

    @property
    def origin(self) -> Fabric:
        """The fabric that resets go back to."""
        return self.resolve(self.document.origin)

    def resolve(self, fabric: str | Fabric) -> Fabric:
        """The Fabric of a name or a file, read once."""
        if isinstance(fabric, Fabric):
            return fabric
        if fabric not in self._fabrics:
            self._fabrics[fabric] = load_fabric(fabric)
        return self._fabrics[fabric]

    def reread(self, fabric: str) -> None:
        """Read a fabric's file again. Raises InputError when it cannot be read; what was read before then stays."""
        self._fabrics[fabric] = load_fabric(fabric)

    @property
    def can_undo(self) -> bool:
        return bool(self._undo)

    @property
    def can_redo(self) -> bool:
        return bool(self._redo)

    # -- editing -----------------------------------------------------------------------------------------------------

    def apply(self, document: Document, gesture: str | None = None) -> None:
        """Make `document` the present one. Edits of one gesture (a drag of one control) are one step of undo."""
        if document == self.document:
            return
        if gesture is None or gesture != self._gesture:
            self._undo.append(self.document)
        self._gesture = gesture
        self._redo.clear()
        self.document = document

    def end_gesture(self) -> None:
        """The next edit is a step of its own."""
        self._gesture = None

    def edit_scene(self, gesture: str | None = None, **changes) -> None:
        """Change fields of the scene. Raises InputError for values out of range."""
        self.apply(replace(self.document, scene=self._changed(self.scene, changes)), gesture)

    def edit_other(self, gesture: str | None = None, **changes) -> None:
        """Change fields of side B."""
        other = self._changed(self.document.other or self.scene, changes)
        self.apply(replace(self.document, other=other), gesture)

    @staticmethod
    def _changed(scene: Scene, changes: dict) -> Scene:
        checked = scene.changed(**changes)
        # Only the changed fields are new objects: whoever compares by identity sees what changed and nothing else.
        return scene.model_copy(update={name: getattr(checked, name) for name in changes})

    def choose_fabric(self, fabric: str | Fabric) -> None:
        """Take another fabric; resets go back to it from now on. Raises InputError when it cannot be read."""
        self.resolve(fabric)
        scene = self.scene.model_copy(update={"fabric": fabric})
        self.apply(replace(self.document, scene=scene, origin=fabric))

    def edit_fabric(self, fabric: Fabric, gesture: str | None = None) -> None:
        """Take an edited fabric; one that equals its origin is the origin again."""
        value = self.document.origin if fabric == self.origin else fabric
        self.apply(replace(self.document, scene=self.scene.model_copy(update={"fabric": value})), gesture)

    def edit_yarn(self, index: int, gesture: str | None = None, **changes) -> None:
        """Change fields of one yarn. Raises InputError for values out of range."""
        yarns = list(self.fabric.yarn)
        try:
            yarns[index] = yarns[index].changed(**changes)
        except InputError as error:
            raise InputError(str(error).replace("yarn:", f"yarn {index + 1}:", 1)) from None
        self.edit_fabric(self.fabric.changed(yarn=tuple(yarns)), gesture)

    def reset_fabric(self) -> None:
        """Every parameter of the fabric back to what its origin has."""
        self.edit_fabric(self.origin)

    def compare(self, how: Compare, gesture: str | None = None, **changes) -> None:
        """Show or hide side B; the first time B becomes a copy of A."""
        other = self.document.other if self.document.other is not None or how == "off" else self.scene
        self.apply(replace(self.document, compare=how, other=other, **changes), gesture)

    def keep_as_other(self) -> None:
        """B becomes a copy of A."""
        self.apply(replace(self.document, other=self.scene))

    def swap(self) -> None:
        """A becomes B and B becomes A; the view stays."""
        other = self.document.other
        if other is None:
            return
        kept = {name: getattr(self.scene, name) for name in SHARED}
        scene = other.model_copy(update=kept)
        self.apply(replace(self.document, scene=scene, origin=other.fabric, other=self.scene))

    def open(self, scene: Scene) -> None:
        """Take another scene as a whole. Raises InputError when its fabric cannot be read."""
        self.resolve(scene.fabric)
        self.apply(replace(self.document, scene=scene, origin=scene.fabric))

    def move(self, **changes) -> None:
        """Change camera or size: no step of undo."""
        assert set(changes) <= set(NAVIGATION), changes
        self.document = replace(self.document, scene=self.scene.model_copy(update=changes))

    def look(self, view: View) -> None:
        """Take another camera: no step of undo."""
        self.move(camera=view)

    # -- history -----------------------------------------------------------------------------------------------------

    def undo(self) -> bool:
        """Go back one edit; False when there is none. The eye stays where it is."""
        return self._travel(self._undo, self._redo)

    def redo(self) -> bool:
        """Take back one undo; False when there is none."""
        return self._travel(self._redo, self._undo)

    def _travel(self, source: list[Document], target: list[Document]) -> bool:
        if not source:
            return False
        document, present = source.pop(), self.document
        target.append(present)
        kept = {name: getattr(present.scene, name) for name in NAVIGATION}
        self.document = replace(document, scene=document.scene.model_copy(update=kept))
        self._gesture = None
        return True

    def reject(self) -> None:
        """Take back the last edit because what it asks for cannot be shown; it cannot be redone."""
        if self.undo():
            self._redo.pop()
