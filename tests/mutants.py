"""mutants: are the tests able to fail? Bugs are planted one at a time, and the unit tests must find each.

    make mutants [ARGS="cosine 'back shines'"]     only those with such words in their names

Each bug of mutants_list.py is edited into a copy of the tree (build/mutants, built with its own Makefile), and unit
tests run until a check fails: first those named beside the bug, then all that look at the core, both as `make check`
runs them ("quick"); then those named with TEST_LONG=1 ("long"), as `make check-long` does. A check that fails without
the bug proves nothing, so every test that has found one must pass on the clean copy. The golden digests are not asked: they
would see any change of a pixel, right or wrong.

The gate: all are caught, 80 % of them by the quick tier. A run that passes rewrites the table in docs/accuracy.md, or the
rows of the bugs that were asked for.
SPDX-License-Identifier: MIT
"""

import os
import re
import shutil
import subprocess
import sys
import threading
import time

from mutants_list import MUTANTS

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
TREE = os.path.join(ROOT, "build", "mutants")
PAGE = os.path.join(ROOT, "docs", "accuracy.md")
BEGIN, END = "<!-- mutants: written by make mutants -->\n", "<!-- end of mutants -->\n"
LEFT_OUT = {".git", "build", "demo", "node_modules", "__pycache__"}
CORE = ("canary", "tile", "film", "fmath", "sobol", "warp", "bsdf", "surface", "cylinder", "watertight", "bits", "bvh",
        "plates", "lobes", "roulette", "light", "metal", "scatter", "materials", "energy", "truth", "truth_lights",
        "path", "qmc")  # the cheapest first
LIMIT_S = {"quick": 300, "long": 1800}  # for one test; a bug by which it does not end is caught, too
LEAST_QUICK = 0.8
# The make that runs us must not hand its variables to the copy's.
PLAIN = {name: value for name, value in os.environ.items()
         if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "TEST_LONG", "BIN")}


def read(path):
    with open(path, encoding="utf-8") as f:
        return f.read()


def write(path, text):
    """Whole or not at all."""
    with open(path + ".new", "w", encoding="utf-8") as f:
        f.write(text)
    os.replace(path + ".new", path)


def copy_tree():
    """Only what has changed is copied, so that only that is built again."""
    wanted = set()
    for folder, folders, files in os.walk(ROOT):
        folders[:] = [name for name in folders if name not in LEFT_OUT]
        wanted |= {os.path.relpath(os.path.join(folder, name), ROOT) for name in files}
    for folder, folders, files in os.walk(TREE):
        folders[:] = [name for name in folders if name not in LEFT_OUT]
        for name in files:
            if os.path.relpath(os.path.join(folder, name), TREE) not in wanted:
                os.remove(os.path.join(folder, name))
    for name in wanted:
        source, copy = os.path.join(ROOT, name), os.path.join(TREE, name)
        with open(source, "rb") as f:
            data = f.read()
        if os.path.isfile(copy):
            with open(copy, "rb") as f:
                if f.read() == data:
                    continue
        os.makedirs(os.path.dirname(copy), exist_ok=True)
        shutil.copy(source, copy)


def misfits():
    """Edits that do not apply, said all at once."""
    for name, edits, _ in MUTANTS:
        for file, old, new in edits:
            found = read(os.path.join(ROOT, file)).count(old)
            if found != 1 or old == new:
                yield f"{name}: {file} has {found} times, not once: {old}"


def make(tests):
    """What the compiler says, if it refuses."""
    targets = [f"build/bin/test_{test}" for test in tests]
    made = subprocess.run(["make", "-s", "-C", TREE, f"-j{os.environ.get('J') or os.cpu_count()}", *targets],
                          env=PLAIN, check=False, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE)
    return made.stderr.decode() if made.returncode else ""


