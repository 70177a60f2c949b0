"""Read OpenEXR pictures: parts, layers, windows, chroma, chromaticities; what is asked of them is checked before they
are decoded."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, meant
from ..progress import warn
from .common import broken, check_pixels, silence
from .primaries import converted, rec709_from

RGB, LUMINANCE = ("R", "G", "B", "A"), ("Y", "RY", "BY", "A")
FAULTS = (RuntimeError, ValueError, TypeError, KeyError, IndexError, OverflowError, MemoryError)
DATA = {"normal": "N", "position": "P", "depth": "Z"}  # layers that are no pictures, and how most programs call them
# Layers that hold the whole picture, by what programs call them.
WHOLE = ("beauty", "combined", "rgba", "rgb", "color", "c", "image", "composite")


@dataclass(frozen=True)
class _Layer:
    """Channels of one part that make a picture: roles of `channels` to their names; `name` is how a user calls it; `plain`:
    the channels' names are the roles themselves."""

    part: int
    name: str
    channels: dict[str, str]
    plain: bool

    @property
    def gray(self) -> bool:
        return "Y" in self.channels


def open_exr(path: Path, header_only: bool = False) -> list:
    """Parts of an OpenEXR file, with separate channels. Raises InputError."""
    import OpenEXR

    try:
        with silence():
            file = OpenEXR.File(str(path), separate_channels=True, header_only=header_only)
            parts = list(file.parts)
            for part in parts:  # a name that is no text is told of when it is asked for
                _ = [channel.name for channel in part.header.get("channels") or ()]
    except FAULTS:
        raise broken(path) from None
    if not parts:
        raise broken(path)
    return parts


def is_cube(path: Path) -> bool:
    """Whether a file says that it is a cube map."""
    return "cube" in str(open_exr(path, header_only=True)[0].header.get("envmap", "")).lower()


def read_exr(path: Path, layer: str = "") -> np.ndarray:
    """Pixels [H, W, 3 or 4] of the picture in a file, linear Rec. 709, its display window.

    layer : the layer or part to take; "": the first part with plain R, G, B (one called beauty before others), then Y,
        then any layer, and a warning says which one where there are several. A layer that is no picture is found by its
        name alone: vectors as [H, W, 3 or 2], single values such as depth as [H, W, 1]. Raises InputError for a name that
        is not there, and for a file that is damaged or too large.
    """
    headers = [part.header for part in open_exr(path, header_only=True)]
    _check_size(path, headers)
    chosen = _data_layer(headers, layer) or _chosen(path, _layers(headers), layer)
    try:
        part = open_exr(path)[chosen.part]
        planes = {role: _full_size(part.channels[name]) for role, name in chosen.channels.items()}
    except (AttributeError, ValueError, KeyError, IndexError):
        raise broken(path, "its pixels are deep or missing") from None
    if chosen.gray:
        planes |= _rgb_from_luminance_chroma(planes)
    order = [planes[role] for role in "RGBA" if role in planes]
    if len({plane.shape for plane in order}) != 1:
        raise broken(path, "its channels differ in size")
    image = _in_display_window(np.stack(order, -1).astype(np.float32), part.header)
    matrix = rec709_from(part.header["chromaticities"]) if "chromaticities" in part.header else None
    if matrix is not None and not chosen.gray:
        warn(f"{path}: its chromaticities are converted to those of Rec. 709, white adapted by Bradford")
        image = converted(image, matrix)
    return image


