"""Picture errors of the methods: paper and direct against the reference under the same lights, and the lights against the map.

python tests/measure/pictures.py ENVIRONMENT... [--fabrics a,b] [--size 640x480] [--out FOLDER]

Prints a row per environment, fabric and comparison: the mean of |difference| of luminance over the mean of the
reference, the median and 95th percentile of the relative error of covered pixels (all in %), and FLIP; and writes strips
test | reference | difference x 8.
"""

import argparse
from pathlib import Path

import numpy as np

import glcloth
from glcloth.color import luminance
from glcloth.metrics import difference, flip


def row(name, test, reference, covered):
    """One line of the table."""
    a, b = luminance(test[covered].astype(float)), luminance(reference[covered].astype(float))
    relative = np.abs(a - b) / np.maximum(b, 1e-3 * b.mean())
    values = 100 * np.array([np.abs(a - b).mean() / b.mean(), np.median(relative), np.percentile(relative, 95)])
    print(f"{name:62}" + "".join(f"{v:9.2f}" for v in values) + f"{flip(test, reference):9.4f}", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("environments", nargs="+")
    parser.add_argument("--fabrics", default="linen,silk_crepe_de_chine,satin_charmeuse_front")
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--methods", default="paper,direct,direct_adaptive,direct_high")
    parser.add_argument(
        "--map", action="store_true", help="also the reference under the map against that under the lights"
    )
    parser.add_argument("--out", type=Path, default=Path("out/pictures"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    print(f"{'environment, fabric, test against reference':62}   mean %  median     95 %     FLIP")
    with glcloth.Renderer() as renderer:
        for environment in options.environments:
            for fabric in options.fabrics.split(","):
                scene = dict(env=environment, fabric=fabric, size=options.size, background=False, shadows="off")
                pictures = {"reference": renderer.render(method="reference", **scene)}
                covered = pictures["reference"][..., 3] > 0
                tests = [(m, "reference") for m in options.methods.split(",")]
                if options.map:
                    pictures["map"] = renderer.render(method="reference", light="map", **scene)
                    tests.append(("reference", "map"))
                for name, against in tests:
                    if name not in pictures:
                        method, _, variant = name.partition("_")
                        changes = {"adaptive": {"adaptive": True}, "": {}}.get(variant, {"quality": variant})
                        pictures[name] = renderer.render(method=method, **scene, **changes)
                    a, b = pictures[name][..., :3], pictures[against][..., :3]
                    where = f"{Path(environment).name} {fabric}"
                    row(f"{where}, {name} against {against}", a, b, covered)
                    strip = np.hstack([a, b, difference(a, b, 8)])
                    file = options.out / f"{Path(environment).stem}-{fabric}-{name}-{against}.png"
                    glcloth.write_image(file, strip)


if __name__ == "__main__":
    main()
