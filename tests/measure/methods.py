"""How close methods direct, paper and reference come to brute force on random cases that nobody has looked at before.

python tests/measure/methods.py [--cases 460] [--first 926000] [--kept truth.npz]   (460 cases: 15 minutes)

A case is a fabric, a view and ten Gaussians (tests/direct_cases.py); --first is the first seed, --kept a file that holds
the brute force. Errors of luminance in %. Of "bright" cases the radiance is above 0.5 % of the brightest of the six
fabrics; the others are what cloth turned away from all light shows.
"""

import common  # noqa: I001
from pathlib import Path

import numpy as np
from direct_cases import case

import glcloth
from glcloth.color import luminance
from glcloth.light.lights import SphericalGaussians
from glcloth.progress import track
from glcloth.twins import quadrature

METHODS = (("direct", "normal"), ("reference", "normal"), ("paper", "normal"), ("direct", "draft"), ("direct", "high"))
FIRST = 200  # seeds for all but direct at its normal quality: 150 cases of the six fabrics
BRIGHT = 0.005
LARGE = 0.05


def truth(first, count, kept):
    """Luminances [count, Gaussians] of the cases by brute force, from the file where it holds them."""
    if kept and Path(kept).is_file():
        data = np.load(kept)
        if int(data["first"]) == first and len(data["L"]) >= count:
            return luminance(data["L"][:count])
    found = []
    for seed in track(list(range(first, first + count)), "brute force"):
        _, fabric, omega_o, xi, k, L = case(seed)
        each = [slice(i, i + 1) for i in range(len(k))]
        found.append([quadrature.L_o(omega_o, xi[i], k[i], L[i], *fabric.arrays(), panels=7) for i in each])
    if kept:
        np.savez(kept, first=first, L=np.array(found))
    return luminance(np.array(found))


def rows(kinds, bright):
    """A row for each kind of fabric, the six together, and their bright cases."""
    six = ~np.isin(kinds, ["random", "extreme"])
    for kind in dict.fromkeys(kinds.tolist()):
        yield kind, kinds == kind
    yield "the six", six
    yield "the six, bright", six & bright


def main():
    """Print the tables."""
    args = common.options(__doc__, cases=460, first=926000, kept="")
    seeds = np.arange(args.first, args.first + args.cases)
    whole = truth(args.first, args.cases, args.kept).sum(1)
    kinds = np.array([case(seed)[0] for seed in seeds])
    lit = whole > 0.0  # else no tangent is seen
    bright = whole > BRIGHT * whole[~np.isin(kinds, ["random", "extreme"])].max()
    print(f"{lit.sum()} cases from seed {args.first}; errors of luminance in %")
    common.head("method", "cases", "number", "median / 95 % / largest")
    with glcloth.Renderer() as renderer:
        for method, quality in METHODS:
            name = f"{method}, {quality}" if method == "direct" else method
            mine = lit & (np.arange(len(seeds)) < (FIRST if name != "direct, normal" else len(seeds)))
            if method != "direct":  # paper would make tables of each fabric
                mine &= ~np.isin(kinds, ["random", "extreme"])
            error = np.full(len(seeds), np.nan)
            for i in track(np.flatnonzero(mine).tolist(), name):
                _, fabric, omega_o, xi, k, L = case(int(seeds[i]))
                how = {"method": method, "quality": quality}
                got = renderer.radiance(fabric, omega_o, SphericalGaussians(xi, k, L), **how)
                error[i] = abs(luminance(got.astype(float))[0] / whole[i] - 1.0)
            for what, of in rows(kinds, bright):
                if (of & mine).any():
                    common.row(name, what, (of & mine).sum(), common.spread(error[of & mine]))
            large = np.flatnonzero(bright & mine & (error > LARGE) & ~np.isin(kinds, ["random", "extreme"]))
            if method == "direct":
                print(
                    f"bright cases of the six above {LARGE:.0%}:",
                    {int(seeds[i]): round(100 * float(error[i]), 2) for i in large},
                )


if __name__ == "__main__":
    main()
