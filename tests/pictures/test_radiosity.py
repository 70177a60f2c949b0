"""Light around the curtain's room: form factors against closed forms, bounces against a furnace and photons, pictures."""

import dataclasses
import pickle

import moderngl
import numpy as np
import pytest

from glcloth.accel.queries import RayQueries
from glcloth.accel.structure import make_structure
from glcloth.accel.triangles import Triangles
from glcloth.curtain.charts import OPEN, make_charts
from glcloth.curtain.form_factors import CELLS, FormFactors, Sheet, factor_steps
from glcloth.curtain.room import Room, box, inside_out
from glcloth.curtain.show import CurtainShow
from glcloth.errors import InputError
from glcloth.fabric import load_fabric
from glcloth.gpu.buffers import Buffer, TextureBuffer
from glcloth.gpu.programs import programs
from glcloth.gpu.tally import counting
from glcloth.light.environment import Environment
from glcloth.scene import CurtainParameters, Scene
from glcloth.twins.form_factor import lean_weights, quad_factor
from glcloth.twins.random import cosine_direction

FAR = Sheet(-0.1, 50.0, 0.1, 50.1, 99.0)  # a curtain that hides nothing
CURTAIN = CurtainParameters(quads=(48, 12), pleats=4, settle=0.2)
SMALL = Scene(size=(40, 40), curtain=CURTAIN, gi="radiosity", room="")
DARK = Environment("dark", np.full((4, 8, 3), 1e-9, np.float32))


def triangles_of(quads):
    """[T, 3, 3] of quads."""
    corners = np.array([corners for _, corners in quads])
    return np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]], 1).reshape(-1, 3, 3).astype(np.float32)


def factors_of(ctx: moderngl.Context, positions, cell=None, sheet=FAR) -> FormFactors:
    """Form factors of triangles."""
    triangles = Triangles.of(ctx, positions, 1)
    structure = make_structure(ctx, "kdtree")
    structure.build(triangles)
    *_, factors = factor_steps(ctx, positions, structure, sheet, cell)
    structure.release()
    triangles.release()
    return factors


def test_closed_forms():
    """From the middle of a face to a parallel and to a perpendicular unit square; integrated, Hottel's 0.1998 and 0.2000."""
    n = np.array([0.0, 0.0, 1.0])
    g = (np.arange(24) + 0.5) / 24
    x, y = (a.ravel() for a in np.meshgrid(g, g))
    points = np.stack([x, y, 0 * x], 1)
    above = [np.array(c, float) - points for c in ((0, 0, 1), (0, 1, 1), (1, 1, 1), (1, 0, 1))]
    assert quad_factor(*above, n).mean() == pytest.approx(0.19982, abs=5e-4)
    wall = [np.array(c, float) - points for c in ((0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1))]
    assert quad_factor(*wall, n).mean() == pytest.approx(0.20004, abs=2e-3)
    whole = [np.array(c, float) for c in ((-1e5, -1e5, 1), (-1e5, 1e5, 1), (1e5, 1e5, 1), (1e5, -1e5, 1))]
    assert quad_factor(*whole, n) == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("over", [False, True], ids=["from within", "turned over"])
def test_a_closed_room(ctx, over):
    """Rows sum to 1, patches are reciprocal, and a furnace of rho 1/2 doubles the light; whichever way the faces are wound."""
    quads = inside_out(box("grey", (0, 0, 0), (2, 1.5, 1)))
    positions = triangles_of(quads)
    f = factors_of(ctx, positions[:, ::-1].copy() if over else positions, 0.2)
    charts = f.charts
    P = len(charts.patches)
    F = f.factors[:P, : len(charts.positions)].T.astype(float)
    assert len(f.openings) == 0 and not charts.halves.any()
    np.testing.assert_allclose(F.sum(1), 1.0, atol=0.02)
    mean = np.zeros((P, len(F)))
    mean[charts.patch_of, np.arange(len(F))] = charts.area
    area = mean.sum(1)
    exchange = mean @ F  # A_i F_ij
    assert area.sum() == pytest.approx(2 * (3 + 2 + 1.5))
    large = exchange > 0.02 * area[:, None]
    np.testing.assert_allclose(exchange[large], exchange.T[large], rtol=0.1)
    B = np.linalg.solve(np.eye(P) - 0.5 * exchange / area[:, None], np.ones(P))
    np.testing.assert_allclose(B, 2.0, rtol=0.01)


