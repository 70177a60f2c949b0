"""The curtain scene from beginning to end: a room, a curtain in the wind, a lamp outside; pictures, trees, measurements."""

from __future__ import annotations

import dataclasses
import statistics
import time
import tomllib
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

import moderngl
import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from ..accel.kdtree import CONSTANTS
from ..accel.queries import RayQueries
from ..accel.triangles import Triangles
from ..errors import InputError
from ..fabric import Fabric, load_fabric
from ..geometry.camera import Camera
from ..image import read_settings
from ..light.environment import Environment, load_environment
from ..scene import View, ViewTransform
from ..tracing.lamp import Lamp, Lighting
from ..tracing.rays import BLOCK
from ..tracing.shot import Shot, TraceSettings
from ..tracing.tracer import Tracer
from ..tracing.tree_view import TreeContent, draw_tree
from .hanging import CurtainParameters, CurtainSimulation
from .room import ROOM, Room, load_room

CLOTH = 0  # the number of the cloth's material; the room's follow
CLOTH_TINT = (0.85, 0.85, 0.88)  # of the curtain in the view of the tree
VIEW = Camera((0.9, 1.5, 3.75), (-0.12, 1.25, 0.0), fov_deg=50.0)
Vec3 = tuple[float, float, float]


class CurtainScene(BaseModel):
    """The curtain scene; fields are options of `glcloth render curtain` and `glcloth animate curtain`.

    Lengths in metres, +Y up; the window is in the plane z = 0, the room before it (z > 0), the lamp behind it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)

    fabric: str | Fabric = "sheer_voile"
    room: str = ""  # an OBJ file; empty: the built-in room
    curtain: CurtainParameters = CurtainParameters()
    lamp_position: Vec3 = (1.6, 3.6, -5.0)
    lamp_intensity: Vec3 = (190.0, 176.0, 150.0)
    ambient: Vec3 = (0.3, 0.3, 0.31)
    env: str = "sky"
    env_rotate: float = 90.0
    camera: View = View()
    size: tuple[int, int] = (640, 640)
    depth: Annotated[int, Field(ge=1, le=8)] = 4
    spp: Annotated[int, Field(ge=1, le=4096)] = 1
    spread: bool = False
    accelerator: Literal["kdtree", "lbvh", "brute"] = "kdtree"
    cutoff: Annotated[float, Field(ge=0, lt=1)] = 1e-3
    rate: Annotated[int, Field(ge=1, le=240)] = 24  # frames per second
    exposure: Annotated[float, Field(ge=-20, le=20)] = 0.0
    view_transform: ViewTransform = "standard"

    @field_validator("size", mode="before")
    @classmethod
    def _size(cls, value):
        if isinstance(value, str):
            parts = value.lower().split("x")
            if len(parts) != 2 or not all(p.isdigit() for p in parts):
                raise ValueError(f"expected WIDTHxHEIGHT such as 640x480, not {value!r}")
            value = tuple(int(p) for p in parts)
        if any(not 1 <= v <= 16384 for v in value):
            raise ValueError(f"expected 1 to 16384 pixels a side, not {value[0]}x{value[1]}")
        return value

    def changed(self, **changes) -> CurtainScene:
        """The same scene with some fields replaced. Raises InputError for unknown fields and values out of range."""
        return parse_curtain_scene({**self.model_dump(exclude_unset=True), **changes}, "scene")

    @property
    def settings(self) -> TraceSettings:
        """How a picture of it is traced."""
        return TraceSettings(self.depth, self.spp, self.spread, self.cutoff, self.accelerator)

    @property
    def lighting(self) -> Lighting:
        """What lights it."""
        return Lighting(Lamp(self.lamp_position, self.lamp_intensity), self.ambient)

    @property
    def view(self) -> Camera:
        """Its camera; what the scene leaves open is that of the built-in room."""
        c = self.camera
        return Camera(c.eye or VIEW.eye, c.target or VIEW.target, c.up, c.fov_deg or VIEW.fov_deg)


def parse_curtain_scene(data: dict, where: str = "scene") -> CurtainScene:
    """Return the CurtainScene of a plain dictionary; `where` names its origin in errors. Raises InputError."""
    try:
        return CurtainScene.model_validate(data)
    except ValidationError as error:
        problem = error.errors()[0]
        name = ": ".join(str(part) for part in problem["loc"])
        if problem["type"] in ("extra_forbidden", "unexpected_keyword_argument"):
            known = CurtainScene.model_fields
            if len(problem["loc"]) > 1:
                known = [f.name for f in dataclasses.fields(CurtainParameters)]
            raise InputError(f"{where}: {name}: unknown key; known keys: {', '.join(known)}") from None
        if problem["type"] == "value_error":
            raise InputError(f"{where}: {name}: {problem['ctx']['error']}") from None
        message = problem["msg"][0].lower() + problem["msg"][1:]
        raise InputError(f"{where}: {name} = {problem['input']!r}: {message}") from None


def load_curtain_scene(name_or_path: str | Path) -> CurtainScene | None:
    """Return the curtain scene of a name or file, or None when that is no curtain scene (another loader may know it).

    A curtain scene is the built-in `curtain`, a .toml file with a [curtain] table, or a picture rendered from one.
    Raises InputError for a curtain scene with wrong values.
    """
    text, path = str(name_or_path), Path(name_or_path)
    if text == "curtain":
        return CurtainScene()
    if path.suffix.lower() in (".exr", ".png"):
        data = read_settings(path) or {}
        return parse_curtain_scene(data["curtain"], text) if "curtain" in data else None
    if path.suffix == ".toml" and path.is_file():
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
            return None
        return parse_curtain_scene(data, text) if "curtain" in data else None
    return None


class CurtainShow:
    """A curtain scene on one OpenGL context, at one moment: `advance` moves it, `picture` traces it.

    The room's triangles come first, then the curtain's; `triangles` holds them, `tracer` traces them.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: CurtainScene | None = None,
        triangles: int | None = None,
        environment: Environment | None = None,
        settle: bool = True,
    ):
        """Read the files, hang the curtain and let it settle.

        Parameters
        ----------
        triangles : about how many triangles the room and the curtain shall have together (default: as the scene says)
        environment : the scene's, where it has been read already
        settle : False leaves that to a caller who goes through `simulation.settling()` and calls `moved` then

        Raises InputError for wrong files and values.
        """
        self.ctx = ctx
        self.scene = scene = scene or CurtainScene()
        self.fabric: Fabric = load_fabric(scene.fabric)
        self.environment: Environment = environment or load_environment(scene.env)
        self.room: Room = load_room(scene.room or ROOM)
        parameters = scene.curtain
        if triangles is not None:
            if triangles <= len(self.room.positions):
                raise InputError(
                    f"--triangles {triangles}: the room alone has {len(self.room.positions)}; give more, 12786 for example"
                )
            if triangles - len(self.room.positions) != parameters.triangle_count:
                parameters = parameters.with_triangles(triangles - len(self.room.positions))
        parameters = _with_openness(parameters, self.fabric)
        self.simulation = CurtainSimulation(ctx, parameters, settle)
        self.frame = 0
        room = len(self.room.positions)
        cloth = 2 * (self.simulation.rows - 1) * (self.simulation.columns - 1)
        reach = max(
            float(np.abs(self.room.positions).max(initial=0.0)), parameters.width, parameters.top + parameters.drop
        )
        self.triangles = Triangles(ctx, room + cloth, max(reach, float(np.abs(scene.view.eye).max())))
        self.triangles.set(0, self.room.positions, material=self.room.material + CLOTH + 1)
        self.materials = np.concatenate([np.zeros((1, 3), np.float32), self.room.reflectances])
        self.tracer = Tracer(ctx)
        self.tracer.set_scene(self.triangles, self.materials)
        self.moved()

    def moved(self) -> None:
        """Copy the curtain as it hangs now into the soup; the tree is out of date then."""
        s = self.simulation
        self.triangles.set_grid(
            len(self.room.positions), s.rows, s.columns, s.position_buffer, s.normal_buffer, s.tangent_buffer, CLOTH
        )
        self._built: set[str] = set()

    def advance(self, frames: int = 1) -> None:
        """Let the wind blow for so many frames."""
        for _ in range(frames):
            for _ in self.moving():
                pass

    def moving(self) -> Iterator[None]:
        """Advance by one frame, a few substeps at a time, for a caller with other things to do in between."""
        yield from self.simulation.steps(1.0 / self.scene.rate)
        self.frame += 1
        self.moved()

    def change(self, scene: CurtainScene, environment: Environment | None = None) -> bool:
        """Take another scene as the curtain hangs now; False, and nothing done, where it must be made anew.

        environment : the new scene's, where it has been read already

        Raises InputError for wrong files and values.
        """
        fabric, here = load_fabric(scene.fabric), self.scene
        same = scene.room == here.room and self.simulation.change(_with_openness(scene.curtain, fabric))
        if not same:
            return False
        if environment is not None:
            self.environment = environment
        elif scene.env != here.env:
            self.environment = load_environment(scene.env)
        self.scene, self.fabric = scene, fabric
        return True

    def is_built(self, accelerator: str) -> bool:
        """Whether a structure holds the present frame."""
        return accelerator in self._built

    def build(self) -> None:
        """Build the scene's structure for the present frame, if it is not yet."""
        for _ in self.building():
            pass

    def building(self, accelerator: str | None = None) -> Iterator[None]:
        """As `build`, in steps for a caller with other things to do in between; begun anew when it is dropped.

        accelerator : another one than the scene's
        """
        accelerator = accelerator or self.scene.accelerator
        if accelerator not in self._built:
            yield from self.tracer.build_steps(accelerator)
            self._built.add(accelerator)

    def shot(self, other: CurtainScene | None = None) -> Shot:
        """What the tracer shows of the scene, or of another one whose fabric and rays to take; the curtain hangs as it
        hangs."""
        s = other or self.scene
        fabric = self.fabric if other is None else load_fabric(other.fabric)
        return Shot(s.view, s.size, fabric, s.lighting, self.environment, s.settings, s.env_rotate)

    def picture(self) -> np.ndarray:
        """Trace the present frame: float32 [H, W, 3], linear Rec. 709, top row first."""
        self.build()
        return self.tracer.trace(self.shot())

    def steps(
        self, size: tuple[int, int], spp: int, pixels: Callable[[], int], other: CurtainScene | None = None
    ) -> Iterator[float]:
        """Trace the present frame tile by tile into `tracer.picture`, as Tracer.steps does; at the scene's size and
        samples it is `picture`, bit for bit.

        other : a scene whose fabric, rays and structure to take for this picture, as for `shot`
        """
        for _ in self.building((other or self.scene).accelerator):
            pass
        shot = self.shot(other)
        settings = dataclasses.replace(shot.settings, spp=spp)
        return self.tracer.steps(dataclasses.replace(shot, size=size, settings=settings), pixels)

    def layers(self, size: tuple[int, int] | None = None, other: CurtainScene | None = None) -> np.ndarray:
        """The present frame rasterised: sorted layers, blended, without shadows; result as for `picture`.

        size, other : as for `steps`
        """
        shot = self.shot(other)
        background = tuple(map(float, self.environment.mean))
        lighting = dataclasses.replace(shot.lighting, background=background)
        return self.tracer.layers(dataclasses.replace(shot, size=size or shot.size, lighting=lighting))

    def tree(self, level: int | None = None, camera: Camera | None = None) -> np.ndarray:
        """The structure of the present frame as a picture, of one level or (None) of its leaves; result as for `picture`."""
        return draw_tree(self.ctx, self.tree_content(camera or self.scene.view), self.scene.size, level)

    def tree_content(self, camera: Camera) -> TreeContent:
        """What a picture of the structure shows of the present frame."""
        self.build()
        arrays = self.tracer.structure(self.scene.accelerator).arrays()
        positions = self.triangles.positions()
        material = np.concatenate(
            [self.room.material + 1, np.zeros(self.triangles.count - len(self.room.material), int)]
        )
        colors = np.where((material == CLOTH)[:, None], CLOTH_TINT, self.materials[material])
        return TreeContent(arrays, positions, colors, camera, self.scene.lamp_position, hides(positions, camera))

    def frames(self, count: int, start: int = 0) -> Iterator[np.ndarray]:
        """Yield the pictures of frames `start` to `count` - 1; the ones before are only simulated."""
        if start > self.frame:
            self.advance(start - self.frame)
        while self.frame < count:
            yield self.picture()
            if self.frame + 1 >= count:
                return
            self.advance()

    def release(self) -> None:
        """Free the GPU's memory."""
        self.tracer.release()
        self.triangles.release()
        self.simulation.release()

    def __enter__(self) -> CurtainShow:
        return self

    def __exit__(self, *_) -> None:
        self.release()


