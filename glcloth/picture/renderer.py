"""The renderer: a scene in, a linear picture out; the same shader functions for given directions."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import moderngl
import numpy as np

from ..errors import InputError
from ..fabric import Fabric
from ..geometry.camera import Camera
from ..gpu.context import Owner, check_errors, create_context
from ..gpu.gbuffer import GBuffer
from ..image import as_picture
from ..light.environment import Environment
from ..light.lights import Lights, SphericalGaussians, as_lights
from ..methods.method import Method
from ..methods.settings import Settings
from ..progress import check_stopped, drain
from ..scene import MethodName, Quality, Scene, View, load_scene
from ..tracing.denoise import denoised
from .background import Background
from .frame import Frame, Frames
from .layers import LIGHT, PATH_SAMPLES, Gathering, Layers, chosen
from .pace import Pace
from .passes import Passes
from .path import PathPictures
from .picked import Picked, pick
from .stage import Stage
from .target import Target, Targets

if TYPE_CHECKING:
    from ..curtain.show import CurtainShow
    from ..tracing.path import PathSums


class Renderer:
    """Renders scenes and evaluates radiances on one OpenGL context; use it as a context manager.

    Parameters
    ----------
    device : number of an EGL device or a part of its name (`glcloth info` lists them); None takes the best
    ctx : an existing moderngl context (OpenGL >= 4.3), current; it is then not released here

    Raises NoOpenGLError when no context can be made.
    """

    def __init__(self, device: int | str | None = None, ctx: moderngl.Context | None = None):
        self._owns_context = ctx is None
        self._owner = Owner("Renderer")
        self.ctx = create_context(device) if ctx is None else ctx
        self.stage = Stage(self.ctx)
        self._frames = Frames()
        self._targets = Targets(self.ctx)
        self._target: Target | None = None
        self._background = Background(self.ctx)
        self._passes = Passes(self.stage, self._background)
        self._paths = PathPictures(self.ctx)
        self._show: CurtainShow | None = None
        self._last: Frame | CurtainShow | None = None  # the last one rendered
        self._by_path: Frame | None = None  # the last one drawn, where that was by method path

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _check(self) -> None:
        """Raise InputError where this renderer cannot work: closed, in another thread, in a forked process."""
        self._owner.check()
        if self.ctx is None:
            raise InputError(
                "this Renderer is closed; make another, or do its work before close() or the end of `with`"
            )

    def close(self) -> None:
        """Free the context and all that lives on it. Raises InputError in another thread."""
        if self.ctx is not None:
            self._owner.check()
        if self._show is not None and self.ctx is not None:
            self._show.release()
        if self.ctx is not None:
            self._paths.release()
        self._show = self._last = None
        if self._owns_context and self.ctx is not None:
            gc.collect()  # objects that wait for collection must go while their context is alive
            self.ctx.release()
        self.ctx = None  # type: ignore[assignment]

    def __del__(self) -> None:
        # One that is dropped without `close`: what lives on the context holds it, and goes when Python collects circles.
        if self.__dict__.get("_owns_context") and self.__dict__.get("ctx") is not None and not sys.is_finalizing():
            self.__dict__.clear()
            gc.collect()

    # -- pictures ----------------------------------------------------------------------------------------------------

    def prepare(self, scene: Scene | str | None = None, **changes: Any) -> Frame:
        """Read the files of a scene and fit its lights. Parameters as for `render`."""
        self._check()
        return self._frames.make(scene, **changes)

    def render(self, scene: Scene | str | None = None, *, aovs: str | Iterable[str] = (), **changes: Any) -> Any:
        """Render one picture, or with `aovs` its layers.

        Parameters
        ----------
        scene : a Scene, the name of a built-in one, or a file; default: silk on the built-in cloth in the studio.
            The curtain is traced; for all else of it see `show`.
        fabric, mesh, environment : a name, a file, or the object itself; of meshes also several
        cloths : several picture.frame.Cloth, each a mesh and its fabric, instead of one
        objects : names and files of meshes that stand about the cloth, or Objects
        lights : Lights or SphericalGaussians in world space instead of a fit of the environment
        camera : Camera, or scene.View such as View(view="side", ortho=2.0), instead of the scene's
        aovs : names of layers for compositing: depth, normal, position, uv, albedo, direct, bounce, transmission, background,
            mask, cryptomatte, or "all"; see docs/pictures.md
        any other keyword : a field of Scene, for example method="reference", size=(320, 240), spp=4

        Returns an image.Picture: float32 [H, W, 3], linear Rec. 709, top row first; [H, W, 4] with premultiplied alpha when
        the background is off; with `aovs` a picture.layers.Layers, a dict of such arrays, the picture as "beauty". Raises
        InputError for wrong input, and what the methods raise.
        """
        scene = Scene() if scene is None else load_scene(scene)
        names = chosen(aovs, changes.get("method", scene.method))
        if scene.curtain is not None:
            from .curtain_layers import curtain_layers  # cloth starts without it

            show = self.show(scene, **changes)
            picture = show.picture(parted=bool(set(names) & set(LIGHT)))
            check_errors(self.ctx, "curtain")
            picture = as_picture(picture, show.scene)
            return curtain_layers(show, names, picture) if names else picture
        frame = self.prepare(scene, **changes)
        return self.render_layers(frame, names) if names else as_picture(self.render_frame(frame), frame.scene)

    def render_layers(self, frame: Frame, names: Sequence[str]) -> Layers:
        """Draw a prepared frame with its layers, all pixels shaded; result as for `render` with `aovs`."""
        if frame.scene.method == "path":
            return self._path_layers(frame, chosen(names, "path"))
        if frame.scene.adaptive:
            frame = replace(frame, scene=frame.scene.model_copy(update={"adaptive": False}))
        self._last = frame
        gathering = Gathering(chosen(names), frame)
        drain(self.steps(frame, announce=f"{frame.scene.method}: passes over the picture", gathering=gathering))
        picture = self.target.read()
        return gathering.result(as_picture(picture[..., :3] if frame.scene.background else picture, frame.scene))

    def _path_layers(self, frame: Frame, names: Sequence[str]) -> Layers:
        """The picture by method path, and layers of what PATH_SAMPLES samples of its pixels see."""
        picture = as_picture(self.render_frame(frame), frame.scene)
        before = self._target, self._by_path
        plain = {"method": "direct", "spp": PATH_SAMPLES, "shadows": "off", "adaptive": False}
        bare = replace(frame, scene=frame.scene.model_copy(update=plain))
        self.stage.take(bare)
        gathering = Gathering(names, bare)
        self._passes.gather(bare, self._targets.get(bare.scene.size, True), gathering)
        if before[0] is not None and self._targets.holds(before[0]):
            self._target, self._by_path = before
        return gathering.result(picture)

    def show(
        self,
        scene: Scene | str,
        *,
        environment: Environment | str | Path | None = None,
        camera: Camera | View | None = None,
        **changes: Any,
    ) -> CurtainShow:
        """The curtain of a scene as it hangs at its frame: its picture, layers and tree. It is this renderer's, and another
        call may change it. Parameters as for `render`, without mesh, objects and lights. Raises InputError."""
        from ..curtain.show import show_at_its_frame  # cloth starts without it

        self._check()

        if isinstance(environment, str | Path):
            changes["env"], environment = environment, None
        if camera is not None:
            changes["camera"] = View.of(camera) if isinstance(camera, Camera) else camera
        scene = load_scene(scene).changed(**{name: value for name, value in changes.items() if value is not None})
        if scene.curtain is None:
            raise InputError("a scene without a curtain; give one with the table curtain, such as Scene(curtain={})")
        scene = scene.model_copy(update={"fabric": self._frames.fabric(scene.fabric)})
        environment = environment or self._frames.environment(scene.env, scene)
        self._last = self._show = show_at_its_frame(self.ctx, scene, environment, self._show)
        return self._show

    def facts(self) -> dict[str, Any]:
        """Facts about the last picture of `render`, in plain values."""
        if not isinstance(self._last, Frame):
            return {} if self._last is None else self._last.facts()
        frame = self._last
        traced = {}
        if frame.scene.method == "path":
            traced = self._paths.sums().facts()
        return {
            "method": frame.scene.method,
            "fabric": ", ".join(dict.fromkeys(cloth.fabric.name for cloth in frame.cloths)),
            "lobes": len(frame.lights.gaussians),
            "suns": len(frame.lights.suns),
            "covered_pixels": self.covered_pixels(),
            **({} if traced else {"shade": self.stage.cloths[0].way}),
            **traced,
        }

    def render_frame(self, frame: Frame) -> np.ndarray:
        """Draw a prepared frame and read it back; result as for `render`."""
        self._last = frame
        self.draw(frame)
        if frame.scene.method == "path" and frame.scene.denoise:
            self.target.color.write(np.ascontiguousarray(denoised(self._paths.sums())[::-1], "f4"))
            for _ in self.path_hairs(frame, self.target.framebuffer):
                pass
        picture = self.target.read()
        check_errors(self.ctx, f"method {frame.scene.method}")
        return picture[..., :3] if frame.scene.background else picture

    def draw(self, frame: Frame) -> None:
        """Draw a frame into a texture, `target.color`; nothing is read back."""
        drain(self.steps(frame, announce=f"{frame.scene.method}: passes over the picture"))

    def draw_aside(self, frame: Frame) -> None:
        """As `draw`, and wait for it, of a frame that nobody sees: places are asked of the picture before, where it is kept."""
        before = self._target, self._by_path
        self.draw(frame)
        self.ctx.finish()
        if before[0] is not None and self._targets.holds(before[0]):
            self._target, self._by_path = before

    def steps(
        self,
        frame: Frame,
        rows: Callable[[], int] | None = None,
        announce: str | None = None,
        preview: bool = False,
        gathering: Gathering | None = None,
    ) -> Iterator[tuple[int, int]]:
        """Draw a frame in steps, for a caller with other things to do in between; together they do what `draw` does,
        bit for bit. Nothing else may be drawn with this renderer before the last step or the iterator's end.

        Parameters: as for Pace, and `gathering` of layers; where it is a `preview`, `trace_visibility` makes the shadows
        complete.

        Yields (passes finished, passes in all) after each step; the background follows the last one.
        """
        self._check()
        check_stopped()
        pace = Pace(rows, preview, announce)
        target = self._targets.get(frame.scene.size, gathering is not None)
        # In parts and as previews, as the window draws, its scenes are shown by `direct`.
        if frame.scene.method == "path" and rows is None and not preview:
            self._target, self._last, self._by_path = target, frame, frame
            yield from self._traced(frame, target.framebuffer, pace)
            return
        self.stage.take(frame)
        self._target, self._by_path = target, None
        yield from self._passes.steps(frame, target, pace, gathering)

    def path_steps(
        self, frame: Frame, target: moderngl.Framebuffer, patience: Callable[[], float]
    ) -> Iterator[tuple[int, int]]:
        """Trace a frame of method `path` into a framebuffer of its size, for a caller with other things to do in between:
        yields (samples finished, samples at most); `draw_paths` draws them. The end is what `draw` makes, bit for bit.

        patience : seconds that the next step may take

        Raises InputError for what paths cannot show.
        """
        self._check()
        check_stopped()
        self._last = self._by_path = frame
        yield from self._traced(frame, target, Pace(), patience)

    def _traced(
        self, frame: Frame, target: moderngl.Framebuffer, pace: Pace, patience: Callable[[], float] | None = None
    ) -> Iterator[tuple[int, int]]:
        """Trace a frame, and draw its hairs where no denoiser follows."""
        done = (0, 0)
        for done in self._paths.steps(frame, target, pace, patience):
            yield done
        if not frame.scene.denoise:
            for _ in self.path_hairs(frame, target):
                yield done

    def path_hairs(self, frame: Frame, target: moderngl.Framebuffer) -> Iterator[None]:
        """Draw the hairs of a frame of method `path` over its finished picture in a framebuffer, in steps; denoised pictures
        get theirs afterwards."""
        if not self._paths.shows_hairs(frame):
            return
        own = self._targets.get(frame.scene.size)
        if target is not own.framebuffer:
            self.ctx.copy_framebuffer(own.framebuffer, target)
        yield from self.stage.hairs_over(own, frame)
        if target is not own.framebuffer:
            self.ctx.copy_framebuffer(target, own.framebuffer)

    def draw_paths(self, target: moderngl.Framebuffer) -> None:
        """Draw the mean of the samples so far of the last `path_steps`."""
        self._paths.draw(target)

    def draw_background(self, frame: Frame, target: moderngl.Framebuffer) -> None:
        """Draw the environment behind a copy of the last draw in another framebuffer of its size."""
        self._background.draw(frame, target)

    # -- in between --------------------------------------------------------------------------------------------------

    def trace_visibility(self, frame: Frame, count: int = 32, enough: int | None = None) -> Iterator[int]:
        """Trace the missing directions of a frame's shadows, `count` a step; none where these are complete or off, or,
        for a first impression, where `enough` are traced.

        Yields how many directions are traced.
        """
        self._check()
        self.stage.take(frame)
        yield from self.stage.trace(count, enough)

    def follow_poses(self, follow: bool = True) -> None:
        """Take meshes with the same triangles for poses of one cloth that moves: each pose traces a quarter of its
        vertices' directions anew, and keeps the rest from the last three. A cut, a jump of the cloth, is noticed."""
        self._frames.follow = follow
        self.stage.follow_poses(follow)

    # -- the last draw -----------------------------------------------------------------------------------------------

    @property
    def target(self) -> Target:
        """The target of the last draw."""
        assert self._target is not None
        return self._target

    @property
    def gbuffer(self) -> GBuffer:
        """The G-buffer of the first cloth in the last draw."""
        return self.target.part(self.stage.cloths[0]).buffer

    def pick(self, x: float, y: float) -> Picked | None:
        """The part of the cloth at a place of the last picture, from 0 to 1 from its top left corner; None: no cloth."""
        self._check()
        if self._by_path is not None:
            return self._paths.pick(self._by_path, x, y)
        return None if self._target is None else pick(self.target, self.stage.cloths_in_frame, x, y)

    def path_sums(self) -> PathSums:
        """Of the last picture by method `path`: its samples, light, standard error and noise. Raises InputError for another."""
        self._check()
        if self._last is None or self._last.scene.method != "path":
            raise InputError("path_sums: the last picture was not by method path; render one first")
        return self._paths.sums() if isinstance(self._last, Frame) else self._last.paths.tracer.sums()

    def covered_pixels(self) -> int:
        """How many pixels of the last draw see cloth."""
        self._check()
        if isinstance(self._last, Frame) and self._last.scene.method == "path":
            return int((self._paths.sums().cover > 0).sum())
        return sum(int(self.target.part(cloth).buffer.covered().sum()) for cloth in self.stage.cloths_in_frame)

    def method(self, name: MethodName) -> Method:
        """The method of a name, as the first cloth has it; made at first use."""
        self._check()
        return self.stage.cloths[0].named_method(name)

    # -- radiance ----------------------------------------------------------------------------------------------------

    def radiance(
        self,
        fabric: Fabric | str,
        omega_o: np.ndarray,
        lights: Lights | SphericalGaussians,
        method: MethodName = "direct",
        quality: Quality = "normal",
        parts: bool = False,
        **settings: Any,
    ) -> np.ndarray:
        """Radiance toward given directions at one point, by the shaders that render pictures.

        Parameters
        ----------
        fabric : Fabric, built-in name or file
        omega_o : [N, 3] unit, in the surface frame (x = yarn 1, y = yarn 2, z = N), away from the surface
        lights : in that same frame
        method, quality : as for `render`; other keywords are fields of Settings (segments, cube, contribution, ...)
        parts : the terms of the sum over tangents, each by itself, in the order of `fabric.tangents`

        Returns float32 [N, 3], linear, or [N, T, 3] in `parts`; 0 where omega_o is below the surface. Raises InputError
        for wrong input.
        """
        self._check()
        omega_o = np.atleast_2d(np.asarray(omega_o, np.float32))
        if (
            omega_o.ndim != 2
            or omega_o.shape[1] != 3
            or not np.allclose(np.linalg.norm(omega_o, axis=-1), 1.0, atol=0.01)
        ):
            raise InputError(f"omega_o: shape {omega_o.shape}, expected [N, 3] finite directions of length 1")
        fabric, lights = self._frames.fabric(fabric), as_lights(lights)
        chosen, how = self.method(method), Settings(quality=quality, **settings)
        buffers = self.stage.cloths[0].scene_buffers
        if parts:
            return chosen.part_radiances(buffers, fabric, lights, how, omega_o)
        buffers.prepare(fabric, lights)
        chosen.prepare(fabric, lights, how)
        radiance = chosen.radiance(buffers, omega_o)
        check_errors(self.ctx, f"method {method}")
        return radiance
