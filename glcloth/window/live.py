"""A session without a display: one thread draws it, others ask for its picture and edit it.

The thread in `run` alone touches OpenGL and the session. Others hand it their wishes by `ask` and wait for the answer.
"""

from __future__ import annotations

import io
import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from PIL import Image

from ..color import view
from ..errors import InputError, ShaderError, one_line
from ..fabric import Fabric, builtin_fabrics
from ..fields import Entry, Value
from ..gpu.context import create_context
from ..scene import Scene, View
from . import orbit
from .clock import now
from .controls import controls
from .refine import Refiner
from .resources import Resources
from .slices import BUDGET
from .state import Document, Session

T = TypeVar("T")
SCENE = ("env", "env_rotate", "exposure", "view_transform", "quality", "shadows", "background")
BACKDROP = 0.05  # linear grey where there is no background
EVERY = 0.12  # seconds between two pictures that are being refined


@dataclass(frozen=True)
class Shown:
    """A picture as it is sent: JPEG, its number, whether it is complete, and the last message."""

    version: int
    jpeg: bytes
    complete: bool
    message: str


class Live:
    """Draws a scene of cloth while others edit it.

    Parameters
    ----------
    scene : the first to show
    device : EGL device, as for Renderer

    Raises InputError for a curtain, and for a fabric that cannot be read.
    """

    def __init__(self, scene: Scene, device: int | str | None = None):
        if scene.curtain is not None:
            raise InputError(
                "the curtain moves in the window and in films: glcloth view curtain, glcloth animate curtain"
            )
        self.session, self._device = Session(scene), device
        self.session.resolve(scene.fabric)
        self._wishes: queue.Queue[tuple[Future, Callable[[], Any]] | None] = queue.Queue()
        self._news = threading.Condition()
        self._shown = Shown(0, b"", False, "")
        self._message = ""
        self.status = "beginning"  # how far it is, in words
        self.fault = ""  # what ended the drawing, if it was not `close`
        names = builtin_fabrics()
        first = scene.fabric if isinstance(scene.fabric, str) else scene.fabric.name
        if not isinstance(scene.fabric, str) and first in names:
            first = f"{first}, own"
        self._fabrics = {first: scene.fabric} | {name: name for name in names}  # those to choose from
        self._document: Document | None = None
        self._pending, self._closed, self._ended = True, False, False
        self._sent, self._unsent = 0.0, False

    # -- for other threads -------------------------------------------------------------------------------------------

    def ask(self, wish: Callable[[], T]) -> T:
        """Have the drawing thread do something with the session; its result, or its error. Raises InputError once closed."""
        if self._closed:
            raise InputError(self.ending)
        future: Future = Future()
        self._wishes.put((future, wish))
        while True:
            try:
                return future.result(1.0)
            except TimeoutError:
                if self._ended:
                    raise InputError(self.ending) from None

    @property
    def closed(self) -> bool:
        """Whether nothing will be drawn any more."""
        return self._closed

    @property
    def ending(self) -> str:
        """Why nothing is drawn any more."""
        return self.fault or "this view is closed; open another"

    def picture(self, after: int = 0, patience: float | None = None) -> Shown:
        """The present picture, once it is newer than number `after`; the old one after `patience` seconds: by default soon
        while something is on its way, so that others can say how far it is."""
        with self._news:
            if patience is None:
                patience = 20.0 if self._shown.complete else 1.0
            self._news.wait_for(lambda: self._shown.version > after or self._closed, patience)
            return self._shown

    def close(self) -> None:
        """End the drawing."""
        self._closed = True
        self._wishes.put(None)
        with self._news:
            self._news.notify_all()

    # -- what the others ask for -------------------------------------------------------------------------------------

    def groups(self) -> dict[str, tuple[Value, list[Entry]]]:
        """Names of groups of controls, each with the value that it edits and its fields."""
        fabric = self.session.fabric
        weave = fabric.weave
        follows = set()
        if weave is not None:
            follows = {"area"} if weave.far == "weave" else set()
            follows |= {"albedo"} if weave.colors != "yarn" else set()
        yarn = [c for c in controls(type(fabric.yarn[0])) if c.kind not in ("curve", "text") and c.name not in follows]
        found: dict[str, tuple[Value, list[Entry]]] = {
            "scene": (self.session.scene, controls(Scene, SCENE)),
            "fabric": (fabric, [c for c in controls(Fabric) if c.kind != "text"]),
            "warp": (fabric.yarn[0], yarn),
            "weft": (fabric.yarn[1], yarn),
        }
        if weave is not None:
            found["weave"] = weave, [c for c in controls(type(weave)) if c.name not in ("far", "colors")]
            found["irregularity"] = weave.irregularity, controls(type(weave.irregularity))
        if fabric.transmission is not None:
            found["transmission"] = fabric.transmission, controls(type(fabric.transmission))
        return found

    def state(self) -> dict:
        """All controls with their values, in plain values."""
        session = self.session
        groups = [
            {"name": name, "fields": [_control(entry, value) for entry in fields]}
            for name, (value, fields) in self.groups().items()
        ]
        return {
            "fabric": next(name for name, fabric in self._fabrics.items() if fabric == session.chosen),
            "fabrics": list(self._fabrics),
            "title": session.fabric.name,
            "size": list(session.scene.size),
            "groups": groups,
            "undo": session.can_undo,
            "redo": session.can_redo,
        }

    def edit(self, group: str, name: str, value: Any) -> None:
        """Give a field of a group another value. Raises InputError for one that is not there, and out of range."""
        found = self.groups().get(group)
        if found is None or name not in {entry.name for entry in found[1]}:
            raise InputError(f"{group}.{name}: no such field here")
        session, gesture, change = self.session, f"{group} {name}", {name: value}
        if group == "scene":
            if name == "env" and value not in ("studio", "sky", session.scene.env):
                raise InputError(f"env = {value}: expected studio or sky; files are chosen where glcloth was started")
            session.edit_scene(gesture, **change)
        elif group == "fabric":
            session.edit_fabric(session.fabric.changed(**change), gesture)
        elif group in ("warp", "weft"):
            session.edit_yarn(("warp", "weft").index(group), gesture, **change)
        elif group == "weave":
            session.edit_weave(gesture, **change)
        elif group == "irregularity":
            assert session.fabric.weave is not None
            session.edit_weave(gesture, irregularity=session.fabric.weave.irregularity.changed(**change))
        else:
            session.edit_transmission(gesture, **change)

    def choose(self, fabric: str) -> None:
        """Take another of the built-in fabrics, or the first one again. Raises InputError."""
        if fabric not in self._fabrics:
            raise InputError(f"fabric {fabric}: expected one of the built-in fabrics")
        self.session.choose_fabric(self._fabrics[fabric])

    def look(self, how: str, x: float, y: float) -> None:
        """Move the eye: orbit, pan (of the picture's height), zoom (steps), or home; `turn` turns the light."""
        if how == "home":
            self.session.look(View())
        if how == "turn":
            turned = self.session.scene.env_rotate - 180.0 * x
            self.session.edit_scene("turn", env_rotate=round((turned + 180.0) % 360.0 - 180.0, 2))
        if how not in ("orbit", "pan", "zoom") or not self.refiner.frames:
            return
        camera = self.refiner.camera(self.session.scene)
        if how == "orbit":
            camera = orbit.orbit(camera, -180.0 * x, 180.0 * y)
        elif how == "pan":
            camera = orbit.pan(camera, -x, y)
        else:
            camera = orbit.zoom(camera, 0.9**y, self.refiner.frames[0].whole.radius)
        self.session.look(orbit.view_of(camera))

    # -- the drawing thread ------------------------------------------------------------------------------------------

    def run(self) -> None:
        """Draw until closed. Raises NoOpenGLError, and InputError when the first scene cannot be shown; then, too, nobody
        waits for a picture any more."""
        try:
            with ExitStack() as stack:
                ctx = create_context(self._device)
                stack.callback(ctx.release)
                self.resources = Resources()
                stack.callback(self.resources.close)
                self.refiner = Refiner(ctx)
                stack.callback(self.refiner.renderer.close)
                stack.callback(self.refiner.release)
                while not self._closed:
                    self._step()
        except Exception as error:
            self.fault = one_line(error) or type(error).__name__
            raise
        finally:
            self._ended = True
            self.close()

    def _step(self) -> None:
        self._hear()
        again = self._follow()
        refiner = self.refiner
        # While something is refined, the sender rests; answers to an edit go out at once.
        changed = False
        try:
            changed = not refiner.idle and refiner.work(BUDGET)
        except (InputError, ShaderError) as error:  # the last picture stays, and the page says why
            self._message, again = one_line(error), bool(refiner.sides)
        self._unsent |= changed
        soon = refiner.idle or refiner.previewing or now() - self._sent > EVERY
        self.status = self.resources.doing if self._pending else refiner.status(self.session.scene)[0]
        # The last step of a drawing shows nothing new, but that the picture is complete.
        over = self._complete and not self._shown.complete
        if again or over or (self._unsent and soon):
            self._send()

    @property
    def _complete(self) -> bool:
        """Whether the picture is that of `render`."""
        sides = self.refiner.sides
        return self.refiner.idle and not self._pending and bool(sides) and sides[0].share == 1.0

    def _hear(self) -> None:
        """Do what was asked; wait for it where there is nothing else to do."""
        known = self._pending or self._document is self.session.document
        idle = self.refiner.idle and known and not self._unsent
        patience = 0.03 if self._pending else None
        try:
            asked = self._wishes.get(idle, patience)
            while asked is not None:
                future, wish = asked
                try:
                    future.set_result(wish())
                except BaseException as error:
                    future.set_exception(error)
                asked = self._wishes.get_nowait()
        except queue.Empty:
            pass

    def _follow(self) -> bool:
        """Take the session's document; True when the same picture is to be shown in another way."""
        document = self.session.document
        if document is self._document and not self._pending:
            return False
        scene, first = document.scene, not self.refiner.frames
        try:
            fabric = self.session.resolve(scene.fabric)
            ready = self.resources.ask(scene, fabric)
            if ready is None:
                self._pending = True
                return False
            self._document, self._pending = document, False
            fresh = self.refiner.show([self.refiner.frame(scene, fabric, ready, True)])
            self._message = ""
            return not fresh and self.refiner.idle
        except (InputError, ShaderError) as error:
            if first:
                raise
            self._message = one_line(error)
            self.session.reject()
            self._document, self._pending = self.session.document, False
            return True

    def _send(self) -> None:
        """Let the others see the picture as it is now."""
        side, scene = self.refiner.sides[0], self.session.scene
        if side.texture is None:
            return
        width, height = side.texture.size
        pixels = np.frombuffer(side.texture.read(), "f4").reshape(height, width, 4)[::-1]
        light = pixels[..., :3]
        if not scene.background:
            light = light + (1.0 - pixels[..., 3:]) * BACKDROP
        complete = self._complete
        codes = np.round(255 * view(light, scene.transform, scene.exposure)).astype(np.uint8)
        buffer = io.BytesIO()
        how = {"quality": 95, "subsampling": 0} if complete else {"quality": 85}
        Image.fromarray(codes).save(buffer, "jpeg", **how)
        with self._news:
            self._shown = Shown(self._shown.version + 1, buffer.getvalue(), complete, self._message)
            self._news.notify_all()
        self._unsent, self._sent = False, now()


def _control(entry: Entry, value: Value) -> dict:
    """A field as the page takes it."""
    own = getattr(value, entry.name)
    choices = list(entry.choices)
    if entry.name == "env":
        choices = list(dict.fromkeys(["studio", "sky", own]))
    return {
        "name": entry.name,
        "label": entry.label,
        "kind": "choice" if choices else entry.kind,
        "unit": entry.unit,
        "help": entry.help,
        "low": entry.low,
        "high": entry.high,
        "log": entry.log,
        "choices": choices,
        "value": list(own) if isinstance(own, tuple) else own,
    }
