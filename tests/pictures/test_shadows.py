"""Shadows of `direct` and `paper`: bits against brute force, means against the twin, closed forms, coarse and fine meshes."""

import numpy as np
import pytest

from glcloth.accel.brute import Brute
from glcloth.accel.lbvh import Lbvh
from glcloth.accel.queries import RayQueries
from glcloth.accel.triangles import Triangles
from glcloth.fabric import builtin_fabrics, load_fabric
from glcloth.geometry import shapes
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.mesh_files import load_mesh
from glcloth.gpu.scene_buffers import SceneBuffers
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.methods.albedo import diffuse_albedo
from glcloth.picture.renderer import Renderer
from glcloth.twins import visibility as twin
from glcloth.twins.visibility import LEAST
from glcloth.visibility import vertices
from glcloth.visibility.furnace import Furnace
from glcloth.visibility.pixels import EDGE_RAYS, edge_layers
from glcloth.visibility.probes import LONGEST_EDGE, place_probes, subdivided
from glcloth.visibility.vertices import (
    BROAD_FLOOR,
    COSINE,
    FLAT,
    NEAREST_LAYER,
    VertexVisibility,
    broad_number,
    top_number,
)

BYTE = 0.5 / 255 + 1e-5
GAUSSIANS = SphericalGaussians(
    [[0, 1, 0], [0.6, 0.3, 0.7], [-1, 0.1, 0], [0, -1, 0.2]], [0.0, 4.0, 25.0, 200.0], np.ones((4, 3))
)
LIGHTS = Lights(GAUSSIANS)
NOTHING_BROAD = np.zeros(len(GAUSSIANS))


def sheet(n=8, height=0.0, size=1.0, name="sheet"):
    """A horizontal square about the y axis, N = +y."""
    x = np.linspace(-size, size, n + 1)
    positions = np.array([[a, height, b] for b in x for a in x])
    return build_mesh(name, positions, shapes.grid_triangles(n + 1, n + 1), positions[:, [0, 2]])


def joined(*meshes):
    """Several meshes as one."""
    firsts = np.cumsum([0, *(len(m.positions) for m in meshes)])
    return build_mesh(
        "joined",
        np.concatenate([m.positions for m in meshes]),
        np.concatenate([m.triangles + first for m, first in zip(meshes, firsts, strict=False)]),
        np.concatenate([m.uv for m in meshes]),
    )


def wavy(n=20):
    """A sheet in deep folds: both sides see a part of it."""
    mesh = sheet(n)
    positions = mesh.positions.astype(float)
    positions[:, 1] = 0.3 * np.sin(7 * positions[:, 0]) + 0.1 * np.cos(5 * positions[:, 2])
    return build_mesh("wavy", positions, mesh.triangles, positions[:, [0, 2]])


def seen_by(ctx, mesh, occluders=None, classes=1, lights=LIGHTS, broad=NOTHING_BROAD, sharp=False, steepness=FLAT):
    """The visibility of a mesh's vertices under lights: (VertexVisibility, values)."""
    triangles = Triangles.of(ctx, mesh.positions[mesh.triangles] if occluders is None else occluders)
    structure = Lbvh(ctx)
    structure.build(triangles)
    vertices = VertexVisibility(ctx, steepness)
    vertices.start(mesh, structure, classes=classes)
    for _ in vertices.steps(lights if sharp else None):
        pass
    vertices.integrate(lights, broad)
    return vertices, vertices.values()


# -- directions and weights, on plain arrays -----------------------------------------------------------------------------


def test_every_beginning_of_the_directions_is_spread_evenly():
    D = twin.world_directions(256)
    assert np.allclose(np.linalg.norm(D, axis=1), 1)
    assert sorted(twin.reversed_bits(np.arange(256), 8)) == list(range(256))
    for count in (16, 32, 64, 256):
        some = D[:count]
        # As many at random have a mean of about count^-1/2.
        assert np.linalg.norm(some.mean(0)) < (0.7 / np.sqrt(count) if count < 256 else 0.005)
        # Second moments of an even set are those of the sphere.
        assert np.abs(some.T @ some / count - np.eye(3) / 3).max() < 2 / count**0.75
    for first in range(0, 256, 32):  # the shares of eight classes
        assert np.linalg.norm(D[first : first + 32].mean(0)) < 0.13


