"""The command line: each command reads its options, calls the package, and says in one line what it did or what is wrong."""

from __future__ import annotations

import functools
import json
import math
import os
import re
import sys
import time
from contextlib import ExitStack
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, CycloptsError, Parameter

from . import __version__
from .errors import InputError, NoOpenGLError, ShaderError
from .files import check_writable
from .progress import hear_ctrl_c, say, track, was_stopped

ABOUT = """Woven cloth as it really looks, on OpenGL.

Exit codes: 0 done, 1 a fault of glcloth, 2 wrong input, 3 no usable OpenGL, 130 stopped by Ctrl-C.
GLCLOTH_CACHE names the folder for fits and tables made on this machine (`glcloth info` shows it).
"""
app = App(name="glcloth", help=ABOUT, version=__version__, help_format="plaintext", suppress_keyboard_interrupt=False)

Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object on stdout.")]
Device = Annotated[int | None, Parameter(help="EGL device; `glcloth info` lists them.")]


def _output(text: str):
    return Parameter(name=["--output", "-o"], help=text)


@Parameter(name="*")
@dataclass
class SceneOptions:
    """What to render; an option that is not given keeps the scene's value."""

    fabric: Annotated[str | None, Parameter(help="Built-in fabric, a .toml file, or a draft (.wif).")] = None
    mesh: Annotated[str | None, Parameter(help="Built-in mesh or a file (.obj .ply .glb .gltf).")] = None
    objects: Annotated[
        list[str] | None,
        Parameter(
            name="--object", negative="", help="Mesh that stands by the cloth, matt, in its own colours; repeatable."
        ),
    ] = None
    ground: Annotated[
        str | None, Parameter(help="Ground: a height in metres; alone or auto: just under the lowest point; or off.")
    ] = None
    ground_color: Annotated[str | None, Parameter(help="R,G,B of the ground, linear, 0 to 1.")] = None
    env: Annotated[str | None, Parameter(help="Built-in environment or an equirectangular .hdr or .exr file.")] = None
    env_rotate: Annotated[float | None, Parameter(help="Turn the environment about +Y, degrees.")] = None
    lobes: Annotated[str | None, Parameter(help="Spherical Gaussians of the environment, 1 to 64, or auto.")] = None
    lights: Annotated[
        str | None, Parameter(help="File of lights (.json, .toml) instead of a fit; `glcloth env` writes one.")
    ] = None
    method: Annotated[str | None, Parameter(help="direct, paper, reference or trace.")] = None
    quality: Annotated[str | None, Parameter(help="draft, normal or high (method direct).")] = None
    adaptive: Annotated[
        bool | None, Parameter(help="Shade one pixel in four where neighbours are alike (method direct).")
    ] = None
    light: Annotated[str | None, Parameter(help="sg or map: the fit, or the environment itself (reference).")] = None
    shadows: Annotated[str | None, Parameter(help="off, sun or full: what the cloth hides from itself.")] = None
    bounce: Annotated[bool | None, Parameter(help="Light from fold to fold, once (with --shadows full).")] = None
    segments: Annotated[int | None, Parameter(help="Theta segments (method paper).")] = None
    cube: Annotated[int | None, Parameter(help="Edge of the cube map that is summed (method reference).")] = None
    contribution: Annotated[float | None, Parameter(help="Share of the singular values kept (method paper).")] = None
    grid: Annotated[int | None, Parameter(help="Directions per axis of the tables (method paper).")] = None
    spp: Annotated[int | None, Parameter(help="Samples per pixel.")] = None
    size: Annotated[str | None, Parameter(help="WIDTHxHEIGHT.")] = None
    exposure: Annotated[float | None, Parameter(help="Stops, for PNG.")] = None
    view_transform: Annotated[str | None, Parameter(help="standard, filmic, neutral or agx, for PNG.")] = None
    background: Annotated[bool | None, Parameter(help="Show the environment behind the cloth.")] = None
    accelerator: Annotated[str | None, Parameter(help="kdtree, lbvh or brute (curtain).")] = None
    depth: Annotated[int | None, Parameter(help="Depth of the rays (curtain).")] = None
    room: Annotated[str | None, Parameter(help="OBJ file of the room (curtain).")] = None
    wind: Annotated[
        float | None, Parameter(help="Wind, m/s: into the room (curtain); animate: along the built-in cloth.")
    ] = None
    fullness: Annotated[float | None, Parameter(help="Width of the cloth over that of the rail (curtain).")] = None

    def changes(self) -> dict:
        """The options that were given, as fields of Scene."""
        return {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) is not None}


