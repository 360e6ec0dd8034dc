"""ply.py - the big meshes of the benches as binary PLY files, made once and kept in build/bench.

    sphere(path, center, radius, steps, seed)   2 steps^2 triangles: a ball with bumps of four sizes
    terrain(path, steps, seed)                  2 steps^2 triangles: hills over [-10, 10]^2, y up

The bytes are a function of the arguments (and of libm's sine). Standard library only: a million triangles take a few
seconds. A file that is there already is trusted; it appears whole or not at all.
SPDX-License-Identifier: MIT
"""

import array
import math
import os
import random
import struct
import sys


def _write(path, positions, columns):
    """Vertices of a grid with that many columns, row by row, as a mesh of two triangles per cell."""
    rows = len(positions) // 3 // columns
    head = ("ply\nformat binary_little_endian 1.0\n"
            f"element vertex {rows * columns}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {2 * (rows - 1) * (columns - 1)}\nproperty list uchar int vertex_indices\nend_header\n")
    pair = struct.Struct("<BiiiBiii")
    faces = bytearray(pair.size * (rows - 1) * (columns - 1))
    at = 0
    for row in range(rows - 1):
        for i in range(row * columns, row * columns + columns - 1):
            pair.pack_into(faces, at, 3, i, i + columns, i + columns + 1, 3, i, i + columns + 1, i + 1)
            at += pair.size
    if sys.byteorder == "big":
        positions.byteswap()
    with open(path + ".new", "wb") as file:
        file.write(head.encode() + positions.tobytes() + faces)
    os.replace(path + ".new", path)


def sphere(path, center, radius, steps, seed):
    if os.path.exists(path):
        return
    dice = random.Random(seed)
    waves = [(2 ** k * 5, 2 ** k * 4, 0.05 / 1.9 ** k, dice.random() * 7, dice.random() * 7) for k in range(4)]
    turn = [2 * math.pi * j / steps for j in range(steps)] + [0]  # the seam closes to the bit
    across = [[a * math.sin(m * phi + p) for phi in turn] for m, _, a, p, _ in waves]
    circle = [(math.cos(phi), math.sin(phi)) for phi in turn]
    positions = array.array("f")
    for i in range(steps + 1):
        theta = math.pi * i / steps
        sin, cos = (math.sin(theta), math.cos(theta)) if i < steps else (0, -1)
        # The bumps fade towards the poles, so that each pole is one point.
        down = [sin * math.sin(n * theta + q) for _, n, _, _, q in waves]
        for j, (x, z) in enumerate(circle):
            r = radius * (1 + sum(d * a[j] for d, a in zip(down, across)))
            positions.extend((center[0] + r * sin * x, center[1] + r * cos, center[2] - r * sin * z))
    _write(path, positions, steps + 1)


def terrain(path, steps, seed):
    """Value noise of eight octaves, smooth between random heights on ever finer grids."""
    if os.path.exists(path):
        return
    dice = random.Random(seed)
    heights = [[0.0] * (steps + 1) for _ in range(steps + 1)]
    for octave in range(8):
        cells = 3 * 2 ** octave
        grid = [[dice.uniform(-1, 1) for _ in range(cells + 1)] for _ in range(cells + 1)]
        places = [_place(k * cells / steps, cells) for k in range(steps + 1)]
        for row, (z, wz) in zip(heights, places):
            line = [a + (b - a) * wz for a, b in zip(grid[z], grid[z + 1])]
            for k, (x, wx) in enumerate(places):
                row[k] += 1.6 / 2.1 ** octave * (line[x] + (line[x + 1] - line[x]) * wx)
    positions = array.array("f")
    for i, row in enumerate(heights):
        for k, y in enumerate(row):
            positions.extend((20 * k / steps - 10, y, 20 * i / steps - 10))
    _write(path, positions, steps + 1)


def _place(at, cells):
    """The cell and the smoothed weight inside it."""
    cell = min(int(at), cells - 1)
    t = at - cell
    return cell, t * t * (3 - 2 * t)
