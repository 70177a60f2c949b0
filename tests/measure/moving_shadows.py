"""Moving cloth: a curtain whose vertices follow from pose to pose against one that is looked at anew in every frame.

python tests/measure/moving_shadows.py [FRAMES]

Linen in the wind under the sky, 240 x 180. Printed: CPU seconds a frame of both; the mean |difference| of luminance over
the mean; the rms change of the picture from frame to frame, and that of the difference (flicker), in % of the mean.
"""

import sys
import time

import numpy as np

import glcloth
from glcloth.color import luminance
from glcloth.curtain.hanging import CurtainParameters, CurtainSimulation

SKIPPED = 5  # frames at the start, in which followed vertices are all traced anew


def main():
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 26
    camera = glcloth.Camera(eye=(1.0, 1.5, 3.6), target=(0.05, 1.25, 0.1), fov_deg=40.0)
    pictures, seconds = {"anew": [], "followed": []}, {"anew": [], "followed": []}
    with glcloth.Renderer() as anew:
        renderers = {"anew": anew, "followed": glcloth.Renderer(ctx=anew.ctx)}
        renderers["followed"].follow_poses()
        curtain = CurtainSimulation(anew.ctx, CurtainParameters(wind=0.8, mass=0.1))
        scene = dict(fabric="linen", env="sky", camera=camera, size=(240, 180), background=False, shadows="full")
        for _ in range(frames):
            curtain.step(1 / 25)
            mesh = curtain.mesh()
            for name, renderer in renderers.items():
                begin = time.process_time()
                picture = renderer.render(mesh=mesh, **scene)
                seconds[name].append(time.process_time() - begin)
                pictures[name].append(luminance(picture[..., :3]) * (picture[..., 3] > 0))
        curtain.release()
    a, b = (np.array(pictures[name])[SKIPPED:] for name in pictures)
    covered = a > 0
    mean = a[covered].mean()

    def change(x):
        both = covered[1:] & covered[:-1]
        return 100 * np.sqrt(np.square((x[1:] - x[:-1])[both]).mean()) / mean

    print("CPU s a frame:", *(f"{name} {np.median(times[SKIPPED:]):.2f}" for name, times in seconds.items()))
    print(f"mean difference {100 * np.abs(b - a)[covered].mean() / mean:.2f} %")
    print(f"change a frame: anew {change(a):.2f} %, followed {change(b):.2f} %, difference {change(b - a):.2f} %")


if __name__ == "__main__":
    main()
