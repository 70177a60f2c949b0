"""The band weights of glcloth/light/bands.py: `python tests/measure/bands.py [--frames 200] [--fabrics a,b]`.

For random frames and views the cloth's kernel K(omega_i) is sampled on 512 x 256 directions and transformed:
b_l = sqrt(Q_l / Q_0) with Q_l = mean of sum_m K_lm^2 / (2 l + 1), K being luminance under white light.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from glcloth.color import luminance
from glcloth.fabric import builtin_fabrics, load_fabric
from glcloth.light import equirect, harmonics
from glcloth.twins.cloth import f_cloth

HEIGHT = 256


def random_frames(count, seed=7):
    """surface_from_world [count, 3, 3], uniform, and views omega_o [count, 3] in the surface frame, cosine 0.1 to 1."""
    rng = np.random.default_rng(seed)
    rotation = Rotation.from_quat(rng.normal(size=(count, 4))).as_matrix()
    cos, phi = rng.uniform(0.1, 1, count), rng.uniform(0, 2 * np.pi, count)
    sin = np.sqrt(1 - cos * cos)
    return rotation, np.stack([sin * np.cos(phi), sin * np.sin(phi), cos], -1)


def kernel(cloth, surface_from_world, omega_o, directions):
    """f_cloth [N, 3] for world directions [N, 3]."""
    omega_i = directions @ surface_from_world.T
    result = np.zeros((len(directions), 3))
    up = omega_i[:, 2] > 0
    result[up] = f_cloth(omega_i[up], omega_o[None], *cloth)
    return result


def power_of(K):
    """sum_m K_lm^2 / (2 l + 1) [l_max + 1] of a kernel [HEIGHT 2 HEIGHT, 3]."""
    power = harmonics.power(luminance(harmonics.transform(K.reshape(HEIGHT, 2 * HEIGHT, 3))))
    return power / (2 * np.arange(len(power)) + 1)


if __name__ == "__main__":
    import common

    options = common.options(__doc__, frames=200, fabrics=builtin_fabrics())
    directions = equirect.texel_directions(HEIGHT, 2 * HEIGHT).reshape(-1, 3)
    for name in options.fabrics:
        cloth = load_fabric(name).arrays()
        frames = zip(*random_frames(options.frames), strict=True)
        Q = sum(power_of(kernel(cloth, *frame, directions)) for frame in frames)
        print(name, np.round(np.sqrt(Q / Q[0]), 4).tolist(), flush=True)
