"""What objects and a ground cost: CPU time (all threads) of the first picture, of one at rest and of one after the light
turned, of the built-in cloth alone, with a ground, and as scene draped.

python tests/measure/around.py [--size 640x480] [--env studio] [--times 5]
"""

import argparse
import time

import numpy as np

import glcloth

SCENES = {
    "cloth": ("drape", {}),
    "with a ground": ("drape", {"ground": "auto"}),
    "draped": ("draped", {"camera": {}}),
}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--env", default="studio")
    parser.add_argument("--times", type=int, default=5)
    options = parser.parse_args()
    print(f"{'CPU ms':16}   first  at rest   turned")
    for name, (scene, changes) in SCENES.items():
        with glcloth.Renderer() as renderer:
            base = dict(size=options.size, env=options.env, fabric="linen", env_rotate=0.0, **changes)
            renderer.draw(renderer.prepare(scene, **base | {"size": "32x24", "mesh": "sphere"}))  # compiles

            def cost(degrees, scene=scene, base=base, renderer=renderer):
                frame = renderer.prepare(scene, **base | {"env_rotate": degrees})
                renderer.ctx.finish()
                begin = time.process_time()
                renderer.draw(frame)
                renderer.ctx.finish()
                return 1e3 * (time.process_time() - begin)

            first = cost(0.0)
            rest = np.median([cost(0.0) for _ in range(options.times)])
            turned = np.median([cost(10.0 * n) for n in range(1, options.times + 1)])
            print(f"{name:16}{first:8.0f} {rest:8.0f} {turned:8.0f}", flush=True)


if __name__ == "__main__":
    main()
