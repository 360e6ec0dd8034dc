#!/usr/bin/env python3
"""The worker's manners: it waits for its coordinator, caches, drains, hands back, and says what is wrong."""
import hashlib
import http.server
import json
import sys
import threading
import time

from farm import Farm, Tap, scene, tool_local

tap = Tap()
SMALL = scene("cornell-box.json", width=64, height=64, spp=16)
LONG = scene("cornell-box.json", width=256, height=256, spp=65536)


def logs(farm):
    return "".join(log.read_text(errors="replace") for log in sorted(farm.folder.glob("*-worker.log")))


def waits_for_its_coordinator(reference):
    with Farm() as farm:
        farm.terminate_coordinator(10)
        worker = farm.worker("--threads", "1")
        farm.wait_for(lambda: "coordinator_lost" in logs(farm), 10, "the worker misses its coordinator")
        farm.start_coordinator()
        done = farm.wait_job(farm.submit(SMALL), "done", 60)
        tap.ok(done["image"]["digest"] == reference, "a worker that came before its coordinator renders")
        tap.ok(worker.poll() is None and "coordinator_back" in logs(farm), "and says that it is there")


def keeps_what_it_has_rendered(reference):
    """The coordinator goes away while passes are rendered: they are delivered when it is back."""
    with Farm(["--tile", "16", "--checkpoint", "0"]) as farm:
        farm.worker("--threads", "1", "--log", "debug")
        job = farm.submit(SMALL)
        farm.wait_for(lambda: farm.job(job)["tile_passes"]["done"] > 0, 30, "passes are merged")
        farm.terminate_coordinator(10)
        delivered = logs(farm).count(" delivered ")
        farm.start_coordinator()
        done = farm.wait_job(job, "done", 60)
        tap.ok(done["image"]["digest"] == reference, f"gone after {delivered} deliveries: the same image")
        tap.ok("delivery_refused" not in logs(farm), "and no result was refused")


def caches_by_hash():
    with Farm() as farm:
        flags = ["--threads", "1", "--cache", farm.folder / "own"]
        first = farm.worker(*flags)
        digest = farm.wait_job(farm.submit(SMALL), "done", 60)["image"]["digest"]
        name = hashlib.sha256(SMALL.encode()).hexdigest()
        tap.ok((farm.folder / "own" / name).read_bytes() == SMALL.encode(), "the document lies in the cache")
        farm.terminate(first, 10)
        (farm.folder / "own" / name).write_bytes(b"damaged")
        farm.worker(*flags)
        again = farm.wait_job(farm.submit(SMALL), "done", 60)
        tap.ok(again["image"]["digest"] == digest and "cache_damaged" in logs(farm),
               "a damaged file in it is found out and fetched again")


def drains():
    with Farm(["--tile", "16"]) as farm:
        worker = farm.worker("--threads", "1", "--name", "box-7")
        job = farm.submit(LONG)
        farm.wait_for(lambda: farm.job(job)["tile_passes"]["done"] > 0, 30, "passes are merged")
        farm.must("PATCH", "/v1/workers/box-7", body=b'{"state": "draining"}')
        tap.ok(worker.wait(timeout=30) == 0, "a drained worker exits 0")
        left = farm.job(job)
        tap.ok(left["workers"] == 0 and left["leases"]["expired"] == 0, "and holds nothing any more")


def leaves_when_told():
    with Farm() as farm:
        worker = farm.worker("--threads", "2", "--name", "box-8")
        farm.wait_for(lambda: farm.get("/v1/workers")["workers"], 30, "the worker asks for work")
        begin = time.monotonic()
        status = farm.terminate(worker, 10)
        tap.ok(status == 0 and time.monotonic() - begin < 2, "an idle worker leaves at once on SIGTERM")
        farm.worker("--threads", "1", "--name", "box-8")
        tap.ok(farm.wait_job(farm.submit(SMALL), "done", 60), "the next one of its name is given work")
        farm.terminate_coordinator(10)
        worker = farm.workers[1]
        tap.ok(farm.terminate(worker, 20) == 0, "it exits 0 without a coordinator, too")


def forgets_a_cancelled_job():
    with Farm(["--tile", "256"]) as farm:
        farm.worker("--threads", "2")
        job = farm.submit(LONG)
        farm.wait_for(lambda: farm.job(job)["state"] == "running", 30, "the job runs")
        farm.delete(f"/v1/jobs/{job}")
        tap.ok(farm.wait_job(farm.submit(SMALL), "done", 60), "after a job was cancelled the next one is rendered")


def mesh_scene(bytes_, format_):
    document = json.loads(SMALL)
    document["shapes"].append({"type": "mesh", "material": "white", "format": format_,
                               "asset": hashlib.sha256(bytes_).hexdigest()})
    return json.dumps(document)


def says_what_is_wrong_with_a_scene():
    with Farm() as farm:
        farm.worker("--threads", "2")
        bad = b"ply\nformat ascii 1.0\nelement vertex 3\nthis is no property\n"
        farm.put("/v1/assets/" + hashlib.sha256(bad).hexdigest(), bad)
        failed = farm.wait_job(farm.submit(mesh_scene(bad, "ply")), "failed", 30)
        reason = failed["failure"]["reason"]
        tap.ok(hashlib.sha256(bad).hexdigest() in reason and "line 4" in reason,
               f"a mesh that cannot be read fails the job: {reason}")
        tap.ok(farm.wait_job(farm.submit(SMALL), "done", 60), "and the worker goes on")


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


def waits_for_its_version():
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), OtherVersion)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with Farm() as farm:
        farm.url = f"http://127.0.0.1:{server.server_port}"
        worker = farm.worker("--threads", "1")
        farm.wait_for(lambda: "refused" in logs(farm), 10, "the worker says that it was refused")
        time.sleep(.5)  # long enough for a loop that does not wait to ask many times
        tap.ok(worker.poll() is None and OtherVersion.asked <= 2,
               f"a worker of another version waits (asked {OtherVersion.asked} times)")
        tap.ok("version: this coordinator is 9.9.9" in logs(farm), "and its log says why")
        tap.ok(farm.terminate(worker, 10) == 0, "until it is stopped")
    server.shutdown()


def misuse():
    with Farm() as farm:
        for flags in (["--threads", "0"], ["--name", "no blanks"], ["--unheard-of"], ["--log", "loud"]):
            tap.ok(farm.worker(*flags).wait(timeout=10) == 2, f"exit status 2: {' '.join(flags)}")


def main():
    reference = tool_local(SMALL)
    waits_for_its_coordinator(reference)
    keeps_what_it_has_rendered(reference)
    caches_by_hash()
    drains()
    leaves_when_told()
    forgets_a_cancelled_job()
    says_what_is_wrong_with_a_scene()
    waits_for_its_version()
    misuse()
    return tap.done()


if __name__ == "__main__":
    sys.exit(main())
