"""Paper A's closed forms against their definitions and against quadrature, in float64."""

import numpy as np
import pytest

from glcloth.fabric import load_fabric
from glcloth.twins import azimuth, convolution, coordinates, fresnel, fresnel_sum, gaussian, quadrature, segments
from glcloth.twins.frame import tangent_from_surface
from glcloth.twins.quadrature import graded
from glcloth.twins.scatter import f_s

DEG = np.pi / 180


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def directions(rng, count):
    v = rng.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def unit(theta, phi):
    """(omega . t, omega . b, omega . n)"""
    parts = np.sin(theta), np.cos(theta) * np.sin(phi), np.cos(theta) * np.cos(phi)
    return np.stack(np.broadcast_arrays(*parts), -1)


def test_a_spherical_gaussian_is_exactly_two_circular_ones(rng):
    """[Miz 10]"""
    theta_i, theta_k = rng.uniform(-1.57, 1.57, (2, 1000))
    phi_i, phi_k = rng.uniform(-np.pi, np.pi, (2, 1000))
    sigma = np.exp(rng.uniform(np.log(0.03), np.log(2), 1000))
    whole = gaussian.G_sg(unit(theta_i, phi_i), unit(theta_k, phi_k), sigma)
    factors = gaussian.g_c(theta_i, theta_k, sigma)
    factors = factors * gaussian.g_c(phi_i, phi_k, gaussian.sigma_k_prime(sigma, theta_i, theta_k))
    assert np.allclose(whole, factors, rtol=1e-10, atol=1e-300)


def test_the_product_of_circular_gaussians_is_one(rng):
    """[Miz 17, erratum E1]; with sigma_3 as printed the product would differ."""
    mu_1, mu_2, x = rng.uniform(-np.pi, np.pi, (3, 2000))
    sigma_1, sigma_2 = np.exp(rng.uniform(np.log(0.05), np.log(2), (2, 2000)))
    mu_3, sharpness_3, alpha = gaussian.g_c_product(mu_1, 2 / sigma_1**2, mu_2, 2 / sigma_2**2).T
    product = gaussian.g_c(x, mu_1, sigma_1) * gaussian.g_c(x, mu_2, sigma_2)
    assert np.allclose(product, alpha * gaussian.g_c(x, mu_3, np.sqrt(2 / sharpness_3)), rtol=1e-9, atol=1e-300)
    printed = (sharpness_3 / 2) ** -1.0  # 1 / sqrt(m^2 + n^2)
    assert not np.allclose(product, alpha * gaussian.g_c(x, mu_3, printed), rtol=0.5)


def test_the_widened_gaussian_is_near_the_lobe_when_narrow():
    """[Miz below 10]  g^u(theta_h; 0, gamma) ~ g^c(theta_i; -theta_o, 2 gamma) / (sqrt(pi) gamma): 1 % of the area at
    10 degrees, 17 % at 60."""
    x = np.linspace(-np.pi, np.pi, 20001)
    for gamma_deg, error in ((5, 0.003), (10, 0.009), (60, 0.18)):
        gamma = gamma_deg * DEG
        exact, circular = (np.trapezoid(f, x) for f in (gaussian.g(x, 0, 2 * gamma), gaussian.g_c(x, 0, 2 * gamma)))
        assert abs(circular / exact - 1) < error


def test_segment_integrals_against_quadrature(rng):
    """[Miz below 16]"""
    x, w = np.polynomial.legendre.leggauss(200)
    for _ in range(50):
        a, b = np.sort(rng.uniform(-np.pi / 2, np.pi / 2, 2))
        mu, sigma = rng.uniform(-2, 2), np.exp(rng.uniform(np.log(0.05), np.log(3)))
        at = (a + b) / 2 + (b - a) / 2 * x
        g = gaussian.g(at, mu, sigma) * w * (b - a) / 2
        assert np.allclose(
            segments.segment_integrals(a, b, mu, sigma), (g.sum(), (g * at).sum()), rtol=1e-9, atol=1e-14
        )


def test_hats_add_up_to_the_segments(rng):
    """The shader's sum over nodes is the paper's sum over segments, for any polyline that ends at zero."""
    for count in (2, 3, 6, 16, 64):
        h = np.concatenate([[0], rng.uniform(0, 1, count - 1), [0]])
        theta = np.linspace(-np.pi / 2, np.pi / 2, count + 1)
        for sigma in (0.04, 0.3, 2.0):
            mu = rng.uniform(-1.5, 1.5)
            u, step = (theta - mu) / sigma, np.pi / count / sigma
            I_2 = segments.twice_integrated(u, np.exp(-u * u))
            weight = sigma * segments.hat_integral(I_2[:-2], I_2[1:-1], I_2[2:], u[1:-1], np.exp(-(u[1:-1] ** 2)), step)
            assert (h[1:-1] * weight).sum() == pytest.approx(
                segments.piecewise(theta, h, mu, sigma), rel=1e-9, abs=1e-13
            )


