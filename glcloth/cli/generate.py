"""Files that are made from the fields of a scene: docs/scene.md and the options of the command line.

`python -m glcloth.cli.generate` writes them.

The options are a file, so that the command line knows them without loading the scene.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, get_args

from ..fields import Entry, Value, entries
from ..files import PACKAGE
from ..scene import CURTAIN, CurtainParameters, Scene, View, kind_of

DOCUMENT = PACKAGE.parent / "docs" / "scene.md"
OPTIONS = PACKAGE / "cli" / "scene_options.py"


def scene_document() -> str:
    """docs/scene.md: every field of a scene with its help, values, default and option."""
    fields = entries(Scene)
    first = ", ".join(f"`{name} = {_said(value)}`" for name, value in CURTAIN.items())
    parts = [
        "# Scenes",
        "Everything that determines a picture. A scene file (.toml) holds these fields, `glcloth render` has\n"
        "them as options, `Scene.changed` and `Renderer.render` take them as keywords, and a picture keeps\nthem.",
        "Made from the fields in `glcloth/scene.py` by `python -m glcloth.cli.generate`.",
        _table("Every scene", [e for e in fields if kind_of(e.name) == "" or e.name == "curtain"]),
        _table("Cloth under an environment", [e for e in fields if kind_of(e.name) == "cloth"]),
        _table("The curtain", [e for e in fields if kind_of(e.name) == "curtain" and e.name != "curtain"]),
        f"A curtain begins with {first}.",
        _table("The table `camera`", entries(View)),
        _table("The table `curtain`", entries(CurtainParameters)),
    ]
    return "\n\n".join(parts) + "\n"


def _table(title: str, rows: list[Entry]) -> str:
    lines = [f"## {title}\n", "| field | what | values | default | option |", "|---|---|---|---|---|"]
    for e in rows:
        what = e.help + (f" (method {e.of})" if e.method else "")
        lines.append(f"| `{e.name}` | {what} | {e.values} | {_said(e.default)} | {e.option and f'`{e.option}`'} |")
    return "\n".join(lines)


def _said(value: Any) -> str:
    """A default as a scene file has it."""
    if isinstance(value, bool):
        return str(value).lower()
    if value is None or value in ("", {}) or isinstance(value, Value):
        return ""
    return str(list(value) if isinstance(value, tuple) else value)


def scene_options() -> str:
    """glcloth/cli/scene_options.py: a dataclass of the fields that are options."""
    lines = [
        '"""Options that are fields of a scene. Made from these by `python -m glcloth.cli.generate`: do not edit."""',
        "",
        "# fmt: off",
        "# ruff: noqa: E501",
        "from dataclasses import dataclass",
        "from typing import Annotated",
        "",
        "from cyclopts import Parameter",
        "",
        "",
        '@Parameter(name="*")',
        "@dataclass",
        "class SceneOptions:",
        '    """What to render; an option that is not given keeps the scene\'s value."""',
        "",
    ]
    for model in (Scene, View, CurtainParameters):
        for entry in entries(model):
            if entry.option:
                several = entry.repeat or entry.kind == "list"
                kind = "list[str]" if several else _type(model.model_fields[entry.name].annotation)
                named = several or entry.option != "--" + entry.name.replace("_", "-")
                name = f'name="{entry.option}", ' if named else ""
                name += 'negative="", ' if several else ""
                text = _help(entry, "curtain" if model is CurtainParameters else entry.of)
                lines.append(f'    {entry.name}: Annotated[{kind} | None, Parameter({name}help="{text}")] = None')
    return "\n".join(lines) + "\n"


def _type(annotation: Any) -> str:
    """The type that an option is read as; the scene parses the rest of a text, and reports its errors."""
    annotation = float if get_args(annotation) == (float, type(None)) else annotation
    return annotation.__name__ if annotation in (bool, int, float) else "str"


def _help(entry: Entry, of: str) -> str:
    who = f"method {of}" if entry.method else of if of == "curtain" else ""
    notes = "; ".join(note for note in (entry.values, who) if note)
    return entry.help[0].upper() + entry.help[1:] + (f" ({notes})" if notes else "") + "."


def files() -> dict[Path, str]:
    """Every file that is written, and its text."""
    return {DOCUMENT: scene_document(), OPTIONS: scene_options()}


if __name__ == "__main__":
    for path, text in files().items():
        path.write_text(text, encoding="utf-8")
