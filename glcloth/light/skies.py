"""The built-in environments, computed: a studio with soft boxes and a clear sky with a sun.

Maps are [H, W, 3], linear Rec. 709, laid out as in equirect.py.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..color import luminance
from . import equirect

HEIGHT, WIDTH = 512, 1024

# Light by wavelength ----------------------------------------------------------------------------------------------

NANOMETRES = np.arange(380.0, 781.0, 5.0)
# IEC 61966-2-1: linear Rec. 709 from XYZ.
_RGB_FROM_XYZ = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])


def _color_matching(nm: np.ndarray) -> np.ndarray:
    """CIE 1931 x, y, z bar [3, N].   [Wyman, Sloan, Shirley 2013, "Simple Analytic Approximations", eq. 4]"""

    def g(alpha, mu, low, high):
        return alpha * np.exp(-0.5 * ((nm - mu) / np.where(nm < mu, low, high)) ** 2)

    x = g(1.056, 599.8, 37.9, 31.0) + g(0.362, 442.0, 16.0, 26.7) + g(-0.065, 501.1, 20.4, 26.2)
    y = g(0.821, 568.8, 46.9, 40.5) + g(0.286, 530.9, 16.3, 31.1)
    z = g(1.217, 437.0, 11.8, 36.0) + g(0.681, 459.0, 26.0, 13.8)
    return np.stack([x, y, z])


def _planck(nm: np.ndarray, kelvin: float) -> np.ndarray:
    """Spectral radiance of a black body in W / (m^2 sr nm)."""
    h, c, k = 6.62607015e-34, 2.99792458e8, 1.380649e-23
    metres = nm * 1e-9
    return 2 * h * c**2 / metres**5 / np.expm1(h * c / (metres * k * kelvin)) * 1e-9


def _photometric_rgb(spectrum: np.ndarray) -> np.ndarray:
    """Linear Rec. 709 of a spectrum on NANOMETRES; its luminance is 683 lm/W times its y integral."""
    xyz = 683.0 * (_color_matching(NANOMETRES) * spectrum).sum(-1) * (NANOMETRES[1] - NANOMETRES[0])
    return np.maximum(_RGB_FROM_XYZ @ xyz, 0.0)


def blackbody(kelvin: float) -> np.ndarray:
    """Linear Rec. 709 colour [3] of a black body, of luminance 1."""
    rgb = _photometric_rgb(_planck(NANOMETRES, kelvin))
    return rgb / luminance(rgb)


# Clear sky --------------------------------------------------------------------------------------------------------

PAINTED_SUN = np.radians(
    0.2665
)  # radius of the disc in the map, the sun's mean one, 6.8e-5 sr; split off it has lights.SUN_RADIUS
SUN_DIRECTION = np.array([-0.55, 0.70, 0.62]) / np.linalg.norm([-0.55, 0.70, 0.62])  # 40 degrees high, front left
TURBIDITY = 2.8
# The ground, as far as one sees it: pale sand and dry grass, of luminance 0.18 in the mean, from the height of a child's eye
# where cloth is. Toward the horizon haze takes the colour of the sky there.
GROUND_COLORS = np.array([[0.235, 0.206, 0.160], [0.152, 0.150, 0.106]])
GROUND_LUMINANCE = 0.18
EYE_HEIGHT = 1.2  # m
PATCHES = 0.2, 0.55, 1.6, 5.0, 16.0, 60.0  # m, across
HAZE = np.sin(np.radians(1.8))  # height below the horizon where it is 1 / e of what it is there
# One unit of the map is 30 kcd/m^2: a white card lying in the sun then has a radiance of about 1.
KILOCANDELA_PER_UNIT = 30.0

# Rows A..E; columns: factor of turbidity, constant.   [Preetham, Shirley, Smits 1999, appendix A.2]
_PEREZ_LUMINANCE = np.array(
    [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]]
)
_PEREZ_X = np.array([[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]])
_PEREZ_Y = np.array([[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]])
_ZENITH_X = np.array(
    [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]]
)
_ZENITH_Y = np.array(
    [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]]
)


def clear_sky(omega: np.ndarray, sun: np.ndarray = SUN_DIRECTION, turbidity: float = TURBIDITY) -> np.ndarray:
    """Radiance [..., 3] in kcd/m^2 of a clear sky without its sun toward omega [..., 3] above the horizon.

    Preetham, Shirley and Smits 1999, "A Practical Analytic Model for Daylight", eq. 3-4 and appendix A.2.
    """
    cos_theta = np.maximum(omega[..., 1], 0.01)
    cos_gamma = np.clip(omega @ sun, -1.0, 1.0)
    gamma = np.arccos(cos_gamma)
    theta_s = np.arccos(np.clip(sun[1], 0.0, 1.0))
    T = turbidity

    def relative(table):
        A, B, C, D, E = table @ [T, 1.0]

        def F(cos_t, g, cos_g):
            return (1 + A * np.exp(B / cos_t)) * (1 + C * np.exp(D * g) + E * cos_g**2)

        return F(cos_theta, gamma, cos_gamma) / F(1.0, theta_s, np.cos(theta_s))

    chi = (4 / 9 - T / 120) * (np.pi - 2 * theta_s)
    Y_z = (4.0453 * T - 4.9710) * np.tan(chi) - 0.2155 * T + 2.4192
    powers = theta_s ** np.arange(3, -1, -1)
    x_z, y_z = (np.array([T * T, T, 1]) @ table @ powers for table in (_ZENITH_X, _ZENITH_Y))
    Y, x, y = Y_z * relative(_PEREZ_LUMINANCE), x_z * relative(_PEREZ_X), y_z * relative(_PEREZ_Y)
    xyz = np.stack([x / y * Y, Y, (1 - x - y) / y * Y], -1)
    return np.maximum(xyz @ _RGB_FROM_XYZ.T, 0.0)


def sun_irradiance(sun: np.ndarray = SUN_DIRECTION, turbidity: float = TURBIDITY) -> np.ndarray:
    """Irradiance [3] in klx on a surface that faces the sun.

    A black body of 5778 K seen under the sun's solid angle, dimmed by Rayleigh scattering and aerosols as in Preetham
    et al. 1999, appendix A.1; ozone, mixed gases and water vapour (a few per cent in the visible) are left out.
    """
    theta_s = np.arccos(np.clip(sun[1], 0.0, 1.0))
    m = 1 / (np.cos(theta_s) + 0.15 * (93.885 - np.degrees(theta_s)) ** -1.253)
    beta = 0.04608 * turbidity - 0.04586
    micrometres = NANOMETRES * 1e-3
    transmitted = np.exp(-m * (0.008735 * micrometres**-4.08 + beta * micrometres**-1.3))
    solid_angle = 2 * np.pi * (1 - np.cos(PAINTED_SUN))
    return _photometric_rgb(_planck(NANOMETRES, 5778.0) * transmitted) * solid_angle * 1e-3


def sky() -> np.ndarray:
    """A clear sky of turbidity 2.8 with the sun 40 degrees high at the front left; sand and dry grass fade into its haze."""
    omega = equirect.texel_directions(HEIGHT, WIDTH)
    up = omega[: HEIGHT // 2]
    radiance = np.empty((HEIGHT, WIDTH, 3))
    radiance[: HEIGHT // 2] = clear_sky(up)
    sun = sun_irradiance()
    weight = equirect.row_solid_angles(HEIGHT, WIDTH)[: HEIGHT // 2]
    horizontal = np.einsum("hwc,hw,h->c", radiance[: HEIGHT // 2], up[..., 1], weight) + sun * SUN_DIRECTION[1]
    down = omega[HEIGHT // 2 :]
    left = np.exp(down[..., 1:2] / HAZE)  # of the haze
    level = np.stack([down[..., 0], np.zeros(down.shape[:2]), down[..., 2]], -1)
    haze = clear_sky(level / np.linalg.norm(level, axis=-1, keepdims=True))
    radiance[HEIGHT // 2 :] = left * haze + (1.0 - left) * ground_albedo(down) / np.pi * horizontal
    radiance += _disc(SUN_DIRECTION, PAINTED_SUN)[..., None] * sun
    return (radiance / KILOCANDELA_PER_UNIT).astype(np.float32)


def ground_albedo(omega: np.ndarray) -> np.ndarray:
    """The colour [..., 3] of the ground toward omega [..., 3] below the horizon: patches of two colours, as far as texels
    of the map can tell them apart."""
    depth = np.maximum(-omega[..., 1], 1e-3)
    place = EYE_HEIGHT / depth[..., None] * omega[..., [0, 2]]
    texel = EYE_HEIGHT / depth**2 * np.pi / HEIGHT  # m, on the ground
    patches = np.zeros(depth.shape)
    for number, across in enumerate(PATCHES):
        patches += np.clip(2.0 - 2.0 * texel / across, 0.0, 1.0) * (_noise(place / across, number) - 0.5)
    share = np.clip(0.5 + 0.55 * patches, 0.0, 1.0)[..., None]
    colors = GROUND_COLORS * (GROUND_LUMINANCE / luminance(GROUND_COLORS.mean(0)))
    return share * colors[0] + (1.0 - share) * colors[1]


def _noise(place: np.ndarray, seed: int) -> np.ndarray:
    """Smooth random values 0 to 1 [...] at places [..., 2], one a unit square."""
    low = np.floor(place).astype(np.int64)
    x, y = np.moveaxis(place - low, -1, 0)
    x, y = x * x * (3 - 2 * x), y * y * (3 - 2 * y)

    def value(dx: int, dy: int) -> np.ndarray:
        bits = (low[..., 0] + dx) * 374761393 + (low[..., 1] + dy) * 668265263 + seed * 974634517
        bits = ((bits ^ (bits >> 13)) * 1274126177) & 0xFFFFFFFF
        return ((bits ^ (bits >> 16)) & 0xFFFFFF) / 2.0**24

    lower = (1 - x) * value(0, 0) + x * value(1, 0)
    return (1 - y) * lower + y * ((1 - x) * value(0, 1) + x * value(1, 1))


def _disc(axis: np.ndarray, radius: float, fine: int = 16) -> np.ndarray:
    """A disc light of irradiance 1 on a map [H, W]: texel coverage by fine x fine samples, scaled to the exact flux."""
    u, v = equirect.uv_from_direction(axis)
    row, column = int(v * HEIGHT), int(u * WIDTH)
    reach = int(np.ceil(radius / np.pi * HEIGHT)) + 1
    wide = min(int(np.ceil(reach / max(np.sin(np.pi * v), 0.01))) + 1, WIDTH // 2)
    rows = np.arange(max(row - reach, 0), min(row + reach + 1, HEIGHT))
    columns = np.arange(column - wide, column + wide + 1)
    offset = (np.arange(fine) + 0.5) / fine
    v_fine = ((rows[:, None] + offset) / HEIGHT).ravel()
    u_fine = ((columns[:, None] + offset) / WIDTH).ravel()
    inside = equirect.direction_from_uv(u_fine[None, :], v_fine[:, None]) @ axis >= np.cos(radius)
    cover = inside.reshape(len(rows), fine, len(columns), fine).mean(axis=(1, 3))
    result = np.zeros((HEIGHT, WIDTH))
    result[np.ix_(rows, columns % WIDTH)] = cover
    return result / (equirect.row_solid_angles(HEIGHT, WIDTH) @ result.sum(axis=1))


# Studio -----------------------------------------------------------------------------------------------------------

# position in metres from the cloth, width and height in metres, roundness (2 an ellipse, 8 a rectangle with soft
# corners), colour temperature, radiance at the centre
_SOFT_BOXES = {
    "key": ((-2.3, 2.2, 2.4), 2.0, 2.0, 2, 5200.0, 33.0),
    "fill": ((3.2, 0.6, 2.0), 2.2, 2.6, 8, 8500.0, 3.4),
    "rim right": ((2.0, 1.9, -2.4), 0.6, 1.5, 8, 6000.0, 30.0),
    "rim left": ((-2.6, 1.2, -2.0), 0.5, 1.3, 8, 7000.0, 16.0),
    "overhead": ((0.0, 3.4, -0.4), 2.4, 1.8, 8, 6500.0, 2.6),
}


def studio() -> np.ndarray:
    """A dark room with a warm key at the upper left, a cool fill at the right, two rim strips and a dim overhead."""
    omega = equirect.texel_directions(HEIGHT, WIDTH)
    # Walls a little lighter toward the floor, which catches the key.
    down = np.clip(-omega[..., 1:2], 0.0, 1.0)
    radiance = 0.022 * np.array([0.96, 0.99, 1.06]) + 0.05 * down**1.5 * np.array([1.08, 1.0, 0.9])
    for position, width, height, roundness, kelvin, brightness in _SOFT_BOXES.values():
        centre = np.array(position)
        # Only the texels inside the circle around the box are worth computing.
        distance = np.linalg.norm(centre)
        near = omega @ (centre / distance) > distance / np.hypot(distance, np.hypot(width, height) / 2)
        shape = _soft_box(omega[near], centre, width, height, roundness)[:, None]
        radiance[near] = radiance[near] * (1 - np.minimum(shape * 4, 1)) + shape * brightness * blackbody(kelvin)
    return radiance.astype(np.float32)


def _soft_box(omega: np.ndarray, position: np.ndarray, width: float, height: float, roundness: float) -> np.ndarray:
    """Relative radiance 0..1 [N] of a diffuser that faces the origin: brightest where the lamp is behind it."""
    normal = position / np.linalg.norm(position)
    right = np.cross([0.0, 1.0, 0.0], normal)
    right /= np.linalg.norm(right)
    up = np.cross(normal, right)
    distance = np.linalg.norm(position) / (omega @ normal)
    s, t = omega @ right * distance / (width / 2), omega @ up * distance / (height / 2)
    r = (np.abs(s) ** roundness + np.abs(t) ** roundness) ** (1 / roundness)
    # The border is 0.05 m wide, a few texels of the map, so that it is not jagged.
    edge = np.clip((1 - r) * min(width, height) / 2 / 0.05, 0, 1)
    return edge * edge * (3 - 2 * edge) * np.exp(-(s * s + t * t))


BUILT_IN: dict[str, Callable[[], np.ndarray]] = {"studio": studio, "sky": sky}
