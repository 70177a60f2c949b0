"""The moving curtain: its pleats by geometry, its behaviour over seconds of wind, and what it may not do."""

from dataclasses import replace

import numpy as np
import pytest
from test_simulation import crossings

from glcloth.curtain.hanging import CurtainParameters, CurtainSimulation, pleated_rail
from glcloth.errors import InputError
from glcloth.geometry.shapes import grid_triangles
from glcloth.gpu.buffers import Buffer
from glcloth.simulation.cloth import Rail
from glcloth.simulation.solids import Plane


@pytest.fixture
def hang(ctx):
    made = []

    def curtain(**changes):
        made.append(CurtainSimulation(ctx, CurtainParameters(**changes)))
        return made[-1]

    yield curtain
    for one in made:
        one.release()


@pytest.mark.parametrize("fullness", [1.0, 1.2, 1.5, 1.8, 2.0, 2.5])
def test_pleats_have_the_fullness(fullness):
    """The polyline is as long as the cloth, in equal pieces; its ends lie at the ends of the rail."""
    m = CurtainParameters(fullness=fullness)
    rail = pleated_rail(m, m.quads[0] + 1)
    pieces = np.linalg.norm(np.diff(rail, axis=0), axis=1)
    assert pieces.sum() == pytest.approx(m.width * fullness, rel=1e-6)
    assert np.ptp(pieces) < 1e-5 * pieces.mean()
    assert rail[0, 0] == -m.width / 2 and rail[-1, 0] == m.width / 2 and (np.diff(rail[:, 0]) > 0).all()
    assert rail[:, 1].min() == pytest.approx(m.clearance)


@pytest.mark.parametrize(("fullness", "slope"), [(1.5, 0.262), (1.8, 0.355), (2.0, 0.414), (2.5, 0.554), (3.0, 0.689)])
def test_even_pleats_are_the_known_sine(fullness, slope):
    """Height over period of a sine wave with a given arc length; values from its elliptic integral."""
    m = CurtainParameters(fullness=fullness, irregularity=0.0, pleats=5, quads=(400, 10))
    z = pleated_rail(m, 401)[:, 1]
    assert (z.max() - z.min()) / 2 / (m.width / m.pleats) == pytest.approx(slope, rel=0.01)


def test_default_curtain_has_12640_triangles():
    assert CurtainParameters().triangle_count == 12_640
    for count in (2_000, 12_640, 50_000, 200_000):
        assert CurtainParameters().with_triangles(count).triangle_count == pytest.approx(count, rel=0.03)


def test_threads_under_rings_hold(hang):
    """A whole pleat hangs on the thread under its ring; none stretches over 5 %."""
    curtain = hang(heading="rings")
    longest = []
    for _ in range(36):
        curtain.step(1 / 24)
        longest.append(curtain.cloth.strain().max())
    assert max(longest) < 0.05


@pytest.mark.parametrize("wind", [0.5, 0.8])
def test_eight_seconds_of_wind(hang, wind):
    """No thread stretches over 5 %, window and floor hold, pins hold, and the cloth moves; pleats do not cross. (Two seconds
    where it is stronger.)"""
    curtain = hang(wind=wind)
    first = curtain.positions()
    spread = []
    seconds = 8 if wind == 0.5 else 2
    for frame in range(seconds * 30):
        curtain.step(1 / 30)
        if frame % 8 == 7:
            p = curtain.positions()
            assert np.isfinite(p).all()
            strain = curtain.cloth.strain()
            assert strain.max() < 0.05
            assert p[..., 2].min() > 0.009 and p[..., 1].min() > 0.009
            # In stronger wind the heading turns about its rail, and keeps its place along it.
            assert np.array_equal(p[0], first[0]) if wind == 0.5 else np.array_equal(p[0, :, 0], first[0, :, 0])
            spread.append(p[-1, :, 2].mean())
        if frame % 60 == 59:
            mesh = curtain.mesh()
            assert crossings(mesh.positions, mesh.triangles) == 0
    assert np.ptp(spread) > 0.05, "the hem should swing"
    assert curtain.time == pytest.approx(seconds) and curtain.cloth.contacts_lost() == 0


def test_strong_wind_crosses_nothing_and_costs_a_bounded_number_of_steps(hang):
    """At 3 m/s the cloth streams into the room: its heading turns with it, and it does not pass through itself; held still and
    without minding folds it did."""

    def crossed(curtain):
        total = 0
        for frame in range(14):
            curtain.step(1 / 24)
            if frame in (10, 13):
                mesh = curtain.mesh()
                total += crossings(mesh.positions, mesh.triangles)
        return total

    strong = {"wind": 3.0, "settle": 0.1}
    curtain = hang(**strong)
    assert crossed(curtain) == 0
    assert curtain.cloth.rail.angle > 0.5 and curtain.cloth.strain().max() < 0.06
    assert curtain.cloth.parameters.substeps == 4 * 288 / 24
    p = curtain.positions()[0]
    assert np.ptp(p[:, 1]) > 0.04 and p[:, 0].min() == pytest.approx(-1.25)
    held = hang(**strong)
    calm = hang(settle=0.0).cloth.parameters
    weak = {
        name: getattr(calm, name) for name in ("gap", "least_fold", "shear", "apart", "contact_columns", "contact_rows")
    }
    held.cloth.set_parameters(replace(held.cloth.parameters, **weak))
    held.cloth.rail.release()
    held.cloth.rail = None
    assert crossed(held) > 20


