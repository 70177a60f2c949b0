"""Which of the files in use have changed on disk."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ..files import GLSL
from .clock import Clock

EVERY = 0.5  # seconds between two looks
SHADERS = "shaders"


class Watcher:
    """Remembers when files were changed; `changed` names those that were since."""

    def __init__(self, clock: Clock):
        self._clock = clock
        self._seen: dict[str, float | None] = {}

    def changed(self, files: Iterable[str]) -> list[str]:
        """The changed ones among `files` (and SHADERS when any shader was); looks at most every EVERY seconds."""
        if not self._clock.every(EVERY, "watched"):
            return []
        stamps = {name: _stamp(Path(name)) for name in files}
        stamps[SHADERS] = max(_stamp(path) or 0.0 for path in GLSL.rglob("*") if path.is_file())
        out = [
            name
            for name, stamp in stamps.items()
            if name in self._seen and stamp is not None and stamp != self._seen[name]
        ]
        self._seen = {**{n: s for n, s in self._seen.items() if n in stamps}, **stamps}
        return out


def _stamp(path: Path) -> float | None:
    try:
        return path.stat().st_mtime
    except OSError:
        return None
