"""What issue 16 asks of a real GPU, in under 4 minutes: times, pictures, races, on the device that is there.

python tests/measure/gpu.py [--device 0] [--seconds 220] [--small] [--json FILE]

Frames stay on the GPU, as in the window. Parts that no longer fit into the seconds are left out and named; one that fails is
told, and the others go on. --small runs everything at sizes that a software rasteriser can do, to see that the script works.
On a machine without OpenGL's loaders see docs/servers.md.
"""

import json
import statistics
import time
import traceback
from pathlib import Path

import common
import curtain_scenes as scenes
import double_runs
import numpy as np

from glcloth.accel.kdtree import KdTree
from glcloth.accel.triangles import Triangles
from glcloth.bench.check import check
from glcloth.curtain.show import CurtainShow
from glcloth.gpu.context import create_context
from glcloth.gpu.tally import counting
from glcloth.picture.renderer import Renderer
from glcloth.picture.ways import known_ways
from glcloth.scene import CurtainParameters, Scene

PATIENCE = 8.0  # seconds of frames of one case at most


def medians(ctx, frame, frames):
    """Median ms of a frame, wall, each waited for; and of many of which only the last is waited for."""
    frame()
    frame()
    ctx.finish()
    times, stop = [], time.perf_counter() + PATIENCE / 2
    while len(times) < frames and (not times or time.perf_counter() < stop):
        begin = time.perf_counter()
        frame()
        ctx.finish()
        times.append(time.perf_counter() - begin)
    count = len(times)
    begin = time.perf_counter()
    for _ in range(count):
        frame()
    ctx.finish()
    return 1e3 * statistics.median(times), 1e3 * (time.perf_counter() - begin) / count


def curtain(ctx, size, frames):
    """Frames of the moving curtain: simulation, tree and picture, which nobody reads."""
    with CurtainShow(ctx, Scene(size=size, gi="off", curtain=CurtainParameters(settle=0.2))) as show:

        def frame():
            show.advance()
            show.build()
            for _ in show.tracer.steps(show.shot()):
                pass

        alone, in_a_row = medians(ctx, frame, frames)
        with counting(ctx) as counted:
            frame()
        return {
            "ms": alone,
            "frames_per_second": 1e3 / in_a_row,
            "reads": counted.reads,
            "dispatches": counted.dispatched,
        }


def tree(ctx, count, frames):
    """The kd-tree of a curtain in a room of so many triangles."""
    soup = scenes.scene(count, 1.0)
    triangles, built = Triangles(ctx, len(soup), 5.0), KdTree(ctx)
    triangles.set(0, soup)
    alone, in_a_row = medians(ctx, lambda: list(built.build_steps(triangles, later=True)), frames)
    fits = built.unread is None or built.fits(built.unread.read())
    found = {"ms": alone, "in_a_row_ms": in_a_row, "triangles": len(soup), "nodes": built.node_count, "fits": fits}
    triangles.release(), built.release()
    return found


def cloth(renderer, method, fabric, size, frames, way, shadows):
    """Frames of cloth at rest, whose pixels are shaded anew, by a way of shading."""
    frame = renderer.prepare(
        "drape", fabric=fabric, method=method, size=size, shadows=shadows, background=False, shade=way
    )
    alone, in_a_row = medians(renderer.ctx, lambda: renderer.draw(frame), frames)
    return {"ms": alone, "frames_per_second": 1e3 / in_a_row, "covered": renderer.covered_pixels()}


def judged(renderer):
    """The ten pictures of `glcloth check`: how far their means are from llvmpipe's, %."""
    verdicts = check(renderer)
    faults = {name: v.fault for name, v in verdicts.items() if v.fault}
    return {"worst_mean_percent": 100 * max(v.mean for v in verdicts.values()), "faults": faults}


def races(ctx, triangles, size):
    """Passes that wrote something else when they ran twice from the same memory, but for those that may; poisoned memory."""
    found = {}
    for name, make in double_runs.works(ctx, triangles, size).items():
        with make() as work:
            work.run()
            clean, runs = work.result(), double_runs.twice(work.run)
            found[name] = sorted(path for path, (_, n) in runs.items() if n and path not in double_runs.PLACED)
            work.poison(0x7F)
            work.run()
            found[name] += [f"{k} on old memory" for k, v in work.result().items() if not np.array_equal(v, clean[k])]
    return found


def parts(ctx, renderer, small):
    """(name, what it does, what is asked) of each part, the most important first."""
    sizes = [(48, 48), (96, 54)] if small else [(320, 320), (1920, 1080)]
    counts = (2000, 5000) if small else (200_000, 800_000)
    large, wide = ((96, 54), (64, 36)) if small else ((3840, 2160), (1920, 1080))
    frames = 3 if small else 60
    yield "check", lambda: judged(renderer), "means within 0.1 %"
    for size, asked in zip(sizes, (250, 90), strict=True):
        yield f"curtain {size[0]}x{size[1]}", lambda size=size: curtain(ctx, size, frames), f"{asked} frames/s"
    for count, asked in zip(counts, (5, 12), strict=True):
        yield f"kd-tree {count}", lambda count=count: tree(ctx, count, frames), f"{asked} ms"
    fabrics = (("linen", 150), ("silk_crepe_de_chine", 150), ("satin_charmeuse_front", 80))
    for way in ("compute", "fragment"):
        for fabric, asked in fabrics:
            work = lambda f=fabric, w=way: cloth(renderer, "direct", f, large, frames, w, "full")  # noqa: E731
            yield f"direct {fabric} {large[0]}x{large[1]} {way}", work, f"{asked} frames/s"
        work = lambda w=way: cloth(renderer, "paper", "linen", wide, frames, w, "off")  # noqa: E731
        yield f"paper linen {wide[0]}x{wide[1]} {way}", work, "60 frames/s"
    yield "races", lambda: races(ctx, 1500, (32, 32)), "none"
    yield "ways of shading", lambda: dict(known_ways(ctx)), "measured by auto"


def main():
    chosen = common.options(__doc__, device="", seconds=220.0, small=False, json="")
    begin, found = time.perf_counter(), {}
    ctx = create_context(chosen.device or None)
    print(ctx.info["GL_RENDERER"], ctx.info["GL_VERSION"], flush=True)
    common.head("part", "found", "asked", "s")
    with Renderer(ctx=ctx) as renderer:
        for name, work, asked in parts(ctx, renderer, chosen.small):
            start = time.perf_counter()
            if start - begin > chosen.seconds:
                found[name] = "left out: no time"
            else:
                try:
                    found[name] = work()
                except Exception as error:  # the others go on
                    traceback.print_exc()
                    found[name] = f"failed: {error}"
            common.row(name, json.dumps(found[name], default=float), asked, time.perf_counter() - start)
    result = {"gl_renderer": ctx.info["GL_RENDERER"], "gl_version": ctx.info["GL_VERSION"], "parts": found}
    if chosen.json:
        Path(chosen.json).write_text(json.dumps(result, default=float, indent=1))


if __name__ == "__main__":
    main()
