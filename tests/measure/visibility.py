"""What a pixel may know of its visibility, and what that costs in accuracy.

python tests/measure/visibility.py ENVIRONMENT... [--fabrics a,b] [--size 120x90] [--cube 16] [--every 16]

Every so many covered pixels of the built-in cloth get rays in every direction of a cube map. Against the sum of f_cloth
times light times V over them, each row sums f_cloth times light times a simpler V: one mean for each Gaussian, flat or
by the cosine; or one of all light together, by six means about the world's axes, the best quadratic, the nine parts that
method `direct` has (also from its 256 directions alone); or one for each Gaussian with a linear gradient. Printed in %:
the mean of |difference| and the difference of the means over the mean, median and 95th percentile of the relative error.
"""

from pathlib import Path

import common
import numpy as np

import glcloth
from glcloth.accel.queries import RayQueries
from glcloth.color import luminance
from glcloth.light import cubemap
from glcloth.twins import cloth
from glcloth.twins.visibility import broad_sums, flat_weight, from_bands, world_directions


def cube_shares(omega):
    """How much [..., 6] a direction belongs to the six axes of the world (the ambient cube, McTaggart 2004)."""
    return np.concatenate([np.maximum(omega, 0.0) ** 2, np.maximum(-omega, 0.0) ** 2], -1)


def quadratics(omega):
    """A basis [..., 9] of the quadratic functions on the sphere."""
    x, y, z = np.moveaxis(omega, -1, 0)
    return np.stack([np.ones_like(x), x, y, z, x * y, y * z, x * z, x * x - z * z, y * y - 1 / 3], -1)


def nine_parts(V, N, x, D, light, omega):
    """V of the directions `omega` of the surface frame from what is seen of the directions D."""
    sums = broad_sums(V[None], N[None], x[None, :3], x[3:], D, light)[0, 0]
    least = 0.05e-4 * light.sum()
    parts = (sums[0] + least) / (sums[1] + least)
    return from_bands(omega, parts[:4], parts[4:8], parts[8])


def with_gradient(V, w, D):
    """The mean of V under the weights w and its linear gradient, at the directions D themselves."""
    if w.sum() < 1e-9:
        return np.ones(len(D))
    mean, m = w @ V / w.sum(), w @ D / w.sum()
    d = D - m
    C = (d * w[:, None]).T @ d / w.sum()
    slope = np.linalg.solve(C + (0.003 + 0.03 * np.trace(C)) * np.eye(3), d.T @ (w * V) / w.sum())
    return np.clip(mean + d @ slope, 0.0, 1.0)


class Light:
    """An environment's Gaussians over the directions of a cube map, D of method `direct`, and bases over them."""

    def __init__(self, gaussians, cube):
        g = gaussians
        self.D, self.omega = world_directions(256), cubemap.directions(cube)
        self.solid_angle = cubemap.solid_angles(cube)
        each = [slice(k, k + 1) for k in range(len(g))]
        flux = [cubemap.average_gaussians(g.axis[k], g.sharpness[k], g.amplitude[k], cube) for k in each]
        self.flux = np.array(flux) * self.solid_angle[:, None]
        total = luminance(self.flux.sum(0))
        self.weight = total / total.sum() * 4 * np.pi / self.solid_angle + 0.02
        weight_D = luminance(g.radiance(self.D))
        self.weight_D = weight_D / weight_D.mean() + 0.02
        narrowed = np.minimum(g.sharpness, 64.0)[:, None]
        self.tables = np.exp(narrowed * (g.axis @ self.omega.T - 1.0)) * self.solid_angle
        self.shares, self.quadratic = cube_shares(self.omega), quadratics(self.omega)


def simpler(light, V, V_D, n, x, omega):
    """{what is known: V} of a pixel: `V` the truth in the directions `omega` of its surface frame, `V_D` in D."""
    flat, flux = flat_weight(omega[:, 2]), luminance(light.flux)
    of_each, of_cosine = flux * flat, flux * np.maximum(omega[:, 2], 0.0)
    w = light.solid_angle * light.weight * flat
    Q, shares = light.quadratic, light.shares
    normal = (Q * w[:, None]).T @ Q
    fitted = np.linalg.solve(normal + 0.002 * np.trace(normal) * np.eye(9), Q.T @ (w * V))
    six = ((w * V) @ shares + 1e-4 * w.sum()) / (w @ shares + 1e-4 * w.sum())
    nine = nine_parts(V, n, x, light.omega, light.solid_angle * light.weight, omega)
    return {
        "truth": V,
        "no shadows": 1.0,
        "one for each, flat": (of_each @ V / np.maximum(of_each.sum(1), 1e-30))[:, None],
        "one for each, by the cosine": (of_cosine @ V / np.maximum(of_cosine.sum(1), 1e-30))[:, None],
        "of all, six means of the world": shares @ six,
        "of all, best quadratic": np.clip(Q @ fitted, 0.0, 1.0),
        "of all, nine parts": nine,
        "of all, nine parts, 256 directions": nine_parts(V_D, n, x, light.D, light.weight_D, omega),
        "one for each, with a gradient": np.array([with_gradient(V, k * flat, light.omega) for k in light.tables]),
    }


def measure(renderer, queries, environment, options):
    frame = renderer.prepare(env=environment, size=options.size, background=False, shadows="off")
    renderer.draw(frame)
    pixels, light = common.Pixels(renderer), Light(frame.lights.gaussians, options.cube)
    structure = renderer.stage.occluders(frame)
    places = pixels.covered[:: options.every]

    def seen(place, directions):
        return ~queries.any_hit(structure, np.repeat(pixels.p[*place, None, :3], len(directions), 0), directions)

    known = [(place, seen(place, light.omega).astype(float), seen(place, light.D)) for place in places]
    for fabric in options.fabrics:
        description = glcloth.load_fabric(fabric).arrays()
        rows = {}
        for place, V, V_D in known:
            to_surface, omega_o = pixels.frame(*place)
            omega = light.omega @ to_surface.T
            weights = luminance(light.flux * cloth.f_cloth(omega, omega_o[None], *description))
            x = np.append(pixels.x[*place, :3], pixels.N[*place, 3])
            for name, value in simpler(light, V, V_D, pixels.N[*place, :3], x, omega).items():
                rows.setdefault(name, []).append((weights * value).sum())
        truth = np.array(rows.pop("truth"))
        for name, values in rows.items():
            apart = np.array(values) - truth
            cells = [np.abs(apart).mean() / truth.mean(), apart.mean() / truth.mean()]
            cells += list(np.percentile(np.abs(apart) / truth, (50, 95)))
            common.row(f"{Path(environment).stem}-{fabric}, {name}", *(100 * float(v) for v in cells))


options = common.options(__doc__, [], fabrics=common.FABRICS, size="120x90", cube=16, every=16)
common.head("environment, fabric, V", *common.PICTURE_ERRORS[:4])
with glcloth.Renderer() as renderer:
    queries = RayQueries(renderer.ctx)
    for environment in options.environments:
        measure(renderer, queries, environment, options)
