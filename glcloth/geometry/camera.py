"""A camera: where it stands, and the matrices (by pyrr) that rasterising and ray casting need."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import gcd

import numpy as np
from pyrr import Matrix44, vector

from ..errors import InputError

FARTHEST = 1e9  # of world units; single precision squares it


@dataclass(frozen=True)
class Camera:
    """A camera in world units (metres): a pinhole, a thin lens, or parallel rays.

    Parameters
    ----------
    eye, target, up : [3]; up need not be perpendicular to the view
    fov_deg : vertical field of view, degrees
    ortho : height of the picture, metres, of a camera with parallel rays; None: perspective
    aperture : diameter of the lens, metres; 0: everything is sharp
    focus : distance of what is sharp, along the view, metres; None: that of the target
    shear : how far its rays lean right and up for each metre along the view; see `through`

    Raises InputError when eye and target coincide, up is along the view, the field of view is outside 1-170 degrees, or a
    height, aperture or distance is not as said.
    """

    eye: tuple[float, float, float] = (0.0, 0.0, 3.0)
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    fov_deg: float = 35.0
    ortho: float | None = None
    aperture: float = 0.0
    focus: float | None = None
    shear: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self):
        for name in ("eye", "target", "up"):
            value = np.asarray(getattr(self, name), float)
            if value.shape != (3,) or not (abs(value) <= FARTHEST).all():
                raise InputError(f"camera {name} = {getattr(self, name)}: expected three numbers, each at most 1e9")
            object.__setattr__(self, name, tuple(float(v) for v in value))
        if not 1.0 <= self.fov_deg <= 170.0:
            raise InputError(f"camera fov_deg = {self.fov_deg}: expected 1 to 170 degrees")
        for name in ("ortho", "focus"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < np.inf:
                raise InputError(f"camera {name} = {value}: expected metres above 0")
        if not 0.0 <= self.aperture < np.inf:
            raise InputError(f"camera aperture = {self.aperture}: expected metres from 0")
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
        aspect = size[0] / size[1]
        if self.ortho is None:
            projection = Matrix44.perspective_projection(self.fov_deg, aspect, near, far)
        else:
            up, right = 0.5 * self.ortho, 0.5 * self.ortho * aspect
            projection = Matrix44.orthogonal_projection(-right, right, -up, up, near, far)
        # pyrr keeps matrices for row vectors; transposed they act on columns.
        if self.shear == (0.0, 0.0):
            matrix = np.array(projection * view, float).T
        else:
            lean = np.eye(4)
            lean[:2, 2] = self.shear  # z is minus the depth
            matrix = np.array(projection, float).T @ lean @ np.array(view, float).T
        shift = np.eye(4)
        shift[0, 3], shift[1, 3] = -2.0 * offset[0] / size[0], -2.0 * offset[1] / size[1]
        return shift @ matrix

    def ray_from_pixel(self, size: tuple[int, int], offset=(0.0, 0.0)) -> np.ndarray:
        """[3, 3]: direction of a ray (not unit, 1 along the view) = matrix @ (x, y, 1), for a pixel centre (x, y) counted from
        below."""
        right, up, forward = self.axes
        toward = forward if self.shear == (0.0, 0.0) else forward + self.shear[0] * right + self.shear[1] * up
        if self.ortho is not None:
            return np.stack([np.zeros(3), np.zeros(3), toward], axis=1)
        half = np.tan(np.radians(self.fov_deg) / 2)
        return _over_picture(right * half * size[0] / size[1], up * half, toward, size, offset)

    def origin_from_pixel(self, size: tuple[int, int], offset=(0.0, 0.0)) -> np.ndarray:
        """[3, 3]: where a ray begins = matrix @ (x, y, 1), for pixels as for `ray_from_pixel`."""
        if self.ortho is None:
            return np.stack([np.zeros(3), np.zeros(3), np.asarray(self.eye)], axis=1)
        right, up, _ = self.axes
        half = 0.5 * self.ortho
        return _over_picture(right * half * size[0] / size[1], up * half, np.asarray(self.eye), size, offset)

    def step_from_pixel(self, size: tuple[int, int]) -> np.ndarray:
        """[3, 3]: how a ray changes from pixel to pixel, across and up: its direction in perspective, else its origin."""
        return self.ray_from_pixel(size) if self.ortho is None else self.origin_from_pixel(size)

    @property
    def viewpoint(self) -> np.ndarray:
        """[4]: (eye, 1), or of parallel rays (direction toward the camera, 0); a point p is seen along xyz - w p."""
        if self.ortho is None:
            return np.append(self.eye, 1.0)
        return np.append(-self.ray_from_pixel((1, 1))[:, 2], 0.0)

    @property
    def reach(self) -> float:
        """The largest coordinate where rays begin, in a picture up to twice as wide as high."""
        beside = 0.5 * self.aperture + (0.0 if self.ortho is None else 1.2 * self.ortho)
        return float(np.abs(self.eye).max()) + beside

    def through(self, point: tuple[float, float]) -> Camera:
        """The pinhole at a point [2] of the lens, a disk of radius 1: what lies at the focus stays where it is."""
        if self.aperture == 0.0:
            return self
        right, up, _ = self.axes
        x, y = 0.5 * self.aperture * point[0], 0.5 * self.aperture * point[1]
        step, focus = x * right + y * up, self.focus_distance
        return replace(
            self,
            eye=tuple(self.eye + step),
            target=tuple(self.target + step),
            shear=(-x / focus, -y / focus),
            aperture=0.0,
        )

    @property
    def focus_distance(self) -> float:
        """Metres along the view at which a point is sharp."""
        return float(np.linalg.norm(np.subtract(self.target, self.eye))) if self.focus is None else self.focus

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


def _over_picture(across, along, middle, size: tuple[int, int], offset) -> np.ndarray:
    """[3, 3]: a vector for each pixel: `middle` at the picture's centre, `across` and `along` more at its right and upper
    edge."""
    corner = middle - across * (1 - 2 * offset[0] / size[0]) - along * (1 - 2 * offset[1] / size[1])
    return np.stack([2 * across / size[0], 2 * along / size[1], corner], axis=1)


def r2_points(count: int) -> np.ndarray:
    """Points [count, 2] of the unit square, the R2 sequence.

    Roberts 2018, "The unreasonable effectiveness of quasirandom sequences": evenly spread for any number of samples.
    """
    g = 1.32471795724474602596
    return (0.5 + np.arange(count)[:, None] / np.array([g, g**2])) % 1.0


def sample_offsets(spp: int) -> list[tuple[float, float]]:
    """Where in the pixel the samples lie, relative to its centre: the R2 sequence, one sample at the centre."""
    return [(0.0, 0.0)] if spp == 1 else [(float(x - 0.5), float(y - 0.5)) for x, y in r2_points(spp)]


def lens_points(spp: int) -> list[tuple[float, float]]:
    """Where on the lens, a disk of radius 1, the samples of a pixel pass; one sample at its middle.

    The R2 sequence in another order than that of `sample_offsets`, so that place in the pixel and on the lens do not go
    together; to the disk by the concentric map of Shirley and Chiu 1997, "A low distortion map between disk and square".
    """
    if spp == 1:
        return [(0.0, 0.0)]
    stride = next(k for k in range(max(2, round(0.618 * spp)), 2 * spp + 2) if gcd(k, spp) == 1)
    offsets = sample_offsets(spp)
    return [_on_disk(2 * x, 2 * y) for x, y in (offsets[n * stride % spp] for n in range(spp))]


def _on_disk(x: float, y: float) -> tuple[float, float]:
    """A point of the square -1..1 on the unit disk, area for area."""
    if x == 0.0 and y == 0.0:
        return 0.0, 0.0
    radius, angle = (x, np.pi / 4 * y / x) if abs(x) > abs(y) else (y, np.pi / 2 - np.pi / 4 * x / y)
    return float(radius * np.cos(angle)), float(radius * np.sin(angle))


def lens_samples(camera: Camera, spp: int) -> list[Camera]:
    """The camera of each sample of a pixel."""
    return [camera.through(point) for point in lens_points(spp)]