def test_own_directions_have_the_mean_of_their_gaussian():
    for kappa in (30.0, 200.0, 1e4):
        axis = np.array([0.6, 0.0, 0.8])
        D = twin.own_directions(axis, kappa, 4096)
        assert np.allclose(np.linalg.norm(D, axis=1), 1)
        mean = 1 / np.tanh(kappa) - 1 / kappa  # E of omega . xi
        assert np.allclose(D.mean(0), mean * axis, atol=2e-3 / np.sqrt(kappa) + 1e-6)


def test_the_shares_of_the_parts_sum_to_one():
    omega = np.random.default_rng(0).normal(size=(100, 3))
    omega /= np.linalg.norm(omega, axis=1, keepdims=True)
    assert np.allclose(twin.band_shares(omega[:, 2]).sum(-1), 1)
    assert np.allclose(twin.quadrant_shares(omega).sum(-1), 1)
    assert np.allclose(twin.from_bands(omega, np.full((100, 4), 0.3), np.full((100, 4), 0.3), 0.3), 0.3)


# -- what vertices see ---------------------------------------------------------------------------------------------------


def test_bits_are_those_of_rays_that_meet_every_triangle(ctx):
    mesh = wavy(10)
    for classes in (1, 4):
        vertices, _ = seen_by(ctx, mesh, classes=classes)
        probes = vertices.probes
        brute, queries = Brute(ctx), RayQueries(ctx)
        brute.build(Triangles.of(ctx, mesh.positions[mesh.triangles]))
        offset = vertices._offset_between_layers().astype("f4")
        N, x = probes.normals.astype("f4"), probes.points.astype("f4")
        for c, bits in enumerate(vertices.bits()):
            D = vertices.class_directions()[c].astype("f4")
            mine = slice(*probes.first[c : c + 2])
            up = D @ N[mine].T >= 0
            off = np.where(up, offset[mine, 0], -offset[mine, 1])
            origins = x[mine] + off[..., None] * N[mine]
            hit = queries.any_hit(brute, origins, np.broadcast_to(D[:, None], origins.shape))
            wrong = hit.reshape(up.shape).T == bits
            # Rays along the sheet itself, and origins that round otherwise, may differ.
            assert wrong.mean() < 2e-3, (classes, c)
            assert 0.2 < bits.mean() < 0.95


@pytest.mark.parametrize(("steepness", "broad"), [(FLAT, NOTHING_BROAD), (COSINE, None)])
def test_means_are_those_of_the_twin(ctx, steepness, broad):
    vertices, values = seen_by(ctx, wavy(), steepness=steepness, broad=broad)
    D = vertices.directions
    table = twin.gaussian_table(D, GAUSSIANS.axis, GAUSSIANS.sharpness)
    expected = twin.mean_visibility(vertices.bits()[0], vertices.probes.normals, D, table, steepness)
    assert np.abs(values[..., :5] - expected).max() < BYTE + 1e-3


def test_four_classes_see_what_one_class_sees(ctx):
    mesh = wavy(40)
    one, four, eight = (seen_by(ctx, mesh, classes=classes)[1][..., :4] for classes in (1, 4, 8))
    # Where a Gaussian lights the other side only, there is nothing to compare.
    lit = np.concatenate([np.ones((len(mesh.positions), 1)), mesh.normals @ GAUSSIANS.axis[:3].T], 1) > 0.2
    for some, limit in ((four, 0.03), (eight, 0.06)):
        difference = (some - one)[:, 0]
        assert np.abs(difference[lit].mean()) < 0.01
        assert np.sqrt(np.square(difference[:, 0]).mean()) < limit
        assert np.sqrt(np.square(difference[lit]).mean()) < 2 * limit


def test_a_flat_sheet_hides_nothing_from_itself(ctx):
    for classes in (1, 2, 4, 8):
        _, values = seen_by(ctx, sheet(20), classes=classes)
        assert np.allclose(values, 1.0)