def test_lone_triangles_make_a_room_too(ctx):
    """A tetrahedron, no two of whose triangles make a parallelogram: elements cover it, rows sum to 1."""
    v = np.array([[0, 0, 0], [2, 0, 0], [0.3, 2, 0], [0.6, 0.7, 1.6]], np.float32)
    f = factors_of(ctx, v[np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]])], 0.15)
    N = len(f.charts.positions)
    sides = f.charts.u, f.charts.v
    assert f.charts.halves.all()
    assert f.charts.area.sum() == pytest.approx(0.5 * np.linalg.norm(np.cross(*sides), axis=1).sum())
    sums = f.factors[: len(f.charts.patches), :N].sum(0)
    assert np.average(sums, weights=f.charts.area) == pytest.approx(1.0, abs=0.02)
    source, weight = f.charts.texels(np.ones(N))
    np.testing.assert_allclose(weight.sum(1), 1.0)
    assert source.max() < N


def test_what_has_no_area_is_no_part_of_a_room(ctx):
    """A quad that is a line, one that is a point and a lone line among others change nothing; a room of such alone is
    refused."""
    quads = inside_out(box("grey", (0, 0, 0), (2, 1.5, 1)))
    line = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 0], [0, 0, 0]], float)
    plain = triangles_of(quads)
    flat = triangles_of([*quads[:3], ("grey", line), ("grey", 0 * line + 0.5), *quads[3:]])
    flat = np.concatenate([flat, np.linspace(0, 1, 9).reshape(1, 3, 3)[:, :, [0, 0, 0]].astype("f4")])
    charts = make_charts(flat, 0.3)
    for name in ("origin", "u", "v", "positions", "patches"):
        np.testing.assert_array_equal(getattr(charts, name), getattr(make_charts(plain, 0.3), name))
    assert np.isfinite(charts.records()).all()
    np.testing.assert_array_equal(factors_of(ctx, flat, 0.3).factors, factors_of(ctx, plain, 0.3).factors)
    with pytest.raises(InputError, match="no triangle has an area"):
        make_charts(flat[6:10])


def test_factors_of_a_sheet_that_leans(ctx):
    """A wall behind it sees more of its back; a part of a factor may cross it; between known leans factors are interpolated."""
    room = inside_out(box("grey", (-1, 0, 0), (1, 2, 2)))
    f = factors_of(ctx, triangles_of(room), 0.25, Sheet(-0.6, 0.4, 0.6, 1.8, 0.2))
    x, n = f.charts.positions, f.charts.normals
    P, N = len(f.charts.patches), len(x)
    beside = (n[:, 2] > 0.9) & (np.abs(x[:, 0]) > 0.7) & (x[:, 1] < 1)
    back = [F[CELLS:].sum(0)[beside].mean() for F in (f.factors[P : P + 2 * CELLS, :N], *f.leaning)]
    assert (np.diff(back) > 0).all() and back[0] > 0
    share = f.crossing()
    assert share.min() == 0 and share.max() == 1 and ((share > 0) & (share < 1)).any()
    # From the middle of the wall behind all ways to the wall opposite cross it, and none from beside.
    opposite = (f.charts.patches[..., 2] > 1.99).all(1)
    middle = (n[:, 2] > 0.9) & (np.hypot(x[:, 0], x[:, 1] - 1) < 0.2)
    assert middle.any() and (share[:P][opposite][:, middle] == 1).all()
    assert (f.crossing(3)[:P][:, beside] != share[:P][:, beside]).any()
    wide = Sheet(-0.6, 0.4, 0.6, 1.8, 0.2, flare=0.1).nodes(0.25)
    np.testing.assert_allclose(wide[0, [0, -1]], [[-0.74, 0.4, 0.55], [0.74, 0.4, 0.55]], atol=1e-6)
    np.testing.assert_allclose(wide[-1, [0, -1]], [[-0.6, 1.8, 0.2], [0.6, 1.8, 0.2]], atol=1e-6)
    for lean, known in zip((0.0, 0.1, 0.25, 0.5), np.eye(4), strict=True):
        np.testing.assert_allclose(lean_weights(lean), known, atol=1e-12)
    assert lean_weights(0.17) @ np.array([0.0, 0.01, 0.0625, 0.25]) == pytest.approx(0.17**2)


