"""Method `reference` with shadows: against the twin and rays that meet every triangle, and closed forms."""

import numpy as np
import pytest
from lambertian import LambertianReference
from test_truth import model

from glcloth.fabric import builtin_fabrics, load_fabric
from glcloth.geometry import shapes
from glcloth.geometry.camera import Camera
from glcloth.geometry.mesh import build_mesh
from glcloth.light.environment import cube_map_of_gaussians
from glcloth.light.lights import Lights, SphericalGaussians, Suns
from glcloth.methods.albedo import diffuse_albedo
from glcloth.twins import cloth, intersect

LIGHTS = Lights(
    SphericalGaussians([[0, 1, 0], [0.6, 0.3, 0.7]], [2.0, 20.0], [[0.5, 0.6, 0.8], [3.0, 2.5, 2.0]]),
    Suns([[-0.5, 0.6, 0.6]], [[5.0, 4.5, 4.0]], 0.0),  # a point: the sum has one direction
)
SIZE, CUBE = (24, 18), 8
SCENE = dict(lights=LIGHTS, method="reference", cube=CUBE, size=SIZE, background=False)


def curved_sheets():
    """A bowl and a small plate above it: both sides are seen, each hides light from the other."""
    bowl, triangles, uv, _ = shapes.plane(1.0, 6)
    bowl[:, 2] = 0.8 * (bowl[:, 0] ** 2 + 0.5 * bowl[:, 1] ** 2)
    plate, more, uv_2, _ = shapes.plane(0.35, 2)
    plate = plate @ np.array([[0.9, 0.0, -0.43], [0.0, 1.0, 0.0], [0.43, 0.0, 0.9]]) + [0.05, 0.1, 0.35]
    return build_mesh(
        "sheets",
        np.concatenate([bowl, plate]),
        np.concatenate([triangles, more + len(bowl)]),
        np.concatenate([uv, uv_2]),
    )


def closed_box(half=1.0):
    """The twelve triangles of a cube about the origin."""
    corners = np.array([[x, y, z] for x in (-half, half) for y in (-half, half) for z in (-half, half)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])


def first_hits(mesh, origin, directions):
    """(triangle, v, w) of the nearest hit of rays from one point; triangle -1: none. Every triangle, float64."""
    a, b, c = (mesh.positions[mesh.triangles[:, k]].astype(float) - origin for k in range(3))
    found = np.full((len(directions), 3), -1.0)
    for n, d in enumerate(directions):
        axis = intersect.longest_axis(d)
        t, v, w, _ = intersect.hit_triangle(
            *(intersect.axis_last(p, np.full(len(p), axis)) for p in (a, b, c)),
            intersect.shear_of(intersect.axis_last(d, axis)),
        ).T
        t = np.where(t > 0, t, np.inf)
        if np.isfinite(t.min()):
            k = t.argmin()
            found[n] = k, v[k], w[k]
    return found


def directions_and_flux(cube):
    omega, solid_angle, radiance = cube_map_of_gaussians(LIGHTS.gaussians, cube)
    omega = np.concatenate([omega, LIGHTS.suns.direction])
    flux = np.concatenate([radiance * solid_angle[:, None], LIGHTS.suns.irradiance])
    return omega, flux, np.concatenate([solid_angle, [0.0]])


def bounced_radiance(mesh, hits, directions, albedo, offset):
    """Radiance [D, 3] that the hits send back: albedo / pi times the irradiance between the vertices of each triangle."""
    omega, flux, _ = directions_and_flux(CUBE)
    known = {}

    def irradiance(vertex, side):
        if (vertex, side) not in known:
            N = side * mesh.normals[vertex].astype(float)
            cos = omega @ N
            up = cos > 0
            free = first_hits(mesh, mesh.positions[vertex] + offset * N, omega[up])[:, 0] < 0
            known[vertex, side] = (flux[up] * (cos[up] * free)[:, None]).sum(0)
        return known[vertex, side]

    result = np.zeros((len(hits), 3))
    for n, (k, v, w) in enumerate(hits):
        if k >= 0:
            corners = mesh.triangles[int(k)]
            a, b, c = mesh.positions[corners].astype(float)
            side = 1 if np.cross(b - a, c - a) @ directions[n] < 0 else -1
            E = sum(weight * irradiance(i, side) for weight, i in zip((1 - v - w, v, w), corners, strict=True))
            result[n] = albedo / np.pi * E
    return result


