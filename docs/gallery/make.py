#!/usr/bin/env python3
"""The pictures of docs/gallery.md, and that page: `make gallery` (ARGS=NAME... renders these alone, --spp=N for a glance).

pictures.py says what is on each of them: a set, and a few lines of JSON that are put into it. assets.py makes the
images and meshes that some of these lines name. The whole documents are left in build/gallery, where
`build/bin/smalti render` takes them as they are. BIN: where the programs are (default build/bin). Standard library only.
SPDX-License-Identifier: MIT
"""

import html
import json
import os
import subprocess
import sys

import assets
from pictures import INTRODUCTION, SECTIONS, SETS

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
WORK = os.path.join(ROOT, "build", "gallery")
COLUMNS = 3


def put_into(document, lines):
    """By name where there are names, at the end of a list, else in the place of what is there."""
    for key, value in lines.items():
        if key in ("materials", "textures", "settings", "film"):
            document.setdefault(key, {}).update(value)
        elif key in ("shapes", "lights"):
            document[key] = document.get(key, []) + value
        else:
            document[key] = value
    return document


def document_of(picture):
    document = put_into(json.loads(json.dumps(SETS[picture.set])), json.loads("{" + picture.lines + "}"))
    return {"smalti": 1, "title": picture.title, **document}


def render(picture, spp):
    path = os.path.join(WORK, picture.name + ".json")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(document_of(picture), file, indent=1)
    program = os.path.join(ROOT, os.environ.get("BIN", "build/bin"), "smalti")
    command = [program, "render", path, "-o", os.path.join(WORK, picture.name + ".exr"),
               "--png", os.path.join(HERE, picture.name + ".png"), "--quiet"]
    subprocess.run(command + (["--spp", spp] if spp else []), check=True)
    print(picture.name, flush=True)


def cell(picture):
    lines = html.escape((picture.shown or picture.lines).strip(), quote=False)
    return ('<td valign="top"><img src="gallery/%s.png" width="224" alt=""><br><b>%s</b>\n<pre>%s</pre></td>'
            % (picture.name, html.escape(picture.title), lines))


def page():
    out = [INTRODUCTION.strip()]
    for section in SECTIONS:
        out.append("## %s\n\n%s" % (section.title, section.text))
        rows = [section.pictures[i:i + COLUMNS] for i in range(0, len(section.pictures), COLUMNS)]
        out.append("<table>\n" + "\n".join("<tr>\n%s\n</tr>" % "\n".join(map(cell, row)) for row in rows) + "\n</table>")
    return "\n\n".join(out) + "\n"


def main():
    names = [a for a in sys.argv[1:] if not a.startswith("-")]
    spp = next((a[6:] for a in sys.argv[1:] if a.startswith("--spp=")), None)
    pictures = [p for section in SECTIONS for p in section.pictures]
    unknown = set(names) - {p.name for p in pictures}
    if unknown:
        sys.exit("make.py: no picture is named " + ", ".join(sorted(unknown)))
    os.makedirs(WORK, exist_ok=True)
    assets.write_all(WORK)
    pictures.sort(key=lambda p: p.name != "camera-panoramic")  # an environment map is made of it
    for picture in pictures:
        if not names or picture.name in names:
            render(picture, spp)
    with open(os.path.join(ROOT, "docs", "gallery.md"), "w", encoding="utf-8") as file:
        file.write(page())


if __name__ == "__main__":
    main()
