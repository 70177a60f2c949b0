"""Objects and a ground about the cloth: closed forms, what hides what, and that nothing changes without them."""

import shlex

import numpy as np
import pytest
from test_shadows import joined, sheet

from glcloth.accel.ground import OverGround
from glcloth.accel.lbvh import Lbvh
from glcloth.accel.queries import RayQueries
from glcloth.accel.triangles import Triangles, rotated_corners
from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.geometry.graded import graded
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.mesh_files import BALL, PLINTH, TABLE, load_mesh, load_solid
from glcloth.geometry.props import RINGS, SECTORS, Ground, Objects, stand_on
from glcloth.gpu.scene_buffers import SceneBuffers
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.scene import Scene, View, load_scene
from glcloth.twins.ground import ground_place
from glcloth.twins.lambert import gaussian_above, gaussian_irradiance
from glcloth.visibility.bounce import Bounce
from glcloth.visibility.furnace import Given
from glcloth.visibility.hit_vertices import HitSurface
from glcloth.visibility.pixels import Occluders, PixelVisibility
from glcloth.window.sharing import as_command, as_python

COLOR = (0.4, 0.3, 0.2)
SKY = Lights(SphericalGaussians([[0, 1, 0]], [0.0], [[1.0, 1.0, 1.0]]))  # the same from everywhere
MIXED = Lights(
    SphericalGaussians([[0, 1, 0], [0.8, 0.5, 0.2], [0, -1, 0.1]], [1.5, 40.0, 3.0], [[1, 1, 1], [4, 3, 2], [1, 2, 3]]),
    Suns([[-0.6, 0.7, 0.2]], [[3.0, 2.5, 2.0]]),
)
ABOVE = Camera(eye=(0.0, 4.0, 1e-3), target=(0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), fov_deg=40)


def at(x, z, size=96, height=-0.5):
    """The pixel (row, column) of a point of the ground, seen from ABOVE."""
    half = (4.0 - height) * np.tan(np.radians(20))
    return int((0.5 + 0.5 * z / half) * size), int((0.5 + 0.5 * x / half) * size)


def seen(renderer, mesh=None, size=96, **changes):
    """A picture of a small sheet at y = 0 over a ground at -0.5."""
    scene = dict(
        mesh=mesh or sheet(8, size=0.4),
        fabric="linen",
        camera=ABOVE,
        size=(size, size),
        background=False,
        ground=-0.5,
        ground_color=COLOR,
        bounce=False,
    )
    return renderer.render(**scene | changes)


def share_of_square(half, height):
    """The form factor of a parallel square above a point, its middle over the point."""
    a = half / height
    root = np.sqrt(1 + a * a)
    return 4 / np.pi * (a / root) * np.arctan(a / root)


# -- closed forms ----------------------------------------------------------------------------------------------------------


def test_irradiance_of_a_gaussian():
    """Against brute force, and where it is known: a uniform sky, a Gaussian at the zenith, a needle."""
    z, weight = np.polynomial.legendre.leggauss(300)
    z, weight = (z + 1) / 2, weight / 2
    psi = (np.arange(1000) + 0.5) * np.pi / 500
    for kappa in (0.3, 4.0, 40.0):
        flux = 2 * np.pi * -np.expm1(-2 * kappa) / kappa
        for c in (-0.9, -0.3, 0.0, 0.2, 0.8):
            d = c * z[:, None] + np.sqrt(1 - c * c) * np.sqrt(1 - z[:, None] ** 2) * np.cos(psi)
            expected = (np.exp(kappa * (d - 1)) * (z * weight)[:, None]).sum() * np.pi / 500
            assert abs(gaussian_irradiance(kappa, c) - expected) < 1e-5 * flux
    assert gaussian_irradiance(0.0, 0.4) == pytest.approx(np.pi, rel=1e-5)
    assert gaussian_irradiance(1e4, 0.6) == pytest.approx(0.6 * 2 * np.pi / 1e4, rel=1e-4)
    assert gaussian_irradiance(1e4, -0.2) == 0.0
    for kappa, c in ((0.5, 0.7), (8.0, 0.1), (60.0, -0.3)):
        whole = 2 * np.pi * -np.expm1(-2 * kappa) / kappa
        assert gaussian_above(kappa, c) + gaussian_above(kappa, -c) == pytest.approx(whole, rel=1e-4)
        slope = (gaussian_above(kappa, 0.6) - gaussian_above(kappa, -0.6)) / whole
        assert slope > 0.1 and gaussian_above(kappa, 1.0) == pytest.approx(
            2 * np.pi * -np.expm1(-kappa) / kappa, rel=2e-3
        )


