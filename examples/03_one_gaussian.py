"""Figure 3 of paper A: shot silk under one spherical Gaussian from above, sharpness 10, 100 and 1000.

Top row the reference, bottom row the paper's method.  python examples/03_one_gaussian.py [out/03_one_gaussian.png [WxH]]
"""

import sys

import numpy as np
from common import output

import glcloth
from glcloth.progress import track

path = output(sys.argv[1] if len(sys.argv) > 1 else "out/03_one_gaussian.png")
size = sys.argv[2] if len(sys.argv) > 2 else "320x240"
rows = {"reference": [], "paper": []}
with glcloth.Renderer() as renderer:
    for sharpness in track((10, 100, 1000), "sharpness"):
        # Equal flux: the integral of a Gaussian is about 2 pi / sharpness.
        lights = glcloth.SphericalGaussians([[0, 1, 0]], [sharpness], [[0.4 * sharpness] * 3])
        for method, row in rows.items():
            how = dict(method=method, size=size, background=False, shadows="off")
            row.append(renderer.render(fabric="silk_shot", lights=lights, **how)[..., :3])
glcloth.write_image(path, np.vstack([np.hstack(row) for row in rows.values()]))
print(path)