# Options of a curtain that stand in its [curtain] table.
CURTAIN_OPTIONS = ("wind", "fullness")


def _scene(name: str | None, options: SceneOptions | None):
    """The Scene or CurtainScene of a command."""
    from .scene import Scene, builtin_scenes, load_scene

    changes = options.changes() if options else {}
    curtain = None
    if name and name not in builtin_scenes():
        from .curtain.show import (
            load_curtain_scene,  # only now: it brings OpenGL, and a wrong option should fail at once
        )

        curtain = load_curtain_scene(name)
    if curtain is None:
        if changes.get("method") == "trace":
            raise InputError("--method trace: renders the curtain; give its scene: glcloth render curtain -o FILE")
        scene = load_scene(name) if name else Scene()
        return scene.changed(**changes)
    method = changes.pop("method", "trace")
    if method != "trace":
        raise InputError(f"--method {method}: the curtain is ray traced, expected trace")
    table = {key: changes.pop(key) for key in CURTAIN_OPTIONS if key in changes}
    if table:
        changes["curtain"] = {**curtain.model_dump()["curtain"], **table}
    return curtain.changed(**changes)


def _stored(scene) -> dict:
    """A scene as a picture keeps it: files by their whole path, so that the picture renders again from any folder."""
    data = scene.model_dump(mode="json")
    for key in ("fabric", "mesh", "env", "lights", "room"):
        if isinstance(data.get(key), str) and data[key] and Path(data[key]).is_file():
            data[key] = str(Path(data[key]).resolve())
    if data.get("objects"):
        data["objects"] = [str(Path(name).resolve()) if Path(name).is_file() else name for name in data["objects"]]
    return data


def _frame_of(scene: str | None) -> int | None:
    """The frame of the moving curtain that a picture shows; None for anything else."""
    from .image import read_settings

    if scene is None or Path(scene).suffix.lower() not in (".png", ".exr"):
        return None
    return (read_settings(scene) or {}).get("frame")


def _print(as_json: bool, result: dict, line: str) -> None:
    if as_json:
        print(json.dumps(result), flush=True)
    else:
        say(line)


@app.command
def render(
    scene: str | None = None,
    /,
    *,
    output: Annotated[Path, _output("Picture to write, .png or .exr.")],
    options: SceneOptions | None = None,
    frame: Annotated[
        int | None, Parameter(help="Frame of the moving curtain; default: that of the picture given as scene, or 48.")
    ] = None,
    show_tree: Annotated[
        str | None, Parameter(help="Curtain: the tree beside the picture: leaves, or a level.")
    ] = None,
    layers: Annotated[
        bool, Parameter(negative="", help="Curtain: blended layers without shadows instead, to compare.")
    ] = False,
    device: Device = None,
    json: Json = False,
) -> None:
    """Render one picture of a scene.

    Parameters
    ----------
    scene
        Built-in scene, scene file (.toml), or a picture that glcloth rendered. Default: silk on the built-in cloth.
    """
    from .image import check_output, write_image
    from .renderer import Renderer
    from .scene import Scene

    chosen = _scene(scene, options)
    check_output(output)
    begin = time.perf_counter()
    if not isinstance(chosen, Scene):
        _render_curtain(chosen, output, _frame_of(scene) if frame is None else frame, show_tree, layers, device, json)
        return
    with Renderer(device) as renderer:
        frame = renderer.prepare(chosen)
        picture = renderer.render_frame(frame)
        covered = renderer.covered_pixels()
        gl = renderer.ctx.info["GL_RENDERER"]
    write_image(
        output,
        picture,
        {"glcloth": __version__, "scene": _stored(chosen)},
        exposure=chosen.exposure,
        view_transform=chosen.view_transform,
    )
    seconds = time.perf_counter() - begin
    result = {
        "file": str(output),
        "width": chosen.size[0],
        "height": chosen.size[1],
        "method": chosen.method,
        "fabric": frame.fabric.name,
        "lobes": len(frame.lights.gaussians),
        "suns": len(frame.lights.suns),
        "covered_pixels": covered,
        "seconds": round(seconds, 3),
        "gl_renderer": gl,
    }
    _print(json, result, f"{output}: {frame.fabric.name}, method {chosen.method}, {seconds:.1f} s on {gl}")


