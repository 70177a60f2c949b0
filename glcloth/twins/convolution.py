"""Paper A's split of the integral (Mizutani et al. 2012, Eq. 8-16) as printed, slow and obvious, in float64."""

import numpy as np

from . import segments as line
from .azimuth import T_l
from .frame import tangent_axes, tangent_from_surface
from .fresnel import F_0
from .fresnel_sum import C_l, D_l
from .gaussian import g_c_product, sigma_of_sharpness
from .quadrature import graded
from .scatter import angles
from .weight import M, P

# |tilt| from which on the domain of T and I is cut, and at which it ends at the horizon of N.
UPRIGHT = np.radians(36), np.radians(46)


def W(t, omega_i, omega_o, tangents, weights, gap, sigma):
    """The weight of tangent t [...], without its factor in the sum; 0 for omega_i below the horizon of N.   [Miz 6]"""
    omega_i, omega_o = np.broadcast_arrays(np.asarray(omega_i, float), np.asarray(omega_o, float))
    local = []
    for yarn, tilt, _ in tangents:
        local.append([tangent_from_surface(omega, yarn, np.cos(tilt), np.sin(tilt)) for omega in (omega_i, omega_o)])
    Q = sum(share * P(i, o, sigma) for (_, share), (i, o) in zip(weights, local, strict=True))
    Q = Q + gap * np.maximum(omega_o[..., 2], 0)
    value = M(*local[t], sigma) * P(*local[t], sigma) / np.where(Q > 0, Q, 1)
    return np.where((omega_i[..., 2] > 0) & (Q > 0), value, 0.0)


def theta_end(tilt):
    """Where the domain of T and of I ends in theta_i, on the side to which the tangent leans.   [own]

    W vanishes below the horizon of N, which hides theta_i > pi / 2 - |tilt| of a tangent's hemisphere. Of flat tangents that
    is little; of upright ones it is half, whose light I must not hold. Between the two the end moves smoothly.
    """
    lean = np.clip((np.abs(tilt) - UPRIGHT[0]) / (UPRIGHT[1] - UPRIGHT[0]), 0, 1)
    return np.pi / 2 - np.abs(tilt) * lean * lean * (3 - 2 * lean)


def T_W(t, xi, omega_o, sharpness, tangents, weights, gap, sigma, panels=24):
    """The mean of W of tangent t under one Gaussian, for one xi [3] and one omega_o [3].   [Miz 9]

    The numerator is over the directions above both horizons, N's and the tangent's; the denominator over the tangent's
    up to `theta_end`, as the integrals I are: their product then has the light of the hemisphere of N.
    """
    yarn, tilt, _ = tangents[t]
    axes = np.stack(tangent_axes(yarn, np.cos(tilt), np.sin(tilt)))
    theta_k, phi_k = angles(axes @ np.asarray(xi, float))
    width = np.sqrt(2 / max(sharpness, 1e-3))

    def integral(lo, hi, reach, weight):
        theta, w_theta = graded(lo, hi, [np.clip(theta_k, lo, hi), lo, hi], [width, 0.2, 0.2], panels)
        limit = reach(theta)
        near = np.clip(phi_k, -limit, limit)
        widths = np.broadcast_to([width, 0.3, 0.3], (len(theta), 3))
        phi, w_phi = graded(-limit, limit, np.stack([near, -limit, limit], -1), widths, panels)
        s, c = np.sin(theta)[:, None], np.cos(theta)[:, None]
        local = np.stack(np.broadcast_arrays(s, c * np.sin(phi), c * np.cos(phi)), -1)
        G = np.exp(-sharpness / 2 * np.sum((local - axes @ xi) ** 2, -1))
        return np.sum(w_theta[:, None] * w_phi * c * G * weight(local @ axes))

    def above_N(theta):
        """z = -sin(theta) sin(tilt) + cos(theta) cos(phi) cos(tilt) > 0"""
        return np.arccos(np.clip(np.tan(theta) * np.sin(tilt) / max(np.cos(tilt), 1e-12), 0, 1))

    lit = integral(
        -np.pi / 2 - min(tilt, 0),
        np.pi / 2 - max(tilt, 0),
        above_N,
        lambda omega_i: W(t, omega_i, omega_o, tangents, weights, gap, sigma),
    )
    low, high = domain(tilt)
    return lit / integral(low, high, lambda theta: np.full_like(theta, np.pi / 2), lambda omega_i: 1.0)


