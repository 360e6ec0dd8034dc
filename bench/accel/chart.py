"""accel/chart.py CSV SVG: draws what bench-accel measured (docs/accel.md says how to read it).

SPDX-License-Identifier: MIT
"""

import csv
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import svg_chart as chart  # pylint: disable=wrong-import-position

HEADINGS = {"ball": "Evenly spread: a bumpy ball on a ground, all triangles of one size",
            "stadium": "A teapot in a stadium: the same ball, 1 m wide, on the floor of an empty hall of 100 m"}
STRUCTURES = ["smalti", "binary BVH", "k-d tree", "BSP tree", "octree", "grid"]  # in the order of styles
NOTE = ("One thread, CPU time. Rays: half from the camera, half bounced; the same triangle test, and the same hits to the "
        "last bit, for all.\nMemory: the triangles (36 bytes each) and the structure.")
HOLLOW = "A hollow end: the structure gave up at the next size; accel.csv says why."

# title, unit, value of a row or None, whether both scenes have the same axis
PANELS = [
    ("Building", "µs per triangle",
     lambda r: 1e6 * float(r["build_s"]) / float(r["triangles"]) if r["build_s"] else None, True),
    ("Memory", "bytes per triangle", lambda r: float(r["bytes_per_triangle"]) if r["bytes_per_triangle"] else None, True),
    ("Speed", "Mrays/s", lambda r: float(r["mrays_per_s"]) if r["mrays_per_s"] else None, False),
]


def line(rows, structure, value):
    """Up to the first value that is missing: there the structure gave up."""
    mine = sorted((r for r in rows if r["structure"] == structure), key=lambda r: int(r["triangles"]))
    points = [(int(r["triangles"]), value(r)) for r in mine]
    known = next((i for i, (_, v) in enumerate(points) if v is None), len(points))
    return chart.Line(structure, points[:known], STRUCTURES.index(structure), known < len(points))


def span(values):
    """Of an axis: the values and a margin, on a logarithmic scale."""
    values = [v for v in values if v is not None]
    margin = (max(values) / min(values)) ** 0.06
    return min(values) / margin, max(values) * margin


def figure(path):
    """Title, rows and note of the figure, from the CSV."""
    with open(path, encoding="utf-8", newline="") as f:
        rows = list(csv.DictReader(f))
    if not rows:
        sys.exit(f"{path}: no measurements")
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    x_range = span([int(r["triangles"]) for r in rows])
    figure_rows = []
    for scene in scenes:
        of_scene = [r for r in rows if r["scene"] == scene]
        panels = [chart.Panel(title, "triangles", unit, [line(of_scene, s, value) for s in STRUCTURES], x_range=x_range,
                              y_range=span([value(r) for r in (rows if shared else of_scene)]))
                  for title, unit, value, shared in PANELS]
        figure_rows.append((HEADINGS[scene], panels))
    note = NOTE + ("\n" + HOLLOW if any(r["gave_up"] for r in rows) else "")
    return "Why the eight-wide BVH: the structures of the textbooks beside smalti's", figure_rows, note


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: chart.py CSV SVG")
    chart.write(sys.argv[2], *figure(sys.argv[1]))
