"""Contact sheets: many fabrics from afar and near by, each with its name, weave and sett below."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ..color import luminance, srgb_decode
from ..fabric import Fabric, load_fabric
from ..image import write_image
from ..light import equirect
from ..light.environment import Environment, load_environment
from ..progress import track
from .patch import patch, patch_camera
from .renderer import Renderer

COLUMNS = 4
FAR, NEAR = (232, 184), (184, 184)  # pixels
WIDE = 0.02  # metres of cloth that the near picture is wide
LABEL, MARGIN, HEADING = 40, 14, 44  # pixels
PAPER, INK, FAINT = 0.27, 0.95, 0.68  # of the screen's white
MIDDLE = 0.35  # luminance at which a picture stays as it is exposed
FAR_EVENED, NEAR_EVENED = 0.25, 0.55  # how far others are brought there: 0 not at all, 1 wholly
ROOM = 64  # letters of a line of text

FAMILIES = {
    "Silks and satins": (
        *(
            "habotai",
            "crepe_de_chine",
            "silk_crepe_de_chine",
            "organza",
            "taffeta",
            "shot_taffeta",
            "silk_shot",
            "faille",
        ),
        *("charmeuse", "satin_charmeuse_front", "satin_charmeuse_back", "duchesse_satin"),
    ),
    "Cottons": (
        *("voile", "percale", "poplin", "chambray", "oxford", "gingham", "calico", "canvas", "sateen", "drill"),
        *("denim_raw", "denim_washed", "flannel", "mock_leno", "waffle"),
    ),
    "Linens": ("linen_light", "linen", "linen_heavy", "damask", "drawn_thread"),
    "Wools": ("gabardine", "hopsack", "houndstooth", "herringbone_tweed", "tartan"),
    "Velvets": ("velvet", "velvet_midnight", "velvet_ruby"),
    "Curtains": ("sheer_voile", "lace", "linen_curtain", "blackout"),
}
OTHERS = "Others"


def fabric_sheet(path: str | Path, fabrics: Sequence[str], device: int | str | None = None) -> None:
    """Render `fabrics` and write them in rows of four: draped, and two centimetres of each with its threads.

    They stand by families, as `FAMILIES` says. Pictures are balanced to a white card that stands in the same light, and dark
    and bright ones brought toward each other, those from near by more than those from afar. Raises InputError if the sheet
    cannot be written.
    """
    white = white_balance(load_environment("studio"), (0.0, 0.0, 1.0))
    families = by_family(fabrics)
    cells = {}
    with Renderer(device) as renderer:
        for name in track(fabrics, "fabrics", len(fabrics)):
            cells[name] = _cell(renderer, name, white)
    blank = np.full_like(next(iter(cells.values())), _LINEAR)
    strips = []
    for title, names in families.items():
        row = [cells[name] for name in names] + [blank] * (-len(names) % COLUMNS)
        strips.append(_text(COLUMNS * blank.shape[1], HEADING, [(title, 22, (MARGIN, 12), INK)]))
        strips += [np.concatenate(row[i : i + COLUMNS], 1) for i in range(0, len(row), COLUMNS)]
    write_image(path, np.concatenate(strips))


def by_family(fabrics: Sequence[str]) -> dict[str, list[str]]:
    """`fabrics` in the order of the sheet, family by family; those of none stand last, as they were given."""
    out = {title: [name for name in names if name in fabrics] for title, names in FAMILIES.items()}
    known = {name for names in FAMILIES.values() for name in names}
    out[OTHERS] = [name for name in fabrics if name not in known]
    return {title: names for title, names in out.items() if names}


def white_balance(environment: Environment, normal: Sequence[float]) -> np.ndarray:
    """The factors [3] that make a white card look white which faces `normal` in this light, its luminance the same."""
    radiance = environment.radiance
    height, width = radiance.shape[:2]
    omega, solid_angle = equirect.texel_directions(height, width), equirect.row_solid_angles(height, width)
    cos = np.maximum(omega @ np.asarray(normal, float), 0.0)
    card = np.einsum("hwc,hw,h->c", radiance, cos, solid_angle)
    return luminance(card) / card


def evened(picture: np.ndarray, mean: float, share: float) -> np.ndarray:
    """A linear picture, brought toward the luminance MIDDLE from `mean` by a factor."""
    return picture * (MIDDLE / max(mean, 1e-4)) ** share


_LINEAR = float(srgb_decode(np.array(PAPER)))
_MARGINS = ((MARGIN, 0), (MARGIN, MARGIN), (0, 0))


def _cell(renderer: Renderer, name: str, white: np.ndarray) -> np.ndarray:
    """Both pictures of a fabric and its label, linear [height, width, 3]."""
    fabric = load_fabric(name)
    worn = renderer.render(fabric=fabric, mesh="drape", size=FAR, adaptive=True, spp=4, background=False)
    cover = worn[..., 3:]
    cloth = worn[..., :3] * white
    far = evened(cloth, float(luminance(cloth).sum() / max(cover.sum(), 1.0)), FAR_EVENED) + (1.0 - cover) * _LINEAR
    mesh, camera = patch(2.0 * WIDE), patch_camera(WIDE, NEAR[0] / NEAR[1])
    near = renderer.render(fabric=fabric, mesh=mesh, camera=camera, size=NEAR, threads=True, shadows="off", spp=4)
    near = near[..., :3] * white
    near = evened(near, float(luminance(near).mean()), NEAR_EVENED)
    cell = np.concatenate([np.concatenate([far, near], 1), _label(name, fabric)])
    return np.pad(cell.astype(np.float32), _MARGINS, constant_values=_LINEAR)


def _label(name: str, fabric: Fabric) -> np.ndarray:
    """A strip with the name, and below it what is woven; linear [LABEL, width, 3]."""
    weave = fabric.weave
    sett = "" if weave is None else f"{weave.drafted.title}, {weave.ends_per_cm:.3g} x {weave.picks_per_cm:.3g} a cm"
    text = f"{fabric.name}; {sett}".rstrip("; ")
    text = text if len(text) <= ROOM else f"{text[: ROOM - 3]}..."
    return _text(FAR[0] + NEAR[0], LABEL, [(name, 15, (2, 3), INK), (text, 12, (2, 22), FAINT)])


def _text(width: int, height: int, lines: Sequence[tuple[str, int, tuple[int, int], float]]) -> np.ndarray:
    """A strip of paper with lines of (text, size, (x, y), share of the screen's white); linear [height, width, 3]."""
    strip = Image.new("L", (width, height), round(255 * PAPER))
    draw = ImageDraw.Draw(strip)
    for text, size, at, ink in lines:
        draw.text(at, text, fill=round(255 * ink), font=ImageFont.load_default(size))
    return np.repeat(srgb_decode(np.asarray(strip, float) / 255.0)[..., None], 3, -1).astype(np.float32)
