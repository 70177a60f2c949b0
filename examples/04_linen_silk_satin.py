"""Figures 4 to 6 of paper A: linen, silk and satin by the paper's method, the reference, and their difference.

A row per fabric: paper, reference, difference x 8 (linen) or x 4 (silk and satin), both under the same fitted lights.
python examples/04_linen_silk_satin.py [out/04_linen_silk_satin.png [WxH [ENVIRONMENT]]]
"""

import sys

import numpy as np
from common import output

import glcloth
from glcloth.metrics import compare, difference

path = output(sys.argv[1] if len(sys.argv) > 1 else "out/04_linen_silk_satin.png")
size = sys.argv[2] if len(sys.argv) > 2 else "240x180"
environment = sys.argv[3] if len(sys.argv) > 3 else "studio"
rows = []
with glcloth.Renderer() as renderer:
    for fabric, scale in (("linen", 8), ("silk_crepe_de_chine", 4), ("satin_charmeuse_front", 4)):
        scene = dict(fabric=fabric, environment=environment, size=size, background=False, shadows="off")
        paper = renderer.render(method="paper", **scene)[..., :3]
        reference = renderer.render(method="reference", **scene)[..., :3]
        print(fabric, {name: round(value, 5) for name, value in compare(paper, reference).items()})
        rows.append(np.hstack([paper, reference, difference(paper, reference, scale)]))
glcloth.write_image(path, np.vstack(rows))
print(path)
