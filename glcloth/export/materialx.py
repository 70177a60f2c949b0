"""A fabric as .mtlx: an OpenPBR surface.   [own]"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

from ..errors import InputError
from ..fabric import Fabric
from ..files import atomic_write
from .maps import Textures, make_textures, normal_map, png
from .models import Fitted, fit_openpbr
from .original import Response


def write_mtlx(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
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
    material = ET.SubElement(root, "surfacematerial", name=xml_name(fabric.name), type="material")
    _input(material, "surfaceshader", "surfaceshader", nodename="cloth")
    return root


def _input(parent: ET.Element, name: str, kind: str, **values: str) -> None:
    ET.SubElement(parent, "input", name=name, type=kind, **values)


def xml_name(text: str) -> str:
    """A name as MaterialX and Mitsuba want it."""
    return "".join(c if c.isalnum() else "_" for c in text) or "cloth"