def test_rings_are_where_their_closed_form_says():
    ground = Ground(-1.0, (0.3, -0.2), 1.5, COLOR)
    mesh = ground.mesh
    assert len(mesh.positions) == 1 + RINGS * SECTORS and np.allclose(mesh.normals, [0, 1, 0])
    x = mesh.positions.astype(float)[:, [0, 2]] - ground.center
    place = ground_place(x, ground.scale, RINGS, SECTORS)
    number = np.arange(1, len(x))
    near = (number - 1) // SECTORS < RINGS - 1  # the last ring lies farther than its number says
    assert np.allclose(place[1:, 0][near], ((number - 1) // SECTORS + 1)[near], atol=1e-3)
    sector = (number - 1) % SECTORS
    apart = (place[1:, 1] - sector + SECTORS / 2) % SECTORS - SECTORS / 2
    assert np.abs(apart).max() < 1e-3
    a, b, c = mesh.positions[mesh.triangles].astype(float).transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 1] > 0).all()


def test_rays_meet_the_plane_or_what_stands_before_it(ctx):
    rng = np.random.default_rng(3)
    positions = rng.uniform(-1, 1, (40, 3, 3)).astype("f4")
    structure = Lbvh(ctx)
    structure.build(Triangles.of(ctx, positions))
    over = OverGround(structure, -0.7)
    origins, directions = rng.uniform(-1.5, 1.5, (4000, 3)), rng.normal(size=(4000, 3))
    directions[:100, 1] = 0.0
    queries = RayQueries(ctx)
    bare = queries.closest_hit(structure, origins, directions)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (-0.7 - origins.astype("f4")[:, 1]) / directions.astype("f4")[:, 1]
    t = np.where(np.isfinite(t) & (t > 0), t, np.inf)
    both = queries.closest_hit(over, origins, directions)
    assert np.allclose(both.t, np.minimum(bare.t, t), rtol=1e-5)
    ground = t < bare.t
    assert ground.sum() > 500 and (both.triangle[ground] == 0x7FFFFFFF).all()
    assert np.array_equal(both.triangle[~ground], bare.triangle[~ground])
    assert np.array_equal(queries.any_hit(over, origins, directions), np.isfinite(both.t))


def test_hits_are_weighted_between_the_turned_corners(ctx):
    mesh = load_mesh("drape")
    triangles = Triangles.of(ctx, mesh.positions[mesh.triangles])
    structure = Lbvh(ctx)
    structure.build(triangles)
    corners = mesh.positions[rotated_corners(mesh.triangles, triangles.turn)].astype(float)
    assert np.array_equal(corners.astype("f4"), triangles.positions())
    rng = np.random.default_rng(0)
    chosen, weights = rng.integers(0, len(corners), 500), rng.dirichlet([2, 2, 2], 500)
    x = (corners[chosen] * weights[..., None]).sum(1)
    N = np.cross(corners[chosen, 1] - corners[chosen, 0], corners[chosen, 2] - corners[chosen, 0])
    N /= np.linalg.norm(N, axis=1, keepdims=True)
    hits = RayQueries(ctx).closest_hit(structure, x + 1e-3 * N, -N)
    same = hits.triangle == chosen
    assert same.mean() > 0.99
    assert np.abs(hits.weights - weights[:, 1:])[same].max() < 1e-3


# -- light on the ground ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["direct", "reference"])
def test_a_ground_alone_is_a_lambertian_under_all_lights(renderer, method):
    picture = seen(renderer, lights=MIXED, method=method, shadows="off", cube=32)
    g = MIXED.gaussians
    E = (gaussian_irradiance(g.sharpness, g.axis[:, 1])[:, None] * g.amplitude).sum(0)
    E = E + MIXED.suns.direction[0, 1] * MIXED.suns.irradiance[0]
    expected = np.array(COLOR) / np.pi * E
    assert np.allclose(picture[at(1.2, 0.9)], [*expected, 1.0], rtol=2e-3 if method == "reference" else 3e-4)


