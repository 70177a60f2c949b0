"""Contact sheets: many fabrics on the built-in cloth, each with its name below."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from ..image import write_image
from ..progress import track
from .renderer import Renderer

CELL, LABEL, COLUMNS = (240, 180), 18, 6


def fabric_sheet(path: str | Path, fabrics: Sequence[str], device: int | None = None) -> None:
    """Render `fabrics` at drape distance and write them in rows of six. Raises InputError if it cannot be written."""
    rows = []
    with Renderer(device) as renderer:
        for name in track(fabrics, "fabrics", len(fabrics)):
            picture = renderer.render(fabric=name, mesh="drape", size=CELL, adaptive=True)[..., :3]
            rows.append(np.concatenate([picture, _label(name)]))
    blank = np.zeros_like(rows[0])
    rows += [blank] * (-len(rows) % COLUMNS)
    lines = [np.concatenate(rows[i : i + COLUMNS], 1) for i in range(0, len(rows), COLUMNS)]
    write_image(path, np.concatenate(lines))


def _label(text: str) -> np.ndarray:
    """A strip with `text`, linear."""
    strip = Image.new("L", (CELL[0], LABEL))
    ImageDraw.Draw(strip).text((4, 3), text, fill=255)
    return np.repeat((np.asarray(strip, np.float32) / 255.0)[..., None], 3, -1)
