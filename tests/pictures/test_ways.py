"""Pixels are shaded in compute as by fragments, and the faster way is measured, kept and taken."""

from unittest.mock import Mock

import numpy as np
import pytest

from glcloth.errors import ShaderError
from glcloth.fabric import load_fabric
from glcloth.gpu.context import is_software
from glcloth.gpu.tally import counting
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.picture.ways import Measured, Ways, apart
from glcloth.scene import Scene, View

LIGHTS = Lights(
    SphericalGaussians([[0, 1, 0], [0.7, 0.4, 0.6]], [1.5, 40.0], [[0.4, 0.5, 0.7], [4.0, 3.6, 3.0]]),
    Suns([[0.3, 0.8, 0.5]], [[0.8, 0.75, 0.6]]),
)
COMMON = {"lights": LIGHTS, "size": (48, 36), "background": False, "shadows": "off"}
BESIDE = {"objects": ("plane@0.25,0.1,0.25,0.5,40",), "mesh": "plane", "shadows": "full"}
POPLIN = load_fabric("poplin")
assert POPLIN.weave is not None
FLAT_POPLIN = POPLIN.changed(weave=POPLIN.weave.changed(relief=0.0)).sketch()
# Every file that passes/picture/covered.comp shades by.
PICTURES = {
    "direct": {**BESIDE, "fabric": "linen", "ground": "auto"},
    "adaptive": {"fabric": FLAT_POPLIN, "mesh": "plane", "adaptive": True,
                 "camera": View(eye=(0.0, 0.012, 0.008), target=(0.0, 0.0, 0.0))},
    "paper": {"fabric": "linen", "method": "paper", "grid": 8, "spp": 2},
    "reference": {**BESIDE, "fabric": "linen", "method": "reference", "cube": 4, "ground": "auto", "size": (24, 18)},
    "sheer": {"fabric": "sheer_voile", "mesh": "sphere", "aovs": ("bounce", "transmission")},
}  # fmt: skip
# Two surfaces; coarse pixels and two grids of terms; two samples; ten passes of two surfaces; four layers, and what is through.
RUNS = {"direct": 2, "adaptive": 3, "paper": 2, "reference": 20, "sheer": 8}
# Both run the same text. llvmpipe makes the same code of it; another compiler may order or fuse what it adds otherwise: some
# steps of float32 in a term, which sums of up to some hundred terms may cancel down to.
BOUND = 1e-3


def rendered(renderer, picture, way):
    """All layers of a picture shaded by a way, in one array, and how often passes ran."""
    with counting(renderer.ctx) as counted:
        found = renderer.render(**{**COMMON, **picture}, shade=way)
    layers = list(found.values()) if "aovs" in picture else [found]
    return np.concatenate([np.asarray(layer).reshape(len(layers[0]), -1) for layer in layers], 1), counted.dispatches


@pytest.mark.parametrize("name", PICTURES)
def test_compute_shades_as_fragments_do(renderer, name):
    (a, by_fragments), (b, by_compute) = (rendered(renderer, PICTURES[name], way) for way in ("fragment", "compute"))
    assert "passes/picture/covered.comp" not in by_fragments
    assert by_compute["passes/picture/covered.comp"] == RUNS[name]
    assert np.isfinite(b).all() and b.mean() > 0.01
    assert np.array_equal(a, b) if is_software(renderer.ctx) else apart(a, b) < BOUND


def test_bands_of_compute_are_the_whole(renderer):
    frame = renderer.prepare(**COMMON, fabric="linen", mesh="plane", shade="compute")
    whole = renderer.render_frame(frame)
    for _ in renderer.steps(frame, rows=lambda: 7):
        pass
    assert np.array_equal(renderer.target.read(), whole)
    # The list follows what is covered.
    moved = renderer.prepare(**COMMON, fabric="linen", mesh="plane", shade="compute", camera=View(view="side"))
    assert np.array_equal(renderer.render_frame(moved)[..., 3] > 0, renderer.gbuffer.covered()) and not np.array_equal(
        renderer.target.read(), whole
    )


def test_auto_takes_what_was_measured_as_faster_and_keeps_it(renderer, monkeypatch, tmp_path):
    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path))
    scene = Scene(fabric="linen", mesh="plane", size=(256, 192), shadows="off", background=False)
    frame, small = (renderer.prepare(one, lights=LIGHTS) for one in (scene, scene.changed(size=(48, 36))))
    monkeypatch.setattr(renderer._passes, "ways", Ways(renderer.ctx))
    taken, times = [], {"fragment": 10.0, "compute": 8.0}
    monkeypatch.setattr(Ways, "_milliseconds", lambda self, run, way: run(way) or times[way])
    for one in (small, small, frame, frame):
        renderer.draw(one)
        taken.append((renderer.facts()["shade"], renderer._passes.ways.measured("direct") is not None))
    # Small pictures measure nothing, nor does the first pass of all.
    assert taken == [("fragment", False)] * 2 + [("compute", True)] * 2
    assert renderer._passes.ways.measured("direct").apart <= BOUND
    # Another process reads it, and what is said goes before it; nothing is known of other methods.
    kept = Ways(renderer.ctx)
    assert kept.measured("direct").way == "compute" == kept.of(scene) and not kept.due(scene)
    assert kept.of(scene.changed(shade="fragment")) == kept.of(scene.changed(method="reference")) == "fragment"
    # Fragments go on where a driver does not compile the other, which is found out once.
    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path / "other"))
    monkeypatch.setattr(renderer._passes, "ways", Ways(renderer.ctx))
    monkeypatch.setattr(Ways, "_compared", Mock(side_effect=ShaderError("covered.comp")))
    for _ in range(3):
        renderer.draw(frame)
        assert renderer.facts()["shade"] == "fragment"
    assert Ways._compared.call_count == 1 and "not compile" in str(Ways(renderer.ctx).measured("direct"))
    # Noise chooses nothing, and no way that gives another picture.
    assert Measured(10.0, 9.5, 0.0).way == Measured(10.0, 1.0, 0.1).way == "fragment"
