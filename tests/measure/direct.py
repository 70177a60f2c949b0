"""How close method `direct` comes to brute force on fresh random cases; the tables of docs/direct.md.

python tests/measure/direct.py [--cases 520] [--first 1000]  (520 cases: 5 minutes; --first is the first seed)
"""

import itertools

import common
import numpy as np
from direct_cases import case
from golden import luminance_errors

import glcloth
from glcloth.color import luminance
from glcloth.light.lights import SphericalGaussians
from glcloth.progress import track
from glcloth.twins import quadrature

SHARPNESS = (0.1, 1, 4, 15, 60, 250, 2000, 1e6)
GAMMA_DEG = (0.5, 2.6, 5.1, 7, 13, 60)


def errors(renderer, fabric, omega_o, xi, k, L):
    """Of each quality: the case's relative error, and each Gaussian's in units of the case; None for a black case."""
    each = [slice(i, i + 1) for i in range(len(k))]
    L_o = [quadrature.L_o(omega_o, xi[i], k[i], L[i], *fabric.arrays(), panels=10) for i in each]
    whole = np.sum(L_o, 0)
    if luminance(whole) <= 0:  # no tangent is seen from here
        return None

    def radiance(i, quality):
        return renderer.radiance(fabric, omega_o, SphericalGaussians(xi[i], k[i], L[i]), quality=quality)

    wholes = [luminance_errors(radiance(slice(None), q), whole[None])[0] for q in common.QUALITIES]
    parts = [np.concatenate([radiance(i, q) for i in each]).astype(float) - L_o for q in common.QUALITIES]
    return wholes, luminance(np.array(parts)) / luminance(whole)


def spreads(errors):
    """A cell for each quality of errors [cases, qualities]."""
    return [common.spread(column) for column in errors.T]


options = common.options(__doc__, cases=520, first=1000)
found = []
with glcloth.Renderer() as renderer:
    for seed in track(list(range(options.first, options.first + options.cases)), "cases"):
        kind, fabric, *rest = case(seed)
        if (result := errors(renderer, fabric, *rest)) is not None:
            gamma = min(min(y.gamma_s_deg, y.gamma_v_deg) for y in fabric.yarn)
            found.append((kind, gamma, rest[2], *result))
kinds, gammas, sharpness, wholes, parts = (np.array(column) for column in zip(*found, strict=True))
print(f"{len(kinds)} cases from seed {options.first}; relative error of luminance in %, median / 95 % / largest")
common.head("fabric", "cases", *common.QUALITIES)
for kind in dict.fromkeys(kinds.tolist()):
    common.row(kind, (kinds == kind).sum(), *spreads(wholes[kinds == kind]))
common.head("narrowest gamma, degrees", "cases", *common.QUALITIES)
for low, high in itertools.pairwise(GAMMA_DEG):
    mine = (gammas >= low) & (gammas < high)
    if mine.any():
        common.row(f"{low:g} to {high:g}", mine.sum(), *spreads(wholes[mine]))
print("\nWhat one Gaussian's error does to a case, six fabrics; mean / 95 % / largest, in % of the whole radiance")
common.head("sharpness", "Gaussians", *common.QUALITIES)
ordinary = ~np.isin(kinds, ["random", "extreme"])
for low, high in itertools.pairwise(SHARPNESS):
    mine = (sharpness >= low) & (sharpness < high) & ordinary[:, None]
    if mine.any():
        of = 100 * np.abs(parts.swapaxes(0, 1)[:, mine])
        cells = [f"{e.mean():.3f} / {np.percentile(e, 95):.2f} / {e.max():.1f}" for e in of]
        common.row(f"{low:g} to {high:g}", mine.sum(), *cells)
