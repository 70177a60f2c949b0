"""Maps over the UVs of cloth: prints, and where cloth is open."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from glcloth.cli.options import scene_of
from glcloth.cli.scene_options import SceneOptions
from glcloth.color import srgb_decode
from glcloth.errors import InputError
from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import Mesh
from glcloth.image import decode_codes, write_image
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.picture.cloths import Cloth
from glcloth.picture.masks import part_pattern
from glcloth.picture.openings import load_opacity
from glcloth.scene import FabricMaskMap, OpacityMap, PrintMap, Scene, load_scene, save_scene

INK = (0.7, 0.3, 0.1)
SIZE = (48, 40)
FRONT = Camera((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), ortho=2.0)
OVERHEAD = Camera((0.0, 5.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), ortho=2.0)


def board(cells=8, axis=2, at=0.0):
    """A sheet of side 2 about the origin in the plane z = `at` (axis 2) or y = `at` (axis 1); its UVs run from 0 to 1."""
    u, v = (a.ravel() for a in np.meshgrid(*2 * [np.linspace(0, 1, cells + 1)]))
    x, y = 2 * u - 1, 2 * v - 1
    positions = np.stack([x, y, 0 * x + at] if axis == 2 else [x, 0 * x + at, -y], -1)
    i = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    corners = np.concatenate([np.stack([i, i + 1, i + cells + 2], -1), np.stack([i, i + cells + 2, i + cells + 1], -1)])
    return Mesh.from_arrays(positions, corners, np.stack([u, v], -1), name="board")


def texture(folder, rows, name="map.exr"):
    """A picture of these rows of colours or shares, the top one first."""
    rows = np.asarray(rows, np.float32)
    write_image(folder / name, np.repeat(rows[..., None], 3, -1) if rows.ndim == 2 else rows)
    return str(folder / name)


def inks(folder, **look):
    return {"file": texture(folder, np.tile(INK, (4, 4, 1))), **look}


@pytest.mark.parametrize("method", ["direct", "reference"])
@pytest.mark.parametrize("near", [False, True])
def test_a_print_of_one_colour_is_a_fabric_of_that_colour(renderer, tmp_path, method, near):
    """Far, at the adaptive rate, and with threads near. Of stripes each thread has its own colour."""
    fabric = load_fabric("gingham" if near else "linen")
    look = {
        "size": SIZE,
        "method": method,
        "cube": 6,
        "shadows": "off",
        "adaptive": method == "direct" and not near,
        "background": False,
    }
    look |= {"mesh": board(), "camera": Camera((0.02, 0.03, 0.1 if near else 4.0), (0.0, 0.0, 0.0))}
    ink = np.array(INK)
    if near:
        stripes = {
            name: tuple(s.changed(albedo=tuple(ink * s.albedo)) for s in getattr(fabric.weave, name))
            for name in ("warp_stripes", "weft_stripes")
        }
        dyed = fabric.changed(weave=fabric.weave.changed(**stripes))
    else:
        dyed = fabric.changed(yarn=tuple(y.changed(albedo=tuple(ink * y.albedo)) for y in fabric.yarn))
    expected = renderer.render(fabric=dyed, **look)
    printed = renderer.render(fabric=fabric, print=inks(tmp_path), **look)
    assert renderer.stage.cloths[0].threads.woven == near
    np.testing.assert_allclose(printed, expected, rtol=2e-3, atol=2e-3 * expected.max())
    assert np.abs(expected - renderer.render(fabric=fabric, **look)).max() > 0.1 * expected.max()


QUARTERS = [[(1, 0, 0), (0, 1, 0)], [(0, 0, 1), (1, 1, 1)]]  # top left red, top right green, below blue and white


@pytest.mark.parametrize(("repeat", "unit"), [(1.0, "uv"), (2.0, "m"), (1.0, "m")])
def test_a_print_lies_upright_and_repeats_as_it_says(renderer, tmp_path, repeat, unit):
    """The board is a UV unit and two metres wide; its own scale is measured."""
    design = {"file": texture(tmp_path, np.repeat(np.repeat(QUARTERS, 8, 0), 8, 1)), "repeat": repeat, "unit": unit}
    # Where nothing is printed only the gloss of the yarns is left.
    layers = renderer.render(
        mesh=board(), fabric="linen", print=design, camera=FRONT, size=(40, 40), shadows="off", aovs="albedo"
    )
    albedo = layers["albedo"]
    half = 40 if repeat * (2.0 if unit == "uv" else 1.0) == 2.0 else 20
    at = [half // 4, 3 * half // 4]
    red, green, blue, white = (albedo[row, column] for row in at for column in at)
    for color, channel in ((red, 0), (green, 1), (blue, 2)):
        others = np.delete(np.arange(3), channel)
        assert color[channel] == pytest.approx(white[channel], rel=1e-3) and (color[others] < 0.6 * white[others]).all()
    if half == 20:
        np.testing.assert_allclose(albedo[2:18, 2:18], albedo[22:38, 22:38], atol=1e-3)
    # Shaded they differ alike.
    picture = layers["beauty"]
    assert picture[at[0], at[0], 0] > 1.05 * picture[at[1], at[0], 0]


def test_the_mean_of_a_print_is_that_of_the_cloth_it_lies_on(renderer, tmp_path):
    """A quarter of the picture is on the mesh: far cloth and a bounce have the colour of that."""
    mesh = board()
    corner = Mesh.from_arrays(mesh.positions, mesh.triangles, 0.4 * np.asarray(mesh.uv) + 0.05, name="corner")
    design = {"file": texture(tmp_path, np.repeat(np.repeat(QUARTERS, 32, 0), 32, 1))}
    look = {"mesh": corner, "camera": FRONT, "size": SIZE, "shadows": "off", "fabric": "linen"}
    renderer.render(print=design, **look)
    fabric = renderer.stage.cloths[0].scene_buffers.fabric
    for before, after in zip(load_fabric("linen").yarn, fabric.yarn, strict=True):
        np.testing.assert_allclose(after.albedo, np.multiply((0, 0, 1), before.albedo), atol=1e-6)


def test_codes_are_srgb_unless_they_are_said_to_be_linear(renderer, tmp_path):
    from PIL import Image

    Image.new("RGB", (4, 4), (188, 90, 40)).save(tmp_path / "ink.png")
    codes = np.array([188, 90, 40]) / 255
    for space, expected in (("srgb", srgb_decode(codes)), ("linear", codes)):
        renderer.render(
            print={"file": str(tmp_path / "ink.png"), "space": space},
            mesh="plane",
            fabric="linen",
            size=(8, 8),
            shadows="off",
        )
        yarn = renderer.stage.cloths[0].scene_buffers.fabric.yarn[0]
        np.testing.assert_allclose(yarn.albedo, expected * load_fabric("linen").yarn[0].albedo, rtol=1e-5)


def test_paper_shows_a_print_too(renderer, tmp_path, capsys):
    look = {"mesh": board(), "camera": FRONT, "size": (8, 8), "shadows": "off", "grid": 8, "method": "paper"}
    linen = load_fabric("linen")
    dyed = linen.changed(yarn=tuple(y.changed(albedo=tuple(np.array(INK) * y.albedo)) for y in linen.yarn))
    printed = renderer.render(print=inks(tmp_path), fabric=linen, **look)
    np.testing.assert_allclose(printed, renderer.render(fabric=dyed, **look), rtol=2e-3)
    assert "print" not in capsys.readouterr().err


def test_light_through_sheer_cloth_is_tinted_and_bare_cloth_shines_through(renderer, tmp_path):
    """From behind, in the light of a sun before it: of a print of one colour what comes through has that colour."""
    sun = Lights(SphericalGaussians(np.array([[0.0, 1.0, 0.0]]), np.array([2.0]), np.full((1, 3), 1e-6)),
                 Suns(np.array([[0.0, 0.0, 1.0]]), np.full((1, 3), 3.0)))  # fmt: skip
    look = {"mesh": board(), "camera": Camera((0.3, 0.2, -5.0), (0.0, 0.0, 0.0)), "size": (16, 16), "lights": sun}
    look |= {"fabric": "sheer_voile", "threads": False, "background": False}
    bare = renderer.render(**look)[8, 8, :3]
    tinted = renderer.render(print=inks(tmp_path), **look)[8, 8, :3]
    np.testing.assert_allclose(tinted, np.multiply(INK, bare), rtol=0.02)
    assert bare.min() > 0.01


# -- opacity -------------------------------------------------------------------------------------------------------------


def test_open_cloth_is_not_there_and_the_rest_keeps_its_bits(renderer, tmp_path):
    look = {"mesh": board(), "camera": FRONT, "size": (40, 40), "background": False, "fabric": "linen", "bounce": False}
    closed = renderer.render(shadows="off", **look)
    left = texture(tmp_path, np.repeat([[0.0, 1.0]], 2, 0))
    cut = renderer.render(shadows="off", opacity=left, **look)
    assert not cut[:, 1:19].any() and np.array_equal(cut[:, 21:39], closed[:, 21:39])


@pytest.mark.parametrize("share", [0.0, 0.25, 0.6, 1.0])
def test_samples_cover_as_much_as_the_map_says(renderer, tmp_path, share):
    opacity = texture(tmp_path, np.full((2, 2), share))
    look = {"mesh": board(), "camera": FRONT, "size": (8, 8), "background": False, "spp": 20, "shadows": "off"}
    assert renderer.render(opacity=opacity, **look)[4, 4, 3] == pytest.approx(share, abs=0.051)


def test_open_cloth_casts_no_shadow(renderer, tmp_path):
    """A sheet over a sheet in a slanting sun, its left half open: the shadow falls from the right half alone."""
    low, high = board(16, 1), board(16, 1)
    high = high.moved(0.5 * high.positions + np.array([0.0, 0.5, 0.0], "f4"))
    slanting = Suns(np.array([[0.0, 1.0, -1.0]]) / np.sqrt(2.0), np.full((1, 3), 3.0))
    sun = Lights(SphericalGaussians(np.array([[0.0, 1.0, 0.0]]), np.array([2.0]), np.full((1, 3), 0.1)), slanting)
    linen = load_fabric("linen")
    Image.fromarray(np.full((4, 4), 16384, np.uint16)).save(tmp_path / "deep.png")  # 16 bits
    assert np.allclose(decode_codes(tmp_path / "deep.png"), 0.25, atol=1e-4)
    opacity = load_opacity(OpacityMap(file=texture(tmp_path, np.repeat([[0.0, 1.0]], 8, 0).repeat(8, 1))))
    look = {
        "camera": OVERHEAD,
        "size": (40, 40),
        "background": False,
        "lights": sun,
        "shadows": "full",
        "bounce": False,
    }
    free = renderer.render(cloths=[Cloth(low, linen)], **look)[..., 1]
    below = renderer.render(cloths=[Cloth(low, linen), Cloth(high, linen, opacity=opacity)], **look)[..., 1]
    shadow = np.s_[32:37]  # 0.6 to 0.85 from the middle, where the upper sheet ends at 0.5
    assert (below[shadow, 12:18] > 0.9 * free[shadow, 12:18]).all()
    assert (below[shadow, 22:28] < 0.5 * free[shadow, 22:28]).all()
    # Where the upper sheet is open the lower one is seen.
    assert (below[12:28, 12:18] > 0.0).all()


# -- fabric masks --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["direct", "reference", "paper", "path"])
def test_each_half_of_a_mask_has_the_bits_of_its_fabric(renderer, tmp_path, method):
    """The mask's left half is blue, its right half white, which has no fabric of its own."""
    mask = texture(tmp_path, np.repeat(np.repeat([[(0, 0, 1), (1, 1, 1)]], 4, 0), 4, 1))
    look = {"mesh": board(), "camera": FRONT, "size": (40, 8), "background": False, "method": method}
    look |= {"cube": 6, "grid": 8} | ({"spp": 4} if method == "path" else {"shadows": "off"})
    linen, velvet = (renderer.render(fabric=name, **look) for name in ("linen", "velvet"))
    shown = renderer.render(fabric="linen", fabrics={"#00f": "velvet"}, fabric_mask=mask, **look)
    if method == "path":  # the same samples in another program
        np.testing.assert_allclose(shown, np.concatenate([velvet[:, :20], linen[:, 20:]], 1), rtol=1e-4, atol=1e-6)
    else:
        assert np.array_equal(shown[:, :20], velvet[:, :20]) and np.array_equal(shown[:, 20:], linen[:, 20:])
    assert np.abs(velvet - linen)[..., :3].max() > 0.05
    if method == "direct":
        textures = {cloth.buffers.cut_out.maps["mask_map"] for cloth in renderer.stage.cloths_in_frame}
        assert len(renderer.stage.cloths_in_frame) == 2 and len(textures) == 1, "both read one texture"
        masked = {"fabrics": {"#00f": "velvet"}, "fabric_masks": {"board": mask}}
        layers = renderer.render(fabric="linen", **masked, **look, aovs="cryptomatte")
        assert layers.names["CryptoMaterial"] == [load_fabric(name).name for name in ("linen", "velvet")]


