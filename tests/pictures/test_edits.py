"""A session shows a scene to the bit as it is, whatever it showed before: what is kept has a key of all that it is made of."""

import numpy as np
import pytest

from glcloth.fabric import Transmission, load_fabric
from glcloth.geometry import shapes
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.props import Objects
from glcloth.light.environment import from_array
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.picture.frame import Cloth
from glcloth.picture.prints import Print
from glcloth.picture.renderer import Renderer
from glcloth.visibility import vertices

AXES = np.array([[0.3, 0.9, 0.3], [-0.8, 0.5, 0.3], [0.2, 0.3, -0.9], [0.5, 0.4, 0.8]])
AXES /= np.linalg.norm(AXES, axis=1)[:, None]
SHARPNESS, AMPLITUDE = (
    np.array([1.0, 12.0, 60.0, 4.0]),
    np.array([[1.0, 0.9, 0.8], [2.0, 2.0, 3.0], [5.0, 4.0, 3.0], [0.5, 0.6, 0.9]]),
)
SUN = {"direction": [[0.4, 0.8, 0.3]], "irradiance": [[2.0, 1.9, 1.6]], "radius": 0.03}


def lights(sharpness=SHARPNESS, amplitude=AMPLITUDE, turn=0, **sun):
    return Lights(SphericalGaussians(np.roll(AXES, turn, 0), sharpness, amplitude), Suns(**{**SUN, **sun}))


def fold(phase=0.0, at=(0.0, 0.0, 0.0), uv=1.0):
    """A ribbon in folds, so fine that no more vertices are wanted: the picture is cheap."""
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 1, 91), (0.0, 1.0)))
    x = np.stack([u - 0.5, 0.1 * np.sin(14 * u + phase), 0.06 * (0.5 - v)], -1) + at
    first = np.arange(90)
    quads = np.stack([first, first + 1, first + 92, first + 91], -1)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return build_mesh("ribbon", x, triangles, uv * np.stack([u, 0.06 * v], -1))


def dyed(fabric, **of_first):
    """A fabric with another first yarn."""
    first, second = fabric.yarn
    return fabric.changed(yarn=(first.changed(**of_first), second))


def sky(*levels):
    rows = np.ones((8, 16, 3)) * np.linspace(levels[0], levels[1], 8)[:, None, None]
    rows[2, 3] = levels[2]
    return from_array("sky", rows)


LINEN, VOILE = load_fabric("linen"), load_fabric("sheer_voile")
WHITE = dyed(VOILE, albedo=(1.0, 1.0, 1.0), k_d=0.9).changed(
    transmission=Transmission(diffuse=0.1, tau=(0.9, 0.1, 0.3))
)  # it is dimmed
MESHES = fold(), fold(1.0), fold(0.5, (0.1, 0.15, -0.03)), fold(0.5, (0.2, 0.12, 0.01))
BLOCK = build_mesh("block", *(lambda s: (0.1 * s[0] + (-0.2, 0.1, -0.1), s[1], s[2]))(shapes.plane(1.0, 2)))
RED, BLUE = (np.tile(color, (len(BLOCK.triangles), 1)) for color in ((0.7, 0.1, 0.1), (0.1, 0.1, 0.7)))
DIM = Lights(SphericalGaussians(AXES, np.full(4, 300.0), AMPLITUDE))  # leaves most directions dark
CAMERA, ASIDE = (Camera(eye, (0.0, 0.0, 0.0), fov_deg=20.0) for eye in ((0.1, 0.5, 0.6), (0.2, 0.5, 0.5)))
BASE = {
    "cloths": [Cloth(MESHES[0], LINEN)],
    "lights": lights(),
    "environment": sky(1.0, 0.4, 6.0),
    "camera": CAMERA,
    "size": (40, 12),
    "cube": 4,
}
TINT = Print(np.tile(np.array([[[0.9, 0.2, 0.1]], [[0.2, 0.5, 0.9]]], np.float32), (2, 4, 1)), (0.5, 0.5), True)


def things(color):
    return Objects((BLOCK,), (color,), graded=(True,))


