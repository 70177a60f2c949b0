"""Moving cloth: a curtain whose vertices follow from pose to pose against one that is traced anew in every frame.

python tests/measure/moving_shadows.py [--frames 26] [--size 240x180]

Linen in the wind under the sky. Printed: CPU seconds a frame of both; the mean |difference| of luminance over the mean;
the rms change of the picture from frame to frame, and that of the difference (flicker), in % of the mean.
"""

import common
import numpy as np

import glcloth
from glcloth.color import luminance
from glcloth.curtain.hanging import CurtainParameters, CurtainSimulation

SKIPPED = 5  # frames at the start, in which followed vertices are all traced anew

options = common.options(__doc__, frames=26, size="240x180")
camera = glcloth.Camera(eye=(1.0, 1.5, 3.6), target=(0.05, 1.25, 0.1), fov_deg=40.0)
scene = dict(fabric="linen", env="sky", camera=camera, size=options.size, background=False, shadows="full")
pictures, times = {"anew": [], "followed": []}, {"anew": [], "followed": []}
with glcloth.Renderer() as anew:
    renderers = {"anew": anew, "followed": glcloth.Renderer(ctx=anew.ctx)}
    renderers["followed"].follow_poses()
    curtain = CurtainSimulation(anew.ctx, CurtainParameters(wind=0.8, mass=0.1))
    for _ in range(options.frames):
        curtain.step(1 / 25)
        mesh = curtain.mesh()
        for name, renderer in renderers.items():

            def draw(name=name, renderer=renderer, mesh=mesh):
                picture = renderer.render(mesh=mesh, **scene)
                pictures[name].append(luminance(picture[..., :3]) * (picture[..., 3] > 0))

            times[name].append(common.spent(renderer, draw)[1])
    curtain.release()
a, b = (np.array(pictures[name])[SKIPPED:] for name in pictures)
covered = a > 0
mean = a[covered].mean()


def change(x):
    both = covered[1:] & covered[:-1]
    return 100 * np.sqrt(np.square((x[1:] - x[:-1])[both]).mean()) / mean


print("CPU s a frame:", *(f"{name} {np.median(ms[SKIPPED:]) / 1e3:.2f}" for name, ms in times.items()))
print(f"mean difference {100 * np.abs(b - a)[covered].mean() / mean:.2f} %")
print(f"change a frame: anew {change(a):.2f} %, followed {change(b):.2f} %, difference {change(b - a):.2f} %")
