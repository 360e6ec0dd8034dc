"""exr.py - the benches' own eyes: EXR files read, PNG files written. Standard library only.

    read(path)                  (width, height, [R, G, B]), each an array of floats, rows from the top
    write_png(path, rows)       8-bit sRGB of linear pixels at exposure 1; rows of (r, g, b)

Reads what smalti and Blender write here: one part, scan lines, not compressed or ZIP, 32-bit channels. The layout is
that of "OpenEXR File Layout" (https://openexr.com/en/latest/OpenEXRFileLayout.html).
SPDX-License-Identifier: MIT
"""

import array
import struct
import sys
import zlib

LINES = {0: 1, 2: 1, 3: 16}  # in a chunk, by compression: none, ZIPS, ZIP


def _text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _header(data):
    """The attributes by name, and where they end."""
    magic, version = struct.unpack_from("<II", data)
    if magic != 20000630 or version & 0x1a00:
        raise ValueError("expected a single-part EXR of scan lines")
    found, at = {}, 8
    while data[at]:
        name, at = _text(data, at)
        _, at = _text(data, at)
        size, = struct.unpack_from("<i", data, at)
        found[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def _channels(data):
    names, at = [], 0
    while data[at]:
        name, at = _text(data, at)
        kind, = struct.unpack_from("<i", data, at)
        if kind == 1:
            raise ValueError(f"channel {name} has 16 bits, expected 32")
        names.append(name)
        at += 16
    return names


def _unzipped(data):
    """Deflated differences of bytes, all first halves before all second halves."""
    data = bytearray(zlib.decompress(data))
    for i in range(1, len(data)):
        data[i] = (data[i - 1] + data[i] - 128) & 255
    whole = bytearray(len(data))
    whole[0::2], whole[1::2] = data[:(len(data) + 1) // 2], data[(len(data) + 1) // 2:]
    return bytes(whole)


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    header, at = _header(data)
    names = _channels(header["channels"])
    left, top, right, bottom = struct.unpack("<4i", header["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    lines = LINES[header["compression"][0]]
    planes = {name: array.array("f") for name in "RGB"}
    for offset in struct.unpack_from(f"<{-(-height // lines)}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        count = min(lines, bottom + 1 - y)
        chunk = data[offset + 8:offset + 8 + size]
        if size < 4 * width * len(names) * count:
            chunk = _unzipped(chunk)
        for line in range(count):
            for name in planes:
                begin = 4 * width * (line * len(names) + names.index(name))
                planes[name].frombytes(chunk[begin:begin + 4 * width])
    if sys.byteorder == "big":
        for plane in planes.values():
            plane.byteswap()
    return width, height, [planes[name] for name in "RGB"]


def _srgb8(x):
    x = min(max(x, 0), 1)
    return round(255 * (12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055))


def write_png(path, rows):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    head = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2, 0, 0, 0)
    lines = b"".join(b"\0" + bytes(_srgb8(c) for pixel in row for c in pixel) for row in rows)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head)
                   + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b""))
