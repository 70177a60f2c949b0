"""Method `path` in the window: it goes on while it is shown, and begins again when anything changes."""

import numpy as np

from glcloth.window.refine import METHODS, Refiner

MOST = 5000  # calls of `work`, many more than it takes


def drawn(refiner):
    """The picture of the first side, top row first."""
    texture = refiner.sides[0].texture
    return np.frombuffer(texture.read(), "f4").reshape(texture.size[1], texture.size[0], 4)[::-1]


def finish(refiner):
    for _ in range(MOST):
        if refiner.idle:
            return
        refiner.work(10.0)
    raise AssertionError("it comes to no end")


def test_it_is_shown_while_it_goes_on_and_begins_again(ctx, renderer, monkeypatch):
    assert "path" in METHODS
    monkeypatch.setattr("glcloth.window.refine.AFRESH", 0.0)
    look = dict(mesh="drape", fabric="linen", method="path", size=(32, 24), spp=12, env="sky", light="sg")
    refiner = Refiner(ctx)
    frames = [refiner.renderer.prepare(**look)]
    refiner.show(frames)
    states, noise = set(), []
    for _ in range(MOST):
        if refiner.idle:
            break
        if refiner.work(1e-4) and refiner._samples:
            states.add(refiner.status(frames[0].scene)[0].split(";")[0])
            noise.append(drawn(refiner).astype(float))
    assert {"path: 4 samples", "path: 8 samples"} <= states
    whole = np.asarray(renderer.render(**look))
    np.testing.assert_array_equal(drawn(refiner)[..., :3], whole[..., :3])
    # Another camera in the middle of it: no sample of the old one stays.
    other = renderer.prepare(**look, camera=frames[0].camera.__class__((0.5, 0.9, 2.0), (0.0, 0.5, 0.0)))
    refiner.show([renderer.prepare(**look, env_rotate=90.0)])
    for _ in range(MOST):
        if refiner._samples:
            break
        refiner.work(1e-4)
    assert refiner._samples
    refiner.show([other])
    finish(refiner)
    np.testing.assert_array_equal(drawn(refiner)[..., :3], np.asarray(renderer.render_frame(other))[..., :3])
    # What it cannot show is shown by direct.
    flat = renderer.prepare(**{**look, "shadows": "off"})
    refiner.show([flat])
    finish(refiner)
    assert refiner.sides[0].share == 1.0 and refiner.status(flat.scene)[0].startswith("direct: ")
    refiner.release()
