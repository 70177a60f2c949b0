"""The cloth simulation against statics, conservation laws and brute force; determinism bit for bit."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from glcloth.errors import InputError
from glcloth.geometry.shapes import grid_triangles
from glcloth.simulation.cloth import Cloth, ClothParameters, Wind
from glcloth.simulation.drape import surface_mesh
from glcloth.simulation.meeting import Meeting
from glcloth.simulation.solids import Box, Plane, Sphere
from glcloth.twins.constraint import solve_line
from glcloth.twins.contact import part
from glcloth.twins.wind import drag

G = 9.81


@pytest.fixture
def make(ctx):
    """Make cloths that are released after the test."""
    made = []

    def cloth(positions, colliders=(), pinned=None, wind=None, **parameters):
        spacing = (
            float(np.linalg.norm(positions[0, 1] - positions[0, 0])),
            float(np.linalg.norm(positions[1, 0] - positions[0, 0])),
        )
        made.append(
            Cloth(ctx, ClothParameters(**{"spacing": spacing} | parameters), positions, colliders, pinned, wind)
        )
        return made[-1]

    yield cloth
    for one in made:
        one.release()


def hanging(rows, columns, height=1.0, width=1.0):
    x, y = np.meshgrid(np.linspace(0, width, columns), np.linspace(0, -height, rows))
    return np.stack([x, y, np.zeros_like(x)], axis=-1)


def lying(rows, columns, size=1.0, y=0.0):
    x, z = np.meshgrid(np.linspace(-size / 2, size / 2, columns), np.linspace(-size / 2, size / 2, rows))
    return np.stack([x, np.full_like(x, y), z], axis=-1)


def top_row(positions):
    pinned = np.zeros(positions.shape[:2], bool)
    pinned[0] = True
    return pinned


def crossings(positions, triangles):
    """How many edges pass through triangles that they share no vertex with; an edge counts for each triangle."""
    return len(crossing_edges(positions, triangles))


def crossing_edges(positions, triangles):
    """The edges [N, 2] that pass through triangles that they share no vertex with, by brute force over near pairs."""
    edges = np.unique(
        np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), 1), axis=0
    )
    p = positions.astype(float)
    middle, center = p[edges].mean(axis=1), p[triangles].mean(axis=1)
    reach = np.linalg.norm(p[edges[:, 0]] - p[edges[:, 1]], axis=1).max() / 2
    reach += np.linalg.norm(p[triangles] - center[:, None], axis=2).max()
    e, t = cKDTree(middle).sparse_distance_matrix(cKDTree(center), reach, output_type="coo_matrix").coords
    apart = ~(triangles[t][:, :, None] == edges[e][:, None, :]).any(axis=(1, 2))
    e, t = e[apart], t[apart]
    origin, d = p[edges[e, 0]], p[edges[e, 1]] - p[edges[e, 0]]
    a, u, v = p[triangles[t, 0]], p[triangles[t, 1]] - p[triangles[t, 0]], p[triangles[t, 2]] - p[triangles[t, 0]]
    h = np.cross(d, v)
    determinant = np.sum(u * h, axis=1)
    f = 1 / np.where(np.abs(determinant) > 1e-18, determinant, np.inf)
    s = origin - a
    q = np.cross(s, u)
    b_1, b_2, along = f * np.sum(s * h, 1), f * np.sum(d * q, 1), f * np.sum(v * q, 1)
    inside = (b_1 >= 0) & (b_2 >= 0) & (b_1 + b_2 <= 1) & (along >= 0) & (along <= 1) & (f != 0)
    return edges[e[inside]]


def test_line_pass_is_the_exact_solution(make):
    """One dispatch of `lines` on a crumpled cloth against dense linear algebra, with pinned vertices among them."""
    rng = np.random.default_rng(0)
    flat = hanging(6, 20)
    pinned = np.zeros((6, 20), bool)
    pinned[0, :3], pinned[1, 9], pinned[2, -1], pinned[3] = True, True, True, True
    cloth = make(flat, pinned=pinned, bending=0.0)
    rest_u, rest_v = cloth.parameters.spacing
    for backward in (0, 1):
        for alpha_h2 in (0.0, 40.0):
            crumpled = (flat + rng.normal(scale=0.2 * rest_u, size=flat.shape)).astype(np.float32)
            for along, rest, (lines, count, line_stride, stride) in (
                ("rows", rest_u, (6, 20, 20, 1)),
                ("columns", rest_v, (20, 6, 1, 20)),
            ):
                cloth.set_state(crumpled)
                cloth._run(
                    "passes/simulation/lines.comp", lines, lines=lines, count=count, line_stride=line_stride,
                    stride=stride, backward=backward, rest=rest, stretch_h2=alpha_h2, bend_h2=1e30,
                )  # fmt: skip
                got = cloth.positions().astype(float)
                start, w = crumpled.astype(float), cloth.inverse_mass.astype(np.float32).astype(float)
                if along == "columns":
                    got, start, w = got.swapaxes(0, 1), start.swapaxes(0, 1), w.T
                for line in range(lines):
                    # A border line is half as wide, so its springs are half as stiff.
                    give = 2.0 if line in (0, lines - 1) else 1.0
                    expected = solve_line(start[line], w[line], rest, give * alpha_h2)
                    assert np.allclose(got[line], expected, atol=2e-4 * rest), (along, line, backward, alpha_h2)


@pytest.mark.parametrize("substeps", [5, 10])
def test_hanging_cloth_stretches_as_statics_say(make, substeps):
    """Tension at depth y below the pins is mass G (L - y), so the strain there is that over the stiffness."""
    positions = hanging(60, 30)
    cloth = make(positions, pinned=top_row(positions), substeps=substeps, mass=0.2, stretch=2000.0)
    for _ in range(90):
        cloth.step(1 / 60)
    length = np.linalg.norm(np.diff(cloth.positions().astype(float), axis=0), axis=2)
    strain = (length / cloth.parameters.spacing[1] - 1)[:, 10:20].mean(axis=1)
    below = 1.0 - (np.arange(59) + 0.5) / 59
    assert np.allclose(strain, 0.2 * G * below / 2000.0, atol=6e-5)
    assert np.abs(cloth.velocities()).max() < 5e-3, "it hangs still"
    assert np.array_equal(cloth.positions()[0], positions[0].astype(np.float32)), "pins hold exactly"


def test_free_fall_and_momentum(make):
    """Without air a thrown, crumpled cloth keeps its angular and linear momentum, and its centre falls as a stone."""
    rng = np.random.default_rng(1)
    positions = hanging(16, 16)
    cloth = make(positions, drag=(0.0, 0.0), damping=0.0, shear=0.0)
    start = positions + rng.normal(scale=0.003, size=positions.shape)
    velocity = np.array([1.0, 2.0, 0.0]) + np.cross([0.0, 3.0, 1.0], start - start.mean(axis=(0, 1)))
    cloth.set_state(start, velocity)
    m = (1 / cloth.inverse_mass)[..., None]
    begin_x, begin_v = cloth.positions().astype(float), cloth.velocities().astype(float)

    def centre(a):
        return (m * a).sum(axis=(0, 1)) / m.sum()

    def spin(x, v):
        return (m * np.cross(x - centre(x), v - centre(v))).sum(axis=(0, 1))

    for _ in range(30):
        cloth.step(1 / 60)
    x, v = cloth.positions().astype(float), cloth.velocities().astype(float)
    # Symplectic Euler falls half a substep further than the parabola.
    h = 1 / 600
    fall = centre(begin_v) * 0.5 + np.array([0, -G, 0]) * (0.5 * 0.5 * (0.5 + h))
    assert np.allclose(centre(x) - centre(begin_x), fall, atol=2e-4)
    assert np.allclose(centre(v), centre(begin_v) + np.array([0, -G * 0.5, 0]), atol=1e-3)
    assert np.allclose(spin(x, v), spin(begin_x, begin_v), rtol=0.02, atol=1e-4)


def test_bending_is_that_of_a_beam(make):
    """A strip clamped at one end sags as linear statics say, K y = f with the vector Laplacian's energy; and as a beam."""
    rows, columns, length = 3, 11, 0.1
    x, z = np.meshgrid(np.linspace(0, length, columns), np.linspace(0, 0.02, rows))
    pinned = np.zeros((rows, columns), bool)
    pinned[:, :2] = True
    D, sigma, cell = 2e-3, 0.2, length / (columns - 1)
    cloth = make(
        np.stack([x, np.zeros_like(x), z], axis=-1), pinned=pinned, bending=D, mass=sigma, substeps=200, damping=30.0,
        drag=(0.0, 0.0), shear=0.0, stretch=1e4,
    )  # fmt: skip
    for _ in range(40):
        cloth.step(1 / 60)
    sag = -cloth.positions()[:, :, 1].mean(axis=0)
    second = np.array([[1.0, -2.0, 1.0] @ np.eye(columns)[k : k + 3] for k in range(columns - 2)])
    K = D / cell**3 * second.T @ second
    f = np.full(columns, sigma * cell * G)
    f[[0, -1]] /= 2
    expected = np.zeros(columns)
    expected[2:] = np.linalg.solve(K[2:, 2:], f[2:])
    assert np.allclose(sag, expected, rtol=0.05, atol=2e-5)
    # The vertex at the clamp bends for half a cell on either side: the free length begins in the middle of the first cell.
    assert sag[-1] == pytest.approx(sigma * G * (length - cell / 2) ** 4 / (8 * D), rel=0.06)


