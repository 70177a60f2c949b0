"""Twin of glsl/sg/segments.glsl: integrals over theta segments (Mizutani et al. 2012, below Eq. 16), as printed, in float64."""

import numpy as np

from .erf import erf


def twice_integrated(u, gaussian):
    """exp(-u^2) integrated twice, element by element, given gaussian = exp(-u^2)."""
    u = np.asarray(u, float)
    return np.sqrt(np.pi) / 2 * u * erf(u) + np.asarray(gaussian) / 2


def segment_integrals(a, b, mu, sigma):
    """The integrals of g(theta; mu, sigma) and of theta g(theta; mu, sigma) over [a, b].   [Miz below 16]"""
    u_a, u_b = (np.asarray(a) - mu) / sigma, (np.asarray(b) - mu) / sigma
    I_0 = np.sqrt(np.pi) / 2 * sigma * (erf(u_b) - erf(u_a))
    return I_0, mu * I_0 + np.asarray(sigma) ** 2 / 2 * (np.exp(-(u_a**2)) - np.exp(-(u_b**2)))


def piecewise(theta, h, mu, sigma, low=-np.inf, high=np.inf):
    """The integral of g(theta; mu, sigma) times the polyline through (theta [S + 1], h [S + 1]) from low to high.
    [Miz below 16]"""
    theta, h = np.asarray(theta, float), np.asarray(h, float)
    a_s = np.diff(h) / np.diff(theta)
    b_s = h[:-1] - a_s * theta[:-1]
    ends = np.clip(theta, low, high)
    I_0, I_1 = segment_integrals(ends[:-1], ends[1:], mu, sigma)
    return np.sum(a_s * I_1 + b_s * I_0)


def hat(u, step):
    """The integral of exp(-t^2) times the hat over u with feet at u - step and u + step: a_s t + b_s on two segments."""
    I_0, I_1 = segment_integrals(u - step, u, 0.0, 1.0)
    J_0, J_1 = segment_integrals(u, u + step, 0.0, 1.0)
    return (I_1 - (u - step) * I_0) / step + ((u + step) * J_0 - J_1) / step


def hat_integral(before, here, after, u, gaussian, step):
    """`hat` where the step is small, and the second difference of twice_integrated, which equals it, elsewhere."""
    before, here, after, u, gaussian, step = (np.asarray(x, float) for x in (before, here, after, u, gaussian, step))
    second_difference = (before - 2 * here + after) / step
    small = step < 0.2
    # Where the shader calls this, gaussian is exp(-u^2), and the quotient 1.
    scale = gaussian / np.exp(-(np.where(small, u, 0.0) ** 2))
    return np.where(small, hat(u, step) * scale, second_difference)


def cut_integrated(u, gaussian, over, slope):
    """exp(-u^2) that ends where its integral is `slope`, integrated twice: `over` is how far behind the end."""
    return twice_integrated(u, gaussian) + np.asarray(slope) * np.asarray(over)


def cut_hat(u, step, left):
    """`hat` of exp(-t^2) that ends at u + left * step."""
    end = u + step * np.clip(left, -1, 1)
    I_0, I_1 = segment_integrals(u - step, np.minimum(u, end), 0.0, 1.0)
    J_0, J_1 = segment_integrals(u, np.maximum(u, end), 0.0, 1.0)
    return (I_1 - (u - step) * I_0) / step + ((u + step) * J_0 - J_1) / step


def cut_hat_integral(before, here, after, u, gaussian, step, left):
    """`cut_hat` where the step is small and the end is near, and `hat_integral` elsewhere; u is the node or, before it, the
    end."""
    u, gaussian, step, left = (np.asarray(x, float) for x in (u, gaussian, step, left))
    left = left[..., None]
    small = np.maximum(5 * step, left) < 1
    node = np.where(small, u - step * np.minimum(left, 0), 0.0)
    near = cut_hat(node, np.where(small, step, 0.1), left) * gaussian / np.exp(-(np.where(small, u, 0.0) ** 2))
    return np.where(small, near, hat_integral(before, here, after, u, gaussian, step))