def test_inside_a_ball_nothing_is_seen_and_outside_everything(ctx):
    mesh = subdivided(load_mesh("sphere"))
    _, values = seen_by(ctx, mesh, classes=4)
    values = values[np.unique(mesh.triangles)]  # at the poles some corners belong to triangles without area
    assert values[:, 0, :5].min() > 0.985  # a facet's plane lies a little below its corners' horizon
    inside = values[:, 1, 0]
    assert inside.max() == 0.0


@pytest.mark.parametrize("classes", [1, 4])
def test_the_front_of_one_winding_is_the_back_of_the_other(ctx, classes):
    mesh = wavy()
    turned = build_mesh("turned", mesh.positions, mesh.triangles[:, ::-1], mesh.uv)
    assert np.allclose(turned.normals, -mesh.normals, atol=1e-6)
    a, b = (seen_by(ctx, m, classes=classes)[1] for m in (mesh, turned))
    assert np.abs(a - b[:, ::-1]).max() < 2 * BYTE


def test_half_of_the_sky_is_hidden_under_the_edge_of_a_roof(ctx):
    """A point straight below the straight edge of a half plane sees half of every mean that is even in x."""
    mesh = sheet(8)
    roof = np.array(
        [[[0, 0.2, -900], [0, 0.2, 900], [900, 0.2, 900]], [[0, 0.2, -900], [900, 0.2, 900], [900, 0.2, -900]]]
    )
    occluders = np.concatenate([mesh.positions[mesh.triangles], roof])
    lights = Lights(SphericalGaussians([[0, 1, 0], [0, 1, 0]], [2.0, 20.0], np.ones((2, 3))))
    _, values = seen_by(ctx, mesh, occluders, lights=lights, broad=np.zeros(2))
    below = np.abs(mesh.positions[:, 0]) < 1e-6
    assert below.sum() == 9
    # 256 directions in 128 pairs: the narrower the Gaussian, the fewer of them.
    assert np.abs(values[below, 0, 0] - 0.5).max() < 0.03
    assert np.abs(values[below, 0, 1] - 0.5).max() < 0.04
    assert np.abs(values[below, 0, 2] - 0.5).max() < 0.12
    assert np.allclose(values[below, 1], 1.0)


def test_a_wall_hides_the_quarter_that_it_covers(ctx):
    """Under uniform light of the flat weight a point at the foot of a wall sees half of its hemisphere."""
    mesh = sheet(8, size=0.01)
    wall = np.array(
        [
            [[0.0101, 0, -900], [0.0101, 900, 900], [0.0101, 0, 900]],
            [[0.0101, 0, -900], [0.0101, 900, -900], [0.0101, 900, 900]],
        ]
    )
    _, values = seen_by(ctx, mesh, np.concatenate([mesh.positions[mesh.triangles], wall]))
    at_wall = mesh.positions[:, 0] > 0.0099
    assert np.abs(values[at_wall, 0, 0] - 0.5).max() < 0.02


def test_a_gaussian_from_beyond_the_wall_is_hidden_and_from_before_it_is_seen(ctx):
    mesh = sheet(8, size=0.01)
    wall = np.array(
        [[[0.02, 0, -900], [0.02, 900, 900], [0.02, 0, 900]], [[0.02, 0, -900], [0.02, 900, -900], [0.02, 900, 900]]]
    )
    lights = Lights(SphericalGaussians([[0.9, 0.5, 0], [-0.9, 0.5, 0]], [100.0, 100.0], np.ones((2, 3))))
    for sharp in (False, True):
        _, values = seen_by(
            ctx,
            mesh,
            np.concatenate([mesh.positions[mesh.triangles], wall]),
            lights=lights,
            broad=np.zeros(2),
            sharp=sharp,
        )
        assert values[:, 0, 1].max() < 0.02
        assert values[:, 0, 2].min() > 0.98