@pytest.mark.parametrize(("repeat", "unit"), [(0.5, "uv"), (1.0, "m")])
def test_the_fabrics_of_a_fine_mask_leave_no_gap_and_keep_its_shares(renderer, tmp_path, repeat, unit):
    """Texels of noise in three colours, some finer than the pixels: all is covered, and each fabric by its share. The board is
    a UV unit and two metres wide."""
    rng = np.random.default_rng(3)
    which = rng.choice(3, (24, 24), p=(0.5, 0.3, 0.2))
    mask = {"file": texture(tmp_path, np.eye(3)[which]), "repeat": repeat, "unit": unit}
    colors = {"#ff0000": load_fabric("linen"), "#00ff00": load_fabric("velvet"), "#0000ff": load_fabric("flannel")}
    look = {"mesh": board(8), "camera": FRONT, "size": (12, 12), "background": False, "shadows": "off", "spp": 6}
    layers = renderer.render(fabric="silk_shot", fabrics=colors, fabric_mask=mask, aovs="cryptomatte", **look)
    np.testing.assert_allclose(layers["beauty"][..., 3], 1.0, atol=1e-6)
    pairs = layers["CryptoMaterial"].reshape(144, -1, 2)
    shares = sorted(pairs[..., 1][pairs[..., 0] == value].sum() / 144 for value in np.unique(pairs[..., 0]) if value)
    np.testing.assert_allclose(shares, sorted((which == n).mean() for n in range(3)), atol=0.03)


