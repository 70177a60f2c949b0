"""How long a frame takes after an edit of the weave, beside the same frame again; a table of docs/direct.md.

python tests/measure/edits.py  (half a minute). At full rate, 640x480, drape in the studio.
"""

import statistics
import time

from glcloth.fabric import load_fabric
from glcloth.picture.renderer import Renderer

FRAMES = 5


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


with Renderer() as renderer:

    def timed(fabric):
        frame = renderer.prepare(fabric=fabric, mesh="drape", env="studio", background=False)
        begin, begin_cpu = time.perf_counter(), time.process_time()
        renderer.draw(frame)
        renderer.ctx.finish()
        return 1000 * (time.perf_counter() - begin), 1000 * (time.process_time() - begin_cpu)

    print("ms wall (CPU), medians of", FRAMES)
    for name in ("linen", "silk_crepe_de_chine"):
        print(name)
        times = {}
        for i in range(-1, FRAMES):
            for what, edited in edits(load_fabric(name), i):
                times.setdefault(what, []).append((*timed(edited), *timed(edited)))
        for what, rows in times.items():
            wall, cpu, wall_again, cpu_again = (statistics.median(column) for column in zip(*rows[1:], strict=True))
            print(f"    {what:22} after the edit {wall:.0f} ({cpu:.0f}), again {wall_again:.0f} ({cpu_again:.0f})")
