"""The ray tracer: closed forms on flat sheets, a slow NumPy tracer on folds, tree against brute force, no speckles."""

import curtain_scenes as scenes
import numpy as np
import pytest
import slow_tracer

from glcloth.accel.triangles import Triangles
from glcloth.errors import InputError
from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera, lens_samples, sample_offsets
from glcloth.gpu.programs import programs
from glcloth.gpu.tally import counting
from glcloth.light.environment import Environment, lookup, rotation_y
from glcloth.methods.albedo import diffuse_albedo
from glcloth.tracing.energy import directional_albedo, mean_albedo, reflection_limit
from glcloth.tracing.lamp import Lamp, Lighting
from glcloth.tracing.rays import BLOCK, COUNTS
from glcloth.tracing.shot import Shot, TraceSettings
from glcloth.tracing.tracer import Tracer, _tiles
from glcloth.twins import sheet

DARK = (0.0, 0.0, 0.0)
WHITE = (1.0, 1.0, 1.0)
VOILE = load_fabric("sheer_voile")


@pytest.fixture(scope="module")
def session_tracer(session_ctx):
    with session_ctx:
        tracer = Tracer(session_ctx)
        yield tracer
        tracer.release()


@pytest.fixture
def tracer(ctx, session_tracer):
    return session_tracer


def rectangle(z, half=50.0):
    """Two triangles in the plane z, yarn 1 along x."""
    a, b, c, d = ([x, y, z] for x, y in ((-half, -half), (half, -half), (half, half), (-half, half)))
    return np.array([[a, b, c], [a, c, d]], float)


def floor(y, half=50.0):
    a, b, c, d = ([x, y, z] for x, z in ((-half, -half), (half, -half), (half, half), (-half, half)))
    return np.array([[a, b, c], [a, c, d]], float)


X = np.broadcast_to([1.0, 0, 0], (2, 3, 3))


def view(tracer, parts, size=(16, 8), lighting=None, camera=None, fabric=VOILE, **settings):
    """Trace parts [(triangles, material)], all with yarn 1 along x; materials: the cloth, a grey of 0.5, black."""
    positions = np.concatenate([p for p, _ in parts])
    material = np.concatenate([np.full(len(p), m) for p, m in parts])
    return tracer.render(
        positions,
        material,
        np.array([[0, 0, 0], [0.5, 0.5, 0.5], [0, 0, 0]]),
        Shot(
            camera or Camera((0, 0, 4), (0, 0, 0)),
            size,
            fabric,
            lighting or Lighting(Lamp(intensity=DARK), DARK, WHITE),
            settings=TraceSettings(**settings),
        ),
        tangents=np.broadcast_to([1.0, 0, 0], positions.shape),
    )


def pixel_directions(camera, size):
    """Unit directions [H, W, 3], top row first."""
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, size[1] - 0.5 - np.arange(size[1]))
    d = np.stack([x, y, np.ones_like(x)], -1) @ camera.ray_from_pixel(size).T
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def through(omega, fabric=VOILE, half=False):
    t = fabric.transmission
    return sheet.T_sheet(omega, t.k_a, t.k_t * (0.5 if half else 1), np.array(t.tau), t.rho)


def mirrored(omega, fabric=VOILE):
    t = fabric.transmission
    return sheet.R_sheet(omega, t.k_t, t.rho, t.eta_1, t.eta_2)[..., None]


@pytest.mark.parametrize("name", ["sheer_voile", "linen_curtain"])
def test_flat_sheets_in_a_white_room(tracer, name):
    """White furnace: what passes and what is mirrored, by the closed forms, and never more than comes in."""
    camera, fabric = Camera((0, 0, 4), (0.5, 0.3, 0), fov_deg=80), load_fabric(name)
    d = pixel_directions(camera, (16, 8))
    T, R = through(d, fabric), mirrored(d, fabric)
    one = view(tracer, [(rectangle(0), 0)], camera=camera, fabric=fabric)
    np.testing.assert_allclose(one, T + R, rtol=2e-4)
    # A second sheet mirrors too; four generations see T T, T R T, T R R R, ...: never more than 1.
    two = view(tracer, [(rectangle(0), 0), (rectangle(-1), 0)], camera=camera, fabric=fabric, depth=6, cutoff=0.0)
    series = R + T * T + T * R * T + T * R * R * T
    np.testing.assert_allclose(two, series, atol=2e-3)
    assert (two <= 1).all() and (one <= 1).all()


