"""What is on the pictures of the gallery: sets, and what is put into them.
SPDX-License-Identifier: MIT
"""

import json
import math
from collections import namedtuple

# shown: the lines that stand on the page, where those that are meant would be too many.
Picture = namedtuple("Picture", "set name title lines shown", defaults=[None])
Section = namedtuple("Section", "title text pictures")


# --- sets ---

def panel(center, target, width, height, emission):
    """A quad that shines at the target, upright."""
    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    def unit(a):
        length = math.sqrt(sum(x * x for x in a))
        return [x / length for x in a]

    front = unit([t - c for t, c in zip(target, center)])
    right = unit(cross([0, 1, 0], front))
    up = cross(front, right)
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    return {"type": "quad", "material": "lamp", "emission": emission,
            "vertices": [[round(c + s * width / 2 * r + t * height / 2 * u, 4)
                          for c, r, u in zip(center, right, up)] for s, t in corners]}


def box(material, lo, hi):
    corners = [[hi[0] if i & 1 else lo[0], hi[1] if i & 2 else lo[1], hi[2] if i & 4 else lo[2]] for i in range(8)]
    faces = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    triangles = [t for a, b, c, d in faces for t in ([a, b, c], [a, c, d])]
    return {"type": "mesh", "material": material, "vertices": corners, "triangles": triangles}


def ground(size, squares, colors):
    return {
        "textures": {"squares": {"type": "checker", "colors": colors, "uv_scale": squares}},
        "materials": {"ground": {"type": "diffuse", "albedo": {"texture": "squares"}},
                      "lamp": {"type": "diffuse", "albedo": 0}},
        "shapes": [{"type": "quad", "material": "ground",
                    "vertices": [[-size, 0, size], [size, 0, size], [size, 0, -size], [-size, 0, -size]]}],
    }


def frame(fov, origin, to):
    return {
        "film": {"width": 224, "height": 224, "filter": {"type": "gaussian"}},
        "camera": {"type": "perspective", "fov_deg": fov, "look_at": {"from": origin, "to": to}},
        "settings": {"target": {"spp": 128}},
    }


def studio():
    s = {**frame(23, [0, 2.7, 6.8], [0, 0.9, 0]), **ground(120, 480, [[0.5, 0.5, 0.5], [0.2, 0.21, 0.23]])}
    s["shapes"] += [panel([-3.4, 4.4, 3], [0, 1, 0], 3.4, 3.4, [6, 5.8, 5.5]),
                    panel([4, 2.4, -1], [0, 1, 0], 1.3, 3.2, [5, 5.5, 6.3]),
                    panel([0, 5, -5], [0, 1, 0], 6, 1.6, [3, 3, 3])]
    s["lights"] = [{"type": "sky", "radiance": [0.2, 0.215, 0.24]}]
    return s


def with_ball(s):
    s["shapes"].append({"type": "sphere", "material": "ball", "center": [0, 1, 0], "radius": 1})
    return s


def table():
    s = {**frame(29, [0.6, 2.6, 6.4], [-0.05, 0.7, 0]), **ground(120, 480, [[0.55, 0.54, 0.52], [0.45, 0.44, 0.42]])}
    s["materials"].update({"white": {"type": "diffuse", "albedo": 0.75},
                           "red": {"type": "plastic", "albedo": [0.6, 0.07, 0.05], "alpha": 0.1},
                           "steel": {"type": "conductor", "metal": "chromium", "alpha": 0.12}})
    s["shapes"] += [{"type": "sphere", "material": "white", "center": [0, 0.75, -0.3], "radius": 0.75},
                    {"type": "sphere", "material": "steel", "center": [0.95, 0.4, 0.8], "radius": 0.4},
                    {**box("red", [-0.35, 0, -0.35], [0.35, 0.7, 0.35]),
                     "transform": [{"rotate_deg": {"axis": [0, 1, 0], "angle": 25}}, {"translate": [-1.05, 0, 0.75]}]}]
    return s