@pytest.mark.parametrize("method", ["direct", "paper", "reference"])
def test_a_square_takes_its_form_factor_of_a_uniform_sky(renderer, method):
    """Below the middle of a square that hides the sky, and far away from it. Seen from below the square; with 20
    directions an edge of the cube map it ends between two of them."""
    square = sheet(16, size=0.4)
    low = Camera(eye=(0.0, -0.1, 1.0), target=(0.0, -0.5, 0.0), fov_deg=4)
    middle = seen(renderer, square, 9, lights=SKY, method=method, camera=low, cube=20)[4, 4, :3]
    assert middle == pytest.approx(np.array(COLOR) * (1 - share_of_square(0.4, 0.5)), rel=0.02)
    far = seen(renderer, square, lights=SKY, method=method, cube=8)[2, 2, :3]
    assert far == pytest.approx(np.array(COLOR), rel=0.02)


@pytest.mark.parametrize("method", ["direct", "reference"])
def test_a_sun_throws_the_shadow_that_geometry_says(renderer, method):
    """The square's shadow is the square, moved by the sun's slope."""
    lights = Lights(SphericalGaussians([], [], []), Suns([[-1, 2, 0]], [[3.0, 3.0, 3.0]]))
    lit = 3.0 * (2 / np.sqrt(5)) * np.array(COLOR) / np.pi
    for shadows in ("sun", "full"):
        picture = seen(renderer, lights=lights, method=method, shadows=shadows, cube=4)
        assert picture[at(0.55, 0.3)][:3] == pytest.approx(np.zeros(3), abs=1e-6)
        assert picture[at(0.55, -0.3)][3] == 1.0
        for x, z in ((0.8, 0.0), (0.55, 0.55), (-1.0, 0.0)):
            assert picture[at(x, z)][:3] == pytest.approx(lit, rel=1e-3)
    assert seen(renderer, lights=lights, method=method, shadows="off")[at(0.55, 0.3)][:3] == pytest.approx(
        lit, rel=1e-3
    )


@pytest.mark.parametrize("method", ["direct", "paper", "reference"])
def test_the_ground_hides_what_shines_from_below(renderer, method):
    """A sheet under light from below only is dark over a ground, and lit without one."""
    lights = Lights(SphericalGaussians([[0, -1, 0]], [20.0], [[1.0, 1.0, 1.0]]))
    below = Camera(eye=(0.0, -0.4, 1e-3), target=(0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), fov_deg=40)
    scene = dict(lights=lights, method=method, camera=below, size=17, cube=8)
    free, dark = (seen(renderer, ground=ground, **scene)[8, 8, :3].mean() for ground in ("off", -0.5))
    assert free > 0.01 and dark < 1e-3 * free


@pytest.mark.parametrize("method", ["direct", "paper", "reference"])
@pytest.mark.parametrize("fabric", ["linen", "silk_crepe_de_chine"])
def test_the_ground_lights_what_hangs_over_it(renderer, method, fabric):
    """The underside of a small sheet sees the ground alone, which the uniform sky lights: as if the sky were of the
    ground's colour, but for the sheet's own shadow, a hundredth."""
    below = Camera(eye=(0.1, -0.3, 0.05), target=(0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), fov_deg=6)
    scene = dict(mesh=sheet(4, size=0.04), lights=SKY, method=method, camera=below, size=9, cube=16, fabric=fabric)
    scene |= dict(bounce=True)
    lit = seen(renderer, **scene)[4, 4, :3]
    free = seen(renderer, ground="off", shadows="off", **scene | {"method": "reference"})[4, 4, :3]
    assert lit == pytest.approx(free * np.array(COLOR), rel=0.04)


def test_the_cloth_lights_the_ground(renderer):
    """Beside a lit wall of linen the ground is brighter, by as much with vertices as with a ray for everything."""
    wall = sheet(12, size=0.4)
    wall = build_mesh("wall", wall.positions[:, [0, 2, 1]] + [0.0, -0.05, 0.0], wall.triangles[:, ::-1], wall.uv)
    lights = Lights(SphericalGaussians([[0.3, 0.5, 0.8]], [6.0], [[1.0, 1.0, 1.0]]))
    view = Camera(eye=(0.0, 1.5, 3.0), target=(0.0, -0.5, 0.4), fov_deg=10)
    scene = dict(mesh=wall, lights=lights, camera=view, size=24, cube=20)
    without, *with_bounce = (
        seen(renderer, method=method, bounce=bounce, **scene)[..., :3]
        for method, bounce in (("reference", False), ("reference", True), ("direct", True))
    )
    gain = with_bounce[0][12, 12] / without[12, 12]
    assert (gain > 1.02).all()
    assert np.abs(with_bounce[1] - with_bounce[0]).mean() < 0.015 * with_bounce[0].mean()


