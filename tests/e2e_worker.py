"""The worker's manners: it waits for its coordinator, caches, drains, hands back, and says what is wrong.
SPDX-License-Identifier: MIT"""

import hashlib
import http.server
import os
import threading
import time

import farm

SMALL = farm.scene("cornell-box.json", 64, 64, spp=16)
LONG = farm.scene("cornell-box.json", 256, 256, spp=65536)


def waits_for_its_coordinator(t):
    reference = farm.local_digest(SMALL)
    with farm.Farm() as f:
        f.start_server("--tile", "16", "--checkpoint", "0").stop()
        worker = f.start_worker("--threads", "1", "--log", "debug")
        f.wait_for("the worker to miss its coordinator", lambda: "coordinator_lost" in worker.log())
        f.start_server("--tile", "16", "--checkpoint", "0")
        job = f.submit(SMALL)
        f.wait_for("merged passes", lambda: f.job(job)["tile_passes"]["done"] > 0)
        t.ok("coordinator_back" in worker.log(), "a worker that came before its coordinator finds it")
        f.server.kill()
        f.start_server("--tile", "16", "--checkpoint", "0")
        t.equal(f.done(job)["image"]["digest"], reference, "and delivers to the one that comes after a crash")
        t.ok("delivery_refused" not in worker.log(), "without a result being refused")


def caches_by_hash(t):
    with farm.Farm() as f:
        f.start_server()
        own = os.path.join(f.dir, "own")
        worker = f.start_worker("--threads", "1", "--cache", own)
        digest = f.done(f.submit(SMALL))["image"]["digest"]
        files = [name for name in os.listdir(own) if len(name) == 64]
        t.equal(len(files), 1, "the document lies in the cache, under its hash")
        t.equal(worker.stop(), 0, "the worker stops")
        with open(os.path.join(own, files[0]), "wb") as file:
            file.write(b"damaged")
        for name in os.listdir(own):
            if name.endswith(".stage"):  # else the scene is there, prepared, and the document not needed
                os.unlink(os.path.join(own, name))
        worker = f.start_worker("--threads", "1", "--cache", own)
        t.equal(f.done(f.submit(SMALL))["image"]["digest"], digest, "a damaged file in it changes no pixel")
        t.ok("cache_damaged" in worker.log(), "it is found out")


def drains(t):
    with farm.Farm() as f:
        f.start_server("--tile", "16")
        worker = f.start_worker("--threads", "1", "--name", "box-7")
        job = f.submit(LONG)
        f.wait_for("merged passes", lambda: f.job(job)["tile_passes"]["done"] > 0)
        worker.wanted = False
        t.equal(f.call("PATCH", "/v1/workers/box-7", {"state": "draining"}).status, 200, "a worker can be drained")
        t.equal(worker.wait(), 0, "it exits 0")
        left = f.job(job)
        t.equal((left["workers"], left["leases"]["expired"]), (0, 0), "and holds nothing any more")


def leaves_when_told(t):
    with farm.Farm() as f:
        f.start_server()
        worker = f.start_worker("--threads", "2", "--name", "box-8")
        f.wait_for("the worker to ask for work", lambda: f.get("/v1/workers")["workers"])
        begin = time.monotonic()
        t.equal(worker.stop(), 0, "an idle worker exits 0 on SIGTERM")
        t.ok(time.monotonic() - begin < 2 * farm.SLOWER, "at once, not when its long poll ends")
        worker = f.start_worker("--threads", "1", "--name", "box-8")
        f.done(f.submit(SMALL))
        t.ok(worker.alive(), "the next one of its name is given work")
        job = f.submit(LONG)
        f.wait_for("merged passes", lambda: f.job(job)["tile_passes"]["done"] > 0)
        f.server.kill()
        t.equal(worker.stop(), 0, "it exits 0 without its coordinator, too")


