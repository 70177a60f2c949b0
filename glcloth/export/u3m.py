"""U3M 1.1, the apparel industry's material file: `.u3m` with its maps beside it, and `.u3ma`, all in one archive.

[Vizoo et al., Unified 3D Material 1.1, github.com/vizoogmbh/u3m: u3m_schema.json and the texts beside it]
"""

from __future__ import annotations

import datetime
import hashlib
import json
import re
import struct
import uuid
import zlib
from pathlib import Path

import numpy as np

from .. import __version__
from ..color import srgb_encode
from ..errors import InputError
from ..fabric import Fabric
from ..files import atomic_write
from .maps import Textures, make_textures, normal_map, png
from .models import Fitted, fit_principled
from .original import Response

MM = 1000.0  # in a metre
INCH = 25.4  # millimetres
CONSTRUCTIONS = (("plain", "Plain weave"), ("twill", "Twill"), ("satin", "Satin"), ("oxford", "Oxford"))
CONSTRUCTIONS += (("waffle", "Waffle"),)


def write_u3m(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
    """The material as JSON; its maps lie in a folder beside it. Raises InputError where that cannot be made."""
    folder = path.parent / f"{_plain(path.stem)}_maps"
    document, maps, fit = _material(fabric, folder.name)
    try:
        if maps:
            folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror}); choose another name") from None
    for name, data in maps.items():
        with atomic_write(path.parent / name) as temporary:
            temporary.write_bytes(data)
    with atomic_write(path) as temporary:
        temporary.write_bytes(document)
    return [path, *(path.parent / name for name in maps)], fit.model


