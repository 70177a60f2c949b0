"""Read the scene of a glTF 2.0 file as one mesh: nodes, skins in their bind pose, morph targets, instances, materials.

Skins are bent by their joints as they stand, morph targets added by their weights; animations are left out.
[Khronos, glTF 2.0 specification, 3.5 to 3.9]
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from ..errors import InputError
from ..files import beside
from .gltf import BROKEN, COMPRESSED, Document
from .raw import Material, RawMesh, check_counts, joined

TRIANGLES, STRIP, FAN = 4, 5, 6
MOST_INSTANCES = 1 << 16


def read_gltf(blob: bytes, path: Path, colored: bool = False) -> RawMesh:
    """Return all triangles of a glTF file's scene in its space, with their materials if asked for; v grows upward.

    Raises InputError for a file that is damaged or too large, and for extensions that hide its triangles.
    """
    document = Document(blob, path)
    try:
        return joined(list(_Scene(document, colored).pieces()), str(path))
    except BROKEN as error:
        if isinstance(error, InputError):
            raise
        reason = " ".join(str(error).split())[:100] or type(error).__name__
        if isinstance(error, KeyError):
            reason = f"{reason} is missing"
        kind = path.suffix.lower().lstrip(".")
        raise InputError(f"{path}: cannot be read as {kind} ({reason}); is it whole? export it again") from None


@dataclass(frozen=True, eq=False)
class _Node:
    number: int
    table: dict
    world: np.ndarray  # [4, 4]


class _Scene:
    def __init__(self, document: Document, colored: bool):
        self.document = document
        self.colored = colored
        self._vertices = self._triangles = 0
        self._materials: dict[tuple[int | None, bool], Material] = {}

    def pieces(self) -> Iterator[RawMesh]:
        """Each primitive of each node of the scene."""
        shown = self._shown()
        self._check_total(shown)
        for number in shown:
            node = self.nodes[number]
            if "mesh" not in node.table:
                continue
            mesh = self.document.item("meshes", node.table["mesh"])
            names = str(mesh.get("name") or ""), str(node.table.get("name") or "")
            for primitive in mesh["primitives"]:
                piece = self._primitive(primitive, mesh, node)
                if piece is not None:
                    material = piece.materials[0].name
                    part = tuple(dict.fromkeys(name for name in (material, *names) if name))
                    for instance in self._placed(piece, node, mesh):
                        yield replace(instance, parts=(part,))

    def _check_total(self, shown: list[int]) -> None:
        """Refuse too many triangles by the counts alone."""
        total = 0
        for number in shown:
            table = self.nodes[number].table
            if "mesh" in table:
                times = self._instance_count(table)
                for primitive in self.document.item("meshes", table["mesh"])["primitives"]:
                    corners = self.document.count(primitive.get("indices", primitive["attributes"]["POSITION"]))
                    mode = primitive.get("mode", TRIANGLES)
                    total += times * (corners // 3 if mode == TRIANGLES else corners if mode in (STRIP, FAN) else 0)
        check_counts(self.document.where, triangles=total)

    def _instance_count(self, table: dict) -> int:
        """How often a node is there."""
        extension = (table.get("extensions") or {}).get("EXT_mesh_gpu_instancing")
        if not extension or "skin" in table:
            return 1
        counts = {self.document.count(number) for number in extension["attributes"].values()}
        if len(counts) != 1 or max(counts) > MOST_INSTANCES:
            raise ValueError(f"a node has {max(counts, default=0)} instances")
        return counts.pop()

    # -- nodes -------------------------------------------------------------------------------------------------------

    @cached_property
    def nodes(self) -> dict[int, _Node]:
        """All nodes that hang from a root, in the space of the scene."""
        tables = self.document.items("nodes")
        children = {child for table in tables for child in table.get("children", ())}
        todo = [(number, np.eye(4)) for number in range(len(tables) - 1, -1, -1) if number not in children]
        found: dict[int, _Node] = {}
        while todo:
            number, above = todo.pop()
            if number in found:
                raise ValueError(f"node {number} hangs from two others")
            table = self.document.item("nodes", number)
            found[number] = _Node(number, table, above @ node_matrix(table))
            todo += [(child, found[number].world) for child in reversed(table.get("children", ()))]
        return found

    def _shown(self) -> list[int]:
        """The numbers of the nodes of the scene, from the roots down."""
        scenes = self.document.items("scenes")
        if not scenes:
            return list(self.nodes)
        roots = self.document.item("scenes", self.document.json.get("scene", 0)).get("nodes", [])
        order, todo = [], list(reversed(roots))
        while todo:
            number = todo.pop()
            if number not in self.nodes:
                raise ValueError(f"node {number} is not there, or hangs from itself")
            extensions = self.nodes[number].table.get("extensions") or {}
            if not (extensions.get("KHR_node_visibility") or {}).get("visible", True):
                continue  # nor what hangs from it
            order.append(number)
            todo += list(reversed(self.nodes[number].table.get("children", ())))
        if len(set(order)) < len(order):
            raise ValueError("a node is twice in the scene")
        return order

    def _placed(self, piece: RawMesh, node: _Node, mesh: dict) -> Iterator[RawMesh]:
        """A primitive where its node stands, once for each instance of it."""
        extensions = node.table.get("extensions") or {}
        if "skin" in node.table:  # its joints say where it is
            worlds = [None]
        elif table := extensions.get("EXT_mesh_gpu_instancing"):
            worlds = [
                node.world @ local for local in self._instances(table["attributes"], self._instance_count(node.table))
            ]
        else:
            worlds = [node.world]
        self._count(len(piece.positions) * len(worlds), len(piece.triangles) * len(worlds))
        for world in worlds:
            yield piece if world is None else _moved(piece, world)

    def _count(self, vertices: int, triangles: int) -> None:
        """Refuse too much before it is made."""
        self._vertices += vertices
        self._triangles += triangles
        check_counts(self.document.where, self._vertices, self._triangles)

    def _instances(self, attributes: dict, count: int) -> np.ndarray:
        """The matrices [I, 4, 4] of EXT_mesh_gpu_instancing."""
        columns = {"TRANSLATION": 3, "ROTATION": 4, "SCALE": 3}
        rows = {name: self.document.accessor(attributes[name], (width,))
                for name, width in columns.items() if name in attributes}  # fmt: skip
        local = [{name.lower(): row[i].tolist() for name, row in rows.items()} for i in range(count)]
        return np.array([node_matrix(table) for table in local]).reshape(count, 4, 4)

    # -- primitives --------------------------------------------------------------------------------------------------

    def _primitive(self, primitive: dict, mesh: dict, node: _Node) -> RawMesh | None:
        """The triangles of a primitive in its mesh's space (skinned: the scene's); None if it has none."""
        mode = primitive.get("mode", TRIANGLES)
        if mode not in (TRIANGLES, STRIP, FAN):
            return None
        document, attributes = self.document, primitive["attributes"]
        for name in primitive.get("extensions") or ():
            if name in COMPRESSED and "bufferView" not in document.item("accessors", attributes["POSITION"]):
                raise document.unread(name)
        count = document.count(attributes["POSITION"])
        check_counts(document.where, count)
        if "indices" in primitive:
            corners = document.accessor(primitive["indices"], (1,), whole=True)[:, 0]
        else:
            corners = np.arange(count)
        triangles = _triangles(corners, mode)
        if not len(triangles):
            return None
        if triangles.max() >= count:
            raise InputError(f"{document.where}: a face names vertex {triangles.max()}, out of range, it has {count}; "
                             "export it again")  # fmt: skip
        weights = node.table.get("weights") or mesh.get("weights") or []
        positions = self._morphed(primitive, "POSITION", weights, count)
        normals = self._morphed(primitive, "NORMAL", weights, count) if "NORMAL" in attributes else None
        uv = self._attribute(attributes, "TEXCOORD_0", (2,), count)
        if uv is not None:
            uv = np.column_stack([uv[:, 0], 1.0 - uv[:, 1]])
        if "skin" in node.table:
            positions, normals = self._skinned(node.table["skin"], attributes, positions, normals)
        colors = self._attribute(attributes, "COLOR_0", (3, 4), count) if self.colored else None
        one = np.zeros(len(triangles), np.int32)
        piece = RawMesh(
            positions, triangles, uv, normals, ((),), one, (self._material(primitive, colors is not None),), one,
            None if colors is None else np.clip(colors[triangles].mean(1)[:, :3], 0.0, 1.0),
        )  # fmt: skip
        return _compact(piece)

    def _attribute(self, attributes: dict, name: str, widths: tuple[int, ...], count: int) -> np.ndarray | None:
        if name not in attributes:
            return None
        rows = self.document.accessor(attributes[name], widths)
        if len(rows) != count:
            raise ValueError(f"{name} has {len(rows)} elements for {count} vertices")
        return rows

    def _morphed(self, primitive: dict, name: str, weights: list, count: int) -> np.ndarray:
        """An attribute with its morph targets as far as they weigh."""
        rows = self._attribute(primitive["attributes"], name, (3,), count)
        assert rows is not None
        for weight, target in zip(weights, primitive.get("targets") or (), strict=False):
            if weight and name in target:
                rows = rows + float(weight) * self._attribute(target, name, (3,), count)
        return rows

    def _skinned(
        self, number: int, attributes: dict, positions: np.ndarray, normals: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """Positions and normals bent by the joints as these stand."""
        skin = self.document.item("skins", number)
        worlds = np.array([self.nodes[joint].world for joint in skin["joints"]])
        if "inverseBindMatrices" in skin:
            inverse = self.document.accessor(skin["inverseBindMatrices"], (16,))
            worlds = worlds @ inverse[: len(worlds)].reshape(-1, 4, 4).swapaxes(1, 2)
        blend, total = np.zeros((len(positions), 16)), np.zeros(len(positions))
        for k in range(8):
            if f"JOINTS_{k}" not in attributes:
                break
            joints = self.document.accessor(attributes[f"JOINTS_{k}"], (4,), whole=True)
            weights = self._attribute(attributes, f"WEIGHTS_{k}", (4,), len(positions))
            if weights is None or len(joints) != len(positions) or joints.max(initial=0) >= len(worlds):
                raise ValueError(f"JOINTS_{k} do not fit skin {number}")
            for j in range(4):
                blend += weights[:, j, None] * worlds.reshape(-1, 16)[joints[:, j]]
                total += weights[:, j]
        blend[total <= 0] = np.eye(4).ravel()
        blend = (blend / np.where(total > 0, total, 1.0)[:, None]).reshape(-1, 4, 4)
        linear = blend[:, :3, :3]
        bent = np.einsum("vij,vj->vi", linear, positions) + blend[:, :3, 3]
        return bent, None if normals is None else _turned(normals, linear)

    def _material(self, primitive: dict, has_colors: bool) -> Material:
        """The material of a primitive, the same one wherever it is asked for again; `has_colors`: of its vertices."""
        key = primitive.get("material"), has_colors
        if key not in self._materials:
            self._materials[key] = self._read_material(*key)
        return self._materials[key]

    def _read_material(self, number: int | None, has_colors: bool) -> Material:
        """A material, its picture by file or bytes."""
        # A material that says no colour would be white, all of whose light comes back: grey is likelier. Colours of
        # vertices say it.
        unsaid = 1.0 if has_colors else 0.5
        if number is None:
            return Material("", (unsaid,) * 3)
        table = self.document.item("materials", number)
        name = str(table.get("name") or "")
        if not self.colored:
            return Material(name)
        pbr = table.get("pbrMetallicRoughness") or {}
        factor, picture = pbr.get("baseColorFactor"), pbr.get("baseColorTexture")
        older = (table.get("extensions") or {}).get("KHR_materials_pbrSpecularGlossiness")
        if older:
            factor, picture = older.get("diffuseFactor"), older.get("diffuseTexture")
        texture = self._picture(picture) if picture else None
        color = np.full(3, 1.0 if texture else unsaid) if factor is None else np.asarray(factor, float)[:3]
        r, g, b = np.clip(color, 0.0, 1.0).tolist()
        roughness, metalness = (
            float(np.clip(pbr.get(key, 1.0), 0.0, 1.0)) for key in ("roughnessFactor", "metallicFactor")
        )
        return Material(name, (r, g, b), roughness, 0.0 if older or not pbr else metalness, texture)

    def _picture(self, reference: dict) -> Path | bytes | None:
        """The file or the bytes of a texture; None for one that is not there."""
        texture = self.document.item("textures", reference["index"])
        if "source" not in texture:
            return None
        image = self.document.item("images", texture["source"])
        if "bufferView" in image:
            blob, begin, length, _ = self.document.view(image["bufferView"])
            return blob[begin : begin + length]
        uri = image["uri"]
        if uri.startswith("data:"):
            return self.document.uri(uri, "a picture")
        return beside(self.document.path, uri) or beside(self.document.path, unquote(uri))


def node_matrix(table: dict) -> np.ndarray:
    """The matrix [4, 4] of a node from its matrix, or its translation, rotation and scale."""
    if "matrix" in table:
        return np.array(table["matrix"], float).reshape(4, 4).T
    x, y, z, w = np.array(table.get("rotation", (0, 0, 0, 1)), float)
    length = x * x + y * y + z * z + w * w
    s = 2.0 / length if length > 0 else 0.0
    rotation = np.array(
        [
            [1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
            [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
            [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.array(table.get("scale", (1, 1, 1)), float).reshape(3)
    matrix[:3, 3] = np.array(table.get("translation", (0, 0, 0)), float).reshape(3)
    return matrix


def _triangles(corners: np.ndarray, mode: int) -> np.ndarray:
    """Triangles [T, 3] of a list, strip or fan of corners."""
    if mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    i = np.arange(max(len(corners) - 2, 0))
    if mode == FAN:
        return np.stack([corners[i + 1], corners[i + 2], corners[np.zeros_like(i)]], 1)
    return np.stack([corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]], 1)


def _turned(normals: np.ndarray, linear: np.ndarray) -> np.ndarray:
    """Normals [V, 3] under linear maps [V or 1, 3, 3]: by the cofactors, which exist where an inverse does not."""
    columns = linear.swapaxes(1, 2)
    cofactors = np.stack([np.cross(columns[:, (k + 1) % 3], columns[:, (k + 2) % 3]) for k in range(3)], 2)
    side = np.where(np.linalg.det(linear) < 0, -1.0, 1.0)
    return np.einsum("vij,vj->vi", np.broadcast_to(cofactors, (len(normals), 3, 3)), normals) * side[:, None]


def _moved(piece: RawMesh, world: np.ndarray) -> RawMesh:
    """A piece in another space. A map that mirrors would turn triangles inside out; they are turned back."""
    linear = world[:3, :3]
    return replace(
        piece,
        positions=piece.positions @ linear.T + world[:3, 3],
        normals=None if piece.normals is None else _turned(piece.normals, linear[None]),
        triangles=piece.triangles[:, ::-1] if np.linalg.det(linear) < 0 else piece.triangles,
    )


def _compact(piece: RawMesh) -> RawMesh:
    """A piece without its unused vertices if these are the most: primitives that share one large buffer."""
    used = np.unique(piece.triangles)
    if 2 * len(used) >= len(piece.positions):
        return piece
    number = np.zeros(len(piece.positions), np.int64)
    number[used] = np.arange(len(used))
    rest = {name: None if getattr(piece, name) is None else getattr(piece, name)[used] for name in ("uv", "normals")}
    return replace(piece, positions=piece.positions[used], triangles=number[piece.triangles], **rest)