def test_same_bits_in_every_run(make):
    """Bit for bit the same in two runs: contacts, friction and gusts included."""
    results = []
    for _ in range(2):
        positions = lying(40, 40, 0.6, 0.32)
        cloth = make(
            positions, (Plane((0, 1, 0)), Sphere((0.02, 0.15, 0.01), 0.12)), wind=Wind((1.0, 0.0, 0.5)),
            gap=1.1 * 0.6 / 39, substeps=12,
        )  # fmt: skip
        for _ in range(45):
            cloth.step(1 / 60)
        results.append((cloth.positions(), cloth.velocities()))
        assert cloth.contacts_lost() == 0
    assert np.array_equal(results[0][0], results[1][0]) and np.array_equal(results[0][1], results[1][1])


def test_solids_keep_the_cloth_out(make):
    """Every vertex stays `thickness` from the ground, the ball and the rounded table, every frame."""
    positions = lying(48, 48, 1.0, 0.55)
    ball, table, thickness = Sphere((0.1, 0.35, 0.0), 0.15), Box((0, 0.1, 0), (0.3, 0.1, 0.2), 0.02), 0.004
    cloth = make(
        positions, (Plane((0, 2, 0), 0.0), ball, table), thickness=thickness, gap=1.2 / 47, stretch=1e4, substeps=20
    )
    for _ in range(60):
        cloth.step(1 / 60)
        p = cloth.positions().astype(float)
        assert p[..., 1].min() >= thickness - 1e-3
        assert np.linalg.norm(p - ball.center, axis=-1).min() - ball.radius >= thickness - 1e-3
        inner = np.maximum(np.abs(p - table.center) - (np.array(table.half_size) - table.rounding), 0)
        assert np.linalg.norm(inner, axis=-1).min() - table.rounding >= thickness - 1e-3
    stretched = np.maximum(cloth.strain(), 0)
    assert np.percentile(stretched, 99.5) < 0.02 and stretched.max() < 0.05
    assert crossings(p.reshape(-1, 3), grid_triangles(48, 48)) == 0
    assert p[..., 1].max() > 0.45, "it lies on the ball"