def bounced_by(ctx, meshes, shares):
    """What comes back to the vertices [V, 4, 4] of several cloths in sight of each other."""
    structure, scene, bounce = Lbvh(ctx), SceneBuffers(ctx), Bounce(ctx)
    structure.build(Triangles.of(ctx, np.concatenate([mesh.positions[mesh.triangles] for mesh in meshes])))
    scene.prepare(load_fabric("linen"), MIXED)
    bounce.hit_vertices.prepare([HitSurface(mesh, mesh) for mesh in meshes], structure.triangles)
    cloths = []
    for mesh in meshes:
        others = tuple(other for other in meshes if other is not mesh)
        cloths.append(PixelVisibility(ctx))
        occluders = Occluders(others, False, bounce.hit_vertices)
        cloths[-1].prepare("full", mesh, mesh, structure, MIXED, True, occluders)
        for _ in cloths[-1].steps():
            pass
        cloths[-1].integrate(None)
    surfaces = [(cloth, share, Given(0.2, 0.5)) for cloth, share in zip(cloths, shares, strict=True)]
    for _ in bounce.gather(surfaces, scene):
        pass
    assert not list(bounce.gather(surfaces, scene)), "known"
    data = [c.vertices.bounced.read(64 * len(m.positions)) for c, m in zip(cloths, meshes, strict=True)]
    return np.frombuffer(b"".join(data), "f4").reshape(-1, 4, 4)


def test_cloths_light_each_other_as_parts_of_one_mesh_do(ctx):
    """Each has its own reflectance, one of all its vertices or one for each."""
    low, high = sheet(6), sheet(9, height=0.4, size=0.8)
    gray, red = np.array([0.5, 0.5, 0.5]), np.array([0.7, 0.2, 0.1])
    count = len(low.positions), len(high.positions)
    each = np.zeros((sum(count), 4), "f4")
    each[:, :3] = np.repeat([gray, red], count, 0)
    one = bounced_by(ctx, [joined(low, high)], [each])
    two = bounced_by(ctx, [low, high], [gray, each[count[0] :]])
    assert np.abs(two - one).max() < 2e-3 * one.max()
    assert (two[count[0] :, 2, 0] > 0.1 * one.max()).any()  # the upper one's back gets light from below
    # Now the upper one is gray too: the front of the lower one gets another colour.
    changed = bounced_by(ctx, [low, high], [gray, gray])
    # By the second bounce, more of what the lower one sends back comes from the upper one.
    upper = changed[count[0] :, 2, :3] - two[count[0] :, 2, :3]
    assert (upper[:, 0] <= 1e-6).all() and (upper[:, 1:] >= -1e-6).all() and np.abs(upper).max() < 0.1 * two.max()
    assert changed[: count[0], 0, 2].max() > 2 * two[: count[0], 0, 2].max()


def test_from_below_the_ground_is_not_there(renderer):
    below = Camera(eye=(0.0, -2.0, 1e-3), target=(0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), fov_deg=40)
    picture = seen(renderer, lights=MIXED, camera=below, size=33)
    assert picture[16, 16, 3] == 1.0 and picture[1, 1, 3] == 0.0


def test_an_object_hides_the_cloth_that_lies_behind_it(renderer):
    """Every sample belongs to what is nearer; the picture is whole."""
    block, colors = load_solid("plane")
    x = 0.4 * block.positions[:, [0, 2, 1]] + [0.3, 0.3, 0.0]
    block = build_mesh("block", x, block.triangles[:, ::-1])
    objects = Objects(
        (block,), (0 * colors + np.float32([0.1, 0.6, 0.2]),), stand_on(sheet(8, size=0.4), [], -0.5, COLOR)
    )
    scene = dict(lights=SKY, objects=objects, shadows="off")
    for spp in (1, 4):
        picture = seen(renderer, spp=spp, **scene)
        assert np.allclose(picture[..., 3], 1.0, atol=1e-5)
        i, j = at(0.3, 0.0, height=0.3)
        assert picture[i, j, :3] == pytest.approx([0.1, 0.6, 0.2], rel=1e-3)
    alone = seen(renderer, ground="off", lights=SKY, shadows="off")
    i, j = at(-0.2, 0.0, height=0.0)
    assert np.array_equal(alone[i, j], seen(renderer, **scene)[i, j])


