"""Measure the band weights of glcloth/light/bands.py: `python tests/measure/bands.py [FRAMES] [FABRIC...]`.

For random frames and views the cloth's kernel K(omega_i) is sampled on 512 x 256 directions and transformed:
b_l = sqrt(Q_l / Q_0) with Q_l = mean of sum_m K_lm^2 / (2 l + 1), K being luminance under white light.
"""

import sys

import numpy as np
from direct_cases import LUMINANCE
from scipy.spatial.transform import Rotation

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
    power = harmonics.power(harmonics.transform(K.reshape(HEIGHT, 2 * HEIGHT, 3)) @ LUMINANCE)
    return power / (2 * np.arange(len(power)) + 1)


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    directions = equirect.texel_directions(HEIGHT, 2 * HEIGHT).reshape(-1, 3)
    for name in sys.argv[2:] or builtin_fabrics():
        cloth = load_fabric(name).arrays()
        Q = sum(power_of(kernel(cloth, *frame, directions)) for frame in zip(*random_frames(count), strict=True))
        print(name, np.round(np.sqrt(Q / Q[0]), 4).tolist(), flush=True)


if __name__ == "__main__":
    main()
