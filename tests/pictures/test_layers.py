"""Layers for compositing: what they hold, that light adds up to the picture, and that other programs read the file."""

import json

import numpy as np
import pytest

from glcloth.cli import main
from glcloth.cryptomatte import RANKS, id_bits, id_float, metadata, murmur3, ranked
from glcloth.errors import InputError
from glcloth.geometry.camera import Camera, lens_samples, sample_offsets
from glcloth.geometry.mesh import build_mesh
from glcloth.image import read_image, write_image
from glcloth.light.environment import Environment
from glcloth.picture.layers import AOVS, FAR, LIGHT

SIZE = (24, 18)
FAST = {"size": SIZE, "lobes": 4, "quality": "draft"}


def wall(name="wall", z=0.0, half=1.0):
    """A square across the z axis, its UVs from 0 to 1."""
    x = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])
    return build_mesh(name, x, np.array([[0, 1, 2], [0, 2, 3]]), (x[:, :2] / half + 1) / 2)


def meets(camera, z=0.0, offset=(0.0, 0.0)):
    """Where the rays of the pixels [H, W, 3], top row first, meet a plane across the z axis, and how far along the view."""
    y, x = np.mgrid[: SIZE[1], : SIZE[0]][:, ::-1] + 0.5
    at = np.stack([x, y, np.ones_like(x)], -1)
    o, d = at @ camera.origin_from_pixel(SIZE, offset).T, at @ camera.ray_from_pixel(SIZE, offset).T
    t = (z - o[..., 2:]) / d[..., 2:]
    return o + t * d, t[..., 0]


@pytest.mark.parametrize(
    "camera",
    [Camera((0.4, 0.3, 2.5), (0, 0, 0), fov_deg=50), Camera((0.4, 0.3, 2.5), (0, 0, 0), ortho=2.6)],
    ids=["perspective", "parallel"],
)
def test_what_pixels_see(renderer, camera):
    out = renderer.render(mesh=wall(), camera=camera, aovs=AOVS, shadows="off", **FAST)
    x, depth = meets(camera)
    inside = np.abs(x[..., :2]).max(-1) < 0.97
    assert 0.1 < inside.mean() < 0.9
    np.testing.assert_allclose(out["position"][inside], x[inside], atol=2e-5)
    np.testing.assert_allclose(out["depth"][inside], depth[inside], rtol=1e-5)
    np.testing.assert_allclose(out["uv"][inside], (x[inside][:, :2] + 1) / 2, atol=2e-5)
    np.testing.assert_allclose(out["normal"][inside], np.tile([0.0, 0, 1], (inside.sum(), 1)), atol=1e-6)
    outside = np.abs(x[..., :2]).max(-1) > 1.03
    assert (out["depth"][outside] == FAR).all() and (out["mask"][outside] == 0).all() and out["mask"][inside].all()
    assert np.ptp(out["albedo"][inside], 0).max() < 1e-6 and 0.02 < out["albedo"][inside].mean() < 1


def test_parallel_rays_see_cloth_and_background_as_from_far_away(renderer):
    """A camera at a thousand times the size, which sees parallel rays to a thousandth."""
    far = Camera((300.0, 200.0, 800.0), fov_deg=1.0)
    height = 2 * np.linalg.norm(far.eye) * np.tan(np.radians(0.5)) / 10
    far = Camera(tuple(np.array(far.eye) / 10), fov_deg=1.0)
    near = Camera(tuple(np.array(far.eye) / 20), ortho=height)
    look = {"mesh": "sphere", "fabric": "satin_charmeuse_front", "shadows": "off", "background": False, **FAST}
    a, b = (renderer.render(camera=camera, **look) for camera in (far, near))
    both = (a[..., 3] == 1) & (b[..., 3] == 1)
    assert np.mean(a[..., 3] != b[..., 3]) < 0.02 and both.mean() > 0.2
    assert np.abs(a - b)[both].max() < 0.03 * a[both][:, :3].max()
    seen = renderer.render(camera=near, **look, aovs=["normal", "position"])
    outward = seen["position"] / np.maximum(np.linalg.norm(seen["position"], axis=-1, keepdims=True), 1e-6)
    facing = both & (outward @ -near.axes[2] > 0.15)
    np.testing.assert_allclose(seen["normal"][facing], outward[facing], atol=0.02)
    behind = renderer.render(camera=near, **look | {"background": True})[b[..., 3] == 0]
    assert np.ptp(behind, 0).max() < 1e-6 and behind.max() > 0


