"""Photon mapping: the tree against brute force, where photons begin and arrive, their power, estimates against closed forms,
pictures of the curtain's room."""

import dataclasses

import numpy as np
import pytest
from scipy.stats import chi2

from glcloth.accel.points import PointTree
from glcloth.accel.queries import RayQueries
from glcloth.accel.structure import make_structure
from glcloth.accel.triangles import Triangles, pack_units
from glcloth.curtain import rims
from glcloth.curtain.charts import OPEN
from glcloth.curtain.photons import PhotonMap, Photons
from glcloth.curtain.room import Room, box, inside_out
from glcloth.curtain.show import CurtainShow, camera_of
from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.gpu.buffers import TextureBuffer
from glcloth.light.environment import Environment
from glcloth.scene import CurtainParameters, Scene
from glcloth.tracing.lamp import Lamp, Lighting
from glcloth.tracing.shot import Shot
from glcloth.tracing.tracer import Tracer
from glcloth.twins.photons import cut_share, disc_distance, disc_kernel
from glcloth.window.curtain import Player

BLACK = (0.0, 0.0, 0.0)
SMALL = Scene(
    size=(32, 32),
    curtain=CurtainParameters(quads=(48, 12), pleats=4, settle=0.2),
    gi="photons",
    photons=8000,
    photon_neighbours=60,
)


def triangles_of(quads):
    """[T, 3, 3] of quads [Q, 4, 3]."""
    corners = np.array(quads, float)
    return np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]], 1).reshape(-1, 3, 3).astype(np.float32)


def cube(without=""):
    """A unit cube seen from within."""
    return triangles_of([corners for _, corners in inside_out(box("grey", (0, 0, 0), (1, 1, 1), without))])


@pytest.fixture(autouse=True)
def at_few_places(monkeypatch):
    """Irradiance is estimated at fewer photons, for tests' sake."""
    monkeypatch.setattr("glcloth.curtain.photons.GATHERED", 2048)


@pytest.fixture
def lit(ctx):
    """Traces the photons of a room without cloth; releases everything in the end."""
    made = []

    def of(
        positions,
        reflectance,
        lamp=(0.5, 0.5, 0.5),
        intensity=(1.0, 1.0, 1.0),
        sky=BLACK,
        count=20_000,
        k=100,
        keep=False,
    ):
        room = Room(positions, np.zeros(len(positions), np.int32), np.full((1, 3), reflectance, np.float32), ("grey",))
        triangles, tracer, photons = Triangles(ctx, len(positions), 4.0), Tracer(ctx), PhotonMap(ctx, room)
        made.extend([triangles, tracer, photons])
        triangles.set(0, positions, material=1)
        tracer.set_scene(triangles, np.concatenate([np.zeros((1, 3)), room.reflectances]))
        tracer.build()
        lighting = Lighting(Lamp(lamp, intensity), BLACK, sky)
        shot = Shot(Camera((0, 0, 3), (0, 0, 0)), (4, 4), load_fabric("sheer_voile"), lighting, indirect={})
        arguments = shot, tracer.inputs(shot), tracer.structure("kdtree"), Photons(count, k)
        for _ in photons.steps(*arguments, keep_lamp=keep):
            pass
        return photons

    yield of
    for thing in made:
        thing.release()


def points(x, n, carried=0.0, place=0):
    """Points [N, 3] with normals as the tree takes them."""
    out = np.zeros((len(x), 2, 4), np.uint32)
    out[:, 0, :3] = np.ascontiguousarray(x, np.float32).view(np.uint32)
    out[:, 0, 3] = pack_units(np.broadcast_to(n, np.shape(x)))
    out[:, 1, :3] = np.ascontiguousarray(np.broadcast_to(carried, np.shape(x)), np.float32).view(np.uint32)
    out[:, 1, 3] = place
    return out


def estimates(ctx, photons, x, n, place, k):
    """Irradiance and radii at points of one surface."""
    queries = TextureBuffer(ctx, points(x, n, place=place), "rgba32ui")
    assert photons.gather(queries, len(x), k) == len(x)
    queries.release()
    _, E, r = photons.gathered(len(x))
    return E, r


