"""A film of threads near by: does a zoom step, does moire run, do threads crawl when the cloth turns or the camera orbits?

python tests/measure/weave_film.py [zoom orbit turn] [--fabrics denim_raw] [--frames 24] [--size 160x120] [--film FOLDER]

zoom: a plane at 35 degrees, 1 cm to 3 m of it across the picture. orbit: the camera goes round an outline of the built-in cloth
by 4 degrees, 4 cm across. turn: the plane turns by 4 degrees, likewise. For orbit and turn the table says how much frames differ
from frames of 16 samples, and how much of that differs from frame to frame (crawling): rms of luminance, % of the mean, by the
samples of a pixel. The frames and a contact sheet are written to folders in that of --film.
"""

import sys
from itertools import pairwise
from pathlib import Path

import common
import numpy as np
from PIL import Image

import glcloth
from glcloth.color import luminance, srgb_encode
from glcloth.geometry.camera import Camera

sys.path.append(str(Path(__file__).parent))
import weave

ANGLE = 4.0  # degrees of a turn


def zoom_view(t, aspect):
    return weave.view(35, 70, 0.01 * 300.0**t, aspect)


def turn_view(t, aspect):
    return weave.view(35, 70 + ANGLE * t, 0.04, aspect)


def orbit_view(t, aspect):
    still = weave.edge_view(0.04, aspect)
    angle = np.radians(ANGLE * (t - 0.5))
    x, y, z = np.subtract(still.eye, still.target)
    around = (x * np.cos(angle) + z * np.sin(angle), y, z * np.cos(angle) - x * np.sin(angle))
    return Camera(tuple(np.add(still.target, around)), still.target, still.up, still.fov_deg)


VIEWS = {"zoom": zoom_view, "orbit": orbit_view, "turn": turn_view}


def frames(renderer, what, name, count, size, samples):
    mesh = "drape" if what == "orbit" else weave.sheet(30.0, 30.0)
    look = {"fabric": name, "mesh": mesh, "size": size, "shadows": "off", "spp": samples, "background": what == "orbit"}
    for n in range(count):
        camera = VIEWS[what](n / max(count - 1, 1), size[0] / size[1])
        yield np.asarray(renderer.render(camera=camera, **look))[..., :3].astype(float)


def contact_sheet(pictures, path):
    mean = np.mean([picture.mean() for picture in pictures])
    codes = [np.round(255 * srgb_encode((picture * 0.3 / mean).clip(0, 1))).astype("u1") for picture in pictures]
    path.mkdir(parents=True, exist_ok=True)
    for number, picture in enumerate(codes):
        Image.fromarray(picture).save(path / f"{number:04d}.png")
    across = min(6, len(codes))
    rows = [np.concatenate(codes[i : i + across], 1) for i in range(0, len(codes) // across * across, across)]
    Image.fromarray(np.concatenate(rows)).save(path / "sheet.png")


def main():
    options = common.options(
        __doc__, ["zoom", "orbit", "turn"], fabrics=["denim_raw"], frames=24, size="160x120", film=Path()
    )
    size = tuple(map(int, options.size.split("x")))
    with glcloth.Renderer() as renderer:
        common.head("view", "fabric", "samples", "off 16 samples", "of that, from frame to frame", "the picture itself")
        for what in options.environments:
            for name in options.fabrics:
                film(renderer, what, name, options, size)


def film(renderer, what, name, options, size):
    """A row for each number of samples; of a zoom the film alone."""
    if what == "zoom":
        pictures = list(frames(renderer, what, name, options.frames, size, 4))
        contact_sheet(pictures, options.film / f"{what}_{name}")
        return
    judge = [luminance(f) for f in frames(renderer, what, name, options.frames, size, 16)]
    mean = np.mean(judge)
    for samples in (1, 4):
        pictures = list(frames(renderer, what, name, options.frames, size, samples))
        off = [luminance(f) - j for f, j in zip(pictures, judge, strict=True)]
        crawls = [b - a for a, b in pairwise(off)]
        moves = [b - a for a, b in pairwise(judge)]
        rms = (100 * float(np.sqrt(np.mean(np.square(x)))) / mean for x in (off, crawls, moves))
        common.row(f"{what} | {name}", str(samples), *rms)
    contact_sheet(pictures, options.film / f"{what}_{name}")


if __name__ == "__main__":
    main()
