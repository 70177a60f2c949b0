"""Method `path`: what it draws has the density it says, and its pictures are closed forms or those of the reference."""

import io
from dataclasses import replace

import moderngl
import numpy as np
import pytest
from PIL import Image
from scipy import stats

import glcloth
from glcloth.color import luminance
from glcloth.errors import InputError
from glcloth.fabric import load_fabric
from glcloth.geometry.mesh import Mesh
from glcloth.geometry.props import Objects
from glcloth.geometry.raw import Material
from glcloth.gpu.buffers import Buffer
from glcloth.gpu.programs import programs
from glcloth.light.environment import Environment
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.picture.cloths import Cloth
from glcloth.picture.openings import Opacity
from glcloth.picture.pace import Pace
from glcloth.picture.path import PathPictures
from glcloth.picture.prints import Print
from glcloth.tracing.energy import mean_albedo, reflection_limit
from glcloth.tracing.path import PathSums, PathTracer
from glcloth.tracing.path_world import PathWorld
from glcloth.tracing.sky import alias_cells, alias_table, sun_records
from glcloth.twins.cloth import f_cloth
from glcloth.twins.sheet import R_limited, R_sheet, T_lambert, T_straight

FABRICS = ["linen", "silk_crepe_de_chine", "satin_charmeuse_front", "satin_charmeuse_back", "silk_shot", "velvet"]
WHITE = Environment.from_array(np.ones((16, 32, 3)), name="white")
DRAW = """#version 430
layout(local_size_x = 64) in;
#include "inputs/gpu/item.glsl"
#include "inputs/tracing/path_fabric.glsl"
layout(std430) buffer Directions { vec4 directions[]; };
uniform bool draws;
uniform vec3 omega_o;
void main() {
    int i = item();
    Fabric fabric = fetch_fabric(0);
    uvec3 hash = hash3(uvec3(uint(i), 5u, 7u));
    vec3 omega = draws ? drawn_direction(fabric, omega_o, unit_square(hash.zz).x, unit_square(hash.xy)) : directions[i].xyz;
    float pdf;
    vec3 f = f_and_pdf(fabric, omega, omega_o, pdf);
    directions[i] = vec4(omega, pdf);
}
"""


def plane(size=2.0):
    """A square of cloth in the plane z = 0."""
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * size / 2
    return Mesh.from_arrays(corners, [[0, 1, 2], [0, 2, 3]], np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]), name="plane")


def shifted(*step):
    """Corners of a small square elsewhere."""
    return plane(0.1).positions + np.array(step)


def slanted(theta, phi=0.5):
    """A direction above the plane."""
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def albedo_of(fabric, omega_o):
    """What it reflects toward omega_o under even light, [3], by quadrature in z: the model does not vanish at the horizon."""
    x, w = np.polynomial.legendre.leggauss(100)
    z, phi = np.repeat((x + 1) / 2, 200), np.tile(2 * np.pi * (np.arange(200) + 0.5) / 200, 100)
    s = np.sqrt(1 - z * z)
    f = f_cloth(np.stack([s * np.cos(phi), s * np.sin(phi), z], -1), omega_o[None], *fabric.arrays())
    return (f * (np.repeat(w / 2, 200) * 2 * np.pi / 200)[:, None]).sum(0)


def directions_of(renderer, fabric, omega_o, values, draws):
    """Directions [N, 3] and their density [N]."""
    tracer = PathTracer(renderer.ctx)
    tracer.take(PathWorld(((plane(), fabric),)))
    buffer = Buffer(renderer.ctx, np.pad(values, ((0, 0), (0, 1))).astype("f4"))
    program = programs(renderer.ctx).compute("draw", None, {"draw": DRAW})
    program.run(
        len(values), tracer.fabric_inputs(), Directions=buffer, draws=draws, omega_o=tuple(omega_o), cloth_count=1
    )
    found = np.frombuffer(buffer.read(16 * len(values)), "f4").reshape(-1, 4)
    return found[:, :3].astype(float), found[:, 3].astype(float)