def test_friction_holds_below_its_angle_and_slides_above(make):
    """On a slope of 20 degrees cloth rests if mu > tan 20 = 0.364; else it slides by g (sin - mu cos) t^2 / 2."""
    tilt = np.radians(20.0)
    normal = np.array([np.sin(tilt), np.cos(tilt), 0.0])
    down = np.array([np.cos(tilt), -np.sin(tilt), 0.0])
    flat = lying(12, 12, 0.3)
    positions = flat[..., :1] * down + flat[..., 2:] * [0, 0, 1.0] + normal * 0.003
    slid = {}
    for mu in (0.5, 0.2):
        cloth = make(positions, (Plane(tuple(normal), 0.0),), friction=mu, thickness=0.003, drag=(0, 0), damping=0.0)
        for _ in range(30):
            cloth.step(1 / 60)
        slid[mu] = float(np.mean((cloth.positions() - positions) @ down))
    assert abs(slid[0.5]) < 1e-4
    assert slid[0.2] == pytest.approx(0.5 * G * (np.sin(tilt) - 0.2 * np.cos(tilt)) * 0.25, rel=0.03)


def test_layers_do_not_pass_through_each_other(make):
    """A cloth folded in a loop by gravity over a bar: with self-contact nothing crosses, without it something does."""
    counts = {}
    for gap in (0.0, 1.05 / 39):
        x, y = np.meshgrid(np.linspace(0, 1, 40), np.linspace(0, 1.0, 40))
        # Standing on its hem with a slight wave, it collapses into a pile of folds.
        positions = np.stack([x - 0.5, y + 0.01, 0.01 * np.sin(9 * y) + 0.004 * np.sin(5 * x)], axis=-1)
        cloth = make(positions, (Plane((0, 1, 0)),), gap=gap, substeps=16)
        for _ in range(80):
            cloth.step(1 / 60)
        counts[gap] = crossings(cloth.positions().reshape(-1, 3), grid_triangles(40, 40))
    assert counts[0.0] > 20, "the case must be hard enough to fail without self-contact"
    assert counts[1.05 / 39] == 0


