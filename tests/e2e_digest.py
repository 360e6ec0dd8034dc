#!/usr/bin/env python3
"""Same pixels: one digest whatever renders the job (P1).

The reference is tool_local: one process, no network, through the same core. Everything else,
any number of workers and threads, any tile size, results late, twice and out of order, must
give the same SHA-256 of the pixel payload.
"""
import json
import random
import sys

from farm import Farm, Tap, scene, tool_local, tool_payload

tap = Tap()
SCENE = scene("glass-and-metal.json", width=100, height=76, spp=40)


def digest_of(farm, job):
    done = farm.wait_job(job, "done", 120)
    return done["image"]["digest"]


def farms_agree(reference):
    for workers, threads, tile in [(1, 1, 64), (2, 1, 16), (3, 2, 32), (7, 1, 24), (1, 2, 128)]:
        with Farm(["--tile", str(tile)]) as farm:
            for _ in range(workers):
                farm.worker("--threads", str(threads))
            digest = digest_of(farm, farm.submit(SCENE))
            tap.ok(digest == reference, f"{workers} workers x {threads} threads, tiles of {tile} px")
            if tile == 16:
                fetched = farm.download(farm.jobs()[0]["id"], "image.exr")
                tap.ok(farm.cli("digest", fetched).stdout.split()[0] == reference,
                       "smalti digest reads the same from the file")


def locals_agree(reference):
    for threads, tile in [(1, 16), (2, 33), (2, 128)]:
        tap.ok(tool_local(SCENE, threads=threads, tile=tile) == reference,
               f"one process, {threads} threads, tiles of {tile} px")


def deliver(farm, lease, body):
    return farm.put(f"/v1/leases/{lease['lease']}?worker=by-hand&want=0", body)["result"]


def disorder_does_not_matter(reference):
    """Every pass is traced by the real core, then delivered in random order, half of them twice."""
    rng = random.Random(4)
    with Farm(["--tile", "64"]) as farm:
        job = farm.submit(SCENE)
        results = []
        while farm.job(job)["state"] in ("queued", "running"):
            leases = farm.lease(64, wait_ms=1000)
            rng.shuffle(leases)
            for lease in leases:
                body = tool_payload(SCENE, job, lease)
                for _ in range(rng.choice([1, 2])):
                    status, answer = farm.request("PUT", f"/v1/leases/{lease['lease']}?worker=by-hand&want=0",
                                                  body=body, media="application/octet-stream")
                    results.append(answer["result"] if status == 200 else status)
        tap.ok(digest_of(farm, job) == reference, "results out of order and twice")
        tap.ok("duplicate" in results, f"{results.count('duplicate')} duplicates were noticed")
        tap.ok("held" in results, f"{results.count('held')} early ones waited for their turn")


def late_results_are_welcome(reference):
    with Farm(["--tile", "64", "--lease-ttl", "0.3"]) as farm:
        job = farm.submit(SCENE)
        late = farm.lease(3)
        bodies = [tool_payload(SCENE, job, lease) for lease in late]
        farm.wait_for(lambda: farm.job(job)["leases"]["expired"] >= len(late), 20, "leases lapse")
        results = [deliver(farm, lease, body) for lease, body in zip(late, bodies)]
        tap.ok(set(results) <= {"merged", "held"}, f"results after their deadline are taken: {results}")
        farm.worker("--threads", "2")
        tap.ok(digest_of(farm, job) == reference, "and the image is the same")


def damaged_results_are_refused(reference):
    with Farm(["--tile", "64"]) as farm:
        job = farm.submit(SCENE)
        lease = farm.lease(1)[0]
        path = f"/v1/leases/{lease['lease']}?worker=by-hand&want=0"
        body = tool_payload(SCENE, job, lease)
        flipped = bytearray(body)
        flipped[len(body) // 2] ^= 1
        other = tool_payload(SCENE, job, {**lease, "tile": lease["tile"] + 1})
        moved = tool_payload(SCENE, job, {**lease, "rect": [0, 0, 8, 8]})
        for what, bad in [("a flipped bit", bytes(flipped)), ("another tile's number", other),
                          ("another rectangle", moved), ("a short body", body[:-1]), ("an empty body", b"")]:
            status, problem = farm.request("PUT", path, body=bad, media="application/octet-stream")
            tap.ok(status == 400, f"{what} is refused: {status} {json.dumps(problem)[:120]}")
        farm.delete(f"/v1/leases/{lease['lease']}")
        farm.worker("--threads", "2")
        tap.ok(digest_of(farm, job) == reference, "and the image is the same")


def targets_agree():
    """An error target stops at the same samples on any farm, and its image is that of the sample count."""
    seen = []
    for workers in (1, 3):
        document = scene("cornell-box.json", width=64, height=64, error=0.12)
        with Farm(["--tile", "16"]) as farm:
            for _ in range(workers):
                farm.worker("--threads", "1")
            job = farm.wait_job(farm.submit(document), "done", 120)
            seen.append((job["spp"], job["image"]["digest"]))
            tap.ok(job["error"] <= 0.12, f"{workers} workers stop at an error of {job['error']:.3f}, {job['spp']} spp")
    tap.ok(seen[0] == seen[1], "an error target gives the same image on any farm")
    same = scene("cornell-box.json", width=64, height=64, spp=seen[0][0])
    tap.ok(tool_local(same) == seen[0][1], "which is the image of that many samples")


def seconds_can_be_repeated():
    document = scene("cornell-box.json", width=128, height=128, seconds=2)
    with Farm([]) as farm:
        farm.worker("--threads", "2")
        job = farm.wait_job(farm.submit(document), "done", 60)
        tap.ok(1 <= job["elapsed_seconds"] <= 5, f"2 s asked, {job['elapsed_seconds']:.2f} s taken, {job['spp']} spp")
        again = scene("cornell-box.json", width=128, height=128, spp=job["spp"])
        tap.ok(tool_local(again) == job["image"]["digest"], "the recorded sample count gives the same image")


reference = tool_local(SCENE)
tap.ok(len(reference) == 64, f"reference {reference}")
locals_agree(reference)
farms_agree(reference)
disorder_does_not_matter(reference)
late_results_are_welcome(reference)
damaged_results_are_refused(reference)
targets_agree()
seconds_can_be_repeated()
sys.exit(tap.done())
