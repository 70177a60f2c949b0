"""From the garment to its threads: a skirt as it stands, from half a metre, and from nine centimetres.

python examples/15_nearer.py [out/15_nearer.png] [FABRIC] [WIDTHxHEIGHT]  (half a minute of CPU)
"""

import sys

import numpy as np
from common import output

import glcloth
from glcloth.progress import track

path = output(sys.argv[1] if len(sys.argv) > 1 else "out/15_nearer.png")
fabric = sys.argv[2] if len(sys.argv) > 2 else "tartan"
width, height = (int(n) for n in (sys.argv[3] if len(sys.argv) > 3 else "400x533").split("x"))
PLACE = 0.62, 0.62  # in the first picture, from its top left corner
SMALL = 60, 80

with glcloth.Renderer() as renderer:
    look = {"fabric": fabric, "spp": 4}
    small = renderer.render("skirt", fabric=fabric, size=SMALL, spp=1, shadows="off", aovs="position")
    place = np.asarray(small["position"])[int(PLACE[1] * SMALL[1]), int(PLACE[0] * SMALL[0]), :3]
    way = np.asarray(renderer.prepare("skirt", size=SMALL).camera.eye) - place
    pictures = []
    for distance in track((None, 0.5, 0.09), "distances"):
        if distance is not None:
            eye = place + distance * way / np.linalg.norm(way)
            look["camera"] = glcloth.View(eye=tuple(map(float, eye)), target=tuple(map(float, place)), fov_deg=24.5)
        pictures.append(renderer.render("skirt", size=(width, height), **look))
glcloth.write_image(path, np.concatenate(pictures, axis=1), exposure=0.2, view_transform="neutral")
print(path)
