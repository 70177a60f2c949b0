"""Fit spherical Gaussians to spherical-harmonics coefficients by weighted least squares. All [own] unless cited.

Cloth sees an environment through a linear operator, so over random frames the mean squared error of its shading is
exactly sum_l q_l sum_m |r_lm|^2 of the residual r, with one weight q_l per degree (see fit.py). That is the loss here:

    Phi = sum_c sum_lm q_l (L_lm,c - sum_k a_kc c_l(lam_k) Y_lm(xi_k))^2,   a >= 0

with the flux a_kc of lobe k, and c_l of harmonics.gaussian_bands. Axes and sharpness start greedily and are improved by
variable projection (Golub and Pereyra 1973): the fluxes are the exact non-negative solution at every step, so by the
envelope theorem the gradient needs no derivative of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from .harmonics import Evaluation, degrees_of, gaussian_bands, harmonics

SHARPNESS_RANGE = (0.5, 1000.0)
_CANDIDATES = 600
_CANDIDATE_SHARPNESS = 2.0 ** np.arange(9)
ITERATIONS = 150


def fibonacci(n: int) -> np.ndarray:
    """n well-spread unit directions [n, 3].   [Swinbank and Purser 2006]"""
    i = np.arange(n) + 0.5
    y = 1 - 2 * i / n
    r, phi = np.sqrt(1 - y * y), np.pi * (1 + 5**0.5) * i
    return np.stack([r * np.cos(phi), y, r * np.sin(phi)], -1)


@lru_cache(maxsize=2)
def _candidate_harmonics(l_max: int) -> np.ndarray:
    return np.ascontiguousarray(harmonics(fibonacci(_CANDIDATES), l_max))


class Problem:
    """One fit: the target coefficients [J, 3] and the weights q [l_max + 1]."""

    def __init__(self, target: np.ndarray, q: np.ndarray):
        self.l_max = len(q) - 1
        self.l = degrees_of(self.l_max)
        # Everything below is in the scaled space sqrt(q) L_lm, where the loss is a plain square.
        self.root = np.sqrt(q)
        self.target = target * self.root[self.l, None]
        self.whole = float(np.square(self.target).sum())

    def columns(self, axis: np.ndarray, sharpness: np.ndarray) -> np.ndarray:
        """Scaled coefficients [J, K] of unit-flux lobes."""
        c, _ = gaussian_bands(sharpness, self.l_max)
        return Evaluation(axis, self.l_max).Y * (c * self.root).T[self.l]

    def fluxes(self, V: np.ndarray) -> np.ndarray:
        """The non-negative fluxes [K, 3] of least loss for columns V [J, K]."""
        from scipy.optimize import nnls  # a fit that is kept needs none of it

        H, h = V.T @ V, V.T @ self.target
        s = 1 / np.sqrt(np.diag(H))
        # Two lobes may coincide on the way; a trace of damping keeps the factor finite and costs 1e-9 of the loss.
        factor = np.linalg.cholesky(H * s[:, None] * s + 1e-9 * np.eye(len(s)))
        right = np.linalg.solve(factor, h * s[:, None])
        return np.stack([nnls(factor.T, right[:, c], maxiter=50 * len(s))[0] for c in range(3)], -1) * s[:, None]

    def loss(self, V: np.ndarray, flux: np.ndarray) -> float:
        """Phi relative to the loss of no lobes at all."""
        return float(np.square(self.target - V @ flux.astype(V.dtype)).sum()) / max(self.whole, 1e-300)

    def greedy(self, axis: np.ndarray, sharpness: np.ndarray, count: int, step: Callable) -> tuple:
        """Add lobes until there are `count`: each time the candidate that lowers the loss most by itself."""
        Y = _candidate_harmonics(self.l_max)
        directions = fibonacci(_CANDIDATES)
        c, _ = gaussian_bands(_CANDIDATE_SHARPNESS, self.l_max)
        bands = (c * self.root).T[self.l]  # [J, S]
        norm = (np.square(c * self.root) * (2 * np.arange(self.l_max + 1) + 1)).sum(-1) / (4 * np.pi)
        taken = np.zeros((len(Y), len(norm)), bool)
        V = self.columns(axis, sharpness) if len(sharpness) else np.zeros((len(self.l), 0))
        while len(sharpness) < count:
            step()
            residual = self.target - (V @ self.fluxes(V) if len(sharpness) else 0.0)
            gain = Y @ (residual[:, None, :] * bands[:, :, None]).reshape(len(Y[0]), -1)
            score = np.square(np.maximum(gain.reshape(len(Y), len(norm), 3), 0.0)).sum(-1) / norm
            score[taken] = -1.0
            n, i = np.unravel_index(int(np.argmax(score)), score.shape)
            taken[n, i] = True
            axis = np.concatenate([axis, directions[n : n + 1]])
            sharpness = np.append(sharpness, _CANDIDATE_SHARPNESS[i])
            V = np.concatenate([V, (Y[n] * bands[:, i])[:, None]], 1)
        return axis, sharpness

    def value_and_gradient(self, p: np.ndarray) -> tuple[float, np.ndarray]:
        """Relative Phi at p = (unnormalised axes [3 K], ln sharpness [K]) and its gradient [4 K]."""
        K = len(p) // 4
        u = p[: 3 * K].reshape(K, 3)
        length = np.linalg.norm(u, axis=1, keepdims=True)
        xi, lam = u / length, np.exp(p[3 * K :])
        e = Evaluation(xi, self.l_max)
        c, slope = gaussian_bands(lam, self.l_max)
        bands = (c * self.root).T[self.l]
        V = e.Y * bands
        a = self.fluxes(V)
        R = self.target - V @ a
        # The fluxes are optimal (or held at 0), so only V's own change counts: dPhi = -2 sum R . dV a.
        G = -2 * R @ a.T
        by_log_sharpness = np.einsum("jk,jk->k", G * e.Y, (slope * self.root).T[self.l])
        by_axis = e.gradient(G * bands)
        by_axis = (by_axis - (by_axis * xi).sum(1, keepdims=True) * xi) / length
        scale = 1 / max(self.whole, 1e-300)
        return np.square(R).sum() * scale, np.concatenate([by_axis.ravel(), by_log_sharpness]) * scale

    def refine(self, axis: np.ndarray, sharpness: np.ndarray, iterations: int, step: Callable) -> tuple:
        """Improve all axes and sharpnesses together by L-BFGS-B; return (axis, sharpness, loss)."""
        from scipy.optimize import minimize

        K = len(sharpness)
        low, high = np.log(SHARPNESS_RANGE)
        start = np.concatenate([axis.ravel(), np.clip(np.log(sharpness), low, high)])
        result = minimize(
            self.value_and_gradient,
            start,
            jac=True,
            method="L-BFGS-B",
            bounds=[(None, None)] * (3 * K) + [(low, high)] * K,
            options={"maxiter": iterations, "maxcor": 20, "ftol": 1e-10, "gtol": 1e-10},
            callback=lambda _: step(),
        )
        u = result.x[: 3 * K].reshape(K, 3)
        return u / np.linalg.norm(u, axis=1, keepdims=True), np.exp(result.x[3 * K :]), float(result.fun)


def fit_lobes(
    target: np.ndarray, q: np.ndarray, count: int, swaps: int = 3, step: Callable[[], None] = lambda: None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Fit `count` spherical Gaussians to coefficients `target` [(l_max + 1)^2, 3] with weights q [l_max + 1].

    `swaps` times the least useful lobe is taken out, a new one put where the residual is largest, and all are refined
    again, as long as that lowers the loss by a hundredth. `step` is called at every step (progress). Deterministic.
    Returns (axis [K, 3], sharpness [K], flux [K, 3], loss relative to no lobes).
    """
    problem = Problem(target, q)
    axis, sharpness = problem.greedy(np.zeros((0, 3)), np.zeros(0), count, step)
    axis, sharpness, loss = problem.refine(axis, sharpness, ITERATIONS, step)
    for _ in range(swaps if count > 1 else 0):
        keep = _without_least_useful(problem, axis, sharpness)
        trial = problem.refine(*problem.greedy(axis[keep], sharpness[keep], count, step), ITERATIONS, step)
        if trial[2] > 0.99 * loss:
            break
        axis, sharpness, loss = trial
    V = problem.columns(axis, sharpness)
    flux = problem.fluxes(V)
    # Brightest first: a table people read, and a stable order.
    order = np.argsort(-flux.sum(axis=1), kind="stable")
    return axis[order], sharpness[order], flux[order], problem.loss(V, flux)


def _without_least_useful(problem: Problem, axis: np.ndarray, sharpness: np.ndarray) -> np.ndarray:
    """Mask [K] of all lobes but the one whose loss is least missed."""
    V = problem.columns(axis, sharpness)
    everything = np.arange(len(sharpness))
    losses = [problem.loss(V[:, everything != k], problem.fluxes(V[:, everything != k])) for k in everything]
    return everything != int(np.argmin(losses))