def test_a_lens_blurs_what_is_not_at_the_focus(renderer):
    """The mean over the samples of a position is that of the points which the rays through the lens meet."""
    camera = Camera((0.2, 0.1, 3.0), (0.2, 0.1, 0.0), fov_deg=20, aperture=0.5, focus=2.0)
    out = renderer.render(mesh=wall(half=5.0), camera=camera, aovs=["position", "mask"], shadows="off", spp=8, **FAST)
    hits = [meets(c, 0.0, o)[0] for c, o in zip(lens_samples(camera, 8), sample_offsets(8), strict=True)]
    np.testing.assert_allclose(out["position"], np.mean(hits, 0), atol=5e-5)
    assert np.ptp(hits, 0).max() > 0.05
    # The same light from everywhere behind: every sample of the lens sees it, and their shares add up.
    even = Environment.from_array(np.full((8, 16, 3), 0.25))
    small = wall(half=0.1)
    picture = renderer.render(mesh=small, camera=camera, environment=even, shadows="off", spp=4, **FAST)
    np.testing.assert_allclose(picture[[0, -1]], 0.25, rtol=1e-5)


@pytest.mark.parametrize(
    "scene",
    [
        {"ground": "auto", "spp": 2},
        {"method": "reference", "cube": 4, "ground": "auto"},
        {"background": False, "shadows": "sun", "env": "sky"},
    ],
    ids=["ground", "reference", "alone"],
)
def test_light_adds_up_to_the_picture(renderer, scene):
    look = {"mesh": wall(half=0.7, z=0.3), "camera": Camera((0.5, 0.8, 3), fov_deg=40), **FAST, **scene}
    out = renderer.render(aovs=(*LIGHT, "mask"), **look)
    whole = sum(out[name].astype(float) for name in LIGHT)
    np.testing.assert_allclose(whole, out["beauty"][..., :3], atol=1e-5 * out["beauty"].max())
    if scene.get("method") == "reference":  # a ray sees the light or brings some back
        dark = renderer.render(**look, bounce=False)
        np.testing.assert_allclose(out["direct"] + out["background"], dark, atol=1e-5 * dark.max())
    else:
        assert (out["beauty"] == renderer.render(**look)).all(), "the same picture"
    if scene.get("ground"):
        cloth = out["mask"] == 1
        assert min(out["bounce"][cloth].max(), out["bounce"][~cloth].max()) > 1e-3 and out["bounce"].min() > -1e-6
    else:
        assert not out["bounce"].any() and not out["background"].any()


def test_hashes_are_those_of_the_specification():
    # smhasher's values, and those of the specification's example manifest
    assert [murmur3(s) for s in (b"", b"a", b"hello, world", b"hello")] == [0, 0x3C2569B2, 0x149BBB7F, 0x248BFA47]
    assert [murmur3(name) >> 23 & 255 for name in (b"name 368", b"name 708")] == [0, 255], "no numbers as they are"
    for name in ("wall", "Linen plain", "ß", "x" * 40, "name 368", "name 708"):
        assert np.float32(id_float(name)).view(np.uint32) == id_bits(name)
        assert np.isfinite(id_float(name)) and 0 < id_bits(name) >> 23 & 255 < 255
    key = next(iter(metadata("CryptoObject", [])))
    assert key.split("/")[1] == f"{murmur3(b'CryptoObject'):08x}"[:7]


def test_coverage_is_ranked():
    coverage = np.array([[[0.25, 0.75, 0.0], [0.0, 0.0, 1.0]]])
    pairs = ranked(coverage, ["a", "b", "c"]).reshape(1, 2, RANKS, 2)
    assert pairs[0, 0, :3].tolist() == [[id_float("b"), 0.75], [id_float("a"), 0.25], [0.0, 0.0]]
    assert pairs[0, 1, 0].tolist() == [id_float("c"), 1.0] and not pairs[0, 1, 1:].any()
    assert ranked(np.ones((1, 1, 9)) / 9, list("abcdefghi")).shape == (1, 1, 2 * RANKS)


