"""A piece of cloth as .glb.   [own]"""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np

from .. import __version__
from ..color import srgb_encode
from ..fabric import Fabric
from ..files import atomic_write
from .maps import make_textures, normal_map, png
from .models import Fitted, fit_gltf
from .original import Response

CLOTH = 0.2  # metres a side


def write_glb(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
    """A piece of cloth, 20 cm a side, with its material."""
    fit = fit_gltf(fabric)
    textures = make_textures(fabric, fit.color("base"), fit.values["roughness"])
    half = CLOTH / 2
    corners = np.array([[-half, -half, 0], [half, -half, 0], [half, half, 0], [-half, half, 0]], "<f4")
    uv = np.array([[0, 0], [CLOTH, 0], [CLOTH, CLOTH], [0, CLOTH]]) / textures.size
    uv[:, 1] = 1.0 - uv[:, 1]  # glTF's v grows downward
    arrays = [
        ("POSITION", "VEC3", corners),
        ("NORMAL", "VEC3", np.tile(np.array([0, 0, 1], "<f4"), (4, 1))),
        ("TANGENT", "VEC4", np.tile(np.array([1, 0, 0, 1], "<f4"), (4, 1))),
        ("TEXCOORD_0", "VEC2", uv.astype("<f4")),
        ("", "SCALAR", np.array([0, 1, 2, 0, 2, 3], "<u2")),
    ]
    rough = np.stack([np.ones_like(textures.roughness), textures.roughness, np.zeros_like(textures.roughness)], -1)
    color = np.concatenate([textures.color, textures.opacity[..., None]], -1)
    opaque = not textures.has_holes
    color_png = png(np.concatenate([srgb_encode(color[..., :3]), color[..., 3:]], -1)[..., : 3 if opaque else 4])
    images = {"color": color_png, "normal": png(normal_map(textures)), "roughness": png(rough)}
    # Along the tangent, everywhere. It says what is so without it, but Blender reads the UVs' tangent for its sake alone.
    images["direction"] = png(np.full((4, 4, 3), (1.0, 0.5, 1.0)))
    chunks, views = b"", []
    for data in [*(a.tobytes() for *_, a in arrays), *images.values()]:
        views.append({"buffer": 0, "byteOffset": len(chunks), "byteLength": len(data)})
        chunks += data + b"\0" * (-len(data) % 4)
    for view, (name, *_) in zip(views, arrays, strict=False):
        view["target"] = 34962 if name else 34963
    accessors = [
        {"bufferView": k, "componentType": 5126 if name else 5123, "count": len(a), "type": kind}
        | ({"min": a.min(0).tolist(), "max": a.max(0).tolist()} if name == "POSITION" else {})
        for k, (name, kind, a) in enumerate(arrays)
    ]
    first = len(arrays)
    material = _gltf_material(fabric, fit, opaque)
    document = {
        "asset": {"version": "2.0", "generator": f"glcloth {__version__}"},
        "extensionsUsed": sorted(material["extensions"]),
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": fabric.name}],
        "meshes": [{"primitives": [{
            "attributes": {name: k for k, (name, *_) in enumerate(arrays) if name}, "indices": 4, "material": 0}]}],
        "materials": [material],
        "textures": [{"source": k, "sampler": 0} for k in range(len(images))],
        "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}],
        "images": [
            {"bufferView": first + k, "mimeType": "image/png", "name": name} for k, name in enumerate(images)
        ],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(chunks)}],
    }  # fmt: skip
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(chunks)
    with atomic_write(path) as temporary:
        temporary.write_bytes(
            struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<I4s", len(text), b"JSON") + text
            + struct.pack("<I4s", len(chunks), b"BIN\0") + chunks
        )  # fmt: skip
    return [path], fit.model


def _gltf_material(fabric: Fabric, fit: Fitted, opaque: bool) -> dict:
    """The material with its extensions; textures 0 colour, 1 normals, 2 roughness, 3 the anisotropy's direction."""
    specular = np.array(fit.color("specular"))
    extensions: dict = {
        "KHR_materials_specular": {"specularFactor": 1.0, "specularColorFactor": specular.tolist()},
        "KHR_materials_anisotropy": {
            "anisotropyStrength": fit.values["stretch"],
            # The direction is the one in which the highlight is long; the tangent is the warp's.
            "anisotropyRotation": np.pi / 2 if fit.across else 0.0,
            "anisotropyTexture": {"index": 3},
        },
        "KHR_materials_sheen": {
            "sheenColorFactor": list(fit.color("sheen")),
            "sheenRoughnessFactor": fit.values["sheen_roughness"],
        },
    }
    if (through := fabric.transmission) is not None:
        color = through.rho * through.k_t * np.exp(-np.array(through.tau))
        factor = float(color.max())
        extensions["KHR_materials_diffuse_transmission"] = {
            "diffuseTransmissionFactor": factor,
            "diffuseTransmissionColorFactor": (color / (factor or 1.0)).tolist(),
        }
    return {
        "name": fabric.name,
        "doubleSided": True,
        "alphaMode": "OPAQUE" if opaque else "MASK",
        **({} if opaque else {"alphaCutoff": 0.5}),
        "normalTexture": {"index": 1},
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0},
            "metallicRoughnessTexture": {"index": 2},
            "metallicFactor": 0.0,
        },
        "extensions": extensions,
    }