def test_layers_closer_than_an_edge_do_not_leak(ctx):
    """Two sheets 1/20 of an edge apart: no ray starts beyond the other, and between them it is dark."""
    edge = 0.25
    for gap in (0.05 * edge, 0.02 * edge):
        mesh = joined(sheet(8), sheet(8, height=gap))
        vertices, values = seen_by(ctx, mesh)
        offset = vertices._offset_between_layers()
        low = mesh.positions[vertices.probes.vertices, 1] == 0
        assert offset[low, 0].max() <= NEAREST_LAYER * gap * 1.001
        assert offset[~low, 1].max() <= NEAREST_LAYER * gap * 1.001
        inner = np.abs(mesh.positions[:, [0, 2]]).max(1) < 0.8
        lower = mesh.positions[:, 1] == 0
        assert values[inner & lower, 0, 0].max() < 0.06
        assert values[inner & ~lower, 1, 0].max() < 0.06
        assert np.allclose(values[inner & lower, 1, 0], 1.0)


def test_broad_light_is_seen_in_parts(ctx):
    """The nine means are the twin's, and weighted by the light that they stand for they give about the mean of all."""
    lights = Lights(SphericalGaussians([[0.3, 0.9, 0.3]], [3.0], np.ones((1, 3))))
    vertices, values = seen_by(ctx, wavy(), lights=lights, broad=np.ones(1))
    first = broad_number(1)
    parts = values[..., [*range(first, first + 8), top_number(1)]]
    D, probes = vertices.directions, vertices.probes
    light = np.exp(3.0 * (D @ lights.gaussians.axis[0] - 1.0))
    light = (light + BROAD_FLOOR * light.mean()) / light.max()
    N, x = probes.normals, probes.tangents
    sums = twin.broad_sums(vertices.bits()[0], N, x[:, :3], x[:, 3], D, light)
    order = np.argsort(probes.vertices)
    seen, there = sums[order, :, 0], sums[order, :, 1]
    some = there > 5 * LEAST * light.sum()
    assert some.mean() > 0.6
    assert np.abs(parts - seen / np.maximum(there, 1e-9))[some].max() < 0.03
    V = np.zeros((len(N), len(D)))
    y = x[:, 3:] * np.cross(N, x[:, :3])
    omega = np.stack([axis @ D.T for axis in (x[:, :3], y, N)], -1)
    place = probes.vertices
    for n in range(len(N)):
        mine = parts[place[n], 0]
        V[n] = twin.from_bands(omega[n], mine[:4], mine[4:8], mine[8])
    w = twin.flat_weight(N @ D.T) * np.exp(3.0 * (D @ lights.gaussians.axis[0] - 1.0))
    mean = ((w * V).sum(1) / w.sum(1))[order]
    assert np.abs(mean - values[:, 0, 1]).max() < 0.08
    assert np.abs((mean - values[:, 0, 1]).mean()) < 0.015


# -- coarse and fine meshes ------------------------------------------------------------------------------------------------


def test_coarse_meshes_get_more_vertices_and_keep_their_surface():
    mesh = sheet(2)
    fine = subdivided(mesh)
    a, b, c = fine.positions[fine.triangles].transpose(1, 0, 2).astype(float)
    assert np.linalg.norm(b - a, axis=1).max() <= LONGEST_EDGE * mesh.radius
    assert np.isclose(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum(), 4.0)
    assert np.allclose(np.linalg.norm(fine.normals, axis=1), 1) and np.allclose(fine.normals, [0, 1, 0])
    assert np.allclose(fine.uv, fine.positions[:, [0, 2]], atol=1e-6)
    assert len(np.unique(fine.positions, axis=0)) == len(fine.positions)
    drape = load_mesh("drape")
    assert subdivided(drape) is drape
    assert len(subdivided(sheet(2), most=100).positions) <= 100
    one = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    copies = subdivided(build_mesh("copies", np.array(one), np.tile([[0, 1, 2]], (1000, 1))))
    assert len(copies.triangles) == len(subdivided(build_mesh("one", np.array(one), [[0, 1, 2]])).triangles) == 4096