@pytest.mark.parametrize("name", FABRICS)
def test_drawn_directions_have_their_density(renderer, name):
    rows, sectors, fine, count = 24, 36, 6, 64 * 2000
    z = np.repeat(-1 + 2 * (np.arange(rows * fine) + 0.5) / (rows * fine), sectors * fine)
    phi = np.tile(-np.pi + 2 * np.pi * (np.arange(sectors * fine) + 0.5) / (sectors * fine), rows * fine)
    s = np.sqrt(1 - z * z)
    grid = np.stack([s * np.cos(phi), s * np.sin(phi), z], -1)
    for theta in (0.3, 1.1):
        omega_o = slanted(theta)
        fabric = load_fabric(name)
        # Half of the sphere has a density; what is drawn below the horizon is lost, and of no density.
        drawn, _ = directions_of(renderer, fabric, omega_o, np.zeros((count, 3)), True)
        _, density = directions_of(renderer, fabric, omega_o, grid, False)
        above = drawn[drawn[:, 2] > 1e-3]
        expected = density.reshape(rows, fine, sectors, fine).sum((1, 3)).ravel() * 4 * np.pi / len(grid) * count
        place = (np.floor((above[:, 2] + 1) / 2 * rows).clip(0, rows - 1) * sectors).astype(int)
        place += (
            np.floor((np.arctan2(above[:, 1], above[:, 0]) / np.pi + 1) / 2 * sectors).clip(0, sectors - 1).astype(int)
        )
        found = np.bincount(place, minlength=rows * sectors)
        assert abs(found.sum() / expected.sum() - 1) < 0.01
        # A bin's own quadrature errs by up to some percent where a thread's pole lies in it.
        many = expected > 20
        z_score = (found - expected)[many] / np.sqrt(expected[many] + (0.03 * expected[many]) ** 2)
        assert stats.chi2.sf((z_score**2).sum(), many.sum() - 1) > 1e-4, name


def test_suns_are_drawn_as_often_as_they_are_bright():
    """What a draw brings, times how often it is drawn, is the sun's irradiance."""
    irradiance = np.array([[1.0, 2.0, 3.0], [9.0, 9.0, 1.0], [0.1, 0.1, 0.1]])
    rows = sun_records(Suns(np.eye(3), irradiance, [0.01, 0.02, 0.03]))
    chance = np.diff(rows[:, 0, 3], prepend=0.0)
    np.testing.assert_allclose(chance[:, None] * rows[:, 1, :3], irradiance, rtol=1e-5)
    assert chance.sum() == pytest.approx(1.0) and chance[1] > chance[0] > chance[2]
    np.testing.assert_allclose(rows[:, 1, 3], np.tan([0.01, 0.02, 0.03]), rtol=1e-6)


def test_cells_are_drawn_as_bright_as_they_are():
    rng = np.random.default_rng(1)
    share = rng.random(500) ** 6
    share /= share.sum()
    keep, other = alias_table(share)
    got = np.bincount(other, (1 - keep) / 500, 500) + keep / 500
    np.testing.assert_allclose(got, share, atol=1e-12)
    radiance = np.zeros((64, 128, 3), np.float32)
    radiance[20, 30] = 100.0
    cells = alias_cells(radiance).reshape(256, 512, 4)
    solid = 2 * np.pi / 512 * -np.diff(np.cos(np.linspace(0, np.pi, 257)))
    np.testing.assert_allclose((cells[..., 2] * solid[:, None]).sum(), 1.0, rtol=1e-5)
    assert cells[80:84, 120:124, 2].min() > 100 * cells[200, :, 2].max() > 0


def furnace(renderer, fabric, theta, **changes):
    """The mean light of a plane of cloth under even light, and its standard error."""
    view = glcloth.View(eye=tuple(3 * slanted(theta)), target=(0, 0, 0), ortho=0.2)
    look = {"method": "path", "light": "map", "environment": WHITE, "size": (24, 16), "camera": view, **changes}
    renderer.render(mesh=plane(), fabric=fabric, **look)
    sums = renderer.path_sums()
    return sums.picture[..., :3].mean((0, 1)), np.sqrt((sums.standard_error**2).sum()) / sums.squares.size, sums


@pytest.mark.parametrize(
    ("name", "theta"), [("linen", 0.4), ("silk_crepe_de_chine", 1.2), ("satin_charmeuse_front", 0.7)]
)
def test_even_light_shows_the_albedo(renderer, name, theta):
    fabric = load_fabric(name)
    mean, error, sums = furnace(renderer, fabric, theta, spp=128)
    expected = albedo_of(fabric, slanted(theta))
    assert abs(luminance(mean) - luminance(expected)) < 4 * error + 0.004 * luminance(expected)
    assert error < 0.005 * luminance(expected)
    # All pixels show the same: their spread is what each says of itself.
    spread = luminance(sums.picture[..., :3].astype(float)).std()
    assert 0.85 < spread / np.sqrt((sums.standard_error.astype(float) ** 2).mean()) < 1.15


