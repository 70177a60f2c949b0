"""Checks and figures of docs/curtain.md on the whole scene, too slow for the test suite.

python tests/measure/curtain.py hits      nearest hits of 100,000 rays against brute force, pictures of every structure
python tests/measure/curtain.py cost      SAH cost of eleven frames against an exact tree, steps and tests of rays (minutes)
python tests/measure/curtain.py growth [N]    whole frames at 12786, 50000 and 200000 triangles for every structure
python tests/measure/curtain.py strain    the longest threads of 126 frames, for every fabric
python tests/measure/curtain.py wind [M/S,HEADING[,FABRIC[,BEHIND]] ...]    edges through cloth, threads, CPU time in strong wind
python tests/measure/curtain.py light     the total transmittance of every fabric against its openness
python tests/measure/curtain.py albedo    the albedo of four fabrics by coarser quadratures against 432,000 directions
python tests/measure/curtain.py series FILE.png    the curtain over roughness, tau and openness
"""

import sys
import time

import common
import curtain_scenes as scenes
import numpy as np

from glcloth.accel.brute import Brute
from glcloth.accel.kdtree import CONSTANTS, KdTree
from glcloth.accel.queries import RayQueries
from glcloth.accel.structure import make_structure
from glcloth.accel.triangles import Triangles
from glcloth.bench.curtain import bench_curtain
from glcloth.curtain.curtains import Curtains
from glcloth.curtain.show import CurtainShow, camera_of
from glcloth.fabric import load_fabric
from glcloth.geometry.shapes import grid_triangles
from glcloth.gpu.context import create_context
from glcloth.image import write_image
from glcloth.scene import CurtainParameters, Scene
from glcloth.twins import kdtree as exact
from glcloth.twins import sheet
from glcloth.twins.cloth import f_cloth

FABRICS = ("sheer_voile", "lace", "linen_curtain", "blackout")
HEADINGS = ("tape", "rings", "pencil", "eyelet", "rod")
RAYS = 100_000
RESULTS = ("triangles", "sim_ms", "build_ms", "trace_ms", "fps", "nodes", "depth", "sah", "steps_per_ray")
RESULTS += ("tests_per_ray", "primary_rays_per_second", "build_stages_ms")


def camera_rays(view, n):
    """n x n rays (o, d) of a camera."""
    x, y = np.meshgrid(np.arange(n) + 0.5, np.arange(n) + 0.5)
    d = np.stack([x, y, np.ones_like(x)], -1).reshape(-1, 3) @ view.ray_from_pixel((n, n)).T
    return np.broadcast_to(view.eye, d.shape), d