@pytest.mark.parametrize("changes", [{"adaptive": True}, {"spp": 2}])
def test_steps_in_bands_make_the_same_picture(renderer, changes):
    scene = dict(mesh=sheet(8, size=0.4), lights=MIXED, ground="auto", size=(40, 30), **changes)
    expected = renderer.render(**scene)
    frame = renderer.prepare(**scene)
    for _ in renderer.steps(frame, rows=lambda: 7):
        pass
    assert np.array_equal(renderer.gbuffer.read()[..., :3], expected)


# -- values and doors ------------------------------------------------------------------------------------------------------


def test_ground_lies_just_under_the_lowest_point(renderer):
    cloth, ball = sheet(4), load_mesh("sphere")
    assert stand_on(cloth, [], None, COLOR).height == pytest.approx(-0.002 * cloth.radius)
    assert stand_on(cloth, [ball], None, COLOR).height == pytest.approx(-0.5 - 0.002 * cloth.radius)
    frame = renderer.prepare(mesh=cloth, objects=("sphere",), ground=True)
    assert frame.objects.ground.height == pytest.approx(-0.5 - 0.002 * cloth.radius)
    assert renderer.prepare(frame.scene, mesh=cloth).objects is frame.objects
    assert renderer.prepare(mesh=cloth).objects is None


def test_cloth_is_seen_from_a_centimetre_over_a_ground_without_end(renderer):
    eye = {"eye": (0.1, 0.01, 0.1), "target": (0.1, 0.0, 0.1), "up": (0.0, 0.0, -1.0), "fov_deg": 30.0}
    corners = np.array([[-1.0, 0, -1], [-1.0, 0, 1], [1.0, 0, 1], [1.0, 0, -1]])
    sheet = build_mesh("sheet", corners, np.array([[0, 1, 2], [0, 2, 3]]), corners[:, ::2], None)
    look = dict(mesh=sheet, fabric="linen", ground=-0.5, size=(8, 8), shadows="off", camera=View(**eye), aovs="depth")
    np.testing.assert_allclose(renderer.render(**look)["depth"][3:5, 3:5], 0.01, rtol=0.01)


def test_objects_bring_their_colours(tmp_path, capsys):
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 0.7 0.1 0.2\n")
    faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{faces}usemtl red\nf 1 2 3\nf 2 4 3\n")
    _, colors = load_solid(tmp_path / "a.obj")
    assert np.allclose(colors, [[0.7, 0.1, 0.2]] * 2)
    (tmp_path / "b.obj").write_text(f"{faces}f 1 2 3\n")
    assert np.allclose(load_solid(tmp_path / "b.obj")[1], 0.5)
    (tmp_path / "c.obj").write_text(f"mtllib none.mtl\n{faces}f 1 2 3\n")
    assert np.allclose(load_solid(tmp_path / "c.obj")[1], 0.5)
    assert "none.mtl" in capsys.readouterr().err
    header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    header += "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
    header += "property list uchar int vertex_indices\nend_header\n"
    (tmp_path / "d.ply").write_text(header + "0 0 0 255 188 0\n1 0 0 255 188 0\n0 1 0 255 188 0\n3 0 1 2\n")
    assert np.allclose(load_solid(tmp_path / "d.ply")[1], [[1.0, 0.5029, 0.0]], atol=1e-3)
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box()
    material = trimesh.visual.material.PBRMaterial(baseColorFactor=[51, 102, 204, 255])
    box.visual = trimesh.visual.TextureVisuals(uv=np.zeros((len(box.vertices), 2)), material=material)
    box.export(tmp_path / "e.glb")
    assert np.allclose(load_solid(tmp_path / "e.glb")[1], [[0.2, 0.4, 0.8]], atol=0.01)


