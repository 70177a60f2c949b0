"""`direct` against the reference on a curtain's folds with the sun behind them; a table of docs/shadows.md.

python tests/measure/sheer.py [sky ...] [--fabrics linen_curtain,sheer_voile] [--size 40x30] [--cube 16] [--turn 150]
    [--mesh drape]

Mean of |difference| and bias of the pixels that cloth covers, in % of the reference's mean; without the bounce and with
it, of which the reference knows the first. `--mesh` takes another mesh than the folds.
"""

import common
import numpy as np

import glcloth
from glcloth.geometry import shapes
from glcloth.geometry.mesh import build_mesh


def folds():
    """A curtain's folds."""
    positions, triangles, uv, _ = shapes.plane(1.0, 16)
    x, y = positions[:, 0], positions[:, 1]
    positions[:, 2] = 0.08 * np.sin(14 * x + 0.6 * y) * (1.2 - y) + 0.05 * np.sin(5 * y)
    return build_mesh("folds", positions, triangles, uv)


options = common.options(
    __doc__, ["sky"], fabrics=["linen_curtain", "sheer_voile"], size="40x30", cube=16, turn=150.0, mesh=""
)
common.head("map", "fabric", "bounce", "mean", "bias")
with glcloth.Renderer() as renderer:
    mesh = options.mesh or folds()
    for env in options.environments:
        for fabric in options.fabrics:
            for bounce in (False, True):
                look = dict(
                    mesh=mesh, env=env, env_rotate=options.turn, fabric=fabric, size=options.size, bounce=bounce
                )
                look["light"] = "sg"
                direct, reference = (
                    renderer.render(method=method, cube=options.cube, **look) for method in ("direct", "reference")
                )
                mean, bias, *_ = common.picture_errors(direct, reference, renderer.gbuffer.covered())
                common.row(env, fabric, bounce, mean, bias)
