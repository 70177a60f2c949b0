"""What objects and a ground cost, in ms of CPU time of all threads; a table of docs/shadows.md.

python tests/measure/around.py [--size 640x480] [--env studio] [--times 5]

The first picture, the same again, and one after the light turned: of the built-in cloth, with a ground, and as scene
`draped`.
"""

import common
import numpy as np

import glcloth

SCENES = {"cloth": ("drape", {}), "with a ground": ("drape", {"ground": "auto"}), "draped": ("draped", {"camera": {}})}

options = common.options(__doc__, size="640x480", env="studio", times=5)
common.head("scene", "first", "at rest", "turned")
for name, (scene, changes) in SCENES.items():
    with glcloth.Renderer() as renderer:
        base = dict(size=options.size, env=options.env, fabric="linen", env_rotate=0.0, **changes)
        renderer.draw(renderer.prepare(scene, **base | {"size": "32x24", "mesh": "sphere"}))  # compiles

        def cost(degrees, scene=scene, base=base, renderer=renderer):
            frame = renderer.prepare(scene, **base | {"env_rotate": degrees})
            return common.spent(renderer, lambda: renderer.draw(frame))[1]

        first = cost(0.0)
        rest = np.median([cost(0.0) for _ in range(options.times)])
        turned = np.median([cost(10.0 * n) for n in range(1, options.times + 1)])
        common.row(name, *(f"{ms:.0f}" for ms in (first, rest, turned)))
