"""How close method `direct` comes to brute force on fresh random cases; the tables of docs/direct.md.

python tests/measure/direct.py [CASES] [FIRST SEED]  (520 cases: 5 minutes)
"""

import itertools
import sys

import direct_cases
import numpy as np
from golden import luminance_errors

from glcloth.color import luminance
from glcloth.light.lights import SphericalGaussians
from glcloth.picture.renderer import Renderer
from glcloth.progress import track
from glcloth.twins import quadrature

QUALITIES = ("draft", "normal", "high")
SHARPNESS = (0.1, 1, 4, 15, 60, 250, 2000, 1e6)
GAMMA_DEG = (0.5, 2.6, 5.1, 7, 13, 60)


def spread(errors):
    """Median / 95 % / largest, in %."""
    errors = 100 * np.asarray(errors)
    return f"{np.median(errors):.2f} / {np.percentile(errors, 95):.2f} / {errors.max():.1f}"


def table(head, rows):
    print(f"\n| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for row in rows:
        print(f"| {' | '.join(str(value) for value in row)} |")


def main(count, first):
    kinds, gammas, sharpness = [], [], []
    wholes, parts = {q: [] for q in QUALITIES}, {q: [] for q in QUALITIES}
    with Renderer() as renderer:
        for seed in track(list(range(first, first + count)), "cases"):
            kind, fabric, omega_o, xi, k, L = direct_cases.case(seed)
            arrays = fabric.arrays()
            each = [
                quadrature.L_o(omega_o, xi[i : i + 1], k[i : i + 1], L[i : i + 1], *arrays, panels=10)
                for i in range(len(k))
            ]
            whole = np.sum(each, 0)
            if luminance(whole) <= 0:  # no tangent is seen from here
                continue
            kinds.append(kind)
            gammas.append(min(min(y.gamma_s_deg, y.gamma_v_deg) for y in fabric.yarn))
            sharpness.append(k)
            for quality in QUALITIES:
                got = renderer.radiance(fabric, omega_o, SphericalGaussians(xi, k, L), quality=quality)
                wholes[quality].append(luminance_errors(got, whole[None])[0])
                single = [
                    renderer.radiance(fabric, omega_o, SphericalGaussians(xi[i], k[i : i + 1], L[i]), quality=quality)[
                        0
                    ]
                    for i in range(len(k))
                ]
                # In units of the whole: what this Gaussian's error does to the case.
                parts[quality].append(luminance(np.asarray(single, float) - each) / luminance(whole))
    kinds, gammas, sharpness = np.array(kinds), np.array(gammas), np.array(sharpness)
    print(f"{len(kinds)} cases from seed {first}; relative error of luminance in %, median / 95 % / largest")
    rows = [
        (kind, (kinds == kind).sum(), *(spread(np.array(wholes[q])[kinds == kind]) for q in QUALITIES))
        for kind in dict.fromkeys(kinds.tolist())
    ]
    table(("fabric", "cases", *QUALITIES), rows)
    rows = []
    for low, high in itertools.pairwise(GAMMA_DEG):
        mine = (gammas >= low) & (gammas < high)
        rows.append((f"{low:g} to {high:g}", mine.sum(), *(spread(np.array(wholes[q])[mine]) for q in QUALITIES)))
    table(("narrowest gamma, degrees", "cases", *QUALITIES), rows)
    ordinary = ~np.isin(kinds, ["random", "extreme"])
    rows = []
    for low, high in itertools.pairwise(SHARPNESS):
        mine = (sharpness >= low) & (sharpness < high) & ordinary[:, None]
        row = [f"{low:g} to {high:g}", mine.sum()]
        for quality in QUALITIES:
            errors = 100 * np.abs(np.array(parts[quality])[mine])
            row.append(f"{errors.mean():.3f} / {np.percentile(errors, 95):.2f} / {errors.max():.1f}")
        rows.append(row)
    print("\nWhat one Gaussian's error does to a case, six fabrics; mean / 95 % / largest, in % of the whole radiance")
    table(("sharpness", "Gaussians", *QUALITIES), rows)


if __name__ == "__main__":
    main(
        *(int(a) for a in sys.argv[1:3])
        if len(sys.argv) > 2
        else (int(sys.argv[1]) if len(sys.argv) > 1 else 520, 1000)
    )
