"""docs/scene.schema.json agrees with the program.

Every example is valid by the schema, and every document of tests/invalid is not, except for the
faults that no schema can see; those are listed here, so that a new one is a decision.
Needs Debian's python3-jsonschema; without it the checks are skipped.
SPDX-License-Identifier: MIT
"""

import glob
import json
import os
import re
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")

# What takes more than one value, or the bytes before they are values.
BEYOND_A_SCHEMA = {
    "camera-lens-wider-than-focus": "one number against another",
    "camera-look-at-itself": "two points coincide",
    "camera-matrix-mirrored": "geometry of a matrix",
    "camera-matrix-scaled": "geometry of a matrix",
    "camera-matrix-sheared": "geometry of a matrix",
    "camera-up-along-view": "geometry of two directions",
    "cylinder-elliptic": "geometry of a transform",
    "cylinder-ends-coincide": "two points coincide",
    "cylinder-too-long": "distance of two points",
    "cylinder-world-huge": "a point and a transform",
    "cylinder-world-short": "two points and a transform",
    "cylinder-world-thin": "a radius and a transform",
    "disc-ellipse": "geometry of a transform",
    "emission-texture-mask": "a shape against its material",
    "emission-texture-unknown": "a name against names",
    "film-crop-empty": "begin against end",
    "film-crop-outside": "window against film",
    "film-crop-swapped": "begin against end",
    "film-pixels": "width times height",
    "mesh-index-high": "index against the count of vertices",
    "mesh-uvs-count": "a count against the count of vertices",
    "mesh-world-huge": "a point and a transform",
    "net-mesh-file": "the schema is also for documents on disk",
    "net-environment-file": "the schema is also for documents on disk",
    "net-texture-file": "the schema is also for documents on disk",
    "quad-bow-tie": "geometry of corners",
    "quad-concave": "geometry of corners",
    "quad-in-a-line": "geometry of corners",
    "quad-not-planar": "geometry of corners",
    "quad-repeated-corner": "geometry of corners",
    "relief-checker": "a name's texture",
    "relief-of-a-part": "a name's material",
    "relief-srgb": "a name's texture",
    "relief-unknown": "a name against names",
    "shape-material-dangling": "a name against names",
    "shape-material-unknown": "a name against names",
    "light-environment-mirrored": "geometry of a transform",
    "light-environment-moved": "geometry of a transform",
    "light-environment-squeezed": "geometry of a transform",
    "light-environment-two": "a count of some of the lights",
    "material-leaf-sum": "sum of two colours",
    "material-mix-dangling": "a name against names",
    "material-mix-of-itself": "what names lead to",
    "material-mix-in-a-ring": "what names lead to",
    "material-nested-deep": "what names lead to",
    "material-mask-shines": "a shape against its material",
    "material-two-sided-glass": "a name's material",
    "light-spot-angles": "one angle against the other",
    "material-unknown-of-many": "a name against names",
    "material-unknown-of-none": "a name against names",
    "sphere-ellipsoid": "geometry of a transform",
    "sphere-world-huge": "product of steps",
    "sphere-world-tiny": "product of steps",
    "texture-image-exr-srgb": "one key against another",
    "textured-unknown": "a name against names",
    "textured-without-textures": "a name against names",
    "transform-singular-matrix": "geometry of a matrix",
}

count = 0
failed = 0


def ok(cond, text):
    global count, failed
    count += 1
    failed += not cond
    print(("ok" if cond else "not ok"), count, "-", text, flush=True)


def load(path):
    with open(path, encoding="utf-8") as f:
        return json.load(f)


def is_syntax(name):
    with open(os.path.join(ROOT, "tests/invalid", name + ".err"), encoding="utf-8") as f:
        return re.match(r"(input|limit) line \d+, column \d+: ", f.read()) is not None


def main():
    try:
        from jsonschema import Draft202012Validator as Validator
    except ImportError:
        debian = "/usr/bin/python3"  # the library is its, perhaps not this interpreter's
        if os.path.exists(debian) and not os.path.samefile(debian, sys.executable):
            sys.stdout.flush()
            os.execv(debian, [debian, os.path.abspath(__file__)])
        print("1..0 # SKIP python3-jsonschema (4.0 or later) is not installed")
        return 0
    schema = load(os.path.join(ROOT, "docs/scene.schema.json"))
    Validator.check_schema(schema)
    ok(True, "the schema is valid by its own schema")
    validator = Validator(schema)

    examples = sorted(glob.glob(os.path.join(ROOT, "scenes/*.json"))) + [os.path.join(ROOT, "tests/textured.json")]
    ok(len(examples) >= 4, "there are examples")
    for path in examples:
        fault = next(validator.iter_errors(load(path)), None)
        ok(fault is None, "%s is valid by the schema" % os.path.basename(path))
        if fault is not None:
            print("#", list(fault.absolute_path), fault.message[:200])

    names = sorted(
        os.path.basename(p)[:-5] for p in glob.glob(os.path.join(ROOT, "tests/invalid/*.json"))
    )
    ok(set(BEYOND_A_SCHEMA) <= set(names), "the exceptions exist")
    for name in names:
        if is_syntax(name):
            continue
        valid = validator.is_valid(load(os.path.join(ROOT, "tests/invalid", name + ".json")))
        why = BEYOND_A_SCHEMA.get(name)
        if why:
            ok(valid, "%s is beyond the schema: %s" % (name, why))
        else:
            ok(not valid, "%s is refused by the schema, too" % name)
    print("1..%d" % count)
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
