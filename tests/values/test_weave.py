"""Weaves: areas against brute force, the maps' means, roll, signs, what a [weave] table makes of a fabric, its doors."""

import hashlib
import json

import numpy as np
import pytest

from glcloth.cli import main
from glcloth.errors import InputError
from glcloth.fabric import FABRICS, Fabric, Yarn, builtin_fabrics, load_fabric, save_fabric
from glcloth.methods.albedo import diffuse_albedo
from glcloth.methods.weave_maps import strands_across
from glcloth.twins import footprint
from glcloth.twins.cloth import f_cloth
from glcloth.weave import pile
from glcloth.weave import tile as tiles
from glcloth.weave.draft import Draft
from glcloth.weave.floats import float_lengths
from glcloth.weave.levels import levels_of, side_by_side
from glcloth.weave.maps import mip_levels
from glcloth.weave.model import Weave
from glcloth.weave.named import WEAVES, named_draft, plain, twill
from glcloth.weave.picture import weave_picture
from glcloth.weave.report import weave_report
from glcloth.weave.tangents import between, sums
from glcloth.weave.tile import make_tile, tile_size

# Records of the fabrics that were there before weaves, as commit 58edb22 has them.
OLD = {
    "linen": "110be3dc43b7af99",
    "silk_crepe_de_chine": "abf3578406caef8e",
    "satin_charmeuse_front": "b32ef468a1fceb7d",
    "satin_charmeuse_back": "c4f78dedbf42bfcb",
    "silk_shot": "cba64e678dac7182",
    "velvet": "699a6dc569bbe332",
    "lace": "472a6bf6faf2239f",
    "sheer_voile": "ba6c59f10d8a49c3",
}
WOVEN = [name for name in builtin_fabrics() if (w := load_fabric(name).weave) is not None and w.far == "weave"]
PUBLISHED = [name for name in builtin_fabrics() if (w := load_fabric(name).weave) is not None and w.far == "yarns"]
SOME = ["poplin", "denim_raw", "charmeuse", "houndstooth", "voile", "drawn_thread", "gabardine", "waffle"]


def weave(draft="twill_3_1", ends=25.0, picks=20.0, **changes) -> Weave:
    return Weave.model_validate({"draft": draft, "ends_per_cm": ends, "picks_per_cm": picks, **changes})


def maps_of(fabric, size=None):
    """The maps of a fabric, and its weights per yarn."""
    weights = [[w for t, w in zip(fabric.tangents, fabric.weights[:, 0], strict=True) if t.yarn == j] for j in (0, 1)]
    tilts = [[np.degrees(t.tilt) for t in fabric.tangents if t.yarn == j] for j in (0, 1)]
    return fabric.weave.maps(tilts, weights, size), weights


@pytest.mark.parametrize("cut", [False, True])
def test_a_click_remakes_only_the_strips_about_its_threads(monkeypatch, cut):
    """The tile is to the bit the one that is made from nothing, of uneven yarns that lie over each other, too."""
    rng = np.random.default_rng(2)
    picks, ends = 23, 19
    sizes = {
        f"{system}_{what}": rng.uniform(low, 0.06, count)
        for system, count in (("warp", ends), ("weft", picks))
        for what, low in (("spacing", 0.03), ("thickness", 0.01))
    }
    eyelets = rng.random((picks, ends)) < 0.1 if cut else None
    drawdown = rng.random((picks, ends)) < 0.5
    places, path = [], tiles.path
    monkeypatch.setattr(tiles, "path", lambda up, x, bow: (places.append(len(up) * len(x)), path(up, x, bow))[1])

    def shape():
        return weave(
            Draft(drawdown.copy(), cut=eyelets, **sizes), width=(1.05, 0.9), pinch=(0.1, 0.2), bow=(0.4, 0.0)
        ).shape

    make_tile(shape(), (256, 256))
    for _ in range(3):
        drawdown[rng.integers(picks), rng.integers(ends)] ^= True
        places.clear()
        quick, few = make_tile(shape(), (256, 256)), sum(places)
        tiles._latest.clear()
        places.clear()
        whole = make_tile.__wrapped__(shape(), (256, 256))
        assert few < 0.8 * sum(places)
        for name in ("system", "thread", "tilt", "side", "height"):
            np.testing.assert_array_equal(getattr(quick, name), getattr(whole, name))


# -- areas and geometry ----------------------------------------------------------------------------------------------------


