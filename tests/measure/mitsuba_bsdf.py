"""The plugin for Mitsuba 3 against glcloth: values, sampling by Mitsuba's own chi-square test, energy, and speed.

python tests/measure/mitsuba_bsdf.py [--fabrics linen,silk_crepe_de_chine,...] [--pairs 4000] [--variant llvm_ad_rgb]

Needs the extra `mitsuba`. Where LLVM is not found, set DRJIT_LIBLLVM_PATH. Columns: largest and mean |difference| to
the twin's f_cloth over its mean, %; p-value of the chi-square test at views of 0, 30 and 70 degrees; weight of the samples
against quadrature, %; million evaluations and samples a second, and those of Mitsuba's principled BSDF.
"""

import sys
import time

import common
import numpy as np

import glcloth
from glcloth.export.original import hemisphere, response

VIEWS = (5.0, 30.0, 70.0)


def interaction(mi, views):
    si = mi.SurfaceInteraction3f()
    si.wi, si.n, si.sh_frame = mi.Vector3f(views.T), mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Vector3f(0, 0, 1))
    return si


def values(mi, bsdf, i, o):
    return np.array(bsdf.eval(mi.BSDFContext(), interaction(mi, o), mi.Vector3f(i.T))).T


def chi_square(mi, name, view):
    """p-value of Mitsuba's test for a view."""
    from mitsuba.chi2 import BSDFAdapter, ChiSquareTest, SphericalDomain

    from glcloth.mitsuba import bsdf

    one = bsdf(name, two_sided=False)
    xml = f"<string name=\"numbers\" value='{one['numbers']}'/>"
    sample, pdf = BSDFAdapter("microcylinder", xml, wi=view.tolist())
    test = ChiSquareTest(SphericalDomain(), sample, pdf, sample_dim=3, sample_count=400_000, res=101, ires=16)
    passed = test.run(0.01)
    return test.p_value if passed else f"fails ({test.p_value:.2g})"


def whole_hemisphere(count):
    """Directions [count, 3], even in solid angle, on a lattice."""
    z, phi = (np.arange(count) + 0.5) / count, 2 * np.pi * (np.arange(count) * 0.618033988749895 % 1)
    return np.stack([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z], -1)


def rates(mi, bsdf, count=1 << 20):
    """Million evaluations and samples a second."""
    import drjit as dr

    o, i = mi.Vector3f(hemisphere(count, 5).T), mi.Vector3f(hemisphere(count, 6).T)
    si = mi.SurfaceInteraction3f()
    si.wi, si.sh_frame = o, mi.Frame3f(mi.Vector3f(0, 0, 1))
    u = [mi.Float(np.random.default_rng(k).random(count, np.float32)) for k in range(3)]
    out = []
    for work in (
        lambda: bsdf.eval(mi.BSDFContext(), si, i),
        lambda: bsdf.sample(mi.BSDFContext(), si, u[0], mi.Point2f(u[1], u[2]))[1],
    ):
        for _ in range(2):
            begin = time.perf_counter()
            dr.eval(work())
            dr.sync_thread()
        out.append(count / (time.perf_counter() - begin) / 1e6)
    return out


def main():
    options = common.options(
        __doc__, fabrics=["linen", "silk_crepe_de_chine", "satin_charmeuse_front", "velvet", "denim_raw"],
        pairs=4000, variant="llvm_ad_rgb", no_speed=False,
    )  # fmt: skip
    try:
        import mitsuba as mi
    except ImportError:
        sys.exit("mitsuba_bsdf.py: needs Mitsuba 3: pip install 'glcloth[mitsuba]'")
    mi.set_variant(options.variant)
    from glcloth.mitsuba import bsdf

    common.head("fabric", "largest", "mean", "chi-square p", "energy", "M eval/s", "M sample/s")
    for name in options.fabrics:
        plugin = mi.load_dict(bsdf(name, two_sided=False))
        i, o = hemisphere(options.pairs, 3), hemisphere(options.pairs, 4)
        truth, ours = response(glcloth.load_fabric(name))(i, o), values(mi, plugin, i, o)
        apart = 100 * np.abs(ours - truth) / truth.mean()
        p, energy = [], []
        for view_deg in VIEWS:
            slope = np.sin(np.radians(view_deg))
            view = np.array([0.8 * slope, 0.6 * slope, np.cos(np.radians(view_deg))])
            p.append(chi_square(mi, name, view))
            n = 200_000
            u = np.random.default_rng(9).random((3, n), np.float32)
            si = interaction(mi, np.repeat(view[None], n, 0))
            weight = plugin.sample(mi.BSDFContext(), si, mi.Float(u[0]), mi.Point2f(u[1], u[2]))[1]
            j = whole_hemisphere(n)
            even = values(mi, plugin, j, np.repeat(view[None], n, 0)).mean() * 2 * np.pi
            energy.append(100 * (np.array(weight).mean() / even - 1))
        said = " ".join(v if isinstance(v, str) else f"{v:.2g}" for v in p)
        speed = [0.0, 0.0] if options.no_speed else rates(mi, plugin)
        common.row(name, float(apart.max()), float(apart.mean()), said, " ".join(f"{e:+.2f}" for e in energy), *speed)
    if not options.no_speed:
        common.row("(principled)", "", "", "", "", *rates(mi, mi.load_dict({"type": "principled"})))


main()
