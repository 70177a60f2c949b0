"""A .zip of a fabric's maps."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path

import numpy as np

from .. import __version__
from ..fabric import Fabric
from ..files import atomic_write
from .maps import make_textures, normal_map, png, png16
from .models import fit_gltf
from .original import Response


def write_zip(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
    """The maps of a fabric, and what they are."""
    fit = fit_gltf(fabric)
    textures = make_textures(fabric, fit.color("base"), fit.values["roughness"])
    low, high = float(textures.height.min()), float(textures.height.max())
    span = high - low or 1.0
    parts = {
        "albedo.png": png(textures.color, srgb=True),
        "normal.png": png(normal_map(textures)),
        "height.png": png16((textures.height - low) / span),
        "roughness.png": png(textures.roughness),
        "opacity.png": png(textures.opacity),
        "weights.png": png(textures.share),
    }
    if textures.rel is not None:
        buffer = io.BytesIO()
        tangents = np.array([(t.yarn, t.tilt) for t in fabric.tangents])
        np.savez_compressed(buffer, rel=textures.rel.astype(np.float16), yarn=tangents[:, 0].astype(int),
                            tilt=tangents[:, 1], weight=fabric.weights[:, 1])  # fmt: skip
        parts["tangents.npz"] = buffer.getvalue()
    about = {
        "made_by": f"glcloth {__version__}",
        "fabric": fabric.name,
        "size_m": textures.size,
        "height_m": {"black": low, "white": high},
        "maps": {
            "albedo": "sRGB; its mean is the base colour of `material`",
            "normal": "linear, green up (OpenGL); x along the warp, y along the weft",
            "height": "linear, 16 bits, see height_m",
            "roughness": "linear; alpha of GGX is its square",
            "opacity": "linear, 0 in holes",
            "weights": "linear; red warp, green weft, blue hole",
            "tangents": "NumPy: rel [T, H, W], what share a tangent has over its mean; yarn, tilt (radians), weight",
        },
        "material": {"model": "glTF 2.0", "stretched_across_the_warp": fit.across, **fit.values},
        "orientation": "u to the right along the warp, v up along the weft; each map is one repeat",
    }
    parts["about.json"] = (json.dumps(about, indent=1) + "\n").encode()
    with atomic_write(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in parts.items():
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
    return [path], fit.model
