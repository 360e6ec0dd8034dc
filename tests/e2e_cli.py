"""The command line: every command, every exit status, nothing left behind. SPDX-License-Identifier: MIT"""

import json
import os
import pty
import re
import signal
import subprocess
import time
import zlib

import farm

SMALL = farm.scene("cornell-box.json", 64, 64, spp=16)
PROGRAM = os.path.join(farm.BIN, "smalti")


def write(f, name, document):
    path = os.path.join(f.dir, name)
    with open(path, "w", encoding="utf-8") as file:
        file.write(document if isinstance(document, str) else json.dumps(document))
    return path


def private_processes(f):
    """Processes of a `smalti render` whose state is in our directory."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/cmdline", "rb") as file:
                if f"{f.dir}/smalti-".encode() in file.read():
                    found.append(pid)
        except OSError:
            pass
    return found


def leftovers(f):
    return [name for name in os.listdir(f.dir) if name.startswith("smalti-")] + private_processes(f)


def renders(f, t):
    small, out = write(f, "small.json", SMALL), os.path.join(f.dir, "small.exr")
    reference = farm.local_digest(SMALL)
    env = {**os.environ, "TMPDIR": f.dir}
    done = f.run("render", small, "-o", out, "--workers", "2", "--threads", "1", "--tile", "32", env=env)
    t.equal(done.returncode, 0, "render: exit status 0")
    t.equal(f.run("digest", out).stdout.strip(), reference, "render: the image of one process")
    lines = done.stderr.splitlines()
    t.ok(len(lines) >= 2 and "\r" not in done.stderr and lines[-2].startswith("done 100 %"),
         "render: plain lines where there is no terminal", done.stderr)
    t.equal(leftovers(f), [], "render: no process and no file is left")

    done = f.run("render", small, "-o", out, "--spp", "8", "--quiet", "--json", env=env)
    told = json.loads(done.stdout)
    t.equal((told["output"], told["spp"], told["state"], done.stderr), (out, 8, "done", ""),
            "render --json: one object and silence")
    png = os.path.join(f.dir, "small.png")
    done = f.run("render", small, "-o", out, "--spp", "8", "--quiet", "--png", png, env=env)
    with open(png, "rb") as file:
        t.ok(done.returncode == 0 and file.read(8) == b"\x89PNG\r\n\x1a\n", "render --png: a picture beside the image")
    odd = f.run("render", small, "-o", out, "--tile", "33", env=env)
    t.ok(odd.returncode == 2 and "--tile: expected a multiple of 8, got 33" in odd.stderr, "render --tile: whole blocks only", odd.stderr)
    done = f.run("render", small, "-o", out, "--error", "0.5", "--quiet", "--json", env=env)
    told = json.loads(done.stdout)
    t.ok(done.returncode == 0 and told["error"] <= .5 and told["target"]["error"] == .5,
         "render --error: it stops when the error is met", told)
    done = f.run("render", small, "-o", out, "--seconds", "1", "--quiet", "--json", env=env)
    told = json.loads(done.stdout)
    same = f.run("render", small, "-o", out + "2", "--spp", str(told["target"]["spp"]), "--quiet", env=env)
    t.ok(done.returncode == same.returncode == 0 and f.run("diff", out, out + "2").returncode == 0,
         "render --seconds: as many samples again give the same image", told)
    kept = os.path.join(f.dir, "kept")
    digests, names = [], []
    for _ in range(2):
        f.run("render", small, "-o", out, "--quiet", "--cache", kept, env=env)
        digests.append(f.run("digest", out).stdout.strip())
        names.append({name: os.stat(os.path.join(kept, name)).st_ino for name in os.listdir(kept)})
    t.ok(names[0] == names[1] and any(name.endswith(".stage") for name in names[0]),
         "render --cache: the prepared scene is kept, and not made again", names)
    t.equal(digests, [reference, reference], "render --cache: the same image")
    t.equal(f.run("render", os.path.join(f.dir, "none.json"), env=env).returncode, 3, "render: no scene, status 3")
    t.equal(f.run("render", small, "-o", "/nonexistent/x.exr", env=env).returncode, 5,
            "render: nowhere to write, status 5")


def shows_a_moving_bar(f, t):
    small, out = os.path.join(f.dir, "small.json"), os.path.join(f.dir, "tty.exr")
    main_end, child_end = pty.openpty()
    child = subprocess.Popen([PROGRAM, "render", small, "-o", out], stderr=child_end, cwd=f.dir,
                             env={**os.environ, "TMPDIR": f.dir})
    os.close(child_end)
    shown = b""
    try:
        while data := os.read(main_end, 4096):
            shown += data
    except OSError:  # the other end was closed
        pass
    os.close(main_end)
    t.equal(child.wait(), 0, "on a terminal render ends well")
    t.ok(b"\r" in shown and b"[####" in shown and re.search(rb"\r\n.*tty\.exr: 16 spp", shown),
         "and its bar moves on one line", shown)


def leaves_the_best_image(f, t):
    long = write(f, "long.json", farm.scene("cornell-box.json", 64, 64, spp=1 << 24))
    out = os.path.join(f.dir, "long.exr")
    log = open(os.path.join(f.dir, "long.log"), "w+b")
    child = subprocess.Popen([PROGRAM, "render", long, "-o", out, "--json"], stderr=log, stdout=subprocess.DEVNULL,
                             env={**os.environ, "TMPDIR": f.dir})

    def has_error():
        log.seek(0)
        return b" error " in log.read()

    f.wait_for("a first estimate", has_error, 60)
    f.wait_for("an image", lambda: any(
        "image.exr" in files for _, _, files in os.walk(f.dir)))
    child.send_signal(signal.SIGINT)
    t.equal(child.wait(20 * farm.SLOWER), 130, "Ctrl-C: exit status 130")
    t.equal(f.run("digest", out).returncode, 0, "Ctrl-C: the best image so far is there")
    t.equal(leftovers(f), [], "Ctrl-C: no process and no file is left")
    log.close()


def takes_its_children_along(f, t):
    long = os.path.join(f.dir, "long.json")
    child = subprocess.Popen([PROGRAM, "render", long, "-o", os.path.join(f.dir, "x.exr"), "--quiet", "--workers", "2"],
                             env={**os.environ, "TMPDIR": f.dir})
    f.wait_for("its processes", lambda: len(private_processes(f)) >= 3)
    child.kill()
    child.wait()
    f.wait_for("its processes to die with it", lambda: not private_processes(f), 10)
    t.ok(True, "kill -9: its processes die with it")


def replays_a_sample(f, t, job, env):
    told = json.loads(f.run("replay", job, "5,9", "3", "--json", env=env).stdout)
    t.ok((told["pixel"], told["sample"]) == ([5, 9], 3) and told["end"], "replay --json: the pixel, the sample, its end", told)
    path = told["path"]
    t.ok(path and path[0]["throughput"] == [1, 1, 1] and all(len(p["point"]) == 3 and p["material"] for p in path),
         "replay: what the path has met", told)
    t.ok(all(a <= b for p in path for a, b in zip(p["light"], told["radiance"])), "light is only found, never lost", told)
    text = f.run("replay", job, "5,9", "3", env=env).stdout
    t.ok(f"  0  {path[0]['material']}" in text and told["end"] in text, "replay: the same for people", text)
    t.equal(f.run("replay", job, "5000,9", "3", env=env).returncode, 3, "replay: no such pixel, status 3")
    t.equal(f.run("replay", job, "5", "3", env=env).returncode, 2, "replay: no pixel, status 2")
    t.equal(f.run("replay", "0" * 16, "5,9", "3", env=env).returncode, 1, "replay: no such job, status 1")


def continues_a_job(f, t, job, env):
    had = f.job(job)["spp"]
    went = f.run("continue", job, "--spp", str(2 * had), "--wait", "--json", env=env)
    lines = [json.loads(line) for line in went.stdout.splitlines()]
    t.ok(went.returncode == 0 and lines[-1]["state"] == "done" and lines[-1]["spp"] == 2 * had, "continue --wait: done, with twice the samples",
         went.stderr)
    again = f.run("continue", job, "--spp", str(had), env=env)
    t.ok(again.returncode == 1 and str(2 * had) in again.stderr, "continue: no further than it is, status 1", again.stderr)
    t.equal(f.run("continue", job, env=env).returncode, 2, "continue: no target, status 2")
    t.equal(f.run("continue", job, "--error", "0", env=env).returncode, 2, "continue: an error of 0, status 2")
    t.equal(f.run("continue", "0" * 16, "--error", ".1", env=env).returncode, 1, "continue: no such job, status 1")


def works_with_a_coordinator(f, t):
    env = {**os.environ, "SMALTI_SERVER": f.url}
    small, out = os.path.join(f.dir, "small.json"), os.path.join(f.dir, "fetched.exr")
    worker = f.start_worker("--threads", "1")
    sent = f.run("submit", small, "--priority", "7", env=env)
    job = sent.stdout.strip()
    t.ok(sent.returncode == 0 and re.fullmatch("[0-9a-f]{16}", job), "submit prints the job's id", sent.stderr)
    t.equal(f.job(job)["priority"], 7, "submit --priority")
    watched = f.run("watch", job, "--json", env=env)
    states = [json.loads(line)["state"] for line in watched.stdout.splitlines()]
    t.ok(watched.returncode == 0 and states[-1] == "done", "watch --json: a line per change, status 0", states)
    t.ok(job in f.run("status", env=env).stdout, "status lists it")
    t.equal(json.loads(f.run("status", job, "--json", env=env).stdout)["state"], "done", "status ID --json")
    t.equal(f.run("fetch", job, "-o", out, env=env).returncode, 0, "fetch: status 0")
    t.equal(f.run("digest", out).stdout.strip(), f.job(job)["image"]["digest"], "fetch: the job's image")
    png = os.path.join(f.dir, "fetched.png")
    f.run("fetch", job, "--png", "-o", png, env=env)
    with open(png, "rb") as file:
        t.equal(file.read(8), b"\x89PNG\r\n\x1a\n", "fetch --png: a PNG")
    t.equal(f.run("cancel", job, env=env).returncode, 1, "cancel: a job that has ended, status 1")
    continues_a_job(f, t, job, env)

    replays_a_sample(f, t, job, env)
    waited = f.run("submit", small, "--wait", env=env)
    t.equal((waited.returncode, waited.stdout.strip() != job), (0, True), "submit --wait: another job, done")
    worker.stop()
    idle = f.run("submit", small, env=env).stdout.strip()
    t.equal(f.run("fetch", idle, "-o", out, env=env).returncode, 1, "fetch: no image yet, status 1")
    t.equal(f.run("cancel", idle, env=env).returncode, 0, "cancel: status 0")
    t.equal(f.run("watch", idle, env=env).returncode, 1, "watch: a cancelled job, status 1")
    t.equal(f.run("status", "0123456789abcdef", env=env).returncode, 1, "status: no such job, status 1")
    t.equal(f.run("status", "nonsense", env=env).returncode, 2, "status: no id at all, status 2")


def png(width, height, rgb):
    """An image of one colour."""
    def chunk(name, data):
        return (len(data).to_bytes(4, "big") + name + data + zlib.crc32(name + data).to_bytes(4, "big"))
    head = width.to_bytes(4, "big") + height.to_bytes(4, "big") + bytes([8, 2, 0, 0, 0])
    rows = (b"\0" + bytes(rgb) * width) * height
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def uploads_what_is_missing(f, t):
    env = {**os.environ, "SMALTI_SERVER": f.url}
    mesh = "v 0.2 0.2 0.3\nv 0.3 0.2 0.3\nv 0.2 0.3 0.3\nf 1 2 3\n"
    write(f, "part.obj", mesh)
    document = farm.scene("cornell-box.json", 64, 64, spp=8)
    document["shapes"].append({"type": "mesh", "material": "white", "file": "part.obj"})
    with open(os.path.join(f.dir, "leaf.png"), "wb") as image:
        image.write(png(3, 2, (20, 200, 60)))
    document["textures"] = {"leaf": {"type": "image", "file": "leaf.png"}}
    path = write(f, "meshes.json", document)
    f.start_worker("--threads", "1")
    first = f.run("submit", path, "--wait", env=env)
    t.equal(first.returncode, 0, "a scene with a mesh file and an image file is sent and rendered")
    job = first.stdout.strip()
    f.run("fetch", job, "-o", os.path.join(f.dir, "meshes.exr"), env=env)
    out = os.path.join(f.dir, "meshes-local.exr")
    t.equal(subprocess.run([os.path.join(farm.BIN, "tool_local"), path, out], stdout=subprocess.DEVNULL,
                           check=False).returncode, 0, "and in one process")
    t.equal(f.run("diff", os.path.join(f.dir, "meshes.exr"), out).returncode, 0, "to the same pixels")
    os.unlink(os.path.join(f.dir, "part.obj"))
    broken = f.run("submit", path, env=env)
    t.ok(broken.returncode == 3 and f"{path}: /shapes/16: " in broken.stderr, "a mesh file that is gone: status 3",
         broken.stderr)
    write(f, "part.obj", mesh)
    write(f, "leaf.png", "a leaf")
    broken = f.run("submit", path, env=env)
    t.ok(broken.returncode == 3 and f"{path}: /textures/leaf: " in broken.stderr, "an image file that is none: status 3",
         broken.stderr)


def checks_scenes(f, t):
    bad = write(f, "bad.json", {**SMALL, "camera": {"type": "perspective", "fov_deg": 200}, "shap": []})
    checked = f.run("check", bad)
    t.ok(checked.returncode == 3 and checked.stderr.count(f"{bad}: /") >= 2, "check: every error with its place",
         checked.stderr)
    told = json.loads(f.run("check", bad, "--json").stdout)
    t.ok(not told["valid"] and "/camera/fov_deg" in [e["pointer"] for e in told["errors"]], "check --json", told)
    loud = {"smalti": 1, "film": {"width": 16, "height": 16}, "materials": {"m": {"type": "diffuse", "albedo": [2, 1, 0.5]}},
            "camera": {"type": "perspective", "fov_deg": 40, "look_at": {"from": [0, 1, 5], "to": [0, 1, 0]}},
            "shapes": [{"type": "sphere", "material": "m", "center": [0, 1, 0], "radius": 1}],
            "settings": {"integrator": "path", "rescale": True, "target": {"spp": 8}}}
    path = write(f, "loud.json", loud)
    change = {"pointer": "/materials/m/albedo", "detail": "more light than there is: was 2, 1, 0.5, became 1, 0.5, 0.25",
              "was": [2, 1, 0.5], "became": [1, 0.5, 0.25]}
    told = json.loads(f.run("check", path, "--json").stdout)
    t.equal(told, {"valid": True, "errors": [], "warnings": [change]}, "check --json says what rescale has changed")
    said = f.run("check", path)
    t.ok(said.returncode == 0 and said.stderr == f"warning: {path}: {change['pointer']}: {change['detail']}\n",
         "and check on stderr", said)
    job = f.submit(loud)
    f.server.stop()
    f.start_server()
    t.equal(f.get(f"/v1/jobs/{job}")["warnings"], [change], "a job's status says it, after a restart, too")
    t.equal(json.loads(f.run("check", "scenes/cornell-box.json", "--json").stdout), {"valid": True, "errors": [], "warnings": []},
            "check --json: a valid scene")
    t.equal(f.run("check", "scenes/cornell-box.json").returncode, 0, "check: status 0")


def plans_scenes(f, t):
    planned = f.run("plan", "scenes/cornell-box.json")
    t.ok(planned.returncode == 0 and planned.stdout.startswith("method     path, mis: "), "plan: the method and why",
         planned.stdout)
    told = json.loads(f.run("plan", "scenes/cornell-box.json", "--error", "0.02", "--json").stdout)
    t.equal((told["method"]["strategy"], told["error"], told["error_asked"]), ("mis", .02, True), "plan --error --json")
    t.ok(told["forecast"]["low"] <= told["forecast"]["units"] <= told["forecast"]["high"], "with a forecast", told)
    t.equal(f.run("plan", os.path.join(f.dir, "bad.json")).returncode, 3, "plan: no valid scene, status 3")


def compares_images(f, t):
    a, b = (os.path.join(f.dir, name) for name in ("small.exr", "small.exr2"))
    f.run("render", os.path.join(f.dir, "small.json"), "-o", a, "--spp", "16", "--quiet")
    f.run("render", os.path.join(f.dir, "small.json"), "-o", b, "--spp", "32", "--quiet")
    t.equal(f.run("diff", a, a).returncode, 0, "diff: identical, status 0")
    differ = f.run("diff", a, b, "--json")
    told = json.loads(differ.stdout)
    t.ok(differ.returncode == 1 and not told["identical"] and 0 < told["relmse_99_9"] < told["relmse"] < 10,
         "diff --json: different, status 1", told)
    t.equal(f.run("diff", a, b, "--tolerance", str(told["relmse"] * 1.01)).returncode, 0, "diff --tolerance: close enough")
    t.equal(f.run("diff", a, os.path.join(f.dir, "bad.json")).returncode, 3, "diff: not an image, status 3")
    t.equal(f.run("digest", os.path.join(f.dir, "nothing.exr")).returncode, 3, "digest: no file, status 3")


def explains_itself(f, t):
    for command in "render submit status watch fetch cancel continue replay check plan diff digest".split():
        told = f.run(command, "--help")
        t.ok(told.returncode == 0 and told.stdout.startswith(f"Usage: smalti {command}") and
             "xit status" in told.stdout, f"{command} --help")
        wrong = f.run(command, "--no-such-flag")
        t.ok(wrong.returncode == 2 and "--no-such-flag" in wrong.stderr and f"smalti {command} --help" in wrong.stderr,
             f"{command}: an unknown flag, status 2 and a hint", wrong.stderr)
    t.equal((f.run().returncode, f.run("rendr").returncode, f.run("--help").returncode), (2, 2, 0),
            "no command, an unknown one, help")
    env = {**os.environ, "SMALTI_SERVER": "http://127.0.0.1:1"}
    begin = time.monotonic()
    t.equal(f.run("status", env=env).returncode, 4, "a coordinator that is not there: status 4")
    t.ok(time.monotonic() - begin < 5 * farm.SLOWER, "at once")
    t.equal(f.run("status", "--server", "localhost").returncode, 2, "no address: status 2")


def test(f, t):
    f.start_server()
    renders(f, t)
    shows_a_moving_bar(f, t)
    leaves_the_best_image(f, t)
    takes_its_children_along(f, t)
    works_with_a_coordinator(f, t)
    uploads_what_is_missing(f, t)
    checks_scenes(f, t)
    plans_scenes(f, t)
    compares_images(f, t)
    explains_itself(f, t)


farm.main(test)