def forgets_a_cancelled_job(t):
    with farm.Farm() as f:
        f.start_server("--tile", "256")
        f.start_worker("--threads", "2")
        job = f.submit(LONG)
        f.wait_for("the job to run", lambda: f.job(job)["state"] == "running")
        f.call("DELETE", f"/v1/jobs/{job}")
        t.equal(f.done(f.submit(SMALL))["state"], "done", "after a job was cancelled the next one is rendered")


def names_a_bad_mesh(t):
    with farm.Farm() as f:
        f.start_server()
        f.start_worker("--threads", "2")
        name = f.upload(b"ply\nformat ascii 1.0\nelement vertex 3\nthis is no property\n")
        document = farm.scene("cornell-box.json", 64, 64, spp=16)
        document["shapes"].append({"type": "mesh", "material": "white", "format": "ply", "asset": name})
        ended = f.finish(f.submit(document))
        reason = (ended["failure"] or {}).get("reason", "")
        t.ok(ended["state"] == "failed" and name in reason and "line 4" in reason,
             "a mesh that cannot be read fails the job, with its name and line", ended)
        t.equal(f.done(f.submit(SMALL))["state"], "done", "and the worker goes on")


def names_a_bad_image(t):
    with farm.Farm() as f:
        f.start_server()
        f.start_worker("--threads", "2")
        cut = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x08\0\0\0\x08\x08\x02"
        name = hashlib.sha256(cut).hexdigest()
        document = farm.scene("cornell-box.json", 64, 64, spp=16)
        document["textures"] = {"wood": {"type": "image", "format": "png", "asset": name}}
        refused = f.call("POST", "/v1/jobs", document)
        t.equal((refused.status, refused.json().get("missing_assets")), (409, [name]), "an image that is not there is asked for")
        f.upload(cut)
        ended = f.finish(f.submit(document))
        reason = (ended["failure"] or {}).get("reason", "")
        t.ok(ended["state"] == "failed" and name in reason and "the file ends too early" in reason,
             "an image that is cut short fails the job, with its name", ended)
        t.equal(f.done(f.submit(SMALL))["state"], "done", "and the worker goes on")


class OtherVersion(http.server.BaseHTTPRequestHandler):
    asked = 0

    def do_POST(self):
        OtherVersion.asked += 1
        self.rfile.read(int(self.headers["Content-Length"]))
        body = b'{"title": "Conflict", "status": 409, "detail": "version: this coordinator is 9.9.9"}'
        self.send_response(409)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


def waits_for_its_version(t):
    other = http.server.ThreadingHTTPServer(("127.0.0.1", 0), OtherVersion)
    threading.Thread(target=other.serve_forever, daemon=True).start()
    with farm.Farm() as f:
        f.url = f"http://127.0.0.1:{other.server_port}"
        worker = f.start_worker("--threads", "1")
        f.wait_for("the refusal in the log", lambda: "version: this coordinator is 9.9.9" in worker.log())
        time.sleep(.5)  # in which a loop that does not wait asks many times
        t.ok(worker.alive() and OtherVersion.asked <= 2, "a worker of another version waits and asks rarely",
             f"asked {OtherVersion.asked} times")
        t.equal(worker.stop(), 0, "until it is stopped")
    other.shutdown()


def refuses_misuse(t):
    with farm.Farm() as f:
        f.url = "http://127.0.0.1:1"
        for flags in (["--threads", "0"], ["--name", "no blanks"], ["--unheard-of"], ["--log", "loud"]):
            t.equal(f.start_worker(*flags).wait(), 2, f"exit status 2: {' '.join(flags)}")
        f.url = "127.0.0.1:1"
        t.equal(f.start_worker().wait(), 2, "exit status 2: an address without http://")


def test(f, t):
    waits_for_its_coordinator(t)
    caches_by_hash(t)
    drains(t)
    leaves_when_told(t)
    forgets_a_cancelled_job(t)
    names_a_bad_mesh(t)
    names_a_bad_image(t)
    waits_for_its_version(t)
    refuses_misuse(t)


farm.main(test)
