"""Files that are made from fields: docs/scene.md, fabric_file.md and lights_file.md, and the options of the command line.

`python -m glcloth.cli.generate` writes them.

The options are a file, so that the command line knows them without loading the scene.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

from ..fabric import Fabric, Transmission, Yarn
from ..fields import Entry, Value, entries
from ..files import PACKAGE
from ..light.lights_file import FORMAT
from ..scene import CURTAIN, CurtainParameters, FabricMaskMap, OpacityMap, PrintMap, Scene, View, kind_of
from ..weave.model import Irregularity, Stripe, Weave

DOCS = PACKAGE.parent / "docs"
OPTIONS = PACKAGE / "cli" / "scene_options.py"
COMMAND = "python -m glcloth.cli.generate"


def scene_document() -> str:
    """docs/scene.md: every field of a scene with its help, values, default and option."""
    fields = entries(Scene)
    first = ", ".join(f"`{name} = {_said(value)}`" for name, value in CURTAIN.items())
    parts = [
        "# Scenes",
        "Everything that determines a picture. A scene file (.toml) holds these fields, `glcloth render` has\n"
        "them as options, `Scene.changed` and `Renderer.render` take them as keywords, and a picture keeps\nthem.",
        "Made from the fields in `glcloth/scene` by `python -m glcloth.cli.generate`.",
        _table("Every scene", [e for e in fields if kind_of(e.name) == "" or e.name == "curtain"]),
        _table("Cloth under an environment", [e for e in fields if kind_of(e.name) == "cloth"]),
        _table("The curtain", [e for e in fields if kind_of(e.name) == "curtain" and e.name != "curtain"]),
        f"A curtain begins with {first}.",
        _table("The table `camera`", entries(View)),
        _table("The table `print`, and each of `prints`", map_options("print", PrintMap)),
        _table("The table `opacity`, and each of `opacities`", map_options("opacity", OpacityMap)),
        _table("The table `fabric_mask`, and each of `fabric_masks`", map_options("fabric_mask", FabricMaskMap)),
        _table("The table `curtain`", entries(CurtainParameters)),
    ]
    return "\n\n".join(parts) + "\n"


def fabric_document() -> str:
    """docs/fabric_file.md: every field of a fabric file."""
    own = [e for e in entries(Fabric) if e.kind != "table" and e.name != "yarn"]
    parts = [
        "# Fabric files",
        "A fabric is a `.toml` file: a few words about the whole, two `[[yarn]]` blocks, the warp first, and if\n"
        "you like a `[weave]` and a `[transmission]`. [Every parameter, near and far](parameters.md) shows what\n"
        "each number does, [your fabric](own_fabric.md) how to begin.",
        f"Made from the fields in `glcloth/fabric` and `glcloth/weave/model.py` by `{COMMAND}`.",
        _short_table("The whole", own),
        _short_table("Each `[[yarn]]`", entries(Yarn)),
        "A yarn has a curve (`curve_angles_deg`, `curve_lengths`, `samples`) or `tangents_deg`. With a `[weave]`\n"
        'whose `far` is `"weave"` it has neither, nor an `area`: they follow.',
        _short_table("The table `[weave]`", [e for e in entries(Weave) if e.kind != "table"]),
        "Pairs are `[warp, weft]`; one number stands for both.",
        _short_table("The table `[weave.irregularity]`", entries(Irregularity)),
        _short_table("Each of `warp_stripes`, `weft_stripes`", entries(Stripe)),
        _short_table("The table `[transmission]`", entries(Transmission)),
        "`openness` may stand for `rho`, which is 1 - openness; one number of `tau` stands for all three.",
    ]
    return "\n\n".join(parts) + "\n"


def lights_document() -> str:
    """docs/lights_file.md: what a file of lights holds."""
    return f"""# Lights files

`--lights FILE` takes lights from a `.json` or `.toml` file instead of a fit; `glcloth env MAP` writes
one. Directions point toward the light, +Y up; colours are linear Rec. 709.

Made by `{COMMAND}`.

| field | what |
|---|---|
| `format` | "{FORMAT}" |
| `note`, `about` | for people; not read |
| `gaussian` | a list of soft lights |
| `sun` | a list of suns, may be empty |

## Each `gaussian`

| field | what | values |
|---|---|---|
| `axis` | direction of its middle | x, y, z; made a unit vector |
| `sharpness` | how narrow it is: about 1 is half the sky, 1000 a lamp 4 degrees wide | from 0 |
| `amplitude` | radiance in its middle | red, green, blue |

The radiance from a direction is the sum of amplitude * exp(sharpness * (direction . axis - 1)).

## Each `sun`

| field | what | values |
|---|---|---|
| `direction` | toward it | x, y, z; made a unit vector |
| `irradiance` | on a surface that faces it | red, green, blue |
| `radius_deg` | how wide its disc is, for the softness of shadows; 0: hard | from 0 to 10 degrees; 0.27 where left out |
"""


def _short_table(title: str, rows: list[Entry]) -> str:
    lines = [f"## {title}\n", "| field | what | values | default |", "|---|---|---|---|"]
    for e in rows:
        default = _said(e.default).replace("|", "\\|") if e.default is not None else ""
        lines.append(f"| `{e.name}` | {e.help} | {e.values} | {default} |")
    return "\n".join(lines)


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


def map_options(field: str, model: type[Value]) -> list[Entry]:
    """The fields of a map of the cloth; the option of its file has the map's name, the others begin with it."""
    option = "--" + field.replace("_", "-")
    return [
        replace(entry, option=option if entry.name == "file" else f"{option}-{entry.name}") for entry in entries(model)
    ]


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
        "from .common import whole",
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
                name += 'negative="", ' if several else "converter=whole, " if kind == "int" else ""
                text = _help(entry, "curtain" if model is CurtainParameters else entry.of)
                lines.append(f'    {entry.name}: Annotated[{kind} | None, Parameter({name}help="{text}")] = None')
    for name, of_map in (("print", PrintMap), ("opacity", OpacityMap), ("fabric_mask", FabricMaskMap)):
        for entry in map_options(name, of_map)[1:]:
            kind = _type(of_map.model_fields[entry.name].annotation)
            text = f"{name.replace('_', ' ').capitalize()}: {_help(entry, '')}"
            lines.append(f'    {name}_{entry.name}: Annotated[{kind} | None, Parameter(help="{text}")] = None')
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
    return {
        DOCS / "scene.md": scene_document(),
        DOCS / "fabric_file.md": fabric_document(),
        DOCS / "lights_file.md": lights_document(),
        OPTIONS: scene_options(),
    }


if __name__ == "__main__":
    for path, text in files().items():
        path.write_text(text, encoding="utf-8")
