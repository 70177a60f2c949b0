"""Domains of glsl/fibre."""

from . import between

SPECIAL = {
    ("g_u", "x"): between(-1.6, 1.6, 0.0),
    ("D_mask", "x"): between(0.0, 1.0),
    ("D_mask", "y"): between(0.0, 1.0),
    ("D_mask", "z"): between(0.0, 1.0),
    ("tangent_from_surface", "cos_tilt"): between(-1.0, 1.0),
    ("tangent_from_surface", "sin_tilt"): between(-1.0, 1.0),
}
TOLERANCE = {
    # A unit vector rounded to float32 is off by 6e-8. Divided by cos(theta_d) = 5e-4 at grazing that is 1e-4, and the
    # transmittance (1 - F_r)^2, a product of two vanishing factors of degree up to 5 in it, has several times that.
    "f_s": (1e-3, 1e-6),
}
