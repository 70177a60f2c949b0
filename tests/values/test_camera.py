"""Cameras: matrices against rays, the lens, views by name and of files, options and errors."""

import json
import struct

import numpy as np
import pytest

from glcloth.cli import main
from glcloth.cli.options import scene_of
from glcloth.cli.scene_options import SceneOptions
from glcloth.errors import InputError
from glcloth.geometry.camera import Camera, lens_points, lens_samples
from glcloth.geometry.mesh_files import load_mesh
from glcloth.geometry.views import DIRECTIONS, file_cameras, view_by_name
from glcloth.scene import Scene, View, load_scene, save_scene

SIZE = (160, 120)


@pytest.mark.parametrize("ortho", [None, 1.7])
def test_rays_go_through_the_pixels_that_the_matrix_puts_their_points_into(ortho):
    rng = np.random.default_rng(0)
    camera = Camera((1, 2, 3), (0.2, 0.1, 0), fov_deg=40, ortho=ortho, aperture=0.2, focus=2.5)
    for one in (camera, *lens_samples(camera, 5)):
        pixels = np.c_[rng.uniform(0, 100, (50, 2)), np.ones(50)]
        d = pixels @ one.ray_from_pixel(SIZE, (0.2, -0.3)).T
        p = pixels @ one.origin_from_pixel(SIZE, (0.2, -0.3)).T + d * rng.uniform(1, 6, (50, 1))
        clip = np.c_[p, np.ones(50)] @ one.clip_from_world(SIZE, 0.1, 10, (0.2, -0.3)).T
        np.testing.assert_allclose((clip[:, :2] / clip[:, 3:] + 1) / 2 * SIZE, pixels[:, :2], atol=1e-4)
        toward = one.viewpoint[:3] - one.viewpoint[3] * p
        unit = [v / np.linalg.norm(v, axis=1, keepdims=True) for v in (toward, d)]
        np.testing.assert_allclose(unit[0], -unit[1], atol=1e-6)
        vary = one.ray_from_pixel if ortho is None else one.origin_from_pixel
        begin = np.array([one.origin_from_pixel((160, 80)) @ (x, y, 1) for x in (0, 160) for y in (0, 80)])
        assert np.abs(begin).max() <= camera.reach
        steps = [vary(SIZE) @ np.subtract(next_to, (40, 30, 1)) for next_to in ((41, 30, 1), (40, 31, 1))]
        np.testing.assert_allclose(one.step_from_pixel(SIZE)[:, :2], np.transpose(steps), atol=1e-9)


@pytest.mark.parametrize("size", [(160, 120), (60, 200)])
def test_a_framed_ball_just_fits_the_shorter_side(size):
    camera = Camera.framing((1.0, 2.0, 3.0), 0.7, fov_deg=50.0, aspect=size[0] / size[1])
    right, up, forward = camera.axes
    way = float(np.linalg.norm(np.subtract(camera.target, camera.eye)))
    rim = np.sqrt(way**2 - 0.7**2)  # where rays touch it
    for side, length in ((right, size[0]), (up, size[1])):
        at = np.array(camera.eye) + rim * (forward * rim + side * 0.7) / way
        clip = camera.clip_from_world(size, 0.1, 10.0) @ [*at, 1.0]
        reach = np.abs(clip[:2] / clip[3]).max() * length / min(size)
        assert reach == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("ortho", [None, 1.7])
def test_all_points_of_the_lens_see_the_focus_at_the_same_pixel(ortho):
    camera = Camera((1, 2, 3), (0.2, 0.1, 0), ortho=ortho, aperture=0.2, focus=2.5)
    samples = lens_samples(camera, 16)
    for pixel in ((40, 30, 1), (150, 5, 1)):
        at = [c.origin_from_pixel(SIZE) @ pixel + 2.5 * (c.ray_from_pixel(SIZE) @ pixel) for c in samples]
        assert np.ptp(at, 0).max() < 1e-9
    assert np.ptp([c.eye for c in samples], 0).max() > 0.1
    assert lens_samples(camera, 1)[0].eye == camera.eye


@pytest.mark.parametrize("spp", [4, 16, 61, 256])
def test_points_fill_the_lens_evenly(spp):
    points = np.array(lens_points(spp))
    radius = np.hypot(*points.T)
    assert len(np.unique(points, axis=0)) == spp and radius.max() <= 1.0
    assert np.abs(points.mean(0)).max() < 0.8 / spp**0.5
    assert (radius**2).mean() == pytest.approx(0.5, abs=0.35 / spp**0.5)


@pytest.mark.parametrize("ortho", [None, 3.0])
@pytest.mark.parametrize("name", DIRECTIONS)
def test_views_frame_the_cloth(name, ortho):
    points = load_mesh("drape").positions
    camera = view_by_name(name, points, 4 / 3, 35.0, ortho)
    clip = (
        np.c_[points, np.ones(len(points))]
        @ camera.clip_from_world(SIZE, *camera.depth_range(points.min(0), points.max(0))).T
    )
    x, y = (clip[:, :2] / clip[:, 3:]).T
    inside = (np.abs(x) < 1) & (np.abs(y) < 1)
    toward = np.subtract(camera.eye, camera.target)
    np.testing.assert_allclose(
        toward / np.linalg.norm(toward), np.array(DIRECTIONS[name]) / np.linalg.norm(DIRECTIONS[name])
    )
    if name == "close":
        assert ortho or 0 < inside.mean() < 0.2
    else:
        assert inside.all() and (ortho or max(np.abs(x).max(), np.abs(y).max()) > 0.85)


