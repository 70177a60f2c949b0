"""A grid of parameters: one picture for each combination, a contact sheet of all, and a table."""

from __future__ import annotations

import csv
import functools
import itertools
import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from ..color import luminance
from ..errors import InputError, meant
from ..fabric import Yarn, load_fabric
from ..files import atomic_write
from ..image import read_image, write_image
from ..picture.options import OPTIONS, SEVERAL, with_options
from ..picture.renderer import Renderer
from ..scene import Scene, header

MOST = 10_000
YARNS = {"warp": 0, "weft": 1}
WIDEST = 320  # pixels of a picture on the sheet
LABEL = 18  # pixels of a line of text
EDGE = 4  # pixels between pictures of the sheet


@dataclass(frozen=True)
class Sweep:
    """All combinations of some parameters' values, the last parameter fastest.

    scene : what does not vary. folder, suffix : where pictures go, 0000.png and so on
    names, values : the parameters, fields of the scene, or of a yarn such as warp.gamma_s_deg; and the values of each
    """

    scene: Scene
    folder: Path
    names: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...]
    suffix: str = ".png"
    device: int | str | None = None

    @functools.cached_property
    def rows(self) -> list[tuple[Any, ...]]:
        """The combinations in their order."""
        return list(itertools.product(*self.values))

    def scene_at(self, number: int) -> Scene:
        """The scene of a combination. Raises InputError for values that cannot be."""
        try:
            return self._scene_at(number)
        except InputError as error:
            said = ", ".join(f"{n}={v}" for n, v in zip(self.names, self.rows[number], strict=True))
            raise InputError(f"--vary: {said}: {error}") from None

    def _scene_at(self, number: int) -> Scene:
        said = dict(zip(self.names, self.rows[number], strict=True))
        yarns = {name: value for name, value in said.items() if "." in name}
        options = {name: [value] if name in SEVERAL else value for name, value in said.items() if "." not in name}
        changed = with_options(self.scene, options)
        if not yarns:
            return changed
        fabric = load_fabric(changed.fabric)
        both = list(fabric.yarn)
        for name, value in yarns.items():
            which, field = name.split(".")
            both[YARNS[which]] = both[YARNS[which]].changed(**{field: value})
        return changed.changed(fabric=fabric.changed(yarn=tuple(both)))

    # -- a job of many processes -------------------------------------------------------------------------------------

    def file(self, number: int) -> Path:
        """The picture of a combination."""
        return self.folder / f"{number:0{max(4, len(str(len(self.rows) - 1)))}d}{self.suffix}"

    def header(self, number: int) -> dict:
        """The scene as a picture keeps it."""
        return header(self.scene_at(number))

    def pictures(self, numbers: Iterable[int]) -> Iterator[np.ndarray]:
        """Yield the pictures of some combinations."""
        with Renderer(self.device) as renderer:
            for number in numbers:
                yield renderer.render(self.scene_at(number))

    def write(self, number: int, picture: np.ndarray) -> dict:
        """Write a picture, whole or not at all."""
        scene = self.scene_at(number)
        look = {"exposure": scene.exposure, "view_transform": scene.transform}
        write_image(self.file(number), picture, header(scene), **look)
        return {"number": number, "file": str(self.file(number))}


def parse_vary(texts: Sequence[str]) -> tuple[tuple[str, ...], tuple[tuple[Any, ...], ...]]:
    """The parameters and values of options such as fabric=linen,silk_shot or env-rotate=0:180:30 (ends included).

    Values that hold commas are set apart by semicolons. Raises InputError.
    """
    known = set(OPTIONS) | {"frame"}
    numbers = [name for name, field in Yarn.model_fields.items() if field.annotation is float]
    known |= {f"{yarn}.{name}" for yarn in YARNS for name in numbers}
    names, values = [], []
    for text in texts:
        name, equals, said = text.partition("=")
        name = name.strip().lstrip("-").replace("-", "_")
        name = {"object": "objects", "fov": "fov_deg"}.get(name, name)
        if name not in known:
            raise InputError(
                f"--vary {text}: no parameter {name}; {meant(name, known)}an option of render, or {sorted(known)[-1]} and so on"
            )
        if not equals or not said.strip():
            raise InputError(f"--vary {text}: expected values, such as {name}=A,B or {name}=0:180:30")
        if name in names:
            raise InputError(f"--vary {text}: {name} is varied already; give all its values at once")
        names.append(name)
        values.append(_values(said, text))
    if math.prod(map(len, values)) > MOST:
        raise InputError(f"--vary: {math.prod(map(len, values))} pictures, expected at most {MOST}")
    return tuple(names), tuple(values)