def test_near_lists_are_those_of_a_tree(make):
    """The hash finds exactly the pairs within reach that are not woven neighbours, sorted within each bucket."""
    rng = np.random.default_rng(4)
    positions = rng.uniform(0, 0.08, size=(20, 20, 3))
    cloth = make(hanging(20, 20), spacing=(0.0095, 0.0095), gap=0.01)
    cloth.set_state(positions)
    # The lists are made at the start of substeps whose number LIST_SUBSTEPS divides, as 0.
    cloth._contact()
    reach = cloth.LIST_REACH * 0.01
    near = np.frombuffer(cloth._buffers["Near"].read(), np.int32).reshape(400, -1)
    count = np.frombuffer(cloth._buffers["NearCount"].read(), np.int32)
    i, j = np.divmod(np.arange(400), 20)
    flat = positions.reshape(-1, 3).astype(np.float32)
    for vertex, expected in enumerate(cKDTree(flat).query_ball_point(flat, reach)):
        woven = (np.abs(i[expected] - i[vertex]) <= 1) & (np.abs(j[expected] - j[vertex]) <= 1)
        assert sorted(near[vertex, : count[vertex]]) == sorted(np.array(expected)[~woven]), vertex
    assert cloth.contacts_lost() == 0


def test_near_rows_are_those_of_a_tree(make):
    """Of its own row, and of the rows above and below, within the window: those that are no neighbours along the row."""
    positions = np.random.default_rng(5).uniform(0, 0.06, size=(9, 20, 3))
    flat = positions.reshape(-1, 3).astype(np.float32)
    i, j = np.divmod(np.arange(180), 20)
    for rows, apart, woven in ((0, 0.0, 1), (1, 0.025, 2)):
        cloth = make(
            hanging(9, 20), spacing=(0.0095, 0.0095), gap=0.012, contact_columns=7, contact_rows=rows, apart=apart
        )
        cloth.set_state(positions)
        cloth._contact()
        near = np.frombuffer(cloth._buffers["Near"].read(), np.int32).reshape(180, -1)
        count = np.frombuffer(cloth._buffers["NearCount"].read(), np.int32)
        for vertex, found in enumerate(cKDTree(flat).query_ball_point(flat, cloth.LIST_REACH * 0.012)):
            down, across = np.abs(i[found] - i[vertex]), np.abs(j[found] - j[vertex])
            expected = np.array(found)[(down <= rows) & (across <= 7) & (across > woven)]
            assert near[vertex, : count[vertex]].tolist() == expected[np.argsort(expected)].tolist(), vertex


def test_narrow_cells_close(make):
    """A layer falls on another of the same rows that is off by half a row: a gap of 1.4 columns lets it through, and so, nearly,
    does one of 1.2 half diagonals within the row alone."""
    u, v, half = 0.016, 0.056, 14
    j, i = np.meshgrid(np.arange(2 * half), np.arange(6))
    upper = j >= half
    x = np.where(upper, 2 * half - 1 - j + 0.5, j) * u
    folded = np.stack([x, np.where(upper, 0.045, 0.0), v * (i + 0.5 * upper)], axis=-1)
    fallen = {}
    for gap, rows in ((1.4 * u, 0), (1.2 * np.hypot(u, v) / 2, 0), (1.2 * np.hypot(u, v) / 2, 1)):
        cloth = make(
            folded, spacing=(u, v), pinned=~upper, shear=0.0, stretch=1.0, bending=0.0, drag=(0, 0), gap=gap, apart=gap,
            contact_columns=2 * half, contact_rows=rows, substeps=16,
        )  # fmt: skip
        for _ in range(5):
            cloth.step(1 / 40)
        fallen[gap > 1.5 * u, rows] = cloth.positions()[:5, half + 3 :, 1].min()
    assert fallen[False, 0] < -0.01 and fallen[True, 0] < fallen[True, 1]
    assert fallen[True, 1] > 0.01