def test_polynomials_are_schlicks_fresnel(rng):
    """[Miz 13]"""
    F_0, cos_theta_d, x = rng.uniform(0, 0.25, 500), rng.uniform(0, 1, 500), rng.uniform(0, 1, 500)
    F_r = fresnel.F_schlick(F_0, cos_theta_d * x)
    assert np.allclose(np.sum(fresnel_sum.C_l(F_0, cos_theta_d) * x[:, None] ** np.arange(6), -1), F_r, atol=1e-13)
    transmitted = np.sum(fresnel_sum.D_l(F_0, cos_theta_d) * x[:, None] ** np.arange(11), -1)
    assert np.allclose(transmitted, (1 - F_r) ** 2, atol=1e-12)


def test_the_azimuth_mass_in_closed_form():
    """What glsl/sg/azimuth.glsl computes by erf, here by the definition; also past 90 degrees, where |cos| folds."""
    from glcloth.twins.erf import erf

    phi_k, kappa = (a.ravel() for a in np.meshgrid(np.linspace(0, np.pi, 19), np.geomspace(1e-4, 1e3, 15)))
    r = np.sqrt(2 * kappa)
    near, far = erf(r * np.sin(np.pi / 4 - phi_k / 2)), erf(r * np.sin(np.pi / 4 + phi_k / 2))
    mass = np.where(phi_k <= np.pi / 2 + 1e-12, near + far, near + 2 * erf(r) - far) * np.sqrt(np.pi / 2 / kappa)
    assert np.allclose(azimuth.azimuth_mass(phi_k, kappa), mass, rtol=1e-6, atol=1e-12)


def test_coordinates_and_their_inverses():
    x = np.linspace(0, 1, 101)
    for there, back in (
        (coordinates.unit_from_half_circle, coordinates.half_circle_from_unit),
        (lambda a: coordinates.unit_from_circle(a, 0.7), lambda u: coordinates.circle_from_unit(u, 0.7)),
        (lambda k: coordinates.unit_from_kappa(k, 2000.0), lambda u: coordinates.kappa_from_unit(u, 2000.0)),
    ):
        assert np.allclose(there(back(x)), x, atol=1e-12)
    levels = np.linspace(0, 15, 61)
    sharpness = coordinates.sharpness_from_level(levels, 0.5, 1500.0, 16)
    assert np.allclose(coordinates.level_from_sharpness(sharpness, 0.5, 1500.0, 16), levels, atol=1e-12)
    assert coordinates.level_from_sharpness(1e6, 0.5, 1500.0, 16) == 15
    assert np.allclose(coordinates.node_coordinate(x * 0 + [0.0], 48), 0.5 / 48)


def test_many_segments_converge_to_the_integral(rng):
    """[Miz 11-16]  I_s and I_v with 200 segments against quadrature of G f_s cos(theta_i) over the tangent's
    hemisphere, where the lobes are narrow enough for circular Gaussians."""
    x, w = np.polynomial.legendre.leggauss(64)
    for _ in range(6):
        theta_k, theta_o = rng.uniform(-0.6, 0.6, 2)
        phi_k, phi_o = rng.uniform(-1, 1, 2)
        sharpness = np.exp(rng.uniform(np.log(8), np.log(80)))
        fibre = (1.5, 0.3, 5 * DEG, 8 * DEG)
        xi, omega_o = unit(theta_k, phi_k), unit(theta_o, phi_o)
        I = convolution.I_terms(xi, omega_o, sharpness, *fibre, segments=200)
        theta, w_theta = graded(-np.pi / 2, np.pi / 2, [-theta_o, theta_k], [0.1, 0.2], 30)
        phi, w_phi = np.pi / 2 * x, np.pi / 2 * w
        omega_i = unit(theta[:, None], phi)
        G = np.exp(sharpness * (omega_i @ xi - 1))
        f = f_s(omega_i, np.broadcast_to(omega_o, omega_i.shape), *fibre)
        exact = np.einsum("i,j,ij,ijc->c", w_theta * np.cos(theta) ** 2, w_phi, G, f)
        assert np.allclose(I, exact, rtol=0.04)


