"""The curtain scene: simulation, room and tracer together; frames that can be resumed; what the bench says."""

import curtain_scenes as scenes
import numpy as np
import pytest

from glcloth.accel.queries import RayQueries
from glcloth.bench.curtain import bench_curtain
from glcloth.curtain.show import CurtainShow, camera_of
from glcloth.errors import InputError
from glcloth.picture import curtain_layers
from glcloth.picture.layers import LIGHT
from glcloth.scene import CurtainParameters, Scene

SMALL = Scene(size=(48, 48), gi="off", curtain=CurtainParameters(quads=(48, 12), pleats=4, settle=0.2))


def test_frames_can_be_resumed(ctx):
    """Starting at frame 2 gives the picture that going through the frames gives, bit for bit."""
    with CurtainShow(ctx, SMALL) as show:
        all_of_them = list(show.frames(3))
    with CurtainShow(ctx, SMALL) as show:
        (last,) = show.frames(3, start=2)
    assert len(all_of_them) == 3
    np.testing.assert_array_equal(all_of_them[2], last)
    assert np.abs(all_of_them[2] - all_of_them[0]).max() > 0.01, "the curtain moves"
    assert all(np.isfinite(p).all() and p.min() >= 0 and p.max() < 1e3 for p in all_of_them)


def test_every_structure_at_rest_and_in_the_wind(ctx):
    """Nearest hits of the room with its curtain equal brute force; pictures are the same."""
    queries = RayQueries(ctx)
    with CurtainShow(
        ctx, SMALL.changed(curtain=CurtainParameters(quads=(48, 12), pleats=4, settle=0.2, wind=1.5))
    ) as show:
        for frames in (0, 12):
            show.advance(frames)
            pictures = {}
            for name in ("kdtree", "lbvh", "brute"):
                show.scene = show.scene.changed(accelerator=name)
                pictures[name] = show.picture()
            np.testing.assert_allclose(pictures["kdtree"], pictures["brute"], rtol=1e-5, atol=1e-6)
            np.testing.assert_allclose(pictures["lbvh"], pictures["brute"], rtol=1e-5, atol=1e-6)
            o, d = scenes.random_rays(20_000, [-2, 0, 0], [2, 2.7, 4], seed=frames)
            hits = {name: queries.closest_hit(show.tracer.structure(name), o, d) for name in pictures}
            for name in ("kdtree", "lbvh"):
                np.testing.assert_array_equal(hits[name].t, hits["brute"].t)
    queries.release()


def test_no_light_leaks(ctx):
    """Without ambient light and with a black curtain, what is lit in the room is lit through the window's opening."""
    black = SMALL.changed(fabric="blackout", ambient=(0, 0, 0), size=(96, 96))
    with CurtainShow(ctx, black) as show:
        dark = show.picture()
    with CurtainShow(ctx, black.changed(fabric="sheer_voile")) as show:
        bright = show.picture()
    # The ceiling and the upper corners see no lamp, whatever hangs before the window.
    assert dark[:6, :].max() == 0 and bright[:6, :].max() == 0
    assert bright.mean() > 5 * dark.mean()


def test_the_tree_and_the_layers(ctx):
    with CurtainShow(ctx, SMALL) as show:
        tree, layers, traced = show.tree(), show.layers(), show.picture()
    assert tree.shape == layers.shape == traced.shape == (48, 48, 3)
    assert (tree[..., 1] > tree[..., 0] + 0.05).sum() > 50, "green boxes"
    assert layers.mean() > traced.mean(), "no shadows"


def test_bench(ctx):
    result = bench_curtain(ctx, SMALL, frames=2)
    for key in ("sim_ms", "build_ms", "trace_ms", "frame_ms", "fps", "cpu_ms", "sah", "steps_per_ray", "tests_per_ray"):
        assert result[key] > 0, key
    assert result["triangles"] == 2 * 48 * 12 + 146 and result["nodes"] > 500
    assert result["rays"] >= 48 * 48 and len(result["levels"]) == 4
    assert set(result["build_stages_ms"]) == {"init", "large", "masks", "small", "order", "emit"}
    assert bench_curtain(ctx, SMALL.changed(accelerator="lbvh"), frames=1, triangles=2000)["triangles"] > 1900


def test_the_default_scene_has_the_papers_triangles():
    assert CurtainParameters().triangle_count + 146 == 12_786


def test_wrong_input(ctx):
    for changes, words in (
        ({"dept": 3}, "unknown key"),
        ({"depth": 9}, "depth"),
        ({"size": "big"}, "WIDTHxHEIGHT"),
        ({"accelerator": "octree"}, "accelerator"),
        ({"curtain": {"fullness": 9}}, "fullness"),
        ({"curtain": {"windd": 9}}, "unknown key"),
        ({"ambient": (1, 2)}, "ambient"),
    ):
        with pytest.raises(InputError, match=words) as error:
            Scene.parse({"curtain": {}, **changes})
        assert "\n" not in str(error.value)
    with pytest.raises(InputError, match="room alone"):
        CurtainShow(ctx, SMALL, triangles=100)
    with pytest.raises(InputError, match="frames"):
        bench_curtain(ctx, SMALL, frames=0)


