"""Nothing lost, nothing twice: the same bytes after any crash (P2).

Workers are killed with -9 and frozen past their lease, the coordinator is killed with -9 and started again;
first one by one, then at twenty random moments. SPDX-License-Identifier: MIT
"""

import random
import time

import farm

SCENE = farm.scene("cornell-box.json", 160, 120, spp=96)
FLAGS = ("--tile", "32", "--checkpoint", "0.3", "--image-interval", "0.3")


def progress(f, job, part):
    f.wait_for(f"{part:.0%} to be done", lambda: f.job(job)["progress"] > part, 60)


def restart(f):
    f.server.kill()
    f.start_server(*f.flags)


def named_faults(t, reference):
    with farm.Farm() as f:
        f.flags = (*FLAGS, "--lease-ttl", "1")
        f.start_server(*f.flags)
        workers = [f.start_worker("--threads", "1") for _ in range(3)]
        job = f.submit(SCENE)
        progress(f, job, .1)
        workers[0].kill()
        workers[1].freeze()
        lapsed = f.job(job)["leases"]["expired"]
        f.wait_for("the frozen worker's leases to lapse", lambda: f.job(job)["leases"]["expired"] > lapsed + 1)
        workers[1].thaw()
        restart(f)
        t.ok(f.job(job)["state"] in ("running", "done"), "after kill -9 of the coordinator the job goes on")
        done = f.done(job)
        t.equal(done["image"]["digest"], reference, "killed, frozen and restarted: the same image")
        t.equal(done["samples"], 160 * 120 * 96, "every sample was merged exactly once")


def random_times(t, reference, times):
    rng = random.Random(20)
    with farm.Farm() as f:
        f.flags = (*FLAGS, "--lease-ttl", "1")
        f.start_server(*f.flags)
        workers = [f.start_worker("--threads", "1") for _ in range(2)]
        finished, wrong, job = 0, 0, None
        for _ in range(times):
            job = job or f.submit(SCENE)
            time.sleep(rng.uniform(.05, .6))  # the moment is what is tested
            if rng.random() < .5:
                restart(f)
            else:
                i = rng.randrange(2)
                workers[i].kill()
                workers[i] = f.start_worker("--threads", "1")
            now = f.job(job)
            if now["state"] == "done":
                finished, wrong, job = finished + 1, wrong + (now["image"]["digest"] != reference), None
        if job:
            finished, wrong = finished + 1, wrong + (f.done(job)["image"]["digest"] != reference)
        t.ok(finished and not wrong, f"{times} kills at random moments, {finished} jobs done, {wrong} of them differ")


def polite_worker(t, reference):
    with farm.Farm() as f:
        f.start_server(*FLAGS, "--lease-ttl", "60")
        leaver = f.start_worker("--threads", "2")
        job = f.submit(SCENE)
        progress(f, job, .05)
        t.equal(leaver.stop(), 0, "SIGTERM: a worker exits 0")
        t.equal(f.job(job)["workers"], 0, "and holds no lease any more")
        f.start_worker("--threads", "2")
        t.equal(f.done(job)["image"]["digest"], reference, "another one finishes the same image")


def polite_coordinator(t, reference):
    with farm.Farm() as f:
        flags = ("--tile", "32", "--checkpoint", "1000")
        f.start_server(*flags)
        f.start_worker("--threads", "2")
        job = f.submit(SCENE)
        progress(f, job, .2)
        t.equal(f.server.stop(), 0, "SIGTERM: the coordinator exits 0")
        f.start_server(*flags)
        t.ok(f.job(job)["progress"] > .15, "and has kept what was merged, without a checkpoint in between")
        t.equal(f.done(job)["image"]["digest"], reference, "the same image")


def test(_, t):
    reference = farm.local_digest(SCENE)
    named_faults(t, reference)
    random_times(t, reference, 20)
    polite_worker(t, reference)
    polite_coordinator(t, reference)


farm.main(test)
