"""Method `path` in the curtain's room against Mitsuba 3 and Cycles: the built-in room, a Lambertian sheet with even holes.

python tests/measure/room.py [--size 48x48] [--spp 256] [--frame 30] [--max-depth 24] [--straight .4] [--albedo .45,.4,.3]
    [--cycles]

Needs the optional extra `check` (Mitsuba 3), and with --cycles the extra `blender` (bpy). The sheet lets the share
`straight` go straight on in all directions and reflects as a Lambertian; in Mitsuba it is a mask over one, and `volpath`
samples light through it; in Cycles a mix with a transparent one. The room has its own colours, the lamp its place; the sky
is even. Printed for each: means, their difference in % of the mean, noise of ours, and the difference after means over 3x3
pixels with what both pictures' noise alone would make; samples per second and CPU second, noise of a pixel, and CPU seconds
that a pixel takes to 1 %.
"""

import os
import tempfile
import time
from pathlib import Path

import common
import numpy as np

import glcloth
from glcloth.color import luminance
from glcloth.curtain.paths import CurtainPaths
from glcloth.fabric import Transmission
from glcloth.geometry.mesh_files import save_mesh
from glcloth.gpu.programs import programs
from glcloth.light.environment import Environment
from glcloth.scene import Scene
from glcloth.tracing.path import PathTracer
from glcloth.visibility.sheets import sight

INCLUDE = "inputs/tracing/path_fabric.glsl"
SKY = 2.0


class Lambertian(PathTracer):
    """Cloth that reflects `albedo` evenly."""

    albedo = np.zeros(3)

    def _dress(self):
        super()._dress()
        rows = np.zeros((1, 8, 4), "f4")
        t = self._world.cloths[0][1].transmission
        end = len(self._world.cloths[0][0].triangles)
        rows[0, 1], rows[0, 2, 3] = (t.rho, t.k_a, t.k_t, t.diffuse), end
        rows[0, 3] = t.eta_1, t.eta_2, 1.0, 1.0
        rows[0, 4, :3] = self.albedo
        rows[0, 4, 3] = rows[0, 5, 2] = rows[0, 5, 3] = -1.0
        self._cloth.write(rows)

    def _program(self):
        text = (Path(glcloth.__file__).parents[1] / "glsl" / INCLUDE).read_text()
        head, _rest = text.split("// Radiance toward omega_o per unit", 1)
        text = (
            head
            + """
vec3 f_and_pdf(Fabric fabric, vec3 omega_i, vec3 omega_o, out float pdf) {
    pdf = min(omega_i.z, omega_o.z) > 0.0 ? omega_i.z / PI : 0.0;
    return texelFetch(cloth_data, CLOTH_TEXELS * 0 + 4).rgb * pdf;
}
vec3 drawn_direction(Fabric fabric, vec3 omega_o, float choice, vec2 u) { return cosine_direction(u); }
"""
        )
        defines, virtual, _ = sight(self.structure, self._sheer, "inputs/tracing/sight_either.glsl")
        virtual |= {"sky.glsl": self.sky.source, "sight.glsl": "inputs/tracing/sight_sheer.glsl", INCLUDE: text}
        return programs(self.ctx).compute("passes/tracing/path.comp", defines, virtual)


def mitsuba_scene(mi, cloth, walls, reflectances, shot, straight, albedo, spp):
    """The same scene."""

    def diffuse(color):
        return {
            "type": "twosided",
            "nested": {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(map(float, color))}},
        }

    camera = shot.camera
    scene = {
        "type": "scene",
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [SKY] * 3}},
        "lamp": {
            "type": "point", "position": list(shot.lighting.lamp.position),
            "intensity": {"type": "rgb", "value": list(shot.lighting.lamp.intensity)},
        },
        "cloth": {"type": "ply", "filename": cloth, "bsdf": {
            "type": "mask", "opacity": 1 - straight, "nested": diffuse(np.asarray(albedo) / (1 - straight))}},
        "sensor": {
            "type": "perspective", "fov": camera.fov_deg, "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(origin=list(camera.eye), target=list(camera.target), up=list(camera.up)),
            "film": {"type": "hdrfilm", "width": shot.size[0], "height": shot.size[1], "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": spp},
        },
    }  # fmt: skip
    for k, (file, color) in enumerate(zip(walls, reflectances, strict=True)):
        scene[f"wall_{k}"] = {"type": "ply", "filename": file, "face_normals": True, "bsdf": diffuse(color)}
    return mi.load_dict(scene)