def test_nearest_are_those_of_brute_force(ctx, lit):
    """In a corner of a box whose walls are lit from one: as many photons as wanted lie in each disc, few more, and they are
    summed as the twin does; the tree holds each once."""
    photons = lit(cube(), 0.5)
    x, W, place = photons.photons()
    data = photons.tree.sorted_points
    rows = np.frombuffer(data.read(32 * photons.arrived), np.uint32).reshape(-1, 8)
    raw = np.concatenate([x.view(np.uint32), W.view(np.uint32), place[:, None].astype(np.uint32)], 1)
    np.testing.assert_array_equal(np.unique(rows[:, [0, 1, 2, 4, 5, 6, 7]], axis=0), np.unique(raw, axis=0))
    arrays = photons.tree.arrays()
    assert sorted(arrays["triangles"]) == list(range(photons.arrived)) and arrays["count"].max() <= 64
    rng = np.random.default_rng(2)
    q = np.c_[rng.random((60, 1)), np.zeros(60), rng.random((60, 1))]
    q[:20, 0] *= 0.05
    on_floor = np.abs(x[:, 1]) < 1e-6
    floor = 2 * int(np.flatnonzero(np.abs(photons.room.positions[:, :, 1]).max(1) < 1e-6)[0])
    corners = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]], float)
    n = np.array([0.0, 1.0, 0.0])
    widest = 0.125 * 3**0.5 - 1e-6
    for k in (8, 60, 300):
        E, r = estimates(ctx, photons, q, n, floor, k)
        d2 = disc_distance(x[on_floor][None].astype(float) - q.astype(np.float32)[:, None], n)
        assert ((d2 < (r[:, None] * (1 + 1e-6)) ** 2).sum(1) >= k)[r < widest].all()
        assert ((d2 < (r[:, None] * 0.965) ** 2).sum(1) < k).all()
        left = 1 - sum(cut_share(q, a, b, n, r) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True))
        ours = (disc_kernel(d2, r[:, None] ** 2)[..., None] * W[on_floor]).sum(1)
        np.testing.assert_allclose(E, ours / (0.5 * np.pi * r**2 * left)[:, None], rtol=2e-4)


def test_few_points(ctx, lit):
    """Trees of none, of one, and of a thousand in one place; no light at all is dark."""
    dark = lit(cube(), 0.5, intensity=BLACK, count=1000)
    assert dark.arrived == 0
    E, _ = estimates(ctx, dark, np.full((3, 3), 0.5), [0.0, 1.0, 0.0], 0, 50)
    np.testing.assert_array_equal(E, 0)
    for x in (np.zeros((0, 3)), np.ones((1, 3)), np.tile([[0.5, 0.25, 2.0]], (1000, 1))):
        tree, buffer = PointTree(ctx), TextureBuffer(ctx, points(x, [0, 1.0, 0]) if len(x) else 64, "rgba32ui")
        for _ in tree.sort(buffer, len(x), 2.0):
            pass
        np.testing.assert_array_equal(tree.positions(), x)
        buffer.release()
        tree.release()


def test_photons_begin_where_light_does(ctx, lit):
    """Chi-square of arrivals in black boxes: of a lamp within, by solid angle; of the sky through an open side, by form factors;
    of a lamp before it, by the inverse square. As much power comes in as does."""
    cells = 6
    side = (np.arange(cells * 8) + 0.5) / (cells * 8)
    s, t = np.meshgrid(side, side, indexing="ij")

    def seen(photons, expected):
        """expected: irradiance at points of the wall x = 1, by (y, z)."""
        x, W, _ = photons.photons()
        wall = np.abs(x[:, 0] - 1) < 1e-5
        share = expected.reshape(cells, 8, cells, 8).mean((1, 3)).ravel()
        E = np.histogram2d(x[wall, 1], x[wall, 2], cells, ((0, 1), (0, 1)), weights=W[wall, 1])[0].ravel()
        count = np.histogram2d(x[wall, 1], x[wall, 2], cells, ((0, 1), (0, 1)))[0].ravel()
        assert E.sum() == pytest.approx(share.mean(), rel=0.02)
        # Evenly spread points vary less than chance would have it.
        assert (((count - (e := count.sum() * share / share.sum())) ** 2 / e).sum()) < chi2.ppf(0.99, cells**2 - 1)

    def of_lamp(p):
        r2 = (1 - p[0]) ** 2 + (s - p[1]) ** 2 + (t - p[2]) ** 2
        return (1 - p[0]) / r2**1.5

    photons = lit(cube(), 0.0, lamp=(0.4, 0.3, 0.5), keep=True)
    seen(photons, of_lamp((0.4, 0.3, 0.5)))
    assert photons.photons()[1].sum(0, dtype=float) == pytest.approx([4 * np.pi] * 3, rel=1e-5)
    for lamp in ((-2.0, 0.6, 0.5), (-60.0, 0.6, 0.5)):  # this one is further off than any way in the scene is long
        seen(lit(cube("-x"), 0.0, lamp=lamp, keep=True), of_lamp(lamp) * through(s, t, lamp))
    # Form factors of the opposite unit square.
    y, z = side[:, None, None, None], side[None, :, None, None]
    u = (np.arange(24) + 0.5) / 24
    parallel = (1 / (np.pi * (1 + (y - u[:, None]) ** 2 + (z - u) ** 2) ** 2)).mean((2, 3))
    sky = lit(cube("-x"), 0.0, intensity=BLACK, sky=(0.5, 1.0, 2.0))
    seen(sky, np.pi * parallel)
    assert sky.photons()[1].sum(0) == pytest.approx(np.pi * np.array([0.5, 1.0, 2.0]), rel=0.01)