def rays_of(positions, view, seed):
    """Half of them a camera's, half random ones through the scene and about it."""
    o, d = camera_rays(view, round((RAYS // 2) ** 0.5))
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
        other = (found.t != truth.t).sum(), (found.triangle != truth.triangle).sum()
        common.row(where, name, triangles.count, reached, len(o), float(hit.mean()), *other)
        structure.release()


def hits(ctx):
    queries = RayQueries(ctx)
    common.head("scene", "structure", "triangles", "in leaves", "rays", "share hit", "other t", "other triangle")
    with CurtainShow(ctx, Scene(curtain=CurtainParameters(), gi="off", size=(320, 320))) as show:
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
    head = ("curtain", "frame", "pairs of triangles", "SAH cost", "exact", "more", "levels")
    common.head(*head, "steps, tests of a camera ray", "of a ray from the lamp")
    for name, curtain, frames in (
        ("as it is", base, (0, 24, 48, 72, 100)),
        ("fullness 1.5", base.changed(fullness=1.5), (0, 48)),
        ("fullness 2.6", base.changed(fullness=2.6), (0, 48)),
        ("wind 1 m/s", base.changed(wind=1.0), (48, 100)),
    ):
        with CurtainShow(ctx, Scene(curtain=curtain, gi="off")) as show:
            for frame in frames:
                show.advance(frame - show.frame)
                cost_of(ctx, show, name)


def cost_of(ctx, show, name):
    positions = show.triangles.positions()
    tree = KdTree(ctx)
    tree.build(show.triangles)
    nodes, C_ts = tree.arrays(), CONSTANTS["C_TS"]
    got = exact.sah_cost(nodes | {"count": nodes["pairs"]}, C_ts)
    count, codes = show.triangles.pairs()
    codes = np.frombuffer(codes.read(4 * count), np.uint32).astype(int)
    parts = np.stack([positions[codes >> 1], positions[(codes >> 1) + (codes & 1)]], 1)
    best = exact.sah_cost(exact.build(parts, C_ts), C_ts)
    queries = RayQueries(ctx)
    o, d = camera_rays(camera_of(show.scene), 160)
    hits = queries.closest_hit(tree, o, d, counted=True)
    hit, lamp = np.isfinite(hits.t), np.array(show.scene.lamp_position)
    way = o[hit] + hits.t[hit, None] * d[hit] - lamp
    shadow = queries.closest_hit(tree, np.broadcast_to(lamp, way.shape), way, t_max=0.999, counted=True)
    work = ["{:.1f}, {:.1f}".format(*rays.work.mean(0)) for rays in (hits, shadow)]
    levels = f"{tree.large_levels} + {tree.small_levels}"
    common.row(name, show.frame, len(parts), got, best, f"{100 * (got / best - 1):+.1f} %", levels, *work)
    queries.release()
    tree.release()


def growth(ctx, only=""):
    common.head("structure", *RESULTS)
    for count, frames in ((12_786, 20), (50_000, 7), (200_000, 3)):
        for name in ("kdtree", "lbvh", "brute"):
            if (name == "brute" and count > 12_786) or only not in ("", str(count)):
                continue
            scene = Scene(curtain=CurtainParameters(), gi="off", size=(320, 320), accelerator=name)
            r = bench_curtain(ctx, scene, frames if name != "brute" else 1, count)
            common.row(name, *(str(r.get(key, "")) for key in RESULTS))


def strain(ctx):
    common.head("fabric", "longest thread of 126 frames")
    for name in FABRICS:
        with CurtainShow(ctx, Scene(curtain=CurtainParameters(), fabric=name)) as show:
            longest = []
            for _ in range(126):
                show.simulation.step(1 / 24)
                longest.append(show.simulation.cloth.strain().max())
            common.row(name, f"{100 * max(longest):.2f} %")


WIND_CASES = [f"3,{heading},{fabric}" for heading in HEADINGS for fabric in FABRICS[:3]]


def wind(ctx, *cases):
    """120 frames from where the wind begins; edges through triangles by brute force, every fifth frame; how many of them pass
    through one in two such frames that follow each other, and the longest thread of all frames."""
    sys.path.insert(0, str(common.TESTS / "structures"))
    from test_simulation import crossing_edges

    common.head(
        "wind, m/s", "heading", "fabric", "behind", "CPU ms a frame", "frames with edges", "edges", "again", "thread, %"
    )
    for case in cases or WIND_CASES:
        speed, heading, *fabrics = case.split(",")
        fabric, behind = fabrics + ["sheer_voile", ""][len(fabrics) :]
        open_to_air = [load_fabric(name).transmission.openness if name else 0.0 for name in (fabric, behind)]
        parameters = CurtainParameters(wind=float(speed), heading=heading, openness=open_to_air[0], behind=behind)
        curtains = Curtains(ctx, parameters, behind_openness=open_to_air[1])
        first = np.cumsum([0, *(one.rows * one.columns for one in curtains.pieces)])
        triangles = [grid_triangles(one.rows, one.columns) + n for one, n in zip(curtains.pieces, first, strict=False)]
        spent, found, longest, again, last = [], [], [], 0, set()
        for frame in range(120):
            before = time.process_time()
            curtains.step(1 / 24)
            ctx.finish()
            spent.append(time.process_time() - before)
            longest.append(max(one.cloth.strain().max() for one in curtains.pieces))
            if frame % 5 == 4:
                positions = np.concatenate([one.positions().reshape(-1, 3) for one in curtains.pieces])
                edges = set(map(tuple, crossing_edges(positions, np.concatenate(triangles)).tolist()))
                found.append(len(edges))
                again += len(edges & last)
                last = edges
        crossed = f"{np.count_nonzero(found)} of {len(found)}"
        cells = f"{1e3 * np.mean(spent):.0f}", crossed, sum(found), again, f"{100 * max(longest):.1f}"
        common.row(speed, heading, fabric, behind or "-", *cells)
        curtains.release()


def light(ctx):
    """Holes, yarns and reflection at normal incidence and over the hemisphere, by quadrature in float64."""
    common.head("fabric", "degrees", "openness", "holes", "yarns", "together")
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
            cells = t.openness, holes, "/".join(f"{v:.3f}" for v in yarns), holes + yarns.max()
            common.row(name, degrees, *(c if isinstance(c, str) else f"{c:.3f}" for c in cells))


def albedo(ctx):
    """Error of the albedo, of four directions and three channels, by Gauss-Legendre over z and over sin^2; in %."""
    common.head("fabric", "rings x sectors", "over", "mean", "worst")
    for name in ("sheer_voile", "linen_curtain", "linen", "silk_crepe_de_chine"):
        arrays = load_fabric(name).arrays()
        seen = [sheet_direction(*angles) for angles in ((4, 0), (25, 90), (62, 45), (76, 45))]
        exact = []
        for o in seen:
            rows = []
            for z in ((np.arange(600) + 0.5) / 600).reshape(6, 100):
                d = ring_directions(np.repeat(z, 720), np.tile((np.arange(720) + 0.5) / 720, 100))
                rows.append(2 * np.pi * f_cloth(d, o[None], *arrays).mean(0))
            exact.append(np.mean(rows, 0))
        for rings, sectors in ((16, 24), (24, 36), (32, 64)):
            x, w = np.polynomial.legendre.leggauss(rings)
            x, w = np.repeat((x + 1) / 2, sectors), np.repeat(w / 2, sectors) * 2 * np.pi / sectors
            turn = np.tile((np.arange(sectors) + 0.5) / sectors, rings)
            for over, z, weight in (("z", x, w), ("sin^2", np.sqrt(1 - x), w / 2 / np.sqrt(1 - x))):
                d = ring_directions(z, turn)
                found = [(f_cloth(d, o[None], *arrays) * weight[:, None]).sum(0) for o in seen]
                error = 100 * (np.array(found) / exact - 1)
                common.row(name, f"{rings} x {sectors}", over, f"{error.mean():+.2f}", f"{np.abs(error).max():.2f}")


def sheet_direction(theta, phi):
    """Of angles in degrees from N and about it."""
    return ring_directions(np.cos(np.radians(theta)), phi / 360)


def ring_directions(z, turn):
    """Unit vectors [..., 3] of height z, turned by so many turns about it."""
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(2 * np.pi * turn), r * np.sin(2 * np.pi * turn), z], -1)


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
    with CurtainShow(ctx, Scene(curtain=CurtainParameters(), gi="off", size=(240, 240), spp=2)) as show:
        show.advance(30)
        for row in changes:
            pictures = []
            for change in row:
                show.fabric = base.changed(transmission=t.model_copy(update=change))
                pictures.append(show.picture())
            rows.append(np.concatenate(pictures, 1))
    write_image(path, np.concatenate(rows))


if __name__ == "__main__":
    commands = {f.__name__: f for f in (hits, cost, growth, strain, wind, light, albedo, series)}
    if len(sys.argv) < 2 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    commands[sys.argv[1]](create_context(), *sys.argv[2:])