def avenue():
    s = {**frame(30, [-1.1, 1.5, 5.2], [0.35, 0.6, 0]), **ground(120, 240, [[0.6, 0.58, 0.55], [0.25, 0.25, 0.27]])}
    colors = [[0.65, 0.1, 0.06], [0.75, 0.45, 0.05], [0.15, 0.45, 0.1], [0.06, 0.25, 0.6], [0.35, 0.1, 0.5]]
    for i, color in enumerate(colors):
        z = 2 - 1.7 * i
        s["materials"]["ball %d" % i] = {"type": "plastic", "albedo": color, "alpha": 0.05}
        s["shapes"].append({"type": "sphere", "material": "ball %d" % i, "center": [-0.55 + 0.55 * i, 0.5, z],
                            "radius": 0.5})
    for i in range(9):
        s["shapes"].append({"type": "sphere", "material": "lamp", "radius": 0.14, "emission": [14, 10, 5],
                            "center": [-4.6 + 1.45 * i, 1.5 + 0.75 * ((i * 5) % 4), -14 - (i * 7) % 5]})
    s["shapes"].append(panel([-4, 5, 3], [0, 0.5, -1], 3, 3, [9, 8.5, 8]))
    s["lights"] = [{"type": "sky", "radiance": [0.16, 0.2, 0.3]}]
    return s


def room():
    """Seen all around: what the environment map is made of."""
    s = {**frame(40, [0, 1.6, 0], [0, 1.6, -1]), **ground(6, 12, [[0.5, 0.42, 0.34], [0.35, 0.28, 0.22]])}
    s["film"] = {"width": 448, "height": 224}
    s["materials"]["wall"] = {"type": "diffuse", "albedo": [0.55, 0.5, 0.45]}
    s["materials"]["shelf"] = {"type": "plastic", "albedo": [0.1, 0.25, 0.35]}
    quads = [[[-4, 0, -4], [4, 0, -4], [4, 4, -4], [-4, 4, -4]], [[4, 0, 4], [-4, 0, 4], [-4, 4, 4], [4, 4, 4]],
             [[-4, 0, 4], [-4, 0, -4], [-4, 4, -4], [-4, 4, 4]], [[4, 0, -4], [4, 0, 4], [4, 4, 4], [4, 4, -4]],
             [[-4, 4, -4], [4, 4, -4], [4, 4, 4], [-4, 4, 4]]]
    s["shapes"] += [{"type": "quad", "material": "wall", "vertices": q} for q in quads]
    s["shapes"] += [panel([-3.95, 2.2, z], [0, 2.2, z], 1.4, 2, [9, 10.5, 13]) for z in (-1.8, 0.4)]
    s["shapes"] += [panel([1.5, 3.95, 1.5], [1.5001, 0, 1.5], 1, 1, [16, 13, 9])]
    s["shapes"] += [box("shelf", [1.2, 0, -3.9], [3.2, 1.8, -3.3]), box("shelf", [3.2, 0, 0.5], [3.9, 1, 2.5])]
    return s


def longer(s):
    """For what takes more samples."""
    s["settings"] = {"target": {"spp": 384}}
    return s


SETS = {"ball": with_ball(studio()), "glass ball": longer(with_ball(studio())), "studio": studio(),
        "table": table(), "long table": longer(table()), "avenue": avenue(), "room": room()}


def ball(name, title, lines):
    return Picture("ball", name, title, lines)


def glass(name, title, lines):
    return Picture("glass ball", name, title, lines)


# --- pictures ---

INTRODUCTION = """
# Gallery

One picture of every material, light, shape and camera, each with the lines of its [document](scene.md) that matter. `make gallery` renders
them all with `smalti render`, in some minutes, and writes this page; the whole documents are then in `build/gallery`. The images and meshes that some of them
name are made by [assets.py](gallery/assets.py), the sets by [pictures.py](gallery/pictures.py).
"""

