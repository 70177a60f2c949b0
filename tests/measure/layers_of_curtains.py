"""`--gi radiosity` (or photons) of pairs and of two curtains against `--method path`; a table of docs/curtain.md.

python tests/measure/layers_of_curtains.py [--spp 512] [--size 54] [--frame 24] [--gi radiosity]

The judge traces pixels as large as 3 x 3 of the other picture. Mean of |difference| and difference of the means of luminance over
the judge's mean, the mean error that the judge's noise alone would make, the bias outside of the curtains; in %.
"""

import common
import numpy as np

import glcloth
from glcloth.color import luminance
from glcloth.scene import Scene

CURTAINS = {
    "sheer_voile, blackout behind": ("sheer_voile", {"behind": "blackout"}),
    "sheer_voile, blackout behind, 1 m open": ("sheer_voile", {"behind": "blackout", "behind_open": 1.0}),
    "linen_curtain, 1.2 m open": ("linen_curtain", {"open": 1.2}),
    "linen_curtain 1.2 m open, sheer_voile behind": ("linen_curtain", {"behind": "sheer_voile", "open": 1.2}),
}
options = common.options(__doc__, None, spp=512, size=54, frame=24, gi="radiosity")
common.head("curtains", "mean", "bias", "noise", "bias of the room")
with glcloth.Renderer() as renderer:
    for name, (fabric, curtain) in CURTAINS.items():
        n = options.size
        look = dict(curtain=curtain, fabric=fabric, frame=options.frame)
        renderer.render(Scene(size=(n, n), method="path", spp=options.spp, **look))
        sums = renderer.path_sums()
        b, error = luminance(sums.picture[..., :3].astype(float)), sums.standard_error.astype(float)
        scene = Scene(size=(3 * n, 3 * n), gi=options.gi, spp=4, **look)
        a = luminance(np.asarray(renderer.render(scene), float)).reshape(n, 3, n, 3).mean((1, 3))
        room = np.ones((n, n), bool)
        room[n // 8 : 7 * n // 8, n // 7 : 8 * n // 9] = False
        values = np.abs(a - b).mean() / b.mean(), a.mean() / b.mean() - 1, np.sqrt(2 / np.pi) * error.mean() / b.mean()
        values = [*values, a[room].mean() / b[room].mean() - 1]
        common.row(name, *(100 * float(v) for v in values))
