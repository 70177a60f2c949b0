"""Method `path` in the curtain's room: the room, the curtain as it hangs now, the lamp, and the sky through the openings."""

from __future__ import annotations

from collections.abc import Iterator

import moderngl
import numpy as np

from ..accel.structure import make_structure
from ..accel.triangles import Triangles
from ..errors import InputError
from ..geometry.mesh import Mesh
from ..gpu.environment_map import EnvironmentMap
from ..gpu.memo import Last
from ..light.environment import rotation_y
from ..tracing.path import PathTracer, PathView, Progress
from ..tracing.path_world import PathWorld
from ..tracing.shot import Shot
from ..tracing.threads import shows_threads
from .charts import make_charts
from .form_factors import facing_the_room, find_openings
from .room import Room


class CurtainPaths:
    """Traces one picture at a time of one room with its curtain.

    The lamp has no size, and stands for the suns of the map, whose other light shines in. The room sends light to and fro
    as often as it takes; `ambient` is not for it.
    """

    def __init__(self, ctx: moderngl.Context, room: Room):
        self.ctx, self.room = ctx, room
        self.tracer = PathTracer(ctx)
        self._map = EnvironmentMap(ctx)
        self._walls = faceted(room.positions), room.reflectances[room.material]
        self._portals: np.ndarray | None = None
        self._world: Last[PathWorld] = Last()

    @property
    def portals(self) -> np.ndarray:
        """The rectangles that the sky shines in through, [W, 3, 3]: a corner and two sides; none in a closed room."""
        if self._portals is None:
            self._portals = portals_of(self.ctx, self.room)
        return self._portals

    def steps(
        self, meshes: list[Mesh], shot: Shot, samples: int, noise: float = 0.0, vertices: int = 24
    ) -> Iterator[Progress]:
        """Trace a picture of curtains, a mesh for each fabric of the shot; yields after each dispatch. Parameters as for
        PathTracer.steps."""
        tracer, environment = self.tracer, shot.environment
        assert environment is not None, "the curtain's scene has one"
        cloths = tuple(zip(meshes, shot.fabrics, strict=True))
        tracer.take(self._world.get(lambda: PathWorld(cloths, (self._walls,)), cloths))
        rotation = rotation_y(shot.env_rotate)
        if len(self.portals):
            tracer.sky.take_portal(environment, rotation, self.portals)
        else:
            tracer.sky.take_map(environment, rotation, suns=False)
        behind = {"environment_map": self._map.texture(environment), "map_from_world": rotation.T}
        near = () if shot.settings.spread else tuple(
            1.0 if shows_threads(shot, fabric, grid) else None
            for fabric, grid in zip(shot.fabrics, shot.grids, strict=True)
        )  # fmt: skip
        view = PathView(
            shot.camera, shot.size, behind, True, vertices, shot.lighting.lamp, shot.settings.spread, near
        )  # fmt: skip
        return tracer.steps(view, samples, noise)

    def release(self) -> None:
        """Free the GPU's memory."""
        self.tracer.release()
        self._map.release()


def faceted(positions: np.ndarray) -> Mesh:
    """A mesh of triangles [T, 3, 3] that meet in edges, each flat."""
    edges = positions[:, 1] - positions[:, 0], positions[:, 2] - positions[:, 0]
    normal = np.cross(*edges).astype(float)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    x = edges[0] / np.maximum(np.linalg.norm(edges[0], axis=1, keepdims=True), 1e-30)
    tangents = np.concatenate([x, np.ones((len(x), 1))], 1)
    return Mesh(
        "room", positions.reshape(-1, 3), np.arange(3 * len(positions)).reshape(-1, 3), np.repeat(normal, 3, 0), None,
        np.repeat(tangents, 3, 0),
    )  # fmt: skip


def portals_of(ctx: moderngl.Context, room: Room) -> np.ndarray:
    """Of each face of the room's bounding box the rectangle that holds its openings, [W, 3, 3]."""
    triangles = Triangles.of(ctx, room.positions)
    structure = make_structure(ctx, "lbvh")
    try:
        structure.build(triangles)
        positions = facing_the_room(room.positions, structure, ctx, room.material)
        low, high = (bound(positions.reshape(-1, 3), axis=0).astype(float) for bound in (np.min, np.max))
        try:
            cells = find_openings(make_charts(positions, material=room.material), low, high, structure, ctx)
        except InputError:  # too many parts for charts: the sky is then drawn as in the open
            return np.zeros((0, 3, 3))
    finally:
        structure.release()
        triangles.release()
    return rectangles_about(cells)


def rectangles_about(cells: np.ndarray) -> np.ndarray:
    """The rectangles that bound cells [N, 4, 3] of the same plane, each perpendicular to an axis: [W, 3, 3]."""
    flat = np.ptp(cells, axis=1).argmin(1)
    level = np.take_along_axis(cells[:, 0], flat[:, None], 1)[:, 0]
    out = []
    for axis, height in sorted(set(zip(flat.tolist(), level.tolist(), strict=True))):
        corners = cells[(flat == axis) & (level == height)].reshape(-1, 3)
        low, size = corners.min(0), np.ptp(corners, axis=0)
        sides = [size * (np.arange(3) == other) for other in range(3) if other != axis]
        out.append([low, *sides])
    return np.array(out).reshape(-1, 3, 3)
