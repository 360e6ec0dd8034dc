"""bench_shared: one copy of a scene for all workers of a machine.

A height field of five million triangles, as a binary PLY in a temporary directory. One worker process starts with an empty cache
and prepares it; a second one starts later and maps it; then eight start at once with another empty cache. Memory is the
proportional share (Pss of smaps_rollup), in which a page that n processes map counts 1/n for each, summed over the processes
while they render, beside that of the one that only mapped. TRIANGLES and PROCESSES in the environment change the numbers.
Last line: "bench-shared: pss-ratio X second-start Y%". SPDX-License-Identifier: MIT
"""

import array
import math
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests"))
import farm  # pylint: disable=wrong-import-position

TRIANGLES = int(os.environ.get("TRIANGLES", "5000000"))
PROCESSES = int(os.environ.get("PROCESSES", "8"))
MIB = 1 << 20


def height_field(side):
    """side x side vertices over 10 m x 10 m; a Python list operation per row, so that it takes seconds only."""
    steps = [10 * i / (side - 1) - 5 for i in range(side)]
    waves = [math.sin(3 * x) + 0.25 * math.sin(17 * x + 1) for x in steps]
    vertices = array.array("f", bytes(12 * side * side))
    for z in range(side):
        row = 3 * side * z
        vertices[row:row + 3 * side:3] = array.array("f", steps)
        vertices[row + 1:row + 3 * side:3] = array.array("f", [0.2 * w * waves[z] for w in waves])
        vertices[row + 2:row + 3 * side:3] = array.array("f", [-steps[z]] * side)
    return vertices


def faces(side):
    """Records of a count and three indices, 13 bytes each: written byte by byte of all records at once."""
    corners = [array.array("i"), array.array("i"), array.array("i")]
    for z in range(side - 1):
        at, up = z * side, (z + 1) * side
        for corner, begins in zip(corners, ((at, at + 1), (at + 1, up + 1), (up, up))):
            pair = array.array("i", bytes(8 * (side - 1)))
            for k, begin in enumerate(begins):
                pair[k::2] = array.array("i", range(begin, begin + side - 1))
            corner.extend(pair)
    count = 2 * (side - 1) ** 2
    records = bytearray(13 * count)
    records[0::13] = b"\3" * count
    for k, corner in enumerate(corners):
        data = corner.tobytes()
        for byte in range(4):
            records[1 + 4 * k + byte::13] = data[byte::4]
    return count, records


def mesh():
    side = int(math.sqrt(TRIANGLES / 2)) + 2
    count, records = faces(side)
    head = ("ply\nformat binary_little_endian 1.0\n"
            f"element vertex {side * side}\nproperty float x\nproperty float y\nproperty float z\n"
            f"element face {count}\nproperty list uchar int vertex_indices\nend_header\n")
    return count, head.encode() + height_field(side).tobytes() + bytes(records)


def scene(asset):
    return {"smalti": 1, "film": {"width": 512, "height": 512},
            "camera": {"type": "perspective", "fov_deg": 50, "look_at": {"from": [0, 3, 7], "to": [0, 0, 0]}},
            "materials": {"earth": {"type": "diffuse", "albedo": 0.5}},
            "shapes": [{"type": "mesh", "material": "earth", "format": "ply", "asset": asset}],
            "lights": [{"type": "sky", "radiance": 1}], "settings": {"integrator": "path", "target": {"spp": 65536}}}


def kib(process, file, field):
    with open(f"/proc/{process.pid}/{file}") as lines:
        return int(re.search(rf"^{field}:\s+(\d+) kB", lines.read(), re.M).group(1))


def story(worker):
    """What the worker says of its scene: how it came about, and milliseconds."""
    line = re.search(r"scene_ready .*", worker.log())
    return dict(word.split("=") for word in line.group(0).split()[1:]) if line else None


class Workers:
    """Some that start at once, looked at when all have the scene and render."""

    def __init__(self, f, job, cache, count):
        workers = [f.start_worker("--threads", "1", "--cache", os.path.join(f.dir, cache)) for _ in range(count)]
        self.stories = [f.wait_for("the scene to be ready", lambda w=w: story(w), 600) for w in workers]
        done = f.job(job)["tile_passes"]["done"]
        f.wait_for("passes", lambda: f.job(job)["tile_passes"]["done"] >= done + 8 * count, 600)
        self.pss = sum(kib(w, "smaps_rollup", "Pss") for w in workers) / 1024
        self.own = [kib(w, "smaps_rollup", "Private_Dirty") / 1024 for w in workers]
        self.peaks = [kib(w, "status", "VmHWM") / 1024 for w in workers]
        for worker in workers:
            worker.stop()

    def ways(self):
        ways = [s["how"] for s in self.stories]
        return ", ".join(f"{ways.count(way)} {way}" for way in sorted(set(ways)))


def main():
    count, data = mesh()
    print(f"{count} triangles, {len(data) / MIB:.0f} MiB of PLY", flush=True)
    with farm.Farm() as f:
        f.start_server()
        job = f.submit(scene(f.upload(data)))
        del data
        first, second = Workers(f, job, "cache", 1), Workers(f, job, "cache", 1)
        for name, run in (("first start", first), ("second start", second)):
            told = run.stories[0]
            print(f"{name}: {told['how']}, scene ready after {told['ms']} ms (assets {told['load_ms']}, preparing "
                  f"{told['prepare_ms']}, writing and mapping {told['share_ms']}); block "
                  f"{int(told['bytes']) / MIB:.0f} MiB, process {run.pss:.0f} MiB, at most {run.peaks[0]:.0f} MiB",
                  flush=True)
        all_at_once = Workers(f, job, "other", PROCESSES)
        print(f"{PROCESSES} processes at once: {all_at_once.ways()}; together {all_at_once.pss:.0f} MiB, of their own "
              f"{min(all_at_once.own):.1f} to {max(all_at_once.own):.1f} MiB each; at most, with all that they map, "
              + " ".join(f"{peak:.0f}" for peak in sorted(all_at_once.peaks)) + " MiB", flush=True)
        f.call("DELETE", f"/v1/jobs/{job}")
        f.stop()
    if all_at_once.ways() != f"{PROCESSES - 1} mapped, 1 prepared":
        sys.exit("bench-shared: not one that prepares and others that map")
    ratio = all_at_once.pss / second.pss
    share = 100 * int(second.stories[0]["ms"]) / int(first.stories[0]["ms"])
    print(f"bench-shared: pss-ratio {ratio:.3f} second-start {share:.1f}%")


main()
