"""Scanned meshes from ../shared/assets, when it is there: read, uploaded, rendered by a farm and in one process alike.
SPDX-License-Identifier: MIT"""

import json
import os

import farm

ASSETS = os.path.join(os.path.dirname(farm.ROOT), "shared", "assets")
SCANS = ("stanford-bunny.obj", "nefertiti.obj", "igea.ply")


def document(name):
    return {"smalti": 1, "film": {"width": 48, "height": 48},
            "camera": {"type": "perspective", "fov_deg": 40, "look_at": {"from": [0, 0.1, 0.4], "to": [0, 0.1, 0]}},
            "materials": {"clay": {"type": "diffuse", "albedo": 0.7}},
            "shapes": [{"type": "mesh", "material": "clay", "file": os.path.join(ASSETS, name)}],
            "lights": [{"type": "sky", "radiance": 1}], "settings": {"integrator": "path", "target": {"spp": 16}}}


def test(f, t):
    for name in SCANS:
        if not os.path.exists(os.path.join(ASSETS, name)):
            t.skip(f"{name} renders", "../shared/assets is not there")
            continue
        path, out = os.path.join(f.dir, "scan.json"), os.path.join(f.dir, "scan.exr")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(document(name), file)
        done = f.run("render", path, "-o", out)
        t.equal(done.returncode, 0, f"{name} renders")
        t.equal(f.run("digest", out).stdout.strip(), farm.local_digest(document(name)), f"{name}: as in one process")


farm.main(test)
