"""Figure 7 of paper A: the satin's lobes edited (narrower and wider highlights), silk, and velvet.

python examples/07_editing.py [out/07_editing.png [WxH]]
"""

import sys

import numpy as np
from common import output

import glcloth
from glcloth.progress import track

path = output(sys.argv[1] if len(sys.argv) > 1 else "out/07_editing.png")
size = sys.argv[2] if len(sys.argv) > 2 else "320x240"
satin = glcloth.load_fabric("satin_charmeuse_front")


def edited(scale):
    """The satin with both lobes of its first yarn scaled."""
    first, second = satin.yarn
    lobes = {"gamma_s_deg": first.gamma_s_deg * scale, "gamma_v_deg": first.gamma_v_deg * scale}
    return satin.changed(yarn=(first.changed(**lobes), second))


fabrics = [satin, edited(2.0), edited(5.0), "silk_crepe_de_chine", "silk_shot", "velvet"]
with glcloth.Renderer() as renderer:
    how = dict(environment="sky", size=size, quality="high", spp=4)
    pictures = [renderer.render(fabric=fabric, **how) for fabric in track(fabrics, "fabrics")]
glcloth.write_image(path, np.vstack([np.hstack(pictures[:3]), np.hstack(pictures[3:])]))
print(path)
