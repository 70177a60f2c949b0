"""How much light of the sky radiosity's sheet, which stays where it hangs, keeps from a room where the wind lifts the curtain.

python tests/measure/sky_past_hem.py [linen_curtain] [60]

Of parts of the built-in room: irradiance by the sky as radiosity has it, by rays from each element to each cell of the openings
through the cloth as it hangs, all indirect irradiance, and the difference of the first two in % of it.
"""

import sys

import common
import numpy as np

import glcloth
from glcloth.color import luminance
from glcloth.curtain.folds import attenuate
from glcloth.curtain.radiosity import without_suns
from glcloth.curtain.show import CurtainShow
from glcloth.gpu.buffers import TextureBuffer
from glcloth.light import equirect
from glcloth.light.environment import rotation_y
from glcloth.scene import Scene


def four(values):
    """[N, 3] as vec4."""
    return np.concatenate([values, np.zeros((len(values), 1))], 1).astype("f4")


def through(show, inputs, x, ends):
    """What passes the cloth between points and ends [N, 3]."""
    a, b, before, after = (TextureBuffer(show.ctx, 16 * len(x)) for _ in range(4))
    a.write(four(x))
    b.write(four(ends))
    before.write(four(np.ones((len(x), 3))))
    attenuate(show.ctx, show.tracer.structure("kdtree"), inputs, a, before, after, len(x), b)
    return np.frombuffer(after.read(16 * len(x)), "f4").reshape(-1, 4)[:, :3]


fabric = sys.argv[1] if len(sys.argv) > 1 else "linen_curtain"
frame = sys.argv[2] if len(sys.argv) > 2 else "60"
with glcloth.Renderer() as renderer:
    show = CurtainShow(renderer.ctx, Scene(curtain={}, fabric=fabric, gi="radiosity", size=(32, 32)))
    show.advance(int(frame))
    show.picture()
    radiosity, shot = show.radiosity, show.lit(show.shot())
    factors, folds, inputs = radiosity.factors, radiosity._folds.value, show.tracer.inputs(shot)
    charts = factors.charts
    N = len(charts.positions)
    x = charts.positions + 1e-3 * charts.normals
    small, turn = without_suns(show.environment), rotation_y(-show.scene.env_rotate)
    model, true = np.zeros((N, 3)), np.zeros((N, 3))
    behind = factors.crossing()[len(charts.patches) :]
    for corners, F, through_it in zip(
        factors.openings, factors.factors[factors.light_senders :, :N], behind, strict=True
    ):
        sees = np.flatnonzero(F)
        end = np.broadcast_to(corners.mean(0), (len(sees), 3))
        d = end - x[sees]
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        light = np.pi * F[sees, None] * equirect.lookup(small, d @ turn.T)
        share = through_it[sees, None]
        model[sees] += light * (1.0 - share + share * folds.along(d))
        true[sees] += light * through(show, inputs, x[sees], end)
    E, area = radiosity.irradiance()[:N], charts.area * (factors.openness() >= 0.35)
    p = charts.positions
    common.head("part", "radiosity", "rays", "all", "difference, %")
    for name, here in {
        "left wall near": (p[:, 0] < -1.99) & (p[:, 2] < 1.5),
        "right wall near": (p[:, 0] > 1.99) & (p[:, 2] < 1.5),
        "floor near": (p[:, 1] < 0.01) & (p[:, 2] < 1),
        "floor far": (p[:, 1] < 0.01) & (p[:, 2] > 1),
        "ceiling": p[:, 1] > 2.69,
        "back wall": p[:, 2] > 3.99,
    }.items():
        a, b, c = (
            float(luminance((v * (area * here)[:, None]).sum(0) / (area * here).sum())) for v in (model, true, E)
        )
        common.row(name, f"{a:.4f}", f"{b:.4f}", f"{c:.4f}", 100 * (a - b) / c)
    show.release()