MATERIALS = [
    ball("diffuse", "Diffuse", '''
"materials": {"ball": {"type": "diffuse",
  "albedo": [0.65, 0.3, 0.16]}}'''),
    ball("rough-diffuse", "Rough diffuse: clay", '''
"materials": {"ball": {"type": "rough_diffuse",
  "albedo": [0.65, 0.3, 0.16],
  "roughness": 1}}'''),
    Picture("studio", "leaf", "Leaf: a shade that lets light through", '''
"materials": {"shade": {"type": "leaf",
  "reflectance": [0.5, 0.4, 0.25],
  "transmittance": [0.45, 0.3, 0.12]}},
"shapes": [
  {"type": "cylinder", "material": "shade",
    "from": [0, 0.25, 0], "to": [0, 1.75, 0],
    "radius": 0.75},
  {"type": "sphere", "material": "lamp",
    "center": [0, 0.9, 0], "radius": 0.2,
    "emission": [7, 6, 4]}]'''),
    ball("mirror", "Mirror", '''
"materials": {"ball": {"type": "mirror",
  "reflectance": 0.95}}'''),
    ball("retroreflector", "Retro-reflector, and a light near the eye", '''
"materials": {"ball": {"type": "retroreflector",
  "reflectance": [0.85, 0.75, 0.3],
  "alpha": 0.5}},
"lights": [{"type": "point",
  "position": [0.3, 3, 6.8],
  "intensity": 22}]'''),
    ball("cloth-velvet", "Cloth: velvet", '''
"materials": {"ball": {"type": "cloth",
  "albedo": [0.22, 0.01, 0.05],
  "color": [0.9, 0.4, 0.45]}}'''),
    ball("cloth-nylon", "Cloth: nylon", '''
"materials": {"ball": {"type": "cloth",
  "albedo": [0.05, 0.16, 0.35],
  "color": [0.35, 0.5, 0.7],
  "roughness": 0.6}}'''),
    ball("plastic", "Plastic: gloss", '''
"materials": {"ball": {"type": "plastic",
  "albedo": [0.6, 0.04, 0.03]}}'''),
    ball("plastic-semi-gloss", "Plastic: semi-gloss", '''
"materials": {"ball": {"type": "plastic",
  "albedo": [0.05, 0.3, 0.22],
  "alpha": 0.25}}'''),
]

METALS = [
    ball("gold", "Gold", '''
"materials": {"ball": {"type": "conductor",
  "metal": "gold", "alpha": 0.1}}'''),
    ball("silver", "Silver", '''
"materials": {"ball": {"type": "conductor",
  "metal": "silver", "alpha": 0.05}}'''),
    ball("copper", "Copper, satin", '''
"materials": {"ball": {"type": "conductor",
  "metal": "copper", "alpha": 0.2}}'''),
    ball("brass", "Brass", '''
"materials": {"ball": {"type": "conductor",
  "metal": "brass", "alpha": 0.1}}'''),
    ball("chromium", "Chromium", '''
"materials": {"ball": {"type": "conductor",
  "metal": "chromium", "alpha": 0}}'''),
    ball("iron", "Iron, cast", '''
"materials": {"ball": {"type": "conductor",
  "metal": "iron", "alpha": 0.5,
  "multiscatter": true}}'''),
    ball("aluminium-brushed", "Aluminium, brushed", '''
"materials": {"ball": {"type": "conductor",
  "metal": "aluminium",
  "alpha": [0.04, 0.4]}}'''),
    ball("brushed-turned", "Brushed the other way", '''
"materials": {"ball": {"type": "conductor",
  "metal": "aluminium",
  "alpha": [0.04, 0.4],
  "rotation_deg": 90}}'''),
    ball("conductor-free", "A metal of one's own", '''
"materials": {"ball": {"type": "conductor",
  "eta": [0.9, 0.5, 0.2], "k": [2, 3, 5],
  "alpha": 0.12}}'''),
    ball("thin-film", "A thin film on metal", '''
"materials": {"ball": {"type": "conductor",
  "metal": "chromium", "alpha": 0.08,
  "thin_film": {"thickness_nm": 420,
    "ior": 1.6}}}'''),
    ball("single-scatter", "Very rough, scattering once", '''
"materials": {"ball": {"type": "conductor",
  "metal": "silver", "alpha": 0.8}}'''),
    ball("multiscatter", "The same with all the light", '''
"materials": {"ball": {"type": "conductor",
  "metal": "silver", "alpha": 0.8,
  "multiscatter": true}}'''),
]

