"""Twin of glsl/woven/sheet.glsl: a sheet of woven cloth (paper B Eq. 1), in float64."""

import numpy as np

from .ggx import F_interface, f_GGX, f_straight


def T_open(omega, rho):
    """The share of light along omega [..., 3] that meets no yarn.   [own]"""
    omega = np.asarray(omega, float)
    q = 1 - np.sqrt(1 - np.asarray(rho, float))
    z = np.maximum(np.abs(omega[..., 2]), 1e-12)
    cos_a = z / np.maximum(np.hypot(omega[..., 1], omega[..., 2]), 1e-12)
    cos_b = z / np.maximum(np.hypot(omega[..., 0], omega[..., 2]), 1e-12)
    return np.maximum(0, 1 - q / cos_a) * np.maximum(0, 1 - q / cos_b)


def open_at(open, hole, mean):
    """The share of light that meets no yarn where `hole` of a place is a hole; its mean over the cloth is `open`.   [own]"""
    open, hole, mean = (np.asarray(x, float) for x in (open, hole, mean))
    more = 1 - (1 - open) * (1 - hole) / np.maximum(1 - mean, 1e-6)
    return np.where(open <= mean, open * hole / np.maximum(mean, 1e-6), more)


def covered(omega_i, omega_o, rho):
    """The share of the yarns' term: the smaller of 1 - T_open of the two directions.   [own]"""
    return np.minimum(1 - T_open(omega_i, rho), 1 - T_open(omega_o, rho))


def absorption(omega_i, omega_o, tau):
    """exp(-tau) along half of the layer in each direction, [..., 3].   [Mat 1]"""
    z_i, z_o = (np.maximum(np.abs(np.asarray(o, float)[..., 2]), 0.1) for o in (omega_i, omega_o))
    return np.exp(-np.asarray(tau, float) * ((1 / z_i + 1 / z_o) / 2)[..., None])


def f_yarn(omega_i, omega_o, roughness, eta_1, eta_2, diffuse, roughness_p):
    """1/2 diffuse transmission + 1/2 directed transmission, 1/sr.   [Mat 1]"""
    f_t = (1 - diffuse) * f_GGX(omega_i, omega_o, roughness, eta_1, eta_2) + diffuse / np.pi
    f = 0.5 * f_t + 0.5 * f_straight(omega_i, omega_o, roughness_p)
    return np.where((np.asarray(omega_i)[..., 2] > 0) & (np.asarray(omega_o)[..., 2] < 0), f, 0.0)


def f_through(omega_i, omega_o, k_t, rho, roughness, eta_1, eta_2, diffuse, roughness_p):
    """The yarns' term without its absorption: covered k_t f_yarn cos_nl, 1/sr.   [Mat 1]"""
    f = f_yarn(omega_i, omega_o, roughness, eta_1, eta_2, diffuse, roughness_p)
    return covered(omega_i, omega_o, rho) * k_t * f * np.maximum(np.asarray(omega_i, float)[..., 2], 0)


def T_sheet(omega, k_a, k, tau, rho):
    """The part of a ray that goes on straight, [..., 3].   [Mat 1]"""
    open_ = T_open(omega, rho)
    through = (np.asarray(k) * (1 - open_))[..., None] * absorption(omega, omega, tau)
    return (np.asarray(k_a) * open_)[..., None] + through


def T_sheet_at(omega, k_a, k, tau, rho, hole, mean):
    """The same at a place of which `hole` is a hole, [..., 3].   [own]"""
    open_ = open_at(T_open(omega, rho), hole, mean)
    through = (np.asarray(k) * (1 - open_))[..., None] * absorption(omega, omega, tau)
    return (np.asarray(k_a) * open_)[..., None] + through


def R_sheet(omega, k_t, rho, eta_1, eta_2):
    """The part of a ray that the yarns mirror.   [own]"""
    cos = np.abs(np.asarray(omega, float)[..., 2])
    return (1 - T_open(omega, rho)) * (1 - np.asarray(k_t)) * F_interface(cos, eta_1, eta_2)


def R_limited(R, T, albedo):
    """What is mirrored, at most what T and the albedo [..., 3] leave.   [own]"""
    return np.clip((1 - np.asarray(T) - np.asarray(albedo)).min(-1), 0.0, R)


def diffuse_transmittance(x):
    """What passes of even light by a depth x on the way: 2 E_3(x), fitted.   [own]"""
    x = np.asarray(x, float)
    return np.exp(-x * (1 + 1 / (1 + 0.934 * np.maximum(x, 0) ** 0.665)))


def f_lambert(omega_i, omega_o, k_t, tau, rho, diffuse):
    """The Lambertian share of the yarns' term of one light, absorption and cosine included, [..., 3], 1/sr.   [own]"""
    omega_i, omega_o = np.asarray(omega_i, float), np.asarray(omega_o, float)
    share = covered(omega_i, omega_o, rho) * k_t * np.maximum(omega_i[..., 2], 0) * diffuse / (2 * np.pi)
    crosses = (omega_i[..., 2] > 0) & (omega_o[..., 2] < 0)
    return np.where(crosses, share, 0.0)[..., None] * absorption(omega_i, omega_o, tau)


def T_straight(omega, k_a, k_t, tau, rho, diffuse):
    """What goes on straight, of the energy split, [..., 3].   [own]"""
    return T_sheet(omega, k_a, np.asarray(k_t) * (1 - np.asarray(diffuse) / 2), tau, rho)


def holes_of_even_light(open, rho):
    """The larger T_open of a direction, `open`, and of even light, in the mean over its half space; fitted.   [own]"""
    most = np.maximum(1 - np.asarray(rho, float), 1e-6)
    s = np.sqrt(most)
    return most * (s + (1 - s) * np.minimum(open / most, 1) ** (1 / (1 - 0.78 * s)))


def T_lambert(omega, k_t, tau, rho, diffuse):
    """What passes evenly, [..., 3]: radiance T_lambert E / pi of the irradiance E behind.   [own]"""
    omega, tau = np.asarray(omega, float), np.asarray(tau, float)
    share = (1 - holes_of_even_light(T_open(omega, rho), rho)) * k_t * diffuse / 2
    slant = np.maximum(np.abs(omega[..., 2]), 0.1)[..., None]
    return share[..., None] * diffuse_transmittance(tau / 2) * np.exp(-tau / 2 / slant)


def R_beside(omega, k_a, k_t, tau, rho, diffuse, eta_1, eta_2, albedo):
    """What a layer mirrors toward omega of the light of one direction, where it reflects `albedo` of even light.   [own]"""
    T = T_straight(omega, k_a, k_t, tau, rho, diffuse) + T_lambert(omega, k_t, tau, rho, diffuse)
    return R_limited(R_sheet(omega, k_t, rho, eta_1, eta_2), T, albedo)
