"""Renders a scene of scenes.py in Blender's Cycles and prints the CPU seconds of rendering, without setup:

    blender -b --factory-startup --python cycles.py -- NAME SAMPLES SEED OUT.exr

Path tracing as in raylex: no denoising, clamping, adaptive sampling or light tree; box filter; one process, one thread.
The setup (copying the scene, building its tree) is the time of a render with one sample minus that sample, measured in
the same process.
"""
import math
import pathlib
import resource
import sys

import bpy
import mathutils

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import scenes  # noqa: E402


def settings(scene, plan):
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_auto_tile = False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = plan.depth
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.pixel_filter_type = "BOX"
    for name in ("use_light_tree", "use_guiding"):  # of later versions
        if hasattr(cycles, name):
            setattr(cycles, name, False)
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.resolution_x = scene.render.resolution_y = plan.resolution
    scene.render.resolution_percentage = 100
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"


def material_of(material, name):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    kind = "Emission" if material.radiance else "BsdfDiffuse" if material.roughness is None else "BsdfGlossy"
    node = tree.nodes.new("ShaderNode" + kind)
    node.inputs["Color"].default_value = (1, 1, 1, 1) if material.radiance else (*material.reflectance, 1)
    if material.radiance:
        node.inputs["Strength"].default_value = material.radiance
    elif material.roughness is not None:
        node.inputs["Roughness"].default_value = math.sqrt(material.roughness)  # Cycles squares it
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def build(plan):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    settings(scene, plan)
    for mesh in plan.meshes:
        data = bpy.data.meshes.new(mesh.name)
        data.from_pydata(mesh.vertices, [], mesh.faces)
        data.materials.append(material_of(mesh.material, mesh.name))
        scene.collection.objects.link(bpy.data.objects.new(mesh.name, data))
    data = bpy.data.cameras.new("camera")
    data.angle = 2 * math.atan(plan.half_tangent)
    camera = bpy.data.objects.new("camera", data)
    camera.location = plan.eye
    camera.rotation_euler = (mathutils.Vector(plan.target) - camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = plan.sky
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    return scene


def cpu_seconds(scene, samples, seed, out):
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.render.filepath = out
    before = resource.getrusage(resource.RUSAGE_SELF)
    bpy.ops.render.render(write_still=bool(out))
    after = resource.getrusage(resource.RUSAGE_SELF)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    name, samples, seed, out = sys.argv[sys.argv.index("--") + 1:]
    plan = scenes.make(name)
    scene = build(plan)
    cpu_seconds(scene, 1, 0, "")  # loads kernels and fills caches
    short = min(cpu_seconds(scene, 1, 0, "") for _ in range(2))
    whole = cpu_seconds(scene, int(samples), int(seed), out)
    rendering = (whole - short) * int(samples) / (int(samples) - 1)
    print(f"CYCLES {name} cpu_seconds={rendering:.4f} setup={whole - rendering:.4f}", flush=True)


main()
