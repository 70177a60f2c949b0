"""The curtain scene from beginning to end: a room, a curtain in the wind, a lamp outside; pictures and trees."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import moderngl
import numpy as np

from ..accel.triangles import PADDING, Triangles
from ..color import luminance
from ..errors import InputError
from ..fabric import Fabric, load_fabric
from ..geometry.camera import Camera
from ..geometry.views import view_by_name
from ..gpu.memo import Last
from ..light.environment import Environment, load_environment, rotation_y
from ..light.lights import Suns
from ..light.suns import split_suns
from ..progress import track, warn
from ..scene import CurtainParameters, Scene
from ..tracing.denoise import check_denoiser, denoised
from ..tracing.lamp import Lamp, Lighting
from ..tracing.path import PathSums, followed, samples_of
from ..tracing.shot import MOST_SPP, HangingGrid, Shot, TraceSettings
from ..tracing.tracer import Tracer
from ..tracing.tree_view import TreeContent, draw_tree
from .charts import most_parts, parts_of
from .curtains import BEHIND, FRONT, Curtains
from .form_factors import SLICES, Sheet
from .hanging import pleated_rail
from .paths import CurtainPaths
from .photons import SOURCE, Grid, PhotonMap, Photons
from .radiosity import HangingPiece, Radiosity
from .room import ROOM, Room, load_room, with_rod

CLOTH = 0  # the number of the cloth's material; the room's follow
CLOTH_TINT = (0.85, 0.85, 0.88)  # of the curtain in the view of the tree
PHOTON_STRUCTURE = "kdtree"  # of photons where rays are traced through one that takes several dispatches
VIEWS = ("front", "three-quarter", "close")  # walls hide it from the others
# Of the depth of folds, how far the last ones close the gap beside a curtain, and beside two.
SIDES, TWO_SIDES = 0.3, 1.0
VIEW = Camera((0.9, 1.5, 3.75), (-0.12, 1.25, 0.0), fov_deg=50.0)


def camera_of(scene: Scene) -> Camera:
    """The camera of a curtain's scene; missing values are those of the built-in room. Raises InputError for a view that the
    room does not have."""
    view, parameters = scene.camera, scene.curtain
    if view.view is None or parameters is None:
        return view.over(VIEW)
    if view.view not in VIEWS:
        raise InputError(f"camera: view {view.view!r}: the curtain hangs in a room, expected {', '.join(VIEWS)}")
    x, y = np.meshgrid(
        np.linspace(-0.5, 0.5, 9) * parameters.width, parameters.top - np.linspace(0, parameters.drop, 9)
    )
    points = np.stack([x, y, np.full_like(x, parameters.clearance)], -1).reshape(-1, 3)
    return view.over(
        view_by_name(view.view, points, scene.size[0] / scene.size[1], view.fov_deg or VIEW.fov_deg, view.ortho)
    )


class CurtainShow:
    """A curtain scene on one OpenGL context, at one moment: `advance` moves it, `picture` traces it.

    The room's triangles come first, then the curtain's; `triangles` holds them, `tracer` traces them.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        scene: Scene | None = None,
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
        self.scene = scene = scene or Scene(curtain=CurtainParameters())
        self.fabric: Fabric = _fabric_of(scene)
        self.behind: Fabric | None = _behind_of(scene)
        self.environment: Environment = environment or load_environment(scene.env, scene.layer, scene.env_layout)
        parameters = scene.curtain
        if parameters is None:
            raise InputError("a scene without a curtain; give one with the table curtain, such as Scene(curtain={})")
        self.room: Room = load_room(scene.room) if scene.room else with_rod(load_room(ROOM), parameters)
        self._room = scene.room, _changed_at(scene.room)
        self._parts = parts_of(self.room.positions, self.room.material)
        self.scene = self._as_it_can_be_lit(scene)
        if triangles is not None:
            if parameters.open or parameters.behind:
                raise InputError("--triangles: of a curtain of one piece; leave open and behind out")
            if triangles <= len(self.room.positions):
                raise InputError(
                    f"--triangles {triangles}: the room alone has {len(self.room.positions)}; give more, 12786 for example"
                )
            if triangles - len(self.room.positions) != parameters.triangle_count:
                parameters = parameters.with_triangles(triangles - len(self.room.positions))
        parameters = _with_openness(parameters, self.fabric)
        self.frame = 0
        self.materials = np.concatenate([np.zeros((1, 3), np.float32), self.room.reflectances])
        self._radiosity: Radiosity | None = None
        self._paths: CurtainPaths | None = None
        self._photons: PhotonMap | None = None
        self._suns: Last[Suns] = Last()
        self._lit_frame = -1  # whose photons are there
        with ExitStack() as made:  # what was made is freed where the rest cannot be
            self._hang(parameters, settle, made)
            made.pop_all()

    def _hang(self, parameters: CurtainParameters, settle: bool, made: ExitStack) -> None:
        """Hang the curtains in the room; `made` gets what must be freed."""
        ctx, room = self.ctx, len(self.room.positions)
        self.simulation = Curtains(ctx, parameters, settle, _openness(self.behind))
        made.callback(self.simulation.release)
        cloth = sum(self.simulation.triangle_counts)
        reach = max(
            float(np.abs(self.room.positions).max(initial=0.0)), parameters.width, parameters.top + parameters.drop
        )
        self.triangles = Triangles(ctx, room + cloth, max(reach, camera_of(self.scene).reach))
        made.callback(self.triangles.release)
        self.triangles.set(0, self.room.positions, material=self.room.material + CLOTH + 1)
        self._hung = Triangles(ctx, cloth, self.triangles.padding / PADDING)
        made.callback(self._hung.release)
        self.tracer = Tracer(ctx)
        made.callback(self.tracer.release)
        self.tracer.set_scene(self.triangles, self.materials)
        self.moved()

    def moved(self) -> None:
        """Copy the curtain as it hangs now into the soup; the tree is out of date then."""
        first = 0
        for s, count in zip(self.simulation.pieces, self.simulation.triangle_counts, strict=True):
            grid = s.rows, s.columns, s.position_buffer, s.normal_buffer, s.tangent_buffer, CLOTH
            self.triangles.set_grid(len(self.room.positions) + first, *grid)
            if self.frame == 0:
                # What light does among the folds is found without wind, so that a frame does not depend on how it was reached.
                self._hung.set_grid(first, *grid)
            first += count
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

    def change(self, scene: Scene, environment: Environment | None = None) -> bool:
        """Take another scene as the curtain hangs now; False, and nothing done, where it must be made anew.

        environment : the new scene's, where it has been read already

        Raises InputError for wrong files and values.
        """
        fabric, behind, here = _fabric_of(scene), _behind_of(scene), self.scene
        parameters = _with_openness(scene.curtain, fabric)
        same = scene.room == here.room and self.simulation.change(parameters, _openness(behind))
        if not same:
            return False
        if environment is not None:
            self.environment = environment
        elif any(getattr(scene, name) != getattr(here, name) for name in ("env", "layer", "env_layout")):
            self.environment = load_environment(scene.env, scene.layer, scene.env_layout)
        self.scene, self.fabric, self.behind, self._lit_frame = self._as_it_can_be_lit(scene), fabric, behind, -1
        return True

    def _as_it_can_be_lit(self, scene: Scene, traced: bool = False) -> Scene:
        """A scene that does not say how the room is lit has even light where its room has more parts than radiosity takes; paths
        find their own, but where such a scene is traced all the same (`traced`), as in a window."""
        if (
            self._parts <= most_parts()
            or (scene.method == "path" and not traced)
            or scene.gi != "radiosity"
            or "gi" in scene.model_fields_set
        ):
            return scene
        warn(
            f"{scene.room}: {self._parts} parts, more than --gi radiosity takes ({most_parts()}): even light instead; simplify "
            "it, or take --gi photons"
        )
        return scene.changed(gi="off")

    def goes_on_to(self, scene: Scene) -> bool:
        """Whether the frame of another scene is one of those that come: the same cloth in the same room and wind."""
        parameters = _with_openness(scene.curtain, load_fabric(scene.fabric))
        same = parameters == self.simulation.parameters and scene.rate == self.scene.rate
        return same and scene.frame >= self.frame and (scene.room, _changed_at(scene.room)) == self._room

    def facts(self) -> dict:
        """Facts about its picture, in plain values."""
        facts = {
            "method": self.scene.method, "fabric": self.fabric.name, "frame": self.frame, "triangles": self.triangles.count
        }  # fmt: skip
        if self.scene.method == "path" and self._paths is not None:  # None: only layers were drawn
            facts |= self.paths.tracer.sums().facts()
        return facts

    def is_built(self, accelerator: str) -> bool:
        """Whether a structure holds the present frame."""
        return accelerator in self._built

    @property
    def is_lit(self) -> bool:
        """Whether the photons of the present frame are there, and no others are being found."""
        return self._lit_frame == self.frame

    def build(self) -> None:
        """Build the scene's structure for the present frame, if it is not yet."""
        for _ in self.building():
            pass

    def building(self, accelerator: str | None = None) -> Iterator[None]:
        """As `build`, in steps for a caller with other things to do in between; begun anew when it is dropped.

        accelerator : another one than the scene's
        """
        accelerator = accelerator or self.scene.accelerator
        gi = self._as_it_can_be_lit(self.scene, traced=True).gi
        if gi == "radiosity":
            steps = self.radiosity.prepare()
            yield from track(steps, "light around the room: form factors", SLICES)
        if accelerator not in self._built:
            # Light that is found through the tree needs one that is known to be whole.
            later = gi == "off" and self.scene.method != "path"
            yield from self.tracer.build_steps(accelerator, later)
            self._built.add(accelerator)

    def shot(self, other: Scene | None = None) -> Shot:
        """The scene as the tracer takes it; `other`: a scene whose fabric and rays to take for the same curtain."""
        s = other or self.scene
        fabric, behind = (
            (self.fabric, self.behind) if other is None else (_fabric_of(other), _behind_of(other) or self.behind)
        )
        settings = TraceSettings(s.depth, min(s.spp, MOST_SPP), s.spread, s.cutoff, s.accelerator)
        lighting = Lighting(self._lamp(s), s.ambient)
        others, grids = (), ()
        if behind is not None and self.simulation.has_behind:
            others, grids = (
                ((len(self.room.positions) + self.simulation.first_of(BEHIND), behind),),
                (self._grid(BEHIND),),
            )
        return Shot(
            camera_of(s), s.size, fabric, lighting, self.environment, settings, s.env_rotate, grid=self._grid(FRONT),
            others=others, other_grids=grids,
        )  # fmt: skip

    def _lamp(self, scene: Scene) -> Lamp:
        """What shines in: the scene's lamp, or the brightest sun of the map."""
        if scene.sun == "lamp":
            return Lamp(scene.lamp_position, scene.lamp_intensity)
        suns = self._suns.get(lambda: split_suns(self.environment.radiance)[0], self.environment)
        turned = suns.rotated(rotation_y(scene.env_rotate))
        bright = luminance(turned.irradiance) * (turned.direction[:, 2] < 0.0)
        if not bright.max(initial=0.0) > 0.0:
            return Lamp((0.0, 0.0, -1.0), (0.0, 0.0, 0.0))
        brightest = int(bright.argmax())
        radius = np.broadcast_to(turned.radius, len(turned))[brightest]
        return Lamp.of_sun(turned.direction[brightest], turned.irradiance[brightest], float(radius))

    def _grid(self, curtain: int) -> HangingGrid:
        """How a curtain lies on its weave, and about where it hangs."""
        m, s = self.simulation.parameters, self.simulation
        pieces = s.pieces_of(curtain)
        spacing = pieces[0].cloth.parameters.spacing
        low, high = (-0.6 * m.width, m.top - m.drop, -0.5), (0.6 * m.width, m.top, 0.5)
        first, across = len(self.room.positions) + s.first_of(curtain), pieces[0].columns - 1
        return HangingGrid(first, across, spacing, low, high, 2 * (pieces[0].rows - 1) * across)

    def picture(self, parted: bool = False) -> np.ndarray:
        """Trace the present frame, by the scene's method: float32 [H, W, 3], linear Rec. 709, top row first.

        parted : keep kinds of light apart, which `tracer.parts` then has; not by method path
        """
        if self.scene.method == "path":
            if self.scene.denoise:
                check_denoiser()
            sums = self.path_sums()
            return (denoised(sums) if self.scene.denoise else sums.picture)[..., :3]
        self.build()
        return self.tracer.trace(dataclasses.replace(self.lit(self.shot()), parted=parted))

    @property
    def radiosity(self) -> Radiosity:
        """The light around the room, made at first use."""
        if self._radiosity is None:
            m, s = self.simulation.parameters, self.simulation
            # Of two curtains, the one behind says what light gets round both.
            nearest = s.pieces_of(BEHIND) or s.pieces
            rails = [pleated_rail(one.parameters, one.columns)[:, 1].mean() for one in nearest]
            sheet = Sheet(
                -m.width / 2, m.upper - m.drop, m.width / 2, m.upper, float(np.mean(rails)), *self._spread(),
                min(m.open, m.behind_open) if m.behind else m.open,
            )  # fmt: skip
            grids = [
                HangingPiece(one.rows - 1, one.columns - 1, panel.shift / m.width, panel.parameters.width / m.width)
                for one, panel in zip(s.pieces, s.panels, strict=True)
            ]
            self._radiosity = Radiosity(self.ctx, self.room, sheet, self._hung, grids, self._each_alone())
        return self._radiosity

    def _spread(self) -> tuple[float, float]:
        """By how much the sides of a piece of cloth are further out a metre below the rail, as it hangs, and how far its last
        folds close the gap to the wall."""
        m, one, panel = self.simulation.parameters, self.simulation.pieces[0], self.simulation.panels[0]
        count = self.simulation.triangle_counts[0]
        p = self._hung.positions()[:count].reshape(one.rows - 1, -1, 3)
        low = p[-2:, :, 0]
        flare = (float(np.ptp(low)) - panel.parameters.width) / 2 / m.drop
        rail = pleated_rail(panel.parameters, one.columns)[:, 1]
        return max(flare, 0.0), (TWO_SIDES if self.simulation.has_behind else SIDES) * float(np.ptp(rail)) / 2

    def _each_alone(self) -> list[Triangles]:
        """Of two curtains each, as it hangs without wind."""
        s = self.simulation
        if not s.has_behind:
            return []
        corners, attributes = (
            np.frombuffer(buffer.read(size * self._hung.count), np.uint32).reshape(-1, size // 4)
            for buffer, size in ((self._hung.corners, 48), (self._hung.attributes, 16))
        )
        out, middle = [], s.first_of(BEHIND)
        for here in (slice(0, middle), slice(middle, self._hung.count)):
            one = Triangles(self.ctx, len(corners[here]), self._hung.padding / PADDING)
            one.take(corners[here], attributes[here])
            out.append(one)
        return out

    @property
    def paths(self) -> CurtainPaths:
        """The path tracer of method `path`, made at first use."""
        if self._paths is None:
            self._paths = CurtainPaths(self.ctx, self.room)
        return self._paths

    def path_sums(self, vertices: int = 24) -> PathSums:
        """The present frame by method `path`, as far as the scene's `spp` and `noise` say.

        vertices : the most surfaces on a path that scatter
        """
        s, paths = self.scene, self.paths
        samples = samples_of(s.spp, s.noise)
        steps = paths.steps(self.simulation.meshes(), self.shot(), samples, s.noise, vertices)
        for _ in followed(steps, paths.tracer.batch, samples, s.noise):
            pass
        return paths.tracer.sums()

    def lit(self, shot: Shot, other: Scene | None = None) -> Shot:
        """A shot of the present frame, whose structure is built, with the light from around the room as the scene says.

        other : as another scene says
        """
        scene = self._as_it_can_be_lit(other or self.scene, traced=True)
        if scene.gi == "off":
            return shot
        split = dataclasses.replace(
            shot, lighting=dataclasses.replace(shot.lighting, ambient=(0.0, 0.0, 0.0)), indirect={}
        )
        if scene.gi == "photons":
            photons = Photons(scene.photons, scene.photon_neighbours)
            return dataclasses.replace(split, indirect_source=SOURCE, renewed=self._renewed(split, photons))
        for _ in self.radiosity.prepare():
            pass
        self.tracer.confirm(shot.settings.accelerator)  # which a scene without this light may have left unread
        structure, first = self.tracer.structure(shot.settings.accelerator), len(self.room.positions)
        return dataclasses.replace(
            split, indirect=self.radiosity.light(split, self.tracer.inputs(split), structure, first)
        )

    @property
    def photons(self) -> PhotonMap:
        """The photons of the room and the curtain, made at first use."""
        if self._photons is None:
            s = self.simulation
            grids = [Grid(one.rows - 1, one.columns - 1, one.cloth.parameters.spacing) for one in s.pieces]
            self._photons = PhotonMap(self.ctx, self.room, *grids)
        return self._photons

    def _renewed(self, shot: Shot, photons: Photons) -> Callable[[int], Iterator[Mapping[str, Any]]]:
        """Finds the photons of each sample of a shot of the present frame."""
        name = shot.settings.accelerator
        for _ in self.building(PHOTON_STRUCTURE if name == "brute" else name):
            pass
        structure = self.tracer.structure(PHOTON_STRUCTURE if name == "brute" else name)
        self.tracer.confirm(PHOTON_STRUCTURE if name == "brute" else name)

        def of_sample(sample: int) -> Iterator[Mapping[str, Any]]:
            self._lit_frame = -1
            yield from self.photons.steps(shot, self.tracer.inputs(shot), structure, photons, sample)
            self._lit_frame = self.frame

        return of_sample

    def steps(
        self, size: tuple[int, int], spp: int, pixels: Callable[[], int], other: Scene | None = None
    ) -> Iterator[float]:
        """Trace the present frame tile by tile into `tracer.picture`, as Tracer.steps does; at the scene's size and
        samples it is `picture`, bit for bit.

        other : a scene whose fabric, rays and structure to take for this picture, as for `shot`
        """
        for _ in self.building((other or self.scene).accelerator):
            pass
        shot = self.lit(self.shot(other), other)
        settings = dataclasses.replace(shot.settings, spp=spp)
        return self.tracer.steps(dataclasses.replace(shot, size=size, settings=settings), pixels)

    def layers(self, size: tuple[int, int] | None = None, other: Scene | None = None) -> np.ndarray:
        """The present frame rasterised: sorted layers, blended, without shadows; result as for `picture`.

        size, other : as for `steps`
        """
        shot = self.shot(other)
        background = tuple(map(float, self.environment.mean))
        lighting = dataclasses.replace(shot.lighting, background=background)
        return self.tracer.layers(dataclasses.replace(shot, size=size or shot.size, lighting=lighting))

    def tree(self, level: int | None = None, camera: Camera | None = None) -> np.ndarray:
        """The structure of the present frame as a picture, of one level or (None) of its leaves; result as for `picture`."""
        return draw_tree(self.ctx, self.tree_content(camera or camera_of(self.scene)), self.scene.size, level)

    def tree_content(self, camera: Camera) -> TreeContent:
        """The content of a picture of the structure of the present frame; with photons of theirs."""
        self.build()
        photons = self.scene.gi == "photons"
        arrays = self._photon_tree() if photons else self.tracer.structure(self.scene.accelerator).arrays()
        positions = self.triangles.positions()
        material = np.concatenate(
            [self.room.material + 1, np.zeros(self.triangles.count - len(self.room.material), int)]
        )
        colors = np.where((material == CLOTH)[:, None], CLOTH_TINT, self.materials[material])
        points = self.photons.in_room() if photons else None
        return TreeContent(
            arrays, positions, colors, camera, self.scene.lamp_position, hides(positions, camera), points
        )

    def _photon_tree(self) -> dict[str, np.ndarray]:
        """The part of the photons' tree that lies in the room, those of the last picture of this frame or of a first sample."""
        if not self.is_lit:
            renewed = self.lit(self.shot()).renewed
            assert renewed is not None
            for _ in renewed(0):
                pass
        return self.photons.room_tree()

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
        (self._radiosity or self._hung).release()
        if self._paths is not None:
            self._paths.release()
        if self._photons is not None:
            self._photons.release()
        self.simulation.release()

    def __enter__(self) -> CurtainShow:
        return self

    def __exit__(self, *_) -> None:
        self.release()


def show_at_its_frame(
    ctx: moderngl.Context, scene: Scene, environment: Environment, last: CurtainShow | None = None
) -> CurtainShow:
    """The curtain of a scene as it hangs at its frame: the last show, where that goes on to it, or a new one.

    Raises InputError for wrong files and values.
    """
    if last is None or not last.goes_on_to(scene) or not last.change(scene, environment):
        new = CurtainShow(ctx, scene, environment=environment)  # where that fails, the last one goes on to serve
        if last is not None:
            last.release()
        last = new
    count = scene.frame - last.frame
    for _ in track(range(count), "the wind blows: frames", count):
        last.advance()
    return last


def _changed_at(room: str) -> int:
    """When the file of a room was last changed."""
    return Path(room).stat().st_mtime_ns if room and Path(room).is_file() else 0


def _fabric_of(scene: Scene) -> Fabric:
    """The fabric of a scene, in the colour of its curtain."""
    fabric = load_fabric(scene.fabric)
    color = scene.curtain.color if scene.curtain else None
    return fabric if color is None else fabric.colored(color)


def _behind_of(scene: Scene) -> Fabric | None:
    """The fabric of a scene's second curtain, in its colour; None without one."""
    curtain = scene.curtain
    if curtain is None or not curtain.behind:
        return None
    fabric = load_fabric(curtain.behind)
    if fabric.transmission is None:
        raise InputError(
            f"curtain: behind {fabric.name}: has no [transmission]; add the block, or take blackout or sheer_voile"
        )
    return fabric if curtain.behind_color is None else fabric.colored(curtain.behind_color)


def _openness(fabric: Fabric | None) -> float:
    """The share of a fabric that lets air through."""
    return 0.0 if fabric is None or fabric.transmission is None else fabric.transmission.openness


def _with_openness(parameters: CurtainParameters, fabric: Fabric) -> CurtainParameters:
    """The curtain lets air through as its fabric does."""
    if fabric.transmission is None:
        return parameters
    return parameters.changed(openness=fabric.transmission.openness)


def hides(positions: np.ndarray, camera: Camera) -> np.ndarray:
    """Which triangles [T] of walls lie behind or beside the camera, seen from outside: they would hide everything."""
    normal = np.cross(positions[:, 1] - positions[:, 0], positions[:, 2] - positions[:, 0])
    size = np.linalg.norm(normal, axis=1)
    toward = np.array(camera.eye) - positions.mean(1)
    large = size > 0.5 * size.max()
    return large & ((normal * toward).sum(1) < 0)