GLASS = [
    glass("glass", "Glass", '''
"materials": {"ball": {"type": "dielectric",
  "ior": 1.5}}'''),
    glass("glass-frosted", "Frosted glass", '''
"materials": {"ball": {"type": "dielectric",
  "ior": 1.5, "alpha": 0.25}}'''),
    glass("glass-green", "Glass that absorbs", '''
"materials": {"ball": {"type": "dielectric",
  "ior": 1.5,
  "absorption": [1.6, 0.25, 1.1]}}'''),
    glass("diamond", "Diamond", '''
"materials": {"ball": {"type": "dielectric",
  "ior": 2.42}}'''),
    glass("thin-dielectric", "Thin dielectric: a bubble", '''
"materials": {"ball":
  {"type": "thin_dielectric", "ior": 1.5}}'''),
    glass("priorities", "Bodies in each other", '''
"materials": {
  "ball": {"type": "dielectric", "ior": 1.5,
    "priority": 1, "absorption": [0.1, 0.3, 0.9]},
  "air": {"type": "dielectric", "ior": 1,
    "priority": 3},
  "core": {"type": "dielectric", "ior": 1.9,
    "priority": 2, "absorption": [0.2, 2, 3]}},
"shapes": [
  {"type": "sphere", "material": "air",
    "center": [-0.28, 1.3, 0.2], "radius": 0.32},
  {"type": "sphere", "material": "core",
    "center": [0.15, 0.85, 0.1], "radius": 0.5}]'''),
]

MADE_OF_OTHERS = [
    ball("principled", "Principled", '''
"materials": {"ball": {"type": "principled",
  "base_color": [0.1, 0.35, 0.6],
  "roughness": 0.35}}'''),
    ball("principled-paint", "Metallic paint", '''
"materials": {"ball": {"type": "principled",
  "base_color": [0.5, 0.05, 0.04],
  "metallic": 1, "roughness": 0.5,
  "clearcoat": 1}}'''),
    glass("principled-transmission", "Transmission", '''
"materials": {"ball": {"type": "principled",
  "base_color": [0.95, 0.8, 0.5],
  "transmission": 1, "roughness": 0.25}}'''),
    ball("principled-sheen", "Sheen", '''
"materials": {"ball": {"type": "principled",
  "base_color": [0.3, 0.12, 0.3],
  "roughness": 0.9,
  "sheen_color": [0.9, 0.8, 0.9]}}'''),
    ball("principled-clearcoat", "Clear coat", '''
"materials": {"ball": {"type": "principled",
  "base_color": [0.08, 0.25, 0.1],
  "roughness": 0.7, "clearcoat": 1}}'''),
    ball("mix", "Mix", '''
"materials": {
  "gold": {"type": "conductor",
    "metal": "gold", "alpha": 0.15},
  "blue": {"type": "diffuse",
    "albedo": [0.03, 0.08, 0.3]},
  "ball": {"type": "mix", "first": "gold",
    "second": "blue",
    "amount": {"texture": "smudges"}}},
"textures": {"smudges": {"type": "image",
  "file": "smudges.png", "uv_scale": [5, 2.5],
  "color_space": "linear"}}'''),
    ball("mask", "Mask", '''
"materials": {
  "rust": {"type": "diffuse",
    "albedo": [0.5, 0.18, 0.07]},
  "ball": {"type": "mask", "material": "rust",
    "opacity": {"texture": "holes"}}},
"textures": {"holes": {"type": "checker",
  "colors": [1, 0], "uv_scale": [20, 10]}}'''),
    ball("two-sided", "Two-sided, cut open by a mask", '''
"materials": {
  "out": {"type": "plastic",
    "albedo": [0.7, 0.65, 0.55]},
  "in": {"type": "diffuse",
    "albedo": [0.7, 0.12, 0.05]},
  "shell": {"type": "two_sided",
    "front": "out", "back": "in"},
  "ball": {"type": "mask", "material": "shell",
    "opacity": {"texture": "bands"}}},
"textures": {"bands": {"type": "checker",
  "colors": [1, 0], "uv_scale": [0.001, 9]}}'''),
]

