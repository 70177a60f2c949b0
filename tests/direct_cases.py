"""Random cases for the direct method, and the arrays that the reference functions take."""

import numpy as np

from glcloth.fabric import Fabric, Yarn, load_fabric

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
KINDS = (
    "linen",
    "satin_charmeuse_back",
    "satin_charmeuse_front",
    "silk_crepe_de_chine",
    "silk_shot",
    "velvet",
    "random",
    "extreme",
)


def random_fabric(rng, extreme=False):
    """A fabric with up to four samples a yarn; `extreme` draws from the whole range that fabrics may have."""
    yarns = []
    for _ in range(2):
        gamma_s = np.exp(rng.uniform(np.log(0.5), np.log(60))) if extreme else rng.uniform(2, 20)
        gamma_v = np.exp(rng.uniform(np.log(0.5), np.log(60))) if extreme else min(60, gamma_s * rng.uniform(1.5, 3))
        count = rng.integers(1, 5)
        tilts = rng.uniform(-90, 90, count) if extreme else rng.uniform(-45, 45, count)
        yarns.append(
            Yarn(
                albedo=tuple(rng.uniform(0.01, 0.6, 3)),
                eta=rng.uniform(1.3, 1.7),
                k_d=rng.uniform(0, 1) if extreme else rng.uniform(0.05, 0.7),
                gamma_s_deg=gamma_s,
                gamma_v_deg=gamma_v,
                area=rng.uniform(0.1, 0.5),
                tangents_deg=tuple(tilts),
            )
        )
    return Fabric(
        name="random",
        yarn=tuple(yarns),
        sigma_deg=np.exp(rng.uniform(np.log(1), np.log(90))) if extreme else rng.uniform(10, 30),
        normalization=("sadeghi", "paper")[rng.integers(2)],
    )


def unit(rng, count):
    """Directions [count, 3] all over the sphere."""
    v = rng.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


ENVIRONMENT = (  # one sky: (azimuth, elevation in degrees, sharpness, radiance)
    (10, 85, 0.9, (0.5, 0.7, 1.1)),
    (200, -60, 1.8, (0.25, 0.2, 0.15)),
    (140, 38, 1500.0, (90.0, 80.0, 60.0)),
    (138, 40, 25.0, (2.5, 2.2, 1.7)),
    (300, 20, 9.0, (0.7, 0.6, 0.5)),
    (60, 12, 14.0, (0.4, 0.5, 0.7)),
    (240, 55, 70.0, (1.6, 1.7, 1.9)),
    (20, -10, 120.0, (2.5, 2.7, 3.0)),
    (100, 5, 300.0, (6.0, 4.5, 3.0)),
    (330, 70, 4.0, (0.4, 0.3, 0.2)),
)


def lights(rng, turned, sharpness=(0.5, 2000.0), count=10):
    """Axes [K, 3], sharpness [K], radiance [K, 3]: one sky in a random orientation, or Gaussians all over the sphere."""
    if turned:
        azimuth, elevation, k, L = (np.array(c, float) for c in zip(*ENVIRONMENT, strict=True))
        a, e = np.radians(azimuth), np.radians(elevation)
        axis = np.stack([np.cos(e) * np.cos(a), np.sin(e), np.cos(e) * np.sin(a)], -1)
        rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        return axis @ rotation, k, L
    k = np.exp(rng.uniform(np.log(sharpness[0]), np.log(sharpness[1]), count))
    # Radiance grows with sharpness as it does in fits of skies, so that narrow lobes count too.
    L = (
        np.exp(rng.normal(0, 0.5, (count, 1)))
        * np.exp(rng.normal(0, 0.3, (count, 3)))
        * (0.3 + 0.02 * k[:, None] ** 0.9)
    )
    return unit(rng, count), k, L


def case(seed):
    """Case number `seed`: (kind, Fabric, omega_o [3], xi [K, 3], sharpness [K], radiance [K, 3]).

    Every tenth case has sharpness from 0.1 to 1e6.
    """
    rng = np.random.default_rng(20240 + seed)
    kind = KINDS[seed % len(KINDS)]
    if kind in ("random", "extreme"):
        fabric = random_fabric(rng, kind == "extreme")
    else:
        fabric = load_fabric(kind)
        if rng.integers(2):
            fabric = fabric.model_copy(update={"normalization": "paper"})
            fabric = Fabric.model_validate(fabric.model_dump())
    wide = seed % 10 == 9 or kind == "extreme"
    cos_o, azimuth = rng.uniform(0.04, 0.99), rng.uniform(0, 2 * np.pi)
    sin_o = np.sqrt(1 - cos_o**2)
    omega_o = np.array([sin_o * np.cos(azimuth), sin_o * np.sin(azimuth), cos_o])
    xi, k, L = lights(rng, turned=not wide and rng.integers(2), sharpness=(0.1, 1e6) if wide else (0.5, 2000.0))
    return kind, fabric, omega_o, xi, k, L