def test_subdivided_curved_meshes_do_not_shade_themselves(ctx):
    """A coarse ball with smooth normals: its flat triangles lie below its horizon."""
    rows, columns = 8, 12
    theta, phi = np.linspace(0, np.pi, rows + 1)[1:-1], np.linspace(0, 2 * np.pi, columns, endpoint=False)
    ring = np.array([[np.sin(t) * np.cos(p), np.cos(t), np.sin(t) * np.sin(p)] for t in theta for p in phi])
    triangles = []
    for r in range(rows - 2):
        for k in range(columns):
            a, b = r * columns + k, r * columns + (k + 1) % columns
            triangles += [(a, b, b + columns), (a, b + columns, a + columns)]
    mesh = build_mesh("ball", ring, np.array(triangles), None, ring)
    if (mesh.normals * mesh.positions).sum(1).mean() < 0:
        mesh = build_mesh("ball", ring, np.array(triangles)[:, ::-1], None, ring)
    fine = subdivided(mesh)
    structure = Lbvh(ctx)
    structure.build(Triangles.of(ctx, mesh.positions[mesh.triangles]))
    worst = []
    for original in (fine, mesh):
        vertices = VertexVisibility(ctx)
        vertices.start(fine, structure, original)
        for _ in vertices.steps():
            pass
        vertices.integrate(LIGHTS, NOTHING_BROAD)
        worst.append(vertices.values()[:, 0, 0].mean())
    assert worst[1] > 0.998 > worst[0]


def test_many_vertices_are_decimated_and_keep_constants_and_places(ctx):
    mesh = sheet(60)
    probes = place_probes(mesh, most=1000, classes=4)
    assert 200 < len(probes.points) <= 1000
    sums = np.asarray(probes.spread.sum(1)).ravel()
    assert np.allclose(sums, np.round(sums)) and 0.999 < sums.min() and sums.max() < 4.001
    near = (probes.spread @ probes.points) / sums[:, None]
    assert np.linalg.norm(near - mesh.positions, axis=1).max() < 6 * 2 / 60
    counts = np.diff(probes.first)
    assert counts.min() > 0.8 * counts.max()


def test_most_vertices_know_all_directions():
    """Beside its own class a vertex has the others among its neighbours."""
    for classes in (2, 4, 8):
        probes = place_probes(load_mesh("drape"), classes=classes)
        known = np.round(np.asarray(probes.spread.sum(1)).ravel())
        assert (known == classes).mean() > (0.999 if classes < 8 else 0.97)


# -- suns, pictures --------------------------------------------------------------------------------------------------------

VIEW = Camera(eye=(0.0, 3.0, 1e-3), target=(0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), fov_deg=40)


def test_suns_cast_the_shadow_that_geometry_says(renderer):
    """A small square high above a large one, the sun at 45 degrees: the shadow is the square, moved by its height."""
    mesh = joined(sheet(10), sheet(4, height=0.5, size=0.2))
    suns = Lights(SphericalGaussians([], [], []), Suns([[-1, 1, 0]], [[3.0, 3.0, 3.0]]))
    scene = dict(fabric="linen", mesh=mesh, lights=suns, camera=VIEW, size=(96, 96), background=False)
    scene["bounce"] = False  # what hides the sun sends light into its shadow
    off, sun, full = (renderer.render(shadows=mode, **scene)[..., :3].sum(-1) for mode in ("off", "sun", "full"))
    dark = (sun == 0) & (off > 0)
    # The pixel of a point of the lower sheet: x right, z down.
    half = 3.0 * np.tan(np.radians(20))
    x, z = (np.arange(96) + 0.5) / 48 - 1, (np.arange(96) + 0.5) / 48 - 1
    X, Z = np.meshgrid(x * half, z * half)
    in_shadow = (np.abs(X - 0.5) < 0.2) & (np.abs(Z) < 0.2)
    margin = (np.abs(np.abs(X - 0.5) - 0.2) > 0.04) & (np.abs(np.abs(Z) - 0.2) > 0.04)
    upper = (np.abs(X) < 0.26) & (np.abs(Z) < 0.26)  # the square itself, nearer to the eye
    look = (off > 0) & ~upper & (np.abs(X - 0.5) < 0.3) & (np.abs(Z) < 0.3) & margin
    assert look.sum() > 100
    assert np.array_equal(dark[look], in_shadow[look])
    assert np.array_equal(sun[~dark], off[~dark])
    assert (full > 0).sum() == (sun > 0).sum()


