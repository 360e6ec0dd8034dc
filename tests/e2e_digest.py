"""Same pixels: one digest whatever renders the job (P1).

The reference is tool_local: one process, no network, the same core. Any number of workers and threads,
any tile size, results late, twice and out of order must give the same SHA-256 of the pixels.
SPDX-License-Identifier: MIT
"""

import random

import farm

SCENE = farm.scene("glass-and-metal.json", 100, 76, spp=40)


def recorded(t):
    """What the scenes looked like to the last bit when this was last changed on purpose: the same with either
    compiler, at any optimisation, under any checker."""
    with open(f"{farm.ROOT}/tests/golden/digests.txt", encoding="ascii") as file:
        for name, width, height, spp, digest in map(str.split, file):
            t.equal(farm.local_digest(farm.scene(name, int(width), int(height), spp=int(spp))), digest,
                    f"{name} is what it was")


def one_process(t, reference):
    for threads, tile in [(1, 16), (2, 40), (2, 128)]:
        t.equal(farm.local_digest(SCENE, threads, tile), reference,
                f"one process, {threads} threads, tiles of {tile} px")


def many_farms(t, reference):
    for workers, threads, tile in [(1, 1, 64), (2, 1, 16), (3, 2, 32), (7, 1, 24), (1, 2, 128)]:
        with farm.Farm() as f:
            f.start_server("--tile", str(tile))
            for _ in range(workers):
                f.start_worker("--threads", str(threads))
            job = f.submit(SCENE)
            t.equal(f.done(job)["image"]["digest"], reference,
                    f"{workers} workers with {threads} threads, tiles of {tile} px")
            if tile == 16:
                path = f"{f.dir}/fetched.exr"
                with open(path, "wb") as file:
                    file.write(f.call("GET", f"/v1/jobs/{job}/image.exr").body)
                t.equal(f.run("digest", path).stdout.split()[0], reference, "smalti digest reads the same from the file")


def disorder(t, reference):
    """Every pass is traced by the real core, then delivered in random order, about half of them twice."""
    rng = random.Random(4)
    results = []
    with farm.Farm() as f:
        f.start_server("--tile", "64")
        job = f.submit(SCENE)
        while f.job(job)["state"] in ("queued", "running"):
            leases = f.lease(64, wait_ms=300)
            rng.shuffle(leases)
            for lease in leases:
                body = farm.payload(SCENE, job, lease)
                for _ in range(rng.choice([1, 2])):
                    reply = f.deliver(lease, body)
                    results.append(reply.json()["result"] if reply.status == 200 else reply.status)
        t.equal(f.done(job)["image"]["digest"], reference, "results out of order and twice")
    t.ok("duplicate" in results, f"{results.count('duplicate')} duplicates were noticed")
    t.ok("held" in results, f"{results.count('held')} early ones waited for their turn")


def late(t, reference):
    with farm.Farm() as f:
        f.start_server("--tile", "64", "--lease-ttl", "0.3")
        job = f.submit(SCENE)
        leases = f.lease(3)
        bodies = [farm.payload(SCENE, job, lease) for lease in leases]
        f.wait_for("leases to lapse", lambda: f.job(job)["leases"]["expired"] >= len(leases))
        results = {f.deliver(lease, body).json()["result"] for lease, body in zip(leases, bodies)}
        t.ok(results <= {"merged", "held"}, "results after their deadline are taken", results)
        f.start_worker("--threads", "2")
        t.equal(f.done(job)["image"]["digest"], reference, "and the image is the same")


def damaged(t, reference):
    with farm.Farm() as f:
        f.start_server("--tile", "64")
        job = f.submit(SCENE)
        lease = f.lease(1)[0]
        body = farm.payload(SCENE, job, lease)
        flipped = bytearray(body)
        flipped[len(body) // 2] ^= 1
        for what, bad in [("a flipped bit", bytes(flipped)),
                          ("another tile's number", farm.payload(SCENE, job, {**lease, "tile": lease["tile"] + 1})),
                          ("another rectangle", farm.payload(SCENE, job, {**lease, "rect": [0, 0, 8, 8]})),
                          ("another range of samples", farm.payload(SCENE, job, {**lease, "samples": [0, 4]})),
                          ("a short body", body[:-1]), ("an empty body", b"")]:
            t.equal(f.deliver(lease, bad).status, 400, f"{what} is refused")
        f.call("DELETE", f"/v1/leases/{lease['lease']}")
        f.start_worker("--threads", "2")
        t.equal(f.done(job)["image"]["digest"], reference, "and the image is the same")


def seconds_target(t):
    with farm.Farm() as f:
        f.start_server()
        f.start_worker("--threads", "2")
        job = f.done(f.submit(farm.scene("cornell-box.json", 128, 128, seconds=2 * farm.SLOWER)))
        t.ok(job["elapsed_seconds"] < 5 * farm.SLOWER,
             f"{2 * farm.SLOWER} s asked, {job['elapsed_seconds']:.2f} s taken, {job['spp']} spp")
        t.equal(farm.local_digest(farm.scene("cornell-box.json", 128, 128, spp=job["spp"])), job["image"]["digest"],
                "the recorded sample count gives the same image")


def test(_, t):
    reference = farm.local_digest(SCENE)
    t.diag(f"reference {reference}")
    recorded(t)
    one_process(t, reference)
    many_farms(t, reference)
    disorder(t, reference)
    late(t, reference)
    damaged(t, reference)
    seconds_target(t)


farm.main(test)
