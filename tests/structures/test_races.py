"""Passes of the trees and of the tracer: nothing depends on what memory held before, or on which invocation came first.

`python tests/measure/races.py` prints the same pass by pass, on any device.
"""

import double_runs as races
import numpy as np
import pytest

from glcloth.gpu.buffers import Buffer
from glcloth.gpu.programs import programs
from glcloth.gpu.shader import flatten
from glcloth.light.lights import SphericalGaussians
from glcloth.methods import relief
from glcloth.scene import View


@pytest.mark.parametrize("name", ["kdtree", "lbvh"])
def test_what_memory_held_before_is_never_read(ctx, name):
    with races.works(ctx, 1500, (32, 32))[name]() as work:
        work.run()
        clean = work.result()
        for byte in (0x00, 0x7F, 0xFF):
            work.poison(byte)
            work.run()
            for what, array in work.result().items():
                np.testing.assert_array_equal(array, clean[what], err_msg=f"{what}, memory of {byte:#x}")


@pytest.mark.parametrize("accelerator", ["kdtree", "lbvh"])
def test_passes_run_twice_write_the_same(ctx, accelerator):
    """But for those whose places in lists are drawn by atomic counters, and these have the same results in the end."""
    with races.Work(ctx, accelerator, triangles=1500, size=(32, 32)) as work:
        work.run()
        assert work.tracer.statistics.shadow_rays[1] > 100  # light through the cloth
        found = races.twice(work.run)
        assert sum(runs for runs, _ in found.values()) > 40
        assert {path for path, (_, differ) in found.items() if differ} <= races.PLACED.keys()


# Passes of photons that a frame runs beside those of the tree and the tracer.
PHOTONS = ("photon_trace", "photon_pack", "photon_radius", "photon_gather")


def test_passes_of_photons_run_twice_write_the_same_and_read_no_old_memory(ctx):
    with races.Lit(ctx) as work:
        work.run()
        clean = work.result()
        work.poison(0x7F)
        work.run()
        for what, array in work.result().items():
            np.testing.assert_array_equal(array, clean[what], err_msg=what)
        found = races.twice(work.run)
        assert {f"passes/curtain/{name}.comp" for name in PHOTONS} < found.keys()
        assert {"passes/accel/sort_scan.comp", "passes/accel/kdtree_points.comp"} < found.keys()
        assert {path for path, (_, differ) in found.items() if differ} <= races.PLACED.keys()


def test_passes_of_relief_and_of_shading_run_twice_write_the_same(ctx, renderer, monkeypatch, tmp_path):
    """The means of relief, and pixels that are shaded in compute: into images, and each anew."""
    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path))
    monkeypatch.setattr(relief, "SAMPLES", 64)
    near = View(eye=(0.0, 0.012, 0.008), target=(0.0, 0.0, 0.0))
    lights = SphericalGaussians([[0, 1, 0]], [3.0], [[1.0, 1.0, 1.0]])
    frame = renderer.prepare(
        fabric="poplin", mesh="plane", camera=near, lights=lights, size=(32, 24), spp=2, shade="compute", shadows="off"
    )
    found = races.twice(lambda: renderer.draw(frame))
    assert found["passes/picture/covered.comp"] == (4, 0)
    assert found["passes/methods/relief_table.comp"] == (1, 0)
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