@pytest.mark.parametrize("method", ["direct", "paper"])
def test_nothing_changes_where_nothing_hides(renderer, method):
    scene = dict(fabric="linen", mesh="plane", lights=LIGHTS, size=(48, 36), background=False, method=method)
    off, full = (renderer.render(shadows=mode, **scene) for mode in ("off", "full"))
    assert off[..., :3].max() > 0
    assert np.abs(full - off).max() < 2e-4 * off.max()


def test_what_lies_under_a_roof_is_dark(renderer):
    mesh = joined(sheet(20), sheet(20, height=0.02))
    lights = Lights(SphericalGaussians([[0, 1, 0], [0.3, 1, 0]], [1.0, 60.0], np.ones((2, 3))))
    below = Camera(eye=(0.0, -3.0, 1e-3), target=(0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), fov_deg=20)
    lit = Lights(SphericalGaussians([[0, -1, 0], [0.3, 1, 0]], [1.0, 60.0], np.ones((2, 3))))
    for method in ("direct", "paper"):
        scene = dict(fabric="linen", mesh=mesh, size=(32, 24), background=False, bounce=False, method=method)
        off = renderer.render(shadows="off", lights=lights, camera=VIEW, **scene)[..., :3].mean()
        top = renderer.render(shadows="full", lights=lights, camera=VIEW, **scene)[..., :3].mean()
        assert np.isclose(top, off, rtol=0.02)
        bottom = renderer.render(shadows="full", lights=lit, camera=below, **scene)[..., :3].mean()
        assert bottom > 0.1 * off
        # Seen from between: the inner sides get next to nothing.
        between = Camera(eye=(0.0, 0.01, 0.6), target=(0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0), fov_deg=4)
        dark = renderer.render(shadows="full", lights=lights, camera=between, **scene)[..., :3].mean()
        open_ = renderer.render(shadows="off", lights=lights, camera=between, **scene)[..., :3].mean()
        assert dark < 0.1 * open_


def test_a_preview_ends_in_the_same_picture(renderer):
    mesh = wavy()
    scene = dict(fabric="silk_crepe_de_chine", mesh=mesh, lights=LIGHTS, size=(48, 36), shadows="full")
    frame = renderer.prepare(**scene)
    for _ in renderer.steps(frame, preview=True):
        pass
    first = renderer.gbuffer.read()
    for _ in renderer.trace_visibility(frame, 16):
        pass
    for _ in renderer.steps(frame):
        pass
    late = renderer.gbuffer.read()
    assert np.array_equal(Renderer(ctx=renderer.ctx).render_frame(frame), late[..., :3])
    assert 0 < np.abs(first - late).mean() < 0.1 * late.mean()


def test_pixels_send_rays_into_narrow_gaussians_where_vertices_do_not_agree(renderer):
    """What pixels at the edge of a shadow see is counted by rays; what they shade is darkest in the middle of it."""
    mesh = joined(sheet(10), sheet(4, height=0.5, size=0.3))
    gaussians = SphericalGaussians([[-0.6, 0.8, 0.0], [0, 1, 0]], [600.0, 2.0], np.ones((2, 3)))
    scene = dict(fabric="linen", mesh=mesh, lights=Lights(gaussians), camera=VIEW, size=(48, 48), background=False)
    frame = renderer.prepare(shadows="full", **scene)

    def seen():
        view = renderer.target.part(renderer.stage.cloths[0]).view
        layers = np.frombuffer(view.seen.read(), "u1").reshape(-1, 48, 48, 4)
        return layers[0, ..., 1] / 255.0, layers[0, ..., 2] / 255.0

    for _ in renderer.trace_visibility(frame):
        pass
    for _ in renderer.steps(frame, preview=True):
        pass
    (by_vertices, broad), buffer = seen(), renderer.gbuffer
    for _ in renderer.steps(frame, rows=lambda: 8):
        pass
    by_pixels, broad_too = seen()
    assert np.array_equal(broad, broad_too)
    N, p = (np.frombuffer(frame.read(), "f4").reshape(48, 48, 4) for frame in map(buffer.frame, ("frame_N", "frame_p")))
    D = twin.own_directions(gaussians.axis[0], 600.0, EDGE_RAYS)
    origins = np.repeat(p[..., None, :3], len(D), 2)
    hit = RayQueries(renderer.ctx).any_hit(renderer.stage.occluders(frame), origins, np.broadcast_to(D, origins.shape))
    exact = 1.0 - hit.reshape(48, 48, -1).mean(-1)
    covered = N[..., 3] != 0
    changed = covered & (by_pixels != by_vertices)
    assert 50 < changed.sum() < 0.3 * covered.sum()
    assert ((exact > 0.1) & (exact < 0.9) & covered).sum() > 20
    # A ray that grazes the square's edge may round otherwise.
    assert np.percentile(np.abs(by_pixels - exact)[changed], 95) < 0.1
    assert np.abs(by_pixels - exact)[covered].mean() < 0.25 * np.abs(by_vertices - exact)[covered].mean()
    late = renderer.gbuffer.read()
    assert np.array_equal(Renderer(ctx=renderer.ctx).render_frame(frame), late)


