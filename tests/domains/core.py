"""Domains of glsl/core."""

from . import between, directions, vectors

SPECIAL = {
    ("facing_normal", "least"): between(0.02, 0.1),
    ("pow5", "x"): between(-2.0, 2.0, 0.0, 1.0),
    ("orthogonal_part", "v"): vectors(1.0),
    # At the poles themselves u has no value.
    ("uv_from_direction", "omega"): directions,
    ("erf", "x"): between(-8.0, 8.0, 0.0, -1.0, 1.0),
}
TOLERANCE = {
    # The part across omega_o is what is left of N; next to -omega_o a thousandth of it, with as many digits fewer.
    "facing_normal": (3e-5, 1e-3),
    # Taking away the part of v along N loses |v| / |x| in digits, at most 1e4 before the fallback.
    "orthogonal_part": (3e-5, 1e-3),
}
