"""200 generated drafts, every second one with a planted error, and files: a picture or one line each, and how long that takes.

python tests/measure/drafts.py [FILES ...] [--size 640x480] [--threads]

Seconds from the file's name to its picture in a renderer that runs already (wall and CPU), and of each refusal.
The first of each number of tangents waits for its program.
"""

import sys
import tempfile
import time

import common
import numpy as np

sys.path.insert(0, str(common.TESTS / "values"))
from test_weave_drafts import ERRORS, generated

from glcloth.errors import InputError
from glcloth.picture.renderer import Renderer


def files(folder):
    """Generated drafts and damaged ones, in turn."""
    for seed in range(200):
        rng = np.random.default_rng(seed)
        text = generated(rng)[0] if seed % 2 else list(ERRORS.values())[seed // 2 % len(ERRORS)][0](rng)
        path = common.Path(folder) / f"{seed}.wif"
        path.write_text(text, encoding="utf-8", newline="")
        yield path


def main():
    given = common.options(__doc__, [], size="640x480", threads=False)
    size = tuple(map(int, given.size.split("x")))
    pictures, lines = [], []
    with tempfile.TemporaryDirectory() as folder, Renderer() as renderer:
        renderer.render(fabric="denim_raw", size=size, threads=given.threads)
        for path in [*files(folder), *map(common.Path, given.environments)]:
            wall, cpu = time.perf_counter(), time.process_time()
            try:
                picture = renderer.render(
                    fabric=str(path), size=size, threads=given.threads, shadows="off", adaptive=True
                )
                assert np.isfinite(picture).all() and picture.max() > 0.0
                found = pictures
            except InputError as error:
                assert str(error).isprintable() and len(str(error)) <= 300, error
                found = lines
            found.append((time.perf_counter() - wall, time.process_time() - cpu, path.name))
    common.row("", "count", "median s", "longest s", "CPU median s", "CPU longest s", "CPU over 1 s", "longest")
    for name, found in (("picture", pictures), ("one line", lines)):
        wall, cpu = (np.array([one[k] for one in found]) for k in (0, 1))
        longest = found[int(np.argmax(wall))][2]
        numbers = float(np.median(wall)), float(wall.max()), float(np.median(cpu)), float(cpu.max())
        common.row(name, len(found), *numbers, int((cpu > 1.0).sum()), longest)


if __name__ == "__main__":
    main()