TEXTURES = [
    ball("texture-image", "An image", '''
"textures": {"wood": {"type": "image",
  "file": "wood.png", "uv_scale": [3, 1]}},
"materials": {"ball": {"type": "plastic",
  "albedo": {"texture": "wood"},
  "alpha": 0.1}}'''),
    ball("texture-checker", "Checker", '''
"textures": {"two": {"type": "checker",
  "colors": [[0.7, 0.62, 0.5],
    [0.08, 0.12, 0.2]],
  "uv_scale": [16, 8]}},
"materials": {"ball": {"type": "plastic",
  "albedo": {"texture": "two"}}}'''),
    ball("texture-roughness", "Any parameter: roughness", '''
"textures": {"smudges": {"type": "image",
  "file": "smudges.png", "uv_scale": [2, 1],
  "color_space": "linear"}},
"materials": {"ball": {"type": "conductor",
  "metal": "silver", "alpha":
    {"texture": "smudges", "scale": 0.35}}}'''),
    ball("normal-map", "Normal map", '''
"textures": {
  "brick": {"type": "image",
    "file": "brick.png", "uv_scale": [6, 3]},
  "normals": {"type": "image",
    "file": "brick-normal.png",
    "color_space": "linear",
    "uv_scale": [6, 3]}},
"materials": {"ball": {"type": "diffuse",
  "albedo": {"texture": "brick"},
  "normal_map": {"texture": "normals",
    "scale": 2}}}'''),
    ball("bump", "Bump", '''
"textures": {"dents": {"type": "image",
  "file": "dents.png", "uv_scale": [3, 1.5],
  "color_space": "linear"}},
"materials": {"ball": {"type": "conductor",
  "metal": "copper", "alpha": 0.12,
  "bump": {"texture": "dents",
    "scale": 0.05}}}'''),
    Picture("studio", "vertex-colors", "Colours of vertices", '''
"textures": {"hues": {"type": "vertex_color"}},
"materials": {"knot": {"type": "plastic",
  "albedo": {"texture": "hues"},
  "alpha": 0.1}},
"shapes": [{"type": "mesh", "material": "knot",
  "file": "knot.ply", "transform": [
    {"rotate_deg": {"axis": [1, 0, 0],
      "angle": 60}},
    {"translate": [0, 1, 0]}]}]'''),
]

SHAPES = [
    Picture("studio", "sphere", "Sphere", '''
"materials": {"m": {"type": "plastic",
  "albedo": [0.2, 0.4, 0.6]}},
"shapes": [{"type": "sphere", "material": "m",
  "center": [0, 1, 0], "radius": 1}]'''),
    Picture("studio", "disc", "Disc", '''
"materials": {"m": {"type": "plastic",
  "albedo": [0.2, 0.4, 0.6]}},
"shapes": [{"type": "disc", "material": "m",
  "center": [0, 1, 0], "radius": 1,
  "normal": [0.35, 0.45, 1]}]'''),
    Picture("studio", "cylinder", "Cylinder", '''
"materials": {"m": {"type": "plastic",
  "albedo": [0.2, 0.4, 0.6]}},
"shapes": [{"type": "cylinder", "material": "m",
  "from": [-0.8, 0.61, -0.4], "to": [0.8, 0.61, 0.4],
  "radius": 0.6}]'''),
    Picture("studio", "quad", "Quad", '''
"materials": {"m": {"type": "plastic",
  "albedo": [0.2, 0.4, 0.6]}},
"shapes": [{"type": "quad", "material": "m",
  "vertices": [[-1, 0.01, 0.3], [1, 0.01, -0.2],
    [0.7, 1.8, -0.325], [-0.7, 1.8, 0.025]]}]'''),
    Picture("studio", "mesh-flat", "Mesh: as flat as it is", '''
"materials": {"m": {"type": "plastic",
  "albedo": [0.2, 0.4, 0.6]}},
"shapes": [{"type": "mesh", "material": "m",
  "file": "ball.obj"}]'''),
    Picture("studio", "mesh-smooth", "Mesh: smooth", '''
"materials": {"m": {"type": "plastic",
  "albedo": [0.2, 0.4, 0.6]}},
"shapes": [{"type": "mesh", "material": "m",
  "file": "ball.obj", "normals": "smooth"}]'''),
]

def many_points():
    """A dome of small coloured lamps, along a spiral."""
    lamps = []
    for i in range(40):
        y, turn = (i + 0.5) / 40, i * 2.399963
        r = 3.2 * math.sqrt(1 - y * y)
        hue = [0.5 + 0.5 * math.cos(turn + 2 * math.pi * k / 3) for k in range(3)]
        lamps.append({"type": "point", "intensity": [round(0.9 * h + 0.05, 3) for h in hue],
                      "position": [round(r * math.cos(turn), 3), round(0.4 + 3 * y, 3), round(r * math.sin(turn), 3)]})
    return lamps


LIGHTS = [
    Picture("table", "light-sky", "Sky", '''
"lights": [{"type": "sky",
  "radiance": [0.5, 0.6, 0.78]}]'''),
    Picture("table", "light-environment", "Environment: the room below", '''
"lights": [{"type": "environment",
  "file": "camera-panoramic.exr"}]'''),
    Picture("table", "light-sun", "Sun", '''
"lights": [
  {"type": "sun", "direction": [1, -1.1, -0.7],
    "diameter_deg": 0.53,
    "irradiance": [3, 2.7, 2.2]},
  {"type": "sky",
    "radiance": [0.14, 0.2, 0.32]}]'''),
    Picture("table", "light-distant", "Distant", '''
"lights": [
  {"type": "distant",
    "direction": [1, -1.1, -0.7],
    "irradiance": [3, 2.7, 2.2]},
  {"type": "sky", "radiance": 0.08}]'''),
    Picture("table", "light-point", "Point", '''
"lights": [
  {"type": "point", "position": [-0.4, 2.6, 1.6],
    "intensity": [9, 8, 6.5]},
  {"type": "sky", "radiance": 0.05}]'''),
    Picture("table", "light-spot", "Spot", '''
"lights": [
  {"type": "spot", "position": [-2, 4.5, 2.5],
    "direction": [2, -4.2, -2.5],
    "intensity": [75, 70, 58],
    "inner_deg": 9, "outer_deg": 15},
  {"type": "sky", "radiance": 0.05}]'''),
    Picture("table", "light-sphere", "A sphere that shines", '''
"shapes": [{"type": "sphere",
  "material": "lamp", "radius": 0.25,
  "center": [-0.4, 2.3, 1.4],
  "emission": [45, 38, 28]}]'''),
    Picture("table", "light-quad", "A quad", '''
"shapes": [{"type": "quad", "material": "lamp",
  "vertices": [[-3.2, 1, 2.4], [-2.6, 1, -1],
    [-2.6, 3, -1], [-3.2, 3, 2.4]],
  "emission": [8, 7.4, 6.4]}]'''),
    Picture("table", "light-disc", "A disc", '''
"shapes": [{"type": "disc", "material": "lamp",
  "center": [0, 3.4, 0.3], "normal": [0, -1, 0],
  "radius": 0.8, "emission": [13, 12.4, 11]}]'''),
    Picture("table", "light-cylinder", "Tubes", '''
"shapes": [
  {"type": "cylinder", "material": "lamp",
    "from": [-2, 1.9, -1.3], "to": [2, 1.9, -1.3],
    "radius": 0.04, "emission": [60, 12, 30]},
  {"type": "cylinder", "material": "lamp",
    "from": [-2.4, 2.6, 1.8], "to": [2, 2.6, 1.8],
    "radius": 0.04, "emission": [20, 45, 60]}]'''),
    Picture("table", "light-mesh", "A mesh", '''
"shapes": [{"type": "mesh", "material": "lamp",
  "file": "knot.ply", "emission": [9, 6, 3],
  "transform": [{"scale": 0.5},
    {"translate": [-0.35, 2.15, 0.9]}]}]'''),
    Picture("table", "light-texture", "A quad with a texture", '''
"textures": {"panes": {"type": "checker",
  "colors": [[2.6, 0.3, 0.1], [0.12, 0.5, 2.6]],
  "uv_scale": [5, 3]}},
"shapes": [{"type": "quad", "material": "lamp",
  "vertices": [[-1.7, 0.1, -1.8], [1.7, 0.1, -1.8],
    [1.7, 2.1, -1.8], [-1.7, 2.1, -1.8]],
  "emission": {"texture": "panes"}}],
"lights": [{"type": "sky", "radiance": 0.1}]'''),
    Picture("long table", "light-many", "40 points", '"lights": ' + json.dumps(many_points()), '''
"lights": [{"type": "point",
  "position": [3.2, 0.438, 0],
  "intensity": [0.95, 0.275, 0.275]},
  and 39 more]'''),
]

