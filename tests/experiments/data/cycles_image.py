# Renders the image that tests `raylex verify --preset cycles`, and the variants that its tolerances were measured on.
#
#   blender -b --factory-startup --python tests/experiments/data/cycles_image.py -- OUT.exr [key=value ...]
#
# scene=still|fog|strong  size=48x36  samples=64  depth=32|16  codec=ZIP|ZIPS|PIZ|DWAA|...  seed=1  groups=all|some|none
# transparent=0|1  layers=1|2  clamp=10 (Blender's own default)  sky=0.4
#
# The image has every kind of light: diffuse, glossy, glass, subsurface, emission, environment; with scene=fog, a volume.
# Three light groups contain all lights. scene=strong has dark corners, and lights that are a thousand times as bright.
import math
import sys

import bpy

arguments = sys.argv[sys.argv.index("--") + 1:]
out = arguments[0]
options = dict(scene="still", size="48x36", samples="64", depth="32", codec="ZIP", seed="1", groups="all", transparent="0",
               layers="1", clamp="10", sky="0.4")
for argument in arguments[1:]:
    key, value = argument.split("=", 1)
    if key not in options:
        sys.exit("unknown option " + key + "; expected one of " + ", ".join(options))
    options[key] = value

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.use_denoising = False  # a denoised Combined is not the sum of its passes
scene.cycles.samples = int(options["samples"])
scene.cycles.seed = int(options["seed"])
scene.cycles.sample_clamp_indirect = float(options["clamp"])
scene.render.threads_mode = "FIXED"
scene.render.threads = 1
scene.render.film_transparent = options["transparent"] == "1"
scene.render.resolution_x, scene.render.resolution_y = map(int, options["size"].split("x"))
scene.render.resolution_percentage = 100
scene.render.use_compositing = scene.render.use_sequencer = False
scene.render.filepath = out
scene.render.use_file_extension = False
settings = scene.render.image_settings
settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR_MULTILAYER", options["depth"], options["codec"]
# Blender writes the date, the machine and the render time into images. These would differ between runs.
for name in dir(scene.render):
    if name.startswith("use_stamp"):
        setattr(scene.render, name, False)


def material(name, base, emission=0.0, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    node = made.node_tree.nodes["Principled BSDF"]
    node.inputs["Base Color"].default_value = (*base, 1)
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ").title() if key != "ior" else "IOR"].default_value = value
    if emission > 0:
        node.inputs["Emission"].default_value = (*base, 1)
        node.inputs["Emission Strength"].default_value = emission
    return made


def add(operator, location, what, group="", **extra):
    operator(location=location, **extra)
    made = bpy.context.object
    made.data.materials.append(what)
    if hasattr(made.data, "polygons"):
        for polygon in made.data.polygons:
            polygon.use_smooth = operator is not bpy.ops.mesh.primitive_plane_add
    if group and options["groups"] != "none":
        made.lightgroup = group
    return made


sphere, plane = bpy.ops.mesh.primitive_uv_sphere_add, bpy.ops.mesh.primitive_plane_add
strength = 1000.0 if options["scene"] == "strong" else 1.0
add(plane, (0, 0, 0), material("ground", (0.5, 0.35, 0.2), roughness=0.6), size=20)
add(plane, (-1.6, 3, 0.6), material("wall", (0.2, 0.3, 0.5), roughness=0.9), size=5, rotation=(math.pi / 2, 0, 0))
add(sphere, (-1.5, 0, 0.8), material("clay", (0.8, 0.2, 0.1), roughness=0.8), radius=0.8)
add(sphere, (0, -0.6, 0.6), material("glass", (0.9, 1, 0.95), transmission=1.0, roughness=0.05, ior=1.45), radius=0.6)
add(sphere, (1.4, 0.2, 0.8), material("metal", (0.9, 0.7, 0.3), metallic=1.0, roughness=0.2), radius=0.8)
add(sphere, (0.5, 1.2, 0.5), material("wax", (0.9, 0.6, 0.5), subsurface=0.7, roughness=0.5), radius=0.5)
add(sphere, (-0.6, -1.4, 0.2), material("bulb", (1.0, 0.8, 0.4), emission=6.0 * strength), radius=0.2, group="bulb")
bpy.ops.object.light_add(type="AREA", location=(2.5, -2, 4), rotation=(0.5, 0.5, 0))
lamp = bpy.context.object
lamp.data.energy, lamp.data.size, lamp.data.color = 150 * strength, 1.5, (1, 0.9, 0.8)
if options["groups"] != "none":
    lamp.lightgroup = "key"
world = bpy.data.worlds.new("sky")
scene.world = world
world.use_nodes = True
world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.5, 0.9, 1)
world.node_tree.nodes["Background"].inputs["Strength"].default_value = float(options["sky"])
if options["groups"] == "all":  # `some` leaves the sky in no group
    world.lightgroup = "sky"
if options["scene"] == "fog":
    nodes, links = world.node_tree.nodes, world.node_tree.links
    bpy.ops.mesh.primitive_cube_add(size=9, location=(0, -1, 2))
    fog = bpy.data.materials.new("fog")
    fog.use_nodes = True
    fog.node_tree.nodes.clear()
    scatter = fog.node_tree.nodes.new("ShaderNodeVolumeScatter")
    scatter.inputs["Density"].default_value = 0.08
    output = fog.node_tree.nodes.new("ShaderNodeOutputMaterial")
    fog.node_tree.links.new(scatter.outputs[0], output.inputs["Volume"])
    bpy.context.object.data.materials.append(fog)

camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
camera.location, camera.rotation_euler, camera.data.lens = (0, -6.5, 2.2), (math.radians(78), 0, 0), 40
scene.camera = camera

if options["layers"] == "2":
    scene.view_layers.new("Second")
for layer in scene.view_layers:
    for kind in ("diffuse", "glossy", "transmission"):
        for part in ("direct", "indirect", "color"):
            setattr(layer, "use_pass_%s_%s" % (kind, part), True)
    layer.use_pass_emit = layer.use_pass_environment = True
    if options["scene"] == "fog":
        layer.cycles.use_pass_volume_direct = layer.cycles.use_pass_volume_indirect = True
    if options["groups"] != "none":
        for name in ("bulb", "key", "sky"):
            if name == "sky" and options["groups"] == "some":
                continue
            layer.lightgroups.add().name = name
bpy.ops.render.render(write_still=True)