def _render_curtain(scene, output: Path, number: int, show_tree, layers: bool, device, json: bool) -> None:
    import numpy as np

    from .context import create_context
    from .curtain.show import CurtainShow
    from .image import write_image

    number = 48 if number is None else number
    if not 0 <= number <= 100_000:
        raise InputError(f"--frame {number}: expected 0 to 100000")
    if show_tree is not None and show_tree != "leaves" and not show_tree.isdigit():
        raise InputError(f"--show-tree {show_tree}: expected leaves, or a level such as 8")
    if show_tree is not None and scene.accelerator == "brute":
        raise InputError("--show-tree: brute force has no tree; use --accelerator kdtree or lbvh")
    begin = time.perf_counter()
    with CurtainShow(create_context(device), scene) as show:
        for _ in track(range(number), "the wind blows: frames", number):
            show.advance()
        picture = show.layers() if layers else show.picture()
        if show_tree is not None:
            tree = show.tree(None if show_tree == "leaves" else int(show_tree))
            picture = np.hstack([picture[..., :3], tree[..., :3]])
        triangles, name = show.triangles.count, show.fabric.name
    settings = {"glcloth": __version__, "curtain": _stored(scene), "frame": number}
    write_image(output, picture, settings, exposure=scene.exposure, view_transform=scene.view_transform)
    seconds = time.perf_counter() - begin
    result = {"file": str(output), "width": picture.shape[1], "height": picture.shape[0], "method": "trace"}
    result |= {"fabric": name, "frame": number, "triangles": triangles, "seconds": round(seconds, 3)}
    _print(json, result, f"{output}: {name}, {triangles} triangles, frame {number}, {seconds:.1f} s")


