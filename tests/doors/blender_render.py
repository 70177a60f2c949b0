"""Opens a .glb in Blender and renders it from above under a white sky; needs bpy (`pip install 'glcloth[blender]'`).

python tests/doors/blender_render.py FILE.glb   # prints what was found as JSON
"""

import json
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np


def main(glb, size=(64, 48)):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=glb)
    (cloth,) = (thing for thing in bpy.data.objects if thing.type == "MESH")
    nodes = cloth.data.materials[0].node_tree.nodes
    surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("white")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    scene.camera = bpy.data.objects.new("above", bpy.data.cameras.new("above"))
    scene.collection.objects.link(scene.camera)
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 0.1
    scene.camera.location, scene.camera.rotation_euler = (0.0, -1.0, 0.0), (np.pi / 2, 0.0, 0.0)  # glTF's +z is -y here
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 16, False
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.image_settings.file_format = "OPEN_EXR"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "a.exr")
        bpy.ops.render.render(write_still=True)
        picture = np.array(bpy.data.images.load(scene.render.filepath).pixels[:]).reshape(*size[::-1], 4)
    found = {
        "blender": bpy.app.version_string,
        "size": list(cloth.dimensions),
        "anisotropic": surface.inputs["Anisotropic"].is_linked,
        "linked": sorted(one.name for one in surface.inputs if one.is_linked),
        "images": [list(image.size) for image in bpy.data.images if image.size[0]],
        "mean": picture[..., :3].mean((0, 1)).tolist(),
    }
    print(json.dumps(found))


main(sys.argv[1])
