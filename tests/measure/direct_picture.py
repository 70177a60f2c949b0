"""How close pictures by method `direct` come to brute force under the same lights, without shadows.

python tests/measure/direct_picture.py [ENV] [--pixels 80]  (random pixels of each fabric: 3 minutes)

Printed per quality: mean; median / 95th percentile of the relative error of luminance in %.
"""

import common
import numpy as np
from direct_cases import KINDS

import glcloth
from glcloth.color import luminance
from glcloth.twins import quadrature

options = common.options(__doc__, ["studio"], pixels=80)
common.head("fabric", *common.QUALITIES)
with glcloth.Renderer() as renderer:
    for name in KINDS[:6]:
        scene = dict(fabric=name, env=options.environments[0], size=(200, 150), background=False, shadows="off")
        pictures = [renderer.render(quality=q, **scene)[::-1, :, :3] for q in common.QUALITIES]
        G, pixels = renderer.prepare(**scene).lights.gaussians, common.Pixels(renderer)
        cloth = glcloth.load_fabric(name).arrays()
        rng = np.random.default_rng(0)
        chosen = pixels.covered[rng.choice(len(pixels.covered), options.pixels, replace=False)]
        expected = []
        for place in chosen:
            frame, omega_o = pixels.frame(*place)
            L_o = quadrature.L_o(omega_o, G.axis @ frame.T, G.sharpness, G.amplitude, *cloth, panels=10)
            expected.append(luminance(L_o))
        expected, cells = np.array(expected), []
        for picture in pictures:
            error = 100 * np.abs(luminance(picture[tuple(chosen.T)]) - expected)
            median, high = np.percentile(error / expected, (50, 95))
            cells.append(f"{error.sum() / expected.sum():.2f}; {median:.2f} / {high:.1f}")
        common.row(name, *cells)
