"""Spherical harmonics against quadrature and against SciPy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import sph_harm_y, spherical_in

from glcloth.light import equirect, harmonics
from glcloth.light.harmonics import Evaluation, gaussian_bands, power, project_gaussians, synthesize, transform


def sphere_quadrature(n):
    """Directions [N, 3] and weights [N], exact for polynomials up to degree 2 n - 1 (Gauss-Legendre by trapezium)."""
    y, w = np.polynomial.legendre.leggauss(n)
    phi = 2 * np.pi * np.arange(2 * n) / (2 * n)
    r = np.sqrt(1 - y * y)[:, None]
    omega = np.stack([r * np.sin(phi), np.repeat(y[:, None], 2 * n, 1), -r * np.cos(phi)], -1).reshape(-1, 3)
    return omega, np.repeat(w * np.pi / n, 2 * n)


def random_directions(n, seed=0):
    omega = np.random.default_rng(seed).normal(size=(n, 3))
    return omega / np.linalg.norm(omega, axis=-1, keepdims=True)


def test_orthonormal_to_degree_32():
    omega, weight = sphere_quadrature(34)
    Y = harmonics.harmonics(omega, 32)
    assert Y.shape[-1] == 33**2
    assert np.abs((Y * weight[:, None]).T @ Y - np.eye(33**2)).max() < 1e-12


def test_agrees_with_scipy():
    """Real harmonics from SciPy's complex ones, which have the Condon-Shortley phase (-1)^m."""
    omega = np.concatenate([random_directions(40), [[0, 1, 0], [0, -1, 0], [0, 0, -1], [1e-9, 1, 0]]])
    theta = np.arctan2(np.hypot(omega[:, 0], omega[:, 2]), omega[:, 1])
    phi = np.arctan2(omega[:, 0], -omega[:, 2])
    Y = harmonics.harmonics(omega, 20)
    for l in range(21):
        for m in range(-l, l + 1):
            complex_value = (-1) ** m * sph_harm_y(l, abs(m), theta, phi)
            part = complex_value.real if m >= 0 else complex_value.imag
            expected = part * (2**0.5 if m else 1)
            assert np.allclose(Y[:, l * (l + 1) + m], expected, atol=1e-10), (l, m)


def test_stable_at_the_poles_and_high_degrees():
    """Sum over m of Y^2 is (2 l + 1) / 4 pi everywhere (addition theorem)."""
    omega = np.array([[0, 1, 0], [0, -1, 0], [1e-12, 1, 1e-12], [1e-5, -1, 0], [0.6, 0.8, 0], [0, 0, 1]], float)
    omega /= np.linalg.norm(omega, axis=-1, keepdims=True)
    for l_max in (0, 1, 2, 32, 64):
        assert np.allclose(
            power(harmonics.harmonics(omega, l_max).T),
            ((2 * np.arange(l_max + 1) + 1) / (4 * np.pi))[:, None],
            rtol=1e-11,
        )


def test_gradient_against_differences():
    omega = np.concatenate([random_directions(6, 1), [[0, 1, 0]]])
    G = np.random.default_rng(2).normal(size=((12 + 1) ** 2, 7))
    got = Evaluation(omega, 12).gradient(G)
    for axis, expected in enumerate(np.eye(3)):
        # Along the sphere only: the extension off it is not the same function.
        step = expected - omega * omega[:, axis : axis + 1]
        up, down = (omega + sign * 1e-6 * step for sign in (1, -1))
        up, down = (d / np.linalg.norm(d, axis=-1, keepdims=True) for d in (up, down))
        slope = ((Evaluation(up, 12).Y - Evaluation(down, 12).Y) * G).sum(0) / 2e-6
        assert np.allclose(slope, np.einsum("ni,ni->n", got, step), rtol=1e-6, atol=1e-5)


def test_transform_inverts_synthesis():
    coefficients = np.random.default_rng(3).normal(size=(21**2, 2))
    back = transform(synthesize(coefficients, 256, 512), 20)
    # Texel centres stand for texels: (l pi / 256)^2 / 24 at l = 20.
    assert np.abs(back - coefficients).max() < 0.02
    assert np.abs(back - coefficients)[:36].max() < 2e-3
    omega = random_directions(50, 4)
    assert np.allclose(
        equirect.lookup(synthesize(coefficients[:25], 256, 512), omega),
        harmonics.harmonics(omega, 4) @ coefficients[:25],
        atol=2e-3,
    )


@pytest.mark.parametrize("shape", [(3, 5), (16, 32), (40, 41), (256, 512), (600, 1200)])
def test_transform_of_any_size_keeps_the_total(shape):
    radiance = np.random.default_rng(5).random((*shape, 3))
    c = transform(radiance)
    assert np.allclose(c[0] * np.sqrt(4 * np.pi), equirect.total(radiance), rtol=1e-12)


@pytest.mark.parametrize("sharpness", [1e-9, 1e-3, 0.5, 3.0, 40.0, 1000.0, 6e4])
def test_gaussian_coefficients_against_quadrature(sharpness):
    """c_l is the integral of 2 pi exp(lam (x - 1)) P_l(x) over the lobe's flux: a Gauss-Legendre integral in x."""
    c, _ = gaussian_bands(np.array([sharpness]), 32)
    low = max(-1.0, 1 - 60 / sharpness)
    x, w = np.polynomial.legendre.leggauss(200)
    x, w = (x * (1 - low) + 1 + low) / 2, w * (1 - low) / 2
    density = np.exp(sharpness * (x - 1)) * w
    P = np.polynomial.legendre.legvander(x, 32)
    assert np.allclose(c[0], density @ P / density.sum(), rtol=1e-9, atol=1e-12)


def test_gaussian_bands_are_bessel_ratios_with_their_slope():
    lam = np.geomspace(1e-3, 500, 30)
    c, slope = gaussian_bands(lam, 16)
    expected = np.stack([spherical_in(l, lam) / spherical_in(0, lam) for l in range(17)], -1)
    assert np.allclose(c, expected, rtol=1e-9)
    up, down = (gaussian_bands(lam * np.exp(s), 16)[0] for s in (1e-5, -1e-5))
    assert np.allclose(slope, (up - down) / 2e-5, rtol=1e-6, atol=1e-9)


def test_projected_gaussian_against_a_map():
    """Coefficients of a lobe in closed form and through a sampled map agree."""
    axis, lam, flux = np.array([[0.2, 0.5, -0.7]]) / np.sqrt(0.78), np.array([25.0]), np.array([[2.0, 1.0, 0.5]])
    omega = equirect.texel_directions(256, 512)
    radiance = np.exp(lam * (omega @ axis[0] - 1))[..., None] * flux / harmonics.gaussian_flux(lam)
    assert np.abs(transform(radiance, 16) - project_gaussians(axis, lam, flux, 16)).max() < 2e-4
    assert np.allclose(equirect.total(radiance), flux[0], rtol=1e-4)


def test_power_is_invariant_under_rotation():
    axis, flux = random_directions(5, 6), np.random.default_rng(7).random((5, 3))
    lam = np.geomspace(1, 300, 5)
    rotation = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix()
    before, after = (project_gaussians(a, lam, flux) for a in (axis, axis @ rotation.T))
    assert np.allclose(power(before), power(after), rtol=1e-9, atol=1e-15)


def test_nothing_projects_to_nothing():
    none = np.zeros((0, 3))
    assert not harmonics.project_directions(none, none).any()
    assert not project_gaussians(none, np.zeros(0), none).any()
