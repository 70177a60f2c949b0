"""From the document to pictures: the cloth's, the curtain's, and the tree's in a window of its own."""

from __future__ import annotations

import numpy as np

from ..color import Transform
from ..errors import InputError, ShaderError
from ..gpu.memo import Last
from ..gpu.programs import recompiled
from ..scene import Scene
from .clock import Clock, now
from .curtain import Player
from .host import Host
from .messages import Messages
from .near_view import NearView
from .refine import Refiner
from .resources import Ready, Resources
from .screen import Look, Rectangle, Screen
from .state import Document, Session
from .tree_window import TreeWindow


class Drawing:
    """Draws the session's document. `follow` takes a new one, `work` draws for a while, `paint` shows it."""

    def __init__(self, host: Host, session: Session, clock: Clock, messages: Messages):
        self.host, self.session, self.clock, self.messages = host, session, clock, messages
        self.ctx = host.ctx
        self.resources = Resources()
        self.refiner = Refiner(self.ctx)
        self.player = Player(self.ctx)
        self.tree: TreeWindow | None = None
        self.near: NearView | None = None
        self._near_asked = False  # since the last step
        self.ready: list[Ready | None] = []
        self.document: Document | None = None  # the one being drawn
        self.pending = True  # something that it needs is still being made
        self._screen = Screen(self.ctx)
        self._transforms: Last[Transform] = Last()
        self._go_to: int | None = None  # a frame of the curtain
        self._tree_shows: tuple | None = None

    def close(self) -> None:
        """Free everything."""
        self.resources.close()
        if self.tree is not None:
            self.tree.close()
        for thing in (self.player, self.refiner, self._screen, self.near):
            if thing is not None:
                thing.release()

    # -- how far it is -----------------------------------------------------------------------------------------------

    @property
    def drawer(self) -> Refiner | Player:
        """The drawer of the scene that is shown."""
        return self.player if self.session.in_curtain else self.refiner

    @property
    def busy(self) -> bool:
        """True while there is something to draw."""
        near = self.near is not None and self._near_asked and not self.near.idle
        return near or not self.drawer.idle or (self.tree is not None and not self.tree.idle)

    @property
    def complete(self) -> bool:
        """True when the picture is what `render` makes of the scene."""
        done = self.drawer.idle and all(side.share == 1.0 for side in self.drawer.sides)
        return done and not self.pending and self.session.document is self.document

    @property
    def shows_something(self) -> bool:
        return self.drawer.sides != []

    @property
    def cold(self) -> bool:
        """True while something is left to compile when nobody does anything."""
        if self.session.in_curtain:
            return False
        return self.refiner.cold or (self.near is not None and self._near_asked and self.near.cold)

    def warm_up(self) -> None:
        """Compile something that edits may need."""
        if self.near is not None and self._near_asked and self.near.cold:
            self.near.warm_up()
        elif self.refiner.cold:
            self.refiner.warm_up()

    def picture(self) -> np.ndarray:
        """The picture as `render` returns it: float32 [H, W, 3 or 4], linear, top row first; once refined."""
        scene = self.session.shown
        data = np.frombuffer(self.drawer.sides[0].texture.read(), "f4").reshape(scene.size[1], scene.size[0], 4)[::-1]
        return data.copy() if not getattr(scene, "background", True) else data[..., :3].copy()

    # -- drawing -----------------------------------------------------------------------------------------------------

    def forget(self) -> None:
        """Draw anew, whatever has been drawn."""
        self.document = None
        self.player.forget()

    def go_to(self, frame: int) -> None:
        """Show a frame of the moving curtain, from the beginning on."""
        self._go_to = frame
        self.pending = True

    def follow(self) -> bool:
        """Take a new document; True when the same picture is to be shown in another way.

        Raises InputError and ShaderError while there is nothing to show; later they become messages.
        """
        if self.tree is not None and self.tree.closed:
            self.toggle_tree()
        document = self.session.document
        if document is self.document and not self.pending:
            return False
        try:
            return (self._follow_curtain if document.mode == "curtain" else self._follow_cloth)(document)
        except (InputError, ShaderError) as error:
            if not self.shows_something:
                raise
            self.messages.error(error)
            if isinstance(error, InputError):
                self.session.reject()
            else:
                self.document = document
            self.pending = isinstance(error, InputError)
            return True

    def _follow_cloth(self, document: Document) -> bool:
        fresh = document is not self.document
        scenes = document.sides()
        ready = [self.resources.ask(scene, self.session.resolve(scene.fabric)) for scene in scenes]
        complete = None not in ready
        if not fresh and not complete:
            return False
        self.document, self.pending = document, not complete
        last = next((r for r in self.ready if r is not None), None)
        frames = []
        for number, scene in enumerate(scenes):
            have = ready[number] or (self.ready[number] if number < len(self.ready) else None) or last
            if have is None:
                return True
            fabric = self.session.resolve(scene.fabric)
            frames.append(self.refiner.frame(scene, fabric, have, ready[number] is not None))
        if complete:
            self.ready = ready
        if self.near is not None:
            self.near.show(self.session.fabric, frames[0])
        return not self.refiner.show(frames)

    def _follow_curtain(self, document: Document) -> bool:
        scene, *others = document.sides()
        environment = self.resources.ask_curtain(scene, self.session.fabric)
        if others:
            # Read once, so that it is one and the same object from picture to picture.
            others = [others[0].model_copy(update={"fabric": self.session.resolve(others[0].fabric)})]
            if self.resources.ask_curtain(others[0], others[0].fabric) is None:
                environment = None
        fresh = document is not self.document
        self.document, self.pending = document, environment is None
        if environment is None:
            return fresh
        if self.player.show(scene, environment, *others, layered=bool(others) and document.layered):
            fresh = False
            if self.tree is not None:
                self.tree.look_as(self.player.camera(scene))
        if self._go_to is not None:
            self.player.go_to(self._go_to)
            self._go_to = None
        return fresh

    def begin_step(self) -> None:
        """Forget what the panels asked for in the last step."""
        self._near_asked = False

    def look_near(self) -> NearView:
        """The view of the cloth near by, which is drawn as long as it is asked for in every step."""
        self._near_asked = True
        if self.near is None:
            self.near = NearView(self.ctx)
        if self.refiner.frames:  # another part may have been chosen, which is no edit
            self.near.show(self.session.fabric, self.refiner.frames[0])
        return self.near

    def work(self, budget: float) -> bool:
        """Draw for so many seconds; True when the picture has changed."""
        until = now() + budget
        changed = False
        try:
            near = self.near if self._near_asked and not self.session.in_curtain else None
            if near is not None and (near.answering or self.drawer.idle) and near.work(budget):
                return True  # the answer is shown before anything else is drawn
            if not self.drawer.idle:
                # The tree's window shares the time, so that it follows while the curtain moves.
                share = 0.6 if self.tree is not None and not self.tree.idle else 1.0
                changed = self.drawer.work(share * budget)
                if self.drawer.idle:
                    self.clock.wake(2)  # the overlay says so, and fits its new text
            if self.tree is not None:
                changed |= self._work_on_tree(self.tree, until - now())
        except (InputError, ShaderError) as error:
            self.messages.error(error)
            return True
        return changed

    def _work_on_tree(self, tree: TreeWindow, seconds: float) -> bool:
        drawn = not tree.idle and seconds > 0.003
        if drawn:
            tree.work(seconds)
        built = self.player.built
        if built is not None and built != self._tree_shows and tree.follow(built[0]):
            self._tree_shows = built
        return drawn  # the panel says how many boxes there are

    def toggle_tree(self) -> None:
        """Open or close the window of the tree."""
        if self.tree is not None:
            self.tree.close()
            self.tree = None
            return
        self._tree_shows = None
        try:
            self.tree = TreeWindow(self.host)
        except RuntimeError as error:
            self.messages.error(f"the tree's window: {error}")

    def paint(self, rectangle: Rectangle) -> None:
        """Put the picture into a rectangle of the window."""
        document = self.session.document
        look = self.look._replace(opaque=getattr(document.shown, "background", True))
        self._screen.draw(
            self.drawer.sides, look, rectangle, document.compare, document.split, document.difference_scale
        )

    @property
    def look(self) -> Look:
        """How the scene that is shown comes to the screen."""
        shown = self.session.shown
        return Look(shown.exposure, self._transform(shown))

    def _transform(self, shown: Scene) -> Transform:
        """The view transform of a scene; where its config cannot be used, our own, and a message."""
        key = shown.ocio, shown.display, shown.ocio_view, shown.view_transform
        return self._transforms.get(lambda: self._checked(shown), *key)

    def _checked(self, shown: Scene) -> Transform:
        try:
            return shown.transform
        except InputError as error:
            self.messages.error(str(error))
            return shown.view_transform

    def reload_shaders(self) -> None:
        """Take the shaders as they are now; when they do not compile, keep the old ones and say why."""
        curtain = self.player.curtain
        try:
            with recompiled(self.ctx):
                refiner = Refiner(self.ctx)
                refiner.try_out(self.refiner.frames)
                self._screen.compiled()
                if curtain is not None:
                    trial = Player(self.ctx)
                    trial.try_out(curtain.scene, curtain.environment)
                    trial.release()
        except ShaderError as error:
            self.messages.error(error)
            return
        self.refiner.release()
        if self.near is not None:
            self.near.release()
            self.near = None
        self.refiner = refiner
        if curtain is not None:
            self._go_to = self.player.frame
        self.player.release()
        self.player = Player(self.ctx)
        self.forget()
        self.messages.note("shaders reloaded")
