"""Triangles to trace in tests: a pleated curtain in a box of a room, by formula; degenerate heaps; rays."""

import numpy as np


def box(low, high):
    """The 12 triangles [12, 3, 3] of an axis-aligned box."""
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    v = np.asarray(low, float) + corner * np.subtract(high, low)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.array([[v[a], v[b], v[c]] for q in quads for a, b, c in (q[:3], (q[0], q[2], q[3]))])


def room():
    """146 triangles: walls with a window opening, a rail, furniture."""
    boxes = [
        ((-2, -0.1, -0.1), (2, 0, 4)), ((-2, 2.7, -0.1), (2, 2.8, 4)), ((-2.1, 0, -0.1), (-2, 2.7, 4)),
        ((2, 0, -0.1), (2.1, 2.7, 4)), ((-2, 0, -0.1), (-1.1, 2.7, 0)), ((1.1, 0, -0.1), (2, 2.7, 0)),
        ((-1.1, 0, -0.1), (1.1, 0.3, 0)), ((-1.1, 2.4, -0.1), (1.1, 2.7, 0)), ((-0.03, 0.3, -0.07), (0.03, 2.4, -0.03)),
        ((-1.4, 2.42, 0.1), (1.4, 2.46, 0.14)), ((0.6, 0, 1.6), (1.4, 0.7, 2.2)), ((-1.6, 0, 1.2), (-1, 0.5, 1.8)),
    ]  # fmt: skip
    back = [[[-2, 0, 4], [2, 0, 4], [2, 2.7, 4]], [[-2, 0, 4], [2, 2.7, 4], [-2, 2.7, 4]]]
    return np.concatenate([*(box(*b) for b in boxes), np.array(back, float)])


def curtain_grid(columns, rows, time=0.0, pleats=7):
    """Vertices [rows, columns, 3] of a hanging curtain with pleats, blown by a wind that changes with time."""
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    phase = 2 * np.pi * pleats * u
    wind = (0.5 + 0.5 * np.sin(1.7 * time + 2.5 * u)) * v**1.6 * 0.35
    x = -1.25 + 2.5 * u + 0.02 * v * np.sin(2 * phase + 0.7 * time)
    y = 2.41 - 2.3 * v + 0.05 * wind
    z = 0.16 + (0.045 + 0.03 * v) * np.sin(phase + 0.8 * v * np.sin(time)) + wind
    return np.stack([x, y, z + 0.01 * np.sin(9 * v + 3 * time + 5 * u)], -1)


def grid_triangles(vertices):
    """The triangles [T, 3, 3] of a grid, as passes/accel/gather_grid.comp cuts it."""
    a, b, c, d = vertices[:-1, :-1], vertices[:-1, 1:], vertices[1:, :-1], vertices[1:, 1:]
    return np.stack([np.stack([a, c, b], 2), np.stack([b, c, d], 2)], 2).reshape(-1, 3, 3)


def scene(count=12_786, time=0.0):
    """The room and a curtain, as near to `count` triangles as a grid allows; exactly 12,786 by default."""
    quads = max((count - 146) / 2, 1)
    columns = 80 if count == 12_786 else max(1, round(quads**0.5))
    rows = round(quads / columns)
    return np.concatenate([room(), grid_triangles(curtain_grid(columns + 1, rows + 1, time))]).astype(np.float32)


EYE = np.array([0.9, 1.5, 3.6])


def camera_rays(count):
    """About `count` rays of a camera in the room that looks at the window."""
    n = round(count**0.5)
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, n), np.linspace(0.5, -0.5, n))
    forward = np.array([-0.1, 1.25, 0]) - EYE
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    d = forward + x[..., None] * right + y[..., None] * np.cross(right, forward)
    d = (d / np.linalg.norm(d, axis=-1, keepdims=True)).reshape(-1, 3)
    return np.broadcast_to(EYE, d.shape).astype(np.float32), d.astype(np.float32)


def random_rays(count, low, high, seed=1):
    """Rays from anywhere in a box to anywhere."""
    rng = np.random.default_rng(seed)
    d = rng.normal(size=(count, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return rng.uniform(low, high, (count, 3)).astype(np.float32), d.astype(np.float32)


def degenerate_scenes():
    """{name: triangles} that break careless builders."""
    rng = np.random.default_rng(5)
    one = rng.normal(size=(1, 3, 3))
    soup = rng.normal(size=(300, 3, 3)) * 0.2 + rng.normal(size=(300, 1, 3))
    flat = rng.uniform(-1, 1, (200, 3, 3))
    flat[..., 2] = 0.0
    halves = np.concatenate([box((-1, -1, -1), (1, 1, 1)), box((-1, -1, 0), (1, 1, 0)), flat])
    sliver = rng.normal(size=(200, 1, 3)) + np.array([[0, 0, 0], [1, 1, 1], [1, 1, 1.000001]])[None]
    point = np.repeat(rng.normal(size=(150, 1, 3)), 3, 1)
    line = np.linspace(0, 1, 150)[:, None, None] * np.ones((1, 3, 3)) + np.array([0.0, 0.1, 0.2])[None, :, None]
    huge = np.array([[[-100, 0, -100], [100, 0, -100], [0, 0, 150.0]]])
    return {
        "one": one,
        "100 coincident": np.repeat(one, 100, 0),
        "coincident in a soup": np.concatenate([np.repeat(one, 100, 0), soup]),
        "in the split plane": halves,
        "all in one plane": flat,
        "slivers": np.concatenate([sliver, soup]),
        "no area": np.concatenate([point, line, soup[:50]]),
        "one huge": np.concatenate([huge, 0.01 * soup]),
        "parallel sheets": np.concatenate([box((-1, -1, z), (1, 1, z)) for z in np.linspace(-1, 1, 40)]),
        "far apart": np.concatenate([soup, 1e-3 * soup + 50, -1e-3 * soup - 50]),
    }
