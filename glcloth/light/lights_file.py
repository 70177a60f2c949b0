"""Lights as files: JSON or TOML, the same fields in both."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import tomli_w

from ..errors import InputError, short
from ..files import atomic_write, path_of, read_json, read_text, read_toml
from .lights import SUN_RADIUS, Lights, SphericalGaussians, Suns, as_lights

FORMAT = "glcloth lights 1"
_NOTE = "linear Rec. 709; +y up; radiance = sum of amplitude * exp(sharpness * (direction . axis - 1)), plus the suns"


def save_lights(path: str | Path, lights: Lights | SphericalGaussians, about: dict | None = None) -> Path:
    """Write lights to .json or .toml (`about`: where they come from, kept under "about"); return the path.

    Every number is written so that it reads back to the same float64. Raises InputError on another suffix or when
    the file cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in (".json", ".toml"):
        raise InputError(f"{path}: cannot write lights as {path.suffix or 'no suffix'}, expected .json or .toml")
    lights = as_lights(lights)
    g, s = lights.gaussians, lights.suns
    data = {
        "format": FORMAT,
        "note": _NOTE,
        "about": about or {},
        "gaussian": [
            {"axis": x.tolist(), "sharpness": float(k), "amplitude": a.tolist()}
            for x, k, a in zip(g.axis, g.sharpness, g.amplitude, strict=True)
        ],
        "sun": [
            {"direction": d.tolist(), "irradiance": e.tolist(), "radius_deg": float(np.degrees(r))}
            for d, e, r in zip(s.direction, s.irradiance, s.radius, strict=True)
        ],
    }
    text = json.dumps(data, indent=2) + "\n" if path.suffix.lower() == ".json" else tomli_w.dumps(data)
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def load_lights(path: str | Path) -> Lights:
    """Read lights written by save_lights (or by hand). Raises InputError when the file is missing or wrong."""
    path = path_of(path)
    if path.suffix.lower() not in (".json", ".toml"):
        raise InputError(f"{path}: cannot read lights from {path.suffix or 'no suffix'}, expected .json or .toml")
    expected = "a file of lights"
    if path.suffix.lower() == ".json":
        data = read_json(read_text(path, expected), str(path), expected)
    else:
        data = read_toml(path, expected)
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise InputError(f'{path}: holds no lights, expected format = "{FORMAT}"; make it with: glcloth env MAP')
    gaussians, suns = _table(path, data, "gaussian"), _table(path, data, "sun")
    try:
        return Lights(
            SphericalGaussians(
                _column(path, gaussians, "gaussian", "axis", (3,)),
                _column(path, gaussians, "gaussian", "sharpness", ()),
                _column(path, gaussians, "gaussian", "amplitude", (3,)),
            ),
            Suns(
                _column(path, suns, "sun", "direction", (3,)),
                _column(path, suns, "sun", "irradiance", (3,)),
                np.radians(_column(path, suns, "sun", "radius_deg", (), np.degrees(SUN_RADIUS))),
            ),
        )
    except InputError as error:
        message = str(error)
        raise InputError(message if message.startswith(str(path)) else f"{path}: {message}") from None


def _table(path: Path, data: dict, key: str) -> list[dict]:
    rows = data.get(key, [])
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise InputError(f"{path}: {key}: expected a list of tables; see a file written by glcloth env")
    return rows


def _column(
    path: Path, rows: list[dict], key: str, field: str, shape: tuple, default: float | None = None
) -> np.ndarray:
    result = np.zeros((len(rows), *shape))
    for number, row in enumerate(rows, 1):
        try:
            value = np.array(row[field] if default is None else row.get(field, default), float)
        except (KeyError, TypeError, ValueError, OverflowError):
            value = None
        if value is None or value.shape != shape or not np.all(np.isfinite(value)):
            expected = "3 finite numbers" if shape else "a finite number"
            raise InputError(f"{path}: {key} {number}: {field} = {short(row.get(field))}, expected {expected}")
        result[number - 1] = value
    return result
