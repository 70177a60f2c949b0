"""Passes of the trees and of the tracer: nothing depends on what memory held before, or on which invocation came first.

`python tests/measure/races.py` prints the same pass by pass, on any device.
"""

import double_runs as races
import numpy as np
import pytest

from glcloth.gpu.buffers import Buffer
from glcloth.gpu.programs import programs
from glcloth.gpu.shader import flatten


@pytest.mark.parametrize("accelerator", ["kdtree", "lbvh"])
def test_what_memory_held_before_is_never_read(ctx, accelerator):
    with races.Work(ctx, accelerator, triangles=1500, size=(32, 32)) as work:
        work.run()
        clean = work.result()
        for byte in (0x00, 0x7F, 0xFF):
            work.poison(byte)
            work.run()
            for name, array in work.result().items():
                np.testing.assert_array_equal(array, clean[name], err_msg=f"{name}, memory of {byte:#x}")


@pytest.mark.parametrize("accelerator", ["kdtree", "lbvh"])
def test_passes_run_twice_write_the_same(ctx, accelerator):
    """But for those whose places in lists are drawn by atomic counters, and these have the same results in the end."""
    with races.Work(ctx, accelerator, triangles=1500, size=(32, 32)) as work:
        work.run()
        assert work.tracer.statistics.shadow_rays[1] > 100  # light through the cloth
        found = races.twice(work.run)
        assert sum(runs for runs, _ in found.values()) > 40
        assert {path for path, (_, differ) in found.items() if differ} <= races.PLACED.keys()


def test_a_pass_that_depends_on_its_first_run_is_noticed(ctx, monkeypatch):
    """The planted fault: the memory is not put back in between, so a sum is another one."""
    text = """#version 430
layout(local_size_x = 8) in;
layout(std430) buffer Sums { uint sum[]; };
void main() { atomicAdd(sum[gl_LocalInvocationID.x], 1u); }
"""
    monkeypatch.setattr(
        "glcloth.gpu.programs.flatten", lambda path, defines, virtual: flatten(path, defines, {path: text})
    )
    program, sums = programs(ctx).compute("<sums>"), Buffer(ctx, bytes(32))
    for restore, differ in ((True, 0), (False, 1)):
        assert races.twice(lambda: program.run(16, Sums=sums), restore) == {"<sums>": (1, differ)}
    assert np.frombuffer(sums.read(), np.uint32).tolist() == [6] * 8
    sums.release()