def test_samples_of_a_pixel_share_the_rays_into_narrow_gaussians():
    seen = []
    for spp, each in ((1, 16), (2, 8), (8, 4)):
        for n in range(spp):
            layers, directions = edge_layers(GAUSSIANS, (n, spp))
            assert layers == [(1, (0, -1, -1, -1))] and directions.shape == (1, each, 3)
            seen.append(directions[0])
    assert np.allclose(np.sort(seen[0], 0), np.sort(np.concatenate(seen[1:3]), 0))
    axis = GAUSSIANS.axis[3]
    assert all(np.diff(some @ axis).min() > 0 for some in seen)  # from the outside in


def test_albedo_is_that_of_the_white_furnace(ctx):
    furnace, scene_buffers = Furnace(ctx), SceneBuffers(ctx)
    for name in builtin_fabrics():
        fabric = load_fabric(name)
        if not fabric.tangents:
            continue
        scene_buffers.prepare(fabric)
        assert np.allclose(furnace.albedo(scene_buffers), diffuse_albedo(fabric), rtol=0.05, atol=0.004), name


def test_adaptive_rate_sees_the_shadows(renderer):
    mesh = joined(sheet(10), sheet(4, height=0.5, size=0.2))
    lights = Lights(GAUSSIANS, Suns([[-1, 1, 0]], [[3.0, 3.0, 3.0]]))
    scene = dict(fabric="linen", mesh=mesh, lights=lights, camera=VIEW, size=(96, 96), shadows="full", background=False)
    full, adaptive = (renderer.render(adaptive=mode, **scene)[..., :3] for mode in (False, True))
    assert np.abs(full - adaptive).mean() < 0.005 * full.mean()
    assert np.abs(full - adaptive).max() < 0.1 * full.max()


def test_cloth_that_moves_is_followed_and_a_cut_is_seen(renderer):
    """The share of the directions that is traced at a pose is the present one's; at rest all are after four."""
    rest = wavy(40)

    def pose(i):
        positions = (
            rest.positions.astype(float) + [0.01 * i, 0, 0] + 0.004 * i * np.cos(3 * rest.positions[:, [2, 0, 1]])
        )
        return build_mesh("pose", positions, rest.triangles, rest.uv)

    scene = dict(fabric="linen", lights=Lights(GAUSSIANS), size=(64, 48), background=False, camera=VIEW)
    last = pose(6)
    truth = renderer.render(mesh=last, **scene)
    stale = renderer.render(mesh=pose(0), **scene)
    renderer.follow_poses()
    try:
        for i in range(6):
            renderer.render(mesh=pose(i), **scene)
        moving = renderer.render(mesh=last, **scene)
        vertices = renderer.stage.cloths[0].visibility.vertices
        assert vertices.classes == 8 and vertices.complete
        bits = np.concatenate(vertices.bits())
        for _ in range(4):  # the same pose, again and again
            last = build_mesh("pose", last.positions, last.triangles, last.uv)
            renderer.render(mesh=last, **scene)
        assert 0 < (np.concatenate(vertices.bits()) != bits).mean() < 0.05
        still = np.concatenate(vertices.bits())
        far = build_mesh("far", last.positions + 5.0, last.triangles, last.uv)
        probes = vertices.probes
        renderer.render(mesh=far, **scene)
        assert vertices.probes is not probes and vertices.complete
        far_bits = np.concatenate(vertices.bits())
        assert (far_bits != still).mean() < 0.01  # a moved cloth sees itself as before
    finally:
        renderer.follow_poses(False)
    error = np.abs(moving - truth).mean() / truth.mean()
    assert error < 0.03 and np.abs(stale - truth).mean() > 2 * error * truth.mean()


