"""Picture errors of the shadows: `direct` against the reference, which traces a ray for every direction.

python tests/measure/shadows.py ENVIRONMENT... [--fabrics a,b] [--scene drape] [--mesh drape] [--size 120x90] [--cube 32]
    [--finer] [--out FOLDER]

Four rows per environment and fabric (common.picture_errors): the method's error without any shadow (off - off); what a
picture without shadows lacks (off - bounce); direct light alone (full - full, both without the bounce); and all
(bounce - bounce). With --finer one row more: the reference against itself with twice the cube's edge, without the
bounce. Strips direct | reference | difference x 8 are written. With a scene that has objects or a ground (draped)
there are rows of the cloth's pixels and of those about it. The references are kept in the folder and used again while
the options agree.
"""

from pathlib import Path

import common
import numpy as np

import glcloth

LIGHTING = {
    "off": {"shadows": "off"},
    "full": {"shadows": "full", "bounce": False},
    "bounce": {"shadows": "full", "bounce": True},
}
ROWS = (("off", "off"), ("off", "bounce"), ("full", "full"), ("bounce", "bounce"))


def kept(file, make):
    """The picture of a file, made and written when there is none."""
    if not file.is_file():
        file.parent.mkdir(parents=True, exist_ok=True)
        np.save(file, make())
    return np.load(file)


def measure(renderer, options, environment, fabric):
    base = dict(env=environment, fabric=fabric, mesh=options.mesh, size=options.size, background=False)
    stem = f"{Path(environment).stem}-{Path(fabric).stem}"
    scene = options.scene
    folder = f"reference-{Path(scene).stem}-{Path(options.mesh).stem}-{options.size}-{options.cube}"
    tests, references = {}, {}
    for name, lighting in LIGHTING.items():
        tests[name] = renderer.render(scene, method="direct", quality=options.quality, **base, **lighting)
        cloth = renderer.gbuffer.covered()

        def reference(lighting=lighting, cube=options.cube):
            return renderer.render(scene, method="reference", cube=cube, **base, **lighting)

        references[name] = kept(options.out / folder / f"{stem}-{name}.npy", reference)
    if options.finer:
        finer = reference(LIGHTING["full"], 2 * options.cube)
        errors = common.picture_errors(references["full"], finer, finer[..., 3] > 0)
        common.row(f"{stem}, reference - finer", *errors)
    for test, against in ROWS:
        a, b = tests[test], references[against]
        covered = b[..., 3] > 0
        common.row(f"{stem}, {test} - {against}", *common.picture_errors(a, b, covered & cloth))
        if (covered & ~cloth).any():
            common.row(f"{stem}, {test} - {against}, about it", *common.picture_errors(a, b, covered & ~cloth))
        common.write_strip(options.out / f"{stem}-{test}-{against}.png", a, b)


options = common.options(
    __doc__, [], fabrics=common.FABRICS, scene="drape", mesh="drape", size="120x90", cube=32, finer=False,
    quality="normal", out=Path("out/shadows"),
)  # fmt: skip
common.head("environment, fabric, direct - reference", *common.PICTURE_ERRORS)
with glcloth.Renderer() as renderer:
    for environment in options.environments:
        for fabric in options.fabrics:
            measure(renderer, options, environment, fabric)
