"""A slow tracer in NumPy and float64: every ray meets every triangle, and calls itself for what it causes."""

import numpy as np

from glcloth.tracing.energy import mean_albedo, reflection_limit
from glcloth.twins import sheet
from glcloth.twins.cloth import f_cloth
from glcloth.twins.shading_frame import facing_normal, orthogonal_part

FACING = 0.02
OFF = 1e-4


def meet(origin, direction, triangles):
    """(t [N, T], v, w): every ray with every triangle; inf = miss."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    e_1, e_2 = b - a, c - a
    p = np.cross(direction[:, None], e_2[None])
    det = (e_1 * p).sum(-1)
    s = origin[:, None] - a[None]
    with np.errstate(divide="ignore", invalid="ignore"):
        v = (s * p).sum(-1) / det
        q = np.cross(s, e_1[None])
        w = (direction[:, None] * q).sum(-1) / det
        t = (e_2 * q).sum(-1) / det
        hit = (v >= 0) & (w >= 0) & (v + w <= 1) & (t > 0)
    return np.where(hit, t, np.inf), v, w


def frames(scene, triangle, v, w, omega_o):
    """Geometric normal, smooth normal and yarn 1 of hits, toward the viewer."""
    tri = scene["positions"].astype(float)[triangle]
    weights = np.stack([1 - v - w, v, w], -1)[..., None]

    def unit(x):
        return x / np.linalg.norm(x, axis=-1, keepdims=True)

    geometric = unit(np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]))
    smooth = unit((unit(scene["normals"].astype(float)[triangle]) * weights).sum(1))
    x = (unit(scene["tangents"].astype(float)[triangle]) * weights).sum(1)
    geometric *= np.where((geometric * omega_o).sum(-1) < 0, -1, 1)[:, None]
    smooth *= np.where((smooth * geometric).sum(-1) < 0, -1, 1)[:, None]
    smooth = facing_normal(smooth, omega_o, np.full(len(smooth), FACING))
    return geometric, smooth, orthogonal_part(x, smooth)


def local(omega, N, x):
    return np.stack([(omega * x).sum(-1), (omega * np.cross(N, x)).sum(-1), (omega * N).sum(-1)], -1)


def visible(origin, direction, distance, scene, fabric):
    """What is left [N, 3] of the lamp's light."""
    t_f = fabric.transmission
    t, v, w = meet(origin, direction, scene["positions"].astype(float))
    left = np.ones((len(origin), 3))
    for i in range(len(origin)):
        hits = np.flatnonzero(t[i] < distance[i])
        if (scene["material"][hits] != 0).any():
            left[i] = 0
            continue
        for k in hits:
            d = direction[i : i + 1]
            _, N, x = frames(scene, np.array([k]), v[i, [k]], w[i, [k]], -d)
            left[i] *= sheet.T_sheet(local(d, N, x), t_f.k_a, t_f.k_t / 2, np.array(t_f.tau), t_f.rho)[0]
    return left


def trace(origin, direction, scene, fabric, lighting, depth, cutoff, weight=None):
    """Radiance [N, 3] along rays, as passes/tracing/shade.comp puts it together."""
    N = len(direction)
    origin = np.broadcast_to(origin, (N, 3))
    weight = np.ones((N, 3)) if weight is None else weight
    f = fabric.transmission
    tau = np.array(f.tau)
    out = np.zeros((N, 3))
    t, v, w = meet(origin, direction, scene["positions"].astype(float))
    nearest = t.argmin(1)
    rows = np.arange(N)
    t = t[rows, nearest]
    miss = np.isinf(t)
    out[miss] = lighting.background
    h = np.flatnonzero(~miss)
    if len(h) == 0:
        return out
    k, d = nearest[h], direction[h]
    p = origin[h] + t[h, None] * d
    Ng, Ns, x = frames(scene, k, v[h, k], w[h, k], -d)
    l = np.array(lighting.lamp.position) - p
    distance = np.linalg.norm(l, axis=-1)
    l /= distance[:, None]
    E = np.array(lighting.lamp.intensity) / distance[:, None] ** 2
    i, o = local(l, Ns, x), local(-d, Ns, x)
    behind = (Ng * l).sum(-1) < 0
    cloth = scene["material"][k] == 0
    flip = np.array([1.0, 1.0, -1.0])
    lobes = sheet.f_yarn(i * flip, o * flip, f.roughness, f.eta_1, f.eta_2, f.diffuse, f.roughness_p)
    passed = (sheet.covered(i, o, f.rho) * f.k_t * lobes * np.maximum(-i[:, 2], 0))[:, None] * sheet.absorption(
        i, o, tau
    )
    yarns, tangents, weights, gap, sigma = fabric.arrays()
    reflected = reflection_limit(fabric) * f_cloth(i, o, yarns, tangents, weights, gap, sigma)
    diffuse = scene["materials"][scene["material"][k]]
    wall = diffuse / np.pi * np.where(behind, 0, np.maximum(i[:, 2], 0))[:, None]
    direct = np.where(cloth[:, None], np.where(behind[:, None], passed, reflected), wall)
    albedo = np.where(cloth[:, None], mean_albedo(fabric) * reflection_limit(fabric), diffuse)
    side = np.where(behind, -1.0, 1.0)[:, None]
    lit = visible(p + OFF * side * Ng, l, distance - OFF, scene, fabric)
    result = albedo * np.array(lighting.ambient) + direct * E * lit
    if depth > 1:
        T = sheet.T_sheet(o, f.k_a, f.k_t, tau, f.rho)
        even = mean_albedo(fabric) * reflection_limit(fabric)
        R = sheet.R_limited(sheet.R_sheet(o, f.k_t, f.rho, f.eta_1, f.eta_2), T, even)[:, None] * np.ones(3)
        r = d - 2 * (d * Ns).sum(-1, keepdims=True) * Ns
        r_g = d - 2 * (d * Ng).sum(-1, keepdims=True) * Ng
        r = np.where((r * Ng).sum(-1, keepdims=True) <= 0, r_g, r)
        for share, start, onward in ((T, p - OFF * Ng, d), (R, p + OFF * Ng, r)):
            go = cloth & ((share * weight[h]).max(-1) > cutoff)
            if go.any():
                deeper = trace(
                    start[go], onward[go], scene, fabric, lighting, depth - 1, cutoff, (share * weight[h])[go]
                )
                result[go] += share[go] * deeper
    out[h] = result
    return out
