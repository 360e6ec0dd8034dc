"""hot.py - where a render spends its time: the share of rays meeting the scene (traversal and intersection).

    shares(tool, few, more)     {function: share of the samples' time}, how it was measured; None where neither perf nor
                                valgrind works
    of_rays(tool, shares)       the share of what common/trace/bvh*.c compiles to
    instructions(tool, document)    executed inside render_tile; None where valgrind does not work

By perf, sampling CPU time; the profile of the document `few` is taken away from that of `more`, so that reading and
preparing do not count. Else by valgrind's callgrind, which counts instructions, not time, inside render_tile, on the
document `few`. A function means a function of the machine code, with what the compiler has inlined into it: the tests
of triangles and boxes count for the traversal that calls them, the sampler for whoever draws from it.
SPDX-License-Identifier: MIT
"""

import collections
import os
import re
import shutil
import subprocess
import tempfile


def _quiet(*argv):
    return subprocess.run(argv, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                          check=False, text=True)


def _by_perf(tool, document, folder):
    data = os.path.join(folder, "perf.data")
    recorded = _quiet("perf", "record", "-q", "-e", "cpu-clock:u", "-c", "500000", "-o", data, "--", tool, document,
                      os.path.join(folder, "image.exr"))
    listed = _quiet("perf", "script", "-i", data, "-F", "ip,sym")
    if recorded.returncode or listed.returncode:
        return None
    return collections.Counter(line.split(None, 1)[1].strip() for line in listed.stdout.splitlines() if line.strip())


def _by_callgrind(tool, document, folder):
    data = os.path.join(folder, "callgrind.out")
    counted = _quiet("valgrind", "--tool=callgrind", "--toggle-collect=render_tile", f"--callgrind-out-file={data}",
                     tool, document, os.path.join(folder, "image.exr"))
    listed = _quiet("callgrind_annotate", "--threshold=100", data)
    if counted.returncode or listed.returncode:
        return None
    counts = collections.Counter()
    for line in listed.stdout.splitlines():
        found = re.match(r"\s*([\d,]+) \([^)]*\)\s+\S*?:(\S+)", line)
        if found:
            counts[found[2]] += int(found[1].replace(",", ""))
    return counts


def instructions(tool, document):
    if not shutil.which("valgrind"):
        return None
    with tempfile.TemporaryDirectory() as folder:
        counts = _by_callgrind(tool, document, folder)
    return sum(counts.values()) if counts else None


def shares(tool, few, more):
    with tempfile.TemporaryDirectory() as folder:
        fixed = whole = None
        if shutil.which("perf"):
            fixed, whole = _by_perf(tool, few, folder), _by_perf(tool, more, folder)
        how = "time, by perf"
        if not fixed or not whole:
            if not shutil.which("valgrind"):
                return None
            fixed, whole = {}, _by_callgrind(tool, few, folder)
            how = "instructions, by callgrind"
        if not whole:
            return None
    # What the first sample has half of is preparing: its difference would be noise.
    rest = {name: count - fixed.get(name, 0) for name, count in whole.items() if count > 2 * fixed.get(name, 0)}
    total = sum(rest.values())
    return {name: count / total for name, count in rest.items()}, how


def _of_traversal(tool):
    """Names of the functions that come from common/trace/bvh*.c. readelf lists the local ones of a source after its
    name; a name that another source has as well is not counted."""
    ours, others, source = set(), set(), ""
    for line in _quiet("readelf", "-sW", tool).stdout.splitlines():
        fields = line.split()
        if len(fields) != 8:
            continue
        kind, binding, name = fields[3], fields[4], fields[7]
        if kind == "FILE":
            source = name
        if kind == "FUNC":
            from_bvh = name.startswith("bvh_") if binding == "GLOBAL" else os.path.basename(source).startswith("bvh")
            (ours if from_bvh else others).add(name)
    return ours - others


def of_rays(tool, found):
    traversal = _of_traversal(tool)
    return sum(share for name, share in found.items() if name in traversal)
