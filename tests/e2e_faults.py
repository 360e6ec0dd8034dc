#!/usr/bin/env python3
"""Nothing lost, nothing twice: the same bytes after any crash (P2).

Workers are killed with -9 and frozen past their lease, the coordinator is killed with -9 and
started again, at twenty random times; the finished image is compared with tool_local's.
"""
import random
import sys
import time

from farm import Farm, Tap, scene, tool_local

tap = Tap()
SCENE = scene("cornell-box.json", width=160, height=120, spp=96)
FLAGS = ["--tile", "32", "--lease-ttl", "1", "--checkpoint", "0.3", "--image-interval", "0.3"]


def progress(farm, job):
    return farm.job(job)["progress"]


def named_faults(reference):
    with Farm(FLAGS) as farm:
        workers = [farm.worker("--threads", "1") for _ in range(3)]
        job = farm.submit(SCENE)
        farm.wait_for(lambda: progress(farm, job) > .1, 60, "a tenth is done")
        farm.kill(workers[0])
        tap.ok(True, "a worker was killed with -9 at %.0f %%" % (100 * progress(farm, job)))
        farm.freeze(workers[1])
        expired = farm.job(job)["leases"]["expired"]
        farm.wait_for(lambda: farm.job(job)["leases"]["expired"] > expired, 30, "the frozen worker's leases lapse")
        farm.thaw(workers[1])
        farm.kill_coordinator()
        farm.start_coordinator()
        after = farm.job(job)
        tap.ok(after["state"] in ("running", "done"), f"after a restart the job is {after['state']}")
        done = farm.wait_job(job, "done", 120)
        tap.ok(done["image"]["digest"] == reference, "killed, frozen and restarted: the same image")
        tap.ok(done["samples"] == 160 * 120 * 96, "every sample was merged exactly once")


def random_times(reference, times):
    rng = random.Random(20)
    with Farm(FLAGS) as farm:
        workers = [farm.worker("--threads", "1") for _ in range(2)]
        kills, job, wrong, finished = 0, None, 0, 0
        while kills < times:
            if job is None:
                job = farm.submit(SCENE)
            time.sleep(rng.uniform(.05, .6))  # the random moment is the point here
            if rng.random() < .5:
                farm.kill_coordinator()
                farm.start_coordinator()
            else:
                i = rng.randrange(2)
                farm.kill(workers[i])
                workers[i] = farm.worker("--threads", "1")
            kills += 1
            if farm.job(job)["state"] == "done":
                finished += 1
                wrong += farm.job(job)["image"]["digest"] != reference
                job = None
        if job is not None:
            finished += 1
            wrong += farm.wait_job(job, "done", 120)["image"]["digest"] != reference
        tap.ok(wrong == 0 and finished > 0, f"{times} kills at random times, {finished} jobs finished, {wrong} differ")


def worker_leaves_politely(reference):
    with Farm(FLAGS[:2] + ["--lease-ttl", "60"]) as farm:
        leaver = farm.worker("--threads", "2")
        job = farm.submit(SCENE)
        farm.wait_for(lambda: progress(farm, job) > .05, 60, "some is done")
        tap.ok(farm.terminate(leaver, 20) == 0, "SIGTERM: a worker exits 0")
        tap.ok(farm.job(job)["workers"] == 0, "and holds no lease any more")
        farm.worker("--threads", "2")
        tap.ok(farm.wait_job(job, "done", 120)["image"]["digest"] == reference, "another one finishes the same image")


def coordinator_leaves_politely(reference):
    with Farm(FLAGS[:4] + ["--checkpoint", "1000"]) as farm:
        farm.worker("--threads", "2")
        job = farm.submit(SCENE)
        farm.wait_for(lambda: progress(farm, job) > .2, 60, "a fifth is done")
        tap.ok(farm.terminate_coordinator(20) == 0, "SIGTERM: the coordinator exits 0")
        farm.start_coordinator()
        tap.ok(progress(farm, job) > .15, "and has kept what was merged, without a checkpoint in between")
        tap.ok(farm.wait_job(job, "done", 120)["image"]["digest"] == reference, "the same image")


reference = tool_local(SCENE)
named_faults(reference)
random_times(reference, 20)
worker_leaves_politely(reference)
coordinator_leaves_politely(reference)
sys.exit(tap.done())