def test_each_column_leans_as_it_hangs(ctx):
    """The weights that the passes read are those of a line through where its samples are now."""
    with CurtainShow(ctx, SMALL.changed(curtain=CURTAIN.changed(wind=1.0))) as one:
        rest, _ = one.simulation.positions().copy(), one.picture()
        one.advance(12)
        _, E = lit(one)
        light = one.radiosity
        leans = np.frombuffer(light._buffers["leans"].read(16 * 13), np.float32).reshape(13, 4)
        moved = one.simulation.positions()
        chosen, columns = (
            np.concatenate(light._cell_triangles),
            np.repeat(np.arange(CELLS) % 12, list(map(len, light._cell_triangles))),
        )
        before, after = (
            np.stack([p[:-1, :-1], p[:-1, 1:], p[1:, :-1], p[1:, 1:]], 2).reshape(-1, 4, 3) for p in (rest, moved)
        )
        quads = np.stack(
            [np.stack([q[:, [0, 2, 1]], q[:, [1, 2, 3]]], 1).reshape(-1, 3, 3).mean(1) for q in (before, after)]
        )
        below, off = light.factors.sheet.y_1 - quads[0, chosen, 1], (quads[1] - quads[0])[chosen, 2]
        for column in range(12):
            own = columns == column
            slope = (below[own] * off[own]).sum() / (below[own] ** 2).sum()
            np.testing.assert_allclose(leans[column], lean_weights(slope), atol=5e-3)
            assert slope > 0.02
        np.testing.assert_allclose(leans[12], leans[:12].mean(0), atol=1e-5)
        assert np.isfinite(E).all()


