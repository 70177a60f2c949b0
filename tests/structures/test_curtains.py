"""Two curtains before a window, and pairs: where the pieces hang, that the one before keeps its side, and what a scene says."""

import numpy as np
import pytest
from test_simulation import crossings

from glcloth.accel.queries import RayQueries
from glcloth.accel.structure import make_structure
from glcloth.accel.triangles import Triangles
from glcloth.curtain.curtains import BEHIND, FRONT, Curtains, panels_of
from glcloth.errors import InputError
from glcloth.geometry.shapes import grid_triangles
from glcloth.scene import CurtainParameters, Scene, load_scene, save_scene

COARSE = {"quads": (72, 18), "pleats": 6, "settle": 0.3}


def test_pairs_leave_the_middle_free():
    pieces = panels_of(CurtainParameters(open=0.9, behind="blackout", behind_open=0.3))
    ends = [(p.shift - p.parameters.width / 2, p.shift + p.parameters.width / 2, p.curtain) for p in pieces]
    expected = [(-1.25, -0.45, FRONT), (0.45, 1.25, FRONT), (-1.25, -0.15, BEHIND), (0.15, 1.25, BEHIND)]
    np.testing.assert_allclose(ends, expected, atol=1e-12)
    # As many folds a metre as one piece has.
    assert [p.parameters.pleats for p in pieces] == [4, 4, 6, 6]
    said = panels_of(CurtainParameters(quads=(100, 20), pleats=10, open=1.25))
    assert {(p.parameters.quads, p.parameters.pleats) for p in said} == {((25, 20), 2)}
    assert panels_of(CurtainParameters(wind=1.0)) == [panels_of(CurtainParameters(wind=1.0))[0]]
    # What hangs before gets the wind that comes through, or by.
    front = panels_of(CurtainParameters(wind=1.0, behind="lace", behind_open=0.5), 0.25)[0]
    assert front.parameters.wind == pytest.approx(1 - 0.75 * 0.8)


def test_the_wind_blows_no_curtain_through_the_other(ctx):
    """Rays from the vertices of the one before into the room meet nothing of the one behind, though that is blown into it."""
    curtains = Curtains(ctx, CurtainParameters(behind="blackout", open=0.4, wind=1.5, **COARSE))
    try:
        behind = curtains.pieces[-1]
        rest = behind.positions()[..., 2].max()
        for _ in range(16):
            curtains.step(1 / 24)
        assert behind.positions()[..., 2].max() > rest + 0.1
        mesh = behind.mesh()
        triangles = Triangles.of(ctx, mesh.positions[mesh.triangles])
        structure, queries = make_structure(ctx, "lbvh"), RayQueries(ctx)
        structure.build(triangles)
        x = np.concatenate([one.positions().reshape(-1, 3) for one in curtains.pieces[:-1]])
        into = np.broadcast_to([0.0, 0.0, 1.0], x.shape).copy()
        assert not queries.any_hit(structure, x, into).any()
        # They are before it, and not beside.
        assert queries.any_hit(structure, x, -into).mean() > 0.7
        for one in (triangles, structure, queries):
            one.release()
    finally:
        curtains.release()


def test_curtains_in_a_storm_push_each_other(ctx):
    """In a wind that lifts the one behind to the rail no edge of one passes through the other. Single threads once were three
    times as long then."""
    curtains = Curtains(ctx, CurtainParameters(behind="blackout", wind=3.0, **COARSE))
    try:
        for _ in range(18):
            curtains.step(1 / 24)
        front, behind = (one.positions() for one in curtains.pieces)
        across, down = curtains.cloth.parameters.spacing
        for cloth in front, behind:
            assert np.linalg.norm(np.diff(cloth, axis=0), axis=-1).max() < 1.1 * down
            assert np.linalg.norm(np.diff(cloth, axis=1), axis=-1).max() < 1.1 * across
        assert front[..., 2].max() > 1.5 and behind[..., 2].max() > 1.5
        triangles = [grid_triangles(*cloth.shape[:2]) + k for cloth, k in ((front, 0), (behind, front.size // 3))]
        assert crossings(np.concatenate([front.reshape(-1, 3), behind.reshape(-1, 3)]), np.concatenate(triangles)) == 0
        # In less wind what hangs behind keeps the other out, as ever.
        calm = curtains.parameters.changed(wind=0.2)
        assert curtains.change(calm) and curtains.cloth.backdrop is None
        curtains.step(1 / 24)
        assert curtains.cloth.backdrop is curtains.backdrop
    finally:
        curtains.release()


def test_a_second_curtain_in_a_scene(tmp_path):
    own = tmp_path / "own.toml"
    scene = Scene(curtain={"behind": str(own), "behind_color": "crimson"})
    save_scene(tmp_path / "scene.toml", scene)
    assert 'behind = "own.toml"' in (tmp_path / "scene.toml").read_text()
    assert load_scene(tmp_path / "scene.toml").curtain == scene.curtain
    assert str(own) in scene.files()
    with pytest.raises(InputError, match=r"open = 2\.3: the rail is 2\.5 m long, expected at most 2\.1"):
        Scene.parse({"curtain": {"open": 2.3}})
