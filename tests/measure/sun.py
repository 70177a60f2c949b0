"""Errors of the suns' shadows against 64 points on each disc and triangles cut twice; a table of docs/shadows.md.

python tests/measure/sun.py [sky FILE.hdr ...] [--fabrics linen] [--size 360x300] [--mesh drape] [--spp 1] [--keep FOLDER]

The built-in cloth at close range under the suns and the sky's Gaussians, no other shadows, all pixels: mean and 99th percentile
of |difference|, in % of the mean luminance, and CPU seconds; "before": a point, and the triangles as they are.
"""

import time
from dataclasses import replace
from pathlib import Path

import common
import numpy as np

import glcloth
from glcloth.color import luminance
from glcloth.light.lights import Lights, Suns
from glcloth.methods.reference import points_of
from glcloth.picture import stage

BATCH = 8  # points at a time
CUTS = stage.cuts


def picture(renderer, lights, cut, look):
    """A picture with the triangles cut so often, or as often as the program wants (None)."""
    stage.cuts = CUTS if cut is None else lambda *_: cut
    renderer.stage._sun_occluders.forget()
    begin = time.process_time()
    result = np.asarray(renderer.render(lights=lights, **look))[..., :3].astype(float)
    return result, time.process_time() - begin


def truth(renderer, lights, look, points=64):
    """The mean over pictures under some points of each sun."""
    every = points_of(lights.suns, points)
    total = 0.0
    for part in range(points // BATCH):
        some = slice(part, None, points // BATCH)
        suns = Suns(every.direction[some], every.irradiance[some] * (points // BATCH), 0.0)
        total = total + picture(renderer, Lights(lights.gaussians, suns), 2, look)[0] * BATCH / points
    return total


def main():
    options = common.options(
        __doc__, ["sky"], fabrics=["linen"], size="360x300", mesh="drape", spp=1, shadows="sun", keep=""
    )
    common.head("map", "fabric", "what", "mean", "99 %", "cpu s")
    mesh = glcloth.load_mesh(options.mesh)
    eye, target = (tuple((mesh.center + np.array(step)).tolist()) for step in ((0.4, 0.5, 3.0), (0.0, 0.25, 0.0)))
    camera = glcloth.Camera(eye, target, fov_deg=14.0)
    for env in options.environments:
        lights = glcloth.fit_lights(glcloth.load_environment(env))
        points = replace(lights, suns=replace(lights.suns, radius=np.zeros(len(lights.suns))))
        for fabric in options.fabrics:
            look = dict(mesh=options.mesh, fabric=fabric, camera=camera, size=options.size, shadows=options.shadows)
            look |= dict(env=env, spp=options.spp)
            with glcloth.Renderer() as renderer:
                pictures = {"judge": truth(renderer, lights, {**look, "spp": 1})}
                ways = {"before": (points, 0), "disc": (lights, 0), "cut": (points, None), "both": (lights, None)}
                for what, (light, cut) in ways.items():
                    pictures[what], seconds = picture(renderer, light, cut, look)
                    error = np.abs(luminance(pictures[what] - pictures["judge"])) / luminance(pictures["judge"]).mean()
                    figures = 100 * float(error.mean()), 100 * float(np.percentile(error, 99))
                    common.row(env, fabric, what, *figures, seconds)
            for what, result in pictures.items() if options.keep else ():
                glcloth.write_image(Path(options.keep) / f"{Path(env).stem}-{fabric}-{what}.png", result)


if __name__ == "__main__":
    main()
