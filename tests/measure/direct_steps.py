"""What each part of method `direct` brings in time and in accuracy; the second table of docs/direct.md.

python tests/measure/direct_steps.py [SHARED]  (some minutes). Times are of this process's CPU, interleaved, so that other
work on the machine weighs on all variants alike; accuracy is that of the golden samples of the fabric, if SHARED has them.
"""

import sys
import time
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import moderngl
import numpy as np
from golden import golden_fabrics, luminance_errors

from glcloth.fabric import Fabric
from glcloth.gpu.memo import Last
from glcloth.light.lights import SphericalGaussians
from glcloth.methods.direct import broad_nodes, gaussian_nodes, schedule
from glcloth.methods.direct import method as direct
from glcloth.picture.renderer import Renderer

SHARED = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parents[3] / "shared")
FRAMES = 9
SQUARE = ((1,), (2,) * 2, (3,) * 3, (4,) * 4, (5,) * 4, (6,) * 4, (6,) * 5, (7,) * 6, (8,) * 7)


@contextmanager
def patched(module, **values):
    """A module with other values for a while, and nothing kept from before."""
    before = {name: getattr(module, name) for name in values}
    for name, value in values.items():
        setattr(module, name, value)
    clear()
    try:
        yield
    finally:
        for name, value in before.items():
            setattr(module, name, value)
        clear()


def clear():
    gaussian_nodes._cell.cache_clear()
    gaussian_nodes.sky_nodes.cache_clear()
    broad_nodes.fixed_rule.cache_clear()


def none_pooled(fabric):
    return tuple(replace(lobes, share_s=0.0, share_v=0.0) for lobes in POOLED(fabric))


POOLED = schedule.pooled_lobes
VARIANTS = {
    "as it is": None,
    "square rules": (gaussian_nodes, {"LADDER": SQUARE}),
    "every Gaussian its own nodes": (schedule, {"BROAD_SHARPNESS": (1e-9, 2e-9)}),
    "Gaussians below the horizon not left out": (direct, {"NO_LIGHT": 1e-300}),
    "no pooled lobes": (schedule, {"pooled_lobes": none_pooled}),
    "nodes do not widen the lobes": (
        schedule,
        {"kept_share": lambda level, k, gamma: np.ones(np.broadcast(k, gamma).shape)},
    ),
    "equal tangents not merged": "split",
    "uncovered pixels shaded": "all",
    "adaptive": "adaptive",
}


def split(fabric):
    """The same fabric, its repeated tangents apart by a hair."""
    data = fabric.model_dump()
    for yarn in data["yarn"]:
        tilts = yarn["tangents_deg"]
        yarn["tangents_deg"] = tuple(t + 1e-6 * i for i, t in enumerate(tilts))
    return Fabric.model_validate(data)


def main():
    data = np.load(SHARED / "golden" / "microcylinder.npz")
    fabrics = golden_fabrics(data, "sadeghi")
    lights = SphericalGaussians(data["env_axis"], data["env_kappa"], data["env_rgb"])
    with Renderer() as renderer:
        method = renderer.method("direct")
        for number, fabric in enumerate(fabrics):
            times, rows = {name: [] for name in VARIANTS}, {}
            for turn in range(FRAMES + 1):
                for name, change in VARIANTS.items():
                    forget(method)
                    shown = split(fabric) if change == "split" else fabric
                    frame = renderer.prepare(
                        fabric=shown,
                        mesh="drape",
                        lights=lights,
                        size=(320, 240),
                        background=False,
                        adaptive=change == "adaptive",
                    )
                    context = patched(change[0], **change[1]) if isinstance(change, tuple) else patched(schedule)
                    with context:
                        direct._warm_up.cache_clear()
                        method.prepare(frame.fabric, frame.lights, frame.settings)
                        if turn == 0:
                            renderer.draw(frame)  # compiles
                            rows[name] = method.evaluations_per_pixel(), errors(renderer, data, fabrics, number, name)
                            forget(method)
                            method.prepare(frame.fabric, frame.lights, frame.settings)
                        renderer.draw(frame)
                        renderer.ctx.finish()
                        begin = time.process_time()
                        if change == "all":
                            shade_all(renderer, frame)
                        else:
                            renderer.draw(frame)
                        renderer.ctx.finish()
                        if turn:
                            times[name].append(time.process_time() - begin)
            base = np.median(times["as it is"])
            print(f"\n{data['fabric_names'][number]}: {len(fabric.tangents)} tangents")
            print("\n| variant | time | evaluations | error, % |\n|---|---|---|---|")
            for name, values in times.items():
                print(f"| {name} | {np.median(values) / base:.2f} | {rows[name][0]} | {rows[name][1]} |", flush=True)


def forget(method):
    """Let the next `prepare` make everything anew."""
    for kept in vars(method).values():
        if isinstance(kept, Last):
            kept.forget()


def shade_all(renderer, frame):
    """The frame without early depth."""
    buffer, method = renderer.gbuffer, renderer.method("direct")
    program = renderer.program("passes/picture/shade.frag", method)
    renderer.shared.bind(program)
    method.bind(program)
    buffer.bind(program)
    buffer.target.use()
    renderer.ctx.enable_only(moderngl.NOTHING)
    array = renderer.ctx.vertex_array(program, [])
    array.render(moderngl.TRIANGLES, vertices=3)
    array.release()


def errors(renderer, data, fabrics, number, name):
    """Median / 95 % / largest, of the golden samples of one fabric."""
    if name in ("uncovered pixels shaded", "adaptive"):
        return ""
    fabric = split(fabrics[number]) if name == "equal tangents not merged" else fabrics[number]
    found = []
    for s in np.flatnonzero(data["fabric"] == number):
        light = SphericalGaussians(data["xi"][s], data["kappa"][s], data["L_k"][s])
        got = renderer.radiance(fabric, data["wo"][s][None], light)
        found.append(luminance_errors(got, data["L_ref_sadeghi"][s][None])[0])
    found = 100 * np.array(found)
    return f"{np.median(found):.2f} / {np.percentile(found, 95):.2f} / {found.max():.2f}"


if __name__ == "__main__":
    main()
