"""Meshes as the bytes of PLY, OBJ and GLB files."""

from __future__ import annotations

import json
import struct

import numpy as np

from .mesh import Mesh


def ply_bytes(mesh: Mesh) -> bytes:
    """Return binary little-endian PLY: x y z nx ny nz [s t] per vertex, one list of three indices per face."""
    names = ["x", "y", "z", "nx", "ny", "nz"] + ([] if mesh.uv is None else ["s", "t"])
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(mesh.positions)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(mesh.triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    vertex = np.column_stack([mesh.positions, mesh.normals] + ([] if mesh.uv is None else [mesh.uv])).astype("<f4")
    face = np.empty(len(mesh.triangles), np.dtype([("count", "u1"), ("index", "<i4", (3,))]))
    face["count"], face["index"] = 3, mesh.triangles
    return "\n".join(header).encode() + vertex.tobytes() + face.tobytes()


def obj_text(mesh: Mesh) -> str:
    """Return OBJ text; nine significant digits give back every float32."""
    lines = [f"o {mesh.name}"]
    lines += ["v {:.9g} {:.9g} {:.9g}".format(*row) for row in mesh.positions.tolist()]
    lines += [] if mesh.uv is None else ["vt {:.9g} {:.9g}".format(*row) for row in mesh.uv.tolist()]
    lines += ["vn {:.9g} {:.9g} {:.9g}".format(*row) for row in mesh.normals.tolist()]
    corner = "{0}//{0}" if mesh.uv is None else "{0}/{0}/{0}"
    lines += ["f " + " ".join(corner.format(i + 1) for i in row) for row in mesh.triangles.tolist()]
    return "\n".join([*lines, ""])


def glb_bytes(mesh: Mesh) -> bytes:
    """Return binary glTF 2.0 with one node, whose v grows downward, as glTF has it."""
    attributes = {"POSITION": (mesh.positions, "VEC3"), "NORMAL": (mesh.normals, "VEC3")}
    if mesh.uv is not None:
        attributes["TEXCOORD_0"] = np.column_stack([mesh.uv[:, 0], 1 - mesh.uv[:, 1]]), "VEC2"
    views, accessors, body = [], [], b""
    for rows, kind in [*attributes.values(), (mesh.triangles.reshape(-1, 1), "SCALAR")]:
        whole = kind == "SCALAR"
        data = np.ascontiguousarray(rows, "<u4" if whole else "<f4")
        views.append(
            {"buffer": 0, "byteOffset": len(body), "byteLength": data.nbytes, "target": 34963 if whole else 34962}
        )
        body += data.tobytes()
        accessor = {
            "bufferView": len(accessors),
            "componentType": 5125 if whole else 5126,
            "count": len(data),
            "type": kind,
        }
        accessors.append(accessor | {"min": data.min(0).tolist(), "max": data.max(0).tolist()})
    document = {
        "asset": {"version": "2.0", "generator": "glcloth"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": mesh.name}],
        "meshes": [{
            "name": mesh.name,
            "primitives": [
                {"attributes": {name: i for i, name in enumerate(attributes)}, "indices": len(attributes), "material": 0}
            ],
        }],
        "materials": [{"doubleSided": True}],  # without one some readers leave out the UVs
        "buffers": [{"byteLength": len(body)}],
        "bufferViews": views,
        "accessors": accessors,
    }  # fmt: skip
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