def test_cloths_that_meet_push_each_other(ctx, make):
    """Each push is that of all pairs of vertices by brute force; a sheet that flies into a heavier one goes on with it, neither
    goes through, and the motion of both together stays; two runs are equal."""
    rng = np.random.default_rng(6)
    cloths = [make(hanging(6, 7), spacing=(0.02, 0.02), gap=0.02, mass=mass) for mass in (0.1, 0.3, 0.2)]
    meeting = Meeting(ctx, (cloths[:1], cloths[1:]), 0.02)
    x = [rng.uniform(0, 0.07, size=(6, 7, 3)).astype(np.float32) for _ in cloths]
    for cloth, here in zip(cloths, x, strict=True):
        cloth.set_state(here)
        cloth._buffers["Previous"].write(np.zeros((42, 4), np.float32))
    meeting.contacts(0.2)
    places, w = [p.reshape(-1, 3).astype(float) for p in x], [cloth.inverse_mass.reshape(-1) for cloth in cloths]
    for k, others in enumerate(([1, 2], [0], [0])):
        here, there = places[k], np.concatenate([places[n] for n in others])
        w_there = np.concatenate([w[n] for n in others])
        shape = 42, len(there)
        pushes = part(
            here[:, None], there[None], np.broadcast_to(w[k][:, None], shape), np.broadcast_to(w_there, shape), 0.02,
            here[:, None] - there[None], 0.2,
        )  # fmt: skip
        met = np.frombuffer(meeting._met[k].read(), np.float32).reshape(42, 4)
        near = np.linalg.norm(here[:, None] - there[None], axis=-1) < 0.02
        assert near.sum() > 40 and met[:, 3].tolist() == near.sum(1).tolist()
        np.testing.assert_allclose(met[:, :3], pushes.sum(1), atol=2e-6)
    meeting.release()

    def collide():
        flat = hanging(14, 14, 0.26, 0.26)
        still = {"gravity": (0, 0, 0), "damping": 0.0, "drag": (0, 0), "friction": 0.0, "gap": 0.0205}
        near = flat + np.array([0.01, 0.01, -0.06])
        sheets = [make(near, mass=0.1, **still), make(flat, mass=0.3, **still)]
        sheets[0].set_state(near, np.broadcast_to([0.0, 0.0, 2.0], flat.shape))
        meeting = Meeting(ctx, ([sheets[0]], [sheets[1]]), 0.0205)
        for _ in range(8):
            for _ in meeting.steps(0.01):
                pass
        meeting.release()
        return [(s.positions(), s.velocities(), s._masses()) for s in sheets]

    (x_1, v_1, m_1), (x_2, v_2, m_2) = collide()
    momentum = (m_1[..., None] * v_1).sum((0, 1)) + (m_2[..., None] * v_2).sum((0, 1))
    np.testing.assert_allclose(momentum / m_1.sum(), [0, 0, 2], atol=0.1)
    assert x_1[..., 2].max() < x_2[..., 2].min() + 0.02 and v_2[..., 2].mean() > 0.3
    both = np.concatenate([x_1, x_2]).reshape(-1, 3)
    assert crossings(both, np.concatenate([grid_triangles(14, 14), grid_triangles(14, 14) + 196])) == 0
    again = collide()
    assert all(np.array_equal(a, b) for a, b in zip((x_1, v_1), again[0][:2], strict=True))