@pytest.mark.parametrize("shadows, bounce", [("sun", True), ("full", False), ("full", True)])
def test_a_picture_is_the_twin_with_rays_that_meet_every_triangle(renderer, shadows, bounce):
    mesh, fabric = curved_sheets(), load_fabric("linen")
    camera = Camera((0.9, 1.1, 2.0), (0, 0, 0.1))
    changes = dict(fabric=fabric, mesh=mesh, camera=camera, shadows=shadows, bounce=bounce)
    picture = renderer.render(**SCENE, **changes)
    unshadowed = renderer.render(**SCENE, **changes | {"shadows": "off"})
    buffer = renderer.gbuffer
    N, x, p = (
        np.frombuffer(t.read(), "f4").reshape(SIZE[1], SIZE[0], 4).astype(float)
        for t in map(buffer.frame, ("frame_N", "frame_x", "frame_p"))
    )
    omega, flux, solid_angle = directions_and_flux(CUBE)
    edges = mesh.positions[mesh.triangles].astype(float)
    offset = 0.05 * np.linalg.norm(edges - np.roll(edges, 1, axis=1), axis=2).mean()
    checked = darker = 0
    for row, column in np.argwhere(N[..., 3] != 0)[:: 17 if bounce and shadows == "full" else 5]:
        n, t = N[row, column, :3], x[row, column, :3]
        frame = np.stack([t, N[row, column, 3] * np.cross(n, t), n])
        ray = buffer.ray_from_pixel @ [column + 0.5, row + 0.5, 1.0]
        omega_o = frame @ (-ray / np.linalg.norm(ray))
        up = omega @ n > 0
        hits = first_hits(mesh, p[row, column, :3], omega[up])
        if shadows == "sun":
            hits[: up[:-1].sum()] = -1
        light = np.where(hits[:, :1] >= 0, 0.0, flux[up])
        if shadows == "full" and bounce:
            back = bounced_radiance(mesh, hits, omega[up], diffuse_albedo(fabric), offset)
            light = light + solid_angle[up, None] * back
        expected = cloth.L_o(omega_o[None], omega[up] @ frame.T, light, *model(fabric))[0]
        got = picture[SIZE[1] - 1 - row, column, :3]
        assert got == pytest.approx(expected, rel=2e-3, abs=1e-5)
        checked += 1
        darker += got.sum() < 0.98 * unshadowed[SIZE[1] - 1 - row, column, :3].sum()
    assert checked > 6 and darker > 0


def test_a_flat_sheet_hides_nothing(renderer):
    """Also with a bounce: no direction above the sheet meets it."""
    for name in ("plane", "linen"):
        scene = dict(SCENE, mesh="plane", fabric="linen" if name == "plane" else "velvet")
        expected = renderer.render(**scene, shadows="off")
        for changes in ({"shadows": "sun"}, {"shadows": "full", "bounce": False}, {"shadows": "full"}):
            assert renderer.render(**scene, **changes) == pytest.approx(expected, rel=1e-5, abs=1e-7)


def test_a_ball_hides_nothing_from_itself(renderer):
    """Rays above the smooth horizon leave a convex mesh, whose flat triangles they would meet from the flat surface."""
    scene = dict(SCENE, mesh="sphere", fabric="silk_crepe_de_chine", size=(32, 24))
    expected, got = (renderer.render(**scene, shadows=s) for s in ("off", "full"))
    apart = np.abs(got - expected)[..., :3].sum(-1)
    assert apart.mean() < 1e-3 * expected[..., :3].sum(-1).mean()
    assert np.quantile(apart[expected[..., 3] > 0], 0.98) < 1e-3 * expected[..., :3].sum(-1).mean()


@pytest.mark.parametrize("light", ["sg", "map"])
def test_a_sheet_in_a_closed_box_is_black(renderer, light):
    sheet, triangles, _, _ = shapes.plane(0.8, 2)
    box, sides = closed_box()
    mesh = build_mesh("boxed", np.concatenate([sheet, box]), np.concatenate([triangles, sides + len(sheet)]))
    scene = dict(mesh=mesh, camera=Camera((0.1, 0.2, 0.8), (0, 0, 0)), method="reference", light=light, cube=CUBE)
    scene |= dict(size=SIZE, background=False)
    for changes in ({"shadows": "full"}, {"shadows": "full", "bounce": False}):
        picture = renderer.render(**scene, **changes)
        assert (picture[..., 3] > 0).all() and not picture[..., :3].any()
    assert renderer.render(**scene, shadows="off")[..., :3].min() > 0