def test_depth_counts_generations(tracer):
    """With `depth` generations the last sheet that is reached sends nothing on."""
    camera = Camera((0, 0, 4), (0, 0, 0), fov_deg=10)
    T = through(pixel_directions(camera, (4, 4)))
    R = mirrored(pixel_directions(camera, (4, 4))) * np.ones(3)
    sheets = [(rectangle(-float(k)), 0) for k in range(3)]
    assert (view(tracer, sheets, (4, 4), camera=camera, depth=1) == 0).all()
    np.testing.assert_allclose(view(tracer, sheets, (4, 4), camera=camera, depth=2), R, rtol=1e-4)
    # Third generation: mirrored by the second sheet and on its way back it ends at the first.
    np.testing.assert_allclose(view(tracer, sheets, (4, 4), camera=camera, depth=3), R, rtol=1e-4)
    # Fourth: through all three, and twice through the first after a mirroring by the second.
    np.testing.assert_allclose(view(tracer, sheets, (4, 4), camera=camera, depth=4), R + T**3 + T * R * T, rtol=1e-3)


def test_lamp_through_cloth_onto_a_floor(tracer):
    """Lambert's floor in the light of a lamp that passes no sheet, some, and as many as any ray."""
    lamp, intensity = np.array([3.0, 8.0, -5.0]), np.array([200.0, 150.0, 100.0])
    lighting = Lighting(Lamp(tuple(lamp), tuple(intensity)), DARK, DARK)
    camera = Camera((0, 3, 6), (0, 0, 5), fov_deg=20)
    d = pixel_directions(camera, (16, 8))
    toward = lamp - (np.array(camera.eye) - d * (camera.eye[1] / d[..., 1:2]))
    distance = np.linalg.norm(toward, axis=-1, keepdims=True)
    toward /= distance
    for count in (0, 1, 2, 8, 9):
        sheets = [(rectangle(-1.0 - 0.4 * k), 0) for k in range(count)]
        got = view(tracer, [(floor(0), 1), *sheets], lighting=lighting, camera=camera)
        if count > 8:
            np.testing.assert_array_equal(got, 0)
            continue
        expected = 0.5 / np.pi * toward[..., 1:2] * intensity / distance**2 * through(toward, half=True) ** count
        np.testing.assert_allclose(got, expected, rtol=2e-4 if count < 3 else 1e-3)
    wall = view(tracer, [(floor(0), 1), (rectangle(-1.0), 1)], lighting=lighting, camera=camera)
    np.testing.assert_array_equal(wall, 0)


def test_point_lamp_on_a_floor(tracer):
    """The inverse square of the distance and the cosine."""
    lamp = np.array([0.5, 2.0, 1.0])
    camera = Camera((0, 3, 6), (0, 0, 2), fov_deg=30)
    got = view(tracer, [(floor(0), 1)], lighting=Lighting(Lamp(tuple(lamp), WHITE), DARK, DARK), camera=camera)
    d = pixel_directions(camera, (16, 8))
    p = np.array(camera.eye) - d * (camera.eye[1] / d[..., 1:2])
    r = lamp - p
    r_2 = (r**2).sum(-1)
    np.testing.assert_allclose(got[..., 0], 0.5 / np.pi * r[..., 1] / r_2**1.5, rtol=2e-4)


@pytest.mark.parametrize("spp", [1, 8])
@pytest.mark.parametrize("ortho", [None, 3.0])
def test_parallel_rays_and_a_lens_meet_the_floor_where_they_should(tracer, ortho, spp):
    """The mean over the samples of the lamp's light where each ray meets the floor."""
    lamp, size = np.array([0.5, 2.0, 1.0]), (16, 8)
    camera = Camera((0, 3, 6), (0, 0, 2), fov_deg=30, ortho=ortho, aperture=0.6, focus=3.0)
    lighting = Lighting(Lamp(tuple(lamp), WHITE), DARK, DARK)
    got = view(tracer, [(floor(0), 1)], size, lighting=lighting, camera=camera, spp=spp)
    expected = []
    for one, offset in zip(lens_samples(camera, spp), sample_offsets(spp), strict=True):
        x, y = np.meshgrid(np.arange(size[0]) + 0.5, size[1] - 0.5 - np.arange(size[1]))
        at = np.stack([x, y, np.ones_like(x)], -1)
        o, d = at @ one.origin_from_pixel(size, offset).T, at @ one.ray_from_pixel(size, offset).T
        r = lamp - (o - d * (o[..., 1:2] / d[..., 1:2]))
        expected.append(0.5 / np.pi * r[..., 1] / (r**2).sum(-1) ** 1.5)
    np.testing.assert_allclose(got[..., 0], np.mean(expected, 0), rtol=3e-4)
    assert spp == 1 or np.ptp(expected, 0).max() > 0.05 * np.max(expected)


