"""former.py - tool_local of this tree beside that of a former commit: the same documents, in turn, in one run.

    TOOL                       this tree's program
    build(commit)              the former one's: built from git into build/bench/base-..., with its own Makefile. None
                               where there is no such commit (an archive, a shallow clone)
    reads(tool, document)      whether that commit knows what is in the document
    Scene(name, document, side, spp, before)    renders of it; spp: samples per pixel beyond the first; before: what the
                               former one gets, when that is another document
    take_turns(scenes, base, rounds)    renders each by both, in alternating order. base: None for TOOL alone
    compare(scenes, base)               prints a table; {name: median ratio of CPU seconds, before over now}

One thread; CPU is user and system time of the samples alone (cpu.py), a path is one sample of one pixel, and ratios
are formed inside a round.
SPDX-License-Identifier: MIT
"""

import os
import shutil
import statistics
import subprocess
import sys

import cpu
import documents

TOOL = os.path.join(documents.ROOT, os.environ.get("BIN", "build/bin"), "tool_local")
IMAGE = os.path.join(documents.FOLDER, "render.exr")
UNREAD = 3  # tool_local's exit status when it refuses a document


def git(*argv):
    return subprocess.run(["git", "-C", documents.ROOT, *argv], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, check=False)


def build(base):
    commit = git("rev-parse", "--verify", "--quiet", base + "^{commit}").stdout.decode().strip()
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
        sys.exit(f"{base} does not build")
    return os.path.join(tree, tool)


def reads(tool, document):
    done = subprocess.run([tool, document, IMAGE], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL, check=False)
    return done.returncode != UNREAD


def _pair(name, document, side, spp):
    return tuple(documents.written(documents.sized(document, side, n), f"{name}-{n}") for n in (1, 1 + spp))


class Scene:
    def __init__(self, name, document, side, spp, before=None):
        self.name, self.spp = name, spp
        film = documents.sized(document, side, 1)["film"]
        self.pixels = film["width"] * film["height"]
        self.few, self.more = self.now = _pair(name, document, side, spp)
        self.before = _pair(name + "-before", before, side, spp) if before else self.now
        self.seconds = {}  # by tool: one per round
        self.digests = {}

    def render(self, tool):
        few, more = self.now if tool == TOOL else self.before
        seconds, self.digests[tool] = cpu.of_samples(tool, few, more, IMAGE)
        self.seconds.setdefault(tool, []).append(seconds)

    def paths_per_second(self, tool):
        return self.pixels * self.spp / statistics.median(self.seconds[tool])

    def ratios(self, base):
        return [before / now for before, now in zip(self.seconds[base], self.seconds[TOOL])]


def take_turns(scenes, base, rounds):
    for i in range(rounds):
        for scene in scenes:
            for tool in [t for t in (base, TOOL) if t][::(1, -1)[i % 2]]:
                scene.render(tool)


def compare(scenes, base):
    rounds = len(scenes[0].seconds[TOOL])
    print(f"{'scene':15} {'before':>9} {'now':>9}  kpaths/CPU s   ratio  (of {rounds} rounds)")
    medians = {}
    for scene in scenes:
        now = scene.paths_per_second(TOOL) / 1000
        if not base:
            print(f"{scene.name:15} {'-':>9} {now:9.1f}")
            continue
        ratios = scene.ratios(base)
        medians[scene.name] = statistics.median(ratios)
        same = "same pixels" if scene.digests[base] == scene.digests[TOOL] else "other pixels"
        print(f"{scene.name:15} {scene.paths_per_second(base) / 1000:9.1f} {now:9.1f}"
              f"{medians[scene.name]:23.3f}  ({min(ratios):.3f} to {max(ratios):.3f}), {same}")
    return medians
