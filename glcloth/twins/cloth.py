"""The microcylinder cloth, slow and obvious: every tangent, every direction, in float64 (Mizutani et al. 2012, Eq. 5-6)."""

import numpy as np

from .frame import tangent_from_surface
from .scatter import f_s
from .weight import M, P


def terms(omega_i, omega_o, yarns, tangents, weights, gap, sigma):
    """The terms of the sum over the tangents of one fabric, for direction pairs in the surface frame.

    Parameters
    ----------
    omega_i, omega_o : [..., 3] unit, away from the surface
    yarns : two mappings with eta, k_d, gamma_s, gamma_v (radians)
    tangents : [(yarn, tilt in radians, count)]
    weights : [tangents, 2], the factor in the sum and the factor in W's normaliser
    gap : 1 - a_1 - a_2
    sigma : radians

    Returns (R, cos_theta_i, f): R = weight M P / Q [..., tangents], cos_theta_i [..., tangents], f [..., tangents, 2].
    Zero where omega_i or omega_o is below the horizon of N.
    """
    omega_i, omega_o = np.broadcast_arrays(np.asarray(omega_i, float), np.asarray(omega_o, float))
    masks, lengths, cosines, values = [], [], [], []
    for yarn, tilt, _ in tangents:
        i = tangent_from_surface(omega_i, yarn, np.cos(tilt), np.sin(tilt))
        o = tangent_from_surface(omega_o, yarn, np.cos(tilt), np.sin(tilt))
        y = yarns[yarn]
        masks.append(M(i, o, sigma))
        lengths.append(P(i, o, sigma))
        cosines.append(np.hypot(i[..., 1], i[..., 2]))
        with np.errstate(divide="ignore", invalid="ignore"):
            values.append(f_s(i, o, y["eta"], y["k_d"], y["gamma_s"], y["gamma_v"]))
    P_t = np.stack(lengths, -1)
    Q = P_t @ np.asarray(weights)[:, 1] + gap * np.maximum(omega_o[..., 2], 0)
    R = np.asarray(weights)[:, 0] * np.stack(masks, -1) * P_t / np.where(Q > 0, Q, 1)[..., None]
    lit = (omega_i[..., 2] > 0) & (omega_o[..., 2] > 0) & (Q > 0)
    R = np.where(lit[..., None], R, 0.0)
    f = np.where((R > 0)[..., None], np.stack(values, -2), 0.0)
    return R, np.stack(cosines, -1), f


def f_cloth(omega_i, omega_o, yarns, tangents, weights, gap, sigma):
    """Radiance toward omega_o per unit irradiance (perpendicular to the light) from omega_i, linear RGB [..., 3].

    sum_t w_t W_t (f_rs + A f_rv) cos(theta_i) / cos^2(theta_d).   [Miz 5-6, errata E7, E8]
    """
    R, cos_theta_i, f = terms(omega_i, omega_o, yarns, tangents, weights, gap, sigma)
    A = np.array([yarns[yarn]["A"] for yarn, _, _ in tangents])
    scale = R * cos_theta_i
    return (scale * f[..., 0]).sum(-1)[..., None] + (scale * f[..., 1]) @ A


def L_o(omega_o, directions, flux, yarns, tangents, weights, gap, sigma):
    """Radiance [N, 3] toward omega_o [N, 3] under light from directions [D, 3] with flux [D, 3] = radiance x solid angle."""
    return np.array(
        [
            (f_cloth(directions, o[None], yarns, tangents, weights, gap, sigma) * flux).sum(0)
            for o in np.atleast_2d(omega_o)
        ]
    )
