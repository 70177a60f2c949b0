"""Where the error of shading by lights instead of their map comes from: suns as points, suns as discs, the Gaussians.

python tests/measure/lamps.py [MAP...] [--lobes 10] [--frames 40] [--flat]

Without a map: a dim room with three lamps of 3 degrees across whose middles stand half a degree above the horizon. --flat:
cloth that lies on the ground, where those lamps are cut in two; otherwise frames are random. Root mean square and 95th
percentile of the error, in % of the mean brightness; brute force in float64 with the lamps' own texels.
"""

import common
import numpy as np

import glcloth
from glcloth.color import luminance
from glcloth.light import equirect, fit
from glcloth.light.environment import Environment
from glcloth.light.judge import FABRICS
from glcloth.light.suns import split_suns
from glcloth.progress import track
from glcloth.twins.cloth import f_cloth
from glcloth.twins.sun_disc import disc_directions

POINTS, ROWS = 64, 64


def room():
    """Three lamps at the horizon."""
    omega = equirect.texel_directions(512, 1024)
    L = np.full((512, 1024, 3), 0.2, np.float32)
    for azimuth in np.radians((20, 140, 250)):
        toward = np.array([np.sin(azimuth), np.tan(np.radians(0.5)), np.cos(azimuth)])
        L[omega @ toward / np.linalg.norm(toward) > np.cos(np.radians(1.5))] = 60
    return Environment("three lamps at the horizon", L)


def frames(count, flat):
    """Rotations [count, 3, 3] and views [count, 3]."""
    rng = np.random.default_rng(1)
    turned = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    if flat:
        c, s = np.cos(turn := rng.uniform(0, 2 * np.pi, count)), np.sin(turn)
        turned = np.stack([c, 0 * c, -s, -s, 0 * c, -c, 0 * c, 1 + 0 * c, 0 * c], -1).reshape(-1, 3, 3)
    z, turn = rng.uniform(0.15, 1, count), rng.uniform(0, 2 * np.pi, count)
    return turned, np.stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z], -1)


def fluxes(environment, lights):
    """[(directions, flux)] of the map's broad light, its lamps, the Gaussians, suns as points and as discs."""
    height = min(environment.radiance.shape[0], 512)
    radiance = equirect.resize(environment.radiance, height, 2 * height)
    rest = split_suns(radiance)[1]
    row, column = np.nonzero(luminance(radiance - rest) > 0)
    lamps = equirect.direction_from_uv((column + 0.5) / (2 * height), (row + 0.5) / height).reshape(-1, 3)
    lamp_flux = (radiance - rest)[row, column] * equirect.row_solid_angles(height, 2 * height)[row, None]
    omega = equirect.texel_directions(ROWS, 2 * ROWS).reshape(-1, 3)
    angle = np.repeat(equirect.row_solid_angles(ROWS, 2 * ROWS), 2 * ROWS)[:, None]
    fine = lights.gaussians.radiance(equirect.texel_directions(4 * ROWS, 8 * ROWS)).astype(np.float32)
    coarse = [equirect.resize(one, ROWS, 2 * ROWS).reshape(-1, 3) * angle for one in (rest, fine)]
    suns = lights.suns
    discs = [disc_directions(*sun, POINTS) for sun in zip(suns.direction, suns.radius, strict=True)]
    of_discs = np.concatenate([np.zeros((0, 3)), *discs]), np.repeat(suns.irradiance / POINTS, POINTS, axis=0)
    return [(omega, coarse[0]), (lamps, lamp_flux), (omega, coarse[1]), (suns.direction, suns.irradiance), of_discs]


def shaded(fabric, rotation, view, light):
    """Luminance under (directions, flux)."""
    omega = light[0] @ rotation.T
    above = omega[:, 2] > 0
    return luminance((f_cloth(omega[above], view, *fabric.arrays()) * light[1][above]).sum(0))


args = common.options(__doc__, ["room"], lobes=10, frames=40, flat=False)
for name in args.environments:
    environment = room() if name == "room" else glcloth.load_environment(name)
    lights = glcloth.fit_lights(environment, args.lobes, cache=False)
    each = fluxes(environment, lights)
    print(f"\n{environment.name}: {args.lobes} lobes, {len(lights.suns)} suns")
    common.head(
        "fabric", "expected rms", "with points: rms, 95 %", "with discs: rms, 95 %", "Gaussians alone: rms, 95 %"
    )
    for chosen in FABRICS:
        fabric = glcloth.load_fabric(chosen)
        pairs = list(zip(*frames(args.frames, args.flat), strict=True))
        broad, lamps, gaussians, points, discs = np.array(
            [[shaded(fabric, *pair, light) for light in each] for pair in track(pairs, chosen)]
        ).T
        mean = (broad + lamps).mean()
        cells = []
        for error in (gaussians + points - broad - lamps, gaussians + discs - broad - lamps, gaussians - broad):
            error = 100 * abs(error) / mean
            cells.append(f"{np.sqrt((error**2).mean()):.2f}, {np.quantile(error, 0.95):.2f}")
        common.row(chosen, f"{100 * fit.predicted_error(environment, lights, chosen):.2f}", *cells)
