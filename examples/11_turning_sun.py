"""A curtain in the wind under a turning sun: its folds hide the sun from each other and light each other.

python examples/11_turning_sun.py [out/11_turning_sun/%04d.png [WxH [FRAMES]]]     (or out/11_turning_sun.mp4)
"""

import sys
from pathlib import Path

import numpy as np
from common import needs, output

import glcloth
from glcloth import progress
from glcloth.curtain.hanging import CurtainParameters, CurtainSimulation
from glcloth.light.environment import load_environment
from glcloth.light.fit import fit_lights
from glcloth.picture.sequence_files import write_frames, write_video

path = str(output(sys.argv[1] if len(sys.argv) > 1 else "out/11_turning_sun/%04d.png"))
if path.endswith(".mp4"):
    needs("av", "video")
size = sys.argv[2] if len(sys.argv) > 2 else "320x240"
frames = int(sys.argv[3]) if len(sys.argv) > 3 else 24
rate = 25
camera = glcloth.Camera(eye=(1.0, 1.5, 3.6), target=(0.05, 1.25, 0.1), fov_deg=40.0)
sun = fit_lights(load_environment("sky"), 10).suns.direction[0]
# From 65 degrees on one side of the curtain's front, which is +z, to 65 on the other.
straight = -np.degrees(np.arctan2(sun[0], sun[2]))
turns = straight + np.linspace(-65.0, 65.0, frames)


def pictures(renderer):
    curtain = CurtainSimulation(renderer.ctx, CurtainParameters(wind=0.8, mass=0.1))
    renderer.follow_poses()
    for turn in turns:
        curtain.step(1 / rate)
        scene = dict(mesh=curtain.mesh(), env="sky", env_rotate=turn, camera=camera, size=size, spp=4)
        yield renderer.render(fabric="linen", shadows="full", **scene)
    curtain.release()


with glcloth.Renderer() as renderer:
    look = 0.0, "standard"
    film = pictures(renderer)
    written = (
        write_video(film, Path(path), rate, *look) if path.endswith(".mp4") else write_frames(film, path, 0, {}, *look)
    )
    for _ in progress.track(written, f"{path}: frames", frames):
        pass
