"""A fabric for Mitsuba 3: a plugin that stands alone, or a BSDF for a scene."""

from __future__ import annotations

import functools
import json
import xml.etree.ElementTree as ET
from pathlib import Path

from .. import __version__
from ..errors import printable
from ..fabric import Fabric
from ..files import atomic_write
from .materialx import xml_name
from .mitsuba_response import by_mitsuba
from .original import Response
from .plain import numbers_of


def write_mitsuba_py(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
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


def write_mitsuba_xml(fabric: Fabric, path: Path) -> tuple[list[Path], Response]:
    """A BSDF to include in a scene; `import glcloth.mitsuba` makes its plugin known."""
    root = ET.Element("scene", version="3.0.0")
    outer = ET.SubElement(root, "bsdf", type="twosided", id=xml_name(fabric.name))
    inner = ET.SubElement(outer, "bsdf", type="microcylinder")
    ET.SubElement(inner, "string", name="numbers", value=json.dumps(numbers_of(fabric)))
    ET.indent(root)
    with atomic_write(path) as temporary:
        temporary.write_bytes(b"<!-- import glcloth.mitsuba before this is loaded -->\n" + ET.tostring(root) + b"\n")
    return [path], functools.partial(by_mitsuba, numbers_of(fabric))
