"""Faults that were once planted and that no test noticed: signs of turns and offsets, the reach of rays, barriers."""

import numpy as np
import pytest
import trimesh

from glcloth.color import luminance
from glcloth.errors import InputError
from glcloth.fabric import load_fabric
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.mesh_files import load_mesh
from glcloth.gpu.buffers import Buffer, TextureBuffer
from glcloth.gpu.programs import Compute, Programs, programs
from glcloth.light import equirect, suns
from glcloth.light.environment import from_array
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.picture import adaptive
from glcloth.picture.adaptive import AdaptiveRate
from glcloth.picture.frame import Cloth
from glcloth.picture.sequence import orbit
from glcloth.picture.sequence_files import pose_files
from glcloth.twins import visibility as twin


@pytest.mark.parametrize("degrees", [0.0, 50.0, -115.0])
def test_the_background_turns_with_the_lights(renderer, degrees):
    """The brightest pixel of the background lies where the light of the fit does."""
    radiance = np.full((64, 128, 3), 0.01)
    radiance[28:33, 40:45] = 50.0
    x, y = np.meshgrid(np.linspace(-1, 1, 3), np.linspace(-1, 1, 3))
    mesh = build_mesh("m", np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), np.array([[0, 1, 3], [1, 4, 3]]))
    frame = renderer.prepare(
        mesh=mesh, environment=from_array("spot", radiance), env_rotate=degrees, lobes=4, size=(64, 48)
    )
    lights = frame.lights
    strengths = [
        *luminance(lights.suns.irradiance),
        *(luminance(lights.gaussians.amplitude) / (1 + lights.gaussians.sharpness)),
    ]
    toward = [*lights.suns.direction, *lights.gaussians.axis][int(np.argmax(strengths))]
    camera = Camera((0, 0, 0), tuple(toward + np.array([0.05, 0.03, 0.02])), fov_deg=60.0)
    frame = renderer.prepare(
        mesh=mesh, environment=frame.environment, env_rotate=degrees, lobes=4, size=(64, 48), camera=camera
    )
    target = renderer._targets.get((64, 48))
    target.clear()
    renderer.draw_background(frame, target.framebuffer)
    picture = luminance(target.read()[..., :3])
    assert picture.max() > 10.0
    row, column = np.argwhere(picture > 0.5 * picture.max()).mean(0)
    seen = camera.ray_from_pixel((64, 48)) @ (column + 0.5, 48 - row - 0.5, 1.0)
    assert seen @ toward > np.cos(np.radians(6.0)) * np.linalg.norm(seen)


def test_normals_of_a_file_stand_on_a_surface_that_is_scaled_unevenly(tmp_path):
    slope = np.array([[0, 0, 0], [1, 0, 1], [0, 1, 0], [1, 1, 1]], float)  # z = x
    part = trimesh.Trimesh(slope, [[0, 1, 2], [2, 1, 3]], vertex_normals=4 * [[-1, 0, 1]], process=False)
    scene = trimesh.Scene()
    scene.add_geometry(part, transform=np.diag([1.0, 2.0, 5.0, 1.0]))
    scene.export(tmp_path / "a.glb")
    mesh = load_mesh(tmp_path / "a.glb")
    assert np.abs(mesh.normals @ np.array([-5.0, 0.0, 1.0])) == pytest.approx(np.sqrt(26.0), rel=1e-4)


def test_samples_lie_where_they_say_for_the_rasteriser_and_for_rays():
    """A sample a quarter pixel to the right and up is the pixel's centre of a picture moved by that."""
    camera, size, offset = Camera((1.0, 2.0, 4.0), (0.2, 0.1, 0.0), fov_deg=40.0), (64, 48), (0.25, 0.125)
    pixel = np.array([20.5, 30.5])
    ray = camera.ray_from_pixel(size, offset) @ (*pixel, 1.0)
    assert ray == pytest.approx(camera.ray_from_pixel(size) @ (*(pixel + offset), 1.0))
    clip = camera.clip_from_world(size, 0.1, 100.0, offset) @ (*(np.array(camera.eye) + 3.0 * ray), 1.0)
    assert (clip[:2] / clip[3] + 1) / 2 * size == pytest.approx(pixel, abs=1e-6)


