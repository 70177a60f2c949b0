"""A draft's loom, its grid of cells, drafts saved from a weave, and the thread counter's square."""

from types import SimpleNamespace

import numpy as np
import pytest

from glcloth.color import luminance
from glcloth.errors import InputError
from glcloth.fabric import builtin_fabrics, load_fabric
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh_files import load_mesh
from glcloth.light import equirect
from glcloth.light.environment import Environment
from glcloth.methods.weave_maps import even_shares, fabric_maps
from glcloth.picture import sheet
from glcloth.picture.frame import Cloth, Frame
from glcloth.picture.warm_up import WARM_UP, warm_up
from glcloth.scene import Scene
from glcloth.weave.draft import Draft
from glcloth.weave.loom import Loom
from glcloth.weave.model import Weave
from glcloth.weave.named import WEAVES, named_draft
from glcloth.weave.plain import draft_of, plain_draft
from glcloth.weave.wif import load_draft, save_draft
from glcloth.window.draft_grid import Cell, Grid, between, is_set, marked, said
from glcloth.window.orbit import view_of
from glcloth.window.thread_colors import in_use, painted, thread_colors
from glcloth.window.thread_counter import glass_at, pixel_of


@pytest.mark.parametrize("name", WEAVES)
def test_a_loom_weaves_its_drawdown_with_the_fewest_shafts(name):
    drawdown = named_draft(name).drawdown
    loom = Loom.of(drawdown)
    assert np.array_equal(loom.drawdown, drawdown)
    assert (loom.shafts, loom.treadles) == (len(np.unique(drawdown.T, axis=0)), len(np.unique(drawdown, axis=0)))


def test_twill_is_threaded_straight_and_cells_say_so():
    loom = Loom.of(named_draft("twill_2_2").drawdown)
    assert loom.threading.tolist() == [0, 1, 2, 3] == loom.treadling.tolist()
    grid = Grid.of(loom)
    for part, rows, columns in (("threading", 4, 4), ("tieup", 4, 4), ("drawdown", 4, 4), ("treadling", 4, 4)):
        for cell in (Cell(part, i, j) for i in range(rows) for j in range(columns)):
            x, y = grid.corner(cell)
            assert grid.cell(x + 0.5, y + 0.5) == cell
            diagonal = cell.row == cell.column
            assert part in ("tieup", "drawdown") or is_set(loom, cell) == diagonal
    assert grid.corner(Cell("threading", 0, 0)) == (0, grid.shafts - 1), "shaft 1 is next to the cloth"
    assert grid.cell(4.5, 0.5) is None and grid.cell(4.5, grid.shafts + 0.5) is None and grid.cell(-1, 3) is None
    for cell in (Cell("warp", 0, 3), Cell("weft", 2, 0)):
        x, y = grid.corner(cell)
        assert grid.cell(x + 0.5, y + 0.5) == cell and is_set(loom, cell)
    on_top = "warp" if loom.drawdown[1, 2] else "weft"
    assert said(loom, Cell("drawdown", 1, 2)) == f"end 3, pick 2: {on_top} on top"
    assert said(loom, Cell("threading", 2, 1)) == "end 2 is on shaft 2", "what is, not what a click would make"


def test_marks_change_what_a_loom_weaves():
    loom = Loom.of(named_draft("plain").drawdown).resized(4, 4)
    flipped = marked(loom, Cell("drawdown", 1, 2), not loom.drawdown[1, 2])
    assert (flipped.drawdown != loom.drawdown).sum() == 1 and flipped.drawdown[1, 2] != loom.drawdown[1, 2]
    # An end on the other shaft works as its neighbour does; a tie moves all ends of the shaft in all picks of the treadle.
    moved = marked(loom, Cell("threading", 1, 0), True)
    assert np.array_equal(moved.drawdown[:, 0], loom.drawdown[:, 1])
    tied = marked(loom, Cell("tieup", 1, 0), not loom.tieup[0, 1])
    assert np.argwhere(tied.drawdown != loom.drawdown).tolist() == [[0, 1], [0, 3], [2, 1], [2, 3]]
    # One new shaft, no more; it is tied to nothing.
    new = marked(loom, Cell("threading", 2, 3), True)
    assert new.shafts == 3 and not new.drawdown[:, 3].any() and marked(loom, Cell("threading", 3, 3), True) is loom
    assert marked(loom, Cell("tieup", 7, 7), True) is loom
    assert between(Cell("drawdown", 0, 0), Cell("drawdown", 2, 4))[-1] == Cell("drawdown", 2, 4)


