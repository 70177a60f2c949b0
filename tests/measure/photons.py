"""Photon mapping of the curtain's room: against other methods, and its error and noise by number and neighbours.

`python tests/measure/photons.py against [FABRIC] [FRAME]` : indirect light of the lamp on whole walls, W/m^2: photons of the GPU,
those of NumPy (tests/measure/radiosity.py), radiosity.
`python tests/measure/photons.py table [FABRIC] [FRAME]` : error and noise of irradiance on walls, floor and ceiling against many
photons, and CPU time, by photons, neighbours and samples.
`python tests/measure/photons.py pictures [SIZE]` : CPU time of a picture's stages.
"""

import sys
import time

import moderngl
import numpy as np
import radiosity

from glcloth.curtain.photons import Photons
from glcloth.curtain.show import CurtainShow
from glcloth.scene import CurtainParameters, Scene


def shown(ctx, fabric, frame, **more):
    """The show of a fabric at a frame."""
    environment = more.pop("environment", None)
    scene = Scene(size=(16, 16), fabric=fabric, gi="photons", curtain=CurtainParameters(), **more)
    show = CurtainShow(ctx, scene, environment=environment)
    show.advance(frame)
    show.build()
    return show


def found(show, photons, sample=0):
    """Find the photons of a sample; returns CPU seconds."""
    shot = show.lit(show.shot())
    inputs, structure = show.tracer.inputs(shot), show.tracer.structure("kdtree")
    begin = time.process_time()
    for _ in show.photons.steps(shot, inputs, structure, photons, sample):
        pass
    show.ctx.finish()
    return time.process_time() - begin


def against(ctx, fabric="sheer_voile", frame="0", count="150000"):
    with shown(ctx, fabric, int(frame), environment=radiosity.DARK) as show:
        found(show, Photons(int(count), 400))
        _, W, place = show.photons.photons()
        show.change(show.scene.changed(gi="radiosity"))
        show.picture()
        factors = show.radiosity.factors
        charts = factors.charts
        E = show.radiosity.irradiance()[: len(charts.positions)]
        area = charts.area * (factors.openness() >= radiosity.OPEN)
        at, flux, first, _ = radiosity.photons(ctx, show, int(count), np.random.default_rng(1))
    sizes = np.linalg.norm(np.cross(charts.u, charts.v), axis=1)
    solid = place < 2 * len(charts.chart_of)
    place, W = place[solid], W[solid]
    print(f"{fabric}, frame {frame}: middle of a wall; red W/m^2 by photons, NumPy's, radiosity; ratios to photons")
    for k in np.argsort(-sizes)[:9]:
        own = charts.element_chart == k
        ours = W[(charts.chart_of[place // 2] == k) & (place % 2 == 0), 0].sum() / sizes[k]
        numpys = flux[(charts.chart_of[at] == k) & ~first, 0].sum() / sizes[k]
        theirs = (E[own, 0] * area[own]).sum() / sizes[k]
        middle = charts.origin[k] + (charts.u[k] + charts.v[k]) / 2
        print(f"  {middle.round(2)}: {ours:.4f} {numpys:.4f} {theirs:.4f}  {numpys / ours:.3f} {theirs / ours:.3f}")


if __name__ == "__main__":
    context = moderngl.create_context(standalone=True, backend="egl", require=430)
    {"against": against}[sys.argv[1]](context, *sys.argv[2:])
