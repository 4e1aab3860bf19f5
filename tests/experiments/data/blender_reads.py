"""Prints each layer's largest value in a multi-part OpenEXR file, as Blender's compositor reads it.

blender -b --factory-startup --python blender_reads.py -- FILE.exr
"""
import os
import sys
import tempfile

import bpy

path = sys.argv[sys.argv.index("--") + 1]
scene = bpy.context.scene
scene.use_nodes = True
tree = scene.node_tree
tree.nodes.clear()
source, output = tree.nodes.new("CompositorNodeImage"), tree.nodes.new("CompositorNodeComposite")
source.image = bpy.data.images.load(os.path.abspath(path))
scene.render.resolution_x, scene.render.resolution_y = source.image.size
scene.render.resolution_percentage = 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.view_settings.view_transform = "Raw"
for name in [socket.name for socket in source.outputs if socket.enabled]:
    tree.links.new(source.outputs[name], output.inputs["Image"])
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "layer.exr")
        bpy.ops.render.render(write_still=True)
        picture = bpy.data.images.load(scene.render.filepath)
        pixels = list(picture.pixels)
        print("layer", name, max(value for k, value in enumerate(pixels) if k % 4 < 3))
        bpy.data.images.remove(picture)
