"""bench_cycles: noise for time, smalti against Blender's Cycles on the CPU, in one run.

    make bench-cycles       (deploy/install-deps cycles installs Blender; without it this says so and ends well)

Three scenes, each one document for both (documents.py; cycles_scene.py says how Cycles is set): the Cornell box, the
same with a ball of glass and one of mirror, 1.05 million triangles of hills under a uniform sky. 128 x 128 pixels,
one thread, the same box filter, at most 9 scatterings, the same number of samples per pixel.

Each renders SEEDS images that differ by their seed, taking turns. relMSE is that of an image against the mean of the
renderer's other ones, its own reference of many samples, averaged over all (spread.py). CPU seconds are user and
system time of the samples alone: a render minus one of a single sample, the median over seeds; ours by wait4 around
tool_local, Cycles' by getrusage around its render. Noise for time is relMSE x CPU seconds: it hardly changes with the
number of samples. Then the pictures: the two means must agree, as wholes within 1 % and in blocks of 8 x 8 pixels
within their noise; build/bench/cycles-SCENE.png shows them side by side, ours on the left.

SEEDS (at least 3) is taken from the environment. Last line: "bench-cycles: worst X", X the largest ratio of noise for
time, ours over Cycles': smaller is better for us. Ends with 1 when the pictures disagree.
SPDX-License-Identifier: MIT
"""

import math
import os
import shutil
import statistics
import subprocess
import sys

import cpu
import documents
import exr
import spread

SEEDS = int(os.environ.get("SEEDS", "0"))
SIDE, BLOCK, BOUNCES = 128, 8, 9
TOOL = os.path.join(documents.ROOT, os.environ.get("BIN", "build/bin"), "tool_local")
# name, document, samples per pixel, seeds
SCENES = (("cornell", documents.cornell, 64, 8), ("spheres", documents.spheres, 64, 16),
          ("terrain", documents.terrain, 128, 8))


class Cycles:
    """Blender with a document loaded, rendering on demand."""

    def __init__(self, document):
        script = os.path.join(documents.ROOT, "bench", "cycles_scene.py")
        self.process = subprocess.Popen(
            ["blender", "-b", "--factory-startup", "-noaudio", "-P", script, "--", document],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.answer("ready")

    def answer(self, word):
        said = []
        for line in self.process.stdout:
            if line.startswith(word):
                return line.split()[1:]
            said.append(line)
        sys.exit("bench-cycles: Blender has ended:\n" + "".join(said[-20:]))

    def render(self, seed, spp, image):
        self.process.stdin.write(f"{seed} {spp} {image}\n")
        self.process.stdin.flush()
        return float(self.answer("rendered")[0])

    def end(self):
        self.process.stdin.close()
        self.process.stdout.read()
        self.process.wait()


class Side:
    """What one renderer did on a scene."""

    def __init__(self):
        self.seconds, self.images = [], []

    def add(self, seconds, image):
        self.seconds.append(seconds)
        self.images.append(exr.read(image)[2])

    def measure(self):
        self.relmse, self.relmse_error = spread.relmse(self.images)
        self.cpu = statistics.median(self.seconds)
        self.cost = self.relmse * self.cpu


def prepared(make):
    document = make()
    document["settings"]["max_bounces"] = BOUNCES
    # A lamp of Cycles reflects nothing.
    document["materials"]["lamp"] = {"type": "diffuse", "albedo": 0}
    for shape in document["shapes"]:
        if "emission" in shape:
            shape["material"] = "lamp"
    return document


def render(name, document, spp, seeds):
    ours, theirs = Side(), Side()
    image = os.path.join(documents.FOLDER, f"cycles-{name}.exr")
    cycles = Cycles(documents.written(documents.sized(document, SIDE, spp), "cycles-" + name))
    cycles.render(0, 1, image)  # the first render makes what later ones find
    for seed in range(1, seeds + 1):
        few, more = (documents.written(documents.sized(document, SIDE, n, seed), f"cycles-{name}-{n}")
                     for n in (1, spp))
        ours.add(cpu.of_samples(TOOL, few, more, image)[0], image)
        fixed = cycles.render(seed, 1, image)
        theirs.add(cycles.render(seed, spp, image) - fixed, image)
    cycles.end()
    return ours, theirs


def compare_pictures(ours, theirs):
    """Whether they agree; prints by how much."""
    found = spread.differences(ours.images, theirs.images, SIDE, BLOCK)
    a, b = (statistics.mean(column) for column in list(zip(*found))[:2])
    scores = sorted((abs(x - y) / s for x, y, s in found if s > 0))
    rms = math.sqrt(statistics.mean(z * z for z in scores))
    relative = math.sqrt(statistics.mean((x - y) ** 2 for x, y, _ in found)) / b
    # Student's t with so many degrees of freedom has this RMS; 1.3 times is beyond chance for 256 blocks.
    freedom = 2 * (len(ours.images) - 1)
    limit = 1.3 * math.sqrt(freedom / (freedom - 2))
    print(f"  pictures: means {a:.5f} and {b:.5f} ({a / b - 1:+.3%}); blocks differ by {relative:.2%} of the mean (RMS),"
          f" by {rms:.2f} standard errors (RMS, at most {limit:.2f}; largest {scores[-1]:.1f})")
    return abs(a / b - 1) < 0.01 and rms < limit


def show(name, ours, theirs):
    def rows(side):
        image = list(zip(*spread.mean(side.images)))
        return [image[y * SIDE:(y + 1) * SIDE] for y in range(SIDE)]
    exr.write_png(os.path.join(documents.FOLDER, f"cycles-{name}.png"),
                  [left + [(1, 1, 1)] * 4 + right for left, right in zip(rows(ours), rows(theirs))])


def main():
    if not shutil.which("blender"):
        print("bench-cycles: left out: Blender is not installed")
        return 0
    worst, agree = 0, True
    for name, make, spp, seeds in SCENES:
        seeds = SEEDS or seeds
        ours, theirs = render(name, prepared(make), spp, seeds)
        for who, side in (("smalti", ours), ("Cycles", theirs)):
            side.measure()
            speed = SIDE * SIDE * (spp - 1) / side.cpu / 1000
            print(f"{name:8} {who}  {spp} spp  {side.cpu:6.2f} CPU s  {speed:7.1f} kpaths/CPU s  relMSE {side.relmse:.6f} "
                  f"+- {side.relmse_error / side.relmse:.0%}  x CPU s {side.cost:.6f}", flush=True)
        ratio = ours.cost / theirs.cost
        print(f"{name:8} ours/Cycles: relMSE {ours.relmse / theirs.relmse:.3f}, CPU s {ours.cpu / theirs.cpu:.3f}, "
              f"relMSE x CPU s {ratio:.3f}")
        worst = max(worst, ratio)
        agree = compare_pictures(ours, theirs) and agree
        show(name, ours, theirs)
    if not agree:
        print("bench-cycles: the pictures disagree")
    print(f"bench-cycles: worst {worst:.3f}")
    return 0 if agree else 1


sys.exit(main())
