"""`--gi radiosity` (or another, or off) of the curtain against `--method path`; a table of docs/curtain.md.

python tests/measure/judge_curtain.py [FABRIC:FRAME ...] [--spp 1024] [--size 54] [--gi radiosity] [--out FOLDER]

The judge traces `size` x `size` pixels, each as large as 3 x 3 of the picture by `gi`, whose means over these, of 24 samples
each, are compared: mean of |difference| and difference of the means of luminance over the judge's mean, and the mean error that
the judge's noise alone would make; then the difference of the means on curtain, left, right and upper parts of the picture; all
in %. With `out` the judge's pictures are kept there, and found again.
"""

from pathlib import Path

import common
import numpy as np

import glcloth
from glcloth.color import luminance
from glcloth.scene import Scene


def judged(renderer, fabric, frame):
    """The judge's picture, its standard error, and what is seen first."""
    file = options.out / f"judge_{fabric}_{frame}_{options.spp}_{options.size}.npz"
    if file.exists():
        with np.load(file) as found:
            return found["Y"], found["error"]
    size = (options.size, options.size)
    renderer.render(Scene(curtain={}, fabric=fabric, frame=frame, size=size, method="path", spp=options.spp))
    sums = renderer.path_sums()
    Y, error = luminance(sums.picture[..., :3].astype(float)), sums.standard_error.astype(float)
    np.savez(file, Y=Y, error=error)
    return Y, error


options = common.options(
    __doc__,
    ["sheer_voile:30", "lace:75", "linen_curtain:60"],
    spp=1024,
    size=54,
    gi="radiosity",
    out=Path("out/judge"),
)
common.head("fabric", "frame", "mean", "bias", "noise", "curtain", "left", "right", "above", "below")
with glcloth.Renderer() as renderer:
    for entry in options.environments:
        fabric, frame = entry.split(":")
        b, error = judged(renderer, fabric, int(frame))
        n = options.size
        scene = Scene(curtain={}, fabric=fabric, frame=int(frame), size=(3 * n, 3 * n), gi=options.gi, spp=24)
        a = luminance(np.asarray(renderer.render(scene), float)).reshape(n, 3, n, 3).mean((1, 3))
        k = n // 9
        rows, whole = slice(2 * k, 7 * k), slice(0, n)
        places = (rows, slice(2 * k, 8 * k)), (rows, slice(0, k)), (rows, slice(8 * k, n))
        places = (*places, (slice(0, k), whole), (slice(8 * k, n), whole))
        parts = [100 * float(a[place].mean() / b[place].mean() - 1) for place in places]
        mean, noise = np.abs(a - b).mean(), np.sqrt(2 / np.pi) * error.mean()
        values = (100 * float(v) for v in (mean / b.mean(), a.mean() / b.mean() - 1, noise / b.mean()))
        common.row(fabric, frame, *values, *parts)