@pytest.mark.parametrize("name", ["sheer_voile", "linen_curtain"])
def test_even_light_through_a_sheet(renderer, name):
    fabric, theta = load_fabric(name), 0.6
    t, omega_o, limit = fabric.transmission, slanted(theta), reflection_limit(fabric)
    straight = T_straight(omega_o, t.k_a, t.k_t, np.array(t.tau), t.rho, t.diffuse)
    evenly = T_lambert(omega_o, t.k_t, np.array(t.tau), t.rho, t.diffuse)
    R = R_limited(R_sheet(omega_o, t.k_t, t.rho, t.eta_1, t.eta_2), straight + evenly, limit * mean_albedo(fabric))
    expected = straight + evenly + R + limit * albedo_of(fabric, omega_o)
    mean, error, _ = furnace(renderer, fabric, theta, spp=128)
    # T_lambert is a fit.
    np.testing.assert_allclose(mean, expected, atol=4 * error + 0.01 * expected.max())
    alone, error, sums = furnace(renderer, fabric, theta, spp=64, background=False)
    np.testing.assert_allclose(alone, expected - straight, atol=4 * error + 0.01 * expected.max())
    np.testing.assert_allclose(sums.picture[..., 3].mean(), 1 - straight.mean(), atol=0.02)


def bowl(rows=24, sectors=48):
    """The lower half of a sphere, seen from within."""
    theta, phi = np.pi / 2 * np.arange(1, rows + 1) / rows, 2 * np.pi * np.arange(sectors) / sectors
    ring = [[np.sin(t) * np.cos(p), -np.cos(t), np.sin(t) * np.sin(p)] for t in theta for p in phi]
    at = lambda r, s: 1 + r * sectors + s % sectors  # noqa: E731
    faces = [[0, at(0, s + 1), at(0, s)] for s in range(sectors)]
    for r in range(rows - 1):
        for s in range(sectors):
            a, b, c, d = at(r, s), at(r, s + 1), at(r + 1, s), at(r + 1, s + 1)
            faces += [[a, b, c], [b, d, c]]
    return Mesh.from_arrays(np.array([[0.0, -1, 0], *ring]), faces, name="bowl")


@pytest.mark.parametrize(("bounce", "expected"), [(True, 0.8 / 1.2), (False, 0.4)])
def test_a_white_bowl_under_even_light(renderer, bounce, expected):
    """Every point of it sees half of a sphere of itself and half of the sky: B = rho (B + L) / 2."""
    mesh = bowl()
    objects = Objects((mesh,), (np.full((len(mesh.triangles), 3), 0.8),))
    view = glcloth.View(eye=(0.0, 0.5, 0.0), target=(0.0, -1.0, 0.0), up=(0.0, 0.0, 1.0), fov_deg=50.0)
    far = Mesh.from_arrays(shifted(0, -9.0, 0), plane().triangles, name="far")
    look = {"method": "path", "light": "map", "environment": WHITE, "size": (24, 18), "spp": 64, "bounce": bounce}
    picture = renderer.render(mesh=far, objects=objects, camera=view, **look)
    assert renderer.path_sums().cover.min() == 64
    np.testing.assert_allclose(np.asarray(picture).mean((0, 1)), expected, rtol=0.012)


def test_a_sun_on_the_ground_is_exact(renderer):
    direction = np.array([0.3, 0.8, 0.2]) / np.linalg.norm([0.3, 0.8, 0.2])
    dark = SphericalGaussians(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)))
    lights = Lights(dark, Suns(direction[None], np.array([[2.0, 1.0, 0.5]]), 0.0))
    view = glcloth.View(eye=(0.0, 3.0, 0.01), target=(0.0, 0.0, 0.0), fov_deg=40.0)
    look = {"method": "path", "ground": 0.0, "ground_color": (0.5, 0.5, 0.5), "size": (16, 12), "spp": 4}
    far = Mesh.from_arrays(shifted(9.0, 0.1, 0), plane().triangles, name="far")
    picture = renderer.render(mesh=far, lights=lights, camera=view, **look)
    expected = 0.5 / np.pi * direction[1] * np.array([2.0, 1.0, 0.5])
    np.testing.assert_allclose(np.asarray(picture)[4:8, 4:12], np.broadcast_to(expected, (4, 8, 3)), rtol=1e-4)


