"""Targets and scenes at the ends of what there is: an error that cannot be reached, one of 0, no light, nothing but
light, one pixel, images of other sizes. Each has an answer that says what happened.

SPDX-License-Identifier: MIT
"""

import json
import os

import farm

MATTE = {"m": {"type": "diffuse", "albedo": 0.5}}
BALL = {"type": "sphere", "material": "m", "center": [0, 0, 0], "radius": 1}
SKY = {"type": "sky", "radiance": 1}


def document(width, height, shapes=(BALL,), lights=(SKY,), **target):
    return {"smalti": 1, "film": {"width": width, "height": height},
            "camera": {"type": "perspective", "fov_deg": 30, "look_at": {"from": [0, 0, 5], "to": [0, 0, 0]}},
            "materials": MATTE, "shapes": list(shapes), "lights": list(lights), "settings": {"target": target}}


def unreachable(f, t):
    """The cap ends it, and status, EXR and command line say so."""
    job = f.done(f.submit(farm.scene("cornell-box.json", 24, 24, error=1e-5, spp=16)))
    t.ok(job["ended_by"] == "spp" and job["spp"] == 16 and job["error"] > .01 and job["target"]["error"] == 1e-5
         and job["report"]["error"]["estimate"] == job["error"] and job["progress"] == 1,
         "an error out of reach: the cap ends the job, which says what was reached", job)
    job = f.done(f.submit(farm.scene("cornell-box.json", 24, 24, error=1e-5, seconds=.3)))
    t.ok(job["ended_by"] == "seconds" and job["error"] > 1e-5 and job["spp"] == job["target"]["spp"] >= 8,
         "or its seconds do, and say with how many samples", job)
    job = f.done(f.submit(farm.scene("cornell-box.json", 24, 24, error=.5, spp=4096)))
    t.ok(job["ended_by"] == "error" and job["error"] <= .5 and job["spp"] < 4096, "one that is reached ends it", job)
    job = f.job(f.submit(farm.scene("cornell-box.json", 512, 512, spp=65536)))
    t.equal(job["ended_by"], None, "a job under way has not ended")
    f.call("DELETE", f"/v1/jobs/{job['id']}")


def on_the_terminal(f, t):
    scene, out = os.path.join(f.dir, "box.json"), os.path.join(f.dir, "box.exr")
    with open(scene, "w", encoding="utf-8") as file:
        json.dump(farm.scene("cornell-box.json", 24, 24, error=1e-5, spp=16), file)
    done = f.run("render", scene, "-o", out, "--quiet", "--json")
    told = json.loads(done.stdout)
    t.ok(done.returncode == 0 and told["ended_by"] == "spp"
         and done.stderr == f"smalti: error {told['error']:.3g} reached, 1e-05 was asked for: ended by its spp, "
                            "with 16 samples per pixel\n",
         "render says what was reached and what ended it", done.stderr)
    for command in "render", "plan":
        done = f.run(command, scene, "--error", "0")
        t.ok(done.returncode == 2 and "--error: expected" in done.stderr, f"{command}: an error of 0, status 2", done.stderr)
    reply = f.call("POST", "/v1/jobs", document(8, 8, error=0))
    t.ok(reply.status == 422 and "/settings/target/error" in json.dumps(reply.json()), "a job for an error of 0 is refused, with the place",
         reply.status, reply.json())
    return out


def light(f, t):
    """None is black, and believed where there is nothing, or at its cap; nothing but light has no noise."""
    black = f.done(f.submit(document(16, 16, lights=(), error=.1, spp=64)))
    t.ok(black["error"] == 0 and black["ended_by"] == "spp" and black["spp"] == 64 and black["report"]["mean_luminance"] == 0
         and black["report"]["pixels"]["unknown"] > .1, "no light: black may be chance where there is a surface, up to the cap", black)
    empty = f.done(f.submit(document(16, 16, (), (), error=.1, spp=64)))
    t.ok(empty["error"] == 0 and empty["ended_by"] == "error" and empty["spp"] == 8 and empty["report"]["pixels"]["trusted"] == 1,
         "nothing at all: black at once", empty)
    sky = f.done(f.submit(document(16, 16, (), error=1e-5, spp=64)))
    t.ok(sky["error"] == 0 and sky["ended_by"] == "error" and sky["spp"] == 8 and sky["report"]["pixels"]["trusted"] == 1
         and abs(sky["report"]["mean_luminance"] - 1) < 1e-6, "nothing but sky: exact at once", sky)
    lamp = f.done(f.submit(document(16, 16, [dict(BALL, radius=4.9, emission=2)], (), error=1e-5, spp=64)))
    t.ok(lamp["error"] == 0 and lamp["ended_by"] == "error" and lamp["spp"] == 8 and lamp["report"]["pixels"]["trusted"] == 1
         and abs(lamp["report"]["mean_luminance"] - 2) < 1e-6, "nothing but a lamp: likewise", lamp)


def one_pixel(f, t):
    one = document(1, 1, error=.01, spp=65536)
    a = f.done(f.submit(one))
    t.ok(a["ended_by"] == "error" and a["error"] <= .01 and 256 <= a["spp"] < 65536 and a["tiles"] == 1,
         "one pixel: it ends by its error, when it has 256 effective samples", a)
    b = f.done(f.submit(dict(one, settings={"target": {"spp": a["spp"]}})))
    t.equal(a["image"]["digest"], b["image"]["digest"], "and has the bytes of as many samples")
    return a["id"]


def other_sizes(f, t, job, image):
    small = os.path.join(f.dir, "one.exr")
    env = dict(os.environ, SMALTI_SERVER=f.url)
    t.equal(f.run("fetch", job, "-o", small, env=env).returncode, 0, "fetch: the image of one pixel")
    for a, b, what in (image, small, "24 x 24 and 1 x 1"), (small, image, "1 x 1 and 24 x 24"):
        done = f.run("diff", a, b)
        t.ok(done.returncode == 3 and done.stderr == f"smalti: sizes differ: {what}\n", "diff: a reference of another size", done.stderr)


def test(f, t):
    f.start_server()
    f.start_worker("--threads", "2")
    unreachable(f, t)
    image = on_the_terminal(f, t)
    light(f, t)
    other_sizes(f, t, one_pixel(f, t), image)


farm.main(test)