def domain(tilt):
    """The ends of theta_i of T and of I."""
    end = theta_end(tilt)
    return (-np.pi / 2, end) if tilt >= 0 else (-end, np.pi / 2)


def I_terms(xi, omega_o, sharpness, eta, k_d, gamma_s, gamma_v, segments, tilt=0.0):
    """(I_s, I_v / A) of one tangent, for xi [3] and omega_o [3] in its frame, by theta segments.   [Miz 11-16]"""
    (theta_k, phi_k), (theta_o, phi_o) = angles(xi), angles(omega_o)
    theta = np.linspace(-np.pi / 2, np.pi / 2, segments + 1)[1:-1]  # at the ends cos^2(theta_i) is 0, and so is h
    cos_theta_d = np.cos((theta - theta_o) / 2)
    kappa_prime = sharpness * np.cos(theta) * np.cos(theta_k)
    T = np.stack([T_l(l, phi_o, phi_k, kappa_prime) for l in range(11)], -1)
    common = np.cos(theta) ** 2 / cos_theta_d**2
    surface = common * np.sum(C_l(F_0(eta), cos_theta_d) * T[:, 1:7], -1)
    volume = common * np.sum(D_l(F_0(eta), cos_theta_d) * T, -1) / (np.cos(theta) + np.cos(theta_o))

    def integral(h, mu, width):
        nodes = np.linspace(-np.pi / 2, np.pi / 2, segments + 1)
        return line.piecewise(nodes, np.concatenate([[0.0], h, [0.0]]), mu, width, *domain(tilt))

    def lobe(h, gamma):
        mu, sharpness_3, alpha = g_c_product(theta_k, sharpness, -theta_o, 2 / (2 * gamma) ** 2)
        return alpha / (np.sqrt(np.pi) * gamma) * integral(h, mu, sigma_of_sharpness(sharpness_3))

    isotropic = integral(volume, theta_k, sigma_of_sharpness(sharpness))
    return lobe(surface, gamma_s), (1 - k_d) * lobe(volume, gamma_v) + k_d * isotropic


def L_o(omega_o, xi, sharpness, L, yarns, tangents, weights, gap, sigma, segments=6, T=T_W):
    """Radiance [3] toward omega_o [3] under K Gaussians: axes xi [K, 3], sharpness [K], radiance L [K, 3].   [Miz 7-16]

    `T` is called as T_W is; tests pass one that reads the tables. Other parameters as in `cloth.terms`.
    """
    out = np.zeros(3)
    for t, (yarn, tilt, _) in enumerate(tangents):
        o = tangent_from_surface(np.asarray(omega_o, float), yarn, np.cos(tilt), np.sin(tilt))
        if o[2] <= 0 or omega_o[2] <= 0:
            continue
        y = yarns[yarn]
        for xi_k, sharpness_k, L_k in zip(xi, sharpness, L, strict=True):
            i = tangent_from_surface(np.asarray(xi_k, float), yarn, np.cos(tilt), np.sin(tilt))
            I_s, I_v = I_terms(i, o, sharpness_k, y["eta"], y["k_d"], y["gamma_s"], y["gamma_v"], segments, tilt)
            weight = weights[t][0] * T(t, xi_k, omega_o, sharpness_k, tangents, weights, gap, sigma)
            out += L_k * weight * (I_s + np.asarray(y["A"]) * I_v)
    return out