@app.command
def animate(
    scene: str | None = None,
    /,
    *,
    output: Annotated[Path, _output("Video (.mp4), or frames such as frames/%04d.png or .exr.")],
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

    Cloth moves by poses from files (--mesh poses/%04d.ply: frame i takes file i) or, the built-in one, in the --wind.
    Where nothing else moves the camera goes once around it.

    Parameters
    ----------
    scene
        Built-in scene, scene file (.toml), or a picture that glcloth rendered. Default: silk on the built-in cloth.
    """
    from . import animate as sequence
    from .context import create_context
    from .curtain.show import CurtainShow
    from .drape import Swaying
    from .mesh import load_mesh
    from .renderer import Renderer
    from .scene import Scene

    chosen, wind = _scene_to_animate(scene, options)
    if not isinstance(chosen, Scene) and (turntable or turn_env):
        raise InputError("--turntable, --turn-env: for cloth under an environment; the curtain hangs in a room")
    if not math.isfinite(turn_env):
        raise InputError(f"--turn-env {turn_env}: expected degrees")
    if not 1 <= frames <= 100_000 or not 0 <= start < frames:
        raise InputError(f"--frames {frames} --start {start}: expected 1 to 100000 frames and a start below that")
    if not 1 <= rate <= 240:
        raise InputError(f"--rate {rate}: expected 1 to 240 frames per second")
    video = sequence.check_sequence(output, chosen.size)
    if video and start:
        raise InputError(f"{output}: a video starts at frame 0; write frames/%04d.png to resume with --start")
    begin = time.perf_counter()
    files = None
    if isinstance(chosen, Scene) and "%" in chosen.mesh:
        files = sequence.pose_files(chosen.mesh, frames)
    with ExitStack() as stack:
        if isinstance(chosen, Scene):
            renderer = stack.enter_context(Renderer(device))
            poses = None
            if files:
                poses = lambda i: load_mesh(files[i])  # noqa: E731
                chosen = chosen.changed(mesh=str(files[0]))
            elif wind is not None:
                swaying = Swaying(renderer.ctx, wind)
                stack.callback(swaying.release)
                poses = functools.partial(_swayed, swaying, rate)
            if turntable is None:
                turntable = poses is None and not turn_env
            pictures = sequence.moving(renderer, renderer.prepare(chosen), frames, start, poses, turntable, turn_env)
        else:
            chosen = chosen.changed(rate=rate)
            pictures = stack.enter_context(CurtainShow(create_context(device), chosen)).frames(frames, start)
        look = chosen.exposure, chosen.view_transform
        if video:
            written = sequence.write_video(pictures, output, rate, *look)
        else:
            settings = functools.partial(_settings_of_frame, chosen, files, turn_env / frames)
            written = sequence.write_frames(pictures, str(output), start, settings, *look)
        for _ in track(written, f"{output}: frames", frames - start):
            pass
    seconds = time.perf_counter() - begin
    result = {"file": str(output), "frames": frames - start, "seconds": round(seconds, 3)}
    _print(json, result, f"{output}: {frames - start} frames, {seconds / (frames - start):.2f} s each")


def _scene_to_animate(name: str | None, options: SceneOptions | None):
    """The scene of a sequence, and the wind of a cloth under an environment, which is no part of its scene."""
    from .scene import Scene

    wind = options.wind if options else None
    if wind is None:
        return _scene(name, options), None
    chosen = _scene(name, replace(options, wind=None))
    if not isinstance(chosen, Scene):
        return _scene(name, options), None
    if chosen.mesh != "drape":
        raise InputError(
            f"--wind: moves the built-in cloth (drape) and the curtain, not {chosen.mesh}; give poses: --mesh %04d.ply"
        )
    return chosen, wind


def _settings_of_frame(scene, files: list[Path] | None, turn: float, number: int) -> dict:
    """What a picture of a sequence keeps of its scene."""
    from .scene import Scene

    if not isinstance(scene, Scene):
        return {"glcloth": __version__, "curtain": _stored(scene)}
    changes = {"mesh": str(files[number])} if files else {}
    if turn:
        changes["env_rotate"] = scene.env_rotate + turn * number
    return {"glcloth": __version__, "scene": _stored(scene.changed(**changes))}


def _swayed(swaying, rate: int, number: int):
    """The pose of a frame, asked for in ascending order."""
    while swaying.frame < number:
        swaying.step(1.0 / rate)
    return swaying.mesh()


@app.command
def view(
    scene: str | None = None,
    /,
    *,
    watch: Annotated[
        bool,
        Parameter(negative="", help="Reload shaders, fabric, mesh, environment and scene when their files change."),
    ] = False,
    options: SceneOptions | None = None,
) -> None:
    """Open the window: edit a fabric while it renders.

    Parameters
    ----------
    scene
        Built-in scene, scene file (.toml), or a picture that glcloth rendered. Default: silk on the built-in cloth.
    """
    from .window import view as open_window

    open_window(_scene(scene, options), watch, scene)


@app.command
def tables(
    *fabrics: str,
    grid: Annotated[int, Parameter(help="Directions per axis.")] = 48,
    contribution: Annotated[float, Parameter(help="Share of the sum of singular values to keep.")] = 0.9,
    output: Annotated[Path | None, _output("Folder for the tables; default: the cache.")] = None,
    json: Json = False,
) -> None:
    """Make the tables of the paper method: T (equation 9) and T_l (equation 14) of paper A.

    Parameters
    ----------
    fabrics
        Built-in fabrics or .toml files.
    """
    from .tables import main as make

    make(fabrics, grid, contribution, output, json)


@app.command
def env(
    file: str,
    /,
    *,
    lobes: Annotated[str, Parameter(help="1 to 64, or auto.")] = "10",
    output: Annotated[Path | None, _output("Fit to write (.json); the picture goes beside it as .png.")] = None,
    json: Json = False,
) -> None:
    """Fit spherical Gaussians and suns to an environment; report the error; write the fit and map | fit | difference.

    Parameters
    ----------
    file
        Built-in environment or an equirectangular .hdr or .exr file.
    """
    from .environment import load_environment
    from .fit import fit_picture, fit_report, save_lights
    from .image import write_image
    from .scene import Scene

    count = Scene().changed(lobes=lobes).lobes
    target = output or Path(f"{Path(file).stem}_fit.json")
    if target.suffix != ".json":
        raise InputError(f"{target}: expected a name that ends in .json; the picture is written beside it as .png")
    check_writable(target)
    environment = load_environment(file)
    report = fit_report(environment, count)
    save_lights(target, report.lights)
    picture = target.with_suffix(".png")
    write_image(picture, fit_picture(environment, report.lights))
    result = {"file": str(target), "picture": str(picture), **report.as_dict()}
    _print(json, result, f"{report}\n{target}, {picture}")


@app.command
def weave(
    draft: Path,
    /,
    *,
    output: Annotated[Path | None, _output("Fabric file to write (.toml).")] = None,
    picture: Annotated[
        Path | None, Parameter(help="Picture to write, .png or .exr: the drawdown, and the cloth in its flat colours.")
    ] = None,
    ends: Annotated[float | None, Parameter(help="Ends a cm; default: what the draft says.")] = None,
    picks: Annotated[float | None, Parameter(help="Picks a cm; default: what the draft says.")] = None,
    flip: Annotated[
        bool, Parameter(negative="", help="Read the picks from the bottom, as handweavers often do.")
    ] = False,
    json: Json = False,
) -> None:
    """Make a fabric of a weaver's draft; report sett, repeat, floats, cover and tilts; draw drawdown and cloth.

    Parameters
    ----------
    draft
        WIF file, or a fabric that has a weave (to report and draw it).
    """
    import numpy as np

    from .fabric import draft_fabric, load_fabric, save_fabric
    from .image import check_output, write_image
    from .weave.picture import weave_picture
    from .weave.report import lines_of, weave_report
    from .weave.wif import load_draft

    if output is not None:
        if output.suffix.lower() != ".toml":
            raise InputError(f"{output}: expected a name that ends in .toml")
        check_writable(output)
    if picture is not None:
        check_output(picture)
    warnings: list[str] = []
    if draft.suffix.lower() == ".wif":
        read = load_draft(draft)
        warnings = list(read.warnings)
        fabric = draft_fabric(read.flipped() if flip else read)
    else:
        fabric = load_fabric(str(draft))
    if fabric.weave is None:
        raise InputError(f"{draft}: {fabric.name} has no [weave], expected a draft (.wif) or a fabric with one")
    changes = {"ends_per_cm": ends, "picks_per_cm": picks}
    if changes := {name: value for name, value in changes.items() if value is not None}:
        fabric = fabric.changed(weave=fabric.weave.changed(**changes))
    facts = weave_report(fabric.weave, fabric.yarn)
    facts |= {"fabric": fabric.name, "warnings": warnings}
    if output is not None:
        save_fabric(output, fabric)
        facts["file"] = str(output)
    if picture is not None:
        colors = fabric.weave.thread_colors or tuple(np.array([yarn.albedo]) for yarn in fabric.yarn)
        write_image(picture, weave_picture(fabric.weave, colors))
        facts["picture"] = str(picture)
    if json:
        _print(True, facts, "")
    else:
        print("\n".join([fabric.name, *lines_of(facts)]), flush=True)
        say(", ".join(facts[key] for key in ("file", "picture") if key in facts))


@app.command
def fabrics(
    *,
    output: Annotated[Path | None, _output("Sheet of pictures to write, .png or .exr.")] = None,
    device: Device = None,
    json: Json = False,
) -> None:
    """List the built-in fabrics with weave, sett and holes; -o draws each on the built-in cloth."""
    from .fabric import builtin_fabrics, load_fabric
    from .image import check_output

    if output is not None:
        check_output(output)
    rows = []
    for name in builtin_fabrics():
        fabric = load_fabric(name)
        row = {"name": name, "title": fabric.name, "gap": round(fabric.gap, 4), "tangents": len(fabric.tangents)}
        if (w := fabric.weave) is not None:
            row |= {"weave": w.drafted.title, "ends_per_cm": w.ends_per_cm, "picks_per_cm": w.picks_per_cm}
        rows.append(row)
    result: dict = {"fabrics": rows}
    if output is not None:
        from .sheet import fabric_sheet

        result["file"] = str(output)
        fabric_sheet(output, [row["name"] for row in rows], device)
    if json:
        _print(True, result, "")
        return
    for row in rows:
        sett = f"{row['ends_per_cm']:5.4g} x {row['picks_per_cm']:<5.4g}" if "weave" in row else " " * 13
        print(f"{row['name']:24} {row.get('weave', ''):14} {sett} {row['gap']:6.1%}  {row['title']}", flush=True)
    if output is not None:
        say(str(output))


@app.command
def drape(*, output: Annotated[Path, _output("Mesh to write, .ply, .obj or .glb.")], device: Device = None) -> None:
    """Make the built-in cloth again by simulation: a sheet that falls over a sphere and a table's edge."""
    from .context import create_context
    from .drape import drape as simulate
    from .mesh import SAVE_SUFFIXES, save_mesh

    if output.suffix.lower() not in SAVE_SUFFIXES:
        raise InputError(f"{output}: cannot write {output.suffix or 'a file without suffix'}, expected {SAVE_SUFFIXES}")
    check_writable(output)
    mesh = simulate(create_context(device))
    save_mesh(output, mesh)
    say(f"{output}: {len(mesh.triangles)} triangles")


@app.command
def diff(
    a: Path,
    b: Path,
    /,
    *,
    metric: Annotated[
        Literal["flip", "rmse", "relmse", "psnr"] | None, Parameter(help="One metric; default: all.")
    ] = None,
    scale: Annotated[float, Parameter(help="Brightness of the difference picture.")] = 8.0,
    output: Annotated[Path | None, _output("Difference picture to write, .png or .exr.")] = None,
    json: Json = False,
) -> None:
    """Compare a picture with a reference.

    Parameters
    ----------
    a
        The picture to judge.
    b
        The reference.
    """
    from .image import check_output, read_image, write_image
    from .metrics import METRICS, check_alike, compare, difference

    if not scale > 0:
        raise InputError(f"--scale {scale}: expected a number above 0")
    if output is not None:
        check_output(output)
    test, reference = read_image(a), read_image(b)
    check_alike(test, reference, f"{a}, {b}")
    values = compare(test, reference, [metric] if metric else METRICS)
    if output is not None:
        write_image(output, difference(test, reference, scale))
    if json:
        values = {k: (v if v != float("inf") else None) for k, v in values.items()}
        _print(True, {"a": str(a), "b": str(b), **values, **({"file": str(output)} if output else {})}, "")
    else:
        print("  ".join(f"{name} {value:.6g}" for name, value in values.items()), flush=True)


@app.command
def info(*, device: Device = None, json: Json = False) -> None:
    """Show versions, the GL renderer and its limits, devices, and the cache."""
    from .bench import machine

    facts = machine(device)
    if json:
        _print(True, facts, "")
        return
    for key, value in facts.items():
        if isinstance(value, dict):
            value = ", ".join(f"{k} {v}" for k, v in value.items())
        elif isinstance(value, list):
            value = "; ".join(str(v) for v in value)
        print(f"{key:12} {value}")


bench = App(name="bench", help="Measure on the built-in scenes.", help_format="plaintext")
app.command(bench)


@bench.command(name="cloth")
def bench_cloth(
    *,
    frames: Annotated[int, Parameter(help="Frames per method; the median is reported.")] = 5,
    methods: Annotated[str, Parameter(help="Comma-separated: direct, paper, reference.")] = "direct,paper,reference",
    options: SceneOptions | None = None,
    device: Device = None,
    json: Json = False,
) -> None:
    """Frame times of the environment-lit methods in one run."""
    from . import bench as measure

    scene = _scene(None, options)
    result = measure.cloth(scene, [m.strip() for m in methods.split(",")], frames, device)
    _print(json, result, measure.cloth_table(result))


@bench.command(name="tables")
def bench_tables(
    *fabrics: str,
    grid: Annotated[int, Parameter(help="Directions per axis.")] = 48,
    contribution: Annotated[float, Parameter(help="Share of the sum of singular values to keep.")] = 0.9,
    json: Json = False,
) -> None:
    """Seconds, bytes and ranks of the paper method's tables, made afresh.

    Parameters
    ----------
    fabrics
        Default: all built-in fabrics.
    """
    from .tables import bench as measure

    result, lines = measure(fabrics, grid, contribution)
    _print(json, result, lines)


@bench.command(name="curtain")
def bench_curtain(
    *,
    frames: Annotated[int, Parameter(help="Animated frames; medians are reported.")] = 60,
    triangles: Annotated[int, Parameter(help="About how many triangles, room and curtain together.")] = 12786,
    options: SceneOptions | None = None,
    device: Device = None,
    json: Json = False,
) -> None:
    """Simulation, build and trace of the moving curtain, 320x320 unless --size says otherwise."""
    from .context import create_context
    from .curtain.show import bench_curtain as measure

    options = options or SceneOptions()
    options.size = options.size or "320x320"
    result = measure(create_context(device), _scene("curtain", options), frames, triangles)
    keys = ("triangles", "rays", "nodes", "sim_ms", "build_ms", "trace_ms", "frame_ms", "cpu_ms", "fps")
    keys += ("primary_rays_per_second",)
    _print(json, result, "  ".join(f"{key} {result[key]}" for key in keys if key in result))


def _with_heights(arguments: list[str]) -> list[str]:
    """The arguments with each --ground and its height in one, `auto` where none follows."""
    out: list[str] = []
    waiting = False
    for argument in arguments:
        given = waiting and re.fullmatch(r"auto|off|[-+]?(\.?\d.*|nan|inf)", argument)
        if waiting:
            out.append("--ground=" + (argument if given else "auto"))
        waiting = argument == "--ground"
        if not given and not waiting:
            out.append(argument)
    return [*out, "--ground=auto"] if waiting else out


def main(arguments: list[str] | None = None) -> None:
    """Run one command. Exit 0 done, 1 a fault of ours, 2 wrong input, 3 no usable OpenGL, 130 stopped by Ctrl-C."""
    arguments = _with_heights(sys.argv[1:] if arguments is None else arguments)
    hear_ctrl_c()
    try:
        app(arguments, exit_on_error=False, print_error=False)
    except CycloptsError as error:
        code, line = 2, " ".join(str(error).split())
    except InputError as error:
        code, line = 2, str(error)
    except NoOpenGLError as error:
        code, line = 3, str(error)
    except ShaderError as error:
        code, line = 1, f"a shader does not compile on this driver: {error}"
    except MemoryError:
        code, line = 2, "out of memory; choose a smaller --size, --grid or environment"
    except BrokenPipeError:
        code, line = 0, ""
    except KeyboardInterrupt:
        code, line = 130, ""
    except Exception as error:
        if os.environ.get("GLCLOTH_DEBUG"):
            raise
        what = " ".join(f"{type(error).__name__}: {error}".split())
        code, line = 1, f"a fault of glcloth, please report it: {what}; GLCLOTH_DEBUG=1 shows where"
    else:
        return
    # A module that was being imported may have swallowed Ctrl-C and failed of the consequences.
    if was_stopped() or code == 130:
        code, line = 130, "stopped; nothing was left half-written"
    if line:
        say(f"glcloth: {' '.join(line.split())}" if code == 2 else f"glcloth: {line}")
    sys.exit(code)
