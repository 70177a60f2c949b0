"""Twin of glsl/core/cubemap.glsl, in float64."""

import numpy as np


def in_texel(middle, solid_angle, at):
    a = np.abs(middle)
    m = a.max(-1)
    step = at * np.sqrt(solid_angle / m**3)[..., None]
    zero = np.zeros_like(m)
    along = np.stack(
        [
            np.stack([zero, step[..., 0], step[..., 1]], -1),
            np.stack([step[..., 0], zero, step[..., 1]], -1),
            np.stack([step[..., 0], step[..., 1], zero], -1),
        ]
    )
    p = middle / m[..., None] + np.take_along_axis(along, a.argmax(-1)[None, ..., None], 0)[0]
    near = 1.0 / np.linalg.norm(p, axis=-1)
    return np.concatenate([p * near[..., None], ((near / m) ** 3)[..., None]], -1)