def test_each_place_of_a_mask_casts_the_shadow_of_its_fabric(renderer, tmp_path):
    """A sheet of four cells over a sheet, by a mask sheer on its left: there light comes through it, and nowhere else."""
    low, high = board(8, 1), board(2, 1)
    high = high.moved(0.7 * high.positions + np.array([0.0, 0.5, 0.0], "f4"))
    mask = texture(tmp_path, np.repeat(np.repeat([[(1, 0, 0), (0, 1, 0)]], 8, 0), 4, 1))
    slanting = Suns(np.array([[0.0, 1.0, -0.8]]) / np.sqrt(1.64), np.full((1, 3), 3.0))
    sun = Lights(SphericalGaussians(np.array([[0.0, 1.0, 0.0]]), np.array([2.0]), np.full((1, 3), 0.01)), slanting)
    look = {
        "camera": OVERHEAD,
        "size": (24, 24),
        "background": False,
        "shadows": "sun",
        "threads": False,
        "lights": sun,
    }
    cloths = {"mesh": [low, high], "fabric": "linen"}
    fabrics = {"#f00": "sheer_voile", "#0f0": "linen"}
    shown = renderer.render(**look, **cloths, fabrics=fabrics, fabric_mask=mask)[..., 1]
    assert len(renderer.stage.cloths_in_frame) == 2
    # What is picked on the upper sheet's left is a place of the mask.
    left_side, right_side = (renderer.pick(x, 0.5) for x in (0.4, 0.6))
    assert (left_side.mask, right_side.mask) == (1, 2) and left_side.names == ("board",)
    # Below the upper sheet's edge (0.7) there is its shadow; the lower sheet has the mask, too, but each half its own fabric.
    bare = renderer.render(**look, mesh=low, fabric="linen", fabrics=fabrics, fabric_mask=mask)[..., 1]
    left = shown[21:23, 6:10] / bare[21:23, 6:10]
    right = shown[21:23, 14:18] / bare[21:23, 14:18]
    assert 0.3 < left.min() and left.max() < 0.9 and right.max() < 0.05
    # Paths show the same, and a ray picks the same.
    traced = look | {"shadows": "full", "method": "path", "spp": 8, "bounce": False}
    shown = renderer.render(**traced, **cloths, fabrics=fabrics, fabric_mask=mask)[..., 1]
    assert [renderer.pick(x, 0.5) for x in (0.4, 0.6)] == [left_side, right_side]
    assert [renderer.pick(x, 0.02)[::2] for x in (0.4, 0.6)] == [(0, 1), (1, 2)], "beside it the lower one is picked"
    np.testing.assert_allclose(np.median(shown[21:23, 6:10] / bare[21:23, 6:10]), np.median(left), rtol=0.02)
    assert shown[21:23, 14:18].max() < 0.02
    # A place that is cut out is looked through.
    cut = {"opacities": {"board": texture(tmp_path, np.repeat([[0.0, 1.0]], 2, 0), "cut.exr")}}
    renderer.render(**traced, mesh=high, fabric="linen", **cut, objects=("sphere",))
    assert renderer.pick(0.4, 0.5) is None and renderer.pick(0.6, 0.5).names == ()


