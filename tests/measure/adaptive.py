"""What the adaptive rate adds in error, and how many pixels it shades; the last table of docs/direct.md.

python tests/measure/adaptive.py [ENV]  (half a minute; env "studio" unless named)
"""

import sys

import numpy as np

from glcloth.color import luminance
from glcloth.picture.renderer import Renderer

with Renderer() as renderer:
    for fabric in ("linen", "silk_crepe_de_chine", "satin_charmeuse_front", "velvet"):
        pictures = [
            renderer.render(
                fabric=fabric,
                mesh="drape",
                env=(sys.argv[1:] or ["studio"])[0],
                size=(640, 480),
                background=False,
                adaptive=adaptive,
            )
            for adaptive in (False, True)
        ]
        covered = pictures[0][..., 3] > 0
        full, fast = (luminance(picture[..., :3])[covered] for picture in pictures)
        error = 100 * np.abs(fast / full - 1)
        levels = " / ".join(f"{v:.2f}" for v in (error.mean(), *np.percentile(error, (95, 99)), error.max()))
        print(f"| {fabric} | {100 * renderer._adaptive.shaded() / covered.sum():.0f} % | {levels} |", flush=True)