def _with_openness(parameters: CurtainParameters, fabric: Fabric) -> CurtainParameters:
    """The curtain lets air through as its fabric does."""
    if fabric.transmission is None:
        return parameters
    return dataclasses.replace(parameters, openness=fabric.transmission.openness)


def hides(positions: np.ndarray, camera: Camera) -> np.ndarray:
    """Which triangles [T] of walls lie behind or beside the camera, seen from outside: they would hide everything."""
    normal = np.cross(positions[:, 1] - positions[:, 0], positions[:, 2] - positions[:, 0])
    size = np.linalg.norm(normal, axis=1)
    toward = np.array(camera.eye) - positions.mean(1)
    large = size > 0.5 * size.max()
    return large & ((normal * toward).sum(1) < 0)


def bench_curtain(
    ctx: moderngl.Context, scene: CurtainScene | None = None, frames: int = 60, triangles: int | None = None
) -> dict:
    """Measure animated frames: simulation, build by stage, trace by level; medians in ms, wall and CPU time of the process.

    scene : default: the built-in one at 320 x 320, depth 4
    triangles : about how many, default 12,786

    Returns sim_ms, build_ms, trace_ms, frame_ms, fps, cpu_ms (of all threads), triangles, rays (and per level), nodes, depth,
    sah, steps and tests per ray, camera rays per second, stages, levels. Raises InputError for fewer than 1 frame.
    """
    if frames < 1:
        raise InputError(f"--frames {frames}: expected at least 1")
    scene = scene or CurtainScene(size=(320, 320))
    with CurtainShow(ctx, scene, triangles) as show:
        rows: list[dict] = []
        stages: list[dict] = []
        show.picture()  # compiles
        show.advance()
        show.picture()
        for _ in range(frames):
            clock, cpu = [time.perf_counter()], time.process_time()
            show.advance()
            ctx.finish()
            clock.append(time.perf_counter())
            show.build()
            ctx.finish()
            clock.append(time.perf_counter())
            show.picture()
            clock.append(time.perf_counter())
            sim, build, trace = (1000 * float(b - a) for a, b in pairwise(clock))
            s = show.tracer.statistics
            rows.append(
                {
                    "sim_ms": sim,
                    "build_ms": build,
                    "trace_ms": trace,
                    "frame_ms": sim + build + trace,
                    "cpu_ms": 1000 * (time.process_time() - cpu),
                    "rays": sum(s.rays) + sum(s.shadow_rays),
                }
            )
            stages.append(dict(s.build_ms))
        structure = show.tracer.structure(scene.accelerator)
        median = {name: round(statistics.median(row[name] for row in rows), 3) for name in rows[0]}
        result = median | {
            "fps": round(1000 / median["frame_ms"], 2),
            "rays": int(median["rays"]),
            "accelerator": scene.accelerator,
            "triangles": show.triangles.count,
            "size": list(scene.size),
            "trace_depth": scene.depth,
            "frames": frames,
            "nodes": structure.node_count,
            "leaf_triangles": structure.leaf_ref_count,
            "build_stages_ms": {k: round(statistics.median(row[k] for row in stages), 3) for k in stages[0]},
            "levels": [
                {
                    "rays": r,
                    "heads": h,
                    "shadow_rays": n,
                    "trace_ms": round(a, 3),
                    "shade_ms": round(b, 3),
                    "shadow_ms": round(c, 3),
                }
                for r, h, n, a, b, c in zip(
                    s.rays, s.heads, s.shadow_rays, s.trace_ms, s.shade_ms, s.shadow_ms, strict=True
                )
            ],
            "renderer": ctx.info["GL_RENDERER"],
        }
        return result | _quality(show)


