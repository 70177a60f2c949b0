"""Picture errors of the methods under the same lights, and of the lights against the map.

python tests/measure/pictures.py ENVIRONMENT... [--fabrics a,b] [--size 640x480] [--map] [--out FOLDER]

A row per environment, fabric and comparison (common.picture_errors); strips test | reference | difference x 8 are
written. With --map one row more: the reference under the lights against the one under the map itself.
"""

from pathlib import Path

import common

import glcloth

VARIANTS = {"": {}, "adaptive": {"adaptive": True}, "high": {"quality": "high"}, "draft": {"quality": "draft"}}
METHODS = ["paper", "direct", "direct_adaptive", "direct_high"]

options = common.options(
    __doc__, [], fabrics=common.FABRICS, size="640x480", methods=METHODS, map=False, out=Path("out/pictures")
)
common.head("environment, fabric, test against reference", *common.PICTURE_ERRORS)
with glcloth.Renderer() as renderer:
    for environment in options.environments:
        for fabric in options.fabrics:
            scene = dict(env=environment, fabric=fabric, size=options.size, background=False, shadows="off")
            pictures = {"reference": renderer.render(method="reference", **scene)}
            for name in options.methods:
                method, _, variant = name.partition("_")
                pictures[name] = renderer.render(method=method, **scene, **VARIANTS[variant])
            tests = [(name, "reference") for name in options.methods]
            if options.map:
                pictures["map"] = renderer.render(method="reference", light="map", **scene)
                tests.append(("reference", "map"))
            for name, against in tests:
                a, b = pictures[name], pictures[against]
                where = f"{Path(environment).stem} {fabric}, {name} against {against}"
                common.row(where, *common.picture_errors(a, b, pictures["reference"][..., 3] > 0))
                common.write_strip(options.out / f"{Path(environment).stem}-{fabric}-{name}-{against}.png", a, b)
