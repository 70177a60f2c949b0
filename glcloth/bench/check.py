"""Whether a driver can be trusted: ten small pictures against values that are kept.

Kept are the means of CELLS cells of each picture, as Mesa's llvmpipe draws it; `tests/measure/check_values.py` writes
them. Lights are given, not fitted, so that nothing but the driver differs.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import DriverError, InputError, ShaderError
from ..light.lights import Lights, SphericalGaussians, Suns
from ..picture.renderer import Renderer
from ..progress import track
from ..scene import CurtainParameters, Scene, View

VALUES = Path(__file__).parent / "check.json"
CELLS = (4, 3)  # of a picture, across and down
SIZE = (96, 72)
# Rasterisers round corners to 1/256 pixel or finer. Where all moves by 1/64 pixel, a picture's mean changes by at most
# 0.11 % and a cell by at most 0.57 %; an NVIDIA H200 differs from llvmpipe by at most 0.09 % in the mean.
MEAN_TOLERANCE = 0.005  # of the picture's mean
CELL_TOLERANCE = 0.02  # of the picture's mean, or of the cell's own where that is more

LIGHTS = Lights(
    SphericalGaussians(
        [[0, 1, 0], [0.7, 0.4, 0.6], [-0.8, 0.1, 0.6], [0.1, -1, 0.2]],
        [1.5, 40.0, 12.0, 3.0],
        [[0.4, 0.5, 0.7], [4.0, 3.6, 3.0], [1.0, 1.2, 1.5], [0.15, 0.12, 0.1]],
    ),
    Suns([[0.3, 0.8, 0.5]], [[0.8, 0.75, 0.6]]),
)
# By both ways of shading, whichever is faster here.
_CLOTH: dict[str, Any] = {
    "lights": LIGHTS,
    "background": False,
    "shadows": "off",
    "size": SIZE,
    "shade": "fragment",
}
_CURTAIN = Scene(
    fabric="sheer_voile",
    size=SIZE,
    frame=3,
    curtain=CurtainParameters(quads=(72, 18), pleats=6, settle=0.1, wind=1.0),
    gi="off",  # even light: what is stored is of the tracer alone
)
# What is rendered: a scene, or changes of the default one.
PICTURES: Mapping[str, dict[str, Any]] = {
    "direct": {**_CLOTH, "fabric": "silk_crepe_de_chine"},
    "paper": {**_CLOTH, "fabric": "linen", "method": "paper", "grid": 16, "shade": "compute"},
    "reference": {**_CLOTH, "fabric": "velvet", "method": "reference", "cube": 8},
    "shadows": {**_CLOTH, "fabric": "satin_charmeuse_front", "mesh": "plane", "objects": ("plane@0.25,0.1,0.25,0.5,40",),
                "ground": "auto", "shadows": "full"},
    "threads": {**_CLOTH, "fabric": "denim_raw", "mesh": "plane",
                "camera": View(eye=(0.0, 0.012, 0.008), target=(0.0, 0.0, 0.0))},
    "sheer": {**_CLOTH, "fabric": "sheer_voile", "mesh": "sphere", "background": True, "shade": "compute"},
    "lens": {**_CLOTH, "fabric": "silk_shot", "adaptive": True, "spp": 2, "camera": View(view="three-quarter", aperture=0.1)},
    "curtain kdtree": {"scene": _CURTAIN},
    "curtain lbvh": {"scene": _CURTAIN.changed(accelerator="lbvh")},
    "curtain brute": {"scene": _CURTAIN.changed(accelerator="brute")},
}  # fmt: skip


@dataclass(frozen=True)
class Verdict:
    """How far one picture is from the kept values, in shares: its mean, and the cell that differs most; `fault` says what
    is wrong, and is empty where nothing is."""

    mean: float = 0.0
    cell: float = 0.0
    fault: str = ""


def cell_means(picture: np.ndarray) -> np.ndarray:
    """The means [CELLS[1], CELLS[0], channels] of the cells of a picture [H, W, channels], float64."""
    height, width = picture.shape[:2]
    across, down = CELLS
    cells = picture.astype(np.float64).reshape(down, height // down, across, width // across, -1)
    return cells.mean((1, 3))


def kept_values() -> dict[str, np.ndarray]:
    """The kept means of each picture. Raises InputError for a file that has others."""
    values = {name: np.array(rows) for name, rows in json.loads(VALUES.read_text(encoding="utf-8")).items()}
    if values.keys() != PICTURES.keys():
        raise InputError(f"{VALUES}: has the values of other pictures; install glcloth anew")
    return values


def judge(picture: np.ndarray, kept: np.ndarray) -> Verdict:
    """Compare a picture with its kept values."""
    found = cell_means(picture)
    if found.shape != kept.shape:
        return Verdict(fault=f"has {found.shape[-1]} channels, expected {kept.shape[-1]}")
    if not np.isfinite(picture).all():
        return Verdict(fault=f"{(~np.isfinite(picture)).any(-1).sum()} pixels are not finite")
    whole = np.abs(kept).mean()
    mean = float(np.abs(found.mean((0, 1)) - kept.mean((0, 1))).max() / whole)
    errors = np.abs(found - kept) / np.maximum(np.abs(kept), whole)
    fault, cell = "", float(errors.max())
    if mean > MEAN_TOLERANCE:
        fault = f"its mean is {100 * mean:.2f} % off"
    elif cell > CELL_TOLERANCE:
        row, column = np.unravel_index(np.argmax(errors), kept.shape)[:2]
        fault = f"{100 * cell:.1f} % off in column {column + 1} of {CELLS[0]}, row {row + 1} of {CELLS[1]}"
    return Verdict(mean, cell, fault)


def check(renderer: Renderer, kept: Mapping[str, np.ndarray] | None = None) -> dict[str, Verdict]:
    """Render the pictures and judge each; what a driver refuses is a fault of its picture."""
    kept = kept_values() if kept is None else kept
    return {name: _verdict(renderer, PICTURES[name], kept[name]) for name in track(list(kept), "check: pictures")}


def _verdict(renderer: Renderer, picture: Mapping[str, Any], kept: np.ndarray) -> Verdict:
    try:
        return judge(np.asarray(renderer.render(**picture)), kept)
    except (ShaderError, DriverError, InputError) as error:  # the last: its memory is at an end
        return Verdict(fault=str(error).splitlines()[0])
