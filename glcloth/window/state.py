"""A session of the window: the scene, side B of the comparison, and every edit undone and redone."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

from ..errors import InputError
from ..fabric import Fabric, Transmission, load_fabric
from ..scene import CurtainParameters, Scene, View
from ..weave.draft import Draft
from ..weave.model import Weave
from ..weave.named import named_draft

Compare = Literal["off", "split", "difference"]
Mode = Literal["cloth", "curtain"]
# Fields that B takes from A: the two sides show the same view of the same cloth in the same light.
SHARED = (
    "mesh",
    "subdivide",
    "fabrics",
    "print",
    "prints",
    "opacity",
    "opacities",
    "fabric_mask",
    "fabric_masks",
    "units",
    "objects",
    "ground",
    "ground_color",
    "env",
    "env_rotate",
    "size",
    "exposure",
    "view_transform",
    "ocio",
    "display",
    "ocio_view",
    "background",
    "camera",
    "bookmarks",
)
# Fields that B of the curtain has of its own: it is the same curtain, at the same moment, in the same light.
OWN = ("fabric", "accelerator", "depth", "spread")
MOST_STEPS = 1000  # of undo that are kept
# Moving around is no edit: undo leaves the eye where it is.
NAVIGATION = ("camera", "size")
_CURTAIN = Scene(curtain=CurtainParameters())


@dataclass(frozen=True)
class Document:
    """One state of a session.

    Parameters
    ----------
    scene : side A; its fabric is a name or a file until something in it is edited, then the Fabric itself
    origin : the fabric that resets go back to, as it was chosen
    origins : likewise those of the parts that have fabrics of their own
    other : side B, kept in full; only fields outside SHARED count
    compare : whether B is shown, and how
    split : where A ends and B begins, 0 to 1 of the picture's width
    difference_scale : brightness of |A - B|
    mode : which of the two scenes is shown, `scene` or `curtain`
    curtain, curtain_origin : the curtain, and its fabric as it was chosen
    curtain_other : side B of the curtain, kept in full; only the fields in OWN count
    layered : whether B of the curtain is drawn as blended layers without shadows, and not traced
    """

    scene: Scene
    origin: str | Fabric
    other: Scene | None = None
    compare: Compare = "off"
    split: float = 0.5
    difference_scale: float = 8.0
    mode: Mode = "cloth"
    curtain: Scene = _CURTAIN
    curtain_origin: str | Fabric = _CURTAIN.fabric
    curtain_other: Scene | None = None
    layered: bool = False
    origins: dict[str, str | Fabric] = field(default_factory=dict)

    @property
    def shown(self) -> Scene:
        """The scene that is shown."""
        return self.scene if self.mode == "cloth" else self.curtain

    @property
    def shown_other(self) -> Scene | None:
        """Side B of the scene that is shown."""
        return self.other if self.mode == "cloth" else self.curtain_other

    def sides(self) -> list[Scene]:
        """The scenes to draw: A, and B while it is compared."""
        a, b = self.shown, self.shown_other
        if self.compare == "off" or b is None:
            return [a]
        if self.mode == "curtain":
            return [a, a.model_copy(update={name: getattr(b, name) for name in OWN})]
        return [a, b.model_copy(update={name: getattr(a, name) for name in SHARED})]


class Session:
    """A document with its history. Every method either succeeds or raises InputError and leaves all as it was."""

    def __init__(self, scene: Scene):
        if scene.curtain is None:
            self.document = Document(scene, scene.fabric, origins=dict(scene.fabrics))
        else:
            cloth = Scene()
            self.document = Document(cloth, cloth.fabric, mode="curtain", curtain=scene, curtain_origin=scene.fabric)
        self._undo: list[Document] = []
        self._redo: list[Document] = []
        self._gesture: str | None = None
        self._part = ""
        self._picked: tuple = ()  # a part without a fabric of its own that is edited, and the mesh it is of
        self._fabrics: dict[str, Fabric] = {}

    # -- reading -----------------------------------------------------------------------------------------------------

    @property
    def scene(self) -> Scene:
        """The cloth's scene, side A."""
        return self.document.scene

    @property
    def curtain(self) -> Scene:
        return self.document.curtain

    @property
    def shown(self) -> Scene:
        """The scene that is shown."""
        return self.document.shown

    @property
    def in_curtain(self) -> bool:
        return self.document.mode == "curtain"

    @property
    def fabric(self) -> Fabric:
        """The fabric of the scene that is shown (side A) as it is now: that of the part that is edited."""
        return self.resolve(self.scene.fabrics.get(self.part, self.scene.fabric) if self.part else self.shown.fabric)

    @property
    def part(self) -> str:
        """The part whose fabric is edited, a key of the scene's `fabrics` or to be one; "": all cloth that has none of its
        own."""
        known = self._part in self.scene.fabrics or self._picked == (self._part, self.scene.mesh)
        return self._part if known and not self.in_curtain else ""

    @property
    def chosen(self) -> str | Fabric:
        """The fabric that resets go back to, as it was chosen."""
        if self.part:
            return self.document.origins.get(self.part, self.scene.fabrics.get(self.part, self.document.origin))
        return self.document.curtain_origin if self.in_curtain else self.document.origin

    @property
    def origin(self) -> Fabric:
        """The fabric that resets go back to."""
        return self.resolve(self.chosen)

    def resolve(self, fabric: str | Fabric) -> Fabric:
        """The Fabric of a name or a file, read once."""
        if isinstance(fabric, Fabric):
            return fabric
        if fabric not in self._fabrics:
            self._fabrics[fabric] = load_fabric(fabric)
        return self._fabrics[fabric]

    @property
    def known(self) -> set[str]:
        """The names and files of the fabrics that are worn, or that resets go back to."""
        document = self.document
        worn = [document.origin, document.curtain_origin, *document.origins.values()]
        for scene in document.sides():
            worn += [scene.fabric, *scene.fabrics.values()]
        return {fabric for fabric in worn if isinstance(fabric, str)}

    def reread(self, fabric: str) -> None:
        """Read a fabric's file again; what goes back to it by a reset is that file again. Raises InputError when it cannot be
        read; the last one then stays."""
        self._fabrics[fabric] = load_fabric(fabric)
        document = self.document
        parts = {part: fabric for part in document.scene.fabrics if document.origins.get(part) == fabric}
        changes: dict = {"fabrics": {**document.scene.fabrics, **parts}} if parts else {}
        if document.origin == fabric:
            changes["fabric"] = fabric
        scene = document.scene.model_copy(update=changes) if changes else document.scene
        curtain = document.curtain
        if document.curtain_origin == fabric:
            curtain = curtain.model_copy(update={"fabric": self._hangable(fabric)})
        self.apply(replace(document, scene=scene, curtain=curtain))

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
            self._undo = [*self._undo[1 - MOST_STEPS :], self.document]
        self._gesture = gesture
        self._redo.clear()
        self.document = document

    def end_gesture(self) -> None:
        """The next edit is a step of its own."""
        self._gesture = None

    def edit_scene(self, gesture: str | None = None, **changes) -> None:
        """Change fields of the scene. Raises InputError for values out of range."""
        self.apply(replace(self.document, scene=self._changed(self.scene, changes)), gesture)

    def edit_curtain(self, gesture: str | None = None, **changes) -> None:
        """Change fields of the curtain's scene. Raises InputError for values out of range."""
        self.apply(replace(self.document, curtain=self._changed(self.curtain, changes)), gesture)

    def hang(self, gesture: str | None = None, **changes) -> None:
        """Change parameters of the curtain itself, wind and stiffness among them. Raises InputError."""
        try:
            parameters = self.curtain.curtain.changed(**changes)
        except InputError as error:
            raise InputError(str(error).removeprefix("curtain: ")) from None
        self.edit_curtain(gesture, curtain=parameters)

    def edit_shown(self, gesture: str | None = None, **changes) -> None:
        """Change fields that both kinds of scene have."""
        (self.edit_curtain if self.in_curtain else self.edit_scene)(gesture, **changes)

    def choose_mode(self, mode: Mode) -> None:
        """Show the cloth or the curtain."""
        self.apply(replace(self.document, mode=mode))

    def edit_other(self, gesture: str | None = None, **changes) -> None:
        """Change fields of side B. Raises InputError for values out of range."""
        if self.in_curtain and "fabric" in changes:
            changes["fabric"] = self._hangable(changes["fabric"])
        other = self._changed(self.document.shown_other or self.shown, changes)
        self.apply(self._with_other(other), gesture)

    def _with_other(self, other: Scene, **changes) -> Document:
        """The document with another side B."""
        return replace(self.document, **{"curtain_other" if self.in_curtain else "other": other}, **changes)

    def _hangable(self, fabric: str | Fabric) -> str | Fabric:
        """A fabric that the ray tracer can take: one without transmission gets a white sheer's."""
        value = self.resolve(fabric)
        return fabric if value.transmission is not None else value.changed(transmission=Transmission())

    @staticmethod
    def _changed(scene, changes: dict):
        checked = scene.changed(**changes)
        # Only the changed fields are new objects: comparing by identity shows the changes and nothing else.
        return scene.model_copy(update={name: getattr(checked, name) for name in changes})

    def choose_fabric(self, fabric: str | Fabric) -> None:
        """Take another fabric; resets go back to it from now on. Raises InputError when it cannot be read.

        In the curtain a fabric without transmission gets a white sheer's.
        """
        self.resolve(fabric)
        if self.in_curtain:
            fabric = self._hangable(fabric)
        self._take_fabric(fabric, origin=fabric)

    def choose_part(self, part: str) -> None:
        """Edit the fabric of a part from now on, "" for all other cloth; a part that has none of its own gets that one."""
        self.end_gesture()
        self._part = part
        if part and part not in self.scene.fabrics:
            self.apply(self._dressed(part, self.scene.fabric, origin=self.document.origin))

    def pick_part(self, part: str) -> None:
        """As `choose_part`, but a part that has no fabric of its own gets one only when that is edited."""
        self.end_gesture()
        self._part, self._picked = part, (part, self.scene.mesh)

    def _dressed(self, part: str, fabric: str | Fabric, **origin) -> Document:
        """The document with another fabric for a part."""
        scene = self._changed(self.scene, {"fabrics": {**self.scene.fabrics, part: fabric}})
        chosen = {"origins": {**self.document.origins, part: origin["origin"]}} if origin else {}
        return replace(self.document, scene=scene, **chosen)

    def edit_fabric(self, fabric: Fabric, gesture: str | None = None) -> None:
        """Take an edited fabric; one that equals its origin is the origin again."""
        if self.in_curtain and fabric.transmission is None:
            raise InputError("the curtain's fabric needs its transmission, which the ray tracer reads")
        self._take_fabric(self.chosen if fabric == self.origin else fabric, gesture)

    def _take_fabric(self, fabric: str | Fabric, gesture: str | None = None, **origin) -> None:
        name = "curtain" if self.in_curtain else "scene"
        if self.part:
            if self.part not in self.scene.fabrics and not origin:
                origin = {"origin": self.document.origin}
            self.apply(self._dressed(self.part, fabric, **origin), gesture)
            return
        scene = self.shown.model_copy(update={"fabric": fabric})
        if self.in_curtain and origin:
            origin = {"curtain_origin": origin["origin"]}
        self.apply(replace(self.document, **{name: scene}, **origin), gesture)

    def edit_transmission(self, gesture: str | None = None, **changes) -> None:
        """Change fields of the fabric's transmission. Raises InputError for values out of range."""
        value = (self.fabric.transmission or Transmission()).changed(**changes)
        self.edit_fabric(self.fabric.changed(transmission=value), gesture)

    def edit_yarn(self, index: int, gesture: str | None = None, **changes) -> None:
        """Change fields of one yarn. Raises InputError for values out of range."""
        yarns = list(self.fabric.yarn)
        try:
            yarns[index] = yarns[index].changed(**changes)
        except InputError as error:
            raise InputError(str(error).replace("yarn:", f"yarn {index + 1}:", 1)) from None
        self.edit_fabric(self.fabric.changed(yarn=tuple(yarns)), gesture)

    def edit_weave(self, gesture: str | None = None, **changes) -> None:
        """Change fields of the fabric's weave. Raises InputError for values out of range, or where there is none."""
        weave = self.fabric.weave
        if weave is None:
            raise InputError(f"fabric {self.fabric.name}: has no [weave] to change; give it one")
        self.edit_fabric(self.fabric.changed(weave=weave.changed(**changes)), gesture)

    def choose_weave(self, name: str) -> None:
        """Weave after a named draft, in its colours if it has some."""
        self.take_draft(named_draft(name), name)

    def take_draft(self, draft: Draft, name: str = "") -> None:
        """Weave after a draft, at the present sett and with the present yarns; in its colours if it has some.

        `name` : the named weave that it is, so that files say the name.
        """
        weave = self.fabric.weave
        colors = "draft" if draft.has_colors else "yarn" if weave is None or weave.colors == "draft" else weave.colors
        stripes = {} if colors == "stripes" else {"warp_stripes": None, "weft_stripes": None}
        if weave is None:
            self.give_weave({"draft": name or draft, "far": "yarns", "colors": colors})
        else:
            self.edit_weave(draft=name or draft, colors=colors, **stripes)

    def give_weave(self, table: dict) -> None:
        """Give a fabric that has no weave one. Raises InputError."""
        self.edit_fabric(self.fabric.changed(weave=Weave.parse(table, "weave")))

    def reset_fabric(self) -> None:
        """Every parameter of the fabric back to its origin's."""
        self.edit_fabric(self.origin)

    def compare(self, how: Compare, gesture: str | None = None, **changes) -> None:
        """Show or hide side B; the first time B becomes a copy of A."""
        other = self.document.shown_other
        self.apply(
            self._with_other(self.shown if other is None and how != "off" else other, compare=how, **changes), gesture
        )

    def keep_as_other(self) -> None:
        """B becomes a copy of A."""
        self.apply(self._with_other(self.shown))

    def draw_other(self, layered: bool) -> None:
        """Draw side B of the curtain as blended layers, or trace it."""
        self.apply(replace(self.document, layered=layered))

    def swap(self) -> None:
        """A becomes B and B becomes A; shared fields stay."""
        other = self.document.shown_other
        if other is None:
            return
        scene = replace(self.document, compare="split").sides()[1]
        names = ("curtain", "curtain_origin") if self.in_curtain else ("scene", "origin")
        self.apply(self._with_other(self.shown, **dict(zip(names, (scene, other.fabric), strict=True))))

    def open(self, scene: Scene) -> None:
        """Take another scene as a whole and show it. Raises InputError when its fabric cannot be read or does not serve."""
        fabric = self.resolve(scene.fabric)
        if scene.curtain is None:
            origins = dict(scene.fabrics)
            self.apply(replace(self.document, scene=scene, origin=scene.fabric, origins=origins, mode="cloth"))
            return
        if fabric.transmission is None:
            raise InputError(f"fabric {fabric.name}: has no [transmission], which the curtain needs; add the table")
        self.apply(replace(self.document, curtain=scene, curtain_origin=scene.fabric, mode="curtain"))

    def move(self, **changes) -> None:
        """Change camera or size of the shown scene: no step of undo."""
        assert set(changes) <= set(NAVIGATION), changes
        name = "curtain" if self.in_curtain else "scene"
        self.document = replace(self.document, **{name: self.shown.model_copy(update=changes)})

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
        self.document = replace(
            document,
            scene=_seen_from(document.scene, present.scene),
            curtain=_seen_from(document.curtain, present.curtain),
        )
        self._gesture = None
        return True

    def reject(self) -> None:
        """Take back the last edit because its result cannot be shown; it cannot be redone."""
        if self.undo():
            self._redo.pop()


def _seen_from(scene, present):
    """A scene of the past with the camera and the size of the present one."""
    kept = {name: getattr(present, name) for name in NAVIGATION}
    return scene if all(getattr(scene, n) == v for n, v in kept.items()) else scene.model_copy(update=kept)