def test_T_is_the_mean_of_W_under_a_gaussian(rng):
    """[Miz 9]  The graded quadrature in the tangent's frame against plain sums over the sphere."""
    fabric = (
        [(0, -25 * DEG, 1), (0, 40 * DEG, 1), (1, 10 * DEG, 1)],
        np.array([[1.0, 0.3], [1.0, 0.2], [1.0, 0.4]]),
        0.1,
    )
    z, azimuths = np.linspace(-1, 1, 250, endpoint=False) + 1 / 250, (np.arange(250) + 0.5) * 2 * np.pi / 250
    r = np.sqrt(1 - z * z)
    omega_i = np.stack(
        [np.outer(r, np.cos(azimuths)), np.outer(r, np.sin(azimuths)), np.outer(z, 1 + 0 * azimuths)], -1
    )
    checked = 0
    for xi, omega_o, sharpness in zip(
        directions(rng, 12), directions(rng, 12), np.tile([0.5, 5.0, 50.0], 4), strict=True
    ):
        omega_o = omega_o * np.sign(omega_o[2])
        t = checked % 3
        yarn, tilt, _ = fabric[0][t]
        local, (low, high) = tangent_from_surface(omega_i, yarn, np.cos(tilt), np.sin(tilt)), convolution.domain(tilt)
        inside = (local[..., 2] > 0) & (local[..., 0] > np.sin(low)) & (local[..., 0] < np.sin(high))
        G = np.exp(sharpness * (omega_i @ xi - 1)) * inside
        if G.max() < 1e-3:
            continue
        sums = np.sum(G * convolution.W(t, omega_i, omega_o, *fabric, 20 * DEG)) / G.sum()
        T = convolution.T_W(t, xi, omega_o, sharpness, *fabric, 20 * DEG, panels=12)
        # The sums see both horizons as steps of half a degree.
        assert T == pytest.approx(sums, rel=7e-3, abs=1e-5)
        checked += 1
    assert checked > 6


def test_brute_force_T_against_independent_values(shared):
    """[Miz 9]  kt_T of the golden file."""
    from test_truth import golden_case

    data = np.load(shared / "golden" / "microcylinder.npz")
    checked = 0
    for s in (0, 25, 50):
        _, tangents, weights = golden_case(data, s)
        for k in (0, 4, 7):
            for t, (yarn, tilt, _) in enumerate(tangents):
                local = tangent_from_surface(data["wo"][s], yarn, np.cos(tilt), np.sin(tilt))
                if local[2] <= 0 or data["kt_intG"][s, k, t] < 1e-5 or data["kt_T"][s, k, t] < 1e-6:
                    continue
                args = t, data["xi"][s, k], data["wo"][s], float(data["kappa"][s, k])
                T = convolution.T_W(*args, tangents, weights["L_ref"], 0.0, float(data["sigma_MP"]), 16)
                assert T == pytest.approx(data["kt_T"][s, k, t], rel=5e-3)
                checked += 1
    assert checked > 12


def test_the_split_of_upright_tangents_is_near_the_integral(rng):
    """[Miz 8-9]  T times I of velvet's tangents from 50 to 90 degrees, light from anywhere; with the whole hemisphere of the
    tangent as the domain of I it is up to a hundred times too much."""
    fabric = load_fabric("velvet").arrays()
    yarn = fabric[0][0]
    lobes = yarn["eta"], yarn["k_d"], yarn["gamma_s"], yarn["gamma_v"]
    errors = []
    for xi, omega_o, sharpness in zip(directions(rng, 10), directions(rng, 10), [3, 10, 30, 60, 100] * 2, strict=True):
        omega_o = omega_o * np.sign(omega_o[2])
        exact = quadrature.integrals(omega_o, xi, sharpness, *fabric, panels=8) @ (1.0, 0.1)
        split = []
        for t, (j, tilt, _) in enumerate(fabric[1]):
            o, i = (tangent_from_surface(omega, j, np.cos(tilt), np.sin(tilt)) for omega in (omega_o, xi))
            I_s, I_v = convolution.I_terms(i, o, sharpness, *lobes, 24, tilt) if o[2] > 0 else (0, 0)
            weight = fabric[2][t, 0] * convolution.T_W(t, xi, omega_o, sharpness, *fabric[1:], panels=6)
            split.append(weight * (I_s + 0.1 * I_v))
        errors.append(sum(split) / exact.sum() - 1)
    assert np.median(np.abs(errors)) < 0.2 and np.max(errors) < 0.8, np.round(errors, 2)
