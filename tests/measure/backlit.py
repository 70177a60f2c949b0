"""`direct` against `path` on sheer cloth lit from behind; a table of docs/path.md.

python tests/measure/backlit.py [sky studio ...] [--fabrics linen_curtain,sheer_voile] [--size 80x60] [--spp 256] [--light sg]
    [--turns 0,180] [--mesh drape]

Of the pixels that cloth covers whole, after means over 3x3 of them: mean of |difference| and difference of the means over the
mean of `path`, and its own noise in these means; all in %.
"""

import common
import numpy as np

import glcloth
from glcloth.color import luminance

options = common.options(
    __doc__, ["sky"], fabrics=["linen_curtain", "sheer_voile"], size="80x60", spp=256, light="sg", turns="0,180",
    mesh="drape",
)  # fmt: skip
common.head("map", "turned", "fabric", "mean", "bias", "noise")
with glcloth.Renderer() as renderer:
    for env in options.environments:
        for turn in map(float, options.turns.split(",")):
            look = dict(mesh=options.mesh, env=env, env_rotate=turn, size=options.size)
            renderer.render(method="path", fabric="linen", spp=8, **look)
            cloth = renderer.path_sums().cover == 8
            for fabric in options.fabrics:
                judge = np.asarray(
                    renderer.render(method="path", fabric=fabric, spp=options.spp, light=options.light, **look)
                )
                error = renderer.path_sums().standard_error.astype(float)
                test = np.asarray(renderer.render(method="direct", fabric=fabric, spp=16, **look))
                (a, whole), (b, _) = (common.means(luminance(p[..., :3].astype(float)), cloth) for p in (test, judge))
                noise = np.sqrt(common.means(error**2, cloth)[0] / 9)[whole].mean()
                a, b = a[whole], b[whole]
                values = (np.abs(a - b).mean() / b.mean(), a.mean() / b.mean() - 1, noise / b.mean())
                common.row(env, int(turn), fabric, *(float(100 * value) for value in values))
