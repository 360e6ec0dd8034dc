"""bench_render: paths per CPU second of whole images, this tree against a former commit, in one run.

    make bench-render [BASE=commit]       default: the commit before the wide hierarchy

The same documents are rendered by both in turn (former.py): the Cornell box, the Stanford bunny under a uniform sky, an
interior of 1.06 million triangles, hills of 1.05 million under a sky (documents.py). Then where the time goes on the
two big ones (hot.py).

ROUNDS and SIDE (of the square image) are taken from the environment. Last line: "bench-render: worst-mesh-ratio X
traversal-share Y%", X the smallest median ratio of the three meshes, Y the smaller share of traversal and
intersection.
SPDX-License-Identifier: MIT
"""

import os

import documents
import former
import hot

ROUNDS = int(os.environ.get("ROUNDS", "3"))
SIDE = int(os.environ.get("SIDE", "256"))
BASE = os.environ.get("BASE") or "4c4f586"
# name, document, samples per pixel beyond the first
SCENES = (("cornell", documents.cornell, 24), ("bunny", documents.bunny, 48),
          ("interior", documents.interior, 12), ("terrain", documents.terrain, 64))
MESHES = ("bunny", "interior", "terrain")
BIG = ("interior", "terrain")


def profile(scenes):
    """The share of traversal by scene; prints what else there is."""
    found = {}
    for scene in scenes:
        if scene.name not in BIG:
            continue
        measured = hot.shares(former.TOOL, scene.few, scene.more)
        if not measured:
            print("profile: left out, neither perf nor valgrind works here")
            return found
        shares, how = measured
        found[scene.name] = hot.of_rays(former.TOOL, shares)
        largest = sorted(shares.items(), key=lambda item: -item[1])[:8]
        print(f"{scene.name}: traversal and intersection {found[scene.name]:.0%} of {how}; "
              + ", ".join(f"{name} {share:.0%}" for name, share in largest))
    return found


def main():
    scenes = [former.Scene(name, make(), SIDE, spp) for name, make, spp in SCENES]
    if not documents.has_bunny():
        print("bunny: the scan is not there, a generated ball of 69 k triangles stands in")
    base = former.build(BASE)
    print(f"before: {BASE}" if base else f"before: left out, there is no commit {BASE} here", flush=True)
    former.take_turns(scenes, base, ROUNDS)
    medians = former.compare(scenes, base)
    shares = profile(scenes)
    ratio = f"{min(medians[name] for name in MESHES):.2f}" if medians else "left-out"
    share = f"{min(shares.values()):.0%}" if shares else "left-out"
    print(f"bench-render: worst-mesh-ratio {ratio} traversal-share {share}")


main()
