"""`glcloth animate`: a sequence of pictures; `glcloth drape`: the built-in cloth made again."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ..errors import InputError
from ..files import check_writable
from ..progress import say, track
from .common import Device, Json, output_option, tell
from .options import SceneOptions, scene_of

if TYPE_CHECKING:
    from ..geometry.mesh import Mesh
    from ..picture.renderer import Renderer
    from ..scene import Scene
    from ..simulation.drape import Swaying


def animate(
    scene: str | None = None,
    /,
    *,
    output: Annotated[Path, output_option("Video (.mp4), or frames such as frames/%04d.png or .exr.")],
    frames: Annotated[int, Parameter(help="Frames of the whole sequence.")] = 120,
    start: Annotated[int, Parameter(help="First frame to render; earlier ones are kept.")] = 0,
    rate: Annotated[int, Parameter(help="Frames per second of a video.")] = 24,
    turntable: Annotated[
        bool | None, Parameter(help="Turn the camera once around the cloth; default: where nothing else moves.")
    ] = None,
    turn_env: Annotated[float, Parameter(help="Degrees by which the environment turns over the sequence.")] = 0.0,
    options: SceneOptions | None = None,
    device: Device = None,
    json: Json = False,
) -> None:
    """Render a sequence: the curtain in the wind, or cloth that moves, under light that turns, or seen from all around.

    Cloth moves by poses from files (--mesh poses/%04d.ply: frame i takes file i, from --start on) or, the built-in one, in the --wind.
    Where nothing else moves the camera goes once around it.

    Parameters
    ----------
    scene
        Built-in scene, scene file (.toml), or a picture that glcloth rendered. Default: silk on the built-in cloth.
    """
    chosen, wind = _scene_and_wind(scene, options)
    _check_numbers(frames, start, rate, turn_env)
    if chosen.curtain is not None and (turntable or turn_env):
        raise InputError("--turntable, --turn-env: for cloth under an environment; the curtain hangs in a room")

    from ..picture import sequence
    from ..picture.renderer import Renderer

    video = sequence.check_sequence(output, chosen.size)
    if video and start:
        raise InputError(f"{output}: a video starts at frame 0; write frames/%04d.png to resume with --start")
    transform = chosen.transform
    begin = time.perf_counter()
    files = sequence.pose_files(chosen.mesh, frames, start) if "%" in chosen.mesh else None
    if files or chosen.curtain is not None:
        chosen = chosen.changed(**({"mesh": str(files[min(files)])} if files else {"rate": rate}))
    with ExitStack() as stack:
        renderer = stack.enter_context(Renderer(device))
        poses = _poses(renderer, stack, files, wind, rate)
        if turntable is None:
            turntable = poses is None and not turn_env
        pictures = sequence.pictures(renderer, chosen, frames, start, poses, turntable, turn_env, min(files or (0,)))
        if video:
            written = sequence.write_video(pictures, output, rate, chosen.exposure, transform)
        else:
            settings = functools.partial(_header_of_frame, chosen, files, turn_env / frames)
            written = sequence.write_frames(pictures, str(output), start, settings, chosen.exposure, transform)
        for _ in track(written, f"{output}: frames", frames - start):
            pass
    seconds = time.perf_counter() - begin
    result = {"file": str(output), "frames": frames - start, "seconds": round(seconds, 3)}
    tell(json, result, f"{output}: {frames - start} frames, {seconds / (frames - start):.2f} s each")


def _scene_and_wind(name: str | None, options: SceneOptions | None) -> tuple[Scene, float | None]:
    """The scene of a sequence, and the wind of a cloth under an environment, which is no part of its scene."""
    from ..scene import load_scene

    wind = options.wind if options is not None else None
    if wind is None or (name is not None and load_scene(name).curtain is not None):
        return scene_of(name, options), None
    chosen = scene_of(name, replace(options, wind=None))
    if chosen.mesh != "drape":
        raise InputError(
            f"--wind: moves the built-in cloth (drape) and the curtain, not {chosen.mesh}; give poses: --mesh %04d.ply"
        )
    return chosen, wind


def _check_numbers(frames: int, start: int, rate: int, turn_env: float) -> None:
    if not math.isfinite(turn_env):
        raise InputError(f"--turn-env {turn_env}: expected degrees")
    if not 1 <= frames <= 100_000 or not 0 <= start < frames:
        raise InputError(f"--frames {frames} --start {start}: expected 1 to 100000 frames and a start below that")
    if not 1 <= rate <= 240:
        raise InputError(f"--rate {rate}: expected 1 to 240 frames per second")


def _poses(
    renderer: Renderer, stack: ExitStack, files: Mapping[int, Path] | None, wind: float | None, rate: int
) -> Callable[[int], Mesh] | None:
    """The mesh of each frame of a cloth that moves; None for one that rests."""
    from ..geometry.mesh_files import load_mesh
    from ..simulation.drape import Swaying

    if files:
        return lambda number: load_mesh(files[number])
    if wind is None:
        return None
    swaying = Swaying(renderer.ctx, wind)
    stack.callback(swaying.release)
    return functools.partial(_swayed, swaying, rate)


def _swayed(swaying: Swaying, rate: int, number: int) -> Mesh:
    """The pose of a frame, asked for in ascending order."""
    while swaying.frame < number:
        swaying.step(1.0 / rate)
    return swaying.mesh()


def _header_of_frame(scene: Scene, files: Mapping[int, Path] | None, turn: float, number: int) -> dict:
    """The scene as a picture of a sequence keeps it."""
    from ..scene import header

    changes: dict = {"mesh": str(files[number])} if files else {}
    if turn:
        changes["env_rotate"] = scene.env_rotate + turn * number
    if scene.curtain is not None:
        changes["frame"] = number
    return header(scene.changed(**changes))


def drape(
    *, output: Annotated[Path, output_option("Mesh to write, .ply, .obj or .glb.")], device: Device = None
) -> None:
    """Make the built-in cloth again by simulation: a sheet that falls over a sphere and a table's edge."""
    from ..geometry.mesh_files import SAVE_SUFFIXES, save_mesh
    from ..gpu.context import create_context
    from ..simulation.drape import drape as simulate

    if output.suffix.lower() not in SAVE_SUFFIXES:
        raise InputError(f"{output}: cannot write {output.suffix or 'a file without suffix'}, expected {SAVE_SUFFIXES}")
    check_writable(output)
    mesh = simulate(create_context(device))
    save_mesh(output, mesh)
    say(f"{output}: {len(mesh.triangles)} triangles")