def _quality(show: CurtainShow) -> dict:
    """Depth and SAH cost of the tree, steps and triangle tests of a camera ray: they do not depend on the machine."""
    structure = show.tracer.structure(show.scene.accelerator)
    if show.scene.accelerator == "brute":
        return {"depth": 0, "steps_per_ray": 0, "tests_per_ray": show.triangles.count}
    tree = structure.arrays()
    leaf = tree["axis"] == 3
    finite = np.isfinite(tree["low"]).all(1) & np.isfinite(tree["high"]).all(1)
    e = np.where(finite[:, None], tree["high"].astype(float) - tree["low"], 0.0)
    area = e[:, 0] * e[:, 1] + e[:, 1] * e[:, 2] + e[:, 2] * e[:, 0]
    if not finite[0]:
        area[0] = area[1:3].max()
    # A pair of triangles counts as one: the builder's own unit.
    kdtree = show.scene.accelerator == "kdtree"
    C_ts, held = (CONSTANTS["C_TS"], tree["pairs"]) if kdtree else (1.0, tree["count"])
    view, size = show.scene.view, show.scene.size
    # As the tracer orders them, block by block.
    w, h = BLOCK
    at = np.arange(size[0] // w * w * (size[1] // h * h))
    down = size[1] // h
    x = at // (w * h) // down * w + at % w + 0.5
    y = at // (w * h) % down * h + at // w % h + 0.5
    d = np.stack([x, y, np.ones_like(x)], -1) @ view.ray_from_pixel(size).T
    queries = RayQueries(show.ctx)
    work = queries.closest_hit(structure, np.broadcast_to(view.eye, d.shape), d, counted=True).work
    count = queries.upload(np.broadcast_to(view.eye, d.shape), d)
    laps = []
    for _ in range(9):
        begin = time.perf_counter()
        queries.run(structure, "closest", count)
        show.ctx.finish()
        laps.append(time.perf_counter() - begin)
    queries.release()
    return {
        "depth": int(tree["depth"].max()),
        "sah": round(float((np.where(leaf, held, C_ts) * area).sum() / area[0]), 2),
        "C_ts": C_ts,
        "steps_per_ray": round(float(work[:, 0].mean()), 2),
        "tests_per_ray": round(float(work[:, 1].mean()), 2),
        "primary_rays_per_second": round(count / statistics.median(laps[1:])),
    }
