"""What a frame asks of the GPU, which does not depend on the machine: waits of the CPU, dispatches, how small these are.

What keeps a real GPU waiting is named here (docs of the road: ../shared/design/facts-gpu.md); it may become less.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from glcloth.curtain.show import CurtainShow
from glcloth.gpu.buffers import Buffer
from glcloth.gpu.programs import Compute, programs
from glcloth.gpu.tally import Counted, counting
from glcloth.light.lights import Lights, SphericalGaussians
from glcloth.scene import CurtainParameters, Scene

LIGHTS = Lights(SphericalGaussians([[0, 1, 0]], [3.0], [[1.0, 1.0, 1.0]]))
SIZE = (64, 48)
# Passes of fewer than FEW invocations on the road of a frame of 12,786 triangles, and why.
FEW = 32
SMALL = {
    "passes/accel/kdtree_root.comp": "one root",
    "passes/accel/kdtree_level.comp": "the counters of a level",
    "passes/accel/kdtree_order.comp": "one work group",
    "passes/simulation/strips.comp": "one a strip",
    "passes/tracing/generation.comp": "the counters of a generation",
}
# Likewise of work groups of fewer, of which there are many.
SMALL_GROUPS = {"passes/accel/kdtree_masks.comp": "one a small node, whose references are at most 64; 32 was no faster"}


@pytest.fixture(scope="module")
def curtain(session_ctx):
    with (
        session_ctx,
        CurtainShow(session_ctx, Scene(size=SIZE, gi="off", curtain=CurtainParameters(settle=0.05))) as show,
    ):
        assert show.triangles.count == 12_786
        show.picture()
        yield show


def frame_of(curtain, ctx):
    """What a frame of the moving curtain asks for: its motion, its tree, and its picture, which stays on the GPU."""
    parts = []
    for work in (curtain.advance, curtain.build, lambda: list(curtain.tracer.steps(curtain.shot()))):
        with counting(ctx) as counted:
            work()
        parts.append(counted)
    return parts


def test_a_frame_of_cloth_waits_for_its_picture_alone(ctx, renderer):
    frame = renderer.prepare(mesh="plane", lights=LIGHTS, size=SIZE, shadows="off", background=False)
    renderer.draw(frame)
    with counting(ctx) as window:
        renderer.draw(frame)
    assert window == Counted()
    with counting(ctx) as picture:
        renderer.render_frame(frame)
    assert (picture.reads, picture.read_bytes, picture.dispatched) == (1, 16 * SIZE[0] * SIZE[1], 0)


def test_a_frame_of_the_curtain_waits_as_often_as_is_said(ctx, curtain):
    """In the window not once: whether tree and rays had room is looked at when the GPU has come so far, before the frame is
    shown. A picture is read, and the counters with it."""
    window = frame_of(curtain, ctx)
    assert [(part.reads, part.read_bytes) for part in window] == [(0, 0)] * 3
    with counting(ctx) as picture:
        curtain.advance()
        curtain.picture()
    assert picture.reads == 1 and picture.read_bytes < 16 * SIZE[0] * SIZE[1] + 2048
    # Nothing was left unread, and nothing was made twice.
    assert curtain.tracer.structure("kdtree").unread is None and curtain.tracer.remade == 0
    assert len(curtain.tracer.statistics.rays) == 4 and curtain.tracer.statistics.rays[0] >= SIZE[0] * SIZE[1]


@pytest.mark.parametrize("short_of", ["levels", "references", "rays", "heads"])
def test_a_frame_that_had_no_room_is_made_again(ctx, curtain, monkeypatch, short_of):
    expected = curtain.picture()
    tracer, tree = curtain.tracer, curtain.tracer.structure("kdtree")

    def plant():
        curtain._built.clear()
        if short_of == "levels":
            tree._levels = 2, 2
        elif short_of == "references":
            tree._capacity["ref"] = 8000  # of memory that is larger
        elif short_of == "rays":
            for generation in tracer._rays._generations[1:]:
                generation.capacity = 64
        else:
            tracer._rays._head_capacity = 512

    monkeypatch.setattr(type(tracer._rays), "_make_room", lambda *_: None)
    monkeypatch.setattr(type(tree), "at_first", {})
    for look in (curtain.picture, lambda: drawn(curtain, ctx)):
        before = tracer.remade
        plant()
        np.testing.assert_array_equal(look(), expected)
        assert tracer.remade > before
        np.testing.assert_array_equal(look(), expected)


def test_who_else_looks_at_the_tree_of_a_frame_finds_it_whole(ctx, curtain, monkeypatch):
    """A picture of the tree in the middle of a frame, and light that is found through the tree."""
    expected, tree = curtain.picture(), curtain.tracer.structure("kdtree")

    def small():
        curtain._built.clear()
        curtain.build()
        assert tree.unread is not None
        curtain._built.clear()
        tree._levels = 2, 2
        curtain.build()

    for look in (tree.arrays, lambda: curtain.tracer.confirm("kdtree")):
        small()
        before = curtain.tracer.remade
        steps = curtain.steps(SIZE, 1, lambda: 1 << 20)
        next(steps)
        look()
        assert tree.unread is None
        assert drawn_by(steps, curtain).tobytes() == expected.tobytes()
        assert curtain.tracer.remade == before + 1
    # Radiosity and photons are found through it.
    for gi in ("radiosity", "photons"):
        small()
        monkeypatch.setattr(type(curtain), "radiosity", SimpleNamespace(prepare=tuple, light=lambda *_: {}))
        curtain.lit(curtain.shot(), curtain.scene.changed(gi=gi))
        assert tree.unread is None


def drawn(curtain, ctx):
    """The present frame as the window draws it."""
    return drawn_by(curtain.steps(SIZE, 1, lambda: 1024), curtain)


def drawn_by(steps, curtain):
    list(steps)
    data = curtain.tracer.picture.read(16 * SIZE[0] * SIZE[1])
    return np.frombuffer(data, np.float32).reshape(SIZE[1], SIZE[0], 4)[..., :3]


def test_dispatches_of_a_frame_of_the_curtain(ctx, curtain):
    tree = curtain.tracer.structure("kdtree")
    large, small = tree.large_levels + 1, tree.small_levels + 1
    moved, built, traced = frame_of(curtain, ctx)
    assert built.dispatched == 4 * large + small + 7
    assert traced.dispatched == 4 * 6 + 3 + 2
    assert moved.dispatched <= 80
    few = {path for counted in (moved, built, traced) for path, items in counted.fewest.items() if items < FEW}
    assert few <= SMALL.keys()
    # Those whose size the GPU alone knows are of whole work groups, or of none.
    groups = {
        one.path: int(np.prod(one.group_size)) for one in programs(ctx)._programs.values() if isinstance(one, Compute)
    }
    indirect = {path for counted in (moved, built, traced) for path in counted.dispatches} - {
        path for counted in (moved, built, traced) for path in counted.fewest
    }
    assert len(indirect) > 10 and {path for path in indirect if groups[path] < FEW} <= SMALL_GROUPS.keys()


def test_counts_are_of_what_is_within(ctx):
    buffer = Buffer(ctx, np.zeros(4, "f4"))
    with counting(ctx) as outer:
        buffer.read()
        with counting(ctx) as inner:
            buffer.read(4)
    buffer.read()
    assert (outer.reads, outer.read_bytes, inner.reads, inner.read_bytes) == (2, 20, 1, 4)
    buffer.release()
