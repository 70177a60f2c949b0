"""Checks and figures of docs/curtain.md on the whole scene, too slow for the test suite.

python tests/measure/curtain.py hits      nearest hits of 100,000 rays against brute force, pictures of every structure
python tests/measure/curtain.py cost      SAH cost of eleven frames against an exact tree, steps and tests of rays (minutes)
python tests/measure/curtain.py growth [N]    whole frames at 12786, 50000 and 200000 triangles for every structure
python tests/measure/curtain.py strain    the longest threads of 126 frames, for every fabric
python tests/measure/curtain.py light     the total transmittance of every fabric against its openness
python tests/measure/curtain.py series FILE.png    the curtain over roughness, tau and openness
"""

import sys

import curtain_scenes as scenes
import numpy as np

from glcloth.accel.brute import Brute
from glcloth.accel.kdtree import KdTree, KdTreeParameters
from glcloth.accel.queries import RayQueries, make_structure
from glcloth.accel.triangles import Triangles
from glcloth.bench.curtain import bench_curtain
from glcloth.curtain.show import CurtainShow, camera_of
from glcloth.fabric import load_fabric
from glcloth.gpu.context import create_context
from glcloth.image import write_image
from glcloth.scene import CurtainParameters, Scene
from glcloth.twins import kdtree as exact
from glcloth.twins import sheet

FABRICS = ("sheer_voile", "lace", "linen_curtain", "blackout")
RAYS = 100_000


