"""The cloth as other programs are to show it, by the NumPy twin; pairs of directions; how far a model is from it.   [own]"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates

from ..color import luminance
from ..fabric import Fabric
from ..light.environment import cube_map, load_environment
from ..twins.cloth import f_cloth

Response = Callable[[np.ndarray, np.ndarray], np.ndarray]  # (omega_i, omega_o [..., 3]) -> f cos(theta_i), [..., 3]
LOWEST = np.cos(np.radians(85.0))  # cosine of views and lights: beyond, all models guess
AT_ONCE = 20_000  # pairs
NODES = 96  # places across a ball's picture at which it is computed


def _said(percent: float) -> str:
    """Two figures, without an exponent."""
    if percent < 0.01:
        return "less than 0.01"
    return f"{percent:.0f}" if percent >= 10.0 else f"{percent:.2g}"


def response(fabric: Fabric) -> Response:
    """Radiance toward omega_o per irradiance, perpendicular to the light, from omega_i; surface frame."""
    yarns, tangents, weights, gap, sigma = fabric.arrays()

    def original(omega_i: np.ndarray, omega_o: np.ndarray) -> np.ndarray:
        omega_i, omega_o = np.broadcast_arrays(omega_i, omega_o)
        i, o = omega_i.reshape(-1, 3), omega_o.reshape(-1, 3)
        parts = [
            f_cloth(i[k : k + AT_ONCE], o[k : k + AT_ONCE], yarns, tangents, weights, gap, sigma)
            for k in range(0, len(i), AT_ONCE)
        ]
        return np.concatenate(parts).reshape(omega_i.shape)

    return original


def hemisphere(count: int, seed: int) -> np.ndarray:
    """Directions [count, 3] that are even in solid angle, above LOWEST."""
    random = np.random.default_rng(seed)
    z = LOWEST + (1.0 - LOWEST) * (random.permutation(count) + random.random(count)) / count
    phi = 2.0 * np.pi * random.random(count)
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], -1)


@dataclass(frozen=True)
class Errors:
    """|difference| of luminance, % of the original's mean: its mean and its 95th percentile.

    sun : under single suns from everywhere, over all views. studio : under the built-in studio, turned in all ways.
    """

    sun: tuple[float, float]
    studio: tuple[float, float]

    def __str__(self) -> str:
        return (
            f"differs by {_said(self.studio[0])} % (95 %: {_said(self.studio[1])} %) under the studio, "
            f"by {_said(self.sun[0])} % (95 %: {_said(self.sun[1])} %) under single suns"
        )

    def as_dict(self) -> dict:
        """Plain numbers."""
        return {f"{light}_{name}": round(value, 4) for light in ("sun", "studio")
                for name, value in zip(("mean", "p95"), getattr(self, light), strict=True)}  # fmt: skip


def errors(model: Response, fabric: Fabric, pairs: int = 6000, views: int = 120) -> Errors:
    """How far a model is from a fabric; views and lights to 85 degrees."""
    original = response(fabric)
    i, o = hemisphere(pairs, 11), hemisphere(pairs, 12)
    sun = _spread(model(i, o), original(i, o))
    directions, flux = _studio()
    lit = directions @ np.swapaxes(_turns(views), 1, 2)  # [views, directions, 3]
    seen = np.broadcast_to(hemisphere(views, 13)[:, None], lit.shape)
    above = lit[..., 2] > 0.0
    radiances = []
    for f in (original, model):
        values = np.zeros(lit.shape)
        values[above] = f(lit[above], seen[above])
        radiances.append((values * flux).sum(1))
    return Errors(sun, _spread(radiances[1], radiances[0]))


def _studio() -> tuple[np.ndarray, np.ndarray]:
    """Directions of the built-in studio, and radiance x solid angle from each."""
    directions, solid_angle, radiance = cube_map(load_environment("studio"), 8)
    return directions, solid_angle[:, None] * radiance


def _turns(count: int) -> np.ndarray:
    """Rotations [count, 3, 3], even over all."""
    q = np.random.default_rng(14).normal(size=(count, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def _spread(test: np.ndarray, truth: np.ndarray) -> tuple[float, float]:
    apart = np.abs(luminance(test) - luminance(truth)) / luminance(truth).mean()
    return float(100 * apart.mean()), float(100 * np.percentile(apart, 95))


def sphere_pictures(model: Response, fabric: Fabric, side: int = 256) -> np.ndarray:
    """The original and the model on a ball in the studio, beside each other; [side, 2 side, 3], linear.

    The radiance is computed at NODES x NODES places, up to the rim, and interpolated: a ball has no finer detail.
    """
    original = response(fabric)
    x, y = np.meshgrid(np.linspace(-1, 1, NODES), np.linspace(1, -1, NODES))
    inward = np.minimum(1.0, 0.99 / np.maximum(np.hypot(x, y), 1e-9))  # places off the ball have the light of its rim
    x, y = (x * inward).ravel(), (y * inward).ravel()
    N = np.stack([x, y, np.sqrt(1.0 - x * x - y * y)], -1)
    t = np.cross([0.0, 1.0, 0.0], N)
    t /= np.linalg.norm(t, axis=1, keepdims=True)
    frames = np.stack([t, np.cross(N, t), N], 1)  # rows: yarn 1, yarn 2, normal
    views = frames @ np.array([0.0, 0.0, 1.0])
    directions, flux = _studio()
    pictures = [np.zeros((len(N), 3)) for _ in range(2)]
    for part in np.array_split(np.arange(len(N)), 8):
        lit = directions @ np.swapaxes(frames[part], 1, 2)  # [places, directions, 3]
        seen = np.broadcast_to(views[part][:, None], lit.shape)
        above = lit[..., 2] > 0.0
        for f, picture in zip((original, model), pictures, strict=True):
            values = np.zeros(lit.shape)
            values[above] = f(lit[above], seen[above])
            picture[part] = (values * flux).sum(1)
    return np.concatenate([_disc(picture.reshape(NODES, NODES, 3), side) for picture in pictures], 1)


def _disc(nodes: np.ndarray, side: int) -> np.ndarray:
    """A ball's picture [side, side, 3] from values at places over its square, with a smooth rim."""
    place = (np.arange(side) + 0.5) / side
    row, column = np.meshgrid(place * (NODES - 1), place * (NODES - 1), indexing="ij")
    values = np.stack([map_coordinates(nodes[..., c], [row, column], order=3) for c in range(3)], -1)
    x, y = np.meshgrid(2 * place - 1, 1 - 2 * place)
    cover = np.clip((0.98 - np.hypot(x, y)) * side / 2 + 0.5, 0.0, 1.0)
    return np.maximum(values, 0.0) * cover[..., None]
