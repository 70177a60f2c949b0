"""The built-in room: its count, which way it faces, that light enters by the window only, and what files may hold."""

import numpy as np
import pytest

from glcloth.curtain.hanging import CurtainParameters, pleated_rail
from glcloth.curtain.room import (
    HIGH,
    LOW,
    MATERIALS,
    ROOM,
    WINDOW_HIGH,
    WINDOW_LOW,
    load_room,
    room_text,
    save_room,
    with_rod,
)
from glcloth.errors import InputError


def first_hits(triangles, origin, directions):
    """t [N] of the nearest triangle along each ray, inf for none; every triangle is tried."""
    a, u, v = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    h = np.cross(directions[:, None], v)
    determinant = np.sum(u * h, axis=-1)
    f = 1 / np.where(np.abs(determinant) > 1e-12, determinant, np.inf)
    s = origin - a
    q = np.cross(s, u)
    b_1, b_2, t = f * np.sum(s * h, -1), f * np.sum(directions[:, None] * q, -1), f * np.sum(v * q, -1)
    return np.where((b_1 >= 0) & (b_2 >= 0) & (b_1 + b_2 <= 1) & (t > 1e-6), t, np.inf).min(axis=1)


def test_the_rod_is_as_long_as_the_rail():
    room = load_room()
    assert with_rod(room, CurtainParameters()) is room
    wide, metal = with_rod(room, CurtainParameters(width=3.0)).positions, room.material == room.names.index("metal")
    assert np.allclose(np.abs(wide[metal, :, 0]), 1.58) and np.array_equal(wide[~metal], room.positions[~metal])
    with pytest.raises(InputError, match=r"width = 3.9 m.*at most 3.8"):
        with_rod(room, CurtainParameters(width=3.9))


def test_curtain_and_room_have_12786_triangles():
    room = load_room()
    assert len(room.positions) + CurtainParameters().triangle_count == 12_786
    assert set(room.names) == set(MATERIALS)
    assert np.allclose(room.reflectances, [MATERIALS[name] for name in room.names], atol=1e-6)
    p = room.positions.astype(float)
    assert np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).min() > 1e-4, "no slivers"


def test_files_are_what_the_command_writes(tmp_path):
    obj, mtl = room_text()
    assert ROOM.read_text(encoding="utf-8") == obj and ROOM.with_suffix(".mtl").read_text(encoding="utf-8") == mtl
    save_room(tmp_path / "mine.obj")
    mine = load_room(tmp_path / "mine.obj")
    assert np.array_equal(mine.positions, load_room().positions) and mine.names == load_room().names
    assert {f.name for f in tmp_path.iterdir()} == {"mine.obj", "mine.mtl"}


def test_walls_close_and_only_the_window_lets_light_in():
    """From a point in the room every ray ends in it or leaves through the opening; what it meets turns its face to it."""
    triangles = load_room().positions.astype(float)
    eye = np.array([0.9, 1.5, 3.6])
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    t = first_hits(triangles, eye, directions)
    leaves = np.isinf(t)
    with np.errstate(divide="ignore"):
        crossing = eye + directions * (-eye[2] / directions[:, 2])[:, None]
    through = (
        (directions[:, 2] < 0)
        & (crossing[:, :2] > WINDOW_LOW).all(axis=1)
        & (crossing[:, :2] < WINDOW_HIGH).all(axis=1)
    )
    assert not leaves[~through].any() and leaves.sum() > 20
    inside = (eye + directions[~leaves] * t[~leaves, None] > np.array(LOW) - [1e-6, 1e-6, 0.2]).all(axis=1)
    assert inside.all()
    # One-sided triangles seen from their backs would be invisible to renderers that cull.
    S = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    facing = np.sum((eye - triangles[:, 0]) * S, axis=1) > 0
    front = triangles[facing]
    assert np.allclose(first_hits(front, eye, directions), t)


def test_curtain_hangs_clear_of_the_room():
    """Between the sill and the furniture, under the rod, over the whole opening."""
    curtain, p = CurtainParameters(), load_room().positions
    rail = pleated_rail(curtain, curtain.quads[0] + 1)
    low = np.array([-curtain.width / 2, curtain.top - curtain.drop, rail[:, 1].min()])
    high = np.array([curtain.width / 2, curtain.top, rail[:, 1].max()])
    boxes = p.min(axis=1), p.max(axis=1)
    assert not ((boxes[0] < high).all(axis=1) & (boxes[1] > low).all(axis=1)).any()
    assert low[0] < WINDOW_LOW[0] and high[0] > WINDOW_HIGH[0] and high[1] > WINDOW_HIGH[1] and low[1] < WINDOW_LOW[1]
    assert (p.max(axis=(0, 1)) <= np.array(HIGH) + 1e-6).all()


def test_bad_rooms_end_in_one_line(tmp_path):
    triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    for name, obj, mtl, words in (
        ("gone.obj", triangle + "mtllib no.mtl\nf 1 2 3\n", None, "not beside it"),
        ("undefined.obj", "mtllib undefined.mtl\n" + triangle + "usemtl red\nf 1 2 3\n", "newmtl blue\n", "red"),
        ("color.obj", "mtllib color.mtl\n" + triangle + "usemtl a\nf 1 2 3\n", "newmtl a\nKd 1 x 0\n", "color.mtl:2"),
        ("bright.obj", "mtllib bright.mtl\n" + triangle + "usemtl a\nf 1 2 3\n", "newmtl a\nKd 1 9 0\n", "0 to 1"),
        ("nan.obj", triangle.replace("1 0 0", "nan 0 0") + "f 1 2 3\n", None, "finite"),
    ):
        (tmp_path / name).write_text(obj)
        if mtl:
            (tmp_path / name).with_suffix(".mtl").write_text(mtl)
        with pytest.raises(InputError, match=words) as caught:
            load_room(tmp_path / name)
        assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="no such file"):
        load_room(tmp_path / "absent.obj")
    (tmp_path / "plain.obj").write_text(triangle + "f 1 2 3\n")
    assert np.allclose(load_room(tmp_path / "plain.obj").reflectances, 0.7)
