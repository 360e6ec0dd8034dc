"""10 000 copies of the Stanford bunny, 690 million triangles: one document, rendered by a coordinator and a worker in less than 1 GiB
each. Without ../shared/assets a ball of as many triangles stands in.
SPDX-License-Identifier: MIT"""

import json
import math
import os
import random
import re

import farm

BUNNY = os.path.join(os.path.dirname(farm.ROOT), "shared", "assets", "stanford-bunny.obj")
SIDE = 100                 # instances along a side of the meadow
MOST_KB = 1024 * 1024      # 1 GiB, of any one process
DOCUMENT_MOST = 4 << 20    # SCENE_MAX_BYTES


def write_ball(path, rings=188):
    """2 * rings * columns triangles about, of the bunny's size, on the ground."""
    columns = rings
    with open(path, "w", encoding="ascii") as file:
        for i in range(rings + 1):
            for j in range(columns):
                t, p = math.pi * i / rings, 2 * math.pi * j / columns
                r = 0.07 * (1 + 0.1 * math.sin(t) * math.sin(5 * p) * math.sin(6 * t))
                file.write(f"v {r * math.sin(t) * math.sin(p):.6f} {0.08 + r * math.cos(t):.6f} "
                           f"{r * math.sin(t) * math.cos(p):.6f}\n")
        for i in range(rings):
            for j in range(columns):
                a, b = i * columns + j + 1, i * columns + (j + 1) % columns + 1
                file.write(f"f {a} {a + columns} {b + columns} {b}\n")


def shape(file, i, dice):
    """Upright, turned and scaled at random, at its place of the grid: a short transform."""
    angle, scale = dice.uniform(0, 2 * math.pi), dice.uniform(0.7, 1.3)
    c, s = scale * math.cos(angle), scale * math.sin(angle)
    x, z = 0.2 * (i % SIDE - SIDE / 2), 0.2 * (i // SIDE - SIDE / 2)
    rows = [c, 0, s, x, 0, scale, 0, -0.033 * scale, -s, 0, c, z, 0, 0, 0, 1]
    return {"type": "mesh", "material": ("clay", "brick", "moss")[i % 3], "file": file,
            "transform": [round(v, 3) for v in rows]}


def document(file):
    dice = random.Random(6)
    ground = [[-40, 0, -40], [-40, 0, 40], [40, 0, 40], [40, 0, -40]]
    return {"smalti": 1, "film": {"width": 160, "height": 90},
            "camera": {"type": "perspective", "fov_deg": 35, "look_at": {"from": [0, 3, 13], "to": [0, 0, 4]}},
            "materials": {"clay": {"type": "diffuse", "albedo": [0.7, 0.65, 0.6]},
                          "brick": {"type": "diffuse", "albedo": [0.6, 0.25, 0.15]},
                          "moss": {"type": "diffuse", "albedo": [0.25, 0.45, 0.15]},
                          "earth": {"type": "diffuse", "albedo": 0.4}},
            "shapes": [{"type": "quad", "material": "earth", "vertices": ground}] +
                      [shape(file, i, dice) for i in range(SIDE * SIDE)],
            "lights": [{"type": "sky", "radiance": [0.6, 0.75, 1]},
                       {"type": "distant", "direction": [-0.5, -1, -0.4], "irradiance": [3, 2.8, 2.4]}],
            "settings": {"integrator": "path", "max_bounces": 3, "target": {"spp": 8}}}


def peak_kb(argv, log):
    """Runs a program to its end: exit status and the largest resident set of it and of each process it has waited for."""
    pid = os.posix_spawn(argv[0], argv, os.environ, file_actions=[
        (os.POSIX_SPAWN_OPEN, 1, log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600),
        (os.POSIX_SPAWN_DUP2, 1, 2)])
    _, status, usage = os.wait4(pid, 0)
    return os.waitstatus_to_exitcode(status), usage.ru_maxrss


def test(f, t):
    name, mesh = "bunnies", BUNNY
    if not os.path.exists(BUNNY):
        name, mesh = "balls", os.path.join(f.dir, "ball.obj")
        t.diag("../shared/assets/stanford-bunny.obj is not there: a ball stands in")
        write_ball(mesh)
    os.symlink(mesh, os.path.join(f.dir, "m.obj"))  # a short name
    path, out, log = (os.path.join(f.dir, name) for name in ("meadow.json", "meadow.exr", "render.log"))
    with open(path, "w", encoding="ascii") as file:
        json.dump(document("m.obj"), file, separators=(",", ":"))
    t.ok(os.path.getsize(path) < DOCUMENT_MOST, f"10 000 {name} are a document of {os.path.getsize(path) / 1e6:.1f} MB")
    said = f.run("check", path).stdout
    triangles = int(re.search(r"1 meshes with (\d+) triangles", said).group(1))
    t.ok(triangles > 690_000_000, f"they are one mesh, used as {triangles / 1e6:.1f} million triangles")
    status, kb = peak_kb([os.path.join(farm.BIN, "smalti"), "render", path, "-o", out, "--quiet"], log)
    with open(log, encoding="utf-8") as file:
        t.equal((status, file.read()), (0, ""), f"10 000 {name} are rendered")
    t.ok(kb < MOST_KB, f"the largest process needs {kb / 1024:.0f} MiB, less than 1024")


farm.main(test)