def first_failure(test, tier):
    """Text of the first check that fails, or None. The test is ended as soon as it has failed."""
    env = dict(PLAIN, TEST_LONG="1") if tier == "long" else PLAIN
    run = subprocess.Popen([f"build/bin/test_{test}"], cwd=TREE, env=env, stdin=subprocess.DEVNULL,
                           stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, errors="replace")
    clock = threading.Timer(LIMIT_S[tier], run.kill)
    clock.start()
    with run:
        failed = filter(None, (re.match(r"not ok \d+ - (.*)", line) for line in run.stdout))
        first = next(failed, None)
        if first:
            run.kill()
    clock.cancel()
    if first:
        return first.group(1)
    return f"(ends with status {run.returncode})" if run.returncode else None


def trials(tests):
    """(test, tier), in order."""
    yield from ((test, "quick") for test in tests)
    yield from ((test, "quick") for test in CORE if test not in tests)
    yield from ((test, "long") for test in tests)


def hunt(edits, tests):
    """(test, tier, check) that finds the bug, or None."""
    for file, old, new in edits:
        path = os.path.join(TREE, file)
        write(path, read(path).replace(old, new))
    built = set()
    try:
        for test, tier in trials(tests):
            if test not in built:
                said = make([test])
                if said:
                    sys.exit(f"mutants: the bug does not compile:\n{said}")
                built.add(test)
            check = first_failure(test, tier)
            if check:
                return test, tier, check
        return None
    finally:
        for file, _, _ in edits:
            write(os.path.join(TREE, file), read(os.path.join(ROOT, file)))


def row(name, found):
    if not found:
        return f"| {name} | **not found** | | |\n"
    test, tier, check = found
    said = re.sub(r" \([^()]*\)$", "", check).replace("|", "\\|")
    return f"| {name} | `tests/test_{test}.c` | {tier} | {said} |\n"


def rewrite(found):
    """The page's table: rows of bugs that were not asked for this time stay as they are."""
    before, rest = read(PAGE).split(BEGIN)
    old, after = rest.split(END)
    kept = {line.split(" | ")[0][2:]: line + "\n" for line in old.split("\n") if line.startswith("| ")}
    rows = [row(name, found[name]) if name in found else kept.get(name, row(name, None)) for name, _, _ in MUTANTS]
    quick = sum("| quick |" in line for line in rows)
    caught = quick + sum("| long |" in line for line in rows)
    head = (f"{caught} of {len(rows)} planted bugs are found, {quick} of them by the quick tier.\n\n"
            "| bug | found by | tier | the check that fails |\n| --- | --- | --- | --- |\n")
    write(PAGE, before + BEGIN + head + "".join(rows) + END + after)
    return caught == len(rows) and quick >= LEAST_QUICK * len(rows)


def main():
    words = sys.argv[1:]
    chosen = [m for m in MUTANTS if not words or any(w in m[0] for w in words)]
    wrong = list(misfits())
    if wrong or not chosen:
        sys.exit("mutants: " + ("\n".join(wrong) or "no bug has such a name"))
    copy_tree()
    said = make(sorted({test for _, _, tests in chosen for test in tests}))
    if said:
        sys.exit(f"mutants: the clean copy does not compile:\n{said}")
    found = {}
    for name, edits, tests in chosen:
        begin = time.monotonic()
        found[name] = hunt(edits, tests)
        print(row(name, found[name]).strip(), f"{time.monotonic() - begin:.0f} s", flush=True)
    used = sorted({(test, tier) for test, tier, _ in filter(None, found.values())})
    make({test for test, _ in used})
    sick = [(test, tier, check) for test, tier in used if (check := first_failure(test, tier))]
    for test, tier, check in sick:
        print(f"test_{test} ({tier}) fails without any bug: {check}")
    caught, quick = (sum(bool(f) and f[1] in tiers for f in found.values())
                     for tiers in (("quick", "long"), ("quick",)))
    print(f"mutants: {caught} of {len(found)} caught, {quick} by the quick tier")
    return 0 if not sick and caught == len(found) and rewrite(found) else 1


sys.exit(main())
