"""What each part of method `direct` brings in time and in accuracy; a table of docs/direct.md.

python tests/measure/direct_steps.py [--times 9] [--size 320x240]  (some minutes)

Times are of this process's CPU, interleaved, so that other work on the machine weighs on all variants alike. Errors are
of the golden samples of the fabric, median / 95 % / largest in %.
"""

from contextlib import contextmanager
from dataclasses import replace

import common
import numpy as np
from golden import golden_fabrics, luminance_errors

import glcloth
from glcloth.fabric import Fabric
from glcloth.light.lights import SphericalGaussians
from glcloth.methods.direct import broad_nodes, gaussian_nodes, schedule
from glcloth.methods.direct import method as direct

SQUARE = ((1,), (2,) * 2, (3,) * 3, (4,) * 4, (5,) * 4, (6,) * 4, (6,) * 5, (7,) * 6, (8,) * 7)


def none_pooled(fabric, pooled=schedule.pooled_lobes):
    return tuple(replace(lobes, share_s=0.0, share_v=0.0) for lobes in pooled(fabric))


def all_kept(level, k, gamma):
    return np.ones(np.broadcast(k, gamma).shape)


VARIANTS = {
    "as it is": (schedule, {}),
    "square rules": (gaussian_nodes, {"LADDER": SQUARE}),
    "every Gaussian its own nodes": (schedule, {"BROAD_SHARPNESS": (1e-9, 2e-9)}),
    "Gaussians below the horizon not left out": (direct, {"NO_LIGHT": 1e-300}),
    "no pooled lobes": (schedule, {"pooled_lobes": none_pooled}),
    "nodes do not widen the lobes": (schedule, {"kept_share": all_kept}),
    "equal tangents not merged": (schedule, {}),
    "adaptive": (schedule, {}),
}


def clear():
    gaussian_nodes._cell.cache_clear()
    gaussian_nodes.sky_nodes.cache_clear()
    broad_nodes.fixed_rule.cache_clear()
    direct._warm_up.cache_clear()


@contextmanager
def patched(module, values):
    """A module with other values for a while, and nothing kept from before."""
    before = {name: getattr(module, name) for name in values}
    vars(module).update(values)
    clear()
    try:
        yield
    finally:
        vars(module).update(before)
        clear()


def split(fabric):
    """The same fabric, its repeated tangents apart by a hair."""
    data = fabric.model_dump()
    for yarn in data["yarn"]:
        yarn["tangents_deg"] = tuple(t + 1e-6 * i for i, t in enumerate(yarn["tangents_deg"]))
    return Fabric.model_validate(data)


def golden_errors(renderer, data, fabric, number):
    """Of the golden samples of fabric `number`."""
    found = []
    for s in np.flatnonzero(data["fabric"] == number):
        light = SphericalGaussians(data["xi"][s], data["kappa"][s], data["L_k"][s])
        got = renderer.radiance(fabric, data["wo"][s][None], light)
        found.append(luminance_errors(got, data["L_ref_sadeghi"][s][None])[0])
    return common.spread(found)


def measure(renderer, data, fabric, number, options):
    """{variant: CPU times}, {variant: (evaluations per pixel, errors)}"""
    lights = SphericalGaussians(data["env_axis"], data["env_kappa"], data["env_rgb"])
    methods = {name: direct.Direct(renderer.ctx) for name in VARIANTS}
    times, facts = {name: [] for name in VARIANTS}, {}
    for turn in range(options.times + 1):
        for name, change in VARIANTS.items():
            shown = split(fabric) if name == "equal tangents not merged" else fabric
            scene = dict(fabric=shown, mesh="drape", lights=lights, size=options.size, background=False)
            common.set_method(renderer, "direct", methods[name])
            with patched(*change):
                if turn == 0:
                    error = "" if name == "adaptive" else golden_errors(renderer, data, shown, number)
                frame = renderer.prepare(adaptive=name == "adaptive", **scene)
                renderer.draw(frame)  # compiles, and makes what is kept
                if turn == 0:
                    facts[name] = methods[name].evaluations_per_pixel(), error
                else:
                    times[name].append(common.spent(renderer, lambda frame=frame: renderer.draw(frame))[1])
    return times, facts


options = common.options(__doc__, times=9, size="320x240")
data = common.golden()
with glcloth.Renderer() as renderer:
    for number, fabric in enumerate(golden_fabrics(data, "sadeghi")):
        times, facts = measure(renderer, data, fabric, number, options)
        print(f"\n{data['fabric_names'][number]}: {len(fabric.tangents)} tangents")
        common.head("variant", "time", "evaluations", "error, %")
        for name, values in times.items():
            common.row(name, float(np.median(values) / np.median(times["as it is"])), *facts[name])