def test_wind_pushes_with_the_drag_of_its_triangles(make):
    """The first velocities are h times the accelerations of the twin, a third of each triangle's force per corner."""
    rng = np.random.default_rng(3)
    flat = hanging(7, 9)
    cloth = make(
        flat, wind=Wind((2.0, 0.3, 1.0), gustiness=0.0), gravity=(0, 0, 0), damping=0.0, bending=0.0, shear=0.0,
        substeps=1, drag=(1.2, 0.1),
    )  # fmt: skip
    p = flat + rng.normal(scale=0.01, size=flat.shape)
    cloth.set_state(p)
    cloth._air(1e-4)
    got = np.frombuffer(cloth._buffers["Air"].read(), np.float32).reshape(-1, 4)[:, :3]
    p = p.reshape(-1, 3).astype(np.float32).astype(float)
    triangles = grid_triangles(7, 9)
    S = np.cross(p[triangles[:, 1]] - p[triangles[:, 0]], p[triangles[:, 2]] - p[triangles[:, 0]]) / 2
    count = len(triangles)
    F = drag(np.tile([2.0, 0.3, 1.0], (count, 1)), S, np.full(count, 1.2), np.full(count, 0.1))
    force = np.zeros_like(p)
    np.add.at(force, triangles.ravel(), np.repeat(F / 3, 3, axis=0))
    assert np.allclose(got, force * cloth.inverse_mass.reshape(-1, 1), rtol=1e-4, atol=1e-5)


def test_terminal_velocity(make):
    """A flat falling sheet reaches sqrt(2 sigma g / (rho C_n))."""
    cloth = make(lying(10, 10), mass=0.05, drag=(1.3, 0.0), damping=0.0, bending=1e-2)
    for _ in range(120):
        cloth.step(1 / 60)
    expected = np.sqrt(2 * 0.05 * G / (1.225 * 1.3))
    assert -cloth.velocities()[..., 1].mean() == pytest.approx(expected, rel=0.01)


def test_frames_of_a_known_surface(make):
    """Normals and yarn 1 of a cylinder laid out as a grid."""
    angle, y = np.meshgrid(np.linspace(-1, 1, 60), np.linspace(1, 0, 20))
    normal = np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=-1)
    cloth = make(normal + np.stack([0 * y, y, 0 * y], axis=-1))
    cloth.update_frames()
    assert np.sum(cloth.normals() * normal, axis=-1)[:, 1:-1].min() > 1 - 1e-6
    tangent = np.frombuffer(cloth.tangent_buffer.read(), np.float32).reshape(20, 60, 4)
    east = np.stack([np.cos(angle), np.zeros_like(angle), -np.sin(angle)], axis=-1)
    assert np.sum(tangent[..., :3] * east, axis=-1)[:, 1:-1].min() > 1 - 1e-6 and (tangent[..., 3] == 1).all()


def test_spline_surface_keeps_flat_cloth_flat_and_its_uvs():
    mesh = surface_mesh("flat", lying(20, 24, 0.8), (0.8, 0.8), 31, 37)
    assert len(mesh.positions) == 31 * 37 and np.allclose(mesh.normals, [0, 1, 0], atol=1e-6)
    assert np.allclose(mesh.positions[:, 0] + 0.4, mesh.uv[:, 0], atol=1e-6)
    assert np.allclose(0.4 - mesh.positions[:, 2], mesh.uv[:, 1], atol=1e-6)
    assert np.allclose(mesh.tangents, [1, 0, 0, 1], atol=1e-6)


def test_bad_input_is_one_line(make):
    flat = hanging(5, 5)
    for words, change in {
        "spacing": {"spacing": (0.0, 0.1)},
        "mass": {"mass": -1.0},
        "gap": {"gap": 0.01},
        "substeps": {"substeps": 0},
        "friction": {"friction": float("nan")},
    }.items():
        with pytest.raises(InputError, match=words):
            make(flat, **change)
    for solid, words in ((Sphere((0, 0, 0), 0.0), "radius"), (Box((0, 0, 0), (1, 1, 0.1), 0.2), "rounding"),
                         (Plane((0, 0, 0)), "normal")):  # fmt: skip
        with pytest.raises(InputError, match=words):
            make(flat, (solid,))
    with pytest.raises(InputError, match="finite"):
        make(np.where(flat == 0, np.nan, flat), spacing=(0.1, 0.1))
    with pytest.raises(InputError, match="shape"):
        make(flat[:2])
    with pytest.raises(InputError, match="time step"):
        make(flat).step(0.0)
