"""Errors of `direct` with shadows and bounce against `path`; a table of docs/path.md.

python tests/measure/judge.py [studio sky FILE.hdr ...] [--fabrics linen,silk_crepe_de_chine,satin_charmeuse_front]
    [--size 120x90] [--noise 1.5] [--spp 144] [--turn 0] [--light map] [--ground off] [--method direct] [--quality normal]

Of the pixels that the built-in cloth covers whole, after means over 3x3 of them, which quieten the judge: mean of
|difference| and difference of the means over the judge's mean, median and 95th percentile of the relative error, and the
judge's own noise in these means; all in %. The picture that is judged has `--spp` samples a pixel: with 16 its own
noise, in the folds of silk at 56x42, is 2 %.
"""

import common
import numpy as np

import glcloth
from glcloth.color import luminance

options = common.options(
    __doc__, ["studio"], fabrics=common.FABRICS, size="120x90", noise=1.5, light="map", ground="off", method="direct",
    quality="normal", spp=144, turn=0.0,
)  # fmt: skip
common.head("map", "fabric", "mean", "bias", "median", "95 %", "noise", "samples", "s")
with glcloth.Renderer() as renderer:
    for env in options.environments:
        for fabric in options.fabrics:
            look = dict(
                mesh="drape", fabric=fabric, env=env, size=options.size, ground=options.ground, background=False,
                env_rotate=options.turn,
            )  # fmt: skip
            begin = common.time.perf_counter()
            judge = renderer.render(method="path", light=options.light, noise=options.noise, **look)
            seconds = common.time.perf_counter() - begin
            sums = renderer.path_sums()
            test = renderer.render(method=options.method, quality=options.quality, spp=options.spp, **look)
            cloth = (sums.cover == sums.samples) & (np.asarray(test)[..., 3] > 0.999)
            if options.ground != "off":  # the ground has no fabric
                cloth &= np.ptp(sums.albedo / sums.samples - glcloth.Scene().ground_color, axis=-1) > 1e-3
            (a, whole), (b, _) = (
                common.means(luminance(np.asarray(p)[..., :3].astype(float)), cloth) for p in (test, judge)
            )
            noise = np.sqrt(common.means(sums.standard_error.astype(float) ** 2, cloth)[0] / 9)[whole].mean()
            a, b = a[whole], b[whole]
            relative = np.abs(a - b) / b
            errors = [np.abs(a - b).mean() / b.mean(), a.mean() / b.mean() - 1, *np.percentile(relative, (50, 95))]
            values = (float(100 * value) for value in (*errors, noise / b.mean()))
            common.row(env, fabric, *values, sums.samples, round(seconds))
