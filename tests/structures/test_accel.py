"""Acceleration structures: every one finds what brute force finds, on good scenes and on bad ones; the tree is sound."""

from itertools import pairwise

import curtain_scenes as scenes
import numpy as np
import pytest

from glcloth.accel import needles
from glcloth.accel.brute import Brute
from glcloth.accel.kdtree import CONSTANTS, KdTree
from glcloth.accel.queries import RayQueries
from glcloth.accel.structure import STRUCTURES, make_structure
from glcloth.accel.triangles import Triangles, find_pairs
from glcloth.errors import InputError
from glcloth.geometry import shapes
from glcloth.gpu.programs import programs
from glcloth.twins import intersect
from glcloth.twins import kdtree as exact

TREES = [name for name in STRUCTURES if name != "brute"]


@pytest.fixture(scope="module")
def keep():
    """Things to release after the module."""
    things = []
    yield things
    for thing in things:
        thing.release()


@pytest.fixture(scope="module")
def queries(session_ctx, keep):
    with session_ctx:
        keep.append(RayQueries(session_ctx))
        return keep[-1]


def same_hits(a, b):
    """Equal t to the bit, and equal triangles but where two are hit at the same t."""
    np.testing.assert_array_equal(a.t, b.t)
    hit = np.isfinite(b.t)
    assert (a.triangle[hit] == b.triangle[hit]).mean() > 0.999 if hit.any() else True


