"""Domains of glsl/sg."""

import numpy as np

from . import between, choice, directions, log_between

HALF = np.pi / 2


def _powers(rng, count):
    """The integrals of falling powers of a cosine: positive, falling, as T_l's are."""
    x, mass = rng.uniform(0.05, 1.0, count), rng.uniform(0.1, 3.0, count)
    return mass[:, None] * x[:, None] ** np.arange(1, 5)


def _three(low, high):
    """Three Gaussians at once, of different widths."""
    return lambda rng, count: rng.uniform(low, high, (count, 3))


def _steps(rng, count):
    return np.exp(rng.uniform(np.log(0.01), np.log(50), (count, 3)))


def _above(rng, count, least=0.02):
    """A normal and a viewer on its side."""
    N, omega_o = directions(rng, count), directions(rng, count)
    along = (N * omega_o).sum(-1, keepdims=True)
    omega_o = omega_o + (np.maximum(np.abs(along), least) - along) * N
    return {"N": N, "omega_o": omega_o / np.linalg.norm(omega_o, axis=-1, keepdims=True)}


JOINT = {"f_gloss": _above, "gloss_of_gaussian": _above}
DOMAINS = {
    "cos_i": between(0.0, 1.0),
    "cos_o": between(1e-3, 1.0),
    "alpha": log_between(0.02, 1.0),
    "xi": directions,
    "mu_1": between(-HALF, HALF, 0.0),
    "mu_2": between(-HALF, HALF, 0.0),
    "sharpness_1": log_between(1e-3, 1e4),
    "sharpness_2": log_between(0.4, 6e3),
    "F_0": between(0.0, 0.25),
    "cos_theta_d": between(0.0, 1.0),
    "T_1": _powers,
    "T_5": _powers,
    "T_9": _powers,
    "u": _three(-60, 60),
    "before": _three(0, 10),
    "here": _three(0, 10),
    "after": _three(0, 10),
    "step": _steps,
    "left": between(-1.5, 1.5, -1.0, 0.0, 1.0),
    "over": _three(0, 10),
    "gaussian": _three(0, 1),
    "phi_k": between(-np.pi, np.pi, 0.0, HALF, -HALF),
    "kappa_prime": log_between(1e-5, 1e4),
    "inner": between(0.5, 0.9),
    "x": between(0.0, 1.0),
    "n": choice(8.0, 16.0, 48.0),
    "angle": between(-HALF, HALF, 0.0),
    "phi": between(-np.pi, np.pi, 0.0, HALF, -HALF),
    "last": choice(1500.0, 2000.0),
    "first": choice(0.5),
    "levels": choice(16.0),
    "sharpness": log_between(1e-4, 1e5),
}
SPECIAL = {
    ("gaussian_direction", "u"): lambda rng, count: rng.random((count, 2)),
    ("gaussian_pdf", "value"): between(0.0, 1.0),
    **{(name, "F_0"): _three(0.0, 1.0) for name in ("F_color", "F_repeated", "f_gloss", "gloss_of_gaussian")},
    ("F_repeated", "albedo"): between(0.05, 1.0),
    ("F_repeated_lobes", "F_0"): _three(0.0, 1.0),
    ("F_repeated_lobes", "albedos"): lambda rng, count: rng.uniform(0.05, 1.0, (count, 2)),
    ("F_repeated_lobes", "sharpness"): log_between(1e-3, 1e3),
    ("F_color", "cos_theta"): between(-0.1, 1.0),
    ("gloss_of_gaussian", "sharpness"): log_between(0.1, 1e3),
    ("theta_gaussians", "theta_k"): between(-HALF, HALF, 0.0),
    ("theta_gaussians", "theta_o"): between(-HALF, HALF, 0.0),
    ("node_terms", "weight"): _three(0, 1),
    ("node_terms", "cos_theta"): between(0.0, 1.0),
    ("node_terms", "cos_theta_d"): between(0.5, 1.0),
    ("node_terms", "slope"): between(0.5, 2.0),
    ("cut_integrated", "slope"): _three(-0.9, 0.9),
    # Further out the series loses digits, where exp(-u^2) leaves less than 1e-5 of it; here `gaussian` is free.
    ("hat_integral", "u"): _three(-1.5, 1.5),
    ("cut_hat_integral", "u"): _three(-1.5, 1.5),
}
TOLERANCE = {
    "gaussian_direction": (1e-3, 1e-4),  # opposite to the axis 2 - below loses digits
    # Coefficients up to 250 with alternating signs: 1e3 roundings of 6e-8 of the largest integral, which is 3 here.
    "volume_sum": (3e-5, 2e-4),
    # Up to eight times that.
    "node_terms": (3e-5, 1.6e-3),
    # The series leaves out about step^4 / 15 at step = 0.2.
    "hat_integral": (1.2e-4, 1e-5),
    # Half a hat leaves out step^3 / 15 as well; what is left of a sliver is lost in the rounding of the whole.
    "cut_hat_integral": (1.2e-4, 2e-4),
    # exp(-lost) with lost up to 100: relative error 100 x 6e-8 x the rounding of lost; angles of up to pi.
    "g_c_product": (1e-4, 3e-6),
    "theta_gaussians": (1e-4, 3e-6),
}
