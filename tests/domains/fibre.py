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
    # A unit vector rounded to float32 is off by 6e-8; divided by cos(theta_d) = 1e-3 at grazing, that is 1e-4 of f_s.
    "f_s": (2e-4, 1e-6),
}