def brute_force(w: Weave, n: int, rng) -> tuple[np.ndarray, np.ndarray]:
    """(areas [2], mean |tilt| of the warp where it is on top) from n random places; one yarn after the other, no arrays.

    Written from the formulas of facts-weave.md 2, apart from the package's code.
    """
    d = w.drafted
    picks, ends = d.structure
    p = 1 / w.ends_per_cm, 1 / w.picks_per_cm
    b = [w.flat[j] * w.width[j] * p[j] for j in (0, 1)]
    h = w.crimp * sum(b), (1 - w.crimp) * sum(b)
    steep = np.arctan(np.pi * h[0] / (2 * p[1])), np.arctan(np.pi * h[1] / (2 * p[0]))
    edges = [
        np.concatenate([[0], np.cumsum(s[:k] / s[:k].mean())])
        for s, k in ((d.warp_spacing, ends), (d.weft_spacing, picks))
    ]
    thick = [t[:k] / t[:k].mean() for t, k in ((d.warp_thickness, ends), (d.weft_thickness, picks))]

    def axis(up, x, bow):
        k, m = int(x), len(up)
        if all(up) or not any(up):
            return (1.0 if up[0] else -1.0), 0.0, 0.0
        first, last = k, k
        while up[(first - 1) % m] == up[k]:
            first -= 1
        while up[(last + 1) % m] == up[k]:
            last += 1
        run = last - first + 1
        t = 2 * (x - first) / run - 1
        q = min(1.0, (1 - abs(t)) * run / (2 * (0.5 + bow * (run - 1) / 2)))
        side = 1.0 if up[k] else -1.0
        return side * np.sin(np.pi / 2 * q), side * np.sign(t) * np.cos(np.pi / 2 * q), abs(t)

    count, tilts = [0, 0], []
    for _ in range(n):
        place = rng.uniform(0, ends), rng.uniform(0, picks)
        crossing = [np.interp(place[j], edges[j], np.arange(len(edges[j]))) for j in (0, 1)]
        best = (-np.inf, -1, 0.0)
        for j, m in enumerate((ends, picks)):
            for i in range(-2, m + 2):
                up = (
                    [bool(d.drawdown[y, i % m]) for y in range(picks)]
                    if j == 0
                    else [not u for u in d.drawdown[i % m, :ends]]
                )
                z, slope, dive = axis(up, crossing[1 - j] % len(up), w.bow[j])
                half = 0.5 * w.width[j] * thick[j][i % m] * (1 - w.pinch[j] * max(0, (dive - 0.4) / 0.6) ** 2)
                middle = 0.5 * (edges[j][i % m] + edges[j][i % m + 1]) + m * (i // m)
                y = (place[j] - middle) / half
                if abs(y) < 1:
                    z = 0.5 * h[j] * z + 0.5 * b[j] * thick[j][i % m] * np.sqrt(1 - y * y)
                    best = max(best, (z, j, steep[j] * slope))
        if best[1] >= 0:
            count[best[1]] += 1
        if best[1] == 0:
            tilts.append(abs(best[2]))
    return np.array(count) / n, np.mean(tilts)


@pytest.mark.parametrize(
    "w",
    [
        weave("plain", width=0.7, pinch=0.2),
        weave("twill_3_1", width=(1.2, 0.85), flat=(0.4, 0.36), crimp=0.3, bow=(0.6, 0.2)),
        weave("satin_5", 60, 30, width=(1.05, 0.8)),
        weave("herringbone", 9, 8),
        load_fabric("drawn_thread").weave,
        weave(Draft(twill(2, 2), warp_spacing=[0.03, 0.05, 0.05, 0.07], warp_thickness=[0.02, 0.05, 0.06, 0.05])),
    ],
    ids=["plain", "denim", "satin", "herringbone", "drawn thread", "uneven"],
)
def test_areas_and_tilts_against_brute_force(w):
    """Within three standard errors of 2500 random places."""
    n = 2500
    areas, tilt = brute_force(w, n, np.random.default_rng(3))
    found = w.derived((8.0, 8.0))
    for mine, theirs in zip(found.areas, areas, strict=True):
        assert mine == pytest.approx(theirs, abs=3 * np.sqrt(max(theirs * (1 - theirs), 0.01) / n))
    tile = w.tile()
    assert np.abs(tile.tilt[tile.system == 0]).mean() == pytest.approx(tilt, abs=0.02)


def test_cover_of_plain_weave():
    """Peirce 1937: cover is c_1 + c_2 - c_1 c_2."""
    found = weave("plain", width=(0.6, 0.4), pinch=0.0).derived((10.0, 10.0))
    assert sum(found.areas) == pytest.approx(0.6 + 0.4 - 0.24, abs=0.005)


@pytest.mark.parametrize(
    "changes, tilts, areas",
    [
        (dict(draft="plain", width=0.42, flat=0.71), (25.1, 25.1), (0.32, 0.32)),
        (dict(draft="plain", width=(1.0, 0.4), flat=(0.3, 0.6), crimp=0.55), (25.0, 21.0), (0.79, 0.19)),
        (dict(draft="satin_8", width=(1.06, 0.85), flat=(0.35, 0.5), bow=(0.6, 0.3)), (32.0, 32.0), (0.90, 0.10)),
        (dict(draft="twill_3_1", width=(1.0, 0.85), flat=(0.4, 0.36), crimp=0.19), (11.9, 41.9), (0.76, 0.23)),
        (dict(draft="plain", width=0.95, flat=0.24, crimp=0.58), (22.6, 16.7), (0.49, 0.49)),
    ],
    ids=["linen", "shot silk", "charmeuse", "denim", "polyester lining"],
)
def test_published_angles_and_areas(changes, tilts, areas):
    """facts-weave.md 2: with sensible widths the geometry gives what Sadeghi 2013 and Irawan and Marschner 2012 fitted."""
    w = weave(ends=20.0, picks=20.0, **changes)
    assert np.degrees(w.shape.largest_tilts) == pytest.approx(tilts, abs=0.15)
    assert w.derived((5.0, 5.0)).areas == pytest.approx(areas, abs=0.015)


def test_the_back_of_a_cloth_is_its_exchange():
    """Warp and weft exchanged, the drawdown complemented and transposed: the same cloth turned by 90 degrees."""
    d = Draft(twill(3, 1))
    turned = Draft(~d.drawdown.T)
    a = weave(d, 20, 20, width=(0.9, 0.7), flat=(0.4, 0.5), crimp=0.3).derived((8.0, 12.0))
    b = weave(turned, 20, 20, width=(0.7, 0.9), flat=(0.5, 0.4), crimp=0.7).derived((12.0, 8.0))
    assert a.areas == pytest.approx(b.areas[::-1]) and np.allclose(a.shares[0], b.shares[1])


@pytest.mark.parametrize("system", [0, 1])
def test_tilt_is_positive_where_a_yarn_goes_down(system):
    tile = weave("twill_2_2", width=0.7, pinch=0.0).tile((256, 256))
    # Along the middle line of a yarn nothing but its axis rises and falls.
    middle = (tile.system == system) & (np.abs(tile.side) < 0.05)
    rise = np.gradient(tile.height, axis=1 - system)
    inner = middle & np.roll(middle, 1, 1 - system) & np.roll(middle, -1, 1 - system) & (np.abs(tile.tilt) > 0.1)
    assert inner.sum() > 100 and (np.sign(rise[inner]) == -np.sign(tile.tilt[inner])).all()


def test_z_twist_rises_to_the_left_of_the_yarn():
    """Left of the warp is +v, of the weft (which runs along +v) -u; positive tilt goes down."""
    tile = weave("plain", width=0.8, twist_deg=20, tilt_deg=0).tile((128, 128))
    for system, left in ((0, 1.0), (1, -1.0)):
        mine = (tile.system == system) & (np.abs(tile.side) > 0.1)
        assert (np.sign(tile.tilt[mine]) == -left * np.sign(tile.side[mine])).all()


def test_float_lengths():
    warp, weft = float_lengths(named_draft("satin_5").drawdown)
    assert warp.tolist() == [4] * 5 and weft.tolist() == [1] * 5
    never = np.array([[True, False], [True, True]])
    assert [f.tolist() for f in float_lengths(never)] == [[1, 2], [1]]


def test_a_thread_that_is_never_bound_lies_straight():
    d = np.ones((2, 2), bool)
    w = weave(Draft(d), width=1.0)
    found = w.derived((8.0, 8.0))
    assert found.areas[0] > 0.95 and found.tilts_deg[0] == (0.0,) and found.areas[1] == 0.0


# -- maps ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SOME)
def test_the_mean_of_every_map_is_one_at_every_level(name):
    fabric = load_fabric(name)
    maps, weights = maps_of(fabric)
    assert maps.rel.dtype == float and len(maps.rel) == len(fabric.tangents)
    levels = mip_levels(maps.rel)
    assert levels[-1].shape == (len(maps.rel), 1, 1)
    for level in levels:
        assert np.abs(level.mean((1, 2)) - 1).max() < 1e-6
    assert (maps.rel >= 0).all() and abs(maps.height.mean()) < 1e-12
    assert maps.share.mean((1, 2)) == pytest.approx([y.area for y in fabric.yarn])
    assert maps.hole.mean() == pytest.approx(fabric.gap, abs=2e-4)
    assert [sum(w) for w in weights] == pytest.approx([y.area for y in fabric.yarn])


@pytest.mark.parametrize("name", SOME)
def test_roll_has_mean_zero_under_every_tangent(name):
    maps, weights = maps_of(load_fabric(name))
    first = 0
    for j in (0, 1):
        s = np.divide(maps.roll[j], maps.share[j], out=np.zeros_like(maps.roll[j]), where=maps.share[j] > 0)
        for t in range(len(weights[j])):
            assert abs((maps.rel[first + t] * s).mean()) < 1e-9
        assert np.abs(s).max() > 0.1
        first += len(weights[j])


def test_shares_of_a_place_add_up_to_one():
    fabric = load_fabric("denim_raw")
    fabric = fabric.changed(weave=fabric.weave.changed(occlusion=0.0))
    maps, weights = maps_of(fabric)
    total = np.tensordot(np.concatenate(weights), maps.rel, 1)
    assert np.allclose(total + maps.hole, 1.0, atol=1e-3)  # a tangent below 1e-5 of the cloth is left out


def test_near_pictures_have_the_far_field_as_their_mean():
    """Section 4 of facts-weave.md: with Q and w_t of the whole weave the mean over a tile is today's cloth, exactly."""
    fabric = load_fabric("houndstooth")
    maps, _ = maps_of(fabric, (64, 64))
    yarns, tangents, weights, gap, sigma = fabric.arrays()
    rng = np.random.default_rng(0)
    omega_i, omega_o = rng.normal(size=(2, 12, 3))
    omega_i[:, 2], omega_o[:, 2] = np.abs(omega_i[:, 2]), np.abs(omega_o[:, 2])
    omega_i, omega_o = (w / np.linalg.norm(w, axis=-1, keepdims=True) for w in (omega_i, omega_o))
    far = f_cloth(omega_i, omega_o, yarns, tangents, weights, gap, sigma)
    # Only the first factor is the place's; the normaliser's is the whole weave's.
    near = np.zeros_like(far)
    for rel in maps.rel.reshape(len(weights), -1).T[::7]:
        local = np.column_stack([weights[:, 0] * rel, weights[:, 1]])
        near += f_cloth(omega_i, omega_o, yarns, tangents, local, gap, sigma)
    sample = maps.rel.reshape(len(weights), -1).T[::7]
    expected = f_cloth(
        omega_i, omega_o, yarns, tangents, np.column_stack([weights[:, 0] * sample.mean(0), weights[:, 1]]), gap, sigma
    )
    assert np.allclose(near / len(sample), expected, rtol=1e-9)
    assert np.allclose(expected, far, rtol=0.1, atol=1e-3)


def test_a_published_far_field_keeps_its_tangents_under_a_weave():
    """far = "yarns": tangents and weights are the yarns' own; the maps still have mean 1, whatever the tilts."""
    w = weave("plain", 20, 20, far="yarns", width=0.8)
    for name in ("linen", "satin_charmeuse_front", "velvet", "silk_shot"):
        plain = load_fabric(name)
        fabric = plain.changed(weave=w)
        assert fabric.tangents == plain.tangents and np.array_equal(fabric.weights, plain.weights)
        maps, _ = maps_of(fabric)
        assert np.abs(maps.rel.mean((1, 2)) - 1).max() < 1e-9


@pytest.mark.parametrize("name", PUBLISHED)
def test_the_weaves_of_the_papers_fabrics_have_their_far_field(name):
    """Maps of the published tangents: mean 1 at every level; and the weave itself comes near the published areas."""
    fabric = load_fabric(name)
    # Tufts differ at every place of the repeat, so their maps are large; smaller ones are made alike.
    maps, _ = maps_of(fabric, (256, 256) if fabric.weave.drafted.pile else None)
    for level in mip_levels(maps.rel):
        assert np.abs(level.mean((1, 2)) - 1).max() < 1e-6
    assert maps.share.mean((1, 2)) == pytest.approx([y.area for y in fabric.yarn])
    if fabric.weave.drafted.pile:
        return
    assert fabric.weave.derived((5.0, 5.0)).areas == pytest.approx([y.area for y in fabric.yarn], abs=0.09)


def test_tufts_of_a_pile_lean_to_all_sides_alike(monkeypatch):
    """All leans from upright to the lowest in equal shares, every place some of each; and hairs spread outward."""
    fabric = load_fabric("velvet_ruby")
    weave = fabric.weave.changed(irregularity={"shift": 0.0})
    tile = weave.tile((256, 256))
    lean = 90.0 - np.abs(np.degrees(tile.tilt))
    for share in ((tile.system == 0).mean(), (tile.tilt > 0.0).mean()):
        assert share == pytest.approx(0.5, abs=0.03)
    assert np.histogram(lean, 7, (0.0, 35.0))[0] == pytest.approx(np.full(7, lean.size / 7), rel=0.01)
    maps, weights = maps_of(fabric, (256, 256))
    for j, rel in enumerate(np.split(maps.rel, [len(weights[0])])):
        np.testing.assert_allclose(maps.share[j], np.tensordot(weights[j], rel, 1), rtol=1e-9)
    low, high = np.quantile(tile.height, (0.2, 0.8))
    assert maps.rel.min(0)[tile.height > high].mean() > 1.1 * maps.rel.min(0)[tile.height < low].mean()
    assert maps.rel.min() > 0.2 and not maps.roll.any()
    # It goes on over the edge of the repeat as it does inside.
    steps = np.abs(np.diff(maps.share[0], axis=1)).mean(), np.abs(maps.share[0][:, 0] - maps.share[0][:, -1]).mean()
    assert steps[1] == pytest.approx(steps[0], rel=0.15)
    for picks, ends in ((12, 48), (48, 12)):
        height = (
            weave.changed(draft=Draft(np.tile(plain(), (picks // 2, ends // 2)), pile=True)).tile((256, 256)).height
        )
        for axis in (0, 1):
            over = np.abs(height.take(0, axis) - height.take(-1, axis)).mean()
            assert over == pytest.approx(np.abs(np.diff(height, axis=axis)).mean(), rel=0.25)
    for name in ("NAP", "TUFT", "HAIR", "JITTER", "RAGGED"):
        monkeypatch.setattr(pile, name, 0.0)
    places = np.array([4.7, 4.3])  # right and left of the middle of a tuft
    # Rows stand a quarter of a tuft aside, to the right in even ones.
    system, _, tilt, _, height = pile.pile_fields((48, 48), 0.07, np.array([4.5]), places + 0.25)
    assert not system.any() and tilt[0, 0] < 0.0 < tilt[0, 1]  # a tilt is negative where a hair rises along +u
    system, _, tilt, _, _ = pile.pile_fields((48, 48), 0.07, places, np.array([4.75]))
    assert system.all() and tilt[0, 0] < 0.0 < tilt[1, 0]
    assert height.max() < 0.0 and np.ptp(height) < 1e-12


def test_depths_are_darker():
    """Occlusion takes light from where a yarn dives and gives it to where it is on top."""
    fabric = load_fabric("tartan")
    tile, (maps, _) = fabric.weave.tile(), maps_of(fabric)
    high = (tile.system == 0) & (tile.height > np.quantile(tile.height[tile.system == 0], 0.8))
    low = (tile.system == 0) & (tile.height < np.quantile(tile.height[tile.system == 0], 0.2))
    assert maps.share[0][high].mean() > 1.1 * maps.share[0][low].mean()


def test_levels_of_uneven_sides():
    levels = mip_levels(np.arange(32.0).reshape(1, 4, 8))
    assert [a.shape for a in levels] == [(1, 4, 8), (1, 2, 4), (1, 1, 2), (1, 1, 1)]
    assert all(a.mean() == 15.5 for a in levels)


def test_sizes_are_powers_of_two():
    assert tile_size(2, 2) == (256, 256) and tile_size(4, 16) == (512, 256) and tile_size(641, 641) == (1024, 1024)


def test_hats_are_a_partition():
    rng = np.random.default_rng(1)
    tilts, x = np.sort(rng.normal(size=7)), rng.normal(size=500)
    at = between(x, tilts)
    assert sums(at, 1.0, 7).sum() == pytest.approx(500)
    assert sums(at, 1.0, 7) @ tilts == pytest.approx(np.clip(x, tilts[0], tilts[-1]).sum())


# -- colours -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["houndstooth", "gingham", "tartan"])
def test_colours_of_threads_have_the_yarn_s_as_their_mean(name):
    fabric = load_fabric(name)
    maps, _ = maps_of(fabric)
    colors, size = fabric.weave.color_map(maps)
    for j, yarn in enumerate(fabric.yarn):
        mean = colors[j].mean((0, 1), dtype=float)
        assert mean[:3] / mean[3] == pytest.approx(yarn.albedo, rel=1e-4)
    picks, ends = weave_report(fabric.weave, fabric.yarn)["repeat"]
    assert size == pytest.approx((0.01 * picks / fabric.weave.picks_per_cm, 0.01 * ends / fabric.weave.ends_per_cm))


def test_the_colour_of_a_place_is_that_of_its_thread():
    stripes = [{"count": 1, "albedo": (c, c, c)} for c in (0.1, 0.3, 0.5)]
    w = weave("plain", colors="stripes", warp_stripes=stripes, weft_stripes=stripes, width=1.2)
    maps = w.maps(((0.0,), (0.0,)), ((0.5,), (0.5,)))
    colors, _ = w.color_map(maps)
    H = colors.shape[1]
    for end in range(6):
        row = colors[0, int((end + 0.5) / 6 * H)]
        seen = row[row[:, 3] > 0]
        assert np.allclose(seen[:, 0] / seen[:, 3], (0.1, 0.3, 0.5)[end % 3], rtol=0.02)


# -- the table of a fabric file ----------------------------------------------------------------------------------------------

TABLE = {"draft": "twill_2_2", "ends_per_cm": 20, "picks_per_cm": 20}
YARN = {"albedo": (0.3, 0.3, 0.3), "eta": 1.5, "k_d": 0.3, "gamma_s_deg": 12, "gamma_v_deg": 24}


@pytest.mark.parametrize("name", OLD)
def test_the_old_fabrics_keep_every_bit(name):
    fabric = load_fabric(name)
    yarns, tangents, weights, gap, sigma = fabric.arrays()
    plain = [{k: (v.tolist() if hasattr(v, "tolist") else float(v)) for k, v in y.items()} for y in yarns]
    paper = fabric.changed(normalization="paper").weights.tolist()
    tangents = [tuple(map(float, t)) for t in tangents]
    areas = [y.area for y in fabric.yarn]
    record = repr((plain, tangents, weights.tolist(), float(gap), float(sigma), paper, areas))
    assert hashlib.sha256(record.encode()).hexdigest()[:16] == OLD[name]


@pytest.mark.parametrize("name", WOVEN)
def test_the_woven_fabrics(name):
    """The far field of each is its weave's, its file says where its numbers come from, and it survives being saved."""
    fabric = load_fabric(name)
    maps, weights = maps_of(fabric, (64, 64))
    assert 0 < len(fabric.tangents) <= 24 and all(0.02 < sum(w) <= 1 for w in weights)
    text = (FABRICS / f"{name}.toml").read_text(encoding="utf-8")
    assert text.startswith("# ") and len(text.split("name =")[0]) > 150
    assert np.isfinite(maps.rel).all()


@pytest.mark.parametrize("name", [*WOVEN, "velvet_ruby", "velvet_midnight"])
def test_no_fabric_reflects_more_than_it_gets(name):
    """White cotton and linen reflect about 0.8; seen from steeply the model may give a little more than it got."""
    assert diffuse_albedo(load_fabric(name)).max() < 0.85


def test_there_are_many_fabrics_by_their_trade_names():
    wanted = (
        "poplin percale oxford chambray canvas linen_light linen_heavy voile organza denim_raw denim_washed gabardine "
    )
    wanted += "flannel herringbone_tweed houndstooth tartan gingham taffeta shot_taffeta crepe_de_chine charmeuse "
    wanted += "duchesse_satin damask velvet_ruby velvet_midnight drawn_thread"
    assert set(wanted.split()) <= set(builtin_fabrics()) and len(WOVEN) >= 24


def test_a_table_derives_areas_and_tangents(tmp_path):
    fabric = Fabric.parse({"name": "x", "yarn": [YARN, YARN], "weave": TABLE})
    found = fabric.weave.derived((12.0, 12.0))
    assert [y.area for y in fabric.yarn] == list(found.areas) and fabric.yarn[0].tangents_deg == found.tilts_deg[0]
    w = [t for t in zip(fabric.tangents, fabric.weights[:, 0], strict=True) if t[0].yarn == 0]
    assert [x for _, x in w] == pytest.approx([found.areas[0] * s for s in found.shares[0]])
    assert fabric.gap == pytest.approx(1 - sum(found.areas))
    # An edit of the weave or of a lobe's width derives them anew.
    open_cloth = fabric.changed(weave=fabric.weave.changed(width=0.5))
    assert open_cloth.gap > fabric.gap + 0.1
    narrow = fabric.changed(yarn=(fabric.yarn[0].changed(gamma_s_deg=4.0), fabric.yarn[1]))
    assert len(narrow.yarn[0].tilts_deg) > len(fabric.yarn[0].tilts_deg)
    save_fabric(tmp_path / "a.toml", open_cloth)
    assert load_fabric(tmp_path / "a.toml") == open_cloth and "area" not in (tmp_path / "a.toml").read_text()
    data = json.loads(open_cloth.model_dump_json())
    assert type(open_cloth).model_validate(data) == open_cloth


@pytest.mark.parametrize(
    "yarn, table, text",
    [
        ({"area": 0.5}, {}, "area: follows from [weave]"),
        ({"tangents_deg": [0]}, {}, "tangents_deg: follows from [weave]"),
        ({}, {"colors": "draft", "draft": "houndstooth"}, "albedo: follows from [weave]"),
        ({}, {"draft": "twil_2_2"}, 'did you mean "twill_2_2"'),
        ({}, {"draft": "nix.wif"}, "no such file"),
        ({}, {"draft": 7}, "expected a named weave"),
        ({}, {"draft": {"drawdown": ["#.", "#"]}}, "equal length"),
        ({}, {"draft": {"drawdwn": []}}, "unknown key"),
        ({}, {"draft": {"drawdown": ["#.", ".#"], "warp_colors": "red", "weft_colors": "#102030"}}, "#c8b496"),
        ({}, {"widht": 1}, "did you mean width"),
        ({}, {"width": 9}, "width: item 1 = 9"),
        ({}, {"crimp": 2}, "crimp = 2"),
        ({}, {"crimp": "x" * 9999}, "crimp = 'xxx"),
        ({}, {"ends_per_cm": 0}, "ends_per_cm = 0"),
        ({}, {"irregularity": {"shift": 5}}, "shift = 5"),
        ({"albedo": None}, {"colors": "draft"}, "the draft says no colours"),
        ({"albedo": None}, {"colors": "stripes"}, "needs warp_stripes"),
        ({"shares": [1.0]}, {"far": "yarns"}, "area: is missing"),
    ],
)
def test_wrong_tables_are_one_line(yarn, table, text):
    first = {name: value for name, value in {**YARN, **yarn}.items() if value is not None}
    second = YARN if "albedo" in first else first
    with pytest.raises(InputError) as error:
        Fabric.parse({"name": "x", "yarn": [first, second], "weave": {**TABLE, **table}}, "cloth.toml")
    assert text in str(error.value) and str(error.value).isprintable() and str(error.value).startswith("cloth.toml")


def test_a_draft_is_looked_for_beside_its_fabric(tmp_path):
    from glcloth.weave.wif import save_draft

    save_draft(tmp_path / "mine.wif", named_draft("herringbone"))
    text = (
        'name = "x"\n'
        + 2 * "[[yarn]]\nalbedo = [0.3, 0.3, 0.3]\neta = 1.5\nk_d = 0.3\ngamma_s_deg = 12\ngamma_v_deg = 24\n"
    )
    (tmp_path / "cloth.toml").write_text(text + '[weave]\ndraft = "mine.wif"\n', encoding="utf-8")
    fabric = load_fabric(tmp_path / "cloth.toml")
    assert fabric.weave.drafted.structure == (4, 16) and fabric.weave.ends_per_cm == pytest.approx(20)


def test_samples_curve_is_the_curve():
    """Linen from two tangents is far from its own curve; samples = "curve" is within 2 % rms of 65 equal samples."""
    linen = load_fabric("linen")
    rng = np.random.default_rng(0)
    omega_i, omega_o = rng.normal(size=(2, 1500, 3)) * (1, 1, 0.4) + (0, 0, 1)
    omega_i, omega_o = (w / np.linalg.norm(w, axis=-1, keepdims=True) for w in (omega_i, omega_o))
    keep = (omega_i[:, 2] > 0.26) & (omega_o[:, 2] > 0.26)

    def radiance(samples):
        yarns, tangents, weights, gap, sigma = linen.changed(
            yarn=tuple(y.changed(samples=samples) for y in linen.yarn)
        ).arrays()
        return f_cloth(omega_i[keep], omega_o[keep], yarns, tangents, weights, gap, sigma)[:, 1]

    def dense():
        tilts = np.radians(np.linspace(-25, 25, 401))
        tangents = [(j, t, 1) for j in (0, 1) for t in tilts]
        weights = np.full((802, 2), 0.33 / 401)
        yarns, _, _, gap, sigma = linen.arrays()
        return f_cloth(omega_i[keep], omega_o[keep], yarns, tangents, weights, gap, sigma)[:, 1]

    truth = dense()
    rms = [np.sqrt(np.mean((radiance(n) - truth) ** 2)) / truth.mean() for n in (2, 0)]
    assert rms[0] > 0.1 and rms[1] < 0.02


def test_samples_curve_survives_its_file(tmp_path):
    linen = load_fabric("linen")
    fabric = linen.changed(yarn=tuple(y.changed(samples="curve") for y in linen.yarn))
    save_fabric(tmp_path / "a.toml", fabric)
    again = load_fabric(tmp_path / "a.toml")
    assert 'samples = "curve"' in (tmp_path / "a.toml").read_text()
    assert np.array_equal(again.weights, fabric.weights)
    # What was derived and kept on both sides is no part of their equality.
    assert again == fabric and hash(again) == hash(fabric) and again != linen
    assert sum(fabric.yarn[0].tilt_shares) == pytest.approx(1) and fabric.gap == linen.gap


@pytest.mark.parametrize("shares, text", [((0.5,), "shares has 1"), ((0.5, 0.6), "add up to 1.1")])
def test_shares_are_checked(shares, text):
    with pytest.raises(InputError, match=text):
        Yarn(**YARN, area=0.5, tangents_deg=(-10, 10)).changed(shares=shares)
    assert Yarn(**YARN, area=0.5, tangents_deg=(-10, 10)).changed(shares=(0.3, 0.7)).tilt_shares == (0.3, 0.7)


# -- doors -------------------------------------------------------------------------------------------------------------------


def door(*arguments: str) -> None:
    """Run a command that is to succeed."""
    with pytest.raises(SystemExit) as stop:
        main(list(arguments))
    assert stop.value.code == 0


def test_weave_makes_a_fabric_and_tells_of_it(tmp_path, capsys):
    from glcloth.image import read_image
    from glcloth.weave.wif import save_draft

    save_draft(tmp_path / "a.wif", named_draft("houndstooth"))
    target, picture = tmp_path / "a.toml", tmp_path / "a.png"
    door("weave", str(tmp_path / "a.wif"), "-o", str(target), "--picture", str(picture), "--ends", "16", "--json")
    facts = json.loads(capsys.readouterr().out)
    assert facts["sett"] == {"warp": 16.0, "weft": 20.0} and facts["repeat"] == [8, 8] and facts["structure"] == [4, 4]
    assert facts["floats"]["warp"] == {"longest": 2, "mean": 2.0, "counts": {"2": 4}}
    assert sum(facts["area"].values()) + facts["gap"] == pytest.approx(1)
    fabric = load_fabric(target)
    assert fabric.weave.ends_per_cm == 16 and fabric == load_fabric(target)
    image = read_image(picture)
    assert image.shape[0] >= 256 and image.shape[1] > 2 * image.shape[0]
    door("weave", str(tmp_path / "a.wif"))
    assert "repeat   8 ends x 8 picks" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["nix.wif", "bare.toml", "a.txt"])
def test_weave_says_in_one_line_what_is_wrong(name, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    save_fabric("bare.toml", load_fabric("velvet").changed(weave=None))
    with pytest.raises(SystemExit) as stop:
        main(["weave", name])
    assert stop.value.code == 2 and len(capsys.readouterr().err.strip().splitlines()) == 1


def test_fabrics_lists_them(capsys):
    door("fabrics", "--json")
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["fabrics"]}
    assert set(rows) == set(builtin_fabrics()) and rows["denim_raw"]["weave"] == "twill_3_1"


def test_the_drawdown_is_drawn_as_weavers_draw_it():
    """Ends from the left, picks from the top, the warp's colour where it is on top; the cloth beside shows the same."""
    w = weave("twill_3_1", 20, 20, width=1.0)
    warp, weft = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    picture = weave_picture(w, (warp, weft), 640)
    cell = 640 // 16
    up = np.tile(WEAVES["twill_3_1"](), (4, 4))
    for start in (0, 17 * cell):
        middle = picture[cell // 2 :: cell, start + cell // 2 : start + 16 * cell : cell]
        assert np.array_equal(middle[..., 0] > middle[..., 2], up)


@pytest.mark.parametrize(("shape", "end"), [((64, 128), 3), ((16, 16), 0), ((512, 512), 4)])
def test_versions_of_a_map_keep_its_mean_and_repeat(shape, end):
    levels = levels_of(*shape, end)
    maps = np.random.default_rng(1).random((2, *shape))
    beside = side_by_side(maps, levels, "f8")
    taken = np.zeros(levels.shape, int)
    for lod, (h, w), (row, column) in zip(levels.lods, levels.sizes, levels.places, strict=True):
        version = beside[:, row : row + h, column : column + w]
        np.testing.assert_allclose(version.mean((1, 2)), maps.mean((1, 2)), rtol=1e-12)
        np.testing.assert_array_equal(beside[:, row : row + h, column - 1], version[:, :, -1])
        np.testing.assert_array_equal(beside[:, row + h, column : column + w], version[:, 0])
        assert (h, w) == tuple(max(round(n * 0.5**lod), 1) for n in shape)
        taken[row - 1 : row + h + 1, column - 1 : column + w + 1] += 1
    assert taken.max() == 1
    steps = np.diff(levels.lods)
    assert levels.lods[0] == 0.0 and levels.sizes[-1] == (1, 1) and set(steps) <= {0.25, 1.0}
    np.testing.assert_array_equal(
        steps == 0.25, (np.array(levels.lods[:-1]) >= levels.whole) & (np.array(levels.lods[:-1]) < end)
    )
    # The shader's numbers are these versions.
    number = footprint.level_number(np.array(levels.lods), (levels.whole, levels.end, len(levels.lods)), 0.5)
    np.testing.assert_array_equal(number, np.stack([np.arange(len(levels.lods)), np.zeros(len(levels.lods))], -1))
    np.testing.assert_array_equal(footprint.level_of_number(number[:, 0], (levels.whole, levels.end, 0)), levels.lods)


def test_thick_yarns_show_more_strands():
    """As many as fit across a yarn of that spacing, and never less than six or more than fourteen."""
    silk, middle, tweed = (
        strands_across(load_fabric(name)) for name in ("habotai", "linen_heavy", "herringbone_tweed")
    )
    assert silk == 6.0 and 6.0 < middle < tweed == pytest.approx(20.0 / 17.5 / 0.09)