def test_poses_before_the_first_go_back_to_a_gap(tmp_path):
    """Frames that move with the cloth before them want those, as far as there is no gap."""
    for number in (0, 1, 3, 4, 5, 6):
        (tmp_path / f"{number:02d}.ply").touch()
    pattern = str(tmp_path / "%02d.ply")
    assert list(pose_files(pattern, 6, start=5)) == [3, 4, 5]
    assert list(pose_files(pattern, 7, start=3)) == [3, 4, 5, 6] and list(pose_files(pattern, 2)) == [0, 1]
    with pytest.raises(InputError, match=r"02\.ply"):
        pose_files(pattern, 5)


def test_the_turntable_goes_counter_clockwise_seen_from_above():
    assert orbit(Camera((0, 1, 3), (0, 0, 0)), 90.0).eye == pytest.approx((3, 1, 0))


def flat(size, height):
    x = np.array([[-1, 0, 1], [1, 0, 1], [-1, 0, -1], [1, 0, -1]], float) * size + (0, height, 0)
    return build_mesh("flat", x, np.array([[0, 1, 2], [2, 1, 3]]), x[:, [0, 2]])


def test_what_is_far_away_casts_its_shadow(renderer):
    """A cloth 500 m above hides the sun from one of 2 m."""
    lights = Lights(SphericalGaussians([[0, 1, 0]], [1.0], [[1e-3] * 3]), Suns([[0, 1, 0]], [[3.0] * 3]))
    linen = load_fabric("linen")
    camera = Camera((0.0, 3.0, 3.0), (0, 0, 0), fov_deg=20.0)
    low, high = Cloth(flat(1.0, 0.0), linen), Cloth(flat(5.0, 500.0), linen)
    look = {
        "lights": lights,
        "camera": camera,
        "size": (16, 12),
        "quality": "draft",
        "shadows": "sun",
        "background": False,
    }
    open_, hidden = (renderer.render(cloths=cloths, **look)[..., :3].max() for cloths in ([low], [low, high]))
    assert hidden < 0.05 * open_


@pytest.mark.parametrize(("ring", "count"), [(7.5, 1), (30.0, 0)])
def test_a_sun_stands_out_from_its_surroundings(ring, count):
    """The disc holds 8 times the light of the ring about it, or twice."""
    height, width = 180, 360
    v, u = (np.arange(n) + 0.5 for n in (height, width))
    omega = equirect.direction_from_uv(u[None] / width, v[:, None] / height)
    angle = np.degrees(
        np.arccos(np.clip(omega @ equirect.direction_from_uv(0.5 + 0.5 / width, 0.5 + 0.5 / height), -1, 1))
    )
    radiance = np.full((height, width, 3), 0.01)
    radiance[angle < 2.4] += (100.0 - 10.0 * angle[angle < 2.4])[:, None]
    # Half the ring, so that its median, the background, stays.
    radiance[(angle > 2.6) & (angle < 4.9) & (u < width / 2)] += ring
    assert len(suns.split_suns(radiance.astype(np.float32))[0]) == count


def test_bounced_light_of_front_and_back_stays_on_its_side(ctx):
    """Two probes about one vertex: their sums, four texels each, are front, its direction, back, its direction."""
    rng = np.random.default_rng(3)
    sums = rng.random((2, 4, 4)).astype("f4") + 0.5
    weights = np.array([0.25, 0.75], "f4")
    data, rows, terms = TextureBuffer(ctx, 16), TextureBuffer(ctx, 8, "rg32ui"), TextureBuffer(ctx, 8, "rg32ui")
    data.write(sums.reshape(-1, 4))
    rows.write(np.array([[0, 2]], "u4"))
    terms.write(np.stack([np.arange(2, dtype="u4"), weights.view("u4")], 1))
    means = Buffer(ctx, 64)
    programs(ctx).compute("passes/visibility/bounce_spread.comp").run(
        1, sum_data=data, row_data=rows, spread_data=terms, Means=means, vertex_count=1
    )
    total = np.einsum("p,psc->sc", weights, sums)
    expected = total / total[[0, 0, 2, 2], 3:]
    assert np.frombuffer(means.read(), "f4").reshape(4, 4) == pytest.approx(expected, rel=1e-5)
    for thing in (data, rows, terms, means):
        thing.release()


