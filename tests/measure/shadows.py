"""Picture errors of the shadows: `direct` against the reference that traces a ray for every direction, under the same lights.

python tests/measure/shadows.py ENVIRONMENT... [--fabrics a,b] [--scene drape] [--mesh drape] [--size 120x90] [--cube 32]
    [--finer] [--out FOLDER]

Four rows per environment and fabric: what the method errs without any shadow (off - off); what a picture without
shadows lacks (off - bounce); direct light alone (full - full, both without the bounce); and all (bounce - bounce).
Printed in %: the mean of |difference| of luminance and the difference of the means, both over the mean of the
reference; the median and the 95th percentile of the relative error of covered pixels; and FLIP. With --finer one row
more: the reference against itself with twice the cube's edge, without the bounce. Strips direct |
reference | difference x 8 are written. With a scene that has objects or a ground (draped) the rows are of the cloth's
pixels, and of those about it. The references are kept in the folder and used again while the options agree.
"""

import argparse
from pathlib import Path

import numpy as np

import glcloth
from glcloth.color import luminance
from glcloth.metrics import difference, flip

LIGHTING = {
    "off": {"shadows": "off"},
    "full": {"shadows": "full", "bounce": False},
    "bounce": {"shadows": "full", "bounce": True},
}
ROWS = (("off", "off"), ("off", "bounce"), ("full", "full"), ("bounce", "bounce"))


def row(name, test, reference, covered):
    """One line of the table."""
    a, b = luminance(test[covered].astype(float)), luminance(reference[covered].astype(float))
    relative = np.abs(a - b) / np.maximum(b, 1e-3 * b.mean())
    mean, bias = np.abs(a - b).mean() / b.mean(), (a - b).mean() / b.mean()
    values = 100 * np.array([mean, bias, np.median(relative), np.percentile(relative, 95)])
    print(f"{name:52}" + "".join(f"{v:9.2f}" for v in values) + f"{flip(test, reference):9.4f}", flush=True)


def kept(file, make):
    """The picture of a file, made and written when there is none."""
    if not file.is_file():
        file.parent.mkdir(parents=True, exist_ok=True)
        np.save(file, make())
    return np.load(file)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("environments", nargs="+")
    parser.add_argument("--fabrics", default="linen,silk_crepe_de_chine,satin_charmeuse_front")
    parser.add_argument("--scene", default="drape")
    parser.add_argument("--mesh", default="drape")
    parser.add_argument("--size", default="120x90")
    parser.add_argument("--cube", type=int, default=32)
    parser.add_argument("--finer", action="store_true")
    parser.add_argument("--quality", default="normal")
    parser.add_argument("--out", type=Path, default=Path("out/shadows"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    print(f"{'environment, fabric, direct - reference':52}   mean %   bias %  median     95 %     FLIP")
    with glcloth.Renderer() as renderer:
        for environment in options.environments:
            for fabric in options.fabrics.split(","):
                base = dict(env=environment, fabric=fabric, mesh=options.mesh, size=options.size, background=False)
                stem = f"{Path(environment).stem}-{Path(fabric).stem}"
                kept_in = (
                    f"reference-{Path(options.scene).stem}-{Path(options.mesh).stem}-{options.size}-{options.cube}"
                )
                folder = options.out / kept_in
                tests, references = {}, {}
                for name, lighting in LIGHTING.items():
                    scene = base | lighting
                    tests[name] = renderer.render(options.scene, method="direct", quality=options.quality, **scene)
                    cloth = renderer.gbuffer.covered()
                    references[name] = kept(
                        folder / f"{stem}-{name}.npy",
                        lambda scene=scene: renderer.render(
                            options.scene, method="reference", cube=options.cube, **scene
                        ),
                    )
                if options.finer:
                    scene = base | LIGHTING["full"] | {"method": "reference", "cube": 2 * options.cube}
                    finer = renderer.render(options.scene, **scene)
                    row(f"{stem}, reference - finer", references["full"][..., :3], finer[..., :3], finer[..., 3] > 0)
                for test, against in ROWS:
                    a, b = tests[test][..., :3], references[against][..., :3]
                    covered = references[against][..., 3] > 0
                    row(f"{stem}, {test} - {against}", a, b, covered & cloth)
                    if (covered & ~cloth).any():
                        row(f"{stem}, {test} - {against}, about it", a, b, covered & ~cloth)
                    strip = np.hstack([a, b, difference(a, b, 8)])
                    glcloth.write_image(options.out / f"{stem}-{test}-{against}.png", strip)


if __name__ == "__main__":
    main()
