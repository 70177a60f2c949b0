"""`glcloth animate`: a sequence of pictures; `glcloth drape`: the built-in cloths made again."""

from __future__ import annotations

import math
import time
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from ..errors import InputError
from ..files import atomic_write, check_writable
from ..progress import note, track
from .common import Device, Json, output_option, tell, whole
from .many import Many, template
from .options import SceneOptions, scene_of

if TYPE_CHECKING:
    from ..farm.film import Film
    from ..scene import Scene


def animate(
    scene: str | None = None,
    /,
    *,
    output: Annotated[Path, output_option("Video (.mp4), or frames such as frames/%04d.png or .exr.")],
    frames: Annotated[int, Parameter(converter=whole, help="Frames of the whole sequence.")] = 120,
    start: Annotated[int, Parameter(converter=whole, help="First frame to render; earlier ones are kept.")] = 0,
    rate: Annotated[int, Parameter(converter=whole, help="Frames per second of a video.")] = 24,
    turntable: Annotated[
        bool | None, Parameter(help="Turn the camera once around the cloth; default: where nothing else moves.")
    ] = None,
    turn_env: Annotated[float, Parameter(help="Degrees by which the environment turns over the sequence.")] = 0.0,
    aov: Annotated[
        str | None,
        Parameter(help="Layers for compositing in each .exr frame, as of render; curtain: depth to cryptomatte."),
    ] = None,
    many: Many | None = None,
    options: SceneOptions | None = None,
    device: Device = None,
    json: Json = False,
) -> None:
    """Render a sequence: the curtain in the wind, or cloth that moves, under light that turns, or seen from all around.

    Cloth moves by poses from files (--mesh poses/%04d.ply: frame i takes file i, from --start on) or, the built-in one,
    in the --wind. Where nothing else moves the camera goes once around it. Many processes or machines share the frames.

    Parameters
    ----------
    scene
        Built-in scene, scene file (.toml), or a picture that glcloth rendered. Default: silk on the built-in cloth.
    """
    chosen, wind = _scene_and_wind(scene, options)
    _check_numbers(frames, start, rate, turn_env)
    if chosen.curtain is not None and (turntable or turn_env):
        raise InputError("--turntable, --turn-env: for cloth under an environment; the curtain hangs in a room")

    from ..farm.film import Film
    from ..picture.sequence_files import check_sequence

    video = check_sequence(output, chosen.size)
    if video and start:
        raise InputError(f"{output}: a video starts at frame 0; write frames/%04d.png to resume with --start")
    film = Film(
        chosen, str(output), frames, rate, wind, turntable, turn_env, device, start, _layers(aov, chosen, output)
    )
    begin = time.perf_counter()
    if many is not None and many.openjd is not None:
        from ..farm.openjd import film_template

        many.check()
        if video:
            raise InputError(f"{output}: a farm writes frames; choose frames/%04d.png or .exr")
        template(many.openjd, film_template(film), chosen, output.parent, frames - start, json)
        return
    if many is not None and many.asked:
        from .many import animate as by_many

        many.check()
        done = by_many(film, many, start, video)
    else:
        done = frames - start
        _film_here(film, start, video)
    seconds = time.perf_counter() - begin
    result = {"file": str(output), "frames": done, "seconds": round(seconds, 3)}
    said = f"{done} frames, {seconds / done:.2f} s each" if done else "no frame was missing"
    tell(json, result, f"{output}: {said}")


def _layers(aov: str | None, scene: Scene, output: Path) -> tuple[str, ...]:
    """The layers that were asked for. Raises InputError where there are none such, or no place for them."""
    if aov is None:
        return ()
    from ..picture.layers import chosen

    if output.suffix.lower() != ".exr":
        raise InputError(f"{output}: --aov writes layers, expected frames such as frames/%04d.exr")
    return chosen(aov, scene.method)


def _film_here(film: Film, start: int, video: bool) -> None:
    """Render a film in this process, its frames or a video."""
    from ..picture import sequence, sequence_files
    from ..picture.renderer import Renderer

    look = film.scene.exposure, film.scene.transform
    with ExitStack() as stack:
        renderer = stack.enter_context(Renderer(film.device))
        pictures = sequence.pictures(renderer, film.start, film.motion(renderer, stack), start, film.aovs)
        if video:
            written = sequence_files.write_video(pictures, Path(film.output), film.rate, *look)
        else:
            written = sequence_files.write_frames(pictures, film.output, start, film.header, *look)
        for _ in track(written, f"{film.output}: frames", film.frames - start):
            pass


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


def drape(
    piece: str = "drape",
    /,
    *,
    output: Annotated[Path, output_option("Mesh to write, .ply, .obj or .glb; .npz: the simulated vertices alone.")],
    device: Device = None,
) -> None:
    """Make a built-in cloth again by simulation.

    Parameters
    ----------
    piece
        drape: a sheet that falls over a sphere and a table's edge; throw: one over a ball on a pedestal; skirt: gathered, on a
        dress form; folds: a length in folds a hand high.
    """
    from ..geometry.mesh_files import SAVE_SUFFIXES, save_mesh
    from ..geometry.pieces import piece_mesh
    from ..geometry.spline import packed
    from ..gpu.context import create_context
    from ..simulation.drape import drape as simulate
    from ..simulation.pieces import check_piece, simulated

    suffixes = SAVE_SUFFIXES if piece == "drape" else (*SAVE_SUFFIXES, ".npz")
    if output.suffix.lower() not in suffixes:
        kind = output.suffix or "a file without suffix"
        raise InputError(f"{output}: cannot write {kind}, expected a name that ends in {', '.join(suffixes)}")
    check_writable(output)
    if piece == "drape":
        mesh = simulate(create_context(device))
    else:
        check_piece(piece)
        positions, size = simulated(create_context(device), piece)
        if output.suffix.lower() == ".npz":
            with atomic_write(output) as temporary:
                temporary.write_bytes(packed(positions, size))
            note(f"{output}: {positions.shape[0]} x {positions.shape[1]} vertices")
            return
        mesh = piece_mesh(piece, positions, size)
    save_mesh(output, mesh)
    note(f"{output}: {len(mesh.triangles)} triangles")
