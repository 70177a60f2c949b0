"""Six fabrics under several environments: direct, reference, and their difference x 8, side by side.

python examples/10_contact_sheet.py OUT.png WxH ENVIRONMENT...      (default: out/10_contact_sheet.png 200x150 studio)
"""

import sys
from pathlib import Path

import numpy as np
from common import output

import glcloth
from glcloth.color import luminance
from glcloth.metrics import difference

path = output(sys.argv[1] if len(sys.argv) > 1 else "out/10_contact_sheet.png")
size = sys.argv[2] if len(sys.argv) > 2 else "200x150"
environments = sys.argv[3:] or ["studio"]
fabrics = ("linen", "silk_crepe_de_chine", "silk_shot", "satin_charmeuse_front", "satin_charmeuse_back", "velvet")
rows = []
with glcloth.Renderer() as renderer:
    for fabric in fabrics:
        row = []
        for environment in environments:
            scene = dict(fabric=fabric, environment=environment, size=size, background=False, shadows="off")
            direct = renderer.render(method="direct", **scene)[..., :3]
            reference = renderer.render(method="reference", **scene)[..., :3]
            error = np.abs(luminance(direct) - luminance(reference)).mean() / luminance(reference).mean()
            print(f"{fabric:24}{Path(environment).stem:12}mean error {100 * error:.2f} %", flush=True)
            # Velvet is dark and forests are dim: each triple is shown so that its reference is well exposed.
            scale = 0.18 / luminance(reference)[luminance(reference) > 0].mean()
            row.append(np.hstack([direct, reference, difference(direct, reference, 8.0)]) * scale)
        rows.append(np.hstack(row))
glcloth.write_image(path, np.vstack(rows))
print(path)
