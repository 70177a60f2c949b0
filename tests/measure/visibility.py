"""What a pixel may know of its visibility, and what that costs in accuracy.

python tests/measure/visibility.py ENVIRONMENT... [--fabrics a,b] [--size 120x90] [--cube 16] [--every 16]

Every so many covered pixels of the built-in cloth get rays in every direction of a cube map. Against the sum of f_cloth
times light times V over them, each row sums f_cloth times light times a simpler V: one mean for each Gaussian, flat or
by the cosine; or one of all light together, by six means about the world's axes, the best quadratic, the nine parts that
method `direct` has (also from its 256 directions alone); or one for each Gaussian with a linear gradient. Printed in %:
the mean of |difference| and the difference of the means over the mean, median and 95th percentile of the relative error.
"""

import argparse
from pathlib import Path

import numpy as np
from test_truth import model

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


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("environments", nargs="+")
    parser.add_argument("--fabrics", default="linen,silk_crepe_de_chine,satin_charmeuse_front")
    parser.add_argument("--size", default="120x90")
    parser.add_argument("--cube", type=int, default=16)
    parser.add_argument("--every", type=int, default=16)
    options = parser.parse_args()
    D, omega_w, solid_angle = (
        world_directions(256),
        cubemap.directions(options.cube),
        cubemap.solid_angles(options.cube),
    )
    shares, quadratic = cube_shares(omega_w), quadratics(omega_w)
    print(f"{'environment, fabric, V':70}   mean %   bias %  median     95 %")
    with glcloth.Renderer() as renderer:
        queries = RayQueries(renderer.ctx)
        for environment in options.environments:
            base = dict(env=environment, size=options.size, background=False, shadows="off")
            frame = renderer.prepare(**base)
            renderer.draw(frame)
            buffer, (width, height) = renderer.gbuffer, frame.scene.size
            structure = renderer.stage.occluders(frame)
            N, x, p = (
                np.frombuffer(t.read(), "f4").reshape(height, width, 4).astype(float)
                for t in map(buffer.frame, ("frame_N", "frame_x", "frame_p"))
            )
            places = np.argwhere(N[..., 3] != 0)[:: options.every]
            seen = [
                [~queries.any_hit(structure, np.repeat(p[i, j, None, :3], len(d), 0), d) for i, j in places]
                for d in (omega_w, D)
            ]
            g = frame.lights.gaussians
            flux = [
                cubemap.average_gaussians(
                    g.axis[k : k + 1], g.sharpness[k : k + 1], g.amplitude[k : k + 1], options.cube
                )
                for k in range(len(g))
            ]
            flux = np.array(flux) * solid_angle[:, None]
            total = luminance(flux.sum(0))
            light = total / total.sum() * 4 * np.pi / solid_angle + 0.02
            light_256 = luminance(g.radiance(D))
            light_256 = light_256 / light_256.mean() + 0.02
            for fabric in options.fabrics.split(","):
                description = model(glcloth.load_fabric(fabric))
                rows = {}
                for (i, j), V, V_256 in zip(places, *seen, strict=True):
                    n, t = N[i, j, :3], x[i, j, :3]
                    to_surface = np.stack([t, N[i, j, 3] * np.cross(n, t), n])
                    ray = buffer.ray_from_pixel @ [j + 0.5, i + 0.5, 1.0]
                    omega_o = to_surface @ (-ray / np.linalg.norm(ray))
                    omega = omega_w @ to_surface.T
                    weights = luminance(flux * cloth.f_cloth(omega, omega_o[None], *description))
                    flat, V = flat_weight(omega[:, 2]), V.astype(float)
                    here = np.append(t, N[i, j, 3])
                    of_each = luminance(flux) * flat
                    of_cosine = luminance(flux) * np.maximum(omega[:, 2], 0.0)
                    w = solid_angle * light * flat
                    normal = (quadratic * w[:, None]).T @ quadratic
                    fitted = np.linalg.solve(normal + 0.002 * np.trace(normal) * np.eye(9), quadratic.T @ (w * V))
                    six = (w * V) @ shares + 1e-4 * w.sum()
                    six /= w @ shares + 1e-4 * w.sum()
                    narrowed = np.minimum(g.sharpness, 64.0)
                    tables = np.exp(narrowed[:, None] * (g.axis @ omega_w.T - 1.0)) * solid_angle * flat
                    for name, value in {
                        "truth": V,
                        "no shadows": 1.0,
                        "one for each, flat": (of_each @ V / np.maximum(of_each.sum(1), 1e-30))[:, None],
                        "one for each, by the cosine": (of_cosine @ V / np.maximum(of_cosine.sum(1), 1e-30))[:, None],
                        "of all, six means of the world": shares @ six,
                        "of all, best quadratic": np.clip(quadratic @ fitted, 0.0, 1.0),
                        "of all, nine parts": nine_parts(V, n, here, omega_w, solid_angle * light, omega),
                        "of all, nine parts, 256 directions": nine_parts(V_256, n, here, D, light_256, omega),
                        "one for each, with a gradient": np.array([with_gradient(V, k, omega_w) for k in tables]),
                    }.items():
                        rows.setdefault(name, []).append((weights * value).sum())
                truth = np.array(rows.pop("truth"))
                for name, values in rows.items():
                    apart = np.array(values) - truth
                    relative = np.abs(apart) / truth
                    line = [np.abs(apart).mean() / truth.mean(), apart.mean() / truth.mean()]
                    line += [np.median(relative), np.percentile(relative, 95)]
                    where = f"{Path(environment).stem}-{fabric}, {name}"
                    print(f"{where:70}" + "".join(f"{100 * v:9.2f}" for v in line), flush=True)


if __name__ == "__main__":
    main()
