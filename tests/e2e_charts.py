"""smalti chart: the same numbers with any number of threads, figures that are whole, and what it refuses.
SPDX-License-Identifier: MIT"""

import copy
import csv
import json
import os
import re
import xml.dom.minidom

import farm

SCENE = {
    "smalti": 1,
    "title": "A <plate> & a lamp",
    "film": {"width": 32, "height": 16},
    "camera": {"type": "perspective", "fov_deg": 40, "look_at": {"from": [0, 2, 4], "to": [0, 0, 0]}},
    "materials": {
        "white": {"type": "diffuse", "albedo": 0.6},
        "iron": {"type": "conductor", "metal": "iron", "alpha": 0.3, "multiscatter": True},
    },
    "shapes": [
        {"type": "disc", "material": "white", "center": [0, 0, 0], "normal": [0, 1, 0], "radius": 9},
        {"type": "sphere", "material": "iron", "center": [0, 0.5, 0], "radius": 0.5},
        {"type": "disc", "material": "white", "emission": 6, "center": [2, 3, 0], "normal": [-0.5, -1, 0], "radius": 1},
    ],
    "lights": [{"type": "sky", "radiance": 0.5}],
    "settings": {"max_bounces": 6},
}
FLAGS = ["--size", "12", "--spp", "32", "--runs", "4", "--reference", "1024"]
FILES = ["plate-price.csv", "plate-price.svg", "plate.csv", "plate.svg"]


def write(f, document, name="plate.json"):
    path = os.path.join(f.dir, name)
    with open(path, "w", encoding="utf-8") as file:
        json.dump(document, file)
    return path


def changed(**members):
    return {**copy.deepcopy(SCENE), **members}


def table(path):
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if any(None in row or None in row.values() for row in rows):
        raise farm.Failure(f"{path}: a row is longer or shorter than its head")
    return rows


def charts(f, t):
    scene, one, two = write(f, SCENE), os.path.join(f.dir, "one"), os.path.join(f.dir, "two")
    done = f.run("chart", scene, "-o", one, *FLAGS, "--threads", "1")
    t.equal(done.returncode, 0, "chart: exit status 0")
    t.equal(sorted(os.listdir(one)), FILES, "chart: four files and nothing else")
    t.equal(done.stderr.splitlines()[-4:], [f"{one}/{name}" for name in ("plate.svg", "plate.csv", "plate-price.svg", "plate-price.csv")],
            "chart: names them")
    done = f.run("chart", scene, "-o", two, *FLAGS, "--threads", "3", "--quiet")
    t.equal((done.returncode, done.stdout, done.stderr), (0, "", ""), "chart --quiet: silence")
    for name in ("plate.csv", "plate-price.csv"):
        rows = [[{k: v for k, v in row.items() if k != "seconds"} for row in table(os.path.join(d, name))] for d in (one, two)]
        t.ok(rows[0] == rows[1] and len(rows[0]) > 5, f"chart: {name} but for seconds is the same with three threads")
    rows = table(os.path.join(one, "plate.csv"))
    t.equal({row["spp"] for row in rows[:-1]}, {"8", "16", "32"}, "chart: a point at each power of two")
    t.ok({"path-mis", "path-light", "path-bsdf", "direct", "whitted"} <= {row["method"] for row in rows}, "chart: every method")
    t.ok(all(float(r["relmse_low"]) < float(r["relmse"]) < float(r["relmse_high"]) for r in rows[:-1]), "chart: bands hold their means")
    missing = {row["method"]: row["class_missing"] for row in rows[:-1]}
    t.ok(missing["path-mis"] == missing["path-bsdf"] == "0" and missing["whitted"] == "1",
         "chart: whitted misses what plates send to each other, paths nothing", missing)
    planned = {row["method"] for row in rows[:-1] if row["planned"] == "1"}
    t.ok(len(planned) == 1 and planned <= {"path-mis", "path-light", "path-bsdf"}, "chart: one line, a sufficient one, is the planner's choice",
         planned)
    price = {row["left_out"]: row for row in table(os.path.join(one, "plate-price.csv"))}
    t.ok("multiple scattering on facets" in price and "absorption" not in price, "chart: prices of the pieces that there are", list(price))
    t.ok(float(price["indirect light"]["work_saved"]) > .05 and float(price["indirect light"]["energy_added"]) < 0,
         "chart: indirect light costs work and brings energy")
    for name in ("plate.svg", "plate-price.svg"):
        with open(os.path.join(one, name), encoding="utf-8") as file:
            text = file.read()
        xml.dom.minidom.parseString(text)
        t.ok("A &lt;plate&gt; &amp; a lamp" in text and not re.search(r"['\", ](-?nan|-?inf)", text), f"chart: {name} is sound")


def refusals(f, t):
    out = os.path.join(f.dir, "none")

    def refused(document, status, text, *flags, name="plate.json"):
        done = f.run("chart", write(f, document, name), "-o", out, *FLAGS, "--quiet", *flags)
        t.ok(done.returncode == status and text in done.stderr and not os.path.exists(out), f"refused: {text}", done.stderr)

    dark = changed(lights=[])
    dark["shapes"] = dark["shapes"][:2]
    refused(dark, 3, "there is no light in the image")
    refused(changed(shapes=[]), 3, "without noise")
    refused(SCENE, 3, "are not shown to be equal within 1 %", "--size", "2", "--reference", "64")
    lost = changed()
    lost["shapes"].append({"type": "mesh", "material": "white", "file": "gone.ply"})
    refused(lost, 3, "gone.ply: No such file or directory")
    refused(changed(camera={"type": "fish"}), 3, "/camera")
    refused(SCENE, 2, "--spp must be 8 times a power of two, got 24", "--spp", "24")
    refused(SCENE, 2, "runs", "--runs", "1")

    scene = write(f, SCENE)
    done = f.run("chart", scene, "-o", os.path.join(scene, "below"), *FLAGS)
    t.ok(done.returncode == 5 and "plate.json/below" in done.stderr, "refused: a directory below a file", done.stderr)
    done = f.run("chart", scene, "-o", "/proc", *FLAGS)
    t.ok(done.returncode == 5 and "/proc/plate" in done.stderr, "refused: a directory that takes no files", done.stderr)
    done = f.run("chart", scene, "-o", os.path.join(f.dir, "a/b/c"), *FLAGS)
    t.ok(done.returncode == 5 and not os.path.exists(os.path.join(f.dir, "a")), "refused: a directory in none", done.stderr)

    done = f.run("chart", scene, "-o", out, "--size", "1", "--spp", "32", "--runs", "4", "--reference", "16384", "--quiet")
    t.ok(done.returncode == 0 and sorted(os.listdir(out)) == FILES, "one pixel is charted", done.stderr)


def test(f, t):
    charts(f, t)
    refusals(f, t)


farm.main(test)