def test_a_scene_that_cannot_be_leaves_the_last_one(renderer):
    before = renderer.render(SMALL)
    with pytest.raises(InputError, match="too soft"):
        renderer.render(SMALL.changed(curtain=SMALL.curtain.changed(bending=1.0, settle=0.0)))
    assert np.array_equal(renderer.render(SMALL), before)
    renderer.show(SMALL.changed(method="path")).layers()
    assert "samples" not in renderer.facts()


def test_layers_of_the_curtain_are_what_its_rays_meet(renderer, monkeypatch):
    scene = SMALL.changed(size=(40, 30), spp=2)
    wanted = "depth,normal,position,uv,mask,cryptomatte"
    layers = renderer.render(scene, aovs=wanted)
    assert np.array_equal(layers["beauty"], renderer.render(scene)), "they change nothing"
    with monkeypatch.context() as patch:
        patch.setattr(curtain_layers, "RAYS", 250)
        for name, layer in renderer.render(scene, aovs=wanted).items():
            np.testing.assert_array_equal(layer, layers[name], err_msg=f"{name}, six rows at a time")
    camera, cloth = camera_of(scene), layers["mask"] == 1.0
    assert 0.1 < cloth.mean() < 0.9
    length = np.linalg.norm(layers["normal"][cloth], axis=-1)  # of the mean of two samples
    assert np.median(length) > 0.99 and length.max() < 1.0 + 1e-5
    # The curtain is 2.3 m long and hangs from 2.41 m; its hem is at v = 0.
    height, v = layers["position"][..., 1][cloth], layers["uv"][..., 1][cloth]
    np.testing.assert_allclose(height - 0.11, v, atol=0.08)
    x, u = layers["position"][..., 0][cloth], layers["uv"][..., 0][cloth]
    np.testing.assert_allclose((x + 1.25) * 1.8, u, atol=0.4)
    # Seen from the eye the place of the first sample, at the pixel's centre or near it, has the depth.
    along = (layers["position"] - camera.eye) @ camera.axes[2]
    assert np.median(np.abs(along - layers["depth"])[cloth]) < 0.02
    pairs = layers["CryptoObject"].reshape(30, 40, -1, 2)
    np.testing.assert_allclose(pairs[..., 1].sum(-1)[layers["depth"] < 1e9], 1.0, atol=1e-6)
    assert "curtain" in layers.names["CryptoObject"] and len(layers.names["CryptoObject"]) > 2
    with pytest.raises(InputError, match="aov bounce: method path keeps kinds of light in one sum"):
        renderer.render(scene, aovs="bounce", method="path")


@pytest.mark.parametrize(
    "traced",
    [{"spp": 2}, {"accelerator": "lbvh", "spread": True}, {"gi": "photons", "photons": 2000}],
    ids=["layers", "nearest hits", "photons"],
)
def test_light_of_the_curtain_adds_up(renderer, traced):
    """Each kind is dark without its source, and the sum is the picture, which is that without layers."""
    narrow = SMALL.curtain.changed(width=1.4, quads=(24, 12), pleats=3)  # so that the window is seen beside it
    scene = SMALL.changed(size=(40, 30), fabric="linen_curtain", curtain=narrow, **traced)
    layers = renderer.render(scene, aovs=(*LIGHT, "mask", "albedo"))
    picture = layers["beauty"]
    np.testing.assert_allclose(sum(layers[name].astype(float) for name in LIGHT), picture, atol=1e-5 * picture.max())
    cloth = layers["mask"] == 1.0
    assert all(layers[name].max() > 0.01 for name in ("direct", "bounce", "background")), "each has something"
    assert layers["transmission"][cloth].mean() > 0.02 and not layers["transmission"][layers["mask"] == 0.0].any()
    assert not layers["background"][cloth].any(), "what is seen through cloth comes through it"
    assert np.ptp(layers["albedo"][cloth], 0).max() < 1e-6 < layers["albedo"][cloth].mean()
    if "gi" not in traced:
        assert np.array_equal(picture, renderer.render(scene)), "they change nothing"
        dark = renderer.render(scene, aovs=LIGHT, lamp_intensity=(0, 0, 0))
        assert not dark["direct"].any()
        np.testing.assert_allclose(dark["background"], layers["background"], atol=1e-6)
        # Even light is on what is seen first; what cloth mirrors of the lamp's light is gone with it.
        assert (layers["bounce"] >= dark["bounce"] - 1e-6).all() and dark["bounce"].max() > 0.01
        np.testing.assert_allclose(
            renderer.render(scene, aovs=LIGHT, ambient=(0, 0, 0))["direct"], layers["direct"], atol=1e-6
        )
        # Of the sky alone cloth shows what comes through it; hardly anything is mirrored by it from the dark room.
        sky = renderer.render(scene, aovs=LIGHT, ambient=(0, 0, 0), lamp_intensity=(0, 0, 0))
        assert sky["transmission"][cloth].mean() > 10.0 * sky["bounce"][cloth].mean()
