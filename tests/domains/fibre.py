"""Domains of glsl/fibre."""

from . import between, directions


def off_pole(rng, count):
    """Directions up to a hundredth from the axes; nearer than that float32 vectors do not define theta_d."""
    return directions(rng, count, tilt=1e-2)


SPECIAL = {
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
    # A unit vector rounded to float32 is off by 6e-8. Divided by cos(theta_d) = 2e-3 that is 3e-5, and the transmittance
    # (1 - F_r)^2, which vanishes there with a fifth power, has up to thirty times that.
    "f_s": (1e-3, 1e-6),
    "tangent_terms": (1e-3, 1e-6),
}