def test_narrow_folds_in_strong_wind(hang):
    """They keep a gap that closes their cells, from the rows above and below, too; contact stretches no thread far (without a
    bound for it 19 %), and nothing crosses."""
    curtain = hang(wind=3.0, heading="pencil", width=0.8, drop=1.2, settle=0.1, openness=0.1)
    m = curtain.cloth.parameters
    assert m.gap == m.apart == pytest.approx(1.2 * np.hypot(*m.spacing) / 2) and m.contact_rows == 1
    longest = []
    for _ in range(14):
        curtain.step(1 / 24)
        longest.append(curtain.cloth.strain().max())
    assert max(longest) < 0.12 and curtain.cloth.contacts_lost() == 0
    assert crossings(curtain.positions().reshape(-1, 3), grid_triangles(curtain.rows, curtain.columns)) == 0
    wide = hang(wind=3.0, settle=0.0).cloth.parameters
    assert wide.gap == pytest.approx(1.4 * wide.spacing[0]) and wide.contact_rows == 0


def test_calm_curtain_comes_to_rest(hang):
    """Without wind there is no jitter, and every thread is as long as statics say."""
    curtain = hang(wind=0.0, gustiness=0.0, settle=4.0)
    for _ in range(30):
        curtain.step(1 / 30)
    assert np.abs(curtain.cloth.velocities()).max() < 0.05, "no more than a slow sway is left"
    x = []
    for _ in range(3):
        curtain.step(1 / 60)
        x.append(curtain.positions().astype(float))
    assert np.abs(x[2] - 2 * x[1] + x[0]).max() < 1e-4
    # Tension of the cloth below, and of a hem as heavy as one more half row.
    m = curtain.parameters
    length = np.linalg.norm(np.diff(curtain.positions().astype(float), axis=0), axis=2)[:, 20:-20].mean(axis=1)
    below = m.drop * (1 - (np.arange(m.quads[1]) + 0.5) / m.quads[1]) + (m.hem - 1) * m.drop / m.quads[1] / 2
    assert np.allclose(length / (m.drop / m.quads[1]) - 1, m.mass * 9.81 * below / m.stretch, atol=1.5e-4)


def test_same_movement_every_time_and_in_any_frame_rate_nearly(hang):
    runs = []
    for rate in (60, 60, 30):
        curtain = hang(quads=(72, 20), pleats=6, settle=0.5)
        for _ in range(rate):
            curtain.step(1 / rate)
        runs.append(curtain.positions())
    assert np.array_equal(runs[0], runs[1])
    assert np.abs(runs[2] - runs[0]).mean() < 0.01, "only the air's force is renewed less often"


def test_wind_blows_into_the_room_and_the_window_stops_it(hang):
    deflection = {}
    for wind in (0.6, -0.6):
        curtain = hang(quads=(72, 20), pleats=6, wind=wind, gustiness=0.0)
        for _ in range(60):
            curtain.step(1 / 30)
        z = curtain.positions()[..., 2]
        deflection[wind] = z[-1].mean() - np.mean(curtain.positions()[0, :, 2])
        assert z.min() > 0.009
    assert deflection[0.6] > 0.03 and -0.2 < deflection[-0.6] < 0
    assert Plane((0.0, 0.0, 1.0), 0.0) in curtain.cloth.colliders


def test_stiff_cloth_takes_the_steps_that_it_needs_or_is_refused(hang):
    """Bending is solved once a substep; h^2 D / (mass cell^4) stays small, or one line says how stiff cloth may be."""
    rates = {}
    for bending in (3e-5, 1e-4, 9e-4):
        curtain = hang(bending=bending, settle=0.0)
        curtain.step(1 / 24)
        rates[bending] = curtain.cloth.parameters.substeps * 24
        cell = min(curtain.cloth.parameters.spacing)
        assert bending / rates[bending] ** 2 / (0.06 * cell**4) < 0.022
    assert rates[3e-5] == 288 < rates[1e-4] < rates[9e-4] <= 4 * 288
    for stiff in ({"bending": 2e-3}, {"bending": 5e-4, "quads": (316, 40)}):
        with pytest.raises(InputError, match=r"too soft beyond .*fewer quads") as caught:
            hang(**stiff, settle=0.0)
        assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="too soft"):
        curtain.change(CurtainParameters(bending=2e-3, settle=0.0))
    assert curtain.parameters.bending == 9e-4