def all_rays(triangles, count):
    """Coherent rays of the camera, and random ones from inside and outside the scene."""
    low, high = triangles.min((0, 1)), triangles.max((0, 1))
    middle, half = (low + high) / 2, (high - low) / 2 + 1e-3
    o_1, d_1 = scenes.camera_rays(count // 2)
    o_2, d_2 = scenes.random_rays(count // 4, middle - half, middle + half)
    o_3, d_3 = scenes.random_rays(count // 4, middle - 2 * half, middle + 2 * half, seed=2)
    # Toward the scene, and a few along the axes, where splits and boxes are.
    target = np.random.default_rng(3).uniform(low, high, o_3.shape)
    d_3 = target - o_3
    d_3[:32] = np.eye(3)[np.arange(32) % 3] * np.where(np.arange(32) % 2, 1, -1)[:, None]
    return np.concatenate([o_1, o_2, o_3]), np.concatenate([d_1, d_2, d_3.astype(np.float32)])


@pytest.mark.parametrize("name", TREES)
@pytest.mark.parametrize("time", [0.0, 2.3])
def test_a_structure_finds_what_brute_force_finds(ctx, queries, keep, name, time):
    soup = scenes.scene(3000, time)
    triangles, structure, judge = Triangles.of(ctx, soup), make_structure(ctx, name), Brute(ctx)
    keep += [triangles, structure]
    structure.build(triangles)
    judge.build(triangles)
    o, d = all_rays(soup, 100_000)
    hits = queries.closest_hit(structure, o, d)
    same_hits(hits, queries.closest_hit(judge, o, d))
    limit = np.where(np.isfinite(hits.t), hits.t * 1.01, 10.0).astype(np.float32)
    assert queries.any_hit(structure, o, d, t_max=limit)[np.isfinite(hits.t)].all()
    before = np.where(np.isfinite(hits.t), hits.t * 0.999, 1e9).astype(np.float32)
    assert not queries.any_hit(structure, o, d, t_max=before).any()


@pytest.mark.parametrize("name", TREES)
@pytest.mark.parametrize("kind", scenes.degenerate_scenes())
def test_degenerate_scenes(ctx, queries, name, kind):
    soup = scenes.degenerate_scenes()[kind].astype(np.float32)
    triangles, structure, judge = Triangles.of(ctx, soup), make_structure(ctx, name), Brute(ctx)
    structure.build(triangles)
    judge.build(triangles)
    tree = structure.arrays()
    assert set(tree["triangles"]) == set(range(len(soup))), "every triangle lies in a leaf"
    assert tree["depth"].max() <= CONSTANTS["STACK"]
    o, d = all_rays(soup, 3000)
    same_hits(queries.closest_hit(structure, o, d), queries.closest_hit(judge, o, d))
    structure.release()
    triangles.release()


@pytest.mark.parametrize("name", STRUCTURES)
def test_triangles_without_area_are_met_by_no_ray(ctx, queries, name):
    """Lines and points in every position; the rays go straight through them."""
    rng = np.random.default_rng(8)
    a, b = rng.uniform(-1, 1, (2, 400, 3))
    share = rng.uniform(-0.5, 1.5, (400, 1))
    lines = np.stack([a, b, a + share * (b - a)], 1).astype(np.float32)
    lines[::7, 2] = lines[::7, 1]
    lines[::11] = lines[::11, :1]
    triangles, structure = Triangles.of(ctx, lines), make_structure(ctx, name)
    structure.build(triangles)
    target = (lines[:, 0] + rng.random((50, 400, 1)) * (lines[:, 1] - lines[:, 0])).reshape(-1, 3)
    origin = target + rng.normal(size=target.shape)
    hits = queries.closest_hit(structure, origin.astype(np.float32), (target - origin).astype(np.float32))
    assert np.isinf(hits.t).all()
    structure.release()
    triangles.release()


@pytest.mark.parametrize("name", TREES)
def test_no_triangles_at_all(ctx, queries, name):
    triangles, structure = Triangles.of(ctx, np.zeros((0, 3, 3))), make_structure(ctx, name)
    structure.build(triangles)
    assert not np.isfinite(queries.closest_hit(structure, *scenes.camera_rays(100)).t).any()


@pytest.mark.parametrize("name", TREES)
def test_rebuilding_gives_the_same_tree(ctx, keep, name):
    triangles, structure = Triangles.of(ctx, scenes.scene(3000, 1.0)), make_structure(ctx, name)
    keep += [triangles, structure]
    structure.build(triangles)
    first = structure.arrays()
    for _ in range(4):
        structure.build(triangles)
        for key, array in structure.arrays().items():
            np.testing.assert_array_equal(array, first[key], err_msg=key)


@pytest.mark.parametrize("name", [name for name in STRUCTURES if name != "kdtree_median"])
@pytest.mark.parametrize("most", [1, 5])
def test_more_work_groups_than_the_device_takes_are_laid_in_rows(ctx, queries, keep, monkeypatch, name, most):
    """As on a device of so few: the same tree and the same hits."""
    soup = scenes.scene(1500, 1.0)
    rays = all_rays(soup, 3000)
    triangles, structures = Triangles.of(ctx, soup), [make_structure(ctx, name) for _ in range(2)]
    keep += [triangles, *structures]
    structures[0].build(triangles)
    hits = queries.closest_hit(structures[0], *rays)
    monkeypatch.setattr(programs(ctx), "most_groups", most)
    structures[1].build(triangles)
    same_hits(queries.closest_hit(structures[1], *rays), hits)
    for key, array in structures[0].arrays().items():
        np.testing.assert_array_equal(array, structures[1].arrays()[key], err_msg=key)


def test_brute_force_against_float64(ctx, queries):
    """The judge itself: Möller and Trumbore in float64."""
    soup = scenes.scene(400, 0.5)
    triangles, judge = Triangles.of(ctx, soup), Brute(ctx)
    judge.build(triangles)
    o, d = all_rays(soup, 800)
    hits = queries.closest_hit(judge, o, d)
    axis = intersect.longest_axis(d)
    shear = intersect.shear_of(intersect.axis_last(d, axis))
    corners = intersect.axis_last(
        soup[None].astype(float) - o[:, None, None].astype(float),
        axis[:, None, None] + np.zeros((1, len(soup), 3), int),
    )
    t = intersect.hit_triangle(corners[:, :, 0], corners[:, :, 1], corners[:, :, 2], shear[:, None])[..., 0]
    t = np.where(t > 0, t, np.inf)
    agree = np.isclose(t.min(1), hits.t, rtol=1e-4, atol=1e-5) | (np.isinf(t.min(1)) & np.isinf(hits.t))
    # A ray within rounding of a silhouette may go either way.
    assert agree.mean() > 0.997
    mine = np.take_along_axis(t, np.maximum(hits.triangle, 0)[:, None], 1)[:, 0]
    hit = np.isfinite(hits.t) & agree
    np.testing.assert_allclose(mine[hit], hits.t[hit], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("name", TREES)
def test_no_ray_slips_through_shared_edges(ctx, queries, name):
    """A wavy closed sheet, seen from one side through its own vertices and along its edges: every ray must hit."""
    x, y = np.meshgrid(np.linspace(-1, 1, 40), np.linspace(-1, 1, 40))
    grid = np.stack([x, y, 0.1 * np.sin(5 * x) * np.cos(4 * y)], -1)
    triangles, structure = Triangles.of(ctx, scenes.grid_triangles(grid)), make_structure(ctx, name)
    structure.build(triangles)
    inner = grid[2:-2, 2:-2].reshape(-1, 3)
    mixes = np.random.default_rng(1).uniform(0, 1, (20, 1, 1))
    right, down = grid[2:-2, 3:-1].reshape(-1, 3), grid[3:-1, 2:-2].reshape(-1, 3)
    targets = np.concatenate(
        [inner[None], inner * mixes + right * (1 - mixes), right * mixes + down * (1 - mixes)]
    ).reshape(-1, 3)
    for eye in ((0.0, 0.0, 2.0), (0.37, -0.2, 1.3), (0.0, 0.5, 40.0)):
        o = np.broadcast_to(np.array(eye, np.float32), targets.shape)
        hits = queries.closest_hit(structure, o, (targets - eye).astype(np.float32))
        assert np.isfinite(hits.t).all()


def without_pairs(soup):
    """The same triangles in an order in which no two neighbours share an edge."""
    halves = np.concatenate([soup[0::2], soup[1::2]])
    assert not find_pairs(halves, np.zeros(len(halves)))[1].any()
    return halves


@pytest.mark.parametrize("pairs", [True, False])
def test_every_triangle_is_reached_and_inside_its_leaf(ctx, keep, pairs):
    soup = scenes.scene(3000, 1.0)
    soup = soup if pairs else without_pairs(soup)
    triangles, tree = Triangles.of(ctx, soup), KdTree(ctx)
    keep += [triangles, tree]
    tree.build(triangles)
    t = tree.arrays()
    assert len(t["axis"]) == tree.node_count
    # Every quad of this scene is a pair.
    assert len(t["triangles"]) == tree.leaf_ref_count * (2 if pairs else 1)
    assert set(t["triangles"]) == set(range(len(soup)))
    leaf = np.flatnonzero(t["axis"] == 3)
    assert t["count"][leaf].sum() == len(t["triangles"])
    # Leaves fill the root's box without a gap or an overlap.
    volume = np.prod((t["high"] - t["low"]).astype(float), axis=1)
    assert volume[leaf].sum() == pytest.approx(volume[0], rel=1e-5)
    # Points of triangles lie in leaves that hold the triangle.
    owner = np.repeat(leaf, t["count"][leaf])
    rng = np.random.default_rng(0)
    b = rng.dirichlet([1, 1, 1], len(soup))
    points = np.einsum("tc,tcx->tx", b, soup.astype(float))
    for i in rng.permutation(len(soup))[:300]:
        holds = leaf[((points[i] >= t["low"][leaf]) & (points[i] <= t["high"][leaf])).all(1)]
        assert len(holds) and (set(holds) <= set(owner[t["triangles"] == i]))


@pytest.mark.parametrize(("pairs", "small_size"), [(True, 64), (False, 64), (False, 32)])
def test_the_tree_costs_little_more_than_an_exact_one(ctx, keep, monkeypatch, pairs, small_size):
    monkeypatch.setattr("glcloth.accel.kdtree.SMALL_SIZE", small_size)
    soup = scenes.scene(1000, 1.0)
    soup = soup if pairs else without_pairs(soup)
    triangles, tree = Triangles.of(ctx, soup), KdTree(ctx)
    keep += [triangles, tree]
    tree.build(triangles)
    nodes = tree.arrays()
    C_ts = CONSTANTS["C_TS"]
    cost = exact.sah_cost(nodes | {"count": nodes["pairs"]}, C_ts)
    best = exact.sah_cost(exact.build(soup.reshape(-1, 2, 3, 3) if pairs else soup, C_ts), C_ts)
    # Boxes are not clipped in small nodes; on the other hand the greedy choice of the exact tree is not the best one.
    assert 0.9 * best < cost < 1.08 * best


def test_no_lane_counts_more_than_it_can(ctx, keep, monkeypatch):
    """Many references take more lanes; the tree is as good, and holds the same."""
    soup = scenes.scene(3000, 0.3)
    triangles, few, many = Triangles.of(ctx, soup), KdTree(ctx), KdTree(ctx)
    keep += [triangles, few, many]
    few.build(triangles)
    monkeypatch.setattr("glcloth.accel.kdtree.LANE_REFS", 16)
    many.build(triangles)
    trees = [tree.arrays() for tree in (few, many)]
    costs = [exact.sah_cost(tree | {"count": tree["pairs"]}, 2.0) for tree in trees]
    assert costs[1] == pytest.approx(costs[0], rel=1e-3)
    assert set(trees[1]["triangles"]) == set(range(len(soup)))
    assert many.large_levels == few.large_levels


def test_buffers_that_are_too_small_grow(ctx, keep, monkeypatch):
    soup = scenes.scene(3000, 0.3)
    triangles, tree, small = Triangles.of(ctx, soup), KdTree(ctx), KdTree(ctx)
    keep += [triangles, tree, small]
    tree.build(triangles)
    monkeypatch.setattr(KdTree, "at_first", {"node": 0.15, "ref": 0.125, "leaf": 0.1})
    small.build(triangles)
    assert small.growths > 0 and tree.growths == 0
    for key, array in tree.arrays().items():
        np.testing.assert_array_equal(array, small.arrays()[key])
    small.build(triangles)
    grown = small.growths
    small.build(triangles)
    assert small.growths == grown


def test_lanes_grow_no_faster_than_the_scene(ctx, keep, monkeypatch):
    """Four times the triangles take four times the lanes' memory, also where a lane cannot count a node's references."""
    monkeypatch.setattr("glcloth.accel.kdtree.LANE_REFS", 16)
    lanes = []
    for count in (2000, 8000):
        triangles, tree = Triangles.of(ctx, scenes.scene(count, 0.3)), KdTree(ctx)
        keep += [triangles, tree]
        tree.build(triangles)
        lanes.append(tree._capacity["lane"])
    assert lanes[1] < 5 * lanes[0]


def test_lanes_that_are_too_few_grow(ctx, keep, monkeypatch):
    """As above, where many lanes share a node."""
    monkeypatch.setattr("glcloth.accel.kdtree.LANE_REFS", 1)
    triangles, tree, small = Triangles.of(ctx, scenes.scene(3000, 0.3)), KdTree(ctx), KdTree(ctx)
    keep += [triangles, tree, small]
    monkeypatch.setattr("glcloth.accel.kdtree.LARGE_REFS", 4)
    tree.build(triangles)
    monkeypatch.setattr("glcloth.accel.kdtree.LARGE_REFS", 1 << 30)
    small.build(triangles)
    assert small.growths > 0 and tree.growths == 0
    for key, array in tree.arrays().items():
        np.testing.assert_array_equal(array, small.arrays()[key])


def test_a_tree_that_grows_deeper_is_built_with_more_levels(ctx, keep):
    """A build dispatches the levels of the last one, and one more; a jump of the scene is noticed."""
    even = without_pairs(scenes.scene(1500, 0.3))
    deep = even.copy()
    deep[:, :, :] *= np.geomspace(1.0, 1e-3, len(deep), dtype="f4")[:, None, None]
    first, then = Triangles.of(ctx, even), Triangles.of(ctx, deep)
    tree, fresh = KdTree(ctx), KdTree(ctx)
    keep += [first, then, tree, fresh]
    tree.build(first)
    levels = tree.large_levels, tree.small_levels
    tree.build(then)
    assert tree.growths == 1 and (tree.large_levels > levels[0] + 1 or tree.small_levels > levels[1] + 1)
    fresh.build(then)
    assert fresh.growths == 0
    for key, array in fresh.arrays().items():
        np.testing.assert_array_equal(array, tree.arrays()[key])


def test_pairs_are_found_and_meet_the_same(ctx, queries, keep):
    """Strips, fans and loose triangles, their corners turned: pairs share an edge, no triangle is in two, hits are alike."""
    rng = np.random.default_rng(4)
    grid = scenes.grid_triangles(scenes.curtain_grid(9, 7))
    loose = rng.normal(size=(25, 3, 3))
    soup = np.concatenate([scenes.room(), loose[:11], grid, loose[11:], grid[:5] + 1.0])
    turned = soup[np.arange(len(soup))[:, None], (np.arange(3) + rng.integers(0, 3, (len(soup), 1))) % 3]
    material = np.where(np.arange(len(soup)) < 146, 1, 0)
    turn, joined = find_pairs(turned, material)
    assert not (joined[1:] & joined[:-1]).any() and joined.sum() >= 73 + 48 + 2
    straight = turned[np.arange(len(soup))[:, None], (turn[:, None] + np.arange(3)) % 3]
    one, two = straight[:-1][joined[:-1]], straight[1:][joined[:-1]]
    np.testing.assert_array_equal(one[:, [2, 1]], two[:, :2])
    triangles, judge = Triangles.of(ctx, turned), Brute(ctx)
    judge.build(triangles)
    tree = KdTree(ctx)
    keep += [tree]
    tree.build(triangles)
    rays = all_rays(soup, 4000)
    same_hits(queries.closest_hit(tree, *rays), queries.closest_hit(judge, *rays))


def test_large_leaves_are_few(ctx, keep):
    """100 coincident triangles make one leaf of 100, not a tree without end."""
    triangles, tree = Triangles.of(ctx, scenes.degenerate_scenes()["100 coincident"]), KdTree(ctx)
    keep += [triangles, tree]
    tree.build(triangles)
    assert tree.node_count < 50 and tree.arrays()["count"].max() == 100


def test_too_many_copies_are_refused(ctx, keep):
    triangles, tree = Triangles.of(ctx, np.repeat(np.eye(3)[None], 60_001, 0)), KdTree(ctx)
    keep += [triangles, tree]
    with pytest.raises(InputError, match="copies"):
        tree.build(triangles)


def test_the_reference_tree_by_hand():
    """Two far triangles: one cut at each side of the gap, or between them, and the cost by equation 6."""
    near = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 1.0]])
    soup = np.stack([near, near + np.array([9, 0, 0])])
    cost, axis, plane = exact.best_split(
        np.stack([soup.min(1), soup.max(1)], 1), np.zeros(3), np.array([10, 1, 1.0]), 0.5
    )
    area = 10 + 10 + 1
    assert axis == 0 and plane in (1.0, 9.0)
    assert cost == pytest.approx(0.5 + ((1 + 1 + 1) * 1 + (9 + 9 + 1) * 1) / area)
    inside = exact.clip_polygons(near[None], np.zeros(3), np.array([0.5, 2, 2]))[0]
    inside = inside[~np.isnan(inside[:, 0])]
    assert inside[:, 0].max() == 0.5 and len(inside) == 4


def test_the_tree_grows_no_faster_than_the_scene(ctx, keep):
    """Four times the triangles make about four times the nodes and references, and no level more than the cap allows."""
    sizes = []
    for count in (3_000, 12_000, 48_000):
        triangles, tree = Triangles.of(ctx, scenes.scene(count, 1.0)), KdTree(ctx)
        keep += [triangles, tree]
        tree.build(triangles)
        sizes.append((tree.node_count, tree.leaf_ref_count, tree.large_levels + tree.small_levels))
        assert tree.growths == 0
    for small, large in pairwise(sizes):
        assert large[0] < 4.4 * small[0] and large[1] < 4.4 * small[1] and large[2] <= small[2] + 8


def test_triangles_that_move_keep_their_pairs_while_these_share_edges(ctx):
    rng = np.random.default_rng(3)
    x, corners, *_ = shapes.plane(divisions=6)
    moved = x + rng.normal(scale=0.02, size=x.shape)
    torn = moved[corners] + 0.1 * np.arange(len(corners))[:, None, None]
    triangles = Triangles.of(ctx, x[corners])
    pairs = triangles.pairs()
    assert pairs[0] < len(corners)
    for soup in (moved[corners], torn):
        triangles.move(soup)
        fresh = Triangles.of(ctx, soup)
        assert np.array_equal(triangles.positions(), fresh.positions()) and triangles.padding == fresh.padding
        assert triangles.corners.read() == fresh.corners.read()
        assert triangles.attributes.read() == fresh.attributes.read()
        assert triangles.pairs()[0] == fresh.pairs()[0] and np.array_equal(triangles.turn, fresh.turn)
    assert triangles.pairs()[0] == len(corners)


def test_the_spatial_median_cuts_the_longest_side_in_the_middle(ctx):
    """Large nodes, but for those that empty space is cut from; the plane of least cost lies elsewhere."""
    soup = np.random.default_rng(4).random((3000, 1, 3)) ** 2 * (3, 2, 1)
    triangles = Triangles.of(ctx, (soup + 0.01 * np.eye(3)).astype("f4"))
    for name, middle in (("kdtree_median", True), ("kdtree", False)):
        tree = make_structure(ctx, name)
        tree.build(triangles)
        found = tree.arrays()
        assert found["axis"][0] == 0
        assert (abs(found["split"][0] - (tree.low[0] + tree.high[0]) / 2) < 1e-3) == middle
        tree.release()
    triangles.release()


def test_needles_across_the_axes_are_entered_by_pieces(ctx, queries, monkeypatch):
    """A cone of 4,000 needles at one apex: the hits are those of whole triangles, in a tenth of the tests."""
    angle = 2.0 * np.pi * np.arange(4000) / 4000
    rim = np.stack([np.cos(angle), 0.1 * np.sin(5 * angle), np.sin(angle)], -1)
    apex = np.broadcast_to([0.0, 3.0, 0.0], rim.shape)
    fan = np.stack([apex, np.roll(rim, -1, 0), rim], 1).astype(np.float32)
    rng = np.random.default_rng(5)
    origins, directions = rng.uniform(-1.5, 1.5, (2000, 3)), rng.normal(size=(2000, 3))
    found = {}
    for most in (needles.MOST_BOXES, 1e9):
        monkeypatch.setattr(needles, "MOST_BOXES", most)
        triangles, tree = Triangles.of(ctx, fan), make_structure(ctx, "lbvh")
        tree.build(triangles)
        assert (triangles.pieces is None) == (most == 1e9)
        hits = queries.closest_hit(tree, origins, directions, counted=True)
        found[most] = hits, queries.any_hit(tree, origins, directions)
        tree.release(), triangles.release()
    (cut, any_cut), (whole, any_whole) = found.values()
    assert np.array_equal(cut.t, whole.t) and np.array_equal(any_cut, any_whole) and any_cut.sum() > 200
    assert np.array_equal(cut.triangle, whole.triangle)
    assert 10 * cut.work[:, 1].sum() < whole.work[:, 1].sum()
    sheet = scenes.scene(4000, 1.0)
    assert needles.pieces_of(sheet) is None, "cloth of ordinary triangles stays whole"
