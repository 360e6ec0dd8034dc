"""Jobs that leave their method open: one plan, made by a worker as a lease of its own, then passes of the method it chose;
the same bytes as a document that asks for that method, whoever lapses, dies or lies on the way.
SPDX-License-Identifier: MIT"""

import json
import os
import struct

import farm


def furnace(**settings):
    """A box whose walls all shine: there shadow rays are not worth their price."""
    quads = [[[-1, -1, -1], [-1, 1, -1], [1, 1, -1], [1, -1, -1]], [[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]],
             [[-1, -1, -1], [-1, -1, 1], [-1, 1, 1], [-1, 1, -1]], [[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]],
             [[-1, -1, -1], [1, -1, -1], [1, -1, 1], [-1, -1, 1]], [[-1, 1, -1], [-1, 1, 1], [1, 1, 1], [1, 1, -1]]]
    return {"smalti": 1, "film": {"width": 128, "height": 96},
            "camera": {"type": "perspective", "fov_deg": 60, "look_at": {"from": [0, 0, 0], "to": [0.3, 0.2, -1]}},
            "materials": {"gray": {"type": "diffuse", "albedo": 0.5}},
            "shapes": [{"type": "quad", "material": "gray", "emission": 1, "vertices": [q[i] for i in (0, 3, 2, 1)]}
                       for q in quads],
            "settings": {"target": {"spp": 128}, **settings}}


def attribute(exr, name):
    """Of a string attribute: its JSON."""
    at = exr.index(name + b"\0string\0") + len(name) + 8
    size, = struct.unpack("<i", exr[at:at + 4])
    return json.loads(exr[at + 4:at + 4 + size])


AUTO = furnace()  # the default
BSDF = {"integrator": "path", "strategy": "bsdf"}
JSON = {"Content-Type": "application/json"}


def is_planned_once(f, t, reference):
    workers = [f.start_worker("--threads", "1") for _ in range(2)]
    job = f.submit(AUTO)
    done = f.done(job)
    t.equal((done["auto"], done["method"]), (True, BSDF), "a furnace: no shadow rays")
    t.equal(done["image"]["digest"], reference, "the image of a document that asks for the same")
    plan = f.get(f"/v1/jobs/{job}/plan")
    t.ok(plan["version"] == 3 and {**plan["method"], "sampler": "sobol"} == {**BSDF, "sampler": "sobol"} and
         plan["pilot_pixels"] > 0, "the plan says so, and why", plan["why"])
    scene = os.path.join(f.dir, "auto.json")
    with open(scene, "w") as file:
        json.dump(AUTO, file)
    t.equal(json.loads(f.run("plan", scene, "--json").stdout), plan, "smalti plan prints the same plan")
    image = f.call("GET", f"/v1/jobs/{job}/image.exr").body
    t.equal(attribute(image, b"smalti.plan"), plan, "the EXR carries it")
    named = f.done(f.submit(furnace(integrator="auto")))
    t.equal((named["auto"], named["image"]["digest"]), (True, reference), "a document may also ask for a plan by name")
    plain = f.done(f.submit(furnace(integrator="path")))
    t.equal((plain["auto"], plain["method"]), (False, None), "a document that names a method is not planned")
    t.equal(f.call("GET", f"/v1/jobs/{plain['id']}/plan").status, 404, "and has no plan")
    again = f.done(f.submit(AUTO))
    t.equal(again["image"]["digest"], reference, "the same again, from the workers' cache")
    for worker in workers:
        worker.stop()


def survives(f, t, reference):
    job = f.submit(AUTO)
    [lease] = f.lease(1)  # and nothing comes of it
    t.ok(lease["plan"], "somebody takes the plan's lease")
    f.wait_for("it to lapse", lambda: f.job(job)["leases"]["expired"], 60)
    f.server.kill()
    f.start_server(*f.flags)
    worker = f.start_worker("--threads", "1")
    f.wait_for("the plan", lambda: f.job(job)["method"], 60)
    f.server.kill()
    f.start_server(*f.flags)
    t.equal(f.job(job)["method"], BSDF, "a plan is on disk before anything else happens")
    t.equal(f.done(job)["image"]["digest"], reference, "lapsed, killed, restarted: the same image")
    replayed = f.run("replay", job, "10,20", "3", "--server", f.url, "--json")
    t.ok(replayed.returncode == 0 and json.loads(replayed.stdout)["path"], "a sample of it is traced again",
         replayed.stderr)
    worker.stop()