# -- from files and options ----------------------------------------------------------------------------------------------


def test_options_name_maps_for_all_cloth_and_for_parts(tmp_path):
    options = SceneOptions(print=["a.png", "Skirt=b.png"], print_repeat=0.3, print_unit="m", opacity=["lace.png"])
    scene = scene_of(None, options)
    assert scene.print == PrintMap(file="a.png", repeat=0.3, unit="m") and scene.opacity == OpacityMap(file="lace.png")
    assert scene.prints == {"Skirt": PrintMap(file="b.png", repeat=0.3, unit="m")}
    assert scene_of(None, SceneOptions()).print is None
    with pytest.raises(InputError, match="--print-repeat: there is no print"):
        scene_of(None, SceneOptions(print_repeat=0.5))
    with pytest.raises(InputError, match="PART=PRINT"):
        scene_of(None, SceneOptions(print=["=b.png"]))
    with pytest.raises(InputError, match="print: repeat"):
        scene_of(None, SceneOptions(print=["a.png"], print_repeat=-1.0))


def test_a_scene_file_keeps_its_maps_beside_it(tmp_path):
    texture(tmp_path, [[1.0]], "roses.exr")
    (tmp_path / "s.toml").write_text('print = "roses.exr"\n[opacities.Trim]\nfile = "roses.exr"\nrepeat = 2\n')
    scene = load_scene(tmp_path / "s.toml")
    assert scene.print.file == str(tmp_path / "roses.exr") and scene.opacities["Trim"].repeat == 2
    save_scene(tmp_path / "t.toml", scene)
    assert 'file = "roses.exr"' in (tmp_path / "t.toml").read_text() and load_scene(tmp_path / "t.toml") == scene
    assert Scene.parse(scene.stored()) == scene