def test_rings_hold_the_crests_only(hang):
    curtain = hang(heading="rings", wind=0.0, settle=1.0)
    pinned = curtain.cloth.inverse_mass[0] == 0
    assert curtain.parameters.pleats - 1 <= pinned.sum() <= curtain.parameters.pleats + 2
    top = curtain.positions()[0, :, 1]
    assert np.allclose(top[pinned], curtain.parameters.top) and top[~pinned].min() < curtain.parameters.top - 0.001


@pytest.mark.parametrize("heading", ["tape", "pencil", "eyelet", "rod"])
def test_headings_as_they_are_sold(hang, heading):
    """On a rod cloth stands above it and about it; narrow folds are narrow, eyelets' even; what is held stays."""
    from glcloth.curtain.hanging import ROD

    curtain = hang(heading=heading, width=1.0, drop=1.0, fullness=2.0, wind=0.5, settle=0.1)
    first = curtain.positions()
    curtain.step(1 / 24)
    m, p = curtain.parameters, curtain.positions()
    held = curtain.cloth.inverse_mass == 0
    on_rod = heading in ("eyelet", "rod")
    assert held[: 2 if on_rod else 1].all() == held.any() and held.sum() == held[: 2 if on_rod else 1].sum()
    assert np.array_equal(p[held], first[held]) and not np.array_equal(p, first)
    z, y = first[held][:, 2], first[held][:, 1]
    folds = np.count_nonzero(np.diff(np.sign(first[0, :, 2] - first[0, :, 2].mean()))) / 2
    assert (
        folds == pytest.approx(m.pleats, abs=1)
        and m.pleats == {"tape": 5, "pencil": 10, "eyelet": 6, "rod": 11}[heading]
    )
    assert (z.min() + z.max()) / 2 == pytest.approx(ROD, abs=1e-3) or not on_rod
    assert (y.min() < m.top + 0.025 < y.max()) == on_rod, "the built-in room's rod is 2.5 cm above the rail's height"
    depth = [np.ptp(part) for part in np.array_split(first[0, :, 2], 3)]
    assert heading not in ("eyelet", "tape") or (max(depth) < 1.05 * min(depth)) == (heading == "eyelet")


def test_frames_are_unit_and_face_the_room(hang):
    curtain = hang(quads=(72, 20), pleats=6)
    curtain.step(1 / 60)
    N = np.frombuffer(curtain.normal_buffer.read(), np.float32).reshape(21, 73, 4)[..., :3]
    x = np.frombuffer(curtain.tangent_buffer.read(), np.float32).reshape(21, 73, 4)[..., :3]
    assert np.allclose(np.linalg.norm(N, axis=-1), 1, atol=1e-5) and np.abs(np.sum(N * x, axis=-1)).max() < 1e-5
    assert N[..., 2].mean() > 0.3
    mesh = curtain.mesh()
    assert np.sum(mesh.tangents[:, :3] * x.reshape(-1, 3), axis=1).mean() > 0.99 and (mesh.tangents[:, 3] == 1).all()


@pytest.mark.parametrize(
    "change", [{"width": 0}, {"fullness": 9}, {"pleats": 40}, {"heading": "hooks"}, {"wind": float("nan")}, {"settle": -1},
               {"openness": 2}, {"quads": (4, 4)}, {"drop": -1}],
)  # fmt: skip
def test_bad_parameters_end_in_one_line(change):
    with pytest.raises(InputError) as caught:
        CurtainParameters().changed(**change)
    assert "\n" not in str(caught.value) and next(iter(change)) in str(caught.value)


def test_pleats_too_full_for_their_quads():
    with pytest.raises(InputError, match="too few"):
        pleated_rail(CurtainParameters(fullness=4.0), 159)


def test_a_heading_turns_the_shorter_way(ctx):
    """Cloth that is blown over its rail: from 3 rad on to -3 rad it is 0.28 rad, not 6."""
    rest = np.array([[[0.1 * k, 2.1 - 0.1 * row, 0.0] for k in range(3)] for row in range(2)], np.float32)
    rail = Rail(ctx, rest, 5)
    x = np.zeros((5, 3, 4), np.float32)
    x[:2, :, :3], x[2:, :, 1] = rest, 2.0
    x[rail.row, :, 1:3] = rail.axis[0] - np.cos(-3.0), rail.axis[1] + np.sin(-3.0)
    positions = Buffer(ctx, x)
    rail._heading.write(np.float32([3.0]))
    rail.turn({"Position": positions}, 0.1 / Rail.FASTEST)
    assert rail.angle == pytest.approx(3.1)
    rail.turn({"Position": positions}, 1.0)
    assert rail.angle == pytest.approx(2 * np.pi - 3.0, abs=1e-5)
    rail.release()
    positions.release()
