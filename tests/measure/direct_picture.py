"""How close pictures by method `direct` come to brute force under the same lights, at random pixels; a table of docs/direct.md.

python tests/measure/direct_picture.py [PIXELS] [ENV]  (80 pixels of each fabric in the studio: 3 minutes)
"""

import sys

import direct_cases
import numpy as np

from glcloth.color import luminance
from glcloth.fabric import load_fabric
from glcloth.picture.renderer import Renderer
from glcloth.twins import quadrature

PIXELS = int(sys.argv[1]) if len(sys.argv) > 1 else 80
ENV = sys.argv[2] if len(sys.argv) > 2 else "studio"
SIZE = (200, 150)

with Renderer() as renderer:
    for name in direct_cases.KINDS[:6]:
        options = {"fabric": name, "mesh": "drape", "env": ENV, "size": SIZE, "background": False}
        pictures = {q: renderer.render(quality=q, **options)[::-1, :, :3] for q in ("draft", "normal", "high")}
        G = renderer.prepare(**options).lights.gaussians
        buffer = renderer.gbuffer
        N, x = (
            np.frombuffer(t.read(), "f4").reshape(*SIZE[::-1], 4).astype(float)
            for t in (buffer.frame_N, buffer.frame_x)
        )
        covered = np.argwhere(N[..., 3] != 0)
        chosen = covered[np.random.default_rng(0).choice(len(covered), PIXELS, replace=False)]
        expected = []
        for row, column in chosen:
            n, t = N[row, column, :3], x[row, column, :3]
            frame = np.stack([t, N[row, column, 3] * np.cross(n, t), n])
            omega_o = frame @ -(buffer.ray_from_pixel @ [column + 0.5, row + 0.5, 1.0])
            args = G.axis @ frame.T, G.sharpness, G.amplitude, *load_fabric(name).arrays()
            expected.append(luminance(quadrature.L_o(omega_o / np.linalg.norm(omega_o), *args, panels=10)))
        expected = np.array(expected)
        cells = []
        for picture in pictures.values():
            error = 100 * np.abs(luminance(picture[tuple(chosen.T)]) - expected)
            relative = error / expected
            cells.append(
                f"{error.sum() / expected.sum():.2f}; {np.median(relative):.2f} / {np.percentile(relative, 95):.1f}"
            )
        print(f"| {name} | {' | '.join(cells)} |", flush=True)
