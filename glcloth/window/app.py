"""The window itself: panels over the picture, and a loop that draws only when something changes.

App puts the parts together and turns the loop; nothing imports it. State flows one way: input (host) goes by
`actions` into the session's document, the document into pictures (drawing), and those onto the screen.
"""

from __future__ import annotations

from .host import Host  # first: it brings the glfw library that imgui-bundle shares   # isort: skip
from imgui_bundle import imgui  # isort: skip
import glfw

from ..scene import Scene
from .actions import Actions
from .clock import Clock
from .drawing import Drawing
from .files import Files, frame_of
from .layout import PANEL, Layout
from .messages import Messages
from .navigation import Navigation
from .panels import Panels
from .slices import BUDGET
from .state import Session

DEFAULT_SIZE = (1280, 720)  # points
LATE = 0.012  # seconds into a step after which the screen waits for the next one
PATIENCE = 0.06  # seconds
QUIET = 0.7  # seconds without an event after which nobody is taken to be at work


class App:
    """One window on one session.

    Parameters
    ----------
    scene : the first to show; a missing size is chosen
    watch : reload shaders, fabric, mesh, environment and scene files when they change
    source : the file the scene came from, if any
    device : number or name of the one that shall draw; None: the display's own

    Raises NoOpenGLError without a display or OpenGL 4.3, and InputError for a scene that cannot be shown.
    """

    def __init__(self, scene: Scene, watch: bool = False, source: str | None = None, device: int | str | None = None):
        given = "size" in scene.model_fields_set
        wanted = tuple(scene.size if given else DEFAULT_SIZE)
        self.session = Session(scene.model_copy(update={"size": wanted}))
        self.session.resolve(scene.fabric)
        self.clock = Clock()
        self.messages = Messages(self.clock)
        self.host = Host(wanted, PANEL, not given, self.clock.heard, device)
        try:
            self.drawing = Drawing(self.host, self.session, self.clock, self.messages)
        except BaseException:
            self.host.close()
            raise
        self.layout = Layout(self.host, self.session)
        self.layout.follow = not given or self.layout.area() == wanted
        self.actions = Actions(self.session, self.drawing, self.layout, self.messages)
        self.files = Files(self.actions, self.clock, source, watch)
        self.navigation = Navigation(self.actions, self.files)
        self.panels = Panels(self.actions, self.files)
        self._owed = False  # something is drawn and not yet shown
        if scene.curtain is not None:
            self.drawing.go_to(frame_of(scene))

    def close(self) -> None:
        """Free everything and close the window."""
        self.files.close()
        self.drawing.close()
        del self.drawing, self.actions, self.files, self.navigation, self.panels
        self.host.close()

    def run(self) -> None:
        """Until the window is closed or Ctrl-C. Raises InputError when the first scene cannot be shown."""
        try:
            while not glfw.window_should_close(self.host.window):
                self.step()
        finally:
            self.close()

    def step(self) -> None:
        """Take the input, draw for a while, show it; or wait when there is nothing to do."""
        self._wait()
        if glfw.get_window_attrib(self.host.window, glfw.ICONIFIED):
            return
        clock, drawing = self.clock, self.drawing
        clock.mark("step")
        unseen = clock.since("shown")
        self._hear()
        self._panels()
        self.layout.update()
        before = drawing.document
        changed = drawing.follow()
        if drawing.document is not before:
            clock.mark("shown")  # the answer has so long before the panels are shown without it
            unseen = 0.0
        # This step shows the picture of the last one, so that neither takes longer than the input may wait.
        owed, self._owed = self._owed, False
        if drawing.busy and not owed:
            changed |= drawing.work(max(BUDGET - clock.usual("panels") - 0.003, 0.012))
            self._owed = changed and clock.since("step") > LATE
        self.files.save_later()
        # While an answer is on its way the panels alone are shown again only now and then: it shows them too.
        soon = drawing.drawer.previewing and unseen < PATIENCE
        if not self._owed and (owed or changed or (clock.awake > 0 and not soon)):
            self.actions.paint()
            glfw.swap_buffers(self.host.window)
            clock.mark("shown")
            clock.awake -= 1
        self.host.collect()

    def _wait(self) -> None:
        clock, drawing = self.clock, self.drawing
        if clock.awake > 0 or drawing.busy or self._owed:
            glfw.poll_events()
        elif drawing.pending or self.files.dialogs.waiting:
            glfw.wait_events_timeout(0.03)
            clock.wake(1)
        elif imgui.get_io().want_text_input:
            glfw.wait_events_timeout(0.4)  # the caret blinks
            clock.wake(1)
        elif drawing.cold:
            # Programs that edits of the weave may need are compiled while nobody does anything.
            glfw.wait_events_timeout(QUIET)
            if clock.since("heard") > QUIET:
                drawing.warm_up()
        elif self.files.watching:
            glfw.wait_events_timeout(0.25)
        else:
            glfw.wait_events_timeout(0.5)  # Ctrl-C is heard between two waits alone

    def _hear(self) -> None:
        """Take the news from outside: files that changed, were chosen or dropped."""
        self.files.watch()
        self.files.dialogs.poll()
        dropped, self.host.dropped = self.host.dropped, []
        for path in dropped:
            self.files.open(path)

    def _panels(self) -> None:
        self.clock.mark("panels")
        self.drawing.begin_step()
        imgui.backends.opengl3_new_frame()
        imgui.backends.glfw_new_frame()
        imgui.new_frame()
        typed, self.host.typed = self.host.typed, []
        try:
            self.navigation.update(typed)
            self.panels.draw()
        finally:
            imgui.render()
        self.clock.learn("panels", min(self.clock.since("panels"), 0.02))
        if not imgui.is_any_item_active() and self.navigation.drag is None:
            self.session.end_gesture()