def test_a_bounce_between_two_parallel_sheets(renderer):
    """A point far inside a gap of width h between squares of side s, light from all around of radiance 1, Lambertian.

    The outer side of either sheet sees all of the light, the inner side only what comes in at the rim: the other sheet
    fills the form factor F, E = pi (1 - F) there, and what comes back is albedo (1 - F) per unit radiance and F.
    """
    albedo, s, h = 0.6, 1.0, 1.0
    low, triangles, uv, _ = shapes.plane(s, 32)
    high = low + np.array([0, 0, h])
    mesh = build_mesh(
        "gap", np.concatenate([low, high]), np.concatenate([triangles, triangles + len(low)]), np.concatenate([uv, uv])
    )
    lights = Lights(SphericalGaussians([[0, 0, 1]], [0.0], [[1.0, 1.0, 1.0]]))
    lambertian = LambertianReference(renderer.ctx, [albedo] * 3)
    kept = renderer.method("reference")
    renderer.stage.cloths[0].methods["reference"] = lambertian
    try:
        camera = Camera((0.0, -0.9, 0.6), (0.0, 0.0, 0.0), fov_deg=1.0)
        scene = dict(mesh=mesh, lights=lights, camera=camera, method="reference", cube=64, size=(1, 1))
        got = [
            renderer.render(**scene, background=False, shadows=shadows, bounce=bounce)[0, 0, 0]
            for shadows, bounce in (("off", False), ("full", False), ("full", True))
        ]
    finally:
        renderer.stage.cloths[0].methods["reference"] = kept
    # At the middle of the lower sheet: by the integral over the upper one, and for its points the same over the lower.
    x = (np.arange(80) + 0.5) / 80 - 0.5
    X, Y = np.meshgrid(x * s, x * s)
    area = (s / 80) ** 2

    def form_factor(at_x, at_y):
        d2 = (X - at_x) ** 2 + (Y - at_y) ** 2 + h * h
        return (h * h / (np.pi * d2**2)).sum() * area

    kernel = h * h / (np.pi * (X**2 + Y**2 + h * h) ** 2) * area
    F = form_factor(0.0, 0.0)
    exitance = np.array([1.0 - form_factor(a, b) for a, b in zip(X.ravel(), Y.ravel(), strict=True)])
    back = albedo * (kernel.ravel() * exitance).sum()
    assert got[0] == pytest.approx(albedo, rel=5e-3)
    assert got[1] == pytest.approx(albedo * (1 - F), rel=5e-3)
    assert got[2] == pytest.approx(albedo * (1 - F + back), rel=5e-3)


def test_steps_do_what_render_does(renderer):
    scene = dict(SCENE, mesh=curved_sheets(), shadows="full")
    expected = renderer.render(**scene)
    renderer.stage.cloths[0].methods.pop("reference")  # so that the vertices are lit anew, between the steps
    frame = renderer.prepare(**scene)
    shares = list(renderer.steps(frame, rows=lambda: 7))
    assert shares[0][0] == 0 and shares[-1][0] == shares[-1][1]
    assert np.array_equal(renderer.target.read(), expected)


@pytest.mark.parametrize("name", builtin_fabrics())
def test_albedo_is_the_white_furnace(renderer, name):
    """A Gaussian of sharpness 0 and radiance 1 is a white furnace; the mean over omega_o weighs by its cosine."""
    z, weight = np.polynomial.legendre.leggauss(12)
    z, weight = (z + 1) / 2, weight / 2
    phi = (np.arange(12) + 0.5) * np.pi / 6
    r = np.sqrt(1 - z * z)
    omega_o = np.stack([np.outer(r, np.cos(phi)), np.outer(r, np.sin(phi)), np.outer(z, np.ones(12))], -1)
    furnace = SphericalGaussians([[0, 0, 1]], [0.0], [[1.0, 1.0, 1.0]])
    L = renderer.radiance(name, omega_o.reshape(-1, 3), furnace, method="reference").reshape(12, 12, 3)
    expected = (2 * (weight * z)[:, None] * L.mean(1)).sum(0)
    assert diffuse_albedo(load_fabric(name)) == pytest.approx(expected, rel=0.02)
