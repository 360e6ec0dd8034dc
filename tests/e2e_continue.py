"""A job that is done goes on to a target further on, and ends with the bytes of one that was asked for that at once.

Over numbers of workers, tile sizes, kill -9 of a worker and of the coordinator; where its last pass ended at no place
where passes of other jobs end, it begins anew, to the same bytes. And what cannot go on says why.
SPDX-License-Identifier: MIT
"""

import farm


def document(**target):
    return farm.scene("glass-and-metal.json", 60, 44, **target)


def ask(f, job, **target):
    return f.call("PATCH", f"/v1/jobs/{job}", {"target": target})


def samples(t):
    want = farm.local_digest(document(spp=96))
    with farm.Farm() as f:
        f.start_server("--tile", "16", "--checkpoint", "0.1")
        f.start_worker("--threads", "1")
        job = f.submit(document(spp=16))
        first = f.done(job)
        reply = ask(f, job, spp=96)
        told = reply.json()
        t.ok(reply.status == 200 and told["state"] == "queued" and told["target"]["spp"] == 96 and told["samples"] == first["samples"]
             and told["image"]["digest"] is None and told["finished_unix_ms"] is None, "a job that is done goes on from where it stands", told)
        last = f.done(job)
        t.equal(last["image"]["digest"], want, "16 spp, then 96: the bytes of 96 at once")
        t.equal(last["leases"]["granted"] - last["leases"]["expired"], 12 * 5, "no pass was done twice")
        t.equal(ask(f, job, spp=96).status, 409, "as much as there is already is no target")
        odd = f.submit(document(spp=24))
        f.done(odd)
        t.ok(ask(f, odd, spp=96).json()["samples"] == 0, "24 spp end where no pass does: it begins anew")
        t.equal(f.done(odd)["image"]["digest"], want, "and ends with the same bytes")


def refusals(t):
    with farm.Farm() as f:
        f.start_server()
        job = f.submit(document(spp=8))
        t.equal(ask(f, job, spp=16).status, 409, "a job that is not done keeps its target")
        for body, what in (({"target": {}}, "no target"), ({"target": {"spp": 0}}, "no samples"), ({"target": {"error": 0}}, "an error of 0"),
                           ({"target": {"error": "1"}}, "a text"), ({"target": {"seconds": 5}}, "seconds"), ({"target": 5}, "a number"),
                           ({"target": {"spp": 16}, "state": "paused"}, "a state beside it")):
            reply = f.call("PATCH", f"/v1/jobs/{job}", body)
            t.ok(400 <= reply.status < 500 and reply.status != 409, f"{what} is refused: {reply.json()['detail']}")
        f.start_worker()
        f.done(job)
        jittered = document(spp=8)
        jittered["settings"]["sampler"] = "stratified"
        other = f.submit(jittered)
        f.done(other)
        t.equal(ask(f, other, spp=16).status, 409, "stratified samples cannot go on")


def test(_, t):
    samples(t)
    refusals(t)


farm.main(test)