def test_cloth_lit_from_behind(tracer):
    """The glow of a sheet before a lamp is equation 1, written out with the float64 functions."""
    t = VOILE.transmission
    lamp = np.array([0.4, 0.2, -2.0])
    camera = Camera((0, 0, 4), (0, 0, 0), fov_deg=60)
    got = view(tracer, [(rectangle(0), 0)], lighting=Lighting(Lamp(tuple(lamp), WHITE), DARK, DARK), camera=camera)
    d = pixel_directions(camera, (16, 8))
    p = np.array(camera.eye) - d * (camera.eye[2] / d[..., 2:3])
    r = lamp - p
    r_2 = (r**2).sum(-1, keepdims=True)
    flip = np.array([1.0, 1.0, -1.0])
    i, o = r / np.sqrt(r_2) * flip, -d * flip
    f = sheet.f_yarn(i, o, t.roughness, t.eta_1, t.eta_2, t.diffuse, t.roughness_p)[..., None]
    cover = sheet.covered(i, o, t.rho)[..., None]
    expected = cover * t.k_t * sheet.absorption(i, o, np.array(t.tau)) * f * i[..., 2:] / r_2
    np.testing.assert_allclose(got, expected, rtol=1e-3, atol=1e-6)


def test_environment_behind_the_window(tracer):
    rng = np.random.default_rng(0)
    environment = Environment("test", rng.random((16, 32, 3)).astype(np.float32))
    camera = Camera((0, 0, 0), (1, 0.2, -0.3), fov_deg=70)
    got = tracer.render(
        floor(-1000.0, 1.0),
        np.ones(2, int),
        np.full((2, 3), 0.5),
        Shot(camera, (16, 8), VOILE, Lighting(Lamp(intensity=DARK), DARK), environment, env_rotate=35),
    )
    expected = lookup(environment, pixel_directions(camera, (16, 8)) @ rotation_y(-35).T)
    np.testing.assert_allclose(got, expected, rtol=0.02, atol=0.01)


def soft_curtain(columns=33, rows=25, time=1.0):
    """(triangles, normals, tangents) of the test curtain with smooth frames."""
    grid = scenes.curtain_grid(columns, rows, time)
    du, dv = np.gradient(grid, axis=1), np.gradient(grid, axis=0)
    normal = np.cross(dv, du)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return tuple(scenes.grid_triangles(a) for a in (grid, normal, du))