def timed(render, spp):
    """Two halves of a picture [2, H, W, 3], and the wall and CPU seconds that both took."""
    begin, cpu = time.perf_counter(), time.process_time()
    halves = np.stack([render(spp // 2, seed) for seed in (1, 2)])
    return halves, time.perf_counter() - begin, time.process_time() - cpu


def block_means(picture):
    """Means over 3x3 pixels, of luminance."""
    Y = luminance(np.asarray(picture, float))
    h, w = (3 * (n // 3) for n in Y.shape)
    return Y[:h, :w].reshape(h // 3, 3, w // 3, 3).mean((1, 3))


options = common.options(
    __doc__,
    None,
    size="48x48",
    spp=256,
    frame=30,
    max_depth=24,
    straight=0.4,
    albedo="0.45,0.4,0.3",
    variant="llvm_ad_rgb",
    cycles=False,
)
import mitsuba as mi  # noqa: E402

mi.set_variant(options.variant)
straight, albedo = float(options.straight), np.array([float(v) for v in options.albedo.split(",")])
spp, depth = int(options.spp), int(options.max_depth)
with glcloth.Renderer() as renderer, tempfile.TemporaryDirectory() as folder:
    scene = Scene(curtain={}, size=options.size, frame=int(options.frame), method="path")
    show = renderer.show(scene, environment=Environment.from_array(np.full((16, 32, 3), SKY), name="even"))
    t = Transmission(rho=0.0, k_a=straight, k_t=0.0, tau=0.0, diffuse=0.0)
    show.fabric = show.fabric.changed(transmission=t)
    paths = CurtainPaths(renderer.ctx, show.room)
    paths.tracer = Lambertian(renderer.ctx)
    paths.tracer.albedo = albedo
    meshes, shot = show.simulation.meshes(), show.shot()
    for _ in paths.steps(meshes, shot, 1, vertices=depth):
        pass
    begin, cpu = time.perf_counter(), time.process_time()
    for _ in paths.steps(meshes, shot, spp, vertices=depth):
        pass
    ours_s, ours_cpu = time.perf_counter() - begin, time.process_time() - cpu
    sums = paths.tracer.sums()
    ours = sums.picture[..., :3]
    room = show.room
    files, colors = [], []
    for k, color in enumerate(room.reflectances):
        if (room.material == k).any():
            from glcloth.curtain.paths import faceted

            files.append(os.path.join(folder, f"wall_{k}.ply"))
            save_mesh(files[-1], faceted(room.positions[room.material == k]))
            colors.append(color)
    cloth = os.path.join(folder, "cloth.ply")
    save_mesh(cloth, show.simulation.mesh())
    theirs_scene = mitsuba_scene(mi, cloth, files, colors, shot, straight, albedo, spp)
    integrator = mi.load_dict({"type": "volpath", "max_depth": depth + 1 if depth > 1 else 2, "rr_depth": 5})
    np.asarray(mi.render(theirs_scene, integrator=integrator, spp=1, seed=9))

    def by_mitsuba(spp, seed):
        return np.asarray(mi.render(theirs_scene, integrator=integrator, spp=spp, seed=seed))

    others = {"Mitsuba": timed(by_mitsuba, spp)}
    if options.cycles:
        import cycles_room

        walls = [(room.positions[room.material == k], color) for k, color in enumerate(room.reflectances)]
        loaded = cycles_room.load(show.simulation.mesh(), walls, shot, SKY, straight, albedo, depth)
        file = Path(folder) / "cycles.exr"
        cycles_room.picture(loaded, 1, 9, file)
        others["Cycles"] = timed(lambda spp, seed: cycles_room.picture(loaded, spp, seed, file), spp)

count = ours[..., 0].size * spp
a = luminance(ours.astype(float))
own = np.sqrt((sums.standard_error.astype(float) ** 2).sum()) / a.size / a.mean()
own_blocks = np.sqrt((sums.standard_error.astype(float) ** 2).mean()) / 3 * np.sqrt(2 / np.pi)
own_pixel = sums.standard_error.mean() / a.mean()
common.head("", "ours", "theirs", "difference %", "our noise %", "3x3 %", "noise would be %")
for name, (halves, _wall, _cpu) in others.items():
    b = luminance(halves.mean(0).astype(float))
    blocks = np.abs(block_means(halves[0]) - block_means(halves[1])).mean() / 2
    apart = np.abs(block_means(ours) - block_means(halves.mean(0))).mean()
    common.row(name, a.mean(), b.mean(), 100 * (a.mean() / b.mean() - 1), 100 * own,
               100 * apart / b.mean(), 100 * np.hypot(own_blocks, blocks) / b.mean())  # fmt: skip
common.head("", "samples/s", "samples/CPU s", "noise of a pixel %", "CPU s a pixel to 1 %")
rows = {"ours": (own_pixel, ours_s, ours_cpu)}
for name, (halves, wall, cpu) in others.items():
    apart = np.abs(luminance(halves[0].astype(float)) - luminance(halves[1].astype(float))).mean()
    rows[name] = apart / 2 * np.sqrt(np.pi / 2) / luminance(halves.astype(float)).mean(), wall, cpu
for name, (noise, wall, cpu) in rows.items():
    common.row(name, count / wall, count / cpu, 100 * noise, cpu / a.size * (100 * noise) ** 2)