@pytest.mark.parametrize("light", ["sg", "map"])
def test_one_event_is_the_reference_without_bounce(renderer, light):
    look = dict(mesh="drape", fabric="silk_crepe_de_chine", env_rotate=60.0, size=(32, 24), bounce=False)
    look |= dict(light=light, ground="auto", background=False, cube=16, env="studio" if light == "map" else "sky")
    reference = np.asarray(renderer.render(method="reference", spp=4, **look), float)
    frame = renderer.prepare(method="path", spp=128, **look)
    picture = np.asarray(renderer.render_frame(frame), float)
    both = (picture[..., 3] > 0.999) & (reference[..., 3] > 0.999)
    inside = both & np.roll(both, 1, 0) & np.roll(both, -1, 0) & np.roll(both, 1, 1) & np.roll(both, -1, 1)
    a, b = luminance(picture[..., :3])[inside], luminance(reference[..., :3])[inside]
    error = np.sqrt((renderer.path_sums().standard_error[inside].astype(float) ** 2).sum()) / inside.sum()
    assert abs(a.mean() - b.mean()) < 4 * error + 0.004 * b.mean()


def test_samples_that_fill_their_intervals_leave_less_noise(renderer, monkeypatch):
    """Blocks of one are what independent samples would leave."""
    look = dict(mesh="drape", fabric="silk_crepe_de_chine", ground="auto", size=(24, 18), method="path", spp=64)
    renderer.render(**look)
    noise = renderer.path_sums().noise
    monkeypatch.setattr("glcloth.tracing.path.BLOCK", 1)
    renderer.render(**look)
    assert noise < 0.85 * renderer.path_sums().noise


def test_noise_is_found_from_whole_blocks():
    rng = np.random.default_rng(3)
    Y = rng.gamma(2.0, size=(3, 4, 45))
    blocks = Y[..., :40].reshape(3, 4, 5, 8).sum(-1)
    light = np.repeat(Y.sum(-1)[..., None], 3, -1)
    sums = PathSums(45, light, (blocks**2).sum(-1), Y[..., 40:].sum(-1), light, light, Y[..., 0])
    np.testing.assert_allclose(sums.standard_error, blocks.std(-1, ddof=1) / np.sqrt(8 * 45), rtol=1e-6)
    assert np.isinf(replace(sums, samples=15).standard_error).all()
    # Of two blocks, as when the noise is first looked at, the deviation alone would be 20 % too small in the mean.
    two = rng.normal(8.0, 1.0, (200, 200, 2))
    light = np.repeat(two.sum(-1)[..., None], 3, -1)
    few = PathSums(16, light, (two**2).sum(-1), 0.0 * two[..., 0], light, light, two[..., 0])
    assert few.noise == pytest.approx(100 / 8 / np.sqrt(2), rel=0.02)


def test_it_stops_at_the_noise_that_is_asked_for(renderer):
    look = dict(mesh="drape", method="path", size=(24, 18), light="sg", env="sky")
    renderer.render(noise=6.0, **look)
    few = renderer.path_sums()
    assert few.noise <= 6.0 and few.samples % 4 == 0
    renderer.render(noise=3.0, **look)
    assert 2.5 < renderer.path_sums().samples / few.samples < 6.0
    assert renderer.facts()["samples"] == renderer.path_sums().samples
    renderer.render(noise=0.001, spp=6, **look)
    assert renderer.path_sums().samples == 6
    # The window, which draws in parts, shows such scenes by another method.
    assert [total for _, total in renderer.steps(renderer.prepare(**look), rows=lambda: 24)][-1] == 1


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"shadows": "off"}, "shadows off"),
        ({"aovs": "bounce"}, "one sum"),
    ],
)
def test_what_it_cannot_do(renderer, changes, said):
    with pytest.raises(InputError, match=said):
        renderer.render(method="path", size=(16, 12), **changes)


def test_sheer_cloth_is_sampled_once_a_dispatch_and_all_is_freed(renderer):
    look = dict(mesh="drape", method="path", size=(16, 12), light="sg", env="sky", spp=3)
    for fabric, steps in (("linen", 1), ("sheer_voile", 3)):
        frame = renderer.prepare(fabric=fabric, **look)
        assert len([done for done, _ in renderer.steps(frame)]) == steps
    pictures = PathPictures(renderer.ctx)
    target = renderer.ctx.simple_framebuffer((16, 12), 4, dtype="f4")
    list(pictures.steps(frame, target, Pace()))
    buffers = held_buffers(pictures.tracer)
    assert len(buffers) > 10
    pictures.release()
    assert all(isinstance(buffer.buffer.mglo, moderngl.InvalidObject) for buffer in buffers)


