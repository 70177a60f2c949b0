"""What the adaptive rate adds in error, and how many pixels it shades; a table of docs/direct.md.

python tests/measure/adaptive.py [ENV] [--size 640x480]  (half a minute; env "studio" unless named)
"""

import common
import numpy as np

import glcloth
from glcloth.color import luminance

options = common.options(__doc__, ["studio"], size="640x480")
common.head("fabric", "shaded beyond one in four", "mean / 95 % / 99 % / largest error, %")
with glcloth.Renderer() as renderer:
    for fabric in [*common.FABRICS, "velvet"]:
        scene = dict(fabric=fabric, mesh="drape", env=options.environments[0], size=options.size, background=False)
        full, fast = (renderer.render(adaptive=adaptive, **scene) for adaptive in (False, True))
        covered = full[..., 3] > 0
        full, fast = (luminance(picture[..., :3])[covered] for picture in (full, fast))
        error = 100 * np.abs(fast / full - 1)
        levels = " / ".join(f"{v:.2f}" for v in (error.mean(), *np.percentile(error, (95, 99)), error.max()))
        common.row(fabric, f"{100 * renderer.stage.cloths[0].adaptive_rate.shaded() / covered.sum():.0f} %", levels)
