"""The view of the tree, and the rasterised picture that ray tracing is compared with."""

import curtain_scenes as scenes
import numpy as np
import pytest

from glcloth.accel.kdtree import KdTree
from glcloth.accel.triangles import Triangles
from glcloth.errors import InputError
from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.tracing.lamp import Lamp, Lighting
from glcloth.tracing.shot import Shot
from glcloth.tracing.tracer import Tracer
from glcloth.tracing.tree_view import GREEN, GREY, YELLOW, TreeContent, box_lines, draw_tree, shown_nodes
from glcloth.twins import sheet

VOILE = load_fabric("sheer_voile")


def near(picture, color, tolerance=0.02):
    """How many pixels have a colour."""
    return int((np.abs(picture - np.array(color)).max(-1) < tolerance).sum())


@pytest.fixture
def tree(ctx):
    soup = scenes.scene(1000, 1.0)
    triangles, structure = Triangles.of(ctx, soup), KdTree(ctx)
    structure.build(triangles)
    yield structure.arrays(), soup
    structure.release()
    triangles.release()


def test_colours_of_the_view(ctx, tree):
    arrays, soup = tree
    colors = np.full((len(soup), 3), (0.2, 0.3, 0.9))
    camera = Camera((4.0, 4.0, 9.0), (0, 1.2, 1.0), fov_deg=40)
    picture = draw_tree(ctx, TreeContent(arrays, soup, colors, camera, (3.0, 3.2, 3.0)), (200, 200), 3)
    assert picture.shape == (200, 200, 3)
    assert near(picture, (0.2, 0.3, 0.9)) > 1000, "primitives are unshaded"
    assert near(picture, YELLOW) > 10 and near(picture, (1, 1, 1)) > 1000
    alone = TreeContent(arrays, soup, colors, camera, hidden=np.ones(len(soup), bool))
    bare = draw_tree(ctx, alone, (200, 200), 0)
    assert near(bare, (0.2, 0.3, 0.9)) == 0 and near(bare, YELLOW) == 0
    # Lines are two half pixels wide at most, so they mix with the paper.
    green = (bare[..., 1] - bare[..., 0] > 0.1).sum()
    more = draw_tree(ctx, alone, (200, 200))
    assert 100 < green < (more[..., 1] - more[..., 0] > 0.1).sum()
    assert max(GREEN) < 1 and len(set(GREY)) == 1


def test_what_is_in_front_hides(ctx, tree):
    """A wall right before the camera hides everything but its own edges."""
    arrays, soup = tree
    wall = np.array([[[-50, -50, 5.0], [50, -50, 5], [0, 90, 5]]], np.float32)
    positions = np.concatenate([soup, wall])
    colors = np.r_[np.full((len(soup), 3), 0.5), [[0.7, 0.1, 0.1]]]
    content = TreeContent(arrays, positions, colors, Camera((0, 1, 8), (0, 1, 0), fov_deg=30))
    picture = draw_tree(ctx, content, (60, 60), 4)
    assert near(picture, (0.7, 0.1, 0.1)) == 3600


def test_levels(tree):
    arrays, _ = tree
    assert list(shown_nodes(arrays, 0)) == [0]
    assert len(shown_nodes(arrays, 2)) == 4
    leaves = shown_nodes(arrays, None)
    assert (arrays["axis"][leaves] == 3).all() and arrays["count"][leaves].min() > 0
    with pytest.raises(InputError, match="levels 0 to"):
        shown_nodes(arrays, 99)


def test_boxes_have_twelve_edges():
    lines = box_lines(np.zeros((1, 3)), np.array([[1.0, 2.0, 3.0]]))[0]
    lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=-1)
    assert sorted(lengths) == [1] * 4 + [2] * 4 + [3] * 4
    assert len({tuple(sorted(map(tuple, line))) for line in lines}) == 12


def test_brute_force_has_no_tree(ctx):
    with pytest.raises(InputError, match="no tree"):
        draw_tree(ctx, TreeContent({"axis": np.array([3])}, np.zeros((1, 3, 3)), np.ones((1, 3)), Camera()), (8, 8))


def test_sorted_layers(ctx):
    """Sheets before a background: each covers what is behind it by one minus its mean transmittance; no shadows."""
    tracer = Tracer(ctx)
    t = VOILE.transmission
    a, b, c, d = ([x, y, 0] for x, y in ((-9, -9), (9, -9), (9, 9), (-9, 9)))
    sheet_at = np.array([[a, b, c], [a, c, d]], float)
    camera = Camera((0, 0, 4), (0, 0, 0), fov_deg=1.2)
    through = sheet.T_sheet(np.array([0, 0, 1.0]), t.k_a, t.k_t, np.array(t.tau), t.rho).mean()
    lighting = Lighting(Lamp(intensity=(0, 0, 0)), (0.0, 0.0, 0.0), (0.5, 0.7, 1.0))
    for depths in ([0.0], [-1.0, 0.0, -2.0]):
        positions = np.concatenate([sheet_at + np.array([0, 0, z]) for z in depths])
        triangles = Triangles.of(ctx, positions, 0)
        tracer.set_scene(triangles, np.zeros((1, 3)))
        got = tracer.layers(Shot(camera, (8, 8), VOILE, lighting))
        np.testing.assert_allclose(
            got, np.broadcast_to(np.array([0.5, 0.7, 1.0]) * through ** len(depths), got.shape), rtol=2e-3
        )
        triangles.release()
    # A solid wall before the sheets hides them, and the lamp shines through it: nothing is in shadow here.
    lamp = Lighting(Lamp((0, 0, -5.0), (100, 100, 100)), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    triangles = Triangles(ctx, 4, 10.0)
    triangles.set(0, sheet_at + np.array([0, 0, -1]), material=1)
    triangles.set(2, sheet_at, material=0)
    tracer.set_scene(triangles, np.array([[0, 0, 0], [0.5, 0.5, 0.5]]))
    tracer.build()
    assert tracer.layers(Shot(camera, (8, 8), VOILE, lamp)).min() > 0.01
    assert tracer.trace(Shot(camera, (8, 8), VOILE, lamp)).max() == 0, "the ray tracer knows the shadow"
    triangles.release()
    tracer.release()
