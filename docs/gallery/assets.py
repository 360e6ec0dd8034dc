"""Images and meshes for the gallery: made by formulas, so that none has to be kept.
SPDX-License-Identifier: MIT
"""

import math
import os
import struct
import zlib

SIDE = 256


# --- noise ---

def hashed(*numbers):
    """In [0, 1)."""
    h = 2166136261
    for n in numbers:
        h = ((h ^ (n & 0xffffffff)) * 16777619) & 0xffffffff
        h ^= h >> 15
        h = (h * 0x2c1b3c6d) & 0xffffffff
    return ((h ^ (h >> 13)) & 0xffffff) / 0x1000000


def smooth(t):
    return t * t * (3 - 2 * t)


def noise(u, v, cells, seed=0):
    """Values at the corners of cells x cells squares, smoothly between them; repeats in [0, 1]."""
    x, y = u * cells, v * cells
    i, j = math.floor(x), math.floor(y)
    s, t = smooth(x - i), smooth(y - j)

    def corner(a, b):
        return hashed((i + a) % cells, (j + b) % cells, cells, seed)

    low = corner(0, 0) * (1 - s) + corner(1, 0) * s
    high = corner(0, 1) * (1 - s) + corner(1, 1) * s
    return low * (1 - t) + high * t


def clouds(u, v, cells, octaves, seed=0):
    total = sum(noise(u, v, cells << k, seed + k) / (1 << k) for k in range(octaves))
    return total / (2 - 2 / (1 << octaves))


# --- images ---

def write_png(path, channels, bits, value):
    """value(u, v): numbers in [0, 1], as many as there are channels."""
    most = (1 << bits) - 1
    rows = bytearray()
    for y in range(SIDE):
        rows.append(0)
        for x in range(SIDE):
            for c in value((x + 0.5) / SIDE, 1 - (y + 0.5) / SIDE):
                rows += int(min(max(c, 0), 1) * most + 0.5).to_bytes(bits // 8, "big")

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", SIDE, SIDE, bits, {1: 0, 3: 2}[channels], 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(rows), 6)) +
                   chunk(b"IEND", b""))


def wood(u, v):
    warp = clouds(u, v, 2, 4, 10)
    rings = math.sin(2 * math.pi * (8 * u + 2.2 * warp))
    fibres = noise(u, v / 8, 128, 20)
    t = min(max(0.5 + 0.32 * rings + 0.25 * (fibres - 0.5), 0), 1)
    return [a + (b - a) * t for a, b in zip((0.36, 0.2, 0.1), (0.72, 0.5, 0.3))]


def dents(u, v):
    """Hammered metal: round dents about points, of which each square has one."""
    cells = 8
    x, y = u * cells, v * cells
    nearest = 4.0
    for i in range(math.floor(x) - 1, math.floor(x) + 2):
        for j in range(math.floor(y) - 1, math.floor(y) + 2):
            px = i + 0.15 + 0.7 * hashed(i % cells, j % cells, 1)
            py = j + 0.15 + 0.7 * hashed(i % cells, j % cells, 2)
            nearest = min(nearest, (x - px) ** 2 + (y - py) ** 2)
    return [min(nearest, 0.8) / 0.8]


def brick(u, v):
    """Height, and which brick it is: 4 rows of 2, every other one moved by half."""
    row = math.floor(v * 4)
    x = (u * 2 + (row % 2) / 2) % 2
    column = math.floor(x)
    edge = min((x - column) * 2, (column + 1 - x) * 2, v * 4 - row, row + 1 - v * 4)  # in heights of a row
    ramp = smooth(min(max((edge - 0.06) / 0.1, 0), 1))
    return ramp + 0.12 * (clouds(u, v, 16, 3, 30) - 0.5) * ramp, hashed(column, row, 40)


def brick_normal(u, v):
    step, depth = 0.5 / SIDE, 0.035
    du = (brick((u + step) % 1, v)[0] - brick((u - step) % 1, v)[0]) * depth / (2 * step)
    dv = (brick(u, (v + step) % 1)[0] - brick(u, (v - step) % 1)[0]) * depth / (2 * step)
    length = math.sqrt(du * du + dv * dv + 1)
    return [0.5 - 0.5 * du / length, 0.5 - 0.5 * dv / length, 0.5 + 0.5 / length]