def test_a_probe_gathers_each_side_by_itself(ctx):
    """Radiance, its direction and the share of rays that surfaces end, front and back: by NumPy, from made-up hits."""
    rng, N = np.random.default_rng(4), np.array([0.6, 0.0, 0.8])
    omega = rng.normal(size=(24, 3))
    omega /= np.linalg.norm(omega, axis=1, keepdims=True)
    hits = np.where(np.arange(24) % 3 == 0, 0xFFFFFFFF, rng.integers(0, 6, 24)).astype("u4")
    sent = np.c_[rng.random((6, 3)) + 0.2, rng.uniform(-0.5, 0.8, 6)]
    vertices = np.zeros((3, 3, 4))
    vertices[:, 1, :3] = [[0, 1, 0], [1, 0, 0], [0, 0.6, 0.8]]
    texels = {
        "probe_data": np.array([[0, 0, 0, 0], [*N, 0]]),
        "direction_data": np.c_[omega, np.zeros(24)],
        "radiance_data": sent,
        "vertex_data": vertices.reshape(-1, 4),
    }
    data = {name: TextureBuffer(ctx, rows.astype("f4")) for name, rows in texels.items()}
    data["hit_data"] = TextureBuffer(ctx, hits, "r32ui")
    sums = Buffer(ctx, 64)
    programs(ctx).compute("passes/visibility/bounce_gather.comp").run(
        (1, 1), data, Sums=sums, first_probe=np.array([0, *[1] * 8]), probe_count=1, class_directions=24, direction_count=24,
        flat_share=0.3,
    )  # fmt: skip
    met = hits != 0xFFFFFFFF
    at = np.where(met, hits, 0)
    cosine = np.abs((vertices[at // 2, 1, :3] * omega).sum(1))
    L = np.where(met, np.maximum(1.0 + sent[at, 3] * (cosine - 2 / 3), 0.0), 0.0)[:, None] * sent[at, :3]
    expected = []
    for w in np.moveaxis(twin.response_to(omega @ N, np.full(24, 0.3)), -1, 0):
        Y = w * luminance(L)
        expected += [[*(w @ L), w.sum()], [*(Y @ omega), w[met].sum()]]
    np.testing.assert_allclose(np.frombuffer(sums.read(), "f4").reshape(4, 4), expected, rtol=1e-4, atol=1e-5)
    for thing in (*data.values(), sums):
        thing.release()


def test_vertices_send_on_what_comes_from_either_side(ctx):
    """Reflected on its own side and let through to the other, with a guess of later bounces by what each side sees hidden."""
    own = np.array([[0.1, 0.2, 0.3, 0.0], [0.4, 0.1, 0.2, 0.0]])
    bounced = np.array([[0.5, 0.4, 0.3, 0], [0, 0, 0, 0.7], [0.2, 0.6, 0.9, 0], [0, 0, 0, 0.2]])
    share, passed = np.array([0.5, 0.4, 0.3]), np.array([0.1, 0.2, 0.05])
    data = {
        "radiance_data": TextureBuffer(ctx, own.astype("f4")),
        "bounced_data": TextureBuffer(ctx, bounced.astype("f4")),
    }
    sent = Buffer(ctx, 32)
    programs(ctx).compute("passes/visibility/bounce_again.comp").run(
        1, data, Radiance=sent, first_item=0, vertex_count=1, own_reflectance=False, reflectance=share, upright=0.0, later=True,
        passed=passed, reflectance_data=data["radiance_data"],
    )  # fmt: skip
    front, back = (
        bounced[2 * k, :3] * twin.later_bounces((share + passed)[None], np.array([bounced[2 * k + 1, 3]]))[0]
        for k in (0, 1)
    )
    expected = own[:, :3] + [share * front + passed * back, share * back + passed * front]
    np.testing.assert_allclose(np.frombuffer(sent.read(), "f4").reshape(2, 4)[:, :3], expected, rtol=1e-4)
    for thing in (*data.values(), sent):
        thing.release()


KERNEL = """#version 430
layout(local_size_x = 1) in;
#include "inputs/visibility/seen_layers.glsl"
uniform vec3 omega;
layout(std430) writeonly buffer Out { float result; };
void main() { fetch_layers(ivec2(0)); result = V_parts(omega) + 0.0 * albedo.x; }
"""


def test_the_parts_of_the_broad_light_are_read_where_they_lie(ctx):
    values = np.linspace(0, 1, 16).reshape(4, 4)  # V_0.., top: number 3; low 4 to 7, middle 8 to 11
    seen = ctx.texture_array((1, 1, 4), 4, values.astype("f4").tobytes(), dtype="f4")
    result = Buffer(ctx, 4)
    program = Programs(ctx).compute("<parts>", None, {"<parts>": KERNEL})
    for omega in ([0.9, 0.3, 0.1], [-0.5, 0.6, 0.5], [0.1, -0.1, 0.95], [-0.6, -0.6, 0.3]):
        omega = np.array(omega) / np.linalg.norm(omega)
        program.run(1, seen=seen, top_number=3, broad_number=4, omega=omega, Out=result)
        got = np.frombuffer(result.read(), "f4")[0]
        assert got == pytest.approx(twin.from_bands(omega, values[1], values[2], values[0, 3]), abs=1e-5)
    program.release()
    seen.release()
    result.release()


def test_pixels_that_are_shaded_by_a_list_look_as_all_others(renderer, monkeypatch):
    """Cosines of 0.03 to 0.05, and no value between neighbours is good enough, so that the list holds what is left."""
    camera = Camera((0.0, 0.12, 3.0), (0, 0, 0), fov_deg=25.0)
    lights = Lights(SphericalGaussians([[0, 0.3, -1]], [20.0], [[1, 1, 1]]))
    frame = renderer.prepare(
        mesh=flat(1.0, 0.0), fabric="satin_charmeuse_front", lights=lights, camera=camera, size=(64, 48), shadows="off"
    )
    full = renderer.render(frame.scene, mesh=frame.mesh, lights=lights, camera=camera)
    surface = renderer.stage.cloths[0]
    surface.adaptive_rate = surface.adaptive_rate or AdaptiveRate(renderer.ctx)
    monkeypatch.setattr(surface.adaptive_rate, "tolerance", -1.0)
    sparse = renderer.render(frame.scene, mesh=frame.mesh, lights=lights, camera=camera, adaptive=True)
    covered = renderer.gbuffer.covered()
    assert surface.adaptive_rate.shaded() > 100
    assert sparse[covered] == pytest.approx(full[covered], rel=1e-4)


class Recorder:
    """Stands for a context and for a linked program, and notes what is asked of it."""

    def __init__(self):
        self.calls = []

    def __getattr__(self, name):
        return lambda *of: self.calls.append(name)


def test_a_barrier_follows_every_dispatch(ctx, monkeypatch):
    """Software rasterisers forgive its absence, GPUs do not."""
    program = programs(ctx).compute("passes/visibility/bounce_spread.comp")
    monkeypatch.setattr(Compute, "bind", lambda *of, **own: None)
    recorder = Recorder()
    monkeypatch.setattr(program, "ctx", recorder)
    monkeypatch.setattr(program, "linked", recorder)
    monkeypatch.setattr(Recorder, "buffer", None, raising=False)
    program.run(64)
    program.run_groups((2, 2, 1))
    program.run_indirect(recorder)
    assert recorder.calls == ["run", "memory_barrier", "run", "memory_barrier", "run_indirect", "memory_barrier"]


def test_a_barrier_follows_the_draw_that_writes_a_list(renderer, monkeypatch):
    """Of the adaptive rate: between the fragments that note pixels and the dispatch that reads them."""
    calls = []
    draw, run = adaptive.draw_screen, Compute.run_indirect

    def noted(program, *of, **own):
        calls.append(program.path)
        draw(program, *of, **own)

    class Context:
        def __init__(self, ctx):
            self.ctx = ctx

        def __getattr__(self, name):
            if name == "memory_barrier":
                calls.append(name)
            return getattr(self.ctx, name)

    monkeypatch.setattr(adaptive, "draw_screen", noted)
    monkeypatch.setattr(Compute, "run_indirect", lambda *of, **own: (calls.append("list"), run(*of, **own)))
    frame = renderer.prepare(mesh="sphere", lobes=2, size=(32, 24), shadows="off", adaptive=True, quality="draft")
    surface = renderer.stage.take(frame)[0]
    surface.adaptive_rate = surface.adaptive_rate or adaptive.AdaptiveRate(renderer.ctx)
    monkeypatch.setattr(surface.adaptive_rate, "ctx", Context(renderer.ctx))
    renderer.draw(frame)
    last = calls.index("passes/picture/adaptive_fill.frag")
    assert calls[last + 1 :] == ["memory_barrier", "list"]
