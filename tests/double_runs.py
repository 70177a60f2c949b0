"""Each dispatch twice from the same memory, and work on poisoned memory: what tests and tests/measure/races.py share."""

import curtain_scenes as scenes
import numpy as np

from glcloth.accel.triangles import Triangles
from glcloth.curtain.show import CurtainShow
from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.gpu.buffers import Buffer
from glcloth.gpu.programs import Compute
from glcloth.scene import CurtainParameters, Scene
from glcloth.tracing.lamp import Lamp, Lighting
from glcloth.tracing.shot import Shot, TraceSettings
from glcloth.tracing.tracer import Tracer

# Passes that place what they write by atomic counters: the order of the list depends on timing, its content does not.
PLACED = {
    "passes/accel/kdtree_divide.comp": "numbers of nodes, places of references",
    "passes/accel/kdtree_masks.comp": "places in the list of small nodes",
    "passes/accel/kdtree_small.comp": "numbers of nodes",
    "passes/tracing/sort.comp": "order of rays",
    "passes/tracing/shade.comp": "places in the next generation's queue",
    "passes/accel/lbvh_boxes.comp": "who arrives first at a node",
}


class Lit:
    """Photons in a room with a curtain, through its tree: a context manager; members as of `Work`."""

    OWN = "_slots", "_found", "_begins", "_photons", "_gathered", "_radii", "_node_light"  # that a sample writes anew

    def __init__(self, ctx):
        curtain = CurtainParameters(quads=(24, 6), pleats=3, settle=0.05)
        self.show = CurtainShow(ctx, Scene(size=(16, 16), gi="photons", photons=3000, curtain=curtain, depth=2))

    def run(self):
        self.picture = self.show.picture()

    def result(self):
        tree = self.show.photons.tree
        return {"picture": self.picture, "points": tree.positions(), **tree.arrays()}

    def poison(self, byte):
        """Fill every buffer that a sample writes anew."""
        light = self.show.photons
        trees = light.tree, light._gathered_tree
        things = [getattr(light, name) for name in self.OWN] + [b for tree in trees for b in tree._buffers.values()]
        for buffer in {id(b): b for b in things}.values():
            buffer.write(bytes([byte]) * buffer.size)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.show.release()


class Work:
    """A curtain in a room, built and traced; a context manager.

    `run` does it once, `result` is the tree and the picture.
    """

    def __init__(self, ctx, accelerator, triangles, size):
        soup = scenes.scene(triangles, 1.0)
        self.triangles, self.tracer, self.accelerator = Triangles(ctx, len(soup), 5.0), Tracer(ctx), accelerator
        self.triangles.set(0, soup, None, None, np.where(np.arange(len(soup)) < 146, 1, 0))
        self.tracer.set_scene(self.triangles, np.array([[0, 0, 0], [0.5, 0.4, 0.3]]))
        camera, light = Camera((0.9, 1.5, 3.6), (-0.1, 1.25, 0.0)), Lighting(Lamp((0.5, 3.0, -4.0), (90.0, 90.0, 90.0)))
        self.shot = Shot(
            camera, size, load_fabric("sheer_voile"), light, settings=TraceSettings(accelerator=accelerator)
        )

    def run(self):
        self.tracer.build(self.accelerator)
        self.picture = self.tracer.trace(self.shot)

    def result(self):
        arrays = self.tracer.structure(self.accelerator).arrays()
        return {name: value for name, value in arrays.items()} | {"picture": self.picture}

    def poison(self, byte):
        """Fill every buffer that a frame writes anew."""
        rays = self.tracer._rays
        things = [*vars(rays).values(), *(b for g in rays._generations for b in vars(g).values()), self.tracer.picture]
        things += self.tracer.structure(self.accelerator)._buffers.values()
        for buffer in {id(b): b for b in things if isinstance(b, Buffer)}.values():
            buffer.write(bytes([byte]) * buffer.size)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.tracer.release()
        self.triangles.release()


def works(ctx, triangles, size):
    """{name: a context manager with `run`, `result` and `poison`} of what is run twice."""
    trees = {name: lambda name=name: Work(ctx, name, triangles, size) for name in ("kdtree", "kdtree_median", "lbvh")}
    return {**trees, "photons": lambda: Lit(ctx)}


def twice(work, restore=True):
    """Do some work, each dispatch of it twice from the same memory: {path: (dispatches, how many wrote something else)}.

    restore : False plants a fault: the second begins with what the first one left
    """
    found = {}

    def doubled(original, inputs_at):
        def run(self, *given, **own):
            names = {}
            for mapping in (*inputs_at(given), own):
                names |= mapping
            written = [n for n, slot in self.slots.items() if slot.kind in ("block", "image") and slot.writes]
            blocks = [names[n] for n in written if names.get(n) is not None]
            before = [b.read() for b in blocks]
            original(self, *given, **own)
            first = [b.read() for b in blocks]
            if restore:
                for buffer, data in zip(blocks, before, strict=True):
                    buffer.write(data)
            original(self, *given, **own)
            differ = first != [b.read() for b in blocks]
            runs, others = found.get(self.path, (0, 0))
            found[self.path] = runs + 1, others + differ

        return run

    kept = Compute._dispatch, Compute.run_indirect
    Compute._dispatch = doubled(kept[0], lambda given: (*given[2], given[3]))
    Compute.run_indirect = doubled(kept[1], lambda given: given[1:])
    try:
        work()
    finally:
        Compute._dispatch, Compute.run_indirect = kept
    return found
