"""Drops files on an X11 window as a file manager does: XDND 5, from a connection of its own."""

import threading
from pathlib import Path

from Xlib import X
from Xlib.display import Display
from Xlib.protocol import event

VERSION = 5


class Source(threading.Thread):
    """One drop of files (`paths`) at (x, y) of the screen on the window with a number; `accepted` once it is over."""

    def __init__(self, window: int, paths: list[Path], x: int, y: int):
        super().__init__(daemon=True)
        self.accepted: bool | None = None
        self._display = Display()
        self._target = self._display.create_resource_object("window", window)
        root = self._display.screen().root
        self._source = root.create_window(0, 0, 1, 1, 0, X.CopyFromParent)
        self._uris = "".join(f"{Path(path).absolute().as_uri()}\r\n" for path in paths).encode()
        self._x, self._y = x, y

    def run(self) -> None:
        """Enter, stand still, drop, hand the names over, wait until the target has done."""
        self._source.set_selection_owner(self._atom("XdndSelection"), X.CurrentTime)
        self._tell("XdndEnter", VERSION << 24, self._atom("text/uri-list"), 0, 0)
        self._tell("XdndPosition", 0, self._x << 16 | self._y, X.CurrentTime, self._atom("XdndActionCopy"))
        if self._hear("XdndStatus")[1] & 1:
            self._tell("XdndDrop", 0, X.CurrentTime, 0, 0)
            # glfw says how many bytes it took, where the protocol asks for a bit.
            self.accepted = self._hear("XdndFinished")[1] > 0
        else:
            self._tell("XdndLeave", 0, 0, 0, 0)
            self.accepted = False
        self._display.close()

    def _atom(self, name: str) -> int:
        return self._display.intern_atom(name)

    def _tell(self, name: str, *data: int) -> None:
        message = event.ClientMessage(
            window=self._target, client_type=self._atom(name), data=(32, [self._source.id, *data])
        )
        self._target.send_event(message)
        self._display.flush()

    def _hear(self, name: str) -> list[int]:
        """The data of the target's next message of that name; hands the names over meanwhile when it asks for them."""
        while True:
            heard = self._display.next_event()
            if heard.type == X.SelectionRequest:
                self._hand_over(heard)
            elif heard.type == X.ClientMessage and heard.client_type == self._atom(name):
                return list(heard.data[1])

    def _hand_over(self, request) -> None:
        known = request.target == self._atom("text/uri-list")
        if known:
            request.requestor.change_property(request.property, request.target, 8, self._uris)
        answer = event.SelectionNotify(
            time=request.time,
            requestor=request.requestor,
            selection=request.selection,
            target=request.target,
            property=request.property if known else X.NONE,
        )
        request.requestor.send_event(answer)
        self._display.flush()
