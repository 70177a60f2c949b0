"""The files of exports but U3M's, each with its distance from the original: .zip of maps, .glb, .mtlx, Mitsuba's.   [own]"""

from __future__ import annotations

import functools
import io
import json
import struct
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import __version__
from ..errors import InputError, printable
from ..fabric import Fabric, load_fabric
from ..files import atomic_write, check_writable
from .maps import Textures, make_textures, normal_map, png, png16
from .mitsuba_response import MissingMitsubaError, by_mitsuba
from .models import Fitted, fit_gltf, fit_openpbr
from .original import Errors, Response, errors
from .plain import numbers_of
from .u3m import write_u3m, write_u3ma

CLOTH = 0.2  # metres a side of the piece of cloth in a .glb


@dataclass(frozen=True)
class Exported:
    """What was written: its files, its errors or why they were not measured, and the response that it stands for."""

    files: list[Path]
    errors: Errors | str
    model: Response | None

    def as_dict(self) -> dict:
        """Plain values."""
        said = {"not_measured": self.errors} if isinstance(self.errors, str) else self.errors.as_dict()
        return {"files": [str(f) for f in self.files], **said}


def export(fabric: Fabric | str, path: Path) -> Exported:
    """Write a fabric in the form that the file's suffix says. Raises InputError for a suffix that is none of `WRITERS`."""
    fabric = load_fabric(fabric)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        said = path.suffix or "a file without suffix"
        raise InputError(f"{path}: cannot export {said}, expected a name that ends in {', '.join(WRITERS)}")
    check_writable(path)
    files, model = writer(fabric, path)
    try:
        return Exported(files, errors(model, fabric), model)
    except MissingMitsubaError as error:
        return Exported(files, str(error), None)


# -- maps -----------------------------------------------------------------------------------------------------------------


def _zip(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
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


# -- glTF -----------------------------------------------------------------------------------------------------------------


def _glb(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
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
    color_png = png(np.concatenate([_srgb(color[..., :3]), color[..., 3:]], -1)[..., : 3 if opaque else 4])
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


def _srgb(values: np.ndarray) -> np.ndarray:
    from ..color import srgb_encode

    return srgb_encode(values)


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


# -- MaterialX ------------------------------------------------------------------------------------------------------------


def _mtlx(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
    """An OpenPBR surface; its maps lie in a folder beside it."""
    fit = fit_openpbr(fabric)
    textures = make_textures(fabric, fit.color("base"), fit.values["roughness"])
    folder = path.parent / f"{path.stem}_maps"
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror}); choose another name") from None
    files = {
        "albedo": png(textures.color, srgb=True),
        "normal": png(normal_map(textures)),
        "roughness": png(textures.roughness),
        "opacity": png(textures.opacity),
    }
    for name, data in files.items():
        with atomic_write(folder / f"{name}.png") as temporary:
            temporary.write_bytes(data)
    root = _materialx(fabric, fit, textures, folder.name)
    ET.indent(root)
    with atomic_write(path) as temporary:
        temporary.write_bytes(b'<?xml version="1.0"?>\n' + ET.tostring(root) + b"\n")
    return [path, *(folder / f"{name}.png" for name in files)], fit.model


def _materialx(fabric: Fabric, fit: Fitted, textures: Textures, folder: str) -> ET.Element:
    root = ET.Element("materialx", version="1.39", colorspace="lin_rec709")
    size = ", ".join(f"{1.0 / side:.9g}" for side in textures.size)
    place = ET.SubElement(root, "texcoord", name="uv_m", type="vector2")  # metres
    place = ET.SubElement(root, "multiply", name="uv", type="vector2")
    _input(place, "in1", "vector2", nodename="uv_m")
    _input(place, "in2", "vector2", value=size)
    for name, kind, space in (
        ("albedo", "color3", "srgb_texture"),
        ("normal", "vector3", None),
        ("roughness", "float", None),
        ("opacity", "float", None),
    ):
        image = ET.SubElement(root, "image", name=name, type=kind)
        _input(image, "file", "filename", value=f"{folder}/{name}.png", **({"colorspace": space} if space else {}))
        _input(image, "texcoord", "vector2", nodename="uv")
        for side in "uv":
            _input(image, f"{side}addressmode", "string", value="periodic")
    turned = ET.SubElement(root, "normalmap", name="turned", type="vector3")
    _input(turned, "in", "vector3", nodename="normal")
    if fit.across:
        ET.SubElement(root, "bitangent", name="across", type="vector3")
    surface = ET.SubElement(root, "open_pbr_surface", name="cloth", type="surfaceshader")
    _input(surface, "base_color", "color3", nodename="albedo")
    _input(surface, "specular_color", "color3", value=", ".join(f"{v:.6g}" for v in fit.color("specular")))
    _input(surface, "specular_roughness", "float", nodename="roughness")
    _input(surface, "specular_roughness_anisotropy", "float", value=f"{fit.values['stretch']:.6g}")
    _input(surface, "specular_ior", "float", value=f"{fit.values['ior']:.6g}")
    _input(surface, "geometry_opacity", "float", nodename="opacity")
    _input(surface, "geometry_thin_walled", "boolean", value="true")
    _input(surface, "geometry_normal", "vector3", nodename="turned")
    if fit.across:
        _input(surface, "geometry_tangent", "vector3", nodename="across")
    material = ET.SubElement(root, "surfacematerial", name=_name(fabric.name), type="material")
    _input(material, "surfaceshader", "surfaceshader", nodename="cloth")
    return root


def _input(parent: ET.Element, name: str, kind: str, **values: str) -> None:
    ET.SubElement(parent, "input", name=name, type=kind, **values)


def _name(text: str) -> str:
    """A name as MaterialX wants it."""
    return "".join(c if c.isalnum() else "_" for c in text) or "cloth"


# -- Mitsuba 3 ------------------------------------------------------------------------------------------------------------


def _mitsuba_py(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
    """The plugin's source with the fabric's numbers: a module that registers itself, without glcloth."""
    source = (Path(__file__).parent / "mitsuba_bsdf.py").read_text(encoding="utf-8")
    numbers = json.dumps(numbers_of(fabric))
    text = (
        f"{source}\n\n# {printable(fabric.name)}, by glcloth {__version__}. Set a variant, import this file, load BSDF.\n"
        f"NUMBERS = {numbers!r}\n"
        'BSDF = {"type": "twosided", "nested": {"type": "microcylinder", "numbers": NUMBERS}}\n'
        "register()\n"
    )
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return [path], functools.partial(by_mitsuba, numbers_of(fabric))


def _mitsuba_xml(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
    """A BSDF to include in a scene; `import glcloth.mitsuba` makes its plugin known."""
    root = ET.Element("scene", version="3.0.0")
    outer = ET.SubElement(root, "bsdf", type="twosided", id=_name(fabric.name))
    inner = ET.SubElement(outer, "bsdf", type="microcylinder")
    ET.SubElement(inner, "string", name="numbers", value=json.dumps(numbers_of(fabric)))
    ET.indent(root)
    with atomic_write(path) as temporary:
        temporary.write_bytes(b"<!-- import glcloth.mitsuba before this is loaded -->\n" + ET.tostring(root) + b"\n")
    return [path], functools.partial(by_mitsuba, numbers_of(fabric))


WRITERS: dict[str, Callable[[Fabric, Path], tuple[list[Path], Response]]] = {
    ".zip": _zip,
    ".glb": _glb,
    ".mtlx": _mtlx,
    ".u3m": write_u3m,
    ".u3ma": write_u3ma,
    ".py": _mitsuba_py,
    ".xml": _mitsuba_xml,
}