def _check_size(path: Path, headers: list[dict]) -> None:
    """Refuse too many pixels by the headers alone: of all channels of all parts, and of the windows shown."""
    size, samples = path.stat().st_size, 0
    for header in headers:
        (x_0, y_0), (x_1, y_1) = _window(path, header, "dataWindow")
        width, height = x_1 - x_0 + 1, y_1 - y_0 + 1
        check_pixels(path, width, height, size)
        samples += width * height * max(len(header.get("channels") or ()), 1)
        (x_0, y_0), (x_1, y_1) = _window(path, header, "displayWindow")
        check_pixels(path, x_1 - x_0 + 1, y_1 - y_0 + 1, size)
    check_pixels(path, samples // 4, 1, size)


def _window(path: Path, header: dict, name: str) -> tuple[tuple[int, int], tuple[int, int]]:
    try:
        (x_0, y_0), (x_1, y_1) = header[name]
        return (int(x_0), int(y_0)), (int(x_1), int(y_1))
    except (KeyError, TypeError, ValueError):
        raise broken(path, f"it has no {name}") from None


def _layers(headers: list[dict]) -> list[_Layer]:
    """All pictures of a file, the likeliest first."""
    found: list[tuple[tuple, _Layer]] = []
    for number, header in enumerate(headers):
        groups = _groups(header)
        part = str(header.get("name") or "") if len(headers) > 1 else ""
        for prefix, roles in groups.items():
            for rank, wanted in enumerate((RGB, LUMINANCE)):
                if all(role in roles for role in (wanted[:3] if wanted is RGB else wanted[:1])):
                    name = prefix if not part or prefix == part or prefix.startswith(f"{part}.") else f"{part}.{prefix}"
                    name = (name or part).rstrip(".")
                    last = name.rpartition(".")[2].lower()
                    key = prefix != "", rank, bool(name) and last not in WHOLE, number
                    channels = {role: roles[role] for role in wanted if role in roles}
                    found.append((key, _Layer(number, name, channels, prefix == "")))
                    break
    return [layer for _, layer in sorted(found, key=lambda item: item[0])]


def _groups(header: dict) -> dict[str, dict[str, str]]:
    """The channels of a part by the name of their layer and their role in it."""
    groups: dict[str, dict[str, str]] = {}
    for channel in header.get("channels") or ():
        prefix, _, role = channel.name.rpartition(".")
        groups.setdefault(prefix, {})[role.upper()] = channel.name
    return groups


def _data_layer(headers: list[dict], wanted: str) -> _Layer | None:
    """The layer of a name that holds vectors (x y z or u v) or one value a pixel, if there is one; not plain Y."""
    wanted = DATA.get(wanted.lower(), wanted)
    for number, header in enumerate(headers) if wanted else ():
        groups = _groups(header)
        roles = groups.get(wanted, {})
        for names in (("X", "Y", "Z"), ("U", "V")):
            if set(roles) == set(names):
                return _Layer(number, wanted, {new: roles[old] for new, old in zip("RGB", names, strict=False)}, False)
        single = list(roles.values()) if len(roles) == 1 and "Y" not in roles else []
        single += [name for name in groups.get("", {}).values() if name == wanted]
        if single:
            return _Layer(number, wanted, {"R": single[0]}, False)
    return None


def _chosen(path: Path, layers: list[_Layer], wanted: str) -> _Layer:
    if not layers:
        raise InputError(f"{path}: no part has R, G, B or Y channels, expected a colour picture; export one")
    names = [layer.name or "(unnamed)" for layer in layers]
    if wanted:
        for fits in (lambda name: name == wanted, lambda name: name.lower() == wanted.lower(),
                     lambda name: name.rpartition(".")[2].lower() == wanted.lower()):  # fmt: skip
            for layer, name in zip(layers, names, strict=True):
                if fits(name) or fits(layer.name):
                    return layer
        hint = meant(wanted, names, "; did you mean {}?")
        raise InputError(f"{path}: has no layer {wanted}, expected {', '.join(dict.fromkeys(names))}{hint}")
    if len(layers) > 1 and (not layers[0].plain or layers[1].plain):
        others = ", ".join(dict.fromkeys(names[1:]))
        warn(f"{path}: layer {names[0]} is taken, there are also {others}; choose by --layer NAME")
    return layers[0]


def _full_size(channel: Any) -> np.ndarray:
    pixels = np.asarray(channel.pixels)
    if pixels.dtype == object or pixels.ndim != 2:
        raise ValueError
    plane = pixels.astype(np.float32)
    if channel.xSampling > 1 or channel.ySampling > 1:
        plane = np.repeat(np.repeat(plane, channel.ySampling, 0), channel.xSampling, 1)
    return plane


def _rgb_from_luminance_chroma(planes: dict) -> dict:
    """RY = (R - Y) / Y and BY = (B - Y) / Y   ["Technical Introduction to OpenEXR", Luminance/Chroma Images]"""
    Y = planes["Y"]
    if "RY" not in planes or "BY" not in planes:
        return {"R": Y, "G": Y, "B": Y}
    height, width = Y.shape
    R = (planes["RY"][:height, :width] + 1) * Y
    B = (planes["BY"][:height, :width] + 1) * Y
    w_R, w_G, w_B = 0.2126, 0.7152, 0.0722
    return {"R": R, "G": (Y - w_R * R - w_B * B) / w_G, "B": B}


def _in_display_window(image: np.ndarray, header: dict) -> np.ndarray:
    """Place the stored pixels in the display window: cropped files keep their place, overscan is cut."""
    try:
        (x_0, y_0), (x_1, y_1) = (np.asarray(corner, int) for corner in header["displayWindow"])
        left, top = (int(value) for value in header["dataWindow"][0])
    except (KeyError, TypeError, ValueError):
        return image
    width, height = x_1 - x_0 + 1, y_1 - y_0 + 1
    if (left, top) == (x_0, y_0) and image.shape[:2] == (height, width):
        return image
    canvas = np.zeros((height, width, image.shape[2]), image.dtype)
    dy, dx = top - y_0, left - x_0
    rows = slice(max(dy, 0), min(dy + image.shape[0], height))
    columns = slice(max(dx, 0), min(dx + image.shape[1], width))
    if rows.start < rows.stop and columns.start < columns.stop:
        canvas[rows, columns] = image[rows.start - dy : rows.stop - dy, columns.start - dx : columns.stop - dx]
    return canvas
