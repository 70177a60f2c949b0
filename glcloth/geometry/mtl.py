"""Materials of OBJ files: MTL, with what Blender and others write into it today."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..errors import InputError
from ..files import beside, read_bytes
from ..progress import warn
from .raw import Material
from .text import plain

UNSAID = 0.7  # reflectance of a material without Kd
MISSING = 0.5  # of one that no file defines
MOST_BYTES = 1 << 24


def read_materials(
    obj: Path, names: Sequence[str], libraries: Sequence[str], grey: float | None
) -> tuple[Material, ...]:
    """The materials of these names from the material files that an OBJ names, `mtllib a.mtl b.mtl`; the first definition
    of a name counts.

    Parameters
    ----------
    grey : reflectance where it names no file; with it, files and materials that are missing and colours above 1 are
        errors. None: they are grey, and clamped, with a warning

    Raises InputError for a file that cannot be read.
    """
    known: dict[str, Material] = {}
    found, absent = _found(obj, libraries)
    if absent and grey is not None:
        raise InputError(f"{obj}: names the material file {absent[0]}, which is not beside it; put it there")
    for library in found:
        for material in read_mtl(read_bytes(library, MOST_BYTES), str(library), strict=grey is not None):
            known.setdefault(material.name, material)
    plain_one = Material("", (MISSING if grey is None else grey,) * 3)
    missing = [name for name in names if name and name not in known] if found else []
    if missing and grey is not None:
        raise InputError(f"{obj}: material `{missing[0]}` is not defined in {', '.join(libraries)}; define it there")
    if absent:
        warn(f"{obj}: names the material file {absent[0]}, which is not beside it; what it would colour is grey")
    elif missing:
        warn(f"{obj}: material {missing[0]} is not defined in {', '.join(libraries)}; it is grey")
    return tuple(known.get(name) or Material(name, plain_one.color) for name in names)


def _found(obj: Path, libraries: Sequence[str]) -> tuple[list[Path], list[str]]:
    """The material files there are beside an OBJ, and the names of those that are not."""
    found, absent = [], []
    for line in dict.fromkeys(libraries):
        whole = beside(obj, line)
        candidates = [(line, whole)] if whole else [(name, beside(obj, name)) for name in line.split()]
        found += [path for _, path in candidates if path]
        absent += [name for name, path in candidates if not path]
    return list(dict.fromkeys(found)), absent


def read_mtl(blob: bytes, where: str, strict: bool = False) -> list[Material]:
    """The materials of an MTL file's bytes, in its order; one without Kd is 70 % grey.

    Kd is linear and multiplies map_Kd; Pr and Pm are roughness and metalness, else roughness follows from Ns as Blender
    writes it. `strict`: a Kd that is not three numbers from 0 to 1 raises InputError, with the line; else it is clamped
    or grey, with a warning.
    """
    tables: list[dict] = []
    for number, line in enumerate(plain(blob).decode("utf-8", errors="replace").split("\n"), 1):
        words = line.split("#", 1)[0].split()
        if not words:
            continue
        if words[0] == "newmtl":
            tables.append({"name": line.strip()[6:].split(" # ", 1)[0].strip()})
        elif tables and words[0] == "Kd":
            tables[-1]["color"] = _color(words[1:], f"{where}:{number}: `{line.strip()}`", strict)
        elif tables and words[0] in ("Pr", "Pm", "Ns") and (value := _number(words[1:])) is not None:
            tables[-1][words[0]] = value
        elif tables and words[0] == "map_Kd" and len(words) > 1:
            tables[-1]["texture"] = beside(Path(where), _file_of_map(words[1:]))
    return [_material(table) for table in tables]


def _material(table: dict) -> Material:
    shine = table.get("Ns", 0.0)
    roughness = table.get("Pr", 1.0 - min(max(shine, 0.0) / 1000.0, 1.0) ** 0.5)
    texture = table.get("texture")
    unsaid = (1.0 if texture else UNSAID,) * 3
    return Material(
        table["name"],
        table.get("color", unsaid),
        min(max(roughness, 0.0), 1.0),
        min(max(table.get("Pm", 0.0), 0.0), 1.0),
        texture,
    )


def _number(words: list[str]) -> float | None:
    try:
        value = float(words[0])
    except (ValueError, IndexError):
        return None
    return value if abs(value) < 1e30 else None


def _file_of_map(words: list[str]) -> str:
    """The file of a line such as `-s 1 1 1 -bm 0.5 my cloth.png`: what stands after the last option."""
    takes = {"-blendu": 1, "-blendv": 1, "-cc": 1, "-clamp": 1, "-texres": 1, "-bm": 1, "-imfchan": 1, "-mm": 2, "-type": 1,
             "-boost": 1, "-colorspace": 1}  # fmt: skip
    i = 0
    while i < len(words) - 1 and words[i].startswith("-"):
        option, i = words[i], i + 1
        if option in ("-o", "-s", "-t"):
            most = i + 3
            while i < min(most, len(words) - 1) and _number([words[i]]) is not None:
                i += 1
        else:
            i += takes.get(option, 1)
    return " ".join(words[i:])


def _color(words: list[str], where: str, strict: bool) -> tuple[float, float, float]:
    try:
        color = tuple(float(word) for word in words[:3])
    except ValueError:
        color = ()
    if not strict and len(color) == 1:
        color = color * 3
    wrong = len(color) != 3 or not all(abs(c) < 1e30 for c in color)
    if strict and (wrong or not all(0 <= c <= 1 for c in color)):
        raise InputError(f"{where}: expected three numbers from 0 to 1; change it")
    if wrong:
        warn(f"{where}: no colour that can be read, expected three numbers from 0 to 1; it is grey")
        return (MISSING,) * 3
    if not all(0 <= c <= 1 for c in color):
        warn(f"{where}: clamped to 0 to 1")
    r, g, b = (min(max(c, 0.0), 1.0) for c in color)
    return r, g, b
