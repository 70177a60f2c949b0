"""`glcloth diff`, `glcloth info`, `glcloth bench`: measurements."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Parameter

from ..errors import InputError, NoOpenGLError
from ..progress import say, show
from .common import Device, Json, output_option, tell, whole
from .options import SceneOptions, scene_of

if TYPE_CHECKING:
    import numpy as np


def diff(
    a: Path,
    b: Path,
    /,
    *,
    metric: Annotated[
        Literal["flip", "rmse", "relmse", "psnr"] | None, Parameter(help="One metric; default: all.")
    ] = None,
    mask: Annotated[
        Path | None,
        Parameter(
            help="Picture of the pixels that count: its alpha, the layer mask, or else its brightness above a half."
        ),
    ] = None,
    limit: Annotated[
        float | None, Parameter(help="Exit 4 if the metric is worse than this; needs --metric.", negative="")
    ] = None,
    scale: Annotated[float, Parameter(help="Brightness of the difference picture.")] = 8.0,
    output: Annotated[Path | None, output_option("Difference picture to write, .png or .exr.")] = None,
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
    from ..image import check_output, read_image, write_image
    from ..metrics import BETTER_ABOVE, METRICS, check_alike, compare, difference

    if not scale > 0:
        raise InputError(f"--scale {scale}: expected a number above 0")
    if limit is not None and metric is None:
        raise InputError(f"--limit {limit:g}: of which metric? say --metric flip, rmse, relmse or psnr")
    if output is not None:
        check_output(output)
    test, reference = read_image(a), read_image(b)
    check_alike(test, reference, f"{a}, {b}")
    counts = None if mask is None else _counts(mask)
    if counts is not None:
        check_alike(counts, reference, f"{mask}, {b}")
    values = compare(test, reference, [metric] if metric else METRICS, counts)
    if output is not None:
        write_image(output, difference(test, reference, scale))
    if json:
        values = {k: (v if v != float("inf") else None) for k, v in values.items()}
        tell(True, {"a": str(a), "b": str(b), **values, **({"file": str(output)} if output else {})}, "")
    else:
        show(["  ".join(f"{name} {value:.6g}" for name, value in values.items())])
    if limit is not None and metric is not None:
        value = values[metric]
        if (value < limit) if metric in BETTER_ABOVE else not value <= limit:
            say(f"glcloth: {a}, {b}: {metric} {value:.6g} is beyond the limit, {limit:g}")
            sys.exit(4)


def _counts(mask: Path) -> np.ndarray:
    """Which pixels of two pictures count [H, W], by a picture."""
    from ..image import read_image

    if mask.suffix.lower() == ".exr":
        with suppress(InputError):
            return read_image(mask, "mask")[..., 0] > 0.5
    picture = read_image(mask)
    return (picture[..., 3] if picture.shape[2] == 4 else picture.max(axis=2)) > 0.5


def info(*, device: Device = None, json: Json = False) -> None:
    """Show versions, the GL renderer and its limits, devices, and the cache."""
    from ..bench.machine import machine

    facts = machine(device)
    if json:
        tell(True, facts, "")
        return
    for key, value in facts.items():
        if isinstance(value, dict):
            value = ", ".join(f"{k} {v}" for k, v in value.items())
        elif isinstance(value, list):
            value = "; ".join(str(v) for v in value)
        show([f"{key:12} {value}"])


def check(*, device: Device = None, json: Json = False) -> None:
    """Render ten small pictures and compare them with kept values: can this driver be trusted? Exit 0 yes, 3 no."""
    import time

    from ..bench.check import check as judged
    from ..picture.renderer import Renderer

    begin = time.perf_counter()
    with Renderer(device) as renderer:
        driver = {name: renderer.ctx.info[f"GL_{name.upper()}"] for name in ("renderer", "version")}
        verdicts = judged(renderer)
    faults = [f"{name}: {verdict.fault}" for name, verdict in verdicts.items() if verdict.fault]
    worst = max(verdicts, key=lambda name: verdicts[name].mean)
    result = {
        "trusted": not faults,
        "gl_renderer": driver["renderer"],
        "gl_version": driver["version"],
        "pictures": {
            name: {"mean_percent": round(100 * v.mean, 4), "cell_percent": round(100 * v.cell, 4), "fault": v.fault}
            for name, v in verdicts.items()
        },
        "seconds": round(time.perf_counter() - begin, 2),
    }
    line = f"{driver['renderer']}, OpenGL {driver['version']}"
    if json:
        tell(True, result)
    elif not faults:
        show(
            [f"{line}: can be trusted; {len(verdicts)} pictures, means at most {100 * verdicts[worst].mean:.3f} % off"]
        )
    if faults:
        raise NoOpenGLError(
            f"{line}: not to be trusted, {len(faults)} of {len(verdicts)} pictures fail: {'; '.join(faults)}; "
            "renew the driver, or choose another --device"
        )


CpuThreads = Annotated[
    int | None,
    Parameter(
        converter=whole,
        name="--cpu-threads",
        help="Threads of Mesa's software renderer and of numerical libraries; default: as LP_NUM_THREADS and these choose.",
    ),
]


@contextmanager
def _on_threads(count: int | None) -> Iterator[None]:
    """Within, and before the first context is made, so many threads draw and reckon."""
    if count is None:
        yield
        return
    if not 1 <= count <= 256:
        raise InputError(f"--cpu-threads {count}: expected 1 to 256")
    from threadpoolctl import threadpool_limits

    os.environ["LP_NUM_THREADS"] = str(count)
    with threadpool_limits(count):
        yield


bench = App(name="bench", help="Measure on the built-in scenes.", help_format="plaintext")


@bench.command(name="cloth")
def bench_cloth(
    *,
    frames: Annotated[int, Parameter(converter=whole, help="Frames per method; the median is reported.")] = 5,
    methods: Annotated[str, Parameter(help="Comma-separated: direct, paper, reference.")] = "direct,paper,reference",
    options: SceneOptions | None = None,
    device: Device = None,
    cpu_threads: CpuThreads = None,
    json: Json = False,
) -> None:
    """Frame times of the environment-lit methods in one run."""
    scene = scene_of(None, options)

    from ..bench import cloth as measure

    with _on_threads(cpu_threads):
        result = measure.cloth(scene, [m.strip() for m in methods.split(",")], frames, device)
    result["cpu_threads"] = cpu_threads
    tell(json, result, *measure.cloth_table(result).splitlines())


@bench.command(name="tables")
def bench_tables(
    *fabrics: str,
    grid: Annotated[int, Parameter(converter=whole, help="Directions per axis.")] = 48,
    contribution: Annotated[float, Parameter(help="Share of the sum of singular values to keep.")] = 0.9,
    cpu_threads: CpuThreads = None,
    json: Json = False,
) -> None:
    """Seconds, bytes and ranks of the paper method's tables, made afresh.

    Parameters
    ----------
    fabrics
        Default: all built-in fabrics.
    """
    from ..methods.paper.tables import bench as measure

    with _on_threads(cpu_threads):
        result, lines = measure(fabrics, grid, contribution)
    tell(json, result, *lines.splitlines())


@bench.command(name="curtain")
def bench_curtain(
    *,
    frames: Annotated[int, Parameter(converter=whole, help="Animated frames; medians are reported.")] = 60,
    triangles: Annotated[
        int, Parameter(converter=whole, help="About how many triangles, room and curtain together.")
    ] = 12786,
    options: SceneOptions | None = None,
    device: Device = None,
    cpu_threads: CpuThreads = None,
    json: Json = False,
) -> None:
    """Simulation, build and trace of the moving curtain, 320x320 and even light unless --size and --gi say otherwise."""
    size = "320x320" if options is None or options.size is None else options.size
    gi = "off" if options is None or options.gi is None else options.gi
    scene = scene_of("curtain", options, size=size, gi=gi)

    from ..bench.curtain import bench_curtain as measure
    from ..gpu.context import create_context

    with _on_threads(cpu_threads):
        result = measure(create_context(device), scene, frames, triangles) | {"cpu_threads": cpu_threads}
    keys = ("triangles", "rays", "nodes", "sim_ms", "build_ms", "trace_ms", "frame_ms", "cpu_ms", "fps")
    keys += ("primary_rays_per_second",)
    tell(json, result, "  ".join(f"{key} {result[key]}" for key in keys if key in result))
