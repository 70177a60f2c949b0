"""Flatten GLSL files (`#include "path"`, each file once), compile them, and map errors back to file and line."""

from __future__ import annotations

import re
from collections.abc import Mapping

from ..errors import ShaderError
from ..files import GLSL

_INCLUDE = re.compile(r'^\s*#include\s+"([^"]+)"')
# Mesa "0:12(3): error: ...", NVIDIA "0(12) : error ...", AMD, Intel and Apple "ERROR: 0:12: ..."
_MESSAGE = re.compile(r"^(?:ERROR:\s*|WARNING:\s*)?\d+(?::(\d+)|\((\d+)\))(?:\(\d+\))?\s*:\s*(.*)$")

Where = list[tuple[str, int]]


def flatten(
    path: str, defines: Mapping[str, object] | None = None, virtual: Mapping[str, str] | None = None
) -> tuple[str, Where]:
    """Return the flat text of one program and, for each of its lines, the (file, line) it came from.

    Parameters
    ----------
    path : the pass, below the glsl folder
    defines : written right after `#version`
    virtual : {name: text or another path}; lets Python choose what `#include "name"` means, for example the method
        of a pass. A value that ends in ".glsl" is a path, anything else is the text itself.

    Raises ShaderError for a missing file or an include cycle.
    """
    lines: list[str] = []
    where: Where = []
    seen: set[str] = set()
    virtual = virtual or {}

    def add(name: str, chain: tuple[str, ...]) -> None:
        text = virtual.get(name)
        if text is not None and text.endswith(".glsl"):
            name, text = text, None
        if name in chain:
            raise ShaderError("include cycle: " + " -> ".join((*chain, name)))
        if name in seen:
            return
        seen.add(name)
        if text is None:
            file = GLSL / name
            if not file.is_file():
                asker = f"glsl/{chain[-1]}: " if chain else ""
                raise ShaderError(f'{asker}no such file "{name}" under {GLSL}')
            text = file.read_text(encoding="utf-8")
        for number, line in enumerate(text.splitlines(), 1):
            if match := _INCLUDE.match(line):
                add(match[1], (*chain, name))
                continue
            lines.append(line)
            where.append((name, number))
            if line.startswith("#version"):
                for key, value in (defines or {}).items():
                    lines.append(f"#define {key} {value}")
                    where.append(("<defines>", 0))

    add(path, ())
    return "\n".join(lines) + "\n", where


def explain(log: str, where: Where) -> str:
    """Rewrite a driver's log so that each message names the GLSL file and line it is about."""
    out = []
    for line in log.splitlines():
        match = _MESSAGE.match(line.strip())
        number = int(match[1] or match[2]) if match else 0
        if match and 0 < number <= len(where):
            file, source_line = where[number - 1]
            out.append(f"glsl/{file}:{source_line}: {match[3]}")
        else:
            out.append(line)
    return "\n".join(out)
