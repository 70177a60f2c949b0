"""How close method `paper` comes to its own split and to the truth, on the golden samples; the figures of
docs/paper.md.  python tests/measure/paper.py [SHARED]  (4 to 10 minutes)
"""

import sys
from pathlib import Path

import numpy as np
from golden import golden_fabrics, luminance_errors

from glcloth.light.lights import SphericalGaussians
from glcloth.picture.renderer import Renderer
from glcloth.twins.convolution import T_W
from glcloth.twins.frame import tangent_from_surface

SHARED = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parents[3] / "shared")


def split(data, fabrics, suffix):
    """T times I [S, 3], T exact by quadrature and I the golden kt_Is, kt_Iv + suffix, in the fabrics' normalisation."""
    L = np.zeros((len(data["wo"]), 3))
    for s, omega_o in enumerate(data["wo"]):
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


def line(got, expected):
    errors = 100 * luminance_errors(got, expected)
    return " / ".join(f"{np.percentile(errors, q):.2f}" for q in (50, 95, 100))


data = np.load(SHARED / "golden" / "microcylinder.npz")
with Renderer() as renderer:
    for normalization, truth in (("paper", "L_ref"), ("sadeghi", "L_ref_sadeghi")):
        fabrics = golden_fabrics(data, normalization)
        exact = {segments: split(data, fabrics, f"_paper{segments}") for segments in (6, 16)}
        both = split(data, fabrics, "")
        print(f"{normalization}: median / 95 % / max relative error of luminance, in %")
        print(f"  T x I, both exact, against the truth: {line(both, data[truth])}")
        for contribution in (0.9, 0.999):
            for segments in (6, 16):
                got = [
                    renderer.radiance(
                        fabrics[int(data["fabric"][s])],
                        data["wo"][s][None],
                        SphericalGaussians(data["xi"][s], data["kappa"][s], data["L_k"][s]),
                        method="paper",
                        segments=segments,
                        contribution=contribution,
                    )[0]
                    for s in range(len(data["wo"]))
                ]
                print(
                    f"  {100 * contribution:g} %, {segments} segments: against T x I, both exact {line(got, both)}; "
                    f"exact T, {segments} segments {line(got, exact[segments])}; the truth {line(got, data[truth])}",
                    flush=True,
                )
