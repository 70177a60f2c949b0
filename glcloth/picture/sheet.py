"""Contact sheets: many fabrics from afar and near by, each with its name, weave and sett below."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ..color import luminance, srgb_decode
from ..fabric import Fabric, load_fabric
from ..image import write_image
from ..progress import track
from ..weave.floats import float_lengths
from .patch import patch, patch_camera
from .renderer import Renderer

COLUMNS = 4
FAR, NEAR = (208, 156), (156, 156)  # pixels
WIDE = 0.02  # metres of cloth that the near picture is wide
LABEL, MARGIN = 36, 10  # pixels
PAPER, INK, FAINT = 0.16, 0.92, 0.62  # of the screen's white
BRIGHTEST = 0.4  # mean luminance of a near picture
ROOM = 60  # letters of a line of text


def fabric_sheet(path: str | Path, fabrics: Sequence[str], device: int | str | None = None) -> None:
    """Render `fabrics` and write them in rows of four: draped, and two centimetres of each with its threads.

    Near pictures are darkened where they would be overexposed: a satin may mirror the lamp.
    The plainest and finest weaves come first, fabrics without a weave last. Raises InputError if it cannot be written.
    """
    known = sorted(((name, load_fabric(name)) for name in fabrics), key=lambda one: _order(*one))
    mesh, camera = patch(2.0 * WIDE), patch_camera(WIDE, NEAR[0] / NEAR[1])
    cells = []
    with Renderer(device) as renderer:
        for name, fabric in track(known, "fabrics", len(known)):
            far = renderer.render(fabric=fabric, mesh="drape", size=FAR, adaptive=True, spp=2)[..., :3]
            near = renderer.render(
                fabric=fabric, mesh=mesh, camera=camera, size=NEAR, threads=True, shadows="off", spp=4
            )[..., :3]
            near *= min(1.0, BRIGHTEST / max(float(luminance(near).mean()), 1e-6))
            pictures = np.concatenate([far, near], 1)
            cells.append(np.pad(np.concatenate([pictures, _label(name, fabric)]), _MARGINS, constant_values=_LINEAR))
    blank = np.full_like(cells[0], _LINEAR)
    cells += [blank] * (-len(cells) % COLUMNS)
    lines = [np.concatenate(cells[i : i + COLUMNS], 1) for i in range(0, len(cells), COLUMNS)]
    write_image(path, np.concatenate(lines))


_LINEAR = float(srgb_decode(np.array(PAPER)))
_MARGINS = ((MARGIN, 0), (MARGIN, MARGIN), (0, 0))


def _order(name: str, fabric: Fabric) -> tuple:
    """Fabrics without a weave behind the others; these by the length of their floats, then by fineness."""
    weave = fabric.weave
    if weave is None:
        return 1, 0.0, 0.0, name
    picks, ends = weave.drafted.structure
    mean = max(float(n.mean()) if n.size else 0.0 for n in float_lengths(weave.drafted.drawdown[:picks, :ends]))
    return 0, round(mean, 2), -weave.ends_per_cm * weave.picks_per_cm, name


def _label(name: str, fabric: Fabric) -> np.ndarray:
    """A strip with the name, and below it what is woven; linear [LABEL, width, 3]."""
    strip = Image.new("L", (FAR[0] + NEAR[0], LABEL), round(255 * PAPER))
    draw = ImageDraw.Draw(strip)
    weave = fabric.weave
    sett = "" if weave is None else f"{weave.drafted.title}, {weave.ends_per_cm:.3g} x {weave.picks_per_cm:.3g} a cm"
    for text, size, y, ink in ((name, 14, 2, INK), (f"{fabric.name}; {sett}".rstrip("; "), 11, 19, FAINT)):
        text = text if len(text) <= ROOM else f"{text[: ROOM - 3]}..."
        draw.text((2, y), text, fill=round(255 * ink), font=ImageFont.load_default(size))
    return np.repeat(srgb_decode(np.asarray(strip, float) / 255.0)[..., None], 3, -1).astype(np.float32)