@pytest.mark.parametrize("name", ["tartan", "denim_raw", "houndstooth"])
def test_a_draft_saved_from_a_weave_has_its_sett_and_colours(tmp_path, name):
    fabric = load_fabric(name)
    weave = fabric.weave
    save_draft(tmp_path / "saved.wif", weave.as_draft([yarn.albedo for yarn in fabric.yarn]))
    draft = load_draft(tmp_path / "saved.wif")
    assert 1.0 / draft.warp_spacing.mean() == pytest.approx(weave.ends_per_cm)
    assert draft.weft_thickness.mean() == pytest.approx(weave.width[1] / weave.picks_per_cm)
    n, m = weave.drafted.drawdown.shape
    assert np.array_equal(draft.drawdown[:n, :m], weave.drafted.drawdown)
    own = weave.thread_colors or [np.array([yarn.albedo]) for yarn in fabric.yarn]
    shown = np.minimum(np.resize(own[0], draft.warp_colors.shape) / 0.42, 1.0)
    assert np.abs(draft.warp_colors - shown).max() < 0.005


@pytest.mark.parametrize("name", ["tartan", "lace"])
def test_a_painted_thread_has_its_colour_and_all_else_stays(name):
    """Of stripes (tartan), and of yarns' own colours where threads are cut out (lace)."""
    fabric = load_fabric(name)
    draft, red = fabric.weave.drafted, np.array([0.5, 0.02, 0.03])
    loom = Loom.of(draft.drawdown).resized(2 * draft.picks, draft.ends)
    before = thread_colors(fabric)
    changes, loom = painted(fabric, loom, [Cell("warp", 0, 1), Cell("weft", 2, 0)], red)
    weave = fabric.weave.changed(**changes)
    after = thread_colors(fabric.changed(weave=weave))
    for number, (own, new, count) in enumerate(zip(before, after, loom.drawdown.shape[::-1], strict=True)):
        expected = np.resize(own, (count, 3))
        expected[(1, 2)[number]] = red
        assert count % len(new) == 0 and np.abs(np.resize(new, (count, 3)) - expected).max() < 0.005
    at = np.ix_(np.arange(loom.drawdown.shape[0]) % draft.picks, np.arange(loom.drawdown.shape[1]) % draft.ends)
    assert np.array_equal(loom.drawdown, draft.drawdown[at])
    assert (weave.drafted.cut is None) == (draft.cut is None)
    assert any(np.abs(color - red).max() < 0.005 for color in in_use(fabric.changed(weave=weave)))


def test_the_thread_counter_is_a_centimetre_of_the_cloth():
    mesh, camera, size = load_mesh("plane"), Camera((0.1, 0.02, 0.3), (0.0, 0.0, 0.0), fov_deg=20.0), (320, 240)
    glass = glass_at(mesh, camera, size, 200.0, 90.0, 1.0)
    assert np.allclose([abs(glass.warp @ (1, 0, 0)), abs(glass.weft @ (0, 1, 0))], 1.0, atol=1e-6)
    x, y = pixel_of(camera, size, glass.middle)
    assert (x, y) == (pytest.approx(200.0, abs=1e-3), pytest.approx(90.0, abs=1e-3)) and abs(glass.middle[2]) < 1e-9
    a, b = glass.lines()[0]
    assert np.linalg.norm(b - a) == pytest.approx(0.01) and len(glass.lines()) == 4 + 18
    assert glass_at(mesh, camera, size, 200.0, 90.0, 2.0).warp @ glass.warp == pytest.approx(0.5)
    parallel = Camera((0.1, 0.02, 0.3), (0.0, 0.0, 0.0), ortho=0.2)
    flat = glass_at(mesh, parallel, size, 200.0, 90.0, 1.0)
    assert (
        pixel_of(parallel, size, flat.middle) == pytest.approx((200.0, 90.0), abs=1e-3) and abs(flat.middle[2]) < 1e-9
    )
    assert view_of(Camera((0.0, 1e-17, 0.3), (5e-17, 0.0, 0.0))).target == (0.0, 0.0, 0.0)
    far = Camera((0.0, 0.0, 5.0), (3.0, 0.0, 0.0), fov_deg=20.0)
    assert glass_at(mesh, far, size, 160.0, 120.0, 1.0) is None


def test_threads_that_are_cut_out_leave_holes():
    rows = ["#.#.", ".oo#", "#.#.", ".#.#"]
    draft = draft_of({"drawdown": rows})
    assert draft.structure == (4, 4) and draft_of(plain_draft(draft)) == draft and draft.cut.sum() == 2
    assert draft.reduced() == draft and draft.flipped().cut[2].tolist() == [False, True, True, False]
    whole = Weave.model_validate({"draft": "plain", "ends_per_cm": 20, "picks_per_cm": 20, "width": 1.0})
    cut = whole.changed(draft=draft, ends_per_cm=20, picks_per_cm=20)
    # Full width covers the cloth but for the holes, which lie where the draft says: ends along v, picks along u.
    tile = cut.tile((256, 256))
    assert np.argwhere(tile.system[32::64, 32::64] < 0).tolist() == [[1, 1], [2, 1]]
    assert (tile.system < 0).mean() == pytest.approx(
        (whole.tile((256, 256)).system < 0).mean() * 0.875 + 0.125, abs=0.02
    )
    assert Loom.of(draft.drawdown).draft(draft) == draft
    with pytest.raises(InputError, match="cut"):
        Draft(draft.drawdown, cut=np.ones((4, 4), bool))