def folded_scene(columns=33, rows=25, time=1.0):
    """Arguments of `render` for the room and a curtain."""
    cloth, normals, tangents = soft_curtain(columns, rows, time)
    room = scenes.room()
    flat = np.repeat(np.cross(room[:, 1] - room[:, 0], room[:, 2] - room[:, 0])[:, None], 3, 1)
    edge = np.repeat((room[:, 1] - room[:, 0])[:, None], 3, 1)
    colors = np.random.default_rng(2).uniform(0.2, 0.8, (14, 3))
    return {
        "positions": np.concatenate([room, cloth]).astype(np.float32),
        "normals": np.concatenate([flat, normals]),
        "tangents": np.concatenate([edge, tangents]),
        "material": np.concatenate([np.arange(len(room)) // 12 + 1, np.zeros(len(cloth), int)]),
        "materials": colors,
    }


ROOM_LIGHT = Lighting(Lamp((0.5, 2.2, -3.0), (60, 58, 54)), (0.2, 0.2, 0.25), (0.5, 0.7, 1.0))
ROOM_CAMERA = Camera((0.9, 1.5, 3.6), (-0.1, 1.25, 0), fov_deg=50)


def test_against_a_slow_tracer(tracer):
    """Every pixel of a small picture of folds, by NumPy in float64: recursion instead of queues, all triangles."""
    scene = folded_scene(17, 9)
    size = (20, 20)
    got = tracer.render(
        **scene,
        shot=Shot(camera=ROOM_CAMERA, size=size, fabric=VOILE, lighting=ROOM_LIGHT, settings=TraceSettings(depth=3)),
    )
    d = pixel_directions(ROOM_CAMERA, size).reshape(-1, 3)
    expected = slow_tracer.trace(np.array(ROOM_CAMERA.eye), d, scene, VOILE, ROOM_LIGHT, depth=3, cutoff=1e-3).reshape(
        20, 20, 3
    )
    error = np.abs(got - expected).max(-1) / (0.05 + expected.max(-1))
    # A ray within rounding of a silhouette or of the cutoff may go either way.
    assert np.median(error) < 1e-4 and (error > 2e-3).mean() < 0.01


@pytest.mark.parametrize("accelerator", ["lbvh", "brute"])
def test_structures_make_the_same_picture(tracer, accelerator):
    if accelerator == "lbvh":
        pytest.importorskip("glcloth.accel.lbvh")
    scene = folded_scene()
    pictures = [
        tracer.render(**scene, shot=Shot(camera=ROOM_CAMERA, size=(64, 64), fabric=VOILE, lighting=ROOM_LIGHT,
                      settings=TraceSettings(accelerator=name)))
        for name in ("kdtree", accelerator)
    ]  # fmt: skip
    np.testing.assert_allclose(pictures[0], pictures[1], rtol=1e-5, atol=1e-6)


def test_the_picture_is_the_same_every_time(tracer):
    scene = folded_scene()
    a, b = (
        tracer.render(**scene, shot=Shot(camera=ROOM_CAMERA, size=(100, 70), fabric=VOILE, lighting=ROOM_LIGHT))
        for _ in range(2)
    )
    np.testing.assert_array_equal(a, b)


def test_no_speckles(tracer):
    """A smooth curtain alone: no pixel differs from all its neighbours, as self-intersections would make it."""
    cloth, normals, tangents = soft_curtain(97, 65)
    picture = tracer.render(
        cloth,
        np.zeros(len(cloth), int),
        np.zeros((1, 3)),
        Shot(Camera((0.2, 1.3, 2.6), (0, 1.3, 0), fov_deg=28), (160, 160), VOILE, ROOM_LIGHT),
        normals,
        tangents,
    )[..., 1]
    middle = picture[1:-1, 1:-1]
    around = np.stack([picture[1 + i : 159 + i, 1 + j : 159 + j] for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j])
    dark = (around.min(0) - middle) / around.mean(0)
    bright = (middle - around.max(0)) / around.mean(0)
    assert max(dark.max(), bright.max()) < 0.1


def test_tiles_and_odd_sizes(tracer, monkeypatch):
    scene = folded_scene()
    whole = tracer.render(**scene, shot=Shot(camera=ROOM_CAMERA, size=(71, 53), fabric=VOILE, lighting=ROOM_LIGHT))
    monkeypatch.setattr("glcloth.tracing.tracer.TILE_PIXELS", 256)
    tiled = tracer.render(**scene, shot=Shot(camera=ROOM_CAMERA, size=(71, 53), fabric=VOILE, lighting=ROOM_LIGHT))
    np.testing.assert_array_equal(whole, tiled)


@pytest.mark.parametrize("accelerator", ["kdtree", "lbvh"])
def test_work_groups_in_rows(ctx, tracer, monkeypatch, accelerator):
    """A device that takes few work groups along a line makes the same picture."""
    shot = Shot(ROOM_CAMERA, (71, 53), VOILE, ROOM_LIGHT, settings=TraceSettings(accelerator=accelerator))
    scene = folded_scene()
    whole = tracer.render(**scene, shot=shot)
    monkeypatch.setattr(programs(ctx), "most_groups", 7)
    np.testing.assert_array_equal(whole, tracer.render(**scene, shot=shot))


def test_supersampling_converges(tracer):
    """Sixteen samples a pixel lie nearer to a picture of twice the size, averaged, than one does."""
    scene = folded_scene()
    common = {"camera": ROOM_CAMERA, "fabric": VOILE, "lighting": ROOM_LIGHT}
    fine = tracer.render(**scene, shot=Shot(size=(192, 192), **common)).reshape(48, 4, 48, 4, 3).mean((1, 3))
    errors = [
        np.abs(
            np.minimum(tracer.render(**scene, shot=Shot(size=(48, 48), settings=TraceSettings(spp=n), **common)), 2)
            - np.minimum(fine, 2)
        ).mean()
        for n in (1, 16)
    ]
    assert errors[1] < 0.5 * errors[0]


def test_spread_keeps_the_energy(tracer):
    """Directions drawn from the lobes: in a white room the mean is what goes straight on without drawing."""
    camera = Camera((0, 0, 4), (0, 0, 0), fov_deg=60)
    exact = through(pixel_directions(camera, (16, 8)))
    got = view(tracer, [(rectangle(0), 0)], camera=camera, spread=True, spp=64) - mirrored(
        pixel_directions(camera, (16, 8))
    )
    np.testing.assert_allclose(got, exact, rtol=0.05)
    np.testing.assert_allclose(got.mean((0, 1)), exact.mean((0, 1)), rtol=0.004)


def test_statistics_add_up(tracer):
    scene = folded_scene()
    tracer.render(**scene, shot=Shot(camera=ROOM_CAMERA, size=(64, 64), fabric=VOILE, lighting=ROOM_LIGHT))
    s = tracer.statistics
    assert s.rays[0] == 64 * 64 and len(s.rays) == 4
    assert all(0 < b <= 2 * a for a, b in zip(s.rays, s.rays[1:], strict=False))
    assert all(0 < b <= a for a, b in zip(s.rays, s.shadow_rays, strict=True))
    assert all(0 < heads <= rays for rays, heads in zip(s.rays, s.heads, strict=True))  # each is cast once
    assert s.total_ms >= sum(s.trace_ms) + sum(s.shade_ms) + sum(s.shadow_ms)


def test_the_cpu_waits_once_a_tile(ctx, tracer):
    """For the numbers of its rays; and once for the picture."""
    scene = folded_scene()
    for depth in (1, 4):
        settings = TraceSettings(depth=depth, accelerator="brute")
        with counting(ctx) as counted:
            tracer.render(
                **scene,
                shot=Shot(camera=ROOM_CAMERA, size=(32, 32), fabric=VOILE, lighting=ROOM_LIGHT, settings=settings),
            )
        assert (counted.reads, counted.read_bytes) == (2, 4 * COUNTS["COUNTS"] + 16 * 32 * 32)


@pytest.mark.parametrize("accelerator", ["kdtree", "lbvh"])
def test_a_tile_without_room_begins_anew(ctx, tracer, monkeypatch, accelerator):
    """Whatever the first guess of the places that generations and heads need: the same bits, and the next picture fits."""
    scene, settings = folded_scene(), TraceSettings(accelerator=accelerator)
    shot = Shot(camera=ROOM_CAMERA, size=(64, 48), fabric=VOILE, lighting=ROOM_LIGHT, settings=settings)
    expected = tracer.render(**scene, shot=shot)
    rays = dict(zip(("rays", "heads", "shadow_rays"), (list(v) for v in (
        tracer.statistics.rays, tracer.statistics.heads, tracer.statistics.shadow_rays)), strict=True))  # fmt: skip
    for few in (1, 700):
        other = Tracer(ctx)
        narrow = other._rays

        def make_room(first, depth, narrow=narrow, few=few):
            for level, generation in enumerate(narrow._generations):
                generation.reserve(first if level == 0 else few)
            narrow._head_capacity = max(narrow._head_capacity, first)

        monkeypatch.setattr(narrow, "_make_room", make_room)
        try:
            with counting(ctx) as counted:
                np.testing.assert_array_equal(other.render(**scene, shot=shot), expected)
            with counting(ctx) as again:
                np.testing.assert_array_equal(other.render(**scene, shot=shot), expected)
            assert counted.reads > again.reads
            assert {name: getattr(other.statistics, name) for name in rays} == rays
        finally:
            other.release()


def test_a_grid_on_the_gpu_is_the_same_as_arrays(ctx, tracer):
    """The soup gathered from vertex buffers equals the one made from arrays."""
    grid = scenes.curtain_grid(13, 7, 0.4).astype(np.float32)
    rng = np.random.default_rng(0)
    vectors = rng.normal(size=(2, 7, 13, 3))
    vectors /= np.linalg.norm(vectors, axis=-1, keepdims=True)
    buffers = []
    for array in (grid, *vectors):
        data = np.zeros((7 * 13, 4), np.float32)
        data[:, :3] = array.reshape(-1, 3)
        buffers.append(ctx.buffer(data.tobytes()))
    a, b = (Triangles(ctx, 3 + 2 * 6 * 12, 3.0) for _ in range(2))
    a.set_grid(3, 7, 13, *buffers, material=5)
    b.set(3, scenes.grid_triangles(grid), scenes.grid_triangles(vectors[0]), scenes.grid_triangles(vectors[1]), 5)
    np.testing.assert_array_equal(a.positions()[3:], b.positions()[3:])
    for name in ("corners", "attributes"):
        x, y = (np.frombuffer(getattr(s, name).buffer.read(), np.uint32) for s in (a, b))
        words = 12 * 3 if name == "corners" else 4 * 3
        packed = np.stack([x[words:], y[words:]])
        # Packed directions may differ by one step of rounding.
        low = (packed & 0xFFFF).astype(np.uint16).astype(np.int16).astype(int)
        high = (packed >> 16).astype(np.uint16).astype(np.int16).astype(int)
        same = packed[0] == packed[1]
        near = (np.abs(np.diff(low, axis=0)[0]) <= 1) & (np.abs(np.diff(high, axis=0)[0]) <= 1)
        assert (same | near).all()
    for thing in (a, b, *buffers):
        thing.release()


def test_wrong_input(tracer):
    scene = folded_scene()
    with pytest.raises(InputError, match="transmission"):
        tracer.render(**scene, shot=Shot(camera=ROOM_CAMERA, size=(8, 8), fabric=load_fabric("satin_charmeuse_front")))
    with pytest.raises(InputError, match="accelerator"):
        tracer.render(
            **scene,
            shot=Shot(camera=ROOM_CAMERA, size=(8, 8), fabric=VOILE, settings=TraceSettings(accelerator="octree")),
        )
    for bad in ({"depth": 0}, {"depth": 9}, {"spp": 0}, {"cutoff": 1.0}):
        with pytest.raises(InputError, match=next(iter(bad))):
            TraceSettings(**bad)
    for bad in ({"intensity": (-1, 0, 0)}, {"position": (np.nan, 0, 0)}):
        with pytest.raises(InputError, match="lamp"):
            Lamp(**bad)


def test_a_lamp_is_an_even_disc_that_faces_the_origin():
    lamp = Lamp((1.0, 2.0, -2.0), WHITE, 0.3)
    off = lamp.points(64) - lamp.position
    x, y = (axis / 0.3 for axis in lamp.axes)
    np.testing.assert_allclose([x @ x, y @ y, x @ y, *(np.stack([x, y]) @ lamp.position)], [1, 1, 0, 0, 0], atol=1e-9)
    assert 0.28 < np.linalg.norm(off, axis=1).max() <= 0.3 and np.abs(off @ lamp.position).max() < 1e-9
    np.testing.assert_allclose([(off @ x) @ (off @ x), (off @ y) @ (off @ y)], 64 * 0.3**2 / 4, rtol=0.1)
    np.testing.assert_array_equal(lamp.points(1), [lamp.position])


@pytest.mark.parametrize("pixels", [8, 100, 3000])
def test_tiles_have_each_pixel_once(pixels):
    size = 53, 17
    seen = np.zeros(size, int)
    for tile in _tiles(*size, lambda: pixels):
        (x, y), (across, up) = tile.first, (n * b for n, b in zip(tile.blocks, BLOCK, strict=True))
        seen[x : x + across, y : y + up] += 1
        assert tile.pixels(size) == seen[x : x + across, y : y + up].size
    assert (seen == 1).all()


def test_what_a_fabric_reflects_leaves_room_for_what_passes():
    """Dimmed no more than it must be; and its mean is that of another quadrature."""
    yarn = VOILE.yarn[0].changed(albedo=(1.0, 1.0, 1.0), k_d=0.9)
    bright = VOILE.changed(yarn=(yarn, yarn))
    t, limit = bright.transmission, reflection_limit(bright)
    theta, phi = (
        a.ravel() for a in np.meshgrid(np.radians([4.0, 25.0, 45.0, 62.0, 76.0]), np.radians([0.0, 45.0, 90.0, 160.0]))
    )
    o = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    optics = t.k_t, np.array(t.tau), t.rho
    passes = [sheet.T_sheet(o, t.k_a, *optics),
              sheet.T_straight(o, t.k_a, *optics, t.diffuse) + sheet.T_lambert(o, *optics, t.diffuse)]  # fmt: skip
    mirrored = sheet.R_sheet(o, t.k_t, t.rho, t.eta_1, t.eta_2)[:, None]
    total = limit * np.array([directional_albedo(bright, one) for one in o]) + np.maximum(*passes) + mirrored
    assert limit < 1.0 and total.max() == pytest.approx(1.0, abs=1e-6)
    np.testing.assert_allclose(mean_albedo(bright), diffuse_albedo(bright), rtol=0.02)
