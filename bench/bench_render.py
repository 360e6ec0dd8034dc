"""bench_render: paths per CPU second of whole images, this tree against a former commit, in one run.

    make bench-render [BASE=commit]       default: the commit before the wide hierarchy

The former commit is built from git into build/bench/base-..., with its own Makefile. Both tool_local programs render
the same documents in turn, in one thread, several rounds, in alternating order; CPU is user and system time of the
samples alone (cpu.py), a path is one sample of one pixel, and ratios are formed inside a round. Scenes: the Cornell
box, the Stanford bunny under a uniform sky, an interior of 1.06 million triangles, hills of 1.05 million under a sky
(documents.py). Then where the time goes on the two big ones (hot.py).

ROUNDS and SIDE (of the square image) are taken from the environment. Last line: "bench-render: worst-mesh-ratio X
traversal-share Y%", X the smallest median ratio of the three meshes, Y the smaller share of traversal and
intersection.
SPDX-License-Identifier: MIT
"""

import os
import shutil
import statistics
import subprocess
import sys

import cpu
import documents
import hot

ROUNDS = int(os.environ.get("ROUNDS", "3"))
SIDE = int(os.environ.get("SIDE", "256"))
BASE = os.environ.get("BASE") or "4c4f586"
TOOL = os.path.join(documents.ROOT, os.environ.get("BIN", "build/bin"), "tool_local")
IMAGE = os.path.join(documents.FOLDER, "render.exr")
# name, document, samples per pixel beyond the first, triangles
SCENES = (("cornell", documents.cornell, 24, "36"), ("bunny", documents.bunny, 48, "69 k"),
          ("interior", documents.interior, 12, "1.06 M"), ("terrain", documents.terrain, 64, "1.05 M"))
MESHES = ("bunny", "interior", "terrain")
BIG = ("interior", "terrain")


def git(*argv):
    return subprocess.run(["git", "-C", documents.ROOT, *argv], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, check=False)


def build_base():
    """The former commit's tool_local, or None when there is no such commit here (an archive, a shallow clone)."""
    commit = git("rev-parse", "--verify", "--quiet", BASE + "^{commit}").stdout.decode().strip()
    if not commit:
        return None
    tree = os.path.join(documents.FOLDER, "base-" + commit[:12])
    if not os.path.isdir(tree):
        shutil.rmtree(tree + ".new", ignore_errors=True)
        os.makedirs(tree + ".new")
        subprocess.run(["tar", "-x", "-C", tree + ".new"], input=git("archive", commit).stdout, check=True)
        os.rename(tree + ".new", tree)
    # The make that runs us must not hand its variables to a Makefile of another time.
    plain = {name: value for name, value in os.environ.items()
             if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "BIN")}
    tool = os.path.join("build", "bin", "tool_local")
    made = subprocess.run(["make", "-s", "-C", tree, f"-j{os.cpu_count()}", tool], env=plain, check=False,
                          stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    if made.returncode:
        sys.exit(f"bench-render: {BASE} does not build")
    return os.path.join(tree, tool)


class Scene:
    def __init__(self, name, make, spp, triangles):
        self.name, self.spp, self.triangles = name, spp, triangles
        document = make()
        self.few = documents.written(documents.sized(document, SIDE, 1), name + "-1")
        self.more = documents.written(documents.sized(document, SIDE, 1 + spp), f"{name}-{1 + spp}")
        self.seconds = {}  # by tool: one per round
        self.digests = {}

    def render(self, tool):
        seconds, self.digests[tool] = cpu.of_samples(tool, self.few, self.more, IMAGE)
        self.seconds.setdefault(tool, []).append(seconds)

    def paths_per_second(self, tool):
        return SIDE * SIDE * self.spp / statistics.median(self.seconds[tool])

    def ratios(self, base):
        return [before / now for before, now in zip(self.seconds[base], self.seconds[TOOL])]


def compare(scenes, base):
    """Median ratio by scene; prints the table."""
    print(f"{'scene':9} {'triangles':>9} {'before':>9} {'now':>9}  kpaths/CPU s   ratio  (of {ROUNDS} rounds)")
    medians = {}
    for scene in scenes:
        now = scene.paths_per_second(TOOL) / 1000
        if not base:
            print(f"{scene.name:9} {scene.triangles:>9} {'-':>9} {now:9.1f}")
            continue
        ratios = scene.ratios(base)
        medians[scene.name] = statistics.median(ratios)
        same = "same pixels" if scene.digests[base] == scene.digests[TOOL] else "other pixels"
        print(f"{scene.name:9} {scene.triangles:>9} {scene.paths_per_second(base) / 1000:9.1f} {now:9.1f}"
              f"{medians[scene.name]:22.2f}  ({min(ratios):.2f} to {max(ratios):.2f}), {same}")
    return medians


def profile(scenes):
    """The share of traversal by scene; prints what else there is."""
    found = {}
    for scene in scenes:
        if scene.name not in BIG:
            continue
        measured = hot.shares(TOOL, scene.few, scene.more)
        if not measured:
            print("profile: left out, neither perf nor valgrind works here")
            return found
        shares, how = measured
        found[scene.name] = hot.of_rays(TOOL, shares)
        largest = sorted(shares.items(), key=lambda item: -item[1])[:8]
        print(f"{scene.name}: traversal and intersection {found[scene.name]:.0%} of {how}; "
              + ", ".join(f"{name} {share:.0%}" for name, share in largest))
    return found


def main():
    scenes = [Scene(*scene) for scene in SCENES]
    if not documents.has_bunny():
        print("bunny: the scan is not there, a generated ball of 69 k triangles stands in")
    base = build_base()
    print(f"before: {BASE}" if base else f"before: left out, there is no commit {BASE} here", flush=True)
    for i in range(ROUNDS):
        for scene in scenes:
            for tool in [t for t in (base, TOOL) if t][::(1, -1)[i % 2]]:
                scene.render(tool)
    medians = compare(scenes, base)
    shares = profile(scenes)
    ratio = f"{min(medians[name] for name in MESHES):.2f}" if medians else "left-out"
    share = f"{min(shares.values()):.0%}" if shares else "left-out"
    print(f"bench-render: worst-mesh-ratio {ratio} traversal-share {share}")


main()
