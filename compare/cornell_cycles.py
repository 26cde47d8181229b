"""The Cornell box of examples/cornell_box.scn in Blender's Cycles, to hold its means against ours.

    blender -b --factory-startup -P compare/cornell_cycles.py -- OUT.exr [SAMPLES] [SEED] [SIZE]

Cycles counts indirect bounces, scnrender scattering events: our bounces: 8 is max_bounces = 7 here.
Everything that biases Cycles by default (clamping, glossy blur, adaptive sampling, light threshold)
is switched off; the pixel filter is a box one pixel wide, as with --filter box on our side.
"""
import sys
import time

import bpy

argv = sys.argv[sys.argv.index("--") + 1:]
out = argv[0]
samples = int(argv[1]) if len(argv) > 1 else 64
seed = int(argv[2]) if len(argv) > 2 else 0
size = int(argv[3]) if len(argv) > 3 else 512

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def diffuse(name, rgb):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    bsdf = nodes.new("ShaderNodeBsdfDiffuse")
    bsdf.inputs["Color"].default_value = (*rgb, 1)
    bsdf.inputs["Roughness"].default_value = 0
    output = nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(bsdf.outputs[0], output.inputs["Surface"])
    return material


def emission(name, rgb):
    """Radiance rgb from the front side, nothing from the back."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    emit = nodes.new("ShaderNodeEmission")
    emit.inputs["Color"].default_value = (*rgb, 1)
    emit.inputs["Strength"].default_value = 1
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(emit.outputs[0], output.inputs["Surface"])
    return material


def mesh(name, vertices, faces, material):
    """Points in millimetres, y up, as in the scene file; Blender's z is up: (x, y, z) -> (x, -z, y)."""
    data = bpy.data.meshes.new(name)
    data.from_pydata([(x / 1000, -z / 1000, y / 1000) for x, y, z in vertices], [], faces)
    data.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new(name, data))


def quad(name, *args):
    *corners, material = args
    mesh(name, corners, [(0, 1, 2, 3)], material)


white = diffuse("white", (0.725, 0.71, 0.68))
red = diffuse("red", (0.63, 0.065, 0.05))
green = diffuse("green", (0.14, 0.45, 0.091))
lamp = emission("lamp", (18.4, 14, 6.75))

quad("floor", (552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2), white)
quad("back", (549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2), white)
quad("right", (0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2), green)
quad("left", (552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0), red)
mesh("ceiling",
     [(556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0),
      (343, 548.8, 227), (343, 548.8, 332), (213, 548.8, 332), (213, 548.8, 227)],
     [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)], white)
quad("short", (130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114), white)
quad("short", (290, 0, 114), (290, 165, 114), (240, 165, 272), (240, 0, 272), white)
quad("short", (130, 0, 65), (130, 165, 65), (290, 165, 114), (290, 0, 114), white)
quad("short", (82, 0, 225), (82, 165, 225), (130, 165, 65), (130, 0, 65), white)
quad("short", (240, 0, 272), (240, 165, 272), (82, 165, 225), (82, 0, 225), white)
quad("tall", (423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406), white)
quad("tall", (423, 0, 247), (423, 330, 247), (472, 330, 406), (472, 0, 406), white)
quad("tall", (472, 0, 406), (472, 330, 406), (314, 330, 456), (314, 0, 456), white)
quad("tall", (314, 0, 456), (314, 330, 456), (265, 330, 296), (265, 0, 296), white)
quad("tall", (265, 0, 296), (265, 330, 296), (423, 330, 247), (423, 0, 247), white)
quad("lamp", (343, 548.8, 227), (343, 548.8, 332), (213, 548.8, 332), (213, 548.8, 227), lamp)

camera = bpy.data.cameras.new("camera")
camera.sensor_fit = "VERTICAL"
camera.angle = 39.3077 * 3.14159265358979 / 180
camera.clip_start = 1e-3
eye = bpy.data.objects.new("camera", camera)
eye.location = (0.278, 0.8, 0.273)
eye.rotation_euler = (3.14159265358979 / 2, 0, 3.14159265358979)
scene.collection.objects.link(eye)
scene.camera = eye

world = bpy.data.worlds.new("world")
world.use_nodes = True
world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
scene.world = world

scene.render.engine = "CYCLES"
cycles = scene.cycles
cycles.device = "CPU"
cycles.samples = samples
cycles.seed = seed
cycles.use_adaptive_sampling = False
cycles.use_denoising = False
cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 7
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
cycles.blur_glossy = 0
cycles.light_sampling_threshold = 0
cycles.pixel_filter_type = "BOX"
cycles.filter_width = 1
scene.render.resolution_x = scene.render.resolution_y = size
scene.render.resolution_percentage = 100
scene.view_settings.view_transform = "Standard"
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = out
start = time.time()
bpy.ops.render.render(write_still=True)
print(f"cycles_seconds {time.time() - start:.3f}")