def held_buffers(thing, seen=None):
    """All buffers that an object holds, through its own parts."""
    seen = set() if seen is None else seen
    if id(thing) in seen:
        return []
    seen.add(id(thing))
    if isinstance(thing, Buffer):
        return [thing]
    if isinstance(thing, dict | list | tuple):
        parts = list(thing.values() if isinstance(thing, dict) else thing)
    else:
        parts = list(vars(thing).values()) if type(thing).__module__.startswith("glcloth") else []
    return [buffer for part in parts for buffer in held_buffers(part, seen)]


RED, LEFT_OPEN = (0.5, 0.2, 0.1), np.repeat([[[0.0], [0.0], [1.0], [1.0]]], 2, 0).astype(np.float32)


def test_prints_colour_the_yarns(renderer):
    fabric = load_fabric("linen")
    colors = np.array([[RED, RED, (1.0, 1.0, 1.0), (1.0, 1.0, 1.0)]], np.float32)
    cloth = Cloth(plane(), fabric, Print(colors, (1.0, 1.0), False))
    theta = 0.4
    view = glcloth.View(eye=(0.0, *(3 * slanted(theta, np.pi / 2)[1:])), target=(0, 0, 0), ortho=1.0)
    look = dict(method="path", light="map", environment=WHITE, size=(32, 16), camera=view, spp=64)
    renderer.render(cloths=[cloth], **look)
    picture = renderer.path_sums().picture
    for part, color in ((picture[:, 6:10], RED), (picture[:, 22:26], (1.0, 1.0, 1.0))):
        expected = albedo_of(fabric.dyed(color), slanted(theta, np.pi / 2))
        np.testing.assert_allclose(part[..., :3].mean((0, 1)), expected, rtol=0.03)


@pytest.mark.parametrize("name", ["linen", "sheer_voile"])
def test_openings_are_seen_and_lit_through(renderer, name):
    """A sun over cloth whose left half is open, over a ground: there both see the ground as if there was no cloth."""
    dark = SphericalGaussians(np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)))
    lights = Lights(dark, Suns(np.array([[0.0, 1.0, 0.0]]), np.full((1, 3), 2.0)))
    flat = Mesh.from_arrays(plane().positions[:, [0, 2, 1]] * [1, 1, -1], plane().triangles, plane().uv, name="flat")
    cloth = Cloth(flat, load_fabric(name), opacity=Opacity(LEFT_OPEN, (1.0, 1.0), False))
    view = glcloth.View(eye=(0.0, 3.0, 0.0), target=(0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), ortho=1.0)
    look = dict(method="path", ground=-0.2, ground_color=(0.5, 0.5, 0.5), size=(32, 16), camera=view, lights=lights)
    picture = np.asarray(renderer.render(cloths=[cloth], spp=4, bounce=False, **look))
    light = 0.5 * 2.0 / np.pi
    np.testing.assert_allclose(picture[:, 6:10, :3], light, rtol=0.02)
    # Under the cloth itself the ground is dark, or dimmed by two layers: seen from below its half-plane, from aside.
    aside = glcloth.View(eye=(3.0, -0.1, 0.0), target=(0.5, -0.2, 0.0), ortho=0.02)
    under = np.asarray(renderer.render(cloths=[cloth], spp=4, **{**look, "camera": aside, "bounce": False}))
    t = cloth.fabric.transmission
    T = 0.0 if t is None else T_straight(np.array([0.0, 0, 1]), t.k_a, t.k_t, np.array(t.tau), t.rho, t.diffuse).max()
    ground = under[10:, :, :3].mean()
    assert ground < light * (T + 0.02)


def test_pictures_on_objects(renderer):
    file = io.BytesIO()
    Image.fromarray(np.array([[[255, 0, 0], [255, 0, 0], [0, 0, 255], [0, 0, 255]]], np.uint8)).save(file, "png")
    paper = Material("paper", (0.5, 0.5, 0.5), texture=file.getvalue())
    wall = plane()
    objects = Objects((wall,), (np.full((2, 3), 0.5),), materials=((paper,),), material_of=(np.zeros(2, int),))
    far = Mesh.from_arrays(shifted(0, -9.0, 0), plane().triangles, name="far")
    view = glcloth.View(eye=(0, 0, 3.0), target=(0, 0, 0), ortho=1.0)
    look = dict(method="path", light="map", environment=WHITE, size=(32, 16), camera=view, spp=64)
    picture = np.asarray(renderer.render(mesh=far, objects=objects, **look))
    np.testing.assert_allclose(picture[:, 6:10, :3].mean((0, 1)), [0.5, 0, 0], atol=0.01)
    np.testing.assert_allclose(picture[:, 22:26, :3].mean((0, 1)), [0, 0, 0.5], atol=0.01)
