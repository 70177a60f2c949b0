"""Threads near by: three fabrics 4 cm wide, under the studio, beside each other.

python examples/13_threads.py [out/13_threads.png] [FABRIC ...]  (under a minute on two cores)
"""

import sys

import numpy as np
from common import output

import glcloth
from glcloth.geometry.mesh import build_mesh
from glcloth.progress import track

WIDTH = 0.04  # metres of cloth across a picture
path = output(sys.argv[1] if len(sys.argv) > 1 else "out/13_threads.png")

side = 0.5
corners = np.array([[-side, 0, side], [side, 0, side], [side, 0, -side], [-side, 0, -side]])
uv = side * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])  # metres
cloth = build_mesh("flat", corners, np.array([[0, 1, 2], [0, 2, 3]]), uv, None)
away, height = 0.77 * WIDTH * np.array([np.cos(1.0), np.sin(1.0)])
camera = glcloth.Camera((0.0, height, away), (0.0, 0.0, 0.0), fov_deg=40.0)

with glcloth.Renderer() as renderer:
    pictures = [
        renderer.render(fabric=name, mesh=cloth, camera=camera, env="studio", spp=4, size=(480, 480), shadows="off")
        for name in track(sys.argv[2:] or ("houndstooth", "denim_raw", "linen_heavy"), "fabrics")
    ]
glcloth.write_image(path, np.concatenate(pictures, axis=1), exposure=0.3, view_transform="filmic")
print(path)