def goes_on(f, t, reference):
    """A target further on, by spp and by error: the method is still the one that it would have been given."""
    worker = f.start_worker("--threads", "1")
    job = f.submit(furnace(integrator="auto", target={"spp": 8}))
    first = f.done(job)
    t.equal(first["method"], BSDF, "planned for 8 samples of a pixel")
    t.equal(f.call("PATCH", f"/v1/jobs/{job}", {"target": {"spp": 128}}).status, 200, "it goes on to 128")
    t.equal(f.done(job)["image"]["digest"], reference, "to the bytes of 128 at once")
    job = f.submit(furnace(integrator="auto", target={"error": 0.2}))
    f.done(job)
    t.equal(f.call("PATCH", f"/v1/jobs/{job}", {"target": {"error": 0.02}}).status, 200, "an error goes on to a smaller one")
    last, at_once = f.done(job), f.done(f.submit(furnace(integrator="auto", target={"error": 0.02})))
    t.equal((last["image"]["digest"], last["spp"]), (at_once["image"]["digest"], at_once["spp"]), "to the bytes of that at once")
    worker.stop()


def deliver(f, lease, body):
    return f.call("PUT", f"/v1/leases/{lease['lease']}/plan?worker=by-hand&want=0", body, JSON)


def believes_nothing(f, t):
    job = f.submit(AUTO)
    [lease] = f.lease(4)
    t.ok(lease["plan"] is True and "tile" not in lease, "the first lease is the plan's, and there is no other", lease)
    pass_lease = {**lease, "tile": 0, "pass": 0, "rect": [0, 0, 64, 64], "samples": [0, 8]}
    t.ok(f.deliver(lease, farm.payload(AUTO, job, pass_lease)).status in (400, 409), "samples are no plan")
    good = {"version": 3, "method": {"integrator": "path", "strategy": "light", "sampler": "sobol"}}
    for body, status, what in (
            (b"{", 400, "no JSON"), ([], 400, "no object"), ({}, 400, "nothing"),
            ({**good, "version": 2}, 400, "another version"),
            ({**good, "method": {"integrator": "auto", "strategy": "mis"}}, 400, "no method"),
            ({**good, "method": {"integrator": "direct", "strategy": "bsdf"}}, 400, "no method there is"),
            ({**good, "method": "path"}, 400, "not even an object"),
            ({**good, "why": "x" * 20000}, 413, "too long")):
        if isinstance(body, (dict, list)):
            body = json.dumps(body).encode()
        t.equal(deliver(f, lease, body).status, status, f"a plan that is {what}")
    t.equal(f.job(job)["method"], None, "and none of it has been believed")
    unknown = {**lease, "lease": "0123456789abcdef"}
    t.equal(deliver(f, unknown, json.dumps(good).encode()).status, 404, "a lease that nobody has")
    reply = deliver(f, lease, json.dumps(good).encode())
    t.equal((reply.status, reply.json()["result"]), (200, "planned"), "a plan")
    t.equal(deliver(f, lease, json.dumps(good).encode()).status, 404, "only once")
    leases = f.lease(4)
    t.ok(leases and all(l["method"] == {"integrator": "path", "strategy": "light"} for l in leases),
         "passes come with the method")
    t.equal(deliver(f, leases[0], json.dumps(good).encode()).status, 400, "a plan is no pass")
    f.call("DELETE", f"/v1/jobs/{job}")


def gives_up(f, t):
    job = f.submit(AUTO)
    for i in range(3):
        body = {"worker": f"bad-{i}", "threads": 1, "version": f.get("/healthz")["version"], "want": 1, "wait_ms": 5000}
        [lease] = f.call("POST", "/v1/leases", body).json()["leases"]
        f.call("DELETE", f"/v1/leases/{lease['lease']}", {"reason": "no room", "kind": "worker"})
    failed = f.finish(job)
    t.ok(failed["state"] == "failed" and "no room" in failed["failure"]["reason"] and failed["failure"]["pass"] is None,
         "a plan that fails on three workers fails the job", failed["failure"])


def test(f, t):
    reference = farm.local_digest(furnace(**BSDF))
    t.ok(reference != farm.local_digest(furnace(integrator="path")), "methods differ in their noise")
    f.start_server()
    believes_nothing(f, t)
    gives_up(f, t)
    f.server.stop()
    f.flags = ("--lease-ttl", "1")
    f.start_server(*f.flags)
    is_planned_once(f, t, reference)
    survives(f, t, reference)
    goes_on(f, t, reference)


farm.main(test)
