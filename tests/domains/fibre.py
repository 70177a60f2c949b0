"""Domains of glsl/fibre."""

import numpy as np

from glcloth.twins.lobe import lobe_ends

from . import GAMMA, between, choice, directions


def off_pole(rng, count):
    """Directions up to a hundredth from the axes; nearer than that float32 vectors do not define theta_d."""
    return directions(rng, count, tilt=1e-2)


def seen(rng, count):
    """Such directions on the side of n."""
    v = off_pole(rng, count)
    return np.c_[v[:, :2], np.abs(v[:, 2])]


def a_lobe(rng, count):
    """A viewer, a width, and the ends of what is drawn."""
    omega_o, gamma = seen(rng, count), GAMMA(rng, count)
    return {"omega_o": omega_o, "gamma": gamma, "ends": lobe_ends(omega_o, gamma)}


def two_lobes(rng, count):
    """A viewer, and the ends of both lobes."""
    omega_o = seen(rng, count)
    return {"omega_o": omega_o} | {f"ends_{k}": lobe_ends(omega_o, GAMMA(rng, count)) for k in "vs"}


JOINT = {"lobe_weights": two_lobes, "lobe_direction": a_lobe, "lobe_pdf": a_lobe}
SPECIAL = {
    ("hair_place", "way"): lambda rng, count: rng.random((count, 4)),
    ("hair_place", "bend"): lambda rng, count: rng.random((count, 4)),
    ("hair_place", "s"): between(0.0, 1.0),
    ("hair_cover", "x"): between(-4.0, 4.0),
    ("hair_cover", "width"): between(0.01, 6.0),
    ("hair_horizon", "N"): directions,
    ("hair_horizon", "omega"): directions,
    ("hair_horizon", "soft"): between(0.25, 1.0),
    ("lobe_ends", "omega_o"): seen,
    ("lobe_weights", "weight"): between(0.0, 1.0),
    ("lobe_weights", "A"): between(0.0, 1.0),
    **{(name, "lobe"): choice(0, 1) for name in ("lobe_direction", "lobe_pdf")},
    ("lobe_direction", "u"): lambda rng, count: rng.random((count, 2)),
    ("lobe_pdf", "omega_i"): off_pole,
    ("f_s", "omega_i"): off_pole,
    ("f_s", "omega_o"): off_pole,
    ("tangent_terms", "omega_i"): off_pole,
    ("tangent_terms", "omega_o"): off_pole,
    ("tangent_terms", "weight"): between(0.0, 1.0),
    ("g_u", "x"): between(-1.6, 1.6, 0.0),
    ("D_mask", "x"): between(0.0, 1.0),
    ("D_mask", "y"): between(0.0, 1.0),
    ("D_mask", "z"): between(0.0, 1.0),
    ("tangent_from_surface", "cos_tilt"): between(-1.0, 1.0),
    ("tangent_from_surface", "sin_tilt"): between(-1.0, 1.0),
}
TOLERANCE = {
    "lobe_ends": (3e-5, 3e-5),  # angles are rounded by 6e-8, and divided by widths down to half a degree
    # Beyond erf(x) = 1 - 1e-4 single precision keeps two digits of how far it is from 1.
    "lobe_direction": (1e-2, 1e-2),
    "lobe_pdf": (1e-3, 1e-5),
    # A unit vector rounded to float32 is off by 6e-8. Divided by cos(theta_d) = 2e-3 that is 3e-5, and the transmittance
    # (1 - F_r)^2, which vanishes there with a fifth power, has up to thirty times that.
    "f_s": (1e-3, 1e-6),
    "tangent_terms": (1e-3, 1e-6),
}
