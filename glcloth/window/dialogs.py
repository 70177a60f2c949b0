"""The file dialog of the desktop, beside the window: it never waits for it, and does without where there is none."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable

from imgui_bundle import portable_file_dialogs

# Programs that portable-file-dialogs calls on Linux; elsewhere the system has a dialog of its own.
PROGRAMS = ("zenity", "kdialog", "matedialog", "qarma")
ALL = ["All files", "*"]


def available() -> bool:
    """Whether this desktop has a file dialog."""
    return not sys.platform.startswith("linux") or any(shutil.which(name) for name in PROGRAMS)


class Dialogs:
    """At most one dialog at a time; `poll` calls back with the choice."""

    def __init__(self):
        self._open = None
        self._chosen: Callable[[str], None] | None = None

    @property
    def waiting(self) -> bool:
        """True while a dialog is open."""
        return self._open is not None

    def open(self, title: str, kinds: list[str], chosen: Callable[[str], None]) -> bool:
        """Ask for a file to open; False where there is no dialog. kinds : name, patterns, name, patterns, ..."""
        return self._start(lambda: portable_file_dialogs.open_file(title, "", [*kinds, *ALL]), chosen)

    def save(self, title: str, name: str, kinds: list[str], chosen: Callable[[str], None]) -> bool:
        """Ask for a name to save to, `name` being proposed; False where there is no dialog."""
        return self._start(lambda: portable_file_dialogs.save_file(title, name, [*kinds, *ALL]), chosen)

    def _start(self, make: Callable, chosen: Callable[[str], None]) -> bool:
        if self.waiting or not available():
            return False
        self._open, self._chosen = make(), chosen
        return True

    def poll(self) -> None:
        """Hear whether the user has chosen; a dialog that was cancelled chooses nothing."""
        if self._open is None or not self._open.ready(0):
            return
        result = self._open.result()
        chosen, self._open, self._chosen = self._chosen, None, None
        path = result if isinstance(result, str) else (result[0] if result else "")
        if path:
            chosen(path)

    def close(self) -> None:
        """Close a dialog that is still open."""
        if self._open is not None:
            self._open.kill()
            self._open = None
