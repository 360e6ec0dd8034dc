"""Jobs with an error target put their samples where the noise is, and give the same bytes on any farm.

One digest, and the same work, over 1 and 3 workers, tiles of 16, 24 and 64 px, kill -9 of workers and of the coordinator, and a job
that was first asked for larger errors. The reference is the rule of common/adaptive.h without a farm (tests/adapt.h).
SPDX-License-Identifier: MIT
"""

import farm

FIRST, SECOND, LAST = .1, .05, .03


def document(error):
    return farm.scene("cornell-box.json", 56, 40, error=error)


def what_is_said(t, f, job):
    spp, stopped = job["report"]["spp"], job["report"]["stopped"]
    t.ok(32 <= spp["least"] < spp["most"] and spp["least"] < spp["mean"] < spp["most"] and 0 < stopped < 1,
         f"blocks have stopped: {stopped:.0%} of the pixels, {spp['least']} to {spp['most']} spp, {spp['mean']:.0f} in the mean")
    t.equal(job["samples"], round(spp["mean"] * 56 * 40), "and all samples are counted")
    t.ok(job["error"] <= SECOND, f"the error is {job['error']:.4f}")
    t.ok(f"{spp['least']} to {spp['most']} spp" in f.run("status", job["id"], "--server", f.url).stdout,
         "smalti status says how many samples pixels have")


def calm(t):
    with farm.Farm() as f:
        f.start_server("--tile", "64")
        f.start_worker("--threads", "1")
        job = f.done(f.submit(document(SECOND)))
        t.equal(job["image"]["digest"], farm.local_digest(document(SECOND)), "one worker: the image of the rule without a farm")
        what_is_said(t, f, job)
        return job


def faulty(t, want):
    flags = ("--tile", "16", "--checkpoint", "0.1", "--lease-ttl", "1")
    with farm.Farm() as f:
        server = f.start_server(*flags)
        workers = [f.start_worker("--threads", "1") for _ in range(3)]
        job = f.submit(document(SECOND))
        for part in (.2, .5):
            most = want["samples"] * part
            f.wait_for(f"{most:.0f} samples", lambda: f.job(job)["samples"] > most)
            workers.pop().kill()
            server.kill()
            server = f.start_server(*flags)
        same(t, f.done(job), want, "three workers, two of them killed, and the coordinator twice")


def same(t, job, want, what):
    t.equal((job["image"]["digest"], job["samples"], job["report"]["spp"], job["report"]["stopped"], job["report"]["work"]),
            (want["image"]["digest"], want["samples"], want["report"]["spp"], want["report"]["stopped"], want["report"]["work"]),
            f"{what}: the same image by the same work")


def continued(t, want):
    flags = ("--tile", "24", "--checkpoint", "0.1", "--lease-ttl", "2")
    with farm.Farm() as f:
        server = f.start_server(*flags)
        f.start_worker("--threads", "1")
        doomed = f.start_worker("--threads", "1")
        job = f.submit(document(FIRST))
        first = f.done(job)
        spp = first["report"]["spp"]
        t.ok(spp["least"] < spp["most"] and spp["least"] <= want["report"]["spp"]["least"], f"an error of {FIRST}: {spp['least']} to {spp['most']} spp")
        more(t, f, job, SECOND)
        same(t, f.done(job), want, f"from there to {SECOND}")
        more(t, f, job, LAST)
        doomed.kill()
        f.wait_for("more samples", lambda: f.job(job)["samples"] > 1.2 * want["samples"])
        server.kill()
        f.start_server(*flags)
        t.equal(f.done(job)["image"]["digest"], farm.local_digest(document(LAST)),
                f"from there to {LAST}, with a worker and the coordinator killed: the bytes of asking at once")
        t.equal(f.call("PATCH", f"/v1/jobs/{job}", {"target": {"error": SECOND}}).status, 409, "an error that is met is no target")


def more(t, f, job, error):
    before = f.job(job)
    told = f.call("PATCH", f"/v1/jobs/{job}", {"target": {"error": error}}).json()
    t.ok(told["state"] == "queued" and told["samples"] == before["samples"], f"a done job goes on to an error of {error} with what it has", told)


def test(_, t):
    want = calm(t)
    faulty(t, want)
    continued(t, want)


farm.main(test)
