"""cycles_scene.py - a smalti document rendered by Blender's Cycles (3.4). Runs inside Blender:

    blender -b --factory-startup -P bench/cycles_scene.py -- DOCUMENT.json

Reads lines "SEED SPP OUT.exr" and answers each with a line "rendered CPU-SECONDS": user and system time of this
process around the render, with Cycles' own preparation in it. Understands what bench/documents.py writes: a
perspective camera with look_at; diffuse, mirror and dielectric; quads, inline meshes, our PLY files, spheres; a sky;
quads that shine.

Cycles renders what smalti renders: one thread, no denoiser, no adaptive sampling, no clamp, no blurred caustics, box
filter of one pixel, linear float EXR. Where there is a choice it has what was best for it on these scenes:
 - An emitting quad is a mesh that emits (on both sides; its back is never seen). A rectangular area light, which Cycles
   samples by solid angle, gave 5 % less relMSE for 13 % more time.
 - The sampler is progressive multi-jitter. Sobol' points had 5 % more relMSE x time in the Cornell box, the same
   elsewhere.
 - The sky is left to the BSDF's sampling, as Cycles does by itself with a uniform one.
A sphere is an icosphere of 81 920 triangles with smooth normals: Cycles has no spheres. max_bounces counts every
scattering with us; Cycles does not count the one where direct light is gathered: one fewer there.
SPDX-License-Identifier: MIT
"""

import array
import json
import math
import os
import resource
import struct
import sys

import bpy
from mathutils import Matrix, Vector

def cpu():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def settings(document):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = document["film"]["width"], document["film"]["height"]
    scene.render.resolution_percentage = 100
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    scene.render.film_transparent = False
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.render.dither_intensity = 0
    scene.view_settings.view_transform = "Raw"
    image = scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGB", "32", "NONE"
    c = scene.cycles
    c.device, c.feature_set = "CPU", "SUPPORTED"
    c.use_denoising = c.use_adaptive_sampling = c.use_auto_tile = c.use_fast_gi = False
    c.sample_clamp_direct = c.sample_clamp_indirect = c.blur_glossy = 0
    c.caustics_reflective = c.caustics_refractive = True
    c.pixel_filter_type = "BOX"
    c.sampling_pattern = "PROGRESSIVE_MULTI_JITTER"
    c.film_exposure = 1
    bounces = document["settings"]["max_bounces"] - 1
    c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transmission_bounces = bounces
    c.transparent_max_bounces = 8
    c.min_light_bounces = c.min_transparent_bounces = 0


def camera(document):
    view = document["camera"]["look_at"]
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "VERTICAL", math.radians(document["camera"]["fov_deg"])
    data.clip_start, data.clip_end = 1e-4, 1e4
    origin = Vector(view["from"])
    back = (origin - Vector(view["to"])).normalized()
    right = Vector((0, 1, 0)).cross(back).normalized()
    axes = Matrix((right, back.cross(right), back)).transposed()
    thing = bpy.data.objects.new("camera", data)
    thing.matrix_world = Matrix.Translation(origin) @ axes.to_4x4()
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.scene.camera = thing


def gray(value):
    return [*value, 1] if isinstance(value, list) else [value, value, value, 1]


def material(name, shader_type, **inputs):
    """A material of one shader node, with these values at its inputs."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    shader = nodes.new(shader_type)
    if hasattr(shader, "distribution"):
        shader.distribution = "SHARP"
    for key, value in inputs.items():
        shader.inputs[key].default_value = value
    made.node_tree.links.new(shader.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def surface(name, described):
    kind = described["type"]
    if kind == "diffuse":
        return material(name, "ShaderNodeBsdfDiffuse", Color=gray(described["albedo"]), Roughness=0)
    if kind == "mirror":
        return material(name, "ShaderNodeBsdfGlossy", Color=gray(described["reflectance"]), Roughness=0)
    if kind == "dielectric":
        return material(name, "ShaderNodeBsdfGlass", Color=gray(1), Roughness=0, IOR=described["ior"])
    sys.exit(f"cycles_scene: no material {kind} here")


def mesh(name, positions, corners, made):
    """Triangles from flat arrays."""
    data = bpy.data.meshes.new(name)
    count = len(corners) // 3
    data.vertices.add(len(positions) // 3)
    data.vertices.foreach_set("co", positions)
    data.loops.add(3 * count)
    data.loops.foreach_set("vertex_index", corners)
    data.polygons.add(count)
    data.polygons.foreach_set("loop_start", array.array("i", range(0, 3 * count, 3)))
    data.polygons.foreach_set("loop_total", array.array("i", [3]) * count)
    data.update(calc_edges=True)
    data.materials.append(made)
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)


def ply(path):
    """Positions and corners of a file that bench/ply.py wrote."""
    with open(path, "rb") as file:
        counts = {}
        for line in iter(file.readline, b"end_header\n"):
            words = line.split()
            if words[0] == b"element":
                counts[words[1]] = int(words[2])
        positions = array.array("f", file.read(12 * counts[b"vertex"]))
        corners = array.array("i")
        for _, i, j, k in struct.Struct("<Biii").iter_unpack(file.read(13 * counts[b"face"])):
            corners.extend((i, j, k))
    return positions, corners


def flat(points):
    return array.array("f", [x for point in points for x in point])


def shape(described, materials):
    made = materials[described["material"]]
    if "emission" in described:
        made = material("light", "ShaderNodeEmission", Color=gray(described["emission"]), Strength=1)
    kind = described["type"]
    if kind == "sphere":
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=7, radius=described["radius"], location=described["center"])
        thing = bpy.context.object
        thing.data.materials.append(made)
        thing.data.polygons.foreach_set("use_smooth", [True] * len(thing.data.polygons))
    elif kind == "quad":
        mesh(kind, flat(described["vertices"]), array.array("i", [0, 1, 2, 0, 2, 3]), made)
    elif "file" in described:
        mesh(kind, *ply(described["file"]), made)
    else:
        corners = array.array("i", [i for corner in described["triangles"] for i in corner])
        mesh(kind, flat(described["vertices"]), corners, made)


def world(lights):
    made = bpy.data.worlds.new("sky")
    made.use_nodes = True
    background = made.node_tree.nodes["Background"]
    radiance = lights[0]["radiance"] if lights else 0
    background.inputs["Color"].default_value = gray(radiance)
    background.inputs["Strength"].default_value = 1
    bpy.context.scene.world = made


def render(seed, spp, path):
    scene = bpy.context.scene
    scene.cycles.seed, scene.cycles.samples = seed, spp
    scene.render.filepath = path
    begin = cpu()
    bpy.ops.render.render()
    used = cpu() - begin
    bpy.data.images["Render Result"].save_render(path, scene=scene)
    return used


def main(path):
    with open(path, encoding="utf-8") as file:
        document = json.load(file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    settings(document)
    camera(document)
    materials = {name: surface(name, m) for name, m in document["materials"].items()}
    for described in document["shapes"]:
        shape(described, materials)
    world(document["lights"] if "lights" in document else [])
    print("ready", flush=True)
    for line in sys.stdin:
        seed, spp, out = line.split(maxsplit=2)
        print("rendered", render(int(seed), int(spp), out.strip()), flush=True)


main(sys.argv[sys.argv.index("--") + 1])