def test_maps_that_cannot_be_are_one_line(renderer, tmp_path):
    look = {"size": (8, 8), "shadows": "off", "mesh": "sphere"}
    with pytest.raises(InputError, match=r"none\.png"):
        renderer.render(print=str(tmp_path / "none.png"), **look)
    with pytest.raises(InputError, match="prints: no part is called Skirt"):
        renderer.render(prints={"Skirt": inks(tmp_path)}, **look)
    bare = Mesh.from_arrays(board().positions, board().triangles, name="bare")
    with pytest.raises(InputError, match="print: mesh bare has no UVs"):
        renderer.render(print=inks(tmp_path), **look | {"mesh": bare})


def test_fabric_masks_from_options_and_files(renderer, tmp_path, capsys):
    scene = scene_of(None, SceneOptions(fabric=["linen", "#f00=velvet"], fabric_mask=["m.png"], fabric_mask_repeat=0.5))
    assert scene.fabrics == {"#ff0000": "velvet"} and scene.fabric_mask == FabricMaskMap(file="m.png", repeat=0.5)
    texture(tmp_path, np.repeat([[(1.0, 0.0, 0.0), (0.0, 0.0, 0.0)]], 2, 0), "m.exr")
    (tmp_path / "s.toml").write_text('fabric_mask = "m.exr"\nmesh = "sphere"\n[fabrics]\n"#FF0000" = "velvet"\n')
    scene = load_scene(tmp_path / "s.toml")
    assert Scene.parse(scene.stored()) == scene and scene.fabric_mask.file == str(tmp_path / "m.exr")
    look = {"size": (8, 8), "shadows": "off"}
    renderer.render(scene, **look)
    # Two spellings of a colour are one, the last counts; and a part may be called as no colour is, or as one.
    spelt = scene.changed(fabrics={**scene.fabrics, "#F00": "linen"})
    assert spelt.fabrics == {"#ff0000": "linen"}
    named = [replace(board(), name=name) for name in ("#a b", "#abc")]
    patterns = {"#a b": "velvet", part_pattern("#abc"): "linen"}
    renderer.render(mesh=named, fabrics=patterns, **look)
    assert [cloth.fabric.name for cloth in renderer.prepare(mesh=named, fabrics=patterns, **look).cloths] == [
        load_fabric(name).name for name in ("velvet", "linen")
    ]
    for changes, said in (
        ({"fabrics": {}}, "no colour has a fabric, and the picture has #000000, #ff0000"),
        ({"fabrics": {"#00ff00": "velvet"}}, "no place of the fabric mask has the colour #00ff00"),
        ({"fabric_mask": None}, "#ff0000 is a colour of a fabric mask, and there is none"),
        (
            {"fabrics": {"#12345": "velvet"}},
            "no part is called #12345, .* a colour of a fabric mask is #rgb or #rrggbb",
        ),
        ({"mesh": Mesh.from_arrays(board().positions, board().triangles, name="bare")}, "mesh bare has no UVs"),
    ):
        with pytest.raises(InputError, match=said):
            renderer.render(scene, **look | changes)
