"""Read glsl/core/shared.glsl: its constants as numbers and its structs as NumPy dtypes (std430 offsets)."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import Any

import numpy as np

from ..errors import ShaderError
from ..files import GLSL

# GLSL type: (NumPy base, shape, alignment in bytes)
_TYPES = {
    "float": ("f4", (), 4),
    "int": ("i4", (), 4),
    "uint": ("u4", (), 4),
    "vec2": ("f4", (2,), 8),
    "vec3": ("f4", (3,), 16),
    "vec4": ("f4", (4,), 16),
    "ivec2": ("i4", (2,), 8),
    "ivec4": ("i4", (4,), 16),
    "uvec2": ("u4", (2,), 8),
    "uvec4": ("u4", (4,), 16),
    "mat4": ("f4", (4, 4), 16),
}
_CONST = re.compile(r"^const\s+(int|uint|float)\s+(\w+)\s*=\s*([^;]+);", re.M)
_STRUCT = re.compile(r"^struct\s+(\w+)\s*\{(.*?)\};", re.M | re.S)
_FIELD = re.compile(r"(\w+)\s+(\w+)(?:\[(\w+)\])?$")


@cache
def shared(path: str = "core/shared.glsl") -> tuple[dict[str, Any], dict[str, np.dtype]]:
    """Return ({constant: value}, {struct: dtype}) of one GLSL file. Raises ShaderError for a type it cannot lay out."""
    text = re.sub(r"//.*", "", (GLSL / path).read_text(encoding="utf-8"))
    constants: dict[str, Any] = {}  # int or float
    for kind, name, value in _CONST.findall(text):
        constants[name] = float(value) if kind == "float" else int(value.rstrip("u"), 0)
    return constants, {name: _dtype(name, body, constants) for name, body in _STRUCT.findall(text)}


def constant(name: str) -> Any:
    """Return one constant of core/shared.glsl."""
    return shared()[0][name]


def struct(name: str) -> np.dtype:
    """Return the std430 dtype of one struct of core/shared.glsl."""
    return shared()[1][name]


def _round_up(offset: int, alignment: int) -> int:
    return -(-offset // alignment) * alignment


def _dtype(name: str, body: str, constants: dict[str, Any]) -> np.dtype:
    names, formats, offsets, end, widest = [], [], [], 0, 4
    for field in filter(None, (" ".join(f.split()) for f in body.split(";"))):
        match = _FIELD.match(field)
        if not match or match[1] not in _TYPES:
            raise ShaderError(f"struct {name}: cannot lay out `{field}`; known types: {', '.join(_TYPES)}")
        base, shape, alignment = _TYPES[match[1]]
        if match[3]:
            if shape == (3,):
                raise ShaderError(f"struct {name}: `{field}`: vec3 arrays are padded to vec4; use vec4")
            shape = (int(constants.get(match[3], 0) or match[3]), *shape)
        offset = _round_up(end, alignment)
        names.append(match[2])
        formats.append((base, shape))
        offsets.append(offset)
        end = offset + np.dtype(base).itemsize * math.prod(shape)
        widest = max(widest, alignment)
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": _round_up(end, widest)})
