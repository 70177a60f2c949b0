"""Light through cloth under an environment: one sheet and two against closed forms, direct against reference."""

import numpy as np
import pytest

from glcloth.fabric import Transmission, load_fabric
from glcloth.geometry import shapes
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import build_mesh
from glcloth.geometry.props import Objects
from glcloth.gpu.gbuffer import Drawn
from glcloth.light.environment import from_array
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.picture.cloths import Cloth
from glcloth.tracing.energy import directional_albedo, hemisphere, mean_albedo, reflection_limit
from glcloth.twins import sheet
from glcloth.twins.cloth import f_cloth
from glcloth.visibility.finer import cuts
from glcloth.visibility.sheets import sees_through

SIZE = (9, 7)
DARK = from_array("dark", np.full((8, 16, 3), 1e-9))
NO_LIGHT = Lights(SphericalGaussians([[0, 1, 0]], [0.0], [[0.0, 0.0, 0.0]]))
EVEN = Lights(SphericalGaussians([[0, 1, 0]], [0.0], [[1.0, 1.0, 1.0]]))
WHITE = from_array("white", np.ones((8, 16, 3)))
FABRICS = ("sheer_voile", "linen_curtain")


def sheets(*heights):
    """Flat squares across z, far wider than what is seen of them."""
    parts = [shapes.plane(40.0, 4) for _ in heights]
    positions = [part[0] + [0, 0, z] for part, z in zip(parts, heights, strict=True)]
    begins = np.cumsum([0] + [len(part[0]) for part in parts])
    triangles = [part[1] + begin for part, begin in zip(parts, begins, strict=False)]
    return build_mesh(
        "sheets", np.concatenate(positions), np.concatenate(triangles), np.concatenate([p[2] for p in parts])
    )


def camera(slant_deg=0.0):
    """Whose middle pixel looks along one direction, `slant_deg` from the sheets' normal in the plane of yarn 1."""
    a = np.radians(slant_deg)
    return Camera((100 * np.sin(a), 0.0, 100 * np.cos(a)), (0.0, 0.0, 0.0), (0, 1, 0), 1.0)


def omega(slant_deg):
    a = np.radians(slant_deg)
    return np.array([np.sin(a), 0.0, np.cos(a)])


def straight(t, o):
    return sheet.T_straight(o, t.k_a, t.k_t, np.array(t.tau), t.rho, t.diffuse)


def even(t, o):
    return sheet.T_lambert(o, t.k_t, np.array(t.tau), t.rho, t.diffuse)


def render(renderer, mesh, slant, lights, fabric="sheer_voile", environment=WHITE, **changes):
    changes = {"size": SIZE, "method": "direct", "shadows": "full", "bounce": False, **changes}
    picture = renderer.render(
        mesh=mesh, camera=camera(slant), lights=lights, fabric=fabric, environment=environment, **changes
    )
    return picture[3, 4]


@pytest.mark.parametrize("slant", [0, 50])
@pytest.mark.parametrize("layers", [1, 4])
def test_layers_before_a_white_background(renderer, layers, slant):
    """Each lets T_s of what is behind it through; without light of their own the rest is black."""
    t = load_fabric("sheer_voile").transmission
    got = render(renderer, sheets(*np.linspace(-1, 1, layers)), slant, NO_LIGHT)
    np.testing.assert_allclose(got, straight(t, omega(slant)) ** layers, rtol=3e-3)


def test_a_background_that_is_off_leaves_transparency(renderer):
    t = load_fabric("sheer_voile").transmission
    got = render(renderer, sheets(0.0), 0, NO_LIGHT, background=False)
    np.testing.assert_allclose(got, [0, 0, 0, 1 - straight(t, omega(0)).mean()], atol=2e-3)


@pytest.mark.parametrize("method", ["direct", "reference"])
@pytest.mark.parametrize("fabric", FABRICS)
def test_white_furnace(renderer, fabric, method):
    """Light from everywhere: what is reflected and mirrored, and passes evenly and straight on; never more than comes."""
    t = load_fabric(fabric).transmission
    for slant in (0, 60):
        o = omega(slant)
        expected = directional_albedo(load_fabric(fabric), o) + even(t, o) + straight(t, o)
        albedo = reflection_limit(load_fabric(fabric)) * mean_albedo(load_fabric(fabric))
        expected = expected + sheet.R_beside(
            o, t.k_a, t.k_t, np.array(t.tau), t.rho, t.diffuse, t.eta_1, t.eta_2, albedo
        )
        got = render(renderer, sheets(0.0), slant, EVEN, fabric, method=method, cube=16)
        np.testing.assert_allclose(got, expected, rtol=0.02)
        assert (got <= 1.0).all()


