"""The container of glTF 2.0: JSON, buffers, and accessors as arrays.   [Khronos, glTF 2.0 specification]"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from pathlib import Path
from urllib.parse import unquote, unquote_to_bytes

import numpy as np

from ..errors import InputError
from ..files import beside, read_bytes
from .raw import MOST_BYTES, MOST_TRIANGLES

COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
# Extensions that a file may require and that change no triangle here, or are read.
READ = ("KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_",
        "KHR_lights_", "KHR_xmp", "KHR_animation_", "KHR_node_visibility", "ADOBE_materials_", "VRM")  # fmt: skip
COMPRESSED = {"KHR_draco_mesh_compression": "Draco", "EXT_meshopt_compression": "meshopt",
              "KHR_meshopt_compression": "meshopt"}  # fmt: skip
BROKEN = (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError, RecursionError, struct.error)


class Document:
    """A glTF file: `json`, and its accessors and pictures by number. Methods raise InputError, or one of BROKEN."""

    def __init__(self, blob: bytes, path: Path):
        self.path = path
        self.where = str(path)
        text, self._chunk = _chunks(blob, self.where) if path.suffix.lower() == ".glb" else (blob, None)
        try:
            self.json = json.loads(text.decode("utf-8-sig"))
        except RecursionError:
            raise InputError(f"{path}: its JSON is nested too deeply; export it again") from None
        except ValueError as error:
            raise InputError(
                f"{path}: cannot be read as gltf (its JSON is damaged: {error}); export it again"
            ) from None
        if not isinstance(self.json, dict) or not isinstance(self.json.get("asset"), dict):
            raise InputError(f"{path}: cannot be read as gltf (no glTF asset in it); export it again")
        version = str(self.json["asset"].get("version", ""))
        if not version.startswith("2"):
            raise InputError(f"{path}: glTF version {version[:20] or 'unsaid'}, expected 2; export it as glTF 2.0")
        self._buffers: dict[int, bytes] = {}
        self._read = 0
        for name in self.json.get("extensionsRequired") or ():
            if not str(name).startswith(READ):
                raise self.unread(str(name))

    def unread(self, name: str) -> InputError:
        """The error for an extension that is not read."""
        what = f"is compressed ({COMPRESSED[name]})" if name in COMPRESSED else "needs an extension that is not read"
        remedy = "without compression" if name in COMPRESSED else "without it"
        return InputError(f"{self.where}: {what}: {name}; export it {remedy}")

    def items(self, name: str) -> list:
        """A list of the document, [] where it has none."""
        value = self.json.get(name, [])
        if not isinstance(value, list):
            raise TypeError(f"{name} is no list")
        return value

    def item(self, name: str, number: int) -> dict:
        """One of a list. Raises one of BROKEN."""
        if not isinstance(number, int) or number < 0:
            raise IndexError(f"{name} {number}")
        if number >= len(self.items(name)):
            raise IndexError(f"{name} {number} is not there")
        value = self.items(name)[number]
        if not isinstance(value, dict):
            raise TypeError(f"{name} {number} is no object")
        return value

    # -- bytes -------------------------------------------------------------------------------------------------------

    def uri(self, uri: str, what: str) -> bytes:
        """The bytes that a URI means: data in itself, or a file in the document's folder or below."""
        left = MOST_BYTES - self._read
        if uri.startswith("data:"):
            head, _, body = uri.partition(",")
            try:
                blob = base64.b64decode(unquote(body)) if head.endswith(";base64") else unquote_to_bytes(body)
            except (binascii.Error, ValueError):
                raise InputError(f"{self.where}: {what} has damaged data in its URI; export it again") from None
        else:
            found = beside(self.path, unquote(uri)) or beside(self.path, uri)
            if found is None:
                raise InputError(
                    f"{self.where}: {what} is the file {unquote(uri)}, which is not in its folder; put it there"
                )
            blob = read_bytes(found, left)
        self._read += len(blob)
        return blob

    def _buffer(self, number: int) -> bytes:
        if number not in self._buffers:
            table = self.item("buffers", number)
            if "uri" in table:
                blob = self.uri(table["uri"], f"buffer {number}")
            elif number == 0 and self._chunk is not None:
                blob = self._chunk
            else:
                names = [name for name in table.get("extensions") or () if name in COMPRESSED]
                raise self.unread(names[0]) if names else ValueError(f"buffer {number} has no data")
            if len(blob) < table["byteLength"]:
                raise ValueError(f"buffer {number} has {len(blob)} bytes of {table['byteLength']}")
            self._buffers[number] = blob
        return self._buffers[number]

    def view(self, number: int) -> tuple[bytes, int, int, int]:
        """(buffer, offset, length, stride or 0) of a buffer view."""
        table = self.item("bufferViews", number)
        blob = self._buffer(table["buffer"])
        begin, length = table.get("byteOffset", 0), table["byteLength"]
        if begin < 0 or length < 0 or begin + length > len(blob):
            raise ValueError(f"buffer view {number} goes beyond its buffer")
        return blob, begin, length, table.get("byteStride", 0)

    # -- accessors ---------------------------------------------------------------------------------------------------

    def count(self, number: int) -> int:
        """How many elements an accessor has, before any of them is read."""
        count = self.item("accessors", number)["count"]
        if not isinstance(count, int) or not 0 <= count <= 3 * MOST_TRIANGLES:
            raise InputError(f"{self.where}: accessor {number} has {count} elements, at most {3 * MOST_TRIANGLES:,} can be "
                             "read; reduce the mesh")  # fmt: skip
        return count

    def accessor(self, number: int, widths: tuple[int, ...], whole: bool = False) -> np.ndarray:
        """The elements of an accessor as [count, width] float64, normalised ones in -1 to 1; `whole`: int64.

        Raises one of BROKEN where its width is none of `widths`.
        """
        table, count = self.item("accessors", number), self.count(number)
        kind, width = np.dtype(COMPONENTS[table["componentType"]]), WIDTHS[table["type"]]
        if width not in widths:
            raise ValueError(f"accessor {number} is a {table['type']}")
        rows = self._elements(table, count, kind, width, number)
        if sparse := table.get("sparse"):
            rows = self._with_sparse(rows, sparse, number)
        if whole:
            if kind.kind == "f":
                raise ValueError(f"accessor {number} holds no whole numbers")
            return rows.astype(np.int64)
        values = rows.astype(np.float64)
        if table.get("normalized") and kind.kind != "f":
            values = np.maximum(values / np.iinfo(kind).max, -1.0)
        return values

    def _elements(self, table: dict, count: int, kind: np.dtype, width: int, number: int) -> np.ndarray:
        if "bufferView" not in table:
            return np.zeros((count, width), kind)
        blob, begin, length, stride = self.view(table["bufferView"])
        offset = table.get("byteOffset", 0)
        stride = stride or kind.itemsize * width
        if offset < 0 or stride < 0 or (count and offset + stride * (count - 1) + kind.itemsize * width > length):
            raise ValueError(f"accessor {number} goes beyond its buffer view")
        return np.ndarray((count, width), kind, blob, begin + offset, (stride, kind.itemsize)).copy()

    def _with_sparse(self, rows: np.ndarray, sparse: dict, number: int) -> np.ndarray:
        count = sparse["count"]
        if not isinstance(count, int) or not 0 <= count <= len(rows):
            raise ValueError(f"accessor {number} has {count} sparse elements of {len(rows)}")
        places, values = sparse["indices"], sparse["values"]
        kind = np.dtype(COMPONENTS[places["componentType"]])
        at = self._elements(places, count, kind, 1, number)[:, 0].astype(np.int64)
        if count and at.max() >= len(rows):
            raise ValueError(f"accessor {number} has a sparse element {at.max()} of {len(rows)}")
        rows[at] = self._elements(values, count, rows.dtype, rows.shape[1], number)
        return rows


def _chunks(blob: bytes, where: str) -> tuple[bytes, bytes | None]:
    """The JSON and the binary chunk of a GLB file."""
    if len(blob) < 20 or blob[:4] != b"glTF":
        raise InputError(f"{where}: cannot be read as glb (it does not begin with glTF); export it again")
    version, length = struct.unpack_from("<II", blob, 4)
    if version != 2:
        raise InputError(f"{where}: glTF version {version}, expected 2; export it as glTF 2.0")
    if length > len(blob):
        raise InputError(f"{where}: cannot be read as glb ({len(blob)} bytes of {length}); copy or export it again")
    found: dict[bytes, bytes] = {}
    at = 12
    while at + 8 <= length:
        size, kind = struct.unpack_from("<I4s", blob, at)
        if at + 8 + size > len(blob):
            raise InputError(f"{where}: cannot be read as glb (a chunk is cut off); copy or export it again")
        found.setdefault(kind, blob[at + 8 : at + 8 + size])
        at += 8 + size
    if b"JSON" not in found:
        raise InputError(f"{where}: cannot be read as glb (no JSON in it); export it again")
    return found[b"JSON"], found.get(b"BIN\0")
