"""Radiosity of the curtain's room against photons, an independent method in NumPy: both without the sky.

`python tests/measure/radiosity.py [FABRIC] [FRAME] [PHOTONS]` prints indirect irradiance of whole walls by both, and the ratio.
Photons go straight, evenly or mirrored at cloth, as glsl/woven/sheet.glsl splits light; its reflection is Lambertian.
"""

import sys

import moderngl
import numpy as np

from glcloth.accel.queries import RayQueries
from glcloth.curtain.charts import OPEN
from glcloth.curtain.room import REVEAL, WINDOW_HIGH, WINDOW_LOW
from glcloth.curtain.show import CurtainShow
from glcloth.light.environment import Environment
from glcloth.scene import CurtainParameters, Scene
from glcloth.tracing.energy import mean_albedo, reflection_limit
from glcloth.twins.random import cosine_direction
from glcloth.twins.sheet import R_limited, R_sheet, T_lambert, T_straight

DARK = Environment("dark", np.full((4, 8, 3), 1e-9, np.float32))
MOST_EVENTS = 60


def emitted(show, count, rng):
    """Photons of the lamp through the window: origins, directions, W."""
    lamp, intensity = np.array(show.scene.lamp_position), np.array(show.scene.lamp_intensity)
    low, high = np.array(WINDOW_LOW), np.array(WINDOW_HIGH)
    at = np.concatenate([rng.uniform(low, high, (count, 2)), np.full((count, 1), -REVEAL)], 1)
    d = at - lamp
    r = np.linalg.norm(d, axis=1, keepdims=True)
    d /= r
    return at - 1e-3 * d, d, intensity * d[:, 2:] / r**2 * np.prod(high - low) / count


def at_cloth(show, d, n):
    """Shares of straight, evenly through, mirrored and reflected light, [4, N, 3], at cloth with normals n toward it."""
    t, tau = show.fabric.transmission, np.array(show.fabric.transmission.tau)
    x = np.array([1.0, 0, 0]) - n * n[:, :1]
    x /= np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-9)
    omega = np.stack([-(d * x).sum(1), -(d * np.cross(n, x)).sum(1), -(d * n).sum(1)], -1)
    straight = T_straight(omega, t.k_a, t.k_t, tau, t.rho, t.diffuse)
    even = T_lambert(omega, t.k_t, tau, t.rho, t.diffuse)
    albedo = mean_albedo(show.fabric) * reflection_limit(show.fabric)
    R = R_limited(R_sheet(omega, t.k_t, t.rho, t.eta_1, t.eta_2), straight + even, albedo)
    return np.stack([straight, even, np.repeat(R[:, None], 3, 1), np.broadcast_to(albedo, straight.shape)])


def photons(ctx, show, count, rng):
    """Where photons meet the room: triangles [K], W [K, 3], whether straight from the lamp [K], positions [K, 3]."""
    queries, structure = RayQueries(ctx), show.tracer.structure("kdtree")
    corners, room = show.triangles.positions().astype(float), show.room
    N = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    N /= np.maximum(np.linalg.norm(N, axis=1, keepdims=True), 1e-20)
    o, d, flux = emitted(show, count, rng)
    t_min, first, found = np.zeros(count), np.ones(count, bool), []
    for _ in range(MOST_EVENTS):
        hits = queries.closest_hit(structure, o, d, t_min)
        met = hits.triangle >= 0
        o, d, flux, first, at = o[met], d[met], flux[met], first[met], hits.triangle[met]
        if not len(o):
            break
        t = hits.t[met].astype(float)
        p = o + t[:, None] * d
        n = N[at] * np.where((N[at] * d).sum(1, keepdims=True) > 0, -1.0, 1.0)
        solid = at < len(room.positions)
        found.append((at[solid], flux[solid], first[solid], p[solid]))
        shares = np.zeros((4, len(o), 3))
        shares[3, solid] = room.reflectances[room.material[at[solid]]]
        shares[:, ~solid] = at_cloth(show, d[~solid], n[~solid])
        # What is likelier the more goes that way; some end, by as much as is lost.
        chance = shares.max(2)
        pick = rng.random(len(o))
        edges = chance.cumsum(0)
        kind = (pick > edges).sum(0)
        going = np.flatnonzero(kind < 4)
        kind = kind[going]
        o, d, p, n, t, first, at = (v[going] for v in (o, d, p, n, t, first, at))
        flux = flux[going] * shares[kind, going] / chance[kind, going, None]
        x = np.cross(np.where(np.abs(n[:, :1]) > 0.7, [0.0, 1, 0], [1.0, 0, 0]), n)
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        c = cosine_direction(rng.random((len(n), 2)))
        side = np.where(kind == 1, -1.0, 1.0)[:, None]
        even = c[:, :1] * x + c[:, 1:2] * np.cross(n, x) + side * c[:, 2:] * n
        mirrored = d - 2 * (d * n).sum(1, keepdims=True) * n
        straight = kind == 0
        d = np.where(straight[:, None], d, np.where((kind == 2)[:, None], mirrored, even))
        o = np.where(straight[:, None], o, p + 2e-4 * side * n)
        t_min, first = np.where(straight, t * (1 + 1e-5) + 1e-5, 0.0), first & straight
    queries.release()
    return [np.concatenate(values) for values in zip(*found, strict=True)]


def main(fabric="sheer_voile", frame="0", count="150000"):
    ctx = moderngl.create_context(standalone=True, backend="egl", require=430)
    scene = Scene(size=(16, 16), fabric=fabric, gi="radiosity", curtain=CurtainParameters())
    with CurtainShow(ctx, scene, environment=DARK) as show:
        show.advance(int(frame))
        show.picture()
        factors = show.radiosity.factors
        charts = factors.charts
        E = show.radiosity.irradiance()[: len(charts.positions)]
        area = charts.area * (factors.openness() >= OPEN)
        at, flux, first, _ = photons(ctx, show, int(count), np.random.default_rng(1))
    chart = charts.chart_of[at]
    middle = charts.origin + (charts.u + charts.v) / 2
    print(
        f"{fabric}, frame {frame}: straight from the lamp {flux[first].sum(0).round(2)} W, "
        f"indirect {flux[~first].sum(0).round(2)} W"
    )
    sizes = np.linalg.norm(np.cross(charts.u, charts.v), axis=1)
    for k in np.argsort(-sizes)[:9]:
        own = charts.element_chart == k
        ours = (E[own] * area[own, None]).sum(0) / sizes[k]
        theirs = np.stack([np.bincount(chart, flux[:, c] * ~first, len(sizes)) for c in range(3)], 1)[k] / sizes[k]
        print(f"  {np.round(middle[k], 2)}: {ours.round(4)} photons {theirs.round(4)} ratio {(ours / theirs).round(3)}")


if __name__ == "__main__":
    main(*sys.argv[1:])
