"""The renderer: a scene in, a linear picture out; the same shader functions for given directions."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import moderngl
import numpy as np

from ..accel.ground import OverGround
from ..accel.queries import make_structure
from ..accel.triangles import Triangles
from ..errors import InputError
from ..fabric import Fabric, load_fabric
from ..geometry.camera import Camera
from ..geometry.mesh import BUILTIN_MESHES, Mesh, load_mesh, load_view
from ..geometry.props import Objects, arrange, load_solids
from ..gpu import shader
from ..gpu.context import create_context
from ..gpu.gbuffer import GBuffer, MeshBuffers
from ..gpu.scene_buffers import SceneBuffers
from ..light.environment import Environment, load_environment, rotation_y
from ..light.fit import fit_lights
from ..light.lights import Lights, SphericalGaussians, as_lights
from ..light.lights_file import load_lights
from ..methods.direct.method import Direct
from ..methods.paper.method import Paper
from ..methods.reference import Reference
from ..progress import check_stopped, track
from ..scene import Scene, View, load_scene
from ..settings import MethodName, Quality, Settings
from ..settings import Shadows as ShadowMode
from ..visibility.bounce import Gather
from ..visibility.pixels import SEEN_ALL, Beside, Shadows, is_next_pose
from ..visibility.probes import lift_off_facets, subdivided
from ..visibility.solids import Around
from .adaptive import AdaptiveRate

if TYPE_CHECKING:
    from ..curtain.show import CurtainShow

METHODS = {"direct": Direct, "paper": Paper, "reference": Reference}
BACKGROUND_UNIT = 5
OCCLUDER_STRUCTURE = "lbvh"  # any-hit rays of the built-in cloth: as fast as the kd-tree; built five times as fast
# Numbers of tangents and widths of lobes that need a program each (cloth/direct.py, VARIANTS). More than 8 tangents take
# seconds to compile and are rare: those wait for it. The first comes twice: llvmpipe compiles the very first one anew.
WARM_UP = ((4, 20.0), (4, 4.0), (5, 4.0), (8, 4.0), (4, 20.0))
# Where a caller has other things to do in between:
BAND_PIXELS = 120_000  # of the G-buffer at a time
SLICE = 0.012  # seconds of rays from pixels at a time
KEPT_SIZES = 3  # G-buffers that stay when the size of the picture changes


@dataclass(frozen=True, eq=False)
class Frame:
    """A scene whose files are read and whose lights are fitted: what one draw needs. `Renderer.prepare` makes it."""

    scene: Scene
    fabric: Fabric
    mesh: Mesh
    environment: Environment
    lights: Lights  # in world space, rotation included
    camera: Camera
    settings: Settings
    objects: Objects | None = None  # what stands about the cloth


def default_camera(mesh: Mesh, scene: Scene) -> Camera:
    """The camera of a scene; what the scene leaves open is chosen so that the mesh fills the picture."""
    view, size = scene.camera, scene.size
    fitted = mesh_camera(mesh, size[0] / size[1])
    fov_deg = view.fov_deg or fitted.fov_deg
    return Camera(view.eye or fitted.eye, view.target or fitted.target, view.up, fov_deg)


def mesh_camera(mesh: Mesh, aspect: float) -> Camera:
    """The camera that shows a mesh well: a chosen one for the built-in meshes, else one that frames its bounds."""
    if mesh.name in BUILTIN_MESHES and (view := load_view(mesh.name)):
        return Camera(**view)
    return Camera.framing(mesh.center, mesh.radius, aspect=aspect)


class Renderer:
    """Renders scenes and evaluates radiances on one OpenGL context; use it as a context manager.

    Parameters
    ----------
    device : EGL device index (`glcloth info` lists them); None takes the best
    ctx : an existing moderngl context (OpenGL >= 4.3), current; it is then not released here

    Raises NoOpenGLError when no context can be made.
    """

    def __init__(self, device: int | None = None, ctx: moderngl.Context | None = None):
        self._owns_context = ctx is None
        self.ctx = create_context(device) if ctx is None else ctx
        self.shared = SceneBuffers(self.ctx)
        self._methods: dict[str, object] = {}
        self._programs: dict[tuple, object] = {}
        self._meshes: dict[int, MeshBuffers] = {}
        self._shadows: Shadows | None = None
        self._finer: tuple[Mesh, Mesh] | None = None  # a mesh, and what it is drawn as with shadows
        self._occluders: tuple | None = None  # mesh, objects' mesh, ground's height, triangles, structure
        self._around: Around | None = None
        self._gather: Gather | None = None
        self._solids: tuple | None = None  # names and when their files changed, meshes and reflectances
        self._objects: tuple | None = None  # cloth, those, the ground, Objects
        self._follow = False
        self._fit: tuple | None = None  # environment, lobes, lights
        self._rotated: tuple | None = None  # lights, degrees, lights turned
        self._files: dict = {}
        self._adaptive: AdaptiveRate | None = None
        self._gbuffer: GBuffer | None = None
        self._gbuffers: dict[tuple[int, int], GBuffer] = {}  # the one used last is the last
        self._background: tuple[Environment, moderngl.Texture] | None = None
        self._show: CurtainShow | None = None
        self._last: Frame | CurtainShow | None = None  # what was rendered last

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def close(self) -> None:
        """Free the context and all that lives on it."""
        if self._show is not None and self.ctx is not None:
            self._show.release()
        self._show = self._last = None
        if self._owns_context and self.ctx is not None:
            gc.collect()  # objects that wait for collection must go while their context is alive
            self.ctx.release()
        self.ctx = None

    # -- from a scene to a frame ---------------------------------------------------------------------------------

    def prepare(
        self,
        scene: Scene | str | None = None,
        *,
        fabric: Fabric | str | None = None,
        mesh: Mesh | str | None = None,
        environment: Environment | str | None = None,
        lights: Lights | SphericalGaussians | None = None,
        camera: Camera | None = None,
        objects: Objects | None = None,
        **changes,
    ) -> Frame:
        """Read the files of a scene and fit its lights. Parameters as for `render`."""
        scene = Scene() if scene is None else load_scene(scene)
        if objects is not None and not isinstance(objects, Objects):
            changes, objects = {**changes, "objects": objects}, None
        scene = scene.changed(**changes) if changes else scene
        if scene.curtain is not None:
            raise InputError("the curtain is traced and has no frame of passes; render it, or take `Renderer.show`")
        fabric = load_fabric(scene.fabric if fabric is None else fabric)
        mesh = mesh if isinstance(mesh, Mesh) else self._loaded(load_mesh, mesh or scene.mesh)
        if not isinstance(environment, Environment):
            environment = self._loaded(load_environment, environment or scene.env)
        rotation = rotation_y(scene.env_rotate)
        if lights is None and scene.lights:
            lights = self._turned(self._loaded(load_lights, scene.lights), scene.env_rotate)
        elif lights is None:
            lights = self._turned(self._fitted(environment, scene.lobes), scene.env_rotate)
        settings = Settings(
            scene.quality,
            scene.segments,
            scene.light,
            scene.cube,
            scene.contribution,
            scene.grid,
            scene.shadows,
            scene.bounce,
            environment,
            rotation,
        )
        camera = camera or default_camera(mesh, scene)
        objects = self._objects_of(scene, mesh) if objects is None else objects
        objects = None if objects is None or objects.empty else objects
        return Frame(scene, fabric, mesh, environment, as_lights(lights), camera, settings, objects)

    def _objects_of(self, scene: Scene, mesh: Mesh) -> Objects | None:
        """The objects and the ground of a scene, the same ones as long as nothing about them changes."""
        if not scene.objects and scene.ground == "off":
            return None
        stamps = tuple(Path(name).stat().st_mtime_ns if Path(name).is_file() else 0 for name in scene.objects)
        key = scene.objects, stamps
        if self._solids is None or self._solids[0] != key:
            self._solids = key, load_solids(scene.objects)
        solids, look = self._solids[1], (scene.ground, scene.ground_color)
        if self._objects is not None and self._objects[1] is solids and self._objects[2] == look:
            before, _, _, objects = self._objects
            # The ground stays where it is while the cloth moves over it.
            if before is mesh or (self._follow and is_next_pose((before,), (mesh,))):
                self._objects = mesh, solids, look, objects
                return objects
        objects = arrange(solids, scene.ground, scene.ground_color, mesh)
        self._objects = mesh, solids, look, objects
        return objects

    def _loaded(self, load, name):
        """What `load` makes of a name or file; the last one of each kind is kept until its file changes."""
        if not isinstance(name, str):
            return name
        path = Path(name)
        stamp = (name, path.stat().st_mtime_ns if path.is_file() else 0)
        if self._files.get(load, (None, None))[0] != stamp:
            self._files[load] = stamp, load(name)
        return self._files[load][1]

    def _fitted(self, environment: Environment, lobes) -> Lights:
        if self._fit is None or self._fit[0] is not environment or self._fit[1] != lobes:
            self._fit = environment, lobes, fit_lights(environment, lobes)
        return self._fit[2]

    def _turned(self, lights: Lights, degrees: float) -> Lights:
        """Lights turned about +Y; the same object while nothing changes, so that what follows from it is kept."""
        if self._rotated is None or self._rotated[0] is not lights or self._rotated[1] != degrees:
            self._rotated = lights, degrees, lights.rotated(rotation_y(degrees))
        return self._rotated[2]

    # -- from a frame to pixels ----------------------------------------------------------------------------------

    def render(self, scene: Scene | str | None = None, **changes) -> np.ndarray:
        """Render one picture.

        Parameters
        ----------
        scene : a Scene, the name of a built-in one, or a file; default: silk on the built-in cloth in the studio.
            The curtain is traced; for all else of it see `show`.
        fabric, mesh, environment : a name, a file, or the object itself
        objects : names and files of meshes that stand about the cloth, or Objects
        lights : Lights or SphericalGaussians in world space instead of a fit of the environment
        camera : Camera instead of the scene's
        any other keyword : a field of Scene, for example method="reference", size=(320, 240), spp=4

        Returns float32 [H, W, 3], linear Rec. 709, top row first; [H, W, 4] with premultiplied alpha when the
        background is off. Raises InputError for wrong input, and what the methods raise.
        """
        scene = Scene() if scene is None else load_scene(scene)
        if scene.curtain is not None:
            return self.show(scene, **changes).picture()
        return self.render_frame(self.prepare(scene, **changes))

    def show(
        self,
        scene: Scene | str,
        *,
        environment: Environment | str | None = None,
        camera: Camera | None = None,
        **changes,
    ) -> CurtainShow:
        """The curtain of a scene as it hangs at its frame: its picture, layers and tree. It is this renderer's, and another
        call may change it. Parameters as for `render`, without mesh, objects and lights. Raises InputError."""
        from ..curtain.show import show_at_its_frame  # cloth starts without it

        if isinstance(environment, str):
            changes["env"], environment = environment, None
        if camera is not None:
            changes["camera"] = View.of(camera)
        scene = load_scene(scene).changed(**{name: value for name, value in changes.items() if value is not None})
        if scene.curtain is None:
            raise InputError("a scene without a curtain; give one with the table curtain, such as Scene(curtain={})")
        scene = scene.model_copy(update={"fabric": self._loaded(load_fabric, scene.fabric)})
        environment = environment or self._loaded(load_environment, scene.env)
        self._last = self._show = show_at_its_frame(self.ctx, scene, environment, self._show)
        return self._show

    def facts(self) -> dict:
        """What the last picture of `render` shows, in plain values."""
        if not isinstance(self._last, Frame):
            return {} if self._last is None else self._last.facts()
        frame = self._last
        return {
            "method": frame.scene.method,
            "fabric": frame.fabric.name,
            "lobes": len(frame.lights.gaussians),
            "suns": len(frame.lights.suns),
            "covered_pixels": self.covered_pixels(),
        }

    def render_frame(self, frame: Frame) -> np.ndarray:
        """Draw a prepared frame and read it back; returns what `render` returns."""
        self._last = frame
        self.draw(frame)
        picture = self._target(frame.scene.size).read()
        return picture[..., :3] if frame.scene.background else picture

    def draw(self, frame: Frame) -> None:
        """Draw a frame into the G-buffer's colour target; nothing is read back."""
        for _ in self.steps(frame, what=f"{frame.scene.method}: passes over the picture"):
            pass

    def steps(
        self,
        frame: Frame,
        rows: Callable[[], int] | None = None,
        what: str | None = None,
        hurry: bool = False,
    ) -> Iterator[tuple[int, int]]:
        """Draw a frame in steps, for a caller with other things to do in between; together they do what `draw` does,
        bit for bit. Nothing else may be drawn with this renderer before the last step or the iterator's end.

        Parameters
        ----------
        rows : called before each step: how many rows of the picture it may shade; None: all
        what : what a progress bar says, None: no bar
        hurry : make do with what is known of the shadows so far; `look` makes it complete

        Yields (passes finished, passes in all) after each step; the background follows the last one.
        """
        check_stopped()
        scene = frame.scene
        buffer = self._target(scene.size)
        method = self.method(scene.method)
        self.shared.prepare(frame.fabric, frame.lights)
        method.prepare(frame.fabric, frame.lights, frame.settings)
        around = self._prepare_around(frame)
        shadows = self._prepare_shadows(frame)
        lookouts = [s for s in (shadows, around and around.shadows) if s is not None]
        if hurry:
            for one in lookouts:
                one.hurry()
        elif lookouts:
            total = sum(one.total() for one in lookouts)
            for _ in track(self.look(frame), "shadows: directions", total) if what else self.look(frame):
                pass
        mesh = self._mesh(self.drawn_mesh(frame), frame.mesh)
        passes = list(method.passes())
        jobs = [(offset, uniforms) for offset in sample_offsets(scene.spp) for uniforms in passes]
        if getattr(method, "traced", False):
            placing = method.place(mesh, self.occluders(frame.mesh, around), around)
            for job in track(placing, f"{scene.method}: light on the folds") if what else placing:
                job()
                yield 0, len(jobs)
        program = self.program("passes/picture/shade.frag", method, shadows)
        buffer.clear_color()
        if scene.adaptive and scene.method == "direct" and scene.quality != "high" and scene.spp == 1:
            for _ in self._shade_adaptively(buffer, mesh, method, program, frame, shadows, rows, around, hurry):
                yield 0, 1
            if around is not None:
                for band in bands(scene.size[1], rows):
                    self._shade_around(buffer, around, method, frame, passes, 0, band)
                    if band is not None:
                        self.ctx.finish()
                        yield 0, 1
            yield 1, 1
            jobs = []
        drawn = None
        for done, (offset, uniforms) in enumerate(track(jobs, what) if what and len(jobs) > 1 else jobs):
            number = done % max(len(passes), 1)
            if offset != drawn:
                for _ in self._place(buffer, mesh, method, frame, shadows, offset, rows is not None, around, hurry):
                    yield done, len(jobs)
                drawn = offset
            first = 0
            while first < scene.size[1]:
                count = scene.size[1] if rows is None else max(1, min(rows(), scene.size[1] - first))
                self.shared.bind(program)
                if shadows is not None:
                    self._bind_shadows(shadows, program, frame, buffer)
                method.bind(program)
                shader.set_uniforms(
                    program, pass_weight=1.0 / scene.spp, pass_cover=1.0 / (scene.spp * len(passes)), **uniforms
                )
                band = None if rows is None else (first, count)
                buffer.shade(program, len(jobs) > 1, band)
                if around is not None:
                    self._shade_around(buffer, around, method, frame, passes, number, band)
                first += count
                if len(jobs) > 1 or rows is not None:
                    self.ctx.finish()  # so that progress tells the truth and Ctrl-C is heard between passes
                yield done + (first >= scene.size[1]), len(jobs)
        if scene.background:
            self.draw_background(frame)

    def look(self, frame: Frame, count: int = 32, enough: int | None = None) -> Iterator[int]:
        """Trace what a frame's shadows lack, `count` directions a step; nothing where they are complete or off, or, for a
        first impression, where `enough` directions are traced.

        Yields how many directions are traced.
        """
        shadows, around = self._prepare_shadows(frame), self._prepare_around(frame)
        if shadows is not None:
            yield from shadows.steps(count, enough)
        if around is not None:
            yield from around.shadows.steps(count, enough)

    def _shadow_mode(self, frame: Frame) -> ShadowMode:
        scene = frame.scene
        # The reference method traces its own.
        if scene.method == "reference" or (scene.shadows == "sun" and not len(frame.lights.suns)):
            return "off"
        return scene.shadows

    def _prepare_shadows(self, frame: Frame) -> Shadows | None:
        """The shadows of a frame; None where it has none."""
        mode = self._shadow_mode(frame)
        if mode == "off":
            return None
        if self._shadows is None:
            self._shadows = Shadows(self.ctx)
        around = self._take_around(frame)
        structure = self.occluders(frame.mesh, around)
        beside = None if around is None else self._beside(frame, around, around.mesh)
        drawn = self.drawn_mesh(frame)
        self._shadows.prepare(mode, drawn, frame.mesh, structure, frame.lights, frame.scene.bounce, beside)
        return self._shadows

    def _beside(self, frame: Frame, around: Around, mesh: Mesh) -> Beside:
        """What hides light beside the cloth of a frame (`mesh` is that of what stands about it), or the other way round."""
        if self._gather is None:
            self._gather = Gather(self.ctx)
        structure = self.occluders(frame.mesh, around)
        self._gather.places.prepare(self.drawn_mesh(frame), frame.mesh, around, structure.triangles)
        return Beside((mesh,), frame.objects.ground is not None, self._gather.places)

    def _take_around(self, frame: Frame) -> Around | None:
        """What stands about the cloth of a frame, on the GPU; None where nothing does."""
        if frame.objects is None:
            return None
        if self._around is None:
            self._around = Around(self.ctx)
            self._around.shadows.follow_poses(self._follow)
        self._around.prepare(frame.objects)
        return self._around

    def _prepare_around(self, frame: Frame) -> Around | None:
        """As `_take_around`, ready to look at the lights."""
        around = self._take_around(frame)
        if around is not None:
            mode = self._shadow_mode(frame)
            structure = beside = None
            if mode != "off":
                structure, beside = self.occluders(frame.mesh, around), self._beside(frame, around, frame.mesh)
            around.look_out(mode, structure, frame.lights, frame.scene.bounce, beside)
        return around

    def follow_poses(self, follow: bool = True) -> None:
        """Take meshes with the same triangles for poses of one cloth that moves: of what its vertices see a quarter is
        traced anew at each, the rest is that of the last three. A cut, a jump of the cloth, is noticed."""
        if self._shadows is None:
            self._shadows = Shadows(self.ctx)
        self._follow = follow
        self._shadows.follow_poses(follow)
        if self._around is not None:
            self._around.shadows.follow_poses(follow)

    @property
    def shadows(self) -> Shadows | None:
        """What the shadows keep; None before the first picture with shadows."""
        return self._shadows

    def drawn_mesh(self, frame: Frame) -> Mesh:
        """The mesh of a frame, with more vertices where its shadows need them."""
        if self._shadow_mode(frame) != "full":
            return frame.mesh
        if self._finer is None or self._finer[0] is not frame.mesh:
            self._finer = frame.mesh, subdivided(frame.mesh)
        return self._finer[1]

    def _place(
        self,
        buffer: GBuffer,
        mesh: MeshBuffers,
        method,
        frame: Frame,
        shadows: Shadows | None,
        offset,
        in_bands: bool,
        around: Around | None,
        hurry: bool,
    ) -> Iterator[None]:
        """Draw what every pixel sees of the cloth and about it, and of the lights; in bands it yields after each."""
        rows = max(1, BAND_PIXELS // buffer.size[0]) if in_bands else buffer.size[1]
        among = None
        if around is not None:
            for _ in around.draw_bands(buffer, mesh, frame.camera, offset, rows):
                if in_bands:
                    self.ctx.finish()
                    yield
            among = around.among(buffer)
        for _ in buffer.draw_bands(mesh, frame.camera, offset, rows, among):
            if in_bands:
                self.ctx.finish()
                yield
        if shadows is None:
            return
        places = sample_offsets(frame.scene.spp)
        sample = places.index(offset), len(places)
        lookouts = [(shadows, buffer, method)]
        bounces = around is not None and self._bounces(frame)
        if around is not None:
            lookouts.append((around.shadows, around.beside(buffer), None))
        for one, target, means in lookouts:
            if in_bands:
                one.integrate(means)
                self.ctx.finish()
                yield
            one.look(target, means, sample)
            if in_bands:
                self.ctx.finish()
                yield
            if not hurry:
                for _ in one.edges(target, *([SLICE] if in_bands else [])):
                    if in_bands:
                        yield
        if bounces:
            albedo = shadows.albedo(frame.fabric, self.shared)
            structure = self.occluders(frame.mesh, around)
            for _ in self._gather.gather(shadows, around, structure, frame.lights, self.shared, albedo):
                if in_bands:
                    self.ctx.finish()
                    yield
            for one, target, _ in lookouts:
                self._gather.fill(one, target)
            if in_bands:
                self.ctx.finish()
                yield

    def _bounces(self, frame: Frame) -> bool:
        """Whether light goes between cloth and what stands about it."""
        return frame.objects is not None and self._shadow_mode(frame) == "full" and frame.scene.bounce

    def _bind_shadows(self, shadows: Shadows, program, frame: Frame, buffer: GBuffer) -> None:
        """Bind what the pixels of the cloth see, and what comes back to them."""
        shadows.bind(program, frame.fabric, self.shared)
        if self._bounces(frame):
            self._gather.bind(buffer)
            self._gather.bind_views(frame.fabric, self.shared)

    def _shade_around(
        self, buffer: GBuffer, around: Around, method, frame: Frame, passes: list[dict], number: int = 0, band=None
    ) -> None:
        """Shade what stands about the cloth: pass number `number` over a sample, or a band of it."""
        weight = 1.0 / frame.scene.spp
        if hasattr(method, "lit"):
            program, cover = method.lit(around), weight / len(passes)
            shader.set_uniforms(program, **passes[number])
        elif number:
            return  # the first pass did it all
        else:
            program, cover = around.lit_by_means(frame.lights, self.shared), weight
            bounces = self._bounces(frame)
            shader.set_uniforms(program, bounces=bounces)
            if bounces:
                self._gather.bind(around.beside(buffer))
        around.run(buffer, program, weight, cover, band)

    def _shade_adaptively(
        self,
        buffer: GBuffer,
        mesh: MeshBuffers,
        method,
        program,
        frame: Frame,
        shadows: Shadows | None,
        rows: Callable[[], int] | None,
        around: Around | None,
        hurry: bool,
    ) -> Iterator[None]:
        """One pixel in four, and the others where their neighbours differ; `high` and spp > 1 shade every pixel."""
        if self._adaptive is None:
            self._adaptive = AdaptiveRate(self.ctx)
        yield from self._place(buffer, mesh, method, frame, shadows, (0.0, 0.0), rows is not None, around, hurry)
        list_program = self.program("passes/picture/shade_list.comp", method, shadows)

        def bind(one) -> None:
            self.shared.bind(one)
            if shadows is not None:
                self._bind_shadows(shadows, one, frame, buffer)
            method.bind(one)

        for one in (program, list_program):
            bind(one)
        shader.set_uniforms(program, pass_weight=1.0, pass_cover=1.0)
        narrowest = float(np.radians(min(min(yarn.gamma_s_deg, yarn.gamma_v_deg) for yarn in frame.fabric.yarn)))
        yield from self._adaptive.steps(buffer, program, list_program, narrowest, bind, rows)

    def warm_up(self, frame: Frame) -> Iterator[None]:
        """Compile what later edits of the weave may need, one way of packing tangents at each step, by drawing a frame's
        scene at 22x18 with other tangents. Without it the first frame of such an edit waits for its compiler. The lights
        stay, so that what the cloth sees of them need not be traced again.
        """
        warp, weft = frame.fabric.yarn
        plain = {"curve_angles_deg": None, "curve_lengths": None, "samples": None}
        one = weft.changed(**plain, tangents_deg=(0.0,), gamma_s_deg=20.0, gamma_v_deg=20.0)
        for tangents, gamma in WARM_UP:
            tilts = np.linspace(-20.0, 20.0, tangents - 1)
            many = warp.changed(**plain, tangents_deg=tuple(tilts), gamma_s_deg=gamma, gamma_v_deg=2.0 * gamma)
            for adaptive in (True, False):
                scene = frame.scene.changed(method="direct", quality="normal", spp=1, adaptive=adaptive, size=(22, 18))
                small = replace(frame, scene=scene, fabric=frame.fabric.changed(yarn=(many, one)))
                self.draw(small)
                self.ctx.finish()
                yield

    def radiance(
        self,
        fabric: Fabric | str,
        omega_o: np.ndarray,
        lights: Lights | SphericalGaussians,
        method: MethodName = "direct",
        quality: Quality = "normal",
        **settings,
    ) -> np.ndarray:
        """Radiance toward given directions at one point, by the shaders that render pictures.

        Parameters
        ----------
        fabric : Fabric, built-in name or file
        omega_o : [N, 3] unit, in the surface frame (x = yarn 1, y = yarn 2, z = N), away from the surface
        lights : in that same frame
        method, quality : as for `render`; other keywords are fields of Settings (segments, cube, contribution, ...)

        Returns float32 [N, 3], linear; 0 where omega_o is below the surface. Raises InputError for wrong input.
        """
        omega_o = np.atleast_2d(np.asarray(omega_o, np.float32))
        if omega_o.ndim != 2 or omega_o.shape[1] != 3 or not np.isfinite(omega_o).all():
            raise InputError(f"omega_o has shape {omega_o.shape}, expected [N, 3] finite unit directions")
        fabric, lights = load_fabric(fabric), as_lights(lights)
        chosen = self.method(method)
        self.shared.prepare(fabric, lights)
        chosen.prepare(fabric, lights, Settings(quality=quality, **settings))
        program = self.program("passes/methods/radiance.comp", chosen)
        count = len(omega_o)
        directions = np.zeros((max(count, 1), 4), "f4")
        directions[:count, :3] = omega_o
        source = self.ctx.buffer(directions.tobytes())
        result = self.ctx.buffer(np.zeros_like(directions).tobytes())
        try:
            self.shared.bind(program)
            chosen.bind(program)
            source.bind_to_storage_buffer(0)
            result.bind_to_storage_buffer(1)
            for uniforms in chosen.passes():
                shader.set_uniforms(program, first=0, count=count, **uniforms)
                program.run((count + 63) // 64)
                # The next pass adds to what this one wrote.
                self.ctx.memory_barrier(moderngl.SHADER_STORAGE_BARRIER_BIT)
            return np.frombuffer(result.read(), "f4").reshape(-1, 4)[:count, :3].copy()
        finally:
            source.release()
            result.release()

    # -- what is kept between draws ------------------------------------------------------------------------------

    def method(self, name: MethodName):
        """The method of a name, made at first use."""
        if name not in METHODS:
            raise InputError(f"method {name!r}: expected one of {', '.join(METHODS)}")
        if name not in self._methods:
            self._methods[name] = METHODS[name](self.ctx)
        return self._methods[name]

    def program(self, pass_path: str, method, shadows: Shadows | None = None):
        """The program of a pass with a method, with shadows or without, compiled at first use. Raises ShaderError."""
        defines = method.defines()
        seen = SEEN_ALL if shadows is None else shadows.source
        virtual = {"method.glsl": method.source, "seen.glsl": seen}
        virtual |= method.includes() if hasattr(method, "includes") else {}
        key = (pass_path, tuple(sorted(virtual.items())), tuple(sorted(defines.items())))
        if key not in self._programs:
            if pass_path.endswith(".comp"):
                self._programs[key] = shader.compute(self.ctx, pass_path, defines, virtual)
            else:
                self._programs[key] = shader.program(
                    self.ctx, "passes/picture/screen.vert", pass_path, defines, virtual
                )
        return self._programs[key]

    def covered_pixels(self) -> int:
        """How many pixels of the last draw see the cloth."""
        return int(self._gbuffer.covered().sum())

    @property
    def gbuffer(self) -> GBuffer:
        """The G-buffer of the last draw."""
        return self._gbuffer

    def _target(self, size: tuple[int, int]) -> GBuffer:
        """The G-buffer of a size; the last few sizes are kept, so that a window can change between two."""
        limit = self.ctx.info["GL_MAX_TEXTURE_SIZE"]
        if max(size) > limit:
            raise InputError(f"size {size[0]}x{size[1]}: this OpenGL draws at most {limit} pixels a side; choose less")
        size = tuple(size)
        buffer = self._gbuffers.pop(size, None)
        if buffer is None:
            program = next((b.program for b in self._gbuffers.values()), None)
            while len(self._gbuffers) >= KEPT_SIZES:
                self._gbuffers.pop(next(iter(self._gbuffers))).release()
            buffer = GBuffer(self.ctx, size, program)
        self._gbuffers[size] = self._gbuffer = buffer
        return buffer

    def _mesh(self, mesh: Mesh, original: Mesh | None = None) -> MeshBuffers:
        key = id(mesh)
        if key not in self._meshes:
            for buffers in self._meshes.values():
                buffers.release()
            lift = lift_off_facets(mesh, original) if original is not None and original is not mesh else None
            self._meshes = {key: MeshBuffers(self.ctx, mesh, lift)}
        return self._meshes[key]

    def occluders(self, mesh: Mesh, around: Around | None = None):
        """The acceleration structure (`glcloth.accel`) over what hides light: the triangles of a mesh, then those of what
        stands about it, and the ground; built once."""
        solids = None if around is None else around.mesh
        if self._occluders is None or self._occluders[0] is not mesh or self._occluders[1] is not solids:
            corners = mesh.positions[mesh.triangles]
            if around is not None:
                corners = np.concatenate([corners, around.triangles])
            if self._occluders is None:
                structure, triangles = make_structure(self.ctx, OCCLUDER_STRUCTURE), None
            else:
                triangles, structure = self._occluders[2:4]
            if triangles is not None and triangles.count == len(corners):
                triangles.move(corners)
            else:
                if triangles is not None:
                    triangles.release()
                triangles = Triangles.of(self.ctx, corners)
            structure.build(triangles)
            ground = None if around is None else around.objects.ground
            seen = structure if ground is None else OverGround(structure, ground.height)
            self._occluders = mesh, solids, triangles, structure, seen
        return self._occluders[4]

    def draw_background(self, frame: Frame, target: moderngl.Framebuffer | None = None) -> None:
        """Draw the environment behind the last draw, or behind a copy of it in another framebuffer of its size."""
        environment = frame.environment
        if self._background is None or self._background[0] is not environment:
            if self._background is not None:
                self._background[1].release()
            height, width = environment.radiance.shape[:2]
            texture = self.ctx.texture((width, height), 3, environment.radiance.tobytes(), dtype="f4", alignment=4)
            texture.repeat_x, texture.repeat_y = True, False
            texture.filter = moderngl.LINEAR, moderngl.LINEAR
            self._background = environment, texture
        key = ("background",)
        if key not in self._programs:
            self._programs[key] = shader.program(
                self.ctx, "passes/picture/screen.vert", "passes/picture/background.frag"
            )
        program = self._programs[key]
        self._background[1].use(BACKGROUND_UNIT)
        program["environment_from_world"].write(rotation_y(-frame.scene.env_rotate).T.astype("f4").tobytes())
        self._gbuffer.fill_behind(program, target)


def bands(height: int, rows: Callable[[], int] | None) -> Iterator[tuple[int, int] | None]:
    """(first row, how many) of each part of a picture whose height `rows` says part by part; None, once, for all of it."""
    if rows is None:
        yield None
        return
    first = 0
    while first < height:
        count = max(1, min(rows(), height - first))
        yield first, count
        first += count


def sample_offsets(spp: int) -> list[tuple[float, float]]:
    """Where in the pixel the samples lie, relative to its centre: the R2 sequence, one sample at the centre.

    Roberts 2018, "The unreasonable effectiveness of quasirandom sequences": evenly spread for any number of samples.
    """
    if spp == 1:
        return [(0.0, 0.0)]
    g = 1.32471795724474602596
    return [(float((0.5 + n / g) % 1.0 - 0.5), float((0.5 + n / g**2) % 1.0 - 0.5)) for n in range(spp)]
