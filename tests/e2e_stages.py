"""One copy of a scene: a worker prepares it, those beside it and after it map it, and the pixels are the same.
SPDX-License-Identifier: MIT"""

import os
import re

import farm


def mesh(side):
    """Something to fetch; many triangles, so that preparing takes a moment."""
    lines = [f"v {x / side - 0.5} {0.05 * ((x * 7 + z * 3) % 11)} {-z / side - 0.5}" for z in range(side) for x in range(side)]
    for z in range(side - 1):
        for x in range(side - 1):
            at = z * side + x + 1
            lines += [f"f {at} {at + 1} {at + side}", f"f {at + 1} {at + side + 1} {at + side}"]
    return "\n".join(lines).encode()


def document(f, spp=16, side=150):
    scene = farm.scene("cornell-box.json", 64, 64, spp=spp)
    scene["shapes"].append({"type": "mesh", "material": "white", "format": "obj", "asset": f.upload(mesh(side))})
    return scene


def how(worker):
    return re.findall(r"scene_ready .*how=(\w+)", worker.log())


def ready(f, worker, count=1):
    f.wait_for("the scene to be ready", lambda: len(how(worker)) == count)
    return how(worker)[-1]


def stage_files(f, draft=False):
    """Of prepared scenes, or of those that are being prepared."""
    names = os.listdir(os.path.join(f.dir, "cache"))
    return [os.path.join(f.dir, "cache", name) for name in names
            if name.endswith(".stage") and name.startswith(".tmp-") == draft]


def drafts(f):
    return stage_files(f, True)


def one_prepares_for_all(f, t):
    f.start_server("--tile", "8", "--lease-ttl", "3")
    workers = [f.start_worker("--threads", "1") for _ in range(3)]
    f.wait_for("all workers", lambda: len(f.get("/v1/workers")["workers"]) == 3)
    job = f.submit(document(f, 4096))
    ways = sorted(ready(f, worker) for worker in workers)
    t.equal(ways, ["mapped", "mapped", "prepared"], "of three workers that start together one prepares, two map")
    t.equal(len(stage_files(f)), 1, "there is one file")
    f.call("DELETE", f"/v1/jobs/{job}")
    f.finish(job)
    for worker in workers:
        worker.stop()


def a_restart_maps(f, t):
    worker = f.start_worker("--threads", "1")
    first = f.done(f.submit(document(f)))["image"]["digest"]
    t.equal(ready(f, worker), "prepared", "another document is another scene")
    worker.stop()
    worker = f.start_worker("--threads", "1")
    t.equal(f.done(f.submit(document(f)))["image"]["digest"], first, "a worker that starts later gives the same pixels")
    t.equal(ready(f, worker), "mapped", "from the scene that is there")
    worker.stop()
    worker = f.start_worker("--threads", "1", "--cache-bytes", "0")
    t.equal(f.done(f.submit(document(f)))["image"]["digest"], first, "as does one without a cache")
    t.equal(ready(f, worker), "private", "which prepares it for itself")
    worker.stop()
    return first


def damage_costs_time_only(f, t, digest):
    for path in stage_files(f):
        with open(path, "r+b") as file:
            file.seek(os.path.getsize(path) // 2)
            byte = file.read(1)
            file.seek(-1, os.SEEK_CUR)
            file.write(bytes([byte[0] ^ 16]))
    worker = f.start_worker("--threads", "1")
    t.equal(f.done(f.submit(document(f)))["image"]["digest"], digest, "one flipped bit in the file changes no pixel")
    t.equal(ready(f, worker), "prepared", "the scene is prepared again")
    t.ok("cache_damaged" in worker.log(), "and the log says why")
    for path in stage_files(f):
        os.unlink(path)
    t.equal(f.done(f.submit(document(f)))["image"]["digest"], digest, "a file that is deleted stays mapped")
    t.equal(how(worker), ["prepared"], "the worker needs no other")
    worker.stop()


def killed_while_preparing(f, t):
    """kill -9 at some moment between the beginning and the end; when it was too late, once more with another document."""
    for spp in range(16, 32):
        worker = f.start_worker("--threads", "1")
        job = f.submit(document(f, spp, 250))
        f.wait_for("the worker to begin", lambda: drafts(f) or how(worker))
        worker.kill()
        if drafts(f):
            break
        worker = f.start_worker("--threads", "1")
        f.done(job)
        worker.stop()
    t.ok(drafts(f), "a worker is killed while it prepares")
    worker = f.start_worker("--threads", "1")
    digest = f.done(job)["image"]["digest"]
    t.equal(ready(f, worker), "prepared", "the next one does it again")
    t.equal(drafts(f), [], "and nothing is left of the dead one")
    worker.stop()
    worker = f.start_worker("--threads", "1", "--cache-bytes", "0")
    t.equal(f.done(f.submit(document(f, spp, 250)))["image"]["digest"], digest,
            "its pixels are those of a worker without a cache")
    worker.stop()


def test(f, t):
    one_prepares_for_all(f, t)
    digest = a_restart_maps(f, t)
    damage_costs_time_only(f, t, digest)
    killed_while_preparing(f, t)


farm.main(test)