@pytest.mark.parametrize("method", ["direct", "reference"])
@pytest.mark.parametrize("behind", [False, True])
def test_a_sun_from_behind(renderer, method, behind):
    """All that the yarns send of one light; through a second sheet of its light T_s is left."""
    t = load_fabric("linen_curtain").transmission
    tau, o = np.array(t.tau), omega(20)
    i = np.array([0.3, 0.2, -1.0]) / np.sqrt(1.13)
    lights = Lights(NO_LIGHT.gaussians, Suns([i], [[5.0, 4.0, 3.0]]))
    black = from_array("black", np.full((8, 16, 3), 1e-9))
    mesh = sheets(0.0, -1.0) if behind else sheets(0.0)
    got = render(renderer, mesh, 20, lights, "linen_curtain", black, method=method, cube=4)

    def through(o, light):
        f = sheet.f_through(
            i * [1, 1, -1], o * [1, 1, -1], t.k_t, t.rho, t.roughness, t.eta_1, t.eta_2, t.diffuse, t.roughness_p
        )
        return f * sheet.absorption(i, o, tau) * light

    E = np.array([5.0, 4.0, 3.0])
    expected = through(o, E)
    if behind:
        expected = through(o, E * straight(t, i)) + straight(t, o) * through(o, E)
    np.testing.assert_allclose(got, expected, rtol=0.015)


def test_a_sun_through_cloth_lights_the_ground(renderer):
    """Its shadow on an object has T_s of the light."""
    t = load_fabric("sheer_voile").transmission
    lights = Lights(NO_LIGHT.gaussians, Suns([[0.0, 1.0, 0.0]], [[1.0, 1.0, 1.0]]))
    positions, triangles, uv, _ = shapes.plane(20.0, 4)
    cloth = build_mesh("cloth", positions[:, [0, 2, 1]] * [1, 1, -1] + [0, 2.0, 0], triangles, uv)
    below = Camera((0.0, 1.0, 1.0), (0.0, 0.0, 0.0), (0, 1, 0), 10.0)
    got = renderer.render(
        mesh=cloth, camera=below, lights=lights, fabric="sheer_voile", environment=WHITE, size=SIZE, ground="0",
        ground_color=(1.0, 1.0, 1.0), bounce=False,
    )  # fmt: skip
    T = straight(t, np.array([0, 0, 1.0])) @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(got.mean((0, 1)), T / np.pi, rtol=0.02)