def brick_color(u, v):
    ramp, which = brick(u, v)
    grain = 0.75 + 0.5 * clouds(u, v, 16, 4, 50)
    stone = [c * grain * (0.75 + 0.5 * which) for c in (0.62, 0.26, 0.18)]
    return [m + (c - m) * min(ramp, 1) for m, c in zip((0.62, 0.6, 0.57), stone)]


def smudges(u, v):
    c = clouds(u, v, 4, 5, 60)
    return [smooth(min(max((c - 0.38) / 0.24, 0), 1))]


# --- meshes ---

def knot_point(t, w):
    """On the tube around a (2, 3) torus knot, and the normal there."""
    def curve(a):
        r = 0.62 + 0.24 * math.cos(3 * a)
        return r * math.cos(2 * a), 0.26 * math.sin(3 * a), r * math.sin(2 * a)

    def minus(a, b):
        return [x - y for x, y in zip(a, b)]

    def unit(a):
        length = math.sqrt(sum(x * x for x in a))
        return [x / length for x in a]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    along = unit(minus(curve(t + 1e-4), curve(t - 1e-4)))
    side = unit(cross(along, curve(t)))
    other = cross(along, side)
    normal = [math.cos(w) * a + math.sin(w) * b for a, b in zip(side, other)]
    return [c + 0.15 * n for c, n in zip(curve(t), normal)], normal


def write_knot(path):
    """PLY with normals, texture coordinates and colours of vertices."""
    long, round_ = 192, 24
    with open(path, "w", encoding="ascii") as file:
        file.write("ply\nformat ascii 1.0\nelement vertex %d\n" % ((long + 1) * (round_ + 1)))
        for name in "x y z nx ny nz s t".split():
            file.write("property float %s\n" % name)
        for name in "red green blue".split():
            file.write("property uchar %s\n" % name)
        file.write("element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (long * round_))
        for i in range(long + 1):
            for j in range(round_ + 1):
                t, w = 2 * math.pi * i / long, -2 * math.pi * j / round_
                p, n = knot_point(t, w)
                hue = [round(255 * (0.5 + 0.45 * math.cos(t + 2 * math.pi * k / 3))) for k in range(3)]
                file.write(" ".join("%.6g" % x for x in p + n + [i / long, j / round_]) + " %d %d %d\n" % tuple(hue))
        for i in range(long):
            for j in range(round_):
                a = i * (round_ + 1) + j
                file.write("4 %d %d %d %d\n" % (a, a + round_ + 1, a + round_ + 2, a + 1))


def write_ball(path):
    """OBJ: a coarse ball on the ground, without normals."""
    long, high = 14, 9
    with open(path, "w", encoding="ascii") as file:
        file.write("v 0 0 0\n")
        for j in range(1, high):
            for i in range(long):
                a, b = 2 * math.pi * i / long, math.pi * j / high
                file.write("v %.6f %.6f %.6f\n" % (math.sin(b) * math.sin(a), 1 - math.cos(b), math.sin(b) * math.cos(a)))
        top = 2 + long * (high - 1)
        file.write("v 0 2 0\n")
        for i in range(long):
            k = (i + 1) % long
            file.write("f 1 %d %d\n" % (2 + k, 2 + i))
            for j in range(high - 2):
                a = 2 + long * j
                file.write("f %d %d %d %d\n" % (a + i, a + k, a + long + k, a + long + i))
            file.write("f %d %d %d\n" % (top - long + i, top - long + k, top))


FILES = {
    "wood.png": lambda path: write_png(path, 3, 8, wood),
    "brick.png": lambda path: write_png(path, 3, 8, brick_color),
    "brick-normal.png": lambda path: write_png(path, 3, 8, brick_normal),
    "dents.png": lambda path: write_png(path, 1, 16, dents),
    "smudges.png": lambda path: write_png(path, 1, 8, smudges),
    "knot.ply": write_knot,
    "ball.obj": write_ball,
}


def write_all(folder):
    """Those that are not there yet, as this file makes them."""
    for name, write in FILES.items():
        path = os.path.join(folder, name)
        if not os.path.exists(path) or os.path.getmtime(path) < os.path.getmtime(__file__):
            write(path)
