"""Pictures of the sphere that are not equirectangular: cube maps and angular maps, taken over into one that is.

All are natural pictures, as one sees them from inside, whose front is the middle of an equirectangular map (+z): its
right is -x, its top +y. Faces of strips stand in the order +x -x +y -y +z -z, each as OpenEXR's cube maps have it.
[OpenEXR, ImfEnvmap; Debevec, "Light Probe Image Gallery"; HDR Shop's crosses]
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from ..errors import InputError
from . import equirect

Layout = Literal["equirect", "cross", "strip", "angular", "mirror"]
LAYOUTS: tuple[str, ...] = get_args(Layout)
TALLEST = 4096  # rows of a map made of another
SAMPLES = 2  # along each side of a texel
ROWS = 64  # at a time, to spare memory
EMPTY = 0.02  # of the mean of what is used: corners that vary less are empty

# The direction of (s, t) in [-1, 1] on each face, s to the right and t down, as rows of coefficients of (1, s, t).
FACES = {
    "+x": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "-x": ((-1, 0, 0), (0, 0, -1), (0, -1, 0)),
    "+y": ((0, 1, 0), (1, 0, 0), (0, 0, -1)),
    "-y": ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    "+z": ((0, -1, 0), (0, 0, -1), (1, 0, 0)),
    "-z": ((0, 1, 0), (0, 0, -1), (-1, 0, 0)),
    # In crosses the top and the bottom hang on the front, and in a tall one the back on the bottom.
    "top": ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    "bottom": ((0, -1, 0), (-1, 0, 0), (0, 0, -1)),
    "under": ((0, -1, 0), (0, 0, 1), (-1, 0, 0)),
}
STRIP = ("+x", "-x", "+y", "-y", "+z", "-z")
# Row and column of each face.
WIDE = {"top": (0, 1), "+x": (1, 0), "+z": (1, 1), "-x": (1, 2), "-z": (1, 3), "bottom": (2, 1)}
TALL = {"top": (0, 1), "+x": (1, 0), "+z": (1, 1), "-x": (1, 2), "bottom": (2, 1), "under": (3, 1)}


def guessed(image: np.ndarray, cube: bool = False) -> Layout:
    """The layout of a picture [H, W, 3] by its shape, and by its corners, which crosses and angular maps leave empty.

    cube : the file says that it is a cube map
    """
    height, width = image.shape[:2]
    if width == 6 * height or height == 6 * width:
        return "strip"
    if (4 * height == 3 * width and width % 4 == 0) or (3 * height == 4 * width and width % 3 == 0):
        cells = TALL if height > width else WIDE
        n = max(height, width) // 4
        used = np.zeros((height, width), bool)
        for row, column in cells.values():
            used[row * n : (row + 1) * n, column * n : (column + 1) * n] = True
        if cube or _empty(image, ~used, used):
            return "cross"
    if height == width and height >= 16:
        x, y = _disk(height)
        r = np.hypot(x, y)
        if _empty(image, r > 1 + 4 / height, r < 1 - 4 / height):
            return "angular"
    return "equirect"


def _empty(image: np.ndarray, outside: np.ndarray, inside: np.ndarray) -> bool:
    with np.errstate(invalid="ignore"):
        corner = image[outside].astype(np.float64)
        mean = np.abs(image[inside]).mean(dtype=np.float64)
        return bool(len(corner) and mean > 0 and np.ptp(corner, axis=0).max() <= EMPTY * mean)


def as_equirect(image: np.ndarray, layout: str, where: str) -> np.ndarray:
    """An equirectangular map [H, 2 H, 3] float32 of a picture [h, w, 3] in another layout, as fine as that.

    Raises InputError where the picture's shape does not fit the layout.
    """
    if layout == "equirect":
        return image
    if layout not in LAYOUTS:
        raise InputError(f"{where}: layout {layout}: unknown, expected {', '.join(LAYOUTS)}")
    if layout in ("angular", "mirror"):
        if image.shape[0] != image.shape[1]:
            raise InputError(
                f"{where}: {image.shape[1]} x {image.shape[0]} pixels, a map of a ball is a square; crop it"
            )
        edge = max(image.shape[0] // 2, 2)
        return _resampled(lambda omega: _ball(image, omega, layout), min(edge, TALLEST))
    faces, names = _faces(image, layout, where)
    return _resampled(lambda omega: _cube(faces, names, omega), min(2 * faces.shape[1], TALLEST))


def _resampled(look, height: int) -> np.ndarray:
    """The map [height, 2 height, 3] of a function of directions, the mean of four points of each texel."""
    out = np.empty((height, 2 * height, 3), np.float32)
    fine = SAMPLES * height
    u = (np.arange(2 * fine) + 0.5) / (2 * fine)
    for row in range(0, height, ROWS):
        rows = min(ROWS, height - row)
        v = (np.arange(SAMPLES * row, SAMPLES * (row + rows)) + 0.5) / fine
        values = look(equirect.direction_from_uv(u[None], v[:, None]))
        out[row : row + rows] = values.reshape(rows, SAMPLES, 2 * height, SAMPLES, 3).mean((1, 3))
    return out


# Cubes ------------------------------------------------------------------------------------------------------------


def _faces(image: np.ndarray, layout: str, where: str) -> tuple[np.ndarray, tuple[str, ...]]:
    """The faces [6, n, n, 3] of a cube map, and what they are called in FACES."""
    height, width = image.shape[:2]
    if layout == "strip" and width == 6 * height:
        return image.reshape(height, 6, height, 3).swapaxes(0, 1), STRIP
    if layout == "strip" and height == 6 * width:
        return image.reshape(6, width, width, 3), STRIP
    if layout == "cross" and max(height, width) % 4 == 0 and min(height, width) * 4 == max(height, width) * 3:
        n, cells = max(height, width) // 4, TALL if height > width else WIDE
        found = [image[r * n : (r + 1) * n, c * n : (c + 1) * n] for r, c in cells.values()]
        return np.stack(found), tuple(cells)
    shape = "six squares in a row" if layout == "strip" else "4 x 3 or 3 x 4 squares"
    raise InputError(f"{where}: {width} x {height} pixels, expected {shape}; crop it, or choose another layout")


def _cube(faces: np.ndarray, names: tuple[str, ...], omega: np.ndarray) -> np.ndarray:
    """Bilinear radiance [..., 3] toward omega [..., 3]; at the edges of faces the nearest texel of the same face."""
    n = faces.shape[1]
    major = np.abs(omega).argmax(-1)
    out = np.empty(omega.shape, np.float32)
    for number, name in enumerate(names):
        rows = np.array(FACES[name], float)  # omega = m (rows @ (1, s, t))
        axis, sign = int(np.abs(rows[:, 0]).argmax()), rows[:, 0].sum()
        here = (major == axis) & (omega[..., axis] * sign > 0)
        p = omega[here] / np.abs(omega[here][:, axis, None])
        s, t = p @ rows[:, 1], p @ rows[:, 2]
        out[here] = _bilinear(faces[number], (s + 1) / 2 * n - 0.5, (t + 1) / 2 * n - 0.5)
    return out


def _bilinear(image: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    height, width = image.shape[:2]
    x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
    i, j = np.minimum(x.astype(int), max(width - 2, 0)), np.minimum(y.astype(int), max(height - 2, 0))
    f, g = (x - i)[:, None], (y - j)[:, None]
    i_1, j_1 = np.minimum(i + 1, width - 1), np.minimum(j + 1, height - 1)
    return (1 - g) * ((1 - f) * image[j, i] + f * image[j, i_1]) + g * ((1 - f) * image[j_1, i] + f * image[j_1, i_1])


# Balls ------------------------------------------------------------------------------------------------------------


def _disk(n: int) -> tuple[np.ndarray, np.ndarray]:
    """x to the right and y up, [n, n], of the pixels of a square about the unit disk."""
    c = (np.arange(n) + 0.5) / n * 2 - 1
    x, y = np.meshgrid(c, -c)
    return x, y


def _ball(image: np.ndarray, omega: np.ndarray, layout: str) -> np.ndarray:
    """Radiance [..., 3] toward omega: the radius is the angle from the front (angular), or what a mirror ball shows."""
    n = image.shape[0]
    x, y, z = omega[..., 0], omega[..., 1], omega[..., 2]
    across = np.hypot(x, y)
    angle = np.arctan2(across, z)
    radius = angle / np.pi if layout == "angular" else np.sin(angle / 2)
    scale = radius / np.maximum(across, 1e-12)
    # Half a texel inside of the rim, beyond which there is nothing to blend with.
    scale = scale * np.minimum(1.0, (1 - 1 / n) / np.maximum(radius, 1e-12))
    s, t = -x * scale, -y * scale
    values = _bilinear(image, ((s + 1) / 2 * n - 0.5).ravel(), ((t + 1) / 2 * n - 0.5).ravel())
    return values.reshape(omega.shape)
