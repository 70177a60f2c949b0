"""A pinhole camera: where it stands, and the matrices (by pyrr) that rasterising and ray casting need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pyrr import Matrix44, vector

from ..errors import InputError

FARTHEST = 1e9  # of world units; single precision squares it


@dataclass(frozen=True)
class Camera:
    """A pinhole camera in world units.

    Parameters
    ----------
    eye, target, up : [3]; up need not be perpendicular to the view
    fov_deg : vertical field of view, degrees

    Raises InputError when eye and target coincide, up is along the view, or the field of view is outside 1-170 degrees.
    """

    eye: tuple[float, float, float] = (0.0, 0.0, 3.0)
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    fov_deg: float = 35.0

    def __post_init__(self):
        for name in ("eye", "target", "up"):
            value = np.asarray(getattr(self, name), float)
            if value.shape != (3,) or not (abs(value) <= FARTHEST).all():
                raise InputError(f"camera {name} = {getattr(self, name)}: expected three numbers, each at most 1e9")
            object.__setattr__(self, name, tuple(float(v) for v in value))
        if not 1.0 <= self.fov_deg <= 170.0:
            raise InputError(f"camera fov_deg = {self.fov_deg}: expected 1 to 170 degrees")
        forward = np.subtract(self.target, self.eye)
        if np.linalg.norm(forward) < 1e-9:
            raise InputError(f"camera: eye and target are both {self.eye}; move one of them")
        if np.linalg.norm(np.cross(forward, self.up)) < 1e-9 * np.linalg.norm(forward):
            raise InputError(f"camera: up {self.up} is along the view; choose another up")

    @property
    def axes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Right, up and forward, unit and perpendicular."""
        forward = vector.normalise(np.subtract(self.target, self.eye))
        right = vector.normalise(np.cross(forward, self.up))
        return right, np.cross(right, forward), forward

    def clip_from_world(self, size: tuple[int, int], near: float, far: float, offset=(0.0, 0.0)) -> np.ndarray:
        """[4, 4], for column vectors. `offset` (pixels, from the centre) is where in each pixel the sample is taken."""
        view = Matrix44.look_at(self.eye, self.target, self.up)
        projection = Matrix44.perspective_projection(self.fov_deg, size[0] / size[1], near, far)
        # pyrr keeps matrices for row vectors; transposed they act on columns.
        matrix = np.array(projection * view, float).T
        shift = np.eye(4)
        shift[0, 3], shift[1, 3] = -2.0 * offset[0] / size[0], -2.0 * offset[1] / size[1]
        return shift @ matrix

    def ray_from_pixel(self, size: tuple[int, int], offset=(0.0, 0.0)) -> np.ndarray:
        """[3, 3]: direction from the eye (not unit) = matrix @ (x, y, 1), for a pixel centre (x, y) counted from below."""
        right, up, forward = self.axes
        half = np.tan(np.radians(self.fov_deg) / 2)
        across, along = right * half * size[0] / size[1], up * half
        corner = forward - across * (1 - 2 * offset[0] / size[0]) - along * (1 - 2 * offset[1] / size[1])
        return np.stack([2 * across / size[0], 2 * along / size[1], corner], axis=1)

    def depth_range(self, low: np.ndarray, high: np.ndarray) -> tuple[float, float]:
        """Near and far distance that hold the box [low, high]."""
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        depth = (corners - self.eye) @ self.axes[2]
        extent = max(float(np.linalg.norm(np.subtract(high, low))), 1e-6)
        far = max(float(depth.max()), 0.0) + 0.01 * extent
        return max(float(depth.min()) - 0.01 * extent, 1e-3 * far), far

    @staticmethod
    def framing(
        center, radius: float, direction=(0.35, 0.25, 1.0), fov_deg: float = 35.0, aspect: float = 4 / 3
    ) -> Camera:
        """A camera that looks along -direction at a sphere and just holds it."""
        half = np.radians(fov_deg) / 2
        half = min(half, np.arctan(np.tan(half) * aspect))
        toward = vector.normalise(np.asarray(direction, float))
        eye = np.asarray(center, float) + toward * max(radius, 1e-6) / np.sin(half)
        return Camera(tuple(eye), tuple(center), (0.0, 1.0, 0.0), fov_deg)


def sample_offsets(spp: int) -> list[tuple[float, float]]:
    """Where in the pixel the samples lie, relative to its centre: the R2 sequence, one sample at the centre.

    Roberts 2018, "The unreasonable effectiveness of quasirandom sequences": evenly spread for any number of samples.
    """
    if spp == 1:
        return [(0.0, 0.0)]
    g = 1.32471795724474602596
    return [(float((0.5 + n / g) % 1.0 - 0.5), float((0.5 + n / g**2) % 1.0 - 0.5)) for n in range(spp)]