def test_suns_do_not_draw_the_facets_of_a_coarse_ball(renderer):
    """The horizon of the sun is that of the smooth normals: with shadows the picture is the one without."""
    x, triangles, uv, N = shapes.sphere(1.0, 8, 12)
    mesh = build_mesh("ball", x, triangles, uv, N)
    assert len(subdivided(mesh).positions) > 4 * len(x)
    suns = Lights(SphericalGaussians([], [], []), Suns([[1, 0.5, 0.3]], [[3.0, 3.0, 3.0]]))
    scene = dict(fabric="linen", mesh=mesh, lights=suns, size=(80, 60), background=False)
    off, full = (renderer.render(shadows=mode, **scene)[..., :3].sum(-1) for mode in ("off", "full"))
    assert (np.abs(full - off) > 0.02 * off.max()).sum() <= 0.005 * (off > 0).sum()


def test_a_first_impression_under_turned_lights_traces_nothing(renderer):
    """What the vertices see does not turn; only narrow Gaussians are looked at anew, and those can wait."""
    scene = {"mesh": "sphere", "env": "studio", "size": (16, 12)}
    renderer.render(**scene)
    frame = renderer.prepare(**scene, env_rotate=40.0)
    assert list(renderer.trace_visibility(frame, 4, enough=16)) == []
    assert list(renderer.trace_visibility(frame, 4)), "narrow Gaussians"


def test_what_vertices_see_is_found_on_disk_by_the_next_process(ctx, monkeypatch, tmp_path):
    """The fixed directions with the vertices they end at, and those of narrow Gaussians: the same bits, and nothing traced."""
    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path))
    monkeypatch.setattr(vertices, "WORTH_LOOKING", 1)
    monkeypatch.setattr(vertices, "WORTH_KEEPING", -1.0)
    traced, trace = [], vertices.VertexVisibility._trace
    monkeypatch.setattr(
        vertices.VertexVisibility, "_trace", lambda self, *part: traced.append(part) or trace(self, *part)
    )
    narrow = SphericalGaussians([[0.3, 1, 0.2], [0, 1, 0]], [60.0, 2.0], [[3.0, 3.0, 3.0], [1.0, 1.0, 1.0]])
    cloth, other = wavy(8), sheet(4)
    common = {"fabric": "linen", "mesh": cloth, "lights": narrow, "size": (32, 24)}

    def drawn(**changes):
        traced.clear()
        return Renderer(ctx=ctx).render(**{**common, **changes}), len(traced)

    first, count = drawn()
    again, none = drawn()
    assert count > 4 and none == 0
    np.testing.assert_array_equal(first, again)
    # Nor after a larger mesh, of which buffers keep something.
    with Renderer(ctx=ctx) as session:
        session.render(**{**common, "mesh": wavy(12)})
        traced.clear()
        np.testing.assert_array_equal(session.render(**common), first)
        assert not traced
    # Other lights have narrow directions of their own, another mesh everything.
    turned = SphericalGaussians(narrow.axis[:, [2, 1, 0]], narrow.sharpness, narrow.amplitude)
    assert 0 < drawn(lights=turned)[1] < count
    assert drawn(mesh=other)[1] > 4
    # A damaged file is as none.
    for file in (tmp_path / "visibility").iterdir():
        file.write_bytes(file.read_bytes()[:-40])
    again, some = drawn()
    assert 0 < some
    np.testing.assert_array_equal(first, again)
