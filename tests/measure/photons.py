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

from glcloth.accel.triangles import pack_units
from glcloth.curtain.photons import Photons
from glcloth.curtain.show import CurtainShow
from glcloth.gpu.buffers import TextureBuffer
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


def places(show, count, rng):
    """Points on the five large walls [N, 3] with normals and places of the room, some near rims: as the tree has points."""
    corners = show.room.positions[:10].astype(float)
    t = rng.integers(0, 10, count)
    u, v = rng.random((2, count, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = (corners[t, k] for k in range(3))
    n = np.cross(b - a, c - a)
    data = np.zeros((count, 2, 4), np.uint32)
    data[:, 0, :3] = (a + u * (b - a) + v * (c - a)).astype(np.float32).view(np.uint32)
    data[:, 0, 3], data[:, 1, 3] = pack_units(n), 2 * t
    return data


def table(ctx, fabric="sheer_voile", frame="30", points="600"):
    """Against three million photons in small discs: noise in %, the root of the mean square of one seed's deviation from the mean
    of three; bias in %, how much brighter the mean is within 0.2 m of a wall's rim, and elsewhere."""
    rng = np.random.default_rng(2)
    with shown(ctx, fabric, int(frame)) as show:
        shot = show.lit(show.shot())
        inputs, structure, m = show.tracer.inputs(shot), show.tracer.structure("kdtree"), show.photons
        count = int(points)
        m.prepare()
        where = places(show, count, rng)
        queries = TextureBuffer(ctx, where, "rgba32ui")

        def light(photons, neighbours, seed):
            """Irradiance by some neighbours each, radii; CPU seconds of photons and tree."""
            begin = time.process_time()
            for _ in m.arrive(shot, inputs, structure, photons, seed):
                pass
            ctx.finish()
            seconds = time.process_time() - begin
            out = []
            for k in neighbours:
                m.gather(queries, count, k)
                out.append(m.gathered(count)[1:])
            return out, seconds

        truth = np.mean([light(500_000, (400,), 100 + s)[0][0][0] for s in range(6)], 0)[:, 1]
        x = np.ascontiguousarray(where[:, 0, :3]).view(np.float32).astype(float)
        to_rim = np.sort(np.minimum(x - [-2, 0, 0], [2, 2.7, 4] - x), 1)[:, 1] < 0.2
        print(
            f"{fabric}, frame {frame}, {count} points on floor, ceiling and walls, green; mean {truth.mean():.4f} W/m^2"
        )
        print("| photons | arrive | CPU s | neighbours | radius, m | noise, % | bias, % | at rims, % |")
        neighbours = (50, 200, 400, 1000)
        for photons in (20_000, 100_000, 200_000):
            runs = [light(photons, neighbours, s) for s in range(3)]
            for j, k in enumerate(neighbours):
                E = np.stack([run[0][j][0][:, 1] for run in runs])
                noise = np.sqrt(((E - E.mean(0)) ** 2).sum(0) / 2).mean() / truth.mean()
                bias = [(E.mean(0) - truth)[w].mean() / truth[w].mean() for w in (~to_rim, to_rim)]
                figures = f"{100 * noise:.1f} | {100 * bias[0]:.1f} | {100 * bias[1]:.1f} |"
                r = runs[0][0][j][1].mean()
                print(f"| {photons} | {m.arrived} | {runs[1][1]:.2f} | {k} | {r:.2f} | {figures}", flush=True)
        print("| samples of 50,000 photons, first 100 neighbours | neighbours then | error, % |")
        begins, total = Photons(50_000, 100), np.zeros(count)
        for sample in range(16):
            ((E, _),), _ = light(begins.count, (begins.neighbours_of(sample),), sample)
            total += E[:, 1]
            if sample + 1 in (1, 4, 16):
                error = np.sqrt(((total / (sample + 1) - truth) ** 2).mean()) / truth.mean()
                print(f"| {sample + 1} | {begins.neighbours_of(sample)} | {100 * error:.1f} |", flush=True)
        queries.release()


def pictures(ctx, size="320"):
    """CPU seconds of a picture's parts."""
    pixels = int(size)
    with shown(ctx, "sheer_voile", 30) as show:
        for gi in ("photons", "radiosity", "off"):
            show.change(show.scene.changed(gi=gi, size=(pixels, pixels)))
            show.picture()
            begin = time.process_time()
            show.picture()
            print(f"{gi}: {time.process_time() - begin:.2f} s of CPU for {pixels}x{pixels}")
        show.change(show.scene.changed(gi="photons"))
        shot = show.lit(show.shot())
        inputs, structure, m = show.tracer.inputs(shot), show.tracer.structure("kdtree"), show.photons
        begin = time.process_time()
        for _ in m._trace(inputs, structure, m.emission(shot), 400_000, 0, False):
            pass
        ctx.finish()
        traced = time.process_time() - begin
        print(f"400,000 photons: traced {traced:.2f} s; {m.arrived} arrive, tree", end=" ")
        begin = time.process_time()
        for _ in m.tree.sort(m._photons, m.arrived, m._scale):
            pass
        ctx.finish()
        print(f"{time.process_time() - begin:.2f} s; all with irradiance {found(show, Photons()):.2f} s")


if __name__ == "__main__":
    context = moderngl.create_context(standalone=True, backend="egl", require=430)
    {"against": against, "table": table, "pictures": pictures}[sys.argv[1]](context, *sys.argv[2:])
