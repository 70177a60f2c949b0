"""How long a frame takes after an edit of the weave, and the same frame again; a table of docs/direct.md.

python tests/measure/edits.py [--size 640x480] [--times 5]  (half a minute). At full rate, drape in the studio.
"""

import common
import numpy as np

import glcloth


def edits(fabric, i):
    """Edit number i of each kind."""
    warp, weft = fabric.yarn
    bent = [angle + 0.2 * (i + 2) * (-1 if angle < 0 else 1) for angle in warp.curve_angles_deg]
    longer = [length * (1 + 0.02 * (i + 2)) if n == 0 else length for n, length in enumerate(warp.curve_lengths)]
    area = warp.area * (0.8 - 0.01 * i)
    yield "tangent curve", fabric.changed(yarn=(warp.changed(curve_angles_deg=bent), weft))
    yield "lengths of the curve", fabric.changed(yarn=(warp.changed(curve_lengths=longer), weft))
    yield "number of samples", fabric.changed(yarn=(warp.changed(samples=warp.samples + 1 + i % 2), weft))
    yield "areas", fabric.changed(yarn=(warp.changed(area=area), weft))
    yield "gamma_s", fabric.changed(yarn=(warp.changed(gamma_s_deg=warp.gamma_s_deg * (1 + 0.01 * i)), weft))


options = common.options(__doc__, size="640x480", times=5)
common.head("fabric", "edit", "after it: ms wall (CPU)", "again")
with glcloth.Renderer() as renderer:
    for name in ("linen", "silk_crepe_de_chine"):
        times = {}
        for i in range(-1, options.times):
            for kind, edited in edits(glcloth.load_fabric(name), i):
                frames = [renderer.prepare(fabric=edited, size=options.size, background=False) for _ in range(2)]
                spent = [common.spent(renderer, lambda frame=frame: renderer.draw(frame)) for frame in frames]
                times.setdefault(kind, []).append(spent)
        for kind, rows in times.items():
            after, again = np.median(rows[1:], 0)  # the first compiles
            common.row(name, kind, *("{:.0f} ({:.0f})".format(*pair) for pair in (after, again)))