def write_u3ma(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
    """The material and its maps in one archive."""
    name = _plain(path.stem)
    document, maps, fit = _material(fabric, f"{name}_maps")
    with atomic_write(path) as temporary:
        temporary.write_bytes(archive({f"{name}.u3m": document, **maps}))
    return [path], fit.model


def _plain(name: str) -> str:
    """A name that paths in a U3M may have."""
    return re.sub(r"[^A-Za-z0-9_-]", "_", name) or "cloth"


# -- the material ------------------------------------------------------------------------------------------------------


def _material(fabric: Fabric, folder: str) -> tuple[bytes, dict[str, bytes], Fitted]:
    """The file's text, the maps by their paths, and the fit that both stand on."""
    fit = fit_principled(fabric)
    textures = make_textures(fabric, fit.color("base"), fit.values["roughness"])
    low, high = (float(MM * end) for end in (textures.height.min(), textures.height.max()))
    span = high - low or 1.0
    # Software must read 8-bit RGB; nothing says that it reads grey.
    grey = {
        "alpha": textures.opacity,
        "roughness": textures.roughness,
        "displacement": (MM * textures.height - low) / span,
    }
    maps = {"basecolor": png(textures.color, srgb=True), "normal": png(normal_map(textures))}
    maps |= {name: png(np.repeat(values[..., None], 3, -1)) for name, values in grey.items()}
    paths = {name: f"{folder}/{name}.png" for name in maps}
    images = {name: _image(path, textures) for name, path in paths.items()}
    if fabric.weave is None:  # even maps say nothing that a number does not
        maps, images = {}, {}
    now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    numbers = fabric.model_dump_json(exclude={"name"})
    document = {
        "schema": "1.1",
        "material": {
            "id": str(uuid.UUID(bytes=hashlib.sha256(numbers.encode()).digest()[:16], version=4)),
            "name": fabric.name,
            "description": f"woven cloth, made by glcloth {__version__}; u along the warp, v along the weft",
            "created": now,
            "modified": now,
            "front": _front(fabric, fit, textures, images, (low, span)),
            "back": None,
            "side": None,
            "physics": _physics(fabric),
            "metadata": None,
        },
        "custom": None,
    }
    return (json.dumps(document, indent=1) + "\n").encode(), {paths[n]: data for n, data in maps.items()}, fit


def _image(path: str, textures: Textures) -> dict:
    """An image of one repeat: its size in millimetres and its resolution."""
    rows, columns = textures.opacity.shape
    width, height = (MM * side for side in textures.size)
    return {
        "path": path,
        "width": width,
        "height": height,
        "dpi": {"x": columns / width * INCH, "y": rows / height * INCH},
        "repeat": {"mode": "normal", "rotation": 0.0},
    }


def _front(fabric: Fabric, fit: Fitted, textures: Textures, images: dict, height: tuple[float, float]) -> dict:
    """The visualisation: what the fit says, with the maps where there are some; the rest is off."""
    values = fit.values
    opacity = float(textures.opacity.mean())
    if fabric.weave is None and (through := fabric.transmission) is not None:
        opacity = 1.0 - through.openness * through.k_a
    up = {"constant": {"x": 0.0, "y": 0.0, "z": 1.0}, "texture": None}
    normal = dict(up)
    if "normal" in images:
        normal["texture"] = {"scale": 1.0, "image": images["normal"]}
    color = _color(textures.color.mean((0, 1)))
    if "basecolor" in images:
        factor = {"r": 1.0, "g": 1.0, "b": 1.0}
        color["texture"] = {"mode": "multiply", "factor": factor, "image": images["basecolor"]}
    low, span = height
    numbers = {
        "alpha": _number(opacity, images.get("alpha")),
        "anisotropy_value": _number(values["stretch"]),
        # A share of a whole turn, from the warp's direction.
        "anisotropy_rotation": _number(0.25 if fit.across else 0.0),
        "displacement": _number(0.0, images.get("displacement"), span, low),
        "roughness": _number(values["roughness"], images.get("roughness")),
        "sheen_value": _number(values["sheen"]),
        "sheen_tint": _number(values["sheen_tint"]),
        "specular_value": _number(values["specular"]),
        "specular_tint": _number(values["specular_tint"]),
        "ior": _number(1.5),
    }
    off = (
        "clearcoat_value",
        "clearcoat_roughness",
        "metalness",
        "subsurface_radius",
        "subsurface_value",
        "transmission",
    )
    return {
        **numbers,
        **{name: _number(0.0) for name in off},
        "basecolor": color,
        "normal": normal,
        "clearcoat_normal": up,
        "subsurface_color": _color(np.ones(3)),
        "shader": "principled",
        "preview": None,
    }


def _number(constant: float, image: dict | None = None, factor: float = 1.0, offset: float = 0.0) -> dict:
    texture = None if image is None else {"factor": factor, "offset": offset, "image": image}
    return {"constant": constant, "texture": texture}


def _color(linear: np.ndarray) -> dict:
    """A colour in sRGB codes, the format's own space."""
    codes = srgb_encode(np.asarray(linear, float))
    return {"constant": dict(zip("rgb", map(float, codes), strict=True)), "texture": None}


def _physics(fabric: Fabric) -> dict:
    """What the fabric knows of it: that it is woven, and how."""
    said = fabric.weave.draft if fabric.weave is not None and isinstance(fabric.weave.draft, str) else ""
    kind = next((name for word, name in CONSTRUCTIONS if said.startswith(word)), "unknown")
    return {
        "thickness": None,
        "weight": None,
        "composition": None,
        "devices": {"fab": "null"},
        "material_type": {"type": "Woven", "name": None},
        "construction": {"type": kind, "name": None},
    }


# -- the archive -------------------------------------------------------------------------------------------------------


def archive(files: dict[str, bytes]) -> bytes:
    """A zip archive as .u3ma wants it: names in UTF-8 and flagged so, deflated, without attributes and extra fields."""
    now = datetime.datetime.now(datetime.UTC)
    date = (max(now.year, 1980) - 1980) << 9 | now.month << 5 | now.day
    time = now.hour << 11 | now.minute << 5 | now.second // 2
    body, directory = b"", b""
    for name, data in files.items():
        packer = zlib.compressobj(9, zlib.DEFLATED, -15)
        packed = packer.compress(data) + packer.flush()
        called = name.encode()
        shared = struct.pack(
            "<HHHHHIIIHH", 0x14, 1 << 11, 8, time, date, zlib.crc32(data), len(packed), len(data), len(called), 0
        )
        directory += (
            struct.pack("<IH", 0x02014B50, 0x3F) + shared + struct.pack("<HHHII", 0, 0, 0, 0, len(body)) + called
        )
        body += struct.pack("<I", 0x04034B50) + shared + called + packed
    end = struct.pack("<IHHHHIIH", 0x06054B50, 0, 0, len(files), len(files), len(directory), len(body), 0)
    return body + directory + end