def test_lace_has_its_holes_and_damask_its_figure():
    lace = load_fabric("lace")
    maps = lace.weave.maps([np.array(y.tilts_deg) for y in lace.yarn], [np.full(2, y.area / 2) for y in lace.yarn])
    assert 0.3 < maps.hole.mean() < 0.5 and np.abs(maps.rel.mean((1, 2)) - 1.0).max() < 1e-9
    damask = named_draft("damask")
    assert damask.structure == (80, 80) and 0.3 < damask.drawdown.mean() < 0.6
    face = damask.drawdown.reshape(16, 5, 16, 5).mean((1, 3))
    assert face.max() == pytest.approx(0.8) and (np.isclose(face, 0.2) | np.isclose(face, 0.8)).mean() > 0.4, (
        "satins of five"
    )
    spacing = named_draft("mock_leno").warp_spacing
    between = 0.5 * (spacing + np.roll(spacing, -1)) / spacing.mean()
    assert between.tolist() == pytest.approx([0.78, 0.78, 1.44] * 2)


def test_a_sketch_is_an_equal_fabric_with_smaller_maps():
    fabric = load_fabric("houndstooth")
    sketch = fabric.sketch(64)
    assert sketch == fabric and sketch.tangents == fabric.tangents and sketch.weave.color_map is not None
    coarse, fine = fabric_maps(sketch), fabric_maps(fabric)
    assert coarse.rel.shape[1:] == (64, 64) and fine.rel.shape[1:] == (256, 256)
    assert np.abs(coarse.rel.mean((1, 2)) - 1.0).max() < 1e-5 and max(sketch.weave.color_map(coarse)[0].shape) <= 128


@pytest.mark.parametrize("due", [False, True])
def test_programs_are_compiled_ahead_for_a_woven_fabric(monkeypatch, due):
    """Idle windows do this; the weave's own tangents must not stand in the way of those that are asked for. Last comes a picture
    that is large enough to measure by, where that is due."""
    monkeypatch.setattr("glcloth.picture.warm_up.ways", lambda _: SimpleNamespace(due=lambda scene: due))
    drawn = []
    renderer = SimpleNamespace(
        draw_aside=lambda frame: drawn.append(len(frame.fabric.tangents)), ctx=SimpleNamespace(finish=int)
    )
    cloth = Cloth(load_mesh("plane"), load_fabric("linen_light"))
    frame = Frame(Scene(), (cloth,), None, None, Camera(), None)
    assert len(list(warm_up(renderer, frame))) == len(drawn)
    assert drawn == [n for n, _ in WARM_UP for _ in (0, 1)] + due * [len(cloth.fabric.tangents)]


def test_the_sheet_of_fabrics_stands_by_families_in_white_light():
    names = ["velvet", "mine", "charmeuse", "denim_raw", "poplin"]
    families = sheet.by_family(names)
    assert list(families) == ["Silks and satins", "Cottons", "Velvets", "Others"] and families["Others"] == ["mine"]
    assert families["Cottons"] == ["poplin", "denim_raw"]
    assert sheet.OTHERS not in sheet.by_family(builtin_fabrics())
    # A warm lamp on the left and a cool one on the right: a card that faces the warm one is balanced to it.
    lamps = np.zeros((8, 16, 3))
    lamps[4, 12], lamps[4, 4] = (3.0, 2.0, 1.0), (1.0, 2.0, 3.0)
    white = sheet.white_balance(Environment("lamps", lamps), equirect.texel_directions(8, 16)[4, 12])
    card = white * lamps[4, 12]
    assert np.ptp(card) < 1e-9 and card[0] == pytest.approx(luminance(lamps[4, 12]))
    dark, bright = (sheet.evened(np.array(x), x, 0.5) for x in (0.01, 0.7))
    assert 0.01 < dark < sheet.MIDDLE < bright < 0.7
    label = sheet._label("denim_raw", load_fabric("denim_raw"))
    assert label.shape == (sheet.LABEL, sheet.FAR[0] + sheet.NEAR[0], 3) and label.max() > 0.5 > label[-1].max()


@pytest.mark.parametrize("normalization", ["sadeghi", "paper"])
def test_a_yarn_reflects_even_light_as_its_area_says(normalization):
    """The normaliser, which knows no area after the paper, is that of both yarns."""
    fabric = load_fabric("denim_raw").changed(normalization=normalization)
    warp, weft = (even_shares(fabric, 4, 4)[f"even_{yarn}"].sum() for yarn in ("warp", "weft"))
    sums = [yarn.area * (len(yarn.tilts_deg) if normalization == "paper" else 1) for yarn in fabric.yarn]
    assert warp + weft == pytest.approx(1.0) and warp / weft == pytest.approx(sums[0] / sums[1], rel=1e-5)
