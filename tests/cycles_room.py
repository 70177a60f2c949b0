"""A room of triangle meshes for Blender's path tracer Cycles, by the package bpy; see room.py."""

import os

import bpy
import mathutils
import numpy as np

from glcloth.image import read_image


def _diffuse(name, color, straight=0.0):
    """A Lambertian, of which the share `straight` is not there."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    lambertian, out = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    lambertian.inputs["Color"].default_value = (*map(float, color), 1.0)
    surface = lambertian.outputs[0]
    if straight:
        mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
        mix.inputs[0].default_value = straight
        tree.links.new(surface, mix.inputs[1])
        tree.links.new(clear.outputs[0], mix.inputs[2])
        surface = mix.outputs[0]
    tree.links.new(surface, out.inputs["Surface"])
    return material


def _place(scene, name, data, at=None):
    thing = bpy.data.objects.new(name, data)
    scene.collection.objects.link(thing)
    if at is not None:
        thing.matrix_world = mathutils.Matrix(at.tolist())
    return thing


def _mesh(scene, name, positions, triangles, material, smooth=False):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(positions, float).tolist(), [], np.asarray(triangles, int).tolist())
    mesh.shade_smooth() if smooth else mesh.shade_flat()
    mesh.materials.append(material)
    _place(scene, name, mesh)


def _camera(scene, camera):
    """Ours: looks along -z of its frame, as Blender's does."""
    z = np.subtract(camera.eye, camera.target)
    z /= np.linalg.norm(z)
    x = np.cross(camera.up, z)
    x /= np.linalg.norm(x)
    at = np.eye(4)
    at[:3, :4] = np.stack([x, np.cross(z, x), z, camera.eye], axis=1)
    data = bpy.data.cameras.new("eye")
    data.clip_start, data.clip_end = 1e-3, 1e3
    data.sensor_fit, data.angle = "VERTICAL", np.radians(camera.fov_deg)
    scene.camera = _place(scene, "eye", data, at)


def load(cloth, walls, shot, sky, straight, albedo, bounces):
    """Make the scene: `cloth` a mesh, `walls` pairs of (triangles' corners [N, 3, 3], reflectance)."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.threads_mode, scene.render.threads = "FIXED", os.cpu_count()
    scene.render.resolution_x, scene.render.resolution_y = shot.size
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    cycles = scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.max_bounces = cycles.diffuse_bounces = bounces
    cycles.transparent_max_bounces = 64
    cycles.light_sampling_threshold = 0.0
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    background.inputs["Strength"].default_value = sky
    lamp = bpy.data.lights.new("lamp", "POINT")
    power = 4 * np.pi * np.asarray(shot.lighting.lamp.intensity, float)  # Blender's watts of a point: 4 pi of W/sr
    lamp.energy, lamp.shadow_soft_size = power.max(), 0.0
    lamp.color = power / power.max()
    at = np.eye(4)
    at[:3, 3] = shot.lighting.lamp.position
    _place(scene, "lamp", lamp, at)
    cloth_material = _diffuse("cloth", np.asarray(albedo) / (1 - straight), straight)
    _mesh(scene, "cloth", cloth.positions, cloth.triangles, cloth_material, smooth=True)
    for k, (corners, color) in enumerate(walls):
        corners = np.asarray(corners).reshape(-1, 3)
        _mesh(scene, f"wall_{k}", corners, np.arange(len(corners)).reshape(-1, 3), _diffuse(f"wall_{k}", color))
    _camera(scene, shot.camera)
    return scene


def picture(scene, spp, seed, file):
    """The linear picture [H, W, 3] of `spp` samples; `file` is where Blender writes it."""
    scene.cycles.samples, scene.cycles.seed = spp, seed
    scene.render.filepath = str(file)
    bpy.ops.render.render(write_still=True)
    return read_image(file)[..., :3]