def test_light_of_a_leaning_sheet(ctx):
    """The passes add what the sheet's cells send at its columns' leans, and take away what crosses it there besides."""
    rng = np.random.default_rng(4)
    N, P, across, cells = 7, 5, 3, 6
    leans, sent = rng.random((across, 4)), rng.random((P + 2 * cells, 4))
    signed, changes = rng.normal(size=(cells, N, 4)), rng.normal(size=(2 * cells, P, 4))
    shares, before = rng.random((P + 2 * cells, 4)), 20.0 + rng.random((N, 4))
    number = np.array([2, 0, 3, 1, 0, 1, 2])
    who, column = rng.integers(0, P, number.sum()), rng.integers(0, across, number.sum())
    more, passes = rng.normal(size=(number.sum(), 3)), np.array([0.2, 0.5, 0.7])
    lists = np.stack([np.cumsum(number) - number, number], 1).astype(np.uint32)
    given = {
        "cells": signed, "leans": leans, "sent": sent, "changes": changes, "shares": shares,
        "crossing": np.column_stack([more, 16 * who + column]),
    }  # fmt: skip
    texels = {name: TextureBuffer(ctx, values.astype(np.float32)) for name, values in given.items()}
    texels["lists"] = TextureBuffer(ctx, lists, "rg32ui")
    received, leaning = Buffer(ctx, before.astype(np.float32)), Buffer(ctx, 16 * len(sent))
    programs(ctx).compute("passes/curtain/leaning_light.comp").run(
        -(-N // 4), **{k: texels[k] for k in ("cells", "leans", "sent", "lists", "crossing")}, Received=received,
        element_count=N, patch_count=P, cell_count=cells, across=across, passes=tuple(passes),
    )  # fmt: skip
    programs(ctx).compute("passes/curtain/leaning_sent.comp").run(
        len(sent), **{k: texels[k] for k in ("sent", "changes", "leans", "shares")}, Leaning=leaning, patch_count=P,
        cell_count=2 * cells, across=across, sender_count=len(sent),
    )  # fmt: skip
    wanted = before[:, :3].copy()
    for k in range(cells):
        for side, F in enumerate((signed[k], -signed[k])):
            wanted += (np.maximum(F, 0.0) @ leans[k % across])[:, None] * sent[P + side * cells + k, :3]
    lost = (more * leans[column, 1:]).sum(1)[:, None] * sent[who, :3] * (1.0 - passes)
    np.subtract.at(wanted, np.repeat(np.arange(N), number), lost)
    found = np.frombuffer(received.read(16 * N), np.float32).reshape(N, 4)
    np.testing.assert_allclose(found[:, :3], wanted, rtol=1e-5)
    again = sent[:, :3].copy()
    seen = np.stack([changes[k] @ leans[k % across] for k in range(2 * cells)])
    again[:P] = np.maximum(again[:P] + shares[:P, :3] * (seen.T @ sent[P:, :3]), 0.0)
    found = np.frombuffer(leaning.read(16 * len(sent)), np.float32).reshape(-1, 4)
    np.testing.assert_allclose(found[:, :3], again, rtol=1e-4, atol=1e-5)
    for buffer in (*texels.values(), received, leaning):
        buffer.release()


def test_a_pair_has_a_gap(ctx):
    """Between its pieces no cell is seen, and nothing crosses."""
    f = factors_of(
        ctx,
        triangles_of(inside_out(box("grey", (-1, 0, 0), (1, 2, 2)))),
        0.25,
        Sheet(-0.8, 0.2, 0.8, 1.8, 0.3, gap=0.8),
    )
    P, N = len(f.charts.patches), len(f.charts.positions)
    cells, nodes = f.factors[P : P + 2 * CELLS, :N].sum(1) > 0, f.sheet.nodes()[0, :, 0]
    np.testing.assert_array_equal(cells, np.tile(f.sheet.cloth, 2))
    assert f.sheet.cloth.sum() == 80 and nodes[5] == pytest.approx(-0.4) and nodes[7] == pytest.approx(0.4)
    # Near the middle of the wall behind all ways to the wall opposite lead through the gap.
    ahead = (f.charts.patches[..., 2] > 1.99).all(1)
    behind = (np.hypot(*(f.charts.positions[:, :2] - [0, 1]).T) < 0.2) & (f.charts.positions[:, 2] < 0.01)
    assert (f.factors[:P][ahead][:, :N][:, behind] > 0).any() and (f.crossing()[:P][ahead][:, behind] == 0).all()


def test_a_room_of_too_many_parts_has_even_light(ctx, monkeypatch, capsys):
    """One that does not say how it is lit; who asks for radiosity is refused."""
    monkeypatch.setattr("glcloth.curtain.charts.MOST_PATCHES", 60)
    scene = Scene(size=(8, 8), curtain=CURTAIN.changed(settle=0.02))
    with CurtainShow(ctx, scene) as one:
        assert one.scene.gi == "off" and one.picture().mean() > 0
        assert one.change(scene.changed(exposure=0.0)) and one.scene.gi == "off"
        # By paths the room lights itself; a window, which traces such a scene, shows even light.
        assert one.change(scene.changed(method="path")) and one.scene.gi == "radiosity"
        one.build()
        shot = one.shot()
        assert one.lit(shot) is shot
    assert Scene.model_validate(scene.stored()) == scene and "gi" not in scene.stored()  # so its picture renders again
    assert scene.changed(gi="radiosity").stored()["gi"] == "radiosity"
    warning = capsys.readouterr().err
    assert warning.count("\n") == 1 and "even light instead" in warning and "--gi photons" in warning
    with CurtainShow(ctx, scene.changed(gi="radiosity")) as one, pytest.raises(InputError, match="at most 60"):
        one.picture()


def test_too_many_parts_are_refused(monkeypatch):
    """A room of many separate triangles: the message says how many are taken, and what to do; a little fewer are coarser."""
    from glcloth.curtain import charts

    rng = np.random.default_rng(1)
    loose = 3 * rng.random((40, 1, 3)) + rng.random((40, 3, 3))
    fine = make_charts(loose)
    monkeypatch.setattr(charts, "MOST", 3600)
    assert 40 <= len(make_charts(loose).positions) < len(fine.positions)
    monkeypatch.setattr(charts, "MOST", 900)
    with pytest.raises(InputError, match=r"at most 30.*--gi photons or off"):
        make_charts(loose)


def test_patches_are_bounded_too(monkeypatch):
    """Their matrix grows with the square: a room with more has larger ones, as long as a part has one."""
    from glcloth.curtain import charts

    room = triangles_of(inside_out(box("grey", (0, 0, 0), (2, 1.5, 1))))
    fine = make_charts(room)
    monkeypatch.setattr(charts, "MOST_PATCHES", 12)
    assert 6 <= len(make_charts(room).patches) <= 12 < len(fine.patches)
    monkeypatch.setattr(charts, "MOST_PATCHES", 5)
    with pytest.raises(InputError, match=r"6 parts.*at most 5.*--gi photons or off"):
        make_charts(room)


def test_a_part_has_one_material():
    """Two triangles of a parallelogram that reflect differently are two parts, with their own colours."""
    room = triangles_of(inside_out(box("grey", (0, 0, 0), (2, 1.5, 1))))
    material = np.zeros(len(room), int)
    material[[1, 4, 5]] = 1, 2, 2
    charts = make_charts(room, None, material)
    assert charts.halves.sum() == 2 and len(charts.u) == 7
    assert charts.chart_of[0] != charts.chart_of[1] and charts.chart_of[4] == charts.chart_of[5]
    np.testing.assert_array_equal(material[charts.patch_triangle[charts.patch_of]][charts.element_chart == 1], 1)


def test_factors_are_kept_on_disk(ctx, monkeypatch, tmp_path):
    """The second time nothing is computed; a file that is damaged is made anew."""
    from glcloth.curtain import form_factors

    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path))
    positions = triangles_of(inside_out(box("grey", (0, 0, 0), (1.0, 1.25, 1))))
    first = factors_of(ctx, positions, 0.3).factors
    with monkeypatch.context() as patched:
        patched.setattr(form_factors, "_compute", lambda *_: pytest.fail("computed again"))
        np.testing.assert_array_equal(factors_of(ctx, positions, 0.3).factors, first)
    (path,) = (tmp_path / "factors").iterdir()
    whole = path.read_bytes()
    turned = bytearray(whole)
    turned[len(whole) // 2] ^= 0x10
    for damaged in (b"", whole[:100], whole[:-300], bytes(turned), b"PK" + bytes(400), pickle.dumps([1])):
        path.write_bytes(damaged)
        np.testing.assert_array_equal(factors_of(ctx, positions, 0.3).factors, first)
        assert path.read_bytes() == whole
    for other in ({"factors": first[:-1]}, {"factors": first.astype(float)}, {"factors": first * np.nan}, {"x": first}):
        np.savez(path, **other)
        np.testing.assert_array_equal(factors_of(ctx, positions, 0.3).factors, first)


def test_a_cache_that_cannot_be_written_is_done_without(ctx, monkeypatch, tmp_path):
    """A file where the folder should be, a folder where the file should be, a full disk."""
    positions = triangles_of(inside_out(box("grey", (0, 0, 0), (1.0, 1.25, 1.1))))
    (tmp_path / "factors").write_text("a file")
    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path))
    first = factors_of(ctx, positions, 0.4).factors
    monkeypatch.setattr(np, "savez", lambda *_, **__: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    monkeypatch.setenv("GLCLOTH_CACHE", str(tmp_path / "other"))
    np.testing.assert_array_equal(factors_of(ctx, positions, 0.4).factors, first)
    assert not list((tmp_path / "other" / "factors").iterdir())


@pytest.fixture(scope="module")
def show(session_ctx):
    with session_ctx:
        one = CurtainShow(session_ctx, SMALL)
    yield one
    with session_ctx:
        one.release()


@pytest.fixture
def as_it_was(ctx, show):
    """The show, whose fabric, room and light a test may exchange."""
    kept = show.scene, show.fabric, show.environment, show.radiosity.room
    yield show
    show.scene, show.fabric, show.environment, show.radiosity.room = kept
    show.radiosity._system = type(show.radiosity._system)()


def lit(show):
    """Trace a picture; the light that came to the receivers."""
    return show.picture(), show.radiosity.irradiance()


def photons(ctx, show, count=60_000):
    """Indirect light of the lamp on floor, ceiling, side and back walls without a curtain, W: by photons, an other method."""
    rng = np.random.default_rng(4)
    room = show.room
    corners = room.positions.astype(float)
    N = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    N /= np.linalg.norm(N, axis=1, keepdims=True)
    lamp, intensity = np.array(show.scene.lamp_position), np.array(show.scene.lamp_intensity)
    p = np.stack([rng.uniform(-1.1, 1.1, count), rng.uniform(0.4, 2.35, count), np.full(count, -0.14)], 1)
    d = p - lamp
    r = np.linalg.norm(d, axis=1, keepdims=True)
    d /= r
    flux = intensity * d[:, 2:] / r**2 * (2.2 * 1.95 / count)
    o, triangles, structure = lamp + 0 * d, Triangles.of(ctx, room.positions, 1), make_structure(ctx, "kdtree")
    structure.build(triangles)
    queries, found = RayQueries(ctx), np.zeros((len(corners), 3))
    t_min = r[:, 0] - 1e-3
    for event in range(30):
        hits = queries.closest_hit(structure, o, d, t_min)
        met = hits.triangle >= 0
        o, d, flux, at = o[met], d[met], flux[met], hits.triangle[met]
        p = o + hits.t[met, None] * d
        n = N[at] * np.where((N[at] * d).sum(1, keepdims=True) > 0, -1.0, 1.0)
        if event:
            for c in range(3):
                found[:, c] += np.bincount(at, flux[:, c], len(found))
        flux = flux * room.reflectances[room.material[at]]
        x = np.cross(np.where(np.abs(n[:, :1]) > 0.7, [0.0, 1, 0], [1.0, 0, 0]), n)
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        k = cosine_direction(rng.random((len(n), 2)))
        o, d, t_min = p + 2e-4 * n, k[:, :1] * x + k[:, 1:2] * np.cross(n, x) + k[:, 2:] * n, 0.0
    for thing in (queries, structure, triangles):
        thing.release()
    return found


def test_against_photons(ctx, as_it_was):
    """A curtain that is not there, before a dark sky: indirect light of floor, ceiling and three walls is that of photons."""
    show = as_it_was
    voile = load_fabric("sheer_voile")
    clear = voile.transmission.model_copy(update={"rho": 0.0, "k_a": 1.0})
    yarns = [yarn.model_copy(update={"albedo": (0.0, 0.0, 0.0), "k_d": 0.0, "eta": 1.0001}) for yarn in voile.yarn]
    show.fabric, show.environment = voile.model_copy(update={"transmission": clear, "yarn": tuple(yarns)}), DARK
    _, E = lit(show)
    factors = show.radiosity.factors
    charts = factors.charts
    open_ = factors.openness() >= OPEN
    P = photons(ctx, show)
    large = np.argsort(-np.linalg.norm(np.cross(charts.u, charts.v), axis=1))[:5]
    for k in large:
        own = charts.element_chart == k
        ours = (E[: len(own)] * (charts.area * open_)[:, None])[own].sum(0)
        np.testing.assert_allclose(ours, P[charts.chart_of == k].sum(0), rtol=0.06)


def test_colours_bleed(as_it_was):
    """Green walls turn the ceiling green; cloth that lets red light through reddens the floor behind the window."""
    show = as_it_was
    plain, E = lit(show)
    x, n = show.radiosity.factors.receivers
    x, n, ceiling = x[: len(E)], n[: len(E)], (n[:, 1] < -0.9) & (x[:, 1] > 2.69)
    voile = load_fabric("sheer_voile")
    red = voile.transmission.model_copy(update={"tau": (0.15, 1.5, 1.5)})
    show.fabric = voile.model_copy(update={"transmission": red})
    _, R = lit(show)
    floor = (n[:, 1] > 0.9) & (x[:, 1] < 0.01) & (x[:, 2] > 0.2) & (x[:, 2] < 0.9)
    assert R[floor, 0].mean() / R[floor, 1].mean() > 1.3 * E[floor, 0].mean() / E[floor, 1].mean()
    show.fabric = voile
    room = show.radiosity.room
    green = room.reflectances.copy()
    green[room.names.index("plaster")] = (0.2, 0.7, 0.2)
    show.radiosity.room = Room(room.positions, room.material, green, room.names)
    show.radiosity._system = type(show.radiosity._system)()
    _, G = lit(show)
    assert G[ceiling, 1].mean() / G[ceiling, 0].mean() > 1.5 * E[ceiling, 1].mean() / E[ceiling, 0].mean()
    assert np.isfinite(plain).all() and plain.min() >= 0


def test_a_background_is_a_sky_too(as_it_was):
    """Without a map the light that the sky sends is the background's, and follows it."""
    show = as_it_was
    show.build()
    shot, light = show.shot(), []
    for background in ((1.0, 1.0, 1.0), (3.0, 1.0, 0.5)):
        lighting = dataclasses.replace(shot.lighting, background=background)
        show.lit(dataclasses.replace(shot, environment=None, lighting=lighting))
        light.append(show.radiosity.irradiance().mean(0))
    ratio = light[1] / light[0]
    assert ratio[0] > 1.3 and ratio[1] == pytest.approx(1) and ratio[2] < 0.9


@pytest.mark.parametrize(("fabric", "least"), [("sheer_voile", 0.3), ("blackout", 0.0)])
def test_no_light_is_gained(as_it_was, fabric, least):
    """The curtain as a sheet passes and scatters at most what comes; blackout lets nothing through."""
    show = as_it_was
    show.fabric = load_fabric(fabric)
    show.build()
    shot = dataclasses.replace(show.shot(), indirect={})
    folds = show.radiosity.cloth.folds(show.tracer.inputs(shot), np.arange(0, show.triangles.count - 146, 5))
    whole = folds.passes + folds.reflected + folds.transmitted
    assert (whole < 1).all() and (whole > 0.1).all()
    assert (folds.lamp >= 0).all() and (folds.lamp.sum(0) < 1).all()
    assert folds.passes.min() >= least
    if fabric == "blackout":  # but for ways round its rim
        _, E = lit(show)
        x, n = show.radiosity.factors.receivers
        reveal, wall = x[:, 2] < 0, n[:, 2] < -0.9
        wall &= x[:, 2] > 3.9
        assert E[wall].mean() < 0.07 * E[reveal].mean()  # 0.085 if the curtain did not dim what crosses it
        assert folds.passes.max() < 2e-3 and folds.transmitted.max() < 0.03


def test_every_structure_finds_the_same_light(as_it_was):
    """kdtree, lbvh and brute, which takes several dispatches, give the same picture."""
    show = as_it_was
    reference = show.picture()
    for accelerator in ("lbvh", "brute"):
        show.scene = SMALL.changed(accelerator=accelerator)
        np.testing.assert_array_equal(show.picture(), reference)


def test_a_frame_looks_at_its_tree_once_more(ctx, as_it_was):
    """It must be whole for the light around the room to be found through it; all else of that light stays on the GPU.
    (In even light: tests/structures/test_counts.py.)"""
    show = as_it_was
    show.picture()
    show.moved()
    with counting(ctx) as window:
        show.build()
        list(show.tracer.steps(show.lit(show.shot())))
    assert window.reads == 1 and window.read_bytes < 1024
    show.moved()
    with counting(ctx) as picture:
        show.picture()
    width, height = SMALL.size
    assert picture.reads == 2 and picture.read_bytes < 16 * width * height + 3072


def test_no_frame_remembers_another(ctx, as_it_was):
    """Frame 2 after frames 0 and 1 is frame 2 at once, bit for bit; off and on again changes nothing; even light does not
    count."""
    show = as_it_was
    show.picture()
    *_, last = show.frames(3)
    with CurtainShow(ctx, SMALL.changed(gi="off", ambient=(5.0, 5.0, 5.0))) as other:
        (even,) = other.frames(3, start=2)
        assert other.change(SMALL.changed(ambient=(5.0, 5.0, 5.0)))
        np.testing.assert_array_equal(other.picture(), last)
        assert even.mean() > 2 * last.mean()
