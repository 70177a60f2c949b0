"""The reference with shadows against Mitsuba 3: the same cloth, camera and lights, a Lambertian in place of the fabric.

python tests/measure/mitsuba.py [ENVIRONMENT...] [--mesh drape] [--size 80x60] [--cube 32] [--spp 256] [--flat]

Needs the optional extra `check` (`pip install 'glcloth[check]'`: Mitsuba 3). Mitsuba gets the mesh as a file, its own
camera, the sum of the Gaussians as an environment map, the suns as directional emitters, and its path tracer. It draws
three times as many pixels a side, of which the middle one of nine is where a sample of ours lies. Two rows per
environment: direct light, and direct light with one bounce. Printed, of the pixels that see cloth, in % of the mean
of Mitsuba's picture: the mean of |difference| of luminance, the difference of the means, the noise that Mitsuba's
picture still has (from its two halves), and the 95th percentile of |difference|; and FLIP. Strips
ours | Mitsuba | difference x 8 are written.
"""

import sys
import tempfile
from pathlib import Path

import common
import numpy as np
from lambertian import LambertianReference

import glcloth
from glcloth.color import luminance
from glcloth.geometry.mesh_files import load_mesh, save_mesh
from glcloth.light.environment import direction_from_uv
from glcloth.metrics import flip
from glcloth.progress import track

ALBEDO = (0.6, 0.5, 0.3)
MAP_HEIGHT = 512
FINER = 3  # pixels of Mitsuba's a side for one of ours


def lights_as_map(gaussians):
    """The sum of the spherical Gaussians as an equirectangular map."""
    rows, columns = np.arange(MAP_HEIGHT) + 0.5, np.arange(2 * MAP_HEIGHT) + 0.5
    v, u = np.meshgrid(rows / MAP_HEIGHT, columns / (2 * MAP_HEIGHT), indexing="ij")
    return gaussians.radiance(direction_from_uv(u, v)).astype(np.float32)


def mitsuba_scene(mi, mesh_file, camera, size, lights, spp):
    """The scene of Mitsuba."""
    scene = {
        "type": "scene",
        "cloth": {
            "type": "ply",
            "filename": str(mesh_file),
            "bsdf": {
                "type": "twosided",
                "nested": {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(ALBEDO)}},
            },
        },
        "environment": {"type": "envmap", "bitmap": mi.Bitmap(lights_as_map(lights.gaussians))},
        "sensor": {
            "type": "perspective",
            "fov": camera.fov_deg,
            "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(
                origin=list(camera.eye), target=list(camera.target), up=list(camera.up)
            ),
            "film": {
                "type": "hdrfilm",
                "width": FINER * size[0],
                "height": FINER * size[1],
                "rfilter": {"type": "box"},
            },
            "sampler": {"type": "multijitter", "sample_count": spp},
        },
    }
    for number, (direction, irradiance) in enumerate(zip(lights.suns.direction, lights.suns.irradiance, strict=True)):
        scene[f"sun_{number}"] = {
            "type": "directional",
            "direction": (-direction).tolist(),
            "irradiance": {"type": "rgb", "value": irradiance.tolist()},
        }
    return mi.load_dict(scene)


def mitsuba_picture(mi, scene, max_depth, spp, what):
    """The two halves of Mitsuba's picture [2, H, W, 3], each of spp samples a pixel."""
    integrator = mi.load_dict({"type": "path", "max_depth": max_depth, "rr_depth": 1000, "hide_emitters": True})
    pictures = [np.array(mi.render(scene, integrator=integrator, spp=spp, seed=half)) for half in track((0, 1), what)]
    return np.stack(pictures)[:, FINER // 2 :: FINER, FINER // 2 :: FINER, :3]


def errors(ours, halves, covered):
    """The numbers of one row."""
    theirs = halves.mean(0)
    a, b = luminance(ours[covered].astype(float)), luminance(theirs[covered])
    noise = np.abs(luminance(halves[0][covered]) - luminance(halves[1][covered])).mean() / 2
    apart = np.abs(a - b)
    values = np.array([apart.mean(), a.mean() - b.mean(), noise, np.percentile(apart, 95)])
    return [*(float(v) for v in 100 * values / b.mean()), f"{flip(ours, theirs.astype(np.float32)):.4f}"]


def measure(mi, renderer, mesh, mesh_file, environment, options):
    base = dict(env=environment, size=options.size, background=False, method="reference", cube=options.cube)
    for light, max_depth, bounce in (("direct", 2, False), ("direct and one bounce", 3, True)):
        frame = renderer.prepare(mesh=mesh, shadows="full", bounce=bounce, **base)
        picture = renderer.render_frame(frame)
        ours, covered = picture[..., :3], picture[..., 3] > 0
        scene = mitsuba_scene(mi, mesh_file, frame.camera, frame.scene.size, frame.lights, options.spp)
        halves = mitsuba_picture(mi, scene, max_depth, options.spp, f"Mitsuba, {light}: samples")
        common.row(f"{Path(environment).name}, {light}", *errors(ours, halves, covered))
        theirs = halves.mean(0).astype(np.float32) * covered[..., None]
        common.write_strip(options.out / f"{Path(environment).stem}-{max_depth - 2}.png", ours, theirs)


def main():
    options = common.options(
        __doc__, ["studio", "sky"], mesh="drape", size="80x60", cube=32, spp=256, flat=False, out=Path("out/mitsuba")
    )
    try:
        import mitsuba as mi

        mi.set_variant("scalar_rgb")
    except ImportError as error:
        sys.exit(f"mitsuba.py: skipped, Mitsuba 3 is not usable here ({error}); pip install 'glcloth[check]'")
    mesh = load_mesh(options.mesh)
    common.head("environment, light", "mean", "bias", "noise", "95 %", "FLIP")
    with glcloth.Renderer() as renderer, tempfile.TemporaryDirectory() as folder:
        common.set_method(renderer, "reference", LambertianReference(renderer.ctx, ALBEDO, options.flat))
        mesh_file = Path(folder) / "mesh.ply"
        save_mesh(mesh_file, mesh)
        for environment in options.environments:
            measure(mi, renderer, mesh, mesh_file, environment, options)


main()
