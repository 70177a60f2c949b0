"""Twin of glsl/simulate/collide.glsl, in float64."""

import numpy as np


def d_plane(p, normal, offset):
    return np.concatenate(
        [np.broadcast_to(normal, p.shape), (np.sum(normal * p, axis=-1) - offset)[..., None]], axis=-1
    )


def d_sphere(p, center, radius):
    distance = np.linalg.norm(p - center, axis=-1)
    return np.concatenate([(p - center) / distance[..., None], (distance - radius)[..., None]], axis=-1)


def d_box(p, center, half_size, radius):
    inner = half_size - radius[..., None]
    e = p - center
    nearest = np.clip(e, -inner, inner)
    outside = np.linalg.norm(e - nearest, axis=-1)
    # From inside, the way out is through the face with the least depth.
    depth = inner - np.abs(e)
    axis = np.argmin(depth, axis=-1)[..., None]
    way_out = np.zeros_like(e)
    np.put_along_axis(way_out, axis, np.where(np.take_along_axis(e, axis, -1) < 0, -1.0, 1.0), -1)
    inside = outside == 0
    gradient = np.where(inside[..., None], way_out, (e - nearest) / np.where(inside, 1, outside)[..., None])
    distance = np.where(inside, -depth.min(axis=-1), outside) - radius
    return np.concatenate([gradient, distance[..., None]], axis=-1)


def d_ellipsoid(p, center, axes):
    e = (p - center) / axes
    n = e / axes
    k, l = np.linalg.norm(e, axis=-1), np.linalg.norm(n, axis=-1)
    middle, l = l == 0.0, np.where(l == 0.0, 1.0, l)
    gradient = np.where(middle[..., None], (0.0, 1.0, 0.0), n / l[..., None])
    distance = np.where(middle, -np.min(axes, axis=-1), k * (k - 1.0) / l)
    return np.concatenate([gradient, distance[..., None]], axis=-1)


def friction(slide, push, mu):
    length = np.linalg.norm(slide, axis=-1)
    held = length <= mu * push
    return np.where(held[..., None], -slide, -slide / np.where(held, 1, length)[..., None] * (mu * push)[..., None])