def through(s, t, p):
    """Whether ways from p to (1, s, t) go through the unit square at x = 0."""
    f = -p[0] / (1 - p[0])
    y, z = p[1] + f * (s - p[1]), p[2] + f * (t - p[2])
    return (y > 0) & (y < 1) & (z > 0) & (z < 1)


def test_power_is_kept(lit):
    """In a closed box of one reflectance the lamp's power arrives once, and rho times of it again, and so on."""
    rho = np.array([0.1, 0.05, 0.02])
    power = lit(cube(), rho, count=130_000, keep=True, k=8).photons()[1].sum(0, dtype=float)
    np.testing.assert_allclose(power, 4 * np.pi / (1 - rho), rtol=1e-3)
    # Beyond the tenth arrival fewer photons carry more each.
    rho = np.array([0.9, 0.6, 0.3])
    power = lit(cube(), rho, count=20_000).photons()[1].sum(0, dtype=float)
    np.testing.assert_allclose(power, 4 * np.pi * rho / (1 - rho), rtol=0.015)


def test_estimates_are_the_light(ctx, lit):
    """A plane under a lamp: I cos / r^2. Under an even sky: no rim and no corner is darker or brighter."""
    plane = triangles_of([[[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]])
    up, x = (
        [0.0, 1.0, 0.0],
        np.array([[0, 0, 0], [0.5, 0, 0.3], [-0.7, 0, 0.7], [0.98, 0, 0], [0.2, 0, -0.99], [0.97, 0, 0.97]]),
    )
    sky = lit(plane, 0.0, intensity=BLACK, sky=(1.0, 1.0, 1.0), count=60_000)
    E, _ = estimates(ctx, sky, x, up, 0, 1500)
    np.testing.assert_allclose(E, np.pi, rtol=0.05)
    photons = lit(plane, 0.0, lamp=(0.0, 1.0, 0.0), count=60_000, keep=True)
    E, _ = estimates(ctx, photons, x[:3], up, 0, 500)
    np.testing.assert_allclose(E[:, 0], 1 / (1 + (x[:3] ** 2).sum(1)) ** 1.5, rtol=0.07)
    # Scattered light: a photon that counted itself would add an eighth with sixteen neighbours.
    box = lit(cube(), 0.8, count=20_000)
    means = []
    for k in (16, 300):
        count = box.gather(box.tree.sorted_points, box.arrived, k, 1.0)
        means.append(box.gathered(count)[1].mean())
    assert count == pytest.approx(2048, rel=0.1)
    assert means[0] == pytest.approx(means[1], rel=0.03)


def test_fewer_neighbours_from_sample_to_sample():
    """As Knaus and Zwicker have it: radii shrink, and noise over all samples does too."""
    photons = Photons(1000, 400)
    shares = np.array([photons.shrunk(k) for k in range(300)])
    assert shares[0] == 1 and (np.diff(shares) < 0).all()
    assert shares[1] == pytest.approx((1 + 2 / 3) / 2)
    assert shares[299] == pytest.approx(shares[99] * 3 ** (-1 / 3), rel=0.01)
    assert [photons.neighbours_of(k) for k in (0, 1, 10**6)] == [400, round(400 * 5 / 6), 8]


def test_rims_of_a_large_room_take_a_bounded_number_of_questions(ctx, monkeypatch):
    """A room of a kilometre, in wrong units perhaps: its rims are found, by longer steps."""
    floor = 1000.0 * np.float32([[[0, 0, 0], [1, 0, 1], [1, 0, 0]], [[0, 0, 0], [0, 0, 1], [1, 0, 1]]])
    triangles, asked = Triangles.of(ctx, floor), []
    structure = make_structure(ctx, "kdtree")
    structure.build(triangles)
    cast = RayQueries.closest_hit
    monkeypatch.setattr(RayQueries, "closest_hit", lambda self, s, o, *a: asked.append(len(o)) or cast(self, s, o, *a))
    monkeypatch.setattr(rims, "MOST_QUESTIONS", 500)
    found = rims.find_rims(ctx, floor, structure, 1.0)
    assert sum(asked) <= 500 + 6 and found.lists[:, 1].tolist() == [4, 4, 4, 4]
    structure.release()
    triangles.release()


@pytest.fixture(scope="module")
def show(session_ctx):
    with session_ctx:
        one = CurtainShow(session_ctx, SMALL)
    yield one
    with session_ctx:
        one.release()


def test_against_radiosity(ctx, show):
    """A curtain that is not there, before a dark sky: the lamp's indirect light on floor, ceiling and three walls."""
    kept = show.environment, show.fabric
    voile = load_fabric("sheer_voile")
    yarns = [yarn.model_copy(update={"albedo": BLACK, "k_d": 0.0, "eta": 1.0001}) for yarn in voile.yarn]
    clear = voile.transmission.model_copy(update={"rho": 0.0, "k_a": 1.0})
    show.change(SMALL.changed(gi="radiosity"), environment=Environment("dark", np.full((4, 8, 3), 1e-9, np.float32)))
    show.fabric = voile.model_copy(update={"transmission": clear, "yarn": tuple(yarns)})
    show.picture()
    factors = show.radiosity.factors
    charts = factors.charts
    E = show.radiosity.irradiance()[: len(charts.positions)]
    area = charts.area * (factors.openness() >= OPEN)
    show.scene = SMALL.changed(photons=40_000, photon_neighbours=8)
    show.picture()
    _, W, place = show.photons.photons()
    show.change(SMALL)
    show.environment, show.fabric = kept
    # The outer sides of walls get light too.
    room = (place < 2 * len(show.room.positions)) & (place % 2 == 0)
    chart = charts.chart_of[place[room] // 2]
    for k in np.argsort(-np.linalg.norm(np.cross(charts.u, charts.v), axis=1))[:5]:
        own = charts.element_chart == k
        np.testing.assert_allclose(W[room][chart == k].sum(0), (E[own] * area[own, None]).sum(0), rtol=0.05)


def test_pictures_of_the_room(ctx, show):
    """The same seed gives the same bits, with any structure; more samples, with photons of their own, come nearer to many
    photons; the light is about that of radiosity."""
    show.advance(1)
    show.change(SMALL)
    picture = show.picture()
    assert np.isfinite(picture).all() and picture.min() >= 0
    arrays = show.photons.room_tree()
    x = show.photons.in_room()
    leaf = (arrays["axis"] == 3) & (arrays["count"] > 0)
    assert arrays["count"][leaf].sum() == len(x) < show.photons.arrived
    tree = show.tree()
    assert ((tree[..., 2] > 0.2) & (tree[..., 2] > 1.5 * tree[..., :2].max(-1))).sum() > 5  # photons are blue
    show.change(SMALL.changed(accelerator="brute"))
    np.testing.assert_array_equal(show.picture(), picture)
    show.change(SMALL.changed(photons=1000, spp=4))
    four = dataclasses.replace(show.shot(), offsets=((0.0, 0.0),) * 4)
    one = dataclasses.replace(four, offsets=((0.0, 0.0),))
    error = [np.abs((show.tracer.trace(show.lit(shot)) - picture)[..., 1]).mean() for shot in (one, four)]
    assert 0 < error[1] < 0.8 * error[0]
    show.change(SMALL.changed(gi="radiosity"))
    assert picture.mean() == pytest.approx(show.picture().mean(), rel=0.1)


def test_the_window_reads_their_tree_between_samples(ctx):
    """Else it would find them anew among half of those that are being found."""
    pictures = []
    for reads in (False, True):
        player = Player(ctx)
        player.show(SMALL.changed(spp=2), Environment("even", np.ones((4, 8, 3), np.float32)))
        read = 0
        while not player.idle:
            player.work(1e-6)
            if reads and (built := player.built) is not None:
                assert built[1:] == (0, "photons")
                player.curtain.tree_content(camera_of(SMALL))
                read += 1
        assert (read > 0) == reads
        pictures.append(np.frombuffer(player.sides[0].texture.read(), np.float32))
        player.release()
    np.testing.assert_array_equal(*pictures)