def _values(said: str, text: str) -> tuple[Any, ...]:
    parts = said.split(":")
    if len(parts) == 3:
        try:
            first, last, step = map(float, parts)
        except ValueError:
            first, last, step = math.nan, math.nan, math.nan
        if not (all(map(math.isfinite, (first, last, step))) and step and (last - first) / step >= 0):
            raise InputError(f"--vary {text}: expected first:last:step such as 0:180:30")
        if (last - first) / step > MOST:
            raise InputError(f"--vary {text}: more than {MOST} values; choose a larger step")
        numbers = [round(first + i * step, 12) for i in range(math.floor((last - first) / step + 1e-9) + 1)]
        return tuple(int(n) if n == int(n) else n for n in numbers)
    return tuple(part.strip() for part in said.split(";" if ";" in said else ",") if part.strip())


def write_tables(sweep: Sweep) -> list[Path]:
    """Write sheet.png, table.csv and table.json beside the pictures; their paths. Raises InputError."""
    rows, pictures = [], []
    for number, values in enumerate(sweep.rows):
        picture = read_image(sweep.file(number))[..., :3]
        mean = [round(float(v), 6) for v in picture.reshape(-1, 3).mean(0)]
        row = {"picture": sweep.file(number).name, **dict(zip(sweep.names, values, strict=True))}
        rows.append(row | dict(zip(("mean_r", "mean_g", "mean_b"), mean, strict=True)))
        rows[-1]["mean_luminance"] = round(float(luminance(picture).mean()), 6)
        pictures.append(_small(picture))
    paths = [sweep.folder / name for name in ("sheet.png", "table.csv", "table.json")]
    look = {"exposure": sweep.scene.exposure, "view_transform": sweep.scene.transform}
    write_image(paths[0], _sheet(sweep, pictures), **(look if sweep.suffix == ".exr" else {}))
    with atomic_write(paths[1]) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    with atomic_write(paths[2]) as temporary:
        temporary.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return paths


def _small(picture: np.ndarray) -> np.ndarray:
    """A picture at most WIDEST wide, by means of whole blocks."""
    n = -(-picture.shape[1] // WIDEST)
    height, width = (max(side // n, 1) for side in picture.shape[:2])
    n = min(n, *picture.shape[:2])
    return picture[: height * n, : width * n].reshape(height, n, width, n, 3).mean((1, 3))


def _sheet(sweep: Sweep, pictures: list[np.ndarray]) -> np.ndarray:
    """Rows of pictures with what they show below: a column for each value of the last parameter."""
    height, width = (max(p.shape[axis] for p in pictures) for axis in (0, 1))
    columns = len(sweep.values[-1])
    cells = []
    for values, picture in zip(sweep.rows, pictures, strict=True):
        cell = np.zeros((height, width, 3), np.float32)
        cell[: picture.shape[0], : picture.shape[1]] = picture
        said = [f"{name}={Path(str(value)).name}" for name, value in zip(sweep.names, values, strict=True)]
        strips = [label(line, width) for line in _lines(said, width)]
        cells.append(np.pad(np.concatenate([cell, *strips]), ((0, EDGE), (0, EDGE), (0, 0))))
    tallest = max(len(cell) for cell in cells)
    cells = [np.pad(cell, ((0, tallest - len(cell)), (0, 0), (0, 0))) for cell in cells]
    return np.concatenate([np.concatenate(cells[i : i + columns], 1) for i in range(0, len(cells), columns)])


def label(text: str, width: int) -> np.ndarray:
    """A strip with `text`, linear, so many pixels wide."""
    strip = Image.new("L", (width, LABEL))
    ImageDraw.Draw(strip).text((4, 3), text, fill=255)
    return np.repeat((np.asarray(strip, np.float32) / 255.0)[..., None], 3, -1)


def _lines(words: list[str], width: int) -> list[str]:
    """Words in lines that fit a width in pixels, about six to a letter."""
    lines = [""]
    for word in words:
        longer = f"{lines[-1]}  {word}".strip()
        if lines[-1] and 6 * len(longer) > width:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines
