"""documents.py - the scenes that whole images are measured with, as smalti documents.

    FOLDER                   build/bench: meshes, documents and images of the benches are made there
    cornell() bunny() interior() terrain() spheres()      a document each; meshes are made when missing
    examples()                                            the names of those of scenes/
    example(name)                                         one of them
    lacking(document)                                     a file that it names and that is not there, or None
    flat(document)                                        a copy without the normals of mesh files
    sized(document, side, spp, seed)                      a copy with another shorter side, count and seed
    written(document, name)                               the path of the document as a file in FOLDER

ASSETS names the folder of scanned meshes (default ../shared/assets).
SPDX-License-Identifier: MIT
"""

import copy
import json
import os

import ply

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDER = os.path.join(ROOT, "build", "bench")
SCENES = os.path.join(ROOT, "scenes")
ASSETS = os.environ.get("ASSETS", os.path.join(os.path.dirname(ROOT), "shared", "assets"))
BUNNY = os.path.join(ASSETS, "stanford-bunny.obj")
WALLS = 6  # shapes of scenes/cornell-box.json before its two blocks: walls and lamp


def _base(fov_deg, origin, target):
    return {"smalti": 1, "film": {"width": 256, "height": 256, "filter": {"type": "box"}},
            "camera": {"type": "perspective", "fov_deg": fov_deg, "look_at": {"from": origin, "to": target}},
            "materials": {"clay": {"type": "diffuse", "albedo": 0.7}}, "shapes": [], "lights": [],
            "settings": {"integrator": "path", "max_bounces": 64, "target": {"spp": 16}}}


def _mesh(name, make, *args):
    os.makedirs(FOLDER, exist_ok=True)
    path = os.path.join(FOLDER, name + ".ply")
    make(path, *args)
    return {"type": "mesh", "material": "clay", "file": path}


def _quad(material, *vertices, **more):
    return {"type": "quad", "material": material, "vertices": [list(v) for v in vertices], **more}


def examples():
    return sorted(name[:-len(".json")] for name in os.listdir(SCENES) if name.endswith(".json"))


def example(name):
    with open(os.path.join(SCENES, name + ".json"), encoding="utf-8") as file:
        return json.load(file)


def lacking(document):
    files = [shape["file"] for shape in document["shapes"] if "file" in shape]
    return next((file for file in files if not os.path.exists(os.path.join(FOLDER, file))), None)


def flat(document):
    document = copy.deepcopy(document)
    for shape in document["shapes"]:
        if "file" in shape:
            shape["normals"] = "flat"
    return document


def cornell():
    document = example("cornell-box")
    document["film"] = {"width": 256, "height": 256, "filter": {"type": "box"}}
    return document


def spheres():
    """The Cornell box with a glass and a mirror ball instead of the blocks."""
    document = cornell()
    del document["shapes"][WALLS:]
    document["materials"]["glass"] = {"type": "dielectric", "ior": 1.5}
    document["materials"]["mirror"] = {"type": "mirror", "reflectance": 0.95}
    document["shapes"] += [
        {"type": "sphere", "material": "glass", "center": [0.17, 0.1, 0.17], "radius": 0.1},
        {"type": "sphere", "material": "mirror", "center": [0.38, 0.1, 0.36], "radius": 0.1}]
    return document


def has_bunny():
    return os.path.exists(BUNNY)


def bunny():
    """The bunny, or where it is missing a ball of as many triangles, on a plain."""
    document = _base(35, [-0.017, 0.13, 0.36], [-0.017, 0.105, 0])
    document["lights"] = [{"type": "sky", "radiance": 1}]
    figure = ({"type": "mesh", "material": "clay", "file": BUNNY} if has_bunny() else
              _mesh("ball-69k", ply.sphere, (-0.017, 0.105, 0), 0.07, 186, 7))
    document["shapes"] = [figure, _quad("clay", (-1, 0.033, 1), (1, 0.033, 1), (1, 0.033, -1), (-1, 0.033, -1))]
    return document


def interior():
    """1.06 million triangles: three bumpy balls in a box with a lamp."""
    document = _base(39, [0, 1, 3.7], [0, 1, 0])
    document["materials"].update(red={"type": "diffuse", "albedo": [0.63, 0.065, 0.05]},
                                 green={"type": "diffuse", "albedo": [0.14, 0.45, 0.091]},
                                 lamp={"type": "diffuse", "albedo": 0})
    document["shapes"] = [
        _quad("clay", (-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)),
        _quad("clay", (-1, 2, 1), (-1, 2, -1), (1, 2, -1), (1, 2, 1)),
        _quad("clay", (-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)),
        _quad("red", (-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)),
        _quad("green", (1, 0, 1), (1, 2, 1), (1, 2, -1), (1, 0, -1)),
        _quad("lamp", (-0.3, 1.99, 0.3), (-0.3, 1.99, -0.3), (0.3, 1.99, -0.3), (0.3, 1.99, 0.3), emission=15),
        _mesh("ball-1", ply.sphere, (-0.45, 0.5, -0.3), 0.45, 420, 1),
        _mesh("ball-2", ply.sphere, (0.45, 0.45, 0.2), 0.4, 420, 2),
        _mesh("ball-3", ply.sphere, (0.1, 1.3, -0.4), 0.35, 420, 3)]
    return document


def terrain():
    """1.05 million triangles of hills under a sky of radiance 1."""
    document = _base(40, [0, 5, 13], [0, -1.2, 0])
    document["lights"] = [{"type": "sky", "radiance": 1}]
    document["shapes"] = [_mesh("terrain", ply.terrain, 724, 1)]
    return document


def sized(document, side, spp, seed=0):
    document = copy.deepcopy(document)
    film = document["film"]
    shorter = min(film["width"], film["height"])
    film.update(width=film["width"] * side // shorter, height=film["height"] * side // shorter)
    document["settings"].update(seed=seed, target={"spp": spp})
    return document


def written(document, name):
    os.makedirs(FOLDER, exist_ok=True)
    path = os.path.join(FOLDER, name + ".json")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(document, file)
    return path
