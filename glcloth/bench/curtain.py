"""Measurements of the curtain in the wind: simulation, structure, rays."""

from __future__ import annotations

import statistics
import time
from itertools import pairwise

import moderngl
import numpy as np

from ..accel.kdtree import CONSTANTS
from ..accel.queries import RayQueries
from ..curtain.show import CurtainShow, camera_of
from ..errors import InputError
from ..scene import CurtainParameters, Scene
from ..tracing.rays import BLOCK


def bench_curtain(
    ctx: moderngl.Context, scene: Scene | None = None, frames: int = 60, triangles: int | None = None
) -> dict:
    """Measure animated frames: simulation, build by stage, trace by level; medians in ms, wall and CPU time of the process.

    scene : default: the built-in one at 320 x 320, depth 4, in even light
    triangles : about how many, default 12,786

    Returns sim_ms, build_ms, trace_ms, frame_ms, fps, cpu_ms (of all threads), triangles, rays (and per level), nodes, depth,
    sah, steps and tests per ray, camera rays per second, stages, levels. Raises InputError for fewer than 1 frame.
    """
    if frames < 1:
        raise InputError(f"--frames {frames}: expected at least 1")
    scene = scene or Scene(size=(320, 320), gi="off", curtain=CurtainParameters())
    with CurtainShow(ctx, scene, triangles) as show:
        show.picture()  # compiles
        show.advance()
        show.picture()
        measured = [_animated_frame(show) for _ in range(frames)]
        rows, stages = [row for row, _ in measured], [stage for _, stage in measured]
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
            "levels": _levels(show),
            "renderer": ctx.info["GL_RENDERER"],
        }
        return result | _quality(show)


def _animated_frame(show: CurtainShow) -> tuple[dict, dict]:
    """Simulate, build and trace the next frame; returns the times of these, and of the stages of the build, in ms."""
    clock, cpu = [time.perf_counter()], time.process_time()
    for work in (show.advance, show.build):
        work()
        show.ctx.finish()
        clock.append(time.perf_counter())
    show.picture()
    clock.append(time.perf_counter())
    sim, build, trace = (1000 * float(b - a) for a, b in pairwise(clock))
    s = show.tracer.statistics
    row = {
        "sim_ms": sim,
        "build_ms": build,
        "trace_ms": trace,
        "frame_ms": sim + build + trace,
        "cpu_ms": 1000 * (time.process_time() - cpu),
        "rays": sum(s.rays) + sum(s.shadow_rays),
    }
    return row, dict(s.build_ms)


def _levels(show: CurtainShow) -> list[dict]:
    """Rays and times of the last picture, by the generation of its rays."""
    s = show.tracer.statistics
    counts = {"rays": s.rays, "heads": s.heads, "shadow_rays": s.shadow_rays}
    times = {"trace_ms": s.trace_ms, "shade_ms": s.shade_ms, "shadow_ms": s.shadow_ms}
    return [
        {name: values[i] for name, values in counts.items()}
        | {name: round(values[i], 3) for name, values in times.items()}
        for i in range(len(s.rays))
    ]


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
    kdtree = show.scene.accelerator.startswith("kdtree")
    C_ts, held = (CONSTANTS["C_TS"], tree["pairs"]) if kdtree else (1.0, tree["count"])
    view, size = camera_of(show.scene), show.scene.size
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
