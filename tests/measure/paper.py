"""How close method `paper` comes to its own split and to the truth on the golden samples; a table of docs/paper.md.

python tests/measure/paper.py [--samples 60]  (4 to 10 minutes)

Printed: median / 95 % / largest relative error of luminance, in %.
"""

import common
import numpy as np
from golden import golden_fabrics, luminance_errors

import glcloth
from glcloth.light.lights import SphericalGaussians
from glcloth.twins.convolution import T_W
from glcloth.twins.frame import tangent_from_surface


def split(data, fabrics, suffix, count):
    """T times I [S, 3], T exact by quadrature and I the golden kt_Is, kt_Iv + suffix, in the fabrics' normalisation."""
    L = np.zeros((count, 3))
    for s, omega_o in enumerate(data["wo"][:count]):
        f = int(data["fabric"][s])
        fabric = fabrics[f]
        rows = list(zip(data["tan_yarn"][f], np.round(data["tan_tilt"][f], 6), strict=True))
        for t, (yarn, tilt, _) in enumerate(fabric.tangents):
            column = rows.index((yarn, round(tilt, 6)))
            if tangent_from_surface(omega_o, yarn, np.cos(tilt), np.sin(tilt))[2] <= 0:
                continue
            I_s, I_v = (data[f"kt_{name}{suffix}"][s, :, column] for name in ("Is", "Iv"))
            for k in np.flatnonzero(I_s + I_v > 1e-9):
                args = t, data["xi"][s, k], omega_o, float(data["kappa"][s, k]), fabric.tangents
                T = T_W(*args, fabric.weights, fabric.gap, fabric.sigma, panels=12)
                I = I_s[k] + data["yarn_A"][f, yarn] * I_v[k]
                L[s] += data["L_k"][s, k] * fabric.weights[t, 0] * T * I
    return L


def radiance(renderer, data, fabrics, s, **settings):
    """Sample s by method `paper`."""
    lights = SphericalGaussians(data["xi"][s], data["kappa"][s], data["L_k"][s])
    fabric = fabrics[int(data["fabric"][s])]
    return renderer.radiance(fabric, data["wo"][s][None], lights, method="paper", **settings)[0]


count = common.options(__doc__, samples=60).samples
data = common.golden()
common.head("normalisation, T, segments", "T x I, both exact", "exact T, these segments", "truth")
with glcloth.Renderer() as renderer:
    for normalization, key in (("paper", "L_ref"), ("sadeghi", "L_ref_sadeghi")):
        fabrics, truth = golden_fabrics(data, normalization), data[key][:count]
        exact = {segments: split(data, fabrics, f"_paper{segments}", count) for segments in (6, 16)}
        both = split(data, fabrics, "", count)
        common.row(f"{normalization}, T x I, both exact", "", "", common.spread(luminance_errors(both, truth)))
        for contribution in (0.9, 0.999):
            for segments in (6, 16):
                settings = dict(segments=segments, contribution=contribution)
                got = [radiance(renderer, data, fabrics, s, **settings) for s in range(len(truth))]
                errors = [common.spread(luminance_errors(got, e)) for e in (both, exact[segments], truth)]
                common.row(f"{normalization}, {100 * contribution:g} %, {segments}", *errors)