def test_other_programs_read_the_file(renderer, tmp_path):
    import OpenEXR
    import OpenImageIO

    path = tmp_path / "a.exr"
    look = {
        "mesh": wall("panel", half=0.6),
        "objects": ("sphere",),
        "spp": 4,
        "camera": Camera((0, 0, 4)),
        "shadows": "off",
    }
    out = renderer.render(aovs="all", **FAST | look)
    assert {name for name in AOVS if name != "cryptomatte"} < set(out)
    write_image(path, out["beauty"], {"a": 1}, layers=out)
    expected = out.channels() | dict(zip("RGB", np.moveaxis(out["beauty"], -1, 0), strict=True))
    names = "Z N.X N.Y N.Z P.X P.Y P.Z uv.U uv.V albedo.R direct.G bounce.B transmission.R mask.A"
    assert {*names.split(), "CryptoObject00.R", "CryptoMaterial02.A"} <= expected.keys()
    with OpenEXR.File(str(path), separate_channels=True) as file:
        part = file.parts[0]
        assert set(part.channels) == set(expected)
        for name, plane in expected.items():
            assert (part.channels[name].pixels == plane).all(), name
    source = OpenImageIO.ImageInput.open(str(path))
    spec = source.spec()
    assert set(spec.channelnames) == set(expected)
    pixels = source.read_image("float")
    for name, plane in expected.items():
        # ids are bits: equal as such, whatever number they are
        got = np.ascontiguousarray(pixels[..., spec.channelnames.index(name)], np.float32)
        assert (got.view(np.uint32) == np.ascontiguousarray(plane, np.float32).view(np.uint32)).all(), name
    for layer, things in (("CryptoObject", {"panel", "sphere"}), ("CryptoMaterial", {"Silk crepe de chine", "sphere"})):
        key = f"cryptomatte/{murmur3(layer.encode()):08x}"[:19]
        assert spec.getattribute(f"{key}/name") == layer and spec.getattribute(f"{key}/hash") == "MurmurHash3_32"
        assert spec.getattribute(f"{key}/conversion") == "uint32_to_float32"
        manifest = json.loads(spec.getattribute(f"{key}/manifest"))
        assert manifest.keys() == things
        pairs = np.stack([out.channels()[f"{layer}{k // 4:02d}.{'RGBA'[k % 4]}"] for k in range(2 * RANKS)], -1)
        ids, coverage = pairs[..., 0::2], pairs[..., 1::2]
        known = {int(code, 16) for code in manifest.values()}
        assert set(ids[coverage > 0].view(np.uint32).tolist()) == known
        total = coverage.sum(-1)
        assert total.max() == pytest.approx(1) and np.isclose(total[6:12, 9:15], 1).all()
        assert ((coverage[..., 0] > 0) & (coverage[..., 0] < 1)).any(), "edges"
    np.testing.assert_array_equal(read_image(path), out["beauty"])
    for name in ("depth", "normal", "position", "uv", "mask", "albedo"):
        np.testing.assert_array_equal(read_image(path, name), np.atleast_3d(out[name]), err_msg=name)


def test_path_has_layers_of_what_is_seen(renderer):
    """Those of sixteen samples, beside the picture by paths; no kinds of light, which are one sum."""
    look = FAST | {"mesh": wall(half=0.6), "camera": Camera((0, 0, 4)), "objects": ("sphere",)}
    seen = renderer.render(aovs=AOVS, **look, spp=16, shadows="off")
    by_path = look | {"method": "path", "spp": 2}
    alone = renderer.render(**by_path)
    traced = renderer.render(aovs="all", **by_path)
    assert set(traced) == set(seen) - set(LIGHT)
    np.testing.assert_array_equal(traced["beauty"], alone)
    for name in set(traced) - {"beauty"}:
        np.testing.assert_array_equal(traced[name], seen[name], err_msg=name)
    assert renderer.facts()["method"] == "path" and renderer.covered_pixels() > 0
    with pytest.raises(InputError, match="one sum"):
        renderer.render(aovs="depth,bounce", **by_path)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--aov", "depth", "-o", "a.png"], "--aov writes layers, expected a name that ends in .exr"),
        (["--aov", "depth,normals", "-o", "a.exr"], "did you mean normal?"),
        (["curtain", "--method", "path", "--aov", "bounce", "-o", "a.exr"], "keeps kinds of light in one sum"),
    ],
)
def test_wrong_layers_are_one_line(words, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(["render", *words, "--size", "8x8"])
    assert stop.value.code == 2 and said in capsys.readouterr().err.strip().splitlines()[-1]
    assert not list(tmp_path.iterdir())


def test_unknown_names_are_said(renderer):
    with pytest.raises(InputError, match="aov 'beauty': unknown"):
        renderer.render(aovs=["beauty"], **FAST)


def test_things_of_one_name_are_told_apart():
    """By their whole names, and cloth and objects alike; one that is alone keeps its name."""
    from types import SimpleNamespace

    from glcloth.picture.solids import Solids

    def named(*names):
        return tuple(SimpleNamespace(name=name, triangles=range(1)) for name in names)

    objects = SimpleNamespace(meshes=named("chair", "chair.v2", "chair.v2", "drape", "chair"))
    solids = SimpleNamespace(objects=objects, catches=True, mesh=None, _shares=[1] * 5)
    frame = SimpleNamespace(cloths=[SimpleNamespace(mesh=named("drape")[0])])
    names = [name for _, name, _ in Solids.identities(solids, frame, 1)]
    assert names == ["chair", "chair.v2", "chair.v2.2", "drape.2", "chair.2"]
