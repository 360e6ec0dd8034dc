"""bench_examples: what features that a scene does not use cost it: the example scenes, this tree against a former commit.

    make bench-examples [BASE=commit]     default: the commit before the whole surface model

Every document of scenes/ that the former commit can read is rendered by both in turn (former.py); meshes from files are
flat in both, since the former one knew no others. What they execute is counted as well, where there is valgrind: instructions
inside render_tile, of a small image, which no neighbour on the machine can disturb.

ROUNDS, SIDE (the image's shorter one) and SPP are taken from the environment. Last line: "bench-examples: worst ratio X
instructions Y", X the smallest median ratio of samples per CPU second, now over before, Y the largest of instructions.
SPDX-License-Identifier: MIT
"""

import os

import documents
import former
import hot

ROUNDS = int(os.environ.get("ROUNDS", "9"))
SIDE = int(os.environ.get("SIDE", "128"))
SPP = int(os.environ.get("SPP", "64"))
BASE = os.environ.get("BASE") or "86918dd"
COUNTED = {"side": 48, "spp": 31}


def scene(name, document, side, spp):
    return former.Scene(name, documents.flat(document), side, spp, document)


def readable(base):
    """By name: the documents that both can render here."""
    found = {}
    for name in documents.examples():
        document = documents.example(name)
        lacking = documents.lacking(document)
        if lacking:
            print(f"{name}: left out, {lacking} is not there")
            continue
        if base and not former.reads(base, scene(name, document, 8, 0).before[0]):
            print(f"{name}: left out, {BASE} does not know what is in it")
            continue
        found[name] = document
    return found


def count(found, base):
    """Ratios of instructions by name, now over before; prints them."""
    ratios = {}
    for name, document in found.items():
        small = scene(name, document, **COUNTED)
        counts = [hot.instructions(*of) for of in ((base, small.before[1]), (former.TOOL, small.now[1]))]
        if not all(counts):
            print("instructions: left out, valgrind does not work here")
            break
        ratios[name] = counts[1] / counts[0]
        before, now = (n / (small.pixels * (small.spp + 1)) for n in counts)
        print(f"{name:15} {before:9.0f} {now:9.0f}  instructions/path {ratios[name]:6.3f}", flush=True)
    return ratios


def main():
    base = former.build(BASE)
    print(f"before: {BASE}" if base else f"before: left out, there is no commit {BASE} here", flush=True)
    found = readable(base)
    counted = count(found, base) if base else {}
    scenes = [scene(name, document, SIDE, SPP) for name, document in found.items()]
    former.take_turns(scenes, base, ROUNDS)
    medians = former.compare(scenes, base)
    ratio = f"{min(medians.values()):.3f}" if medians else "left-out"
    instructions = f"{max(counted.values()):.3f}" if counted else "left-out"
    print(f"bench-examples: worst ratio {ratio} instructions {instructions}")


main()