def glb(path, **data):
    text = json.dumps({"asset": {"version": "2.0"}, **data}).encode()
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text)
    return path


def test_cameras_of_a_file(tmp_path):
    half = 0.5**0.5
    path = glb(
        tmp_path / "a.glb",
        nodes=[
            {
                "name": "rig",
                "translation": [0, 1, 0],
                "rotation": [0, half, 0, half],
                "scale": [2, 2, 2],
                "children": [1, 2],
            },
            {"name": "shot", "camera": 0, "translation": [0, 0, 3]},
            {"name": "plan", "camera": 1, "rotation": [-half, 0, 0, half]},
        ],
        cameras=[
            {"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}},
            {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1.5, "zfar": 9, "znear": 0.1}},
        ],
    )
    shot, plan = file_cameras(path).values()
    np.testing.assert_allclose([shot.eye, shot.axes[2]], [(6, 1, 0), (-1, 0, 0)], atol=1e-12)
    assert shot.fov_deg == pytest.approx(np.degrees(0.7)) and shot.ortho is None
    np.testing.assert_allclose([plan.eye, plan.axes[2], plan.axes[1]], [(0, 1, 0), (0, -1, 0), (-1, 0, 0)], atol=1e-12)
    assert plan.ortho == 3.0
    seen = view_by_name("shot", np.array([[-1.0, 0, -1], [1, 2, 1]]), 4 / 3, file=path)
    np.testing.assert_allclose(seen.target, (0, 1, 0), atol=1e-9)
    # In centimetres the cloth is a hundredth of the file's numbers, and so is where the camera stands.
    seen = view_by_name("shot", np.array([[-1.0, 0, -1], [1, 2, 1]]) / 100, 4 / 3, file=path, scale=0.01)
    np.testing.assert_allclose([seen.eye, seen.target], [(0.06, 0.01, 0), (0, 0.01, 0)], atol=1e-9)
    assert view_by_name("plan", np.zeros((1, 3)), 1.0, file=path, scale=0.01).ortho == pytest.approx(0.03)
    with pytest.raises(InputError, match="has 2 cameras; did you mean shot"):
        view_by_name("shott", np.zeros((1, 3)), 1.0, file=path)
    with pytest.raises(InputError, match=r"expected front.*shot, plan"):
        view_by_name("file", np.zeros((1, 3)), 1.0, file=path)


def test_damaged_cameras_are_one_line(tmp_path):
    for more in ({"cameras": ["x"], "nodes": [{"camera": 0}]}, {"cameras": [{}], "nodes": [{"camera": 0}]}):
        with pytest.raises(InputError, match="its cameras cannot be read"):
            file_cameras(glb(tmp_path / f"{len(str(more))}.glb", **more))


def test_a_mesh_by_name_brings_its_own_cameras(tmp_path):
    from glcloth.geometry.mesh_files import load_mesh, save_mesh
    from glcloth.picture.frame import Frames

    save_mesh(tmp_path / "a.glb", load_mesh("plane"))
    with pytest.raises(InputError, match=r"a\.glb has 0 cameras"):
        Frames().make("draped", mesh=str(tmp_path / "a.glb"), camera=View(view="file"))


def test_options_make_a_camera_that_a_file_keeps(tmp_path):
    base = scene_of(None, SceneOptions(eye="-1,2,3", target="0,.5,-1e-1", fov_deg=50.0, aperture=0.1, focus=2.0))
    assert base.camera == View(eye=(-1, 2, 3), target=(0, 0.5, -0.1), fov_deg=50, aperture=0.1, focus=2)
    save_scene(tmp_path / "a.toml", base)
    assert load_scene(tmp_path / "a.toml") == base
    # A view by name takes the place of the file's; an angle that of parallel rays.
    again = scene_of(str(tmp_path / "a.toml"), SceneOptions(view="side", ortho=2.0)).camera
    assert again == View(view="side", ortho=2.0, aperture=0.1)
    camera = Camera((1, 2, 3), (0, 0, 1), (0, 0, 1), ortho=2.0, aperture=0.3, focus=4.0)
    assert View.of(camera).over(Camera()) == camera


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--eye", "-1,2"], "eye: expected X,Y,Z"),
        (["--up=0,0,nan"], "up: expected X,Y,Z"),
        (["--fov", "-3"], "fov_deg = -3.0"),
        (["--fov", "40", "--ortho", "2"], "--fov, --ortho"),
        (["--ortho=-2"], "ortho = -2.0"),
        (["--aperture", "-1"], "aperture = -1.0"),
        (["--view", "bakc"], "did you mean back?"),
        (["--eye", "-1,2,3", "--target=-1,2,3"], "eye and target are both (-1.0, 2.0, 3.0)"),
        (["--eye", "0,5,0", "--target", "0,0,0"], "up (0.0, 1.0, 0.0) is along the view"),
    ],
)
def test_wrong_values_are_one_line(options, said, capsys, tmp_path):
    with pytest.raises(SystemExit) as stop:
        main(["render", *options, "--size", "8x8", "--mesh", "plane", "--env", "studio", "-o", str(tmp_path / "a.png")])
    lines = capsys.readouterr().err.strip().splitlines()
    assert stop.value.code == 2 and said in lines[-1] and not list(tmp_path.iterdir())


def test_a_scene_without_a_camera_is_seen_as_before():
    from glcloth.picture.frame import default_camera, mesh_camera

    mesh = load_mesh("sphere")
    assert default_camera(mesh, Scene()) == mesh_camera(mesh, 4 / 3)