def wear(*fabrics, meshes=(MESHES[0], MESHES[2]), **look):
    return {"cloths": [Cloth(mesh, fabric, **look) for mesh, fabric in zip(meshes, fabrics, strict=False)]}


GREEN, THIN = dyed(LINEN, albedo=(0.1, 0.5, 0.2)), {"gamma_s_deg": 5.0, "gamma_v_deg": 8.0}
AFTERNOON = {"direction": [[-0.5, 0.7, 0.4]]}
CHAINS = {
    "lights and fabric": (
        {"lights": lights(amplitude=AMPLITUDE[::-1])},
        {"lights": lights(turn=1, radius=0.1)},
        {"camera": ASIDE},
        wear(GREEN),
        wear(dyed(LINEN, **THIN)),
        wear(dyed(LINEN, **THIN, k_d=0.1)),
        wear(LINEN.changed(sigma_deg=40.0)),
        wear(load_fabric("velvet")),
        {"lights": lights(sharpness=np.array([1.0, 3.0, 8.0, 60.0]))},
    ),
    "surfaces": (
        wear(LINEN, LINEN),
        wear(LINEN, GREEN),
        {"objects": things(RED)},
        {"objects": things(BLUE)},
        {"lights": lights(sharpness=np.array([1.0, 30.0, 90.0, 4.0]))},
        {"objects": None, "shadows": "sun"},
        wear(LINEN, GREEN, meshes=(MESHES[0], MESHES[3])),
        {"lights": lights(**AFTERNOON)},
        {**wear(GREEN, meshes=MESHES[1:]), "shadows": "full"},
        {"bounce": False},
    ),
    "through": (
        wear(LINEN, VOILE, meshes=(MESHES[0], MESHES[3])),
        {"lights": lights(direction=[[-0.5, -0.7, 0.4]])},
        wear(LINEN, WHITE, meshes=(MESHES[0], MESHES[3])),
    ),
    "reference": (
        {"lights": DIM},
        {"bounce": True},
        wear(LINEN, LINEN),
        wear(GREEN, LINEN),
        {"shadows": "sun"},
        {"light": "map"},
        {"env_rotate": 90.0},
        {"environment": sky(0.4, 1.0, 60.0)},
    ),
    "path": (
        {"lights": lights(**AFTERNOON)},
        {"lights": lights(**AFTERNOON, irradiance=[[3.0, 1.0, 1.0]])},
        {"lights": lights(**AFTERNOON, irradiance=[[3.0, 1.0, 1.0]], radius=0.15)},
        wear(GREEN),
        wear(GREEN, meshes=MESHES[1:]),
        {"objects": things(RED)},
        {"objects": things(BLUE)},
        {**wear(LINEN, print=TINT), "light": "map"},
        {"uv_scale": 0.5},
        {"environment": sky(0.4, 1.0, 60.0)},
    ),
}
BEGIN = {
    "through": {**wear(LINEN, VOILE), "lights": lights(direction=[[0.4, -0.8, 0.3]])},  # a sun from below
    "reference": {"method": "reference", "bounce": False},
    "path": {"method": "path", "spp": 2, "uv_scale": 1.0},
}


@pytest.mark.parametrize("chain", CHAINS)
def test_no_order_of_edits_shows(ctx, renderer, monkeypatch, chain):
    """What is kept too long is of an earlier scene, and that is another one where the edits are made from behind."""
    monkeypatch.setattr(vertices, "DIRECTIONS", 64)  # few are as good here
    scenes = [{**BASE, **BEGIN.get(chain, {})}]
    for edit in CHAINS[chain]:
        scenes.append({**scenes[-1], **edit})
    there, back = Renderer(ctx=ctx), Renderer(ctx=ctx)
    forward = [there.render(**scene).copy() for scene in scenes]
    for number in reversed(range(len(scenes))):
        found = back.render(**scenes[number])
        np.testing.assert_array_equal(found, forward[number], f"edit {number}: {[*(CHAINS[chain])[number - 1]]}")
        same = number and np.array_equal(forward[number], forward[number - 1])
        assert not same, f"edit {number} shows nothing"