CAMERAS = [
    Picture("avenue", "camera-perspective", "Perspective", '''
"camera": {"type": "perspective", "fov_deg": 30,
  "look_at": {"from": [-1.1, 1.5, 5.2],
    "to": [0.35, 0.6, 0]}}'''),
    Picture("avenue", "camera-thin-lens", "Thin lens", '''
"camera": {"type": "thin_lens", "fov_deg": 30,
  "aperture_radius": 0.12,
  "focus_distance": 5.1,
  "look_at": {"from": [-1.1, 1.5, 5.2],
    "to": [0.35, 0.6, 0]}}'''),
    Picture("avenue", "camera-blades", "Thin lens of five blades", '''
"camera": {"type": "thin_lens", "fov_deg": 30,
  "aperture_radius": 0.14, "blades": 5,
  "blade_angle_deg": 90,
  "focus_distance": 3.3,
  "look_at": {"from": [-1.1, 1.5, 5.2],
    "to": [0.35, 0.6, 0]}}'''),
    Picture("avenue", "camera-orthographic", "Orthographic", '''
"camera": {"type": "orthographic", "height": 6.5,
  "look_at": {"from": [5, 5.5, 8],
    "to": [0.45, 0.3, -1.5]}}'''),
    Picture("room", "camera-panoramic", "Panoramic: a room", '''
"camera": {"type": "panoramic",
  "look_at": {"from": [0, 1.6, 0],
    "to": [0, 1.6, -1]}}'''),
]


SECTIONS = [
    Section("Materials", "The set is a ball on a checkered ground between two lamps, under a gray sky.", MATERIALS),
    Section("Metals", "By measured constants, or by constants of one's own.", METALS),
    Section("Glass", "", GLASS),
    Section("Materials made of others", "", MADE_OF_OTHERS),
    Section("Textures", "Every parameter of every material may come from a texture; normals, too.", TEXTURES),
    Section("Shapes", "", SHAPES),
    Section("Lights", "The set is a table with a ball of plaster, one of steel and a lacquered box, in the dark.", LIGHTS),
    Section("Cameras", "", CAMERAS),
]