def test_the_stand_is_closed_and_the_cloth_lies_on_it():
    stand, colors = load_solid("stand")
    assert len(colors) == len(stand.triangles)
    p = stand.positions[stand.triangles].astype(float)
    N = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    assert (np.einsum("ij,ij->i", N, stand.normals[stand.triangles].mean(1)) > -1e-12).all()
    assert np.abs(N.sum(0)).max() < 1e-6  # nothing is open
    cloth = load_mesh("drape").positions.astype(float)
    centre, half, rounding = (np.array(v) for v in TABLE)
    q = np.abs(cloth - centre) - (half - rounding)
    table = np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(1), 0) - rounding
    ball = np.linalg.norm(cloth - BALL[0], axis=1) - BALL[1]
    for distance in (table, ball):
        assert 0.001 < distance.min() < 0.005 and (distance < 0.005).sum() > 500
    assert PLINTH < cloth[:, 1].min() < PLINTH + 0.005


def test_a_session_shares_objects_and_ground():
    """A command line of the window brings them back."""
    scene = load_scene("draped").changed(camera={}, ground=-1.5, objects=("stand", "sphere"))
    words = shlex.split(as_command(scene))
    assert words.count("--object=stand") == 1 and "--ground=-1.5" in words and "--ground-color=0.38,0.39,0.41" in words
    assert "stand" in as_python(scene) and load_scene("draped").objects[0] == "stand"


def test_a_ground_stays_while_the_cloth_moves(renderer):
    cloth = load_mesh("plane")
    moved = build_mesh("moved", cloth.positions - np.float32([0, 0.02, 0]), cloth.triangles, cloth.uv, cloth.normals)
    renderer.follow_poses()
    try:
        first, second = (renderer.prepare(mesh=mesh, ground="auto").objects for mesh in (cloth, moved))
    finally:
        renderer.follow_poses(False)
    assert second is first


@pytest.mark.parametrize("method", ["direct", "paper", "reference"])
def test_a_cloth_alone_is_the_same_to_the_bit_after_others_stood_about_it(renderer, method):
    scene = Scene(method=method, size=(40, 30), mesh="sphere", cube=4, grid=12)
    alone = renderer.render(scene)
    among = renderer.render(scene, ground="auto", objects=("plane",))
    assert not np.array_equal(among, alone)
    assert np.array_equal(renderer.render(scene), alone)


@pytest.mark.parametrize("half", [500, 5, 50_000])
def test_the_shadow_on_a_large_object_is_that_on_the_ground(renderer, tmp_path, half):
    """Two triangles of any size: they are cut where the cloth is near, without gaps or folds."""
    corners = "".join(f"v {x} -0.5 {z}\n" for x, z in ((-half, -half), (half, -half), (half, half), (-half, half)))
    (tmp_path / "floor.obj").write_text(corners + "f 1 4 3 2\n")
    cloth = sheet(8, size=0.4)
    mesh, source = graded(load_mesh(tmp_path / "floor.obj"), tuple(cloth.center.tolist()), cloth.radius)
    p = mesh.positions[mesh.triangles].astype(float)
    areas = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 1] / 2
    assert (areas > 0).all() and (len(mesh.positions) < 6000) and set(source) == {0, 1}
    if half < 5000 * cloth.radius:
        assert np.allclose(np.bincount(source, areas), 2 * half**2)
    edges = np.sort(np.concatenate([mesh.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), 1)
    edges_of, times = np.unique(edges, axis=0, return_counts=True)
    beside = np.abs(mesh.positions[edges_of[times == 1]].mean(1)[:, [0, 2]]).max(1)
    assert (times <= 2).all() and (beside > 0.99 * min(half, 5000 * cloth.radius)).all(), (
        "every edge within has two sides"
    )
    if half != 500:
        return
    light = dict(lights=MIXED, size=48)
    expected = seen(renderer, ground_color=(0.5, 0.5, 0.5), **light)[..., :3]
    got = seen(renderer, ground="off", objects=(str(tmp_path / "floor.obj"),), **light)[..., :3]
    assert np.abs(got - expected).mean() < 0.01 * expected.mean()
    assert np.abs(got - expected).max() < 0.1 * expected.max()
    assert expected.min() < 0.8 * np.median(expected), "there is a shadow"