def strip(place, cells=48, width=2):
    """A sheet of so many cells, `width` of them across, in [-1, 1]: no finer vertices are wanted."""
    u, v = (
        grid.ravel()
        for grid in np.meshgrid(np.linspace(-1, 1, cells + 1), (np.arange(width + 1) - width / 2) * 2 / cells)
    )
    first = (np.arange(width)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    corners = [first, first + 1, first + cells + 2], [first, first + cells + 2, first + cells + 1]
    return build_mesh("strip", np.stack(place(u, v), 1), np.concatenate([np.stack(three, 1) for three in corners]))


def test_the_mirror_of_yarns_shows_no_light_that_is_hidden(renderer):
    """A sheet seen at a slant, and a wall that hides the light which it would mirror toward the eye."""
    # The wall stands across the strip, a little beside its middle.
    level, upright = strip(lambda u, v: (u, v, 0 * u)), strip(lambda u, v: (0 * u - 0.05, v, u))
    cloths = [Cloth(level, load_fabric("sheer_voile")), Cloth(upright, load_fabric("linen"))]
    hidden, seen = omega(-75), omega(20)
    pictures = [
        renderer.render(
            cloths=cloths, camera=camera(75), lights=SphericalGaussians(axes, sharpness, amplitudes), size=SIZE, bounce=False,
            environment=DARK,
        )
        for axes, sharpness, amplitudes in (
            ([hidden, seen], [50.0, 2.0], [[9.0] * 3, [1.0] * 3]),
            ([seen], [2.0], [[1.0] * 3]),
        )
    ]  # fmt: skip
    np.testing.assert_allclose(pictures[0][3, 4], pictures[1][3, 4], rtol=0.01)
    assert pictures[1][3, 4].min() > 0.01


def test_a_sun_from_behind_a_sheet_that_is_fine(renderer):
    """Rays to the sun start from its other side, and meet it no more."""
    t, i, o = load_fabric("linen_curtain").transmission, np.array([0.3, 0.2, -1.0]) / np.sqrt(1.13), omega(20)
    fine = strip(lambda u, v: (u, v, 0 * u), 800, 1)
    got = renderer.render(
        mesh=fine, camera=Camera(tuple(0.5 * o), (0.0, 0.0, 0.0), fov_deg=1.0), fabric="linen_curtain", size=(9, 9),
        lights=Lights(NO_LIGHT.gaussians, Suns([i], [[5.0, 4.0, 3.0]])), environment=DARK, shadows="sun", threads=False,
    )  # fmt: skip
    f = sheet.f_through(
        i * [1, 1, -1], o * [1, 1, -1], t.k_t, t.rho, t.roughness, t.eta_1, t.eta_2, t.diffuse, t.roughness_p
    )
    assert cuts([fine], 1600, 0) == 0
    np.testing.assert_allclose(got[4, 4], f * sheet.absorption(i, o, np.array(t.tau)) * [5.0, 4.0, 3.0], rtol=0.015)


@pytest.mark.parametrize("worn", [True, False])
def test_what_lets_no_light_through_hides_the_sun_from_sheer_cloth(renderer, worn):
    """A square of two triangles over sheer cloth whose triangles are cut for suns: another cloth, or an object."""
    low = sheets(0.0)
    square = build_mesh("square", *(lambda s: (0.2 * s[0] + [0, 0, 5.0], s[1]))(shapes.plane(40.0, 1)))
    assert cuts([low], len(low.triangles), 2) > 0 and len(square.triangles) == 2
    cloths = [Cloth(low, load_fabric("sheer_voile")), *([Cloth(square, load_fabric("linen"))] if worn else [])]
    objects = None if worn else Objects((square,), (np.full((2, 3), 0.5),), graded=(True,))
    lights = Lights(NO_LIGHT.gaussians, Suns([[0.0, 0.0, 1.0]], [[3.0, 3.0, 3.0]]))
    look = dict(lights=lights, environment=DARK, size=(17, 16), shadows="sun", fabric="linen")
    below = Camera((0.0, 0.0, 4.0), (0.0, 0.0, 0.0), fov_deg=120.0)
    got = renderer.render(cloths=cloths, objects=objects, camera=below, **look)[..., 1]
    lit = got[:, 0].mean()
    assert lit > 0.01 and got[7:9, 5:12].max() < 0.01 * lit


def test_one_colour_is_enough_to_see_through_cloth():
    assert sees_through(Transmission(k_a=0.0, k_t=1.0, diffuse=0.0, tau=(0.0, 20.0, 20.0)))
    assert not sees_through(Transmission(k_a=0.0, k_t=0.0))


def test_rays_through_sheets_remember_the_first(renderer):
    """Of two sheer sheets over cloth the nearer one sends light back to it."""
    places = [strip(lambda u, v, z=z: (u, v, 0 * u + z)) for z in (0.0, 0.2, 0.3)]
    cloths = [
        Cloth(mesh, load_fabric(name)) for mesh, name in zip(places, ("linen", *2 * ["sheer_voile"]), strict=True)
    ]
    renderer.render(cloths=cloths, camera=camera(), lights=EVEN, environment=WHITE, size=SIZE, shadows="full")
    lowest = renderer.stage.cloths[0].visibility.vertices
    hits = np.frombuffer(lowest._data["hit_data"].read(4 * lowest.share * len(lowest.probes.points)), "u4")
    met = hits[hits != 0xFFFFFFFF] // 2
    first = lowest.hit_vertices.first_vertex
    assert len(met) > 1000 and met.min() >= first[1] and met.max() < first[2]


def test_what_a_sheet_scatters_is_of_the_light_on_its_other_side(renderer):
    """Under a sheer sheet that alone sees the sky: `reference` finds on cloth what is let straight on and what is scattered."""
    linen, voile = load_fabric("linen"), load_fabric("sheer_voile")
    between = Camera((0.0, 0.0, 0.6), (0.0, 0.0, 0.0), (0, 1, 0), 1.0)
    got = renderer.render(
        cloths=[Cloth(sheets(0.0), linen), Cloth(sheets(1.0), voile)], camera=between, lights=EVEN, environment=WHITE,
        size=SIZE, method="reference", cube=6,
    )[3, 4]  # fmt: skip
    d, weight = hemisphere()
    f = f_cloth(d, np.array([[0.0, 0.0, 1.0]]), *linen.arrays()) * (weight / d[:, 2])[:, None]
    t = voile.transmission
    expected = (f * (straight(t, d) + even(t, d))).sum(0)
    np.testing.assert_allclose(got, expected, rtol=0.03)
    assert (expected > 1.2 * (f * straight(t, d)).sum(0)).all()


def folds():
    """A curtain's folds, lit and seen from both sides."""
    positions, triangles, uv, _ = shapes.plane(1.0, 16)
    x, y = positions[:, 0], positions[:, 1]
    positions[:, 2] = 0.08 * np.sin(14 * x + 0.6 * y) * (1.2 - y) + 0.05 * np.sin(5 * y)
    return build_mesh("folds", positions, triangles, uv)


@pytest.mark.parametrize("bounce", [False, True])
def test_direct_is_the_reference(renderer, bounce):
    """Folds before and behind each other, a sun behind them, most of the light through cloth."""
    lights = Lights(
        SphericalGaussians([[0.1, 0.9, -0.4], [0.5, 0.3, -0.8]], [1.5, 8.0], [[0.5, 0.55, 0.6], [1.2, 1.0, 0.8]]),
        Suns([[-0.3, 0.5, -0.8]], [[1.5, 1.4, 1.2]]),
    )
    scene = dict(mesh=folds(), lights=lights, fabric="sheer_voile", size=(24, 18), bounce=bounce, environment=WHITE)
    direct, reference = (renderer.render(method=method, cube=8, **scene) for method in ("direct", "reference"))
    covered = renderer.gbuffer.covered()
    Y = reference[covered].mean(-1)
    error = direct[covered].mean(-1) - Y
    limits = (0.03, 0.02) if bounce else (0.02, 0.01)
    assert np.abs(error).mean() < limits[0] * Y.mean() and abs(error.mean()) < limits[1] * Y.mean()


def test_layers_of_light(renderer):
    """What comes through is a layer of the picture; all layers are the picture; a fabric without has none, and no memory."""
    scene = dict(mesh=sheets(0.0), camera=camera(), lights=EVEN, environment=WHITE, size=SIZE)
    out = renderer.render(fabric="sheer_voile", aovs="direct,bounce,transmission,background", **scene)
    t, o = load_fabric("sheer_voile").transmission, omega(0)
    np.testing.assert_allclose(out["transmission"][3, 4], straight(t, o) + even(t, o), rtol=0.01)
    whole = sum(out[name] for name in ("direct", "bounce", "transmission", "background"))
    np.testing.assert_allclose(whole, out["beauty"], atol=1e-5)
    assert renderer.target.layered
    renderer.render(fabric="linen", **scene)
    sheer = renderer.render(fabric="sheer_voile", **scene)
    assert renderer.target.layered
    np.testing.assert_array_equal(renderer.render(fabric="sheer_voile", **scene), sheer)
    renderer.render(fabric="linen", **scene)
    assert not renderer.target.layered


def test_the_adaptive_rate_and_steps_see_through(renderer):
    scene = dict(mesh=folds(), lights=EVEN, fabric="linen_curtain", size=(48, 36), environment=WHITE)
    full = renderer.render(**scene)
    adaptive = renderer.render(adaptive=True, **scene)
    assert np.abs(adaptive - full).mean() < 0.01 * full.mean()
    frame = renderer.prepare(**scene)
    for _ in renderer.steps(frame, rows=lambda: 7):
        pass
    np.testing.assert_array_equal(renderer.target.read()[..., :3], full)


@pytest.mark.parametrize("method", ["direct", "reference"])
def test_a_shadow_that_is_caught_behind_cloth(renderer, method):
    """Through the sheet one sees the background, dimmed by what the sheet hides of the sun from the ground."""
    t = load_fabric("sheer_voile").transmission
    lights = Lights(NO_LIGHT.gaussians, Suns([[0.0, 1.0, 0.0]], [[1.0, 1.0, 1.0]]))
    positions, triangles, uv, _ = shapes.plane(20.0, 4)
    cloth = build_mesh("cloth", positions[:, [0, 2, 1]] * [1, 1, -1], triangles, uv)
    scene = dict(
        mesh=cloth, lights=lights, fabric="sheer_voile", size=SIZE, ground="catcher", bounce=False, method=method, cube=4,
        camera=Camera((0.0, 6.0, 0.5), (0.0, 0.0, 0.0), (0, 1, 0), 1.0),
    )  # fmt: skip
    black = from_array("black", np.full((8, 16, 3), 1e-9))
    white, dark = (renderer.render(environment=env, **scene)[3, 4] for env in (WHITE, black))
    o = np.array([0.0, 0.5, 6.0]) / np.hypot(0.5, 6.0)
    hidden = 1 - straight(t, np.array([0, 0, 1.0])) @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(white - dark, straight(t, o) * (1 - hidden), rtol=0.02)


def stack(*fabrics):
    """Sheets one behind the other, each a cloth of its own; what keeps the meshes is the caller."""
    meshes = [sheets(-float(number)) for number in range(len(fabrics))]
    return meshes, lambda *names: [
        Cloth(mesh, load_fabric(name)) for mesh, name in zip(meshes, names or fabrics, strict=True)
    ]


def test_another_cloth_of_several_becomes_sheer(renderer):
    """The meshes stay, and so does what hides what; but what is seen behind it changes."""
    _, dressed = stack("sheer_voile", "linen", "velvet")
    scene = dict(camera=camera(), lights=EVEN, environment=WHITE, size=SIZE, bounce=False)
    renderer.render(cloths=dressed(), **scene)
    both = renderer.render(cloths=dressed("sheer_voile", "sheer_voile", "velvet"), **scene)
    renderer.render(cloths=dressed(), **{**scene, "camera": camera(30)})
    np.testing.assert_array_equal(
        renderer.render(cloths=dressed("sheer_voile", "sheer_voile", "velvet"), **scene), both
    )
    other = renderer.render(cloths=dressed("linen", "sheer_voile", "velvet"), **scene)
    assert np.abs(other - both).max() > 0.05


def test_layers_of_many_cloths_are_compared_one_by_one(renderer, monkeypatch):
    """What a layer holds names all before and behind it: compared as a tree it would take 32 times as long a surface."""
    _, dressed = stack("sheer_voile", "linen", "linen", "linen")
    scene = dict(cloths=dressed(), camera=camera(), lights=EVEN, environment=WHITE, size=SIZE, shadows="off")
    first = renderer.render(**scene)
    compared, equal = [], Drawn.__eq__

    def counted(one, other):
        compared.append(one)
        return equal(one, other)

    monkeypatch.setattr(Drawn, "__eq__", counted)
    np.testing.assert_array_equal(renderer.render(**scene), first)
    assert 0 < len(compared) < 200


def test_bright_sheer_cloth_bounces_no_more_than_it_reflects(renderer):
    """Its reflection is dimmed where with what passes it would be more than comes: also that of light from fold to fold."""
    sheer = load_fabric("sheer_voile")
    yarn = sheer.yarn[0].changed(albedo=(0.9, 0.9, 0.9))
    bright = sheer.changed(yarn=(yarn, yarn), transmission=sheer.transmission.changed(k_t=0.9))
    assert reflection_limit(bright) < 0.9
    scene = dict(mesh=folds(), lights=EVEN, fabric=bright, size=(24, 18), environment=WHITE)
    direct, reference = (renderer.render(method=method, cube=8, **scene) for method in ("direct", "reference"))
    covered = renderer.gbuffer.covered()
    ratio = direct[covered].mean() / reference[covered].mean()
    assert ratio == pytest.approx(1.0, abs=0.02)