def rays_of(positions, view, seed):
    """Half of them a camera's, half random ones through the scene and about it."""
    n = round((RAYS // 2) ** 0.5)
    x, y = np.meshgrid((np.arange(n) + 0.5), (np.arange(n) + 0.5))
    d = np.stack([x, y, np.ones_like(x)], -1).reshape(-1, 3) @ view.ray_from_pixel((n, n)).T
    o = np.broadcast_to(view.eye, d.shape)
    low, high = positions.min((0, 1)), positions.max((0, 1))
    o_2, d_2 = scenes.random_rays(RAYS - len(d), low - 0.1, high + 0.1, seed=seed)
    return np.concatenate([o, o_2]).astype(np.float32), np.concatenate([d, d_2]).astype(np.float32)


def compare(ctx, queries, triangles, view, where):
    judge = Brute(ctx)
    judge.build(triangles)
    o, d = rays_of(triangles.positions(), view, 7)
    truth = queries.closest_hit(judge, o, d)
    hit = np.isfinite(truth.t)
    for name in ("kdtree", "lbvh"):
        structure = make_structure(ctx, name)
        structure.build(triangles)
        found = queries.closest_hit(structure, o, d)
        reached = len(np.unique(structure.arrays()["triangles"]))
        print(
            f"{where:34} {name:7} {triangles.count:6} triangles, {reached} in leaves; {len(o)} rays, {hit.mean():.2f} hit; "
            f"{(found.t != truth.t).sum()} other t, {(found.triangle != truth.triangle).sum()} other triangles",
            flush=True,
        )
        structure.release()


def hits(ctx):
    queries = RayQueries(ctx)
    with CurtainShow(ctx, Scene(curtain=CurtainParameters(), size=(320, 320))) as show:
        for frame in (0, 60):
            show.advance(frame - show.frame)
            compare(ctx, queries, show.triangles, camera_of(show.scene), f"frame {frame}")
            pictures = {}
            for name in ("kdtree", "lbvh", "brute"):
                show.scene = show.scene.changed(accelerator=name)
                pictures[name] = show.picture()
            for name in ("kdtree", "lbvh"):
                other = (pictures[name] != pictures["brute"]).any(-1).sum()
                print(f"frame {frame}, 320x320: {other} pixels of {name} differ from brute", flush=True)
        view = camera_of(show.scene)
    for name, soup in scenes.degenerate_scenes().items():
        triangles = Triangles.of(ctx, soup.astype(np.float32))
        compare(ctx, queries, triangles, view, name)
        triangles.release()


def cost(ctx):
    """Frames of several curtains, and what a camera ray and a ray from the lamp to what it meets take."""
    base = CurtainParameters()
    for name, curtain, frames in (
        ("as it is", base, (0, 24, 48, 72, 100)),
        ("fullness 1.5", base.changed(fullness=1.5), (0, 48)),
        ("fullness 2.6", base.changed(fullness=2.6), (0, 48)),
        ("wind 1 m/s", base.changed(wind=1.0), (48, 100)),
    ):
        with CurtainShow(ctx, Scene(curtain=curtain)) as show:
            for frame in frames:
                show.advance(frame - show.frame)
                for pairs in (True, False) if name == "as it is" and frame == 48 else (True,):
                    cost_of(ctx, show, name, pairs)


def cost_of(ctx, show, name, pairs):
    positions = show.triangles.positions()
    tree = KdTree(ctx, KdTreeParameters(pairs=pairs))
    tree.build(show.triangles)
    nodes, C_ts = tree.arrays(), tree.parameters.C_ts
    got = exact.sah_cost(nodes | {"count": nodes["pairs"]}, C_ts)
    count, codes = show.triangles.pairs(pairs)
    codes = np.frombuffer(codes.buffer.read(4 * count), np.uint32).astype(int)
    parts = np.stack([positions[codes >> 1], positions[(codes >> 1) + (codes & 1)]], 1)
    best = exact.sah_cost(exact.build(parts, C_ts), C_ts)
    queries = RayQueries(ctx)
    x, y = np.meshgrid(np.arange(160) * 2 + 1.0, np.arange(160) * 2 + 1.0)
    d = np.stack([x, y, np.ones_like(x)], -1).reshape(-1, 3) @ camera_of(show.scene).ray_from_pixel((320, 320)).T
    hits = queries.closest_hit(tree, np.broadcast_to(camera_of(show.scene).eye, d.shape), d, counted=True)
    lamp, hit = np.array(show.scene.lamp_position), np.isfinite(hits.t)
    way = np.array(camera_of(show.scene).eye) + hits.t[hit, None] * d[hit] - lamp
    lit = queries.closest_hit(tree, np.broadcast_to(lamp, way.shape), way, t_max=0.999, counted=True)
    print(
        f"{name:13} frame {show.frame:3}, pairs {pairs!s:5}: {len(parts)} parts, cost {got:.2f}, exact {best:.2f}: "
        f"{100 * (got / best - 1):+.1f} %; levels {tree.large_levels} + {tree.small_levels}; steps, tests of a camera ray "
        "{:.1f}, {:.1f}; of a ray from the lamp {:.1f}, {:.1f}".format(*hits.work.mean(0), *lit.work.mean(0)),
        flush=True,
    )
    queries.release()
    tree.release()


def growth(ctx, only=""):
    for count, frames in ((12_786, 20), (50_000, 7), (200_000, 3)):
        for name in ("kdtree", "lbvh", "brute"):
            if (name == "brute" and count > 12_786) or only not in ("", str(count)):
                continue
            scene = Scene(curtain=CurtainParameters(), size=(320, 320), accelerator=name)
            r = bench_curtain(ctx, scene, frames if name != "brute" else 1, count)
            cells = [r["triangles"], name, r["sim_ms"], r["build_ms"], r["trace_ms"], r["fps"], r["nodes"], r["depth"]]
            cells += [r.get("sah", ""), r["steps_per_ray"], r["tests_per_ray"], r.get("primary_rays_per_second", "")]
            print("| " + " | ".join(str(c) for c in cells) + " |", r["build_stages_ms"], flush=True)


def strain(ctx):
    for name in FABRICS:
        with CurtainShow(ctx, Scene(curtain=CurtainParameters(), fabric=name)) as show:
            longest = []
            for _ in range(126):
                show.simulation.step(1 / 24)
                longest.append(show.simulation.cloth.strain().max())
            print(f"{name:16} longest thread of 126 frames: {100 * max(longest):.2f} %", flush=True)


def light(ctx):
    """Holes, yarns and reflection at normal incidence and over the hemisphere, by quadrature in float64."""
    mu = (np.arange(64) + 0.5) / 64
    phi = (np.arange(128) + 0.5) / 128 * 2 * np.pi
    for name in FABRICS:
        t = load_fabric(name).transmission
        tau = np.array(t.tau)
        cos, azimuth = (a.ravel() for a in np.meshgrid(mu, phi))
        sin = np.sqrt(1 - cos**2)
        out = np.stack([sin * np.cos(azimuth), sin * np.sin(azimuth), -cos], -1)
        for degrees in (0, 45, 70):
            i = np.array([np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))])
            every = np.broadcast_to(i, out.shape)
            holes = t.k_a * sheet.T_open(i, t.rho)
            f = sheet.f_yarn(every, out, t.roughness, t.eta_1, t.eta_2, t.diffuse, t.roughness_p)
            f = f * sheet.covered(every, out, t.rho)
            yarns = (f[:, None] * sheet.absorption(every, out, tau) * t.k_t * cos[:, None]).mean(0) * 2 * np.pi
            print(
                f"{name:16} {degrees:3} degrees: openness {t.openness:.3f}, holes {holes:.3f}, yarns "
                + "/".join(f"{v:.3f}" for v in yarns)
                + f", together {holes + yarns.max():.3f}",
                flush=True,
            )


def series(ctx, path):
    """Three rows: roughness, tau and openness of sheer_voile, from low to high."""
    rows = []
    base = load_fabric("sheer_voile")
    t = base.transmission
    changes = [
        [{"roughness": r, "roughness_p": r} for r in (0.05, 0.15, 0.3, 0.6)],
        [{"tau": (v, v, v)} for v in (0.0, 0.3, 0.8, 2.0)],
        [{"rho": r, "k_a": t.k_a} for r in (0.9, 0.7, 0.5, 0.3)],
    ]
    with CurtainShow(ctx, Scene(curtain=CurtainParameters(), size=(240, 240), spp=2)) as show:
        show.advance(30)
        for row in changes:
            pictures = []
            for change in row:
                show.fabric = base.changed(transmission=t.model_copy(update=change))
                pictures.append(show.picture())
            rows.append(np.concatenate(pictures, 1))
    write_image(path, np.concatenate(rows))


if __name__ == "__main__":
    commands = {f.__name__: f for f in (hits, cost, growth, strain, light, series)}
    if len(sys.argv) < 2 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    commands[sys.argv[1]](create_context(), *sys.argv[2:])
