"""What the measuring scripts share: import paths, the command line, tables, times, errors of pictures, pixels.

Each script begins with `import common`. Then it finds the helpers of the tests, and this folder's names (mitsuba.py,
for one) no longer hide packages. Samples that are not part of the project lie in the folder `shared` beside it, or in
the one that GLCLOTH_SHARED names. Tables are printed as Markdown, as docs/*.md show them.
"""

import argparse
import os
import sys
import time
from pathlib import Path

import numpy as np

TESTS = Path(__file__).resolve().parent.parent
sys.path[:] = [str(TESTS), *(p for p in sys.path if Path(p).resolve() != TESTS / "measure")]

import glcloth  # noqa: E402
from glcloth.color import luminance  # noqa: E402
from glcloth.metrics import difference, flip  # noqa: E402

SHARED = Path(os.environ.get("GLCLOTH_SHARED") or TESTS.parent.parent / "shared")
FABRICS = ["linen", "silk_crepe_de_chine", "satin_charmeuse_front"]
QUALITIES = ("draft", "normal", "high")
PICTURE_ERRORS = ("mean", "bias", "median", "95 %", "FLIP")


def options(doc, environments=None, **defaults):
    """The options of a script. A default tells the type; a list is written with commas, False is a switch.

    `environments` are the maps if none is named; [] makes at least one obligatory, None takes none.
    """
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    if environments is not None:
        parser.add_argument("environments", nargs="*" if environments else "+", default=environments)
    for name, default in defaults.items():
        flag = "--" + name.replace("_", "-")
        if default is False:
            parser.add_argument(flag, action="store_true")
        elif isinstance(default, list):
            parser.add_argument(flag, type=lambda text: text.split(","), default=default)
        else:
            parser.add_argument(flag, type=type(default), default=default)
    found = parser.parse_args()
    if "out" in defaults:
        found.out.mkdir(parents=True, exist_ok=True)
    return found


def golden():
    """The arrays of the brute-force samples."""
    return np.load(SHARED / "golden" / "microcylinder.npz")


def row(*cells):
    """Print one row of a table; numbers get two digits."""
    print(f"| {' | '.join(f'{c:.2f}' if isinstance(c, float) else str(c) for c in cells)} |", flush=True)


def head(*cells):
    """Print the head of a table."""
    print(f"\n| {' | '.join(cells)} |\n|{'---|' * len(cells)}", flush=True)


def spread(errors, digits=2):
    """Median / 95th percentile / largest of relative errors, in %."""
    values = 100 * np.percentile(errors, (50, 95, 100))
    return " / ".join(f"{v:.{digits}f}" for v in values)


def picture_errors(test, reference, covered):
    """Five numbers of two pictures [H, W, 3+], the first four in %; see PICTURE_ERRORS.

    Mean of |difference| of luminance and difference of the means, both over the reference's mean; median and 95th
    percentile of the relative error of the covered pixels; FLIP of the whole pictures.
    """
    a, b = (luminance(p[covered][..., :3].astype(float)) for p in (test, reference))
    relative = np.abs(a - b) / np.maximum(b, 1e-3 * b.mean())
    mean, bias = np.abs(a - b).mean() / b.mean(), (a - b).mean() / b.mean()
    values = [100 * float(v) for v in (mean, bias, *np.percentile(relative, (50, 95)))]
    return [*values, f"{flip(test[..., :3], reference[..., :3]):.4f}"]


def write_strip(file, test, reference):
    """Write test | reference | difference x 8 as a picture."""
    a, b = test[..., :3], reference[..., :3]
    glcloth.write_image(file, np.hstack([a, b, difference(a, b, 8)]))


def spent(renderer, work):
    """Milliseconds (wall, CPU of all threads) that `work()` takes, drawn to the end."""
    renderer.ctx.finish()
    begin = time.perf_counter(), time.process_time()
    work()
    renderer.ctx.finish()
    return 1e3 * (time.perf_counter() - begin[0]), 1e3 * (time.process_time() - begin[1])


def set_method(renderer, name, method):
    """Have a renderer use `method` under a method's name."""
    renderer.stage.cloths[0].methods[name] = method


class Pixels:
    """Surface frames of the cloth's pixels that a renderer drew last."""

    def __init__(self, renderer):
        buffer = renderer.gbuffer
        width, height = buffer.size
        self.ray_from_pixel = buffer.ray_from_pixel
        self.N, self.x, self.p = (
            np.frombuffer(buffer.frame(name).read(), "f4").reshape(height, width, 4).astype(float)
            for name in ("frame_N", "frame_x", "frame_p")
        )
        self.covered = np.argwhere(self.N[..., 3] != 0)  # row from below, column

    def frame(self, row, column):
        """(surface_from_world [3, 3], omega_o [3] in the surface's frame) of a pixel."""
        n, t = self.N[row, column, :3], self.x[row, column, :3]
        surface_from_world = np.stack([t, self.N[row, column, 3] * np.cross(n, t), n])
        omega_o = surface_from_world @ -(self.ray_from_pixel @ [column + 0.5, row + 0.5, 1.0])
        return surface_from_world, omega_o / np.linalg.norm(omega_o)


def means(values, covered):
    """Means over 3x3 pixels, and where all nine are covered."""
    shifts = [(y, x) for y in (-1, 0, 1) for x in (-1, 0, 1)]
    whole = np.all([np.roll(covered, shift, (0, 1)) for shift in shifts], axis=0)
    return np.mean([np.roll(values, shift, (0, 1)) for shift in shifts], axis=0), whole
