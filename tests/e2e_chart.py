"""The figures of docs/ and what draws them (bench/svg_chart.py): names never overlap, nothing is outside, a structure that
gave up ends hollow; docs/accel.svg is what docs/accel.csv says, and that every hit was right. SPDX-License-Identifier: MIT
"""

import csv
import importlib.util
import os
import random
import re
import sys
import tempfile
import xml.etree.ElementTree

import farm

BENCH = os.path.join(farm.ROOT, "bench")
sys.path.insert(0, BENCH)
import svg_chart as chart  # pylint: disable=wrong-import-position

SVG = "{http://www.w3.org/2000/svg}"
tap = farm.Tap()


def accel_chart():
    spec = importlib.util.spec_from_file_location("accel_chart", os.path.join(BENCH, "accel", "chart.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def texts(svg):
    """(x, y, text) of each text of each panel, in the figure's pixels, and the size of the figure."""
    root = xml.etree.ElementTree.fromstring(svg)
    found = []
    for group in [root] + root.findall(SVG + "g"):
        x, y = map(float, re.findall(r"[\d.]+", group.get("transform", "0 0")))
        for t in group.findall(SVG + "text"):
            if t.text and "rotate" not in t.get("transform", ""):
                found.append((x + float(t.get("x")), y + float(t.get("y")), t))
    return found, float(root.get("width")), float(root.get("height"))


def box(x, y, t):
    """As wide as most fonts would have it."""
    size = float(t.get("font-size"))
    width = chart.LETTER * size * len(t.text)
    begin = x - {"start": 0, "middle": width / 2, "end": width}[t.get("text-anchor")]
    return begin, y - 0.8 * size, begin + width, y + 0.2 * size


def overlaps(svg):
    found, width, height = texts(svg)
    boxes = [box(*one) for one in found]
    pairs = [(found[i][2].text, found[j][2].text) for i, a in enumerate(boxes) for j, b in enumerate(boxes[:i])
             if a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]]
    outside = [t.text for (_, _, t), b in zip(found, boxes) if b[0] < 0 or b[1] < 0 or b[2] > width or b[3] > height]
    return pairs, outside


def test_names_apart():
    dice = random.Random(1)
    worst = 0
    for _ in range(200):
        count = dice.randint(1, 7)
        lines = [chart.Line(f"structure {i}", [(100, 1), (10 ** dice.uniform(3, 6), 10 ** (dice.random() * dice.choice((0, 1, 4))))],
                            i) for i in range(count)]
        pairs, outside = overlaps(chart.figure("any", [("row", [chart.Panel("p", "x", "y", lines)])]))
        worst = max(worst, len(pairs) + len(outside))
    tap.ok(worst == 0, "names of up to seven lines that end anywhere never overlap nor leave the figure")
    heights = chart.apart([5, 5, 5, 90], 10, 0, 100)
    tap.ok(sorted(heights) == [0, 10, 20, 90], f"names are moved no farther than they must ({heights})")


def test_gave_up():
    lines = [chart.Line("a", [(1, 1), (10, 2)], 1, gave_up=True), chart.Line("b", [(1, 1), (10, 3)], 2)]
    svg = chart.figure("any", [("", [chart.Panel("p", "x", "y", lines)])])
    hollow = [e.get("stroke") for e in xml.etree.ElementTree.fromstring(svg).iter() if e.get("fill") == "#ffffff" and e.get("stroke")]
    tap.ok(hollow == [chart.STYLES[1][0]] * 2, "the last point of a line that gave up is hollow, and so is its name's marker")


def test_axes():
    def panel(**more):
        return chart.Panel("p", "x", "y", [chart.Line("a", [(1, 0.0001), (1e6, 1)], 0)], **more)

    svg = chart.figure("any", [("", [panel()])])
    names = [t.text for _, _, t in texts(svg)[0]]
    tap.ok(all(n in names for n in ("10⁻⁴", "0.001", "1", "1 k", "1 M")), "decades are named", str(names))
    svg = chart.figure("any", [("", [panel(log_x=False, log_y=False)])])
    names = [t.text for _, _, t in texts(svg)[0]]
    tap.ok(all(n in names for n in ("0", "0.2", "1", "200 k", "1 M")), "even axes have even ticks", str(names))
    try:
        chart.figure("any", [("", [chart.Panel("p", "x", "y", [chart.Line("a", [(0, 1), (1, 1)], 0)])])])
        tap.ok(False, "a logarithmic axis refuses 0")
    except ValueError as e:
        tap.ok("above 0" in str(e), "a logarithmic axis refuses 0")


def test_band():
    band = chart.Band([(1, 1, 2), (10, 2, 4)], 3)
    svg = chart.figure("a < b & c", [("", [chart.Panel("p", "x", "y", [chart.Line("l", [(1, 1.5), (10, 3)], 3)], [band])])])
    strips = [e for e in xml.etree.ElementTree.fromstring(svg).iter(SVG + "path") if e.get("fill-opacity")]
    tap.ok(len(strips) == 1 and strips[0].get("d").count("L") == 3, "a band is one strip; a title may hold any character")


def test_accel():
    module = accel_chart()
    path = os.path.join(farm.ROOT, "docs", "accel.csv")
    with open(path, encoding="utf-8", newline="") as f:
        rows = list(csv.DictReader(f))
    with open(os.path.join(farm.ROOT, "docs", "accel.svg"), encoding="utf-8") as f:
        drawn = f.read()
    tap.ok(drawn == chart.figure(*module.figure(path)), "docs/accel.svg is drawn from docs/accel.csv")
    pairs, outside = overlaps(drawn)
    tap.ok(not pairs and not outside, "docs/accel.svg: no words overlap, none is outside", str(pairs), str(outside))
    tap.ok(all(r["differ"] == "0" for r in rows), "docs/accel.csv: every structure found smalti's hits")
    sizes = {(r["scene"], r["triangles"]) for r in rows}
    ends = {(r["scene"], r["structure"]) for r in rows if r["gave_up"]}
    whole = {(scene, name) for scene in ("ball", "stadium") for name in module.STRUCTURES
             if sum(r["scene"] == scene and r["structure"] == name and r["mrays_per_s"] != "" for r in rows) == len(sizes) / 2}
    tap.ok(len(ends | whole) == 2 * len(module.STRUCTURES), "docs/accel.csv: each structure has every size or a reason")


def test_accel_gave_up():
    head = "scene,structure,triangles,build_s,bytes_per_triangle,mrays_per_s,rays,differ,gave_up\n"
    with tempfile.TemporaryDirectory() as d:
        path = os.path.join(d, "a.csv")
        with open(path, "w", encoding="utf-8") as f:
            f.write(head + "ball,smalti,100,0.1,50,2,9,0,\nball,smalti,1000,0.1,50,2,9,0,\nball,grid,100,0.1,50,2,9,0,\n"
                    "ball,grid,1000,0.1,50,,0,0,fewer than 1024 rays in 5 s\n")
        _, rows, note = accel_chart().figure(path)
    build, _, speed = [next(one for one in p.lines if one.name == "grid") for p in rows[0][1]]
    tap.ok(speed.gave_up and len(speed.points) == 1 and not build.gave_up and len(build.points) == 2 and "gave up" in note,
           "what was too slow to measure ends hollow in that panel only, and the note says what it means")


def test_accel_run():
    """The program itself, small: the CSV that the figure is drawn from."""
    program = os.path.join(farm.BIN, "bench-accel")
    done = farm.subprocess.run([program, "100"], capture_output=True, text=True, check=False, timeout=60 * farm.SLOWER)
    rows = list(csv.DictReader(done.stdout.splitlines()))
    tap.ok(done.returncode == 0 and len(rows) == 12 and all(float(r["mrays_per_s"]) > 0 and r["differ"] == "0" for r in rows),
           "bench-accel measures six structures on two scenes, with equal hits", done.stdout, done.stderr)
    done = farm.subprocess.run([program, "many"], capture_output=True, text=True, check=False, timeout=60)
    tap.ok(done.returncode == 2 and "usage" in done.stderr, "bench-accel refuses a size that is none")


test_names_apart()
test_gave_up()
test_axes()
test_band()
test_accel()
test_accel_gave_up()
test_accel_run()
print(f"1..{tap.count}")
sys.exit(tap.failed > 0)
