"""Lines to the user: errors, which stay until they are closed, and notes."""

from __future__ import annotations

from collections.abc import Callable

from ..errors import InputError, ShaderError, one_line, printable
from .clock import Clock

MOST = 5  # lines that are shown


class Messages:
    """The messages on the screen: `lines` of (kind, text); the kind is "error" or "note"."""

    def __init__(self, clock: Clock):
        self.lines: list[tuple[str, str]] = []
        self._clock = clock

    def note(self, text: str) -> None:
        """Show a line until newer ones push it out, or it is closed."""
        self._add("note", printable(text))

    def error(self, error: Exception | str) -> None:
        """Show an error; of a shader only the lines that do not compile, without a driver's warnings and headings."""
        text = one_line(error)
        if isinstance(error, ShaderError):
            lines = str(error).splitlines()
            text = "\n".join([line for line in lines if "error" in line.lower()] or lines)
        self._add("error", text)

    def _add(self, kind: str, text: str) -> None:
        self.close((kind, text))
        self.lines = [*self.lines[1 - MOST :], (kind, text)]
        self._clock.wake()

    def close(self, line: tuple[str, str]) -> None:
        """Show a line no longer."""
        self.lines = [one for one in self.lines if one != line]

    def attempt(self, action: Callable, *arguments, **options) -> None:
        """Run an edit; an error becomes a message and nothing else changes."""
        try:
            action(*arguments, **options)
        except InputError as error:
            self.error(error)
        except OSError as error:
            self.error(f"{error.filename or 'a file'}: {error.strerror or error}; check the name and its permissions")
