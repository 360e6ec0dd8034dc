"""farm.py - a real coordinator and real workers on loopback, for the e2e tests.

    import farm

    def test(f, t):
        f.start_server("--tile", "32", "--lease-ttl", "2")
        worker = f.start_worker("--threads", "1")
        job = f.submit("scenes/cornell-box.json")
        f.wait_for("the first image", lambda: f.job(job)["image"]["version"] > 0)
        worker.kill()                        # -9; also freeze(), thaw(), stop()
        t.ok(f.finish(job)["state"] == "done", "the job finishes all the same")

    farm.main(test)

The programs come from $BIN (default build/bin). State, logs and sockets are in a temporary directory that is removed
when all is well. Whatever happens - a failed wait, Ctrl-C, SIGTERM - every process started here is stopped;
after a failure the ends of their logs are shown as TAP diagnostics. Nothing sleeps for a fixed time: tests wait
for conditions, with a limit. Python 3 standard library only. SPDX-License-Identifier: MIT
"""

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import urllib.error
import urllib.request

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BIN = os.path.join(ROOT, os.environ.get("BIN", "build/bin"))

# Sanitized programs are slower; the limits of waiting stretch with them, the tests stay the same.
SLOWER = next((factor for mode, factor in (("tsan", 12), ("asan", 6), ("debug", 6), ("coverage", 6))
               if mode in BIN.split(os.sep) or mode + "-clang" in BIN.split(os.sep)), 1)


class Failure(Exception):
    """A test cannot go on: a limit was reached, or a program died."""


class Tap:
    """Test Anything Protocol, as tests/tap.h."""

    def __init__(self):
        self.count = self.failed = 0

    def ok(self, held, text, *details):
        """One check. Details are shown when it does not hold."""
        self.count += 1
        self.failed += not held
        print(f"{'ok' if held else 'not ok'} {self.count} - {text}", flush=True)
        if not held:
            for detail in details:
                self.diag(detail)
        return bool(held)

    def equal(self, got, want, text):
        return self.ok(got == want, text, f"got:  {got!r}", f"want: {want!r}")

    def skip(self, text, why):
        self.count += 1
        print(f"ok {self.count} - {text} # SKIP {why}", flush=True)

    def diag(self, text):
        for line in str(text).splitlines():
            print(f"# {line}", flush=True)

    def done(self):
        print(f"1..{self.count}", flush=True)
        return 1 if self.failed or not self.count else 0


def skip_all(why):
    """Leaves the whole program: what it needs is not installed."""
    print(f"1..0 # SKIP {why}", flush=True)
    sys.exit(0)


def scene(name, width, height, **target):
    """The example scene of that name at another size and with another target (spp, error, seconds).

    By path tracing: the first lease of a job that leaves the method open would be its plan's."""
    with open(os.path.join(ROOT, "scenes", name), "rb") as file:
        document = json.load(file)
    document["film"].update(width=width, height=height)
    document.setdefault("settings", {}).update(integrator="path", target=target)
    return document


def _with_document(document, program, *args):
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(document, file)
        file.flush()
        return subprocess.run([os.path.join(BIN, program), file.name, *map(str, args)], check=True,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE).stdout


def local_digest(document, threads=1, tile=64):
    """The digest of the document's image rendered in one process, without a farm."""
    with tempfile.NamedTemporaryFile(suffix=".exr") as out:
        return _with_document(document, "tool_local", out.name, "--threads", threads, "--tile", tile).decode().strip()


def payload(document, job, lease):
    """What a worker would deliver for that lease, traced by the real core."""
    return _with_document(document, "tool_payload", job, lease["tile"], lease["pass"], *lease["rect"],
                          *lease["samples"])


class Reply:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    def json(self):
        return json.loads(self.body)


# Loopback is never reached through a proxy, whatever the environment says.
_opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))


def request(method, url, body=None, headers=None, limit=30.0):
    """An answer of any status is a Reply; no answer is an OSError."""
    if isinstance(body, (dict, list)):
        body = json.dumps(body).encode()
        headers = {"Content-Type": "application/json", **(headers or {})}
    call = urllib.request.Request(url, data=body, method=method, headers=headers or {})
    try:
        with _opener.open(call, timeout=limit * SLOWER) as answer:
            return Reply(answer.status, answer.headers, answer.read())
    except urllib.error.HTTPError as answer:
        with answer:
            return Reply(answer.code, answer.headers, answer.read())


def wait_for(what, condition, limit=30.0, watch=lambda: None):
    """Returns the first true value of condition(). An OSError of it (the server is away) is a no.
    watch() is called between looks and may raise."""
    end = time.monotonic() + limit * SLOWER
    last = None
    while True:
        try:
            last = condition()
        except OSError as error:
            last = error
        if last and not isinstance(last, OSError):
            return last
        watch()
        if time.monotonic() > end:
            raise Failure(f"waited {limit * SLOWER:g} s for {what}; last seen: {last!r}")
        time.sleep(0.02)


class Process:
    """A program with its log. `wanted` says that it should be alive."""

    def __init__(self, name, argv, log_path, env=None):
        self.name, self.log_path = name, log_path
        with open(log_path, "ab") as log:
            # A session of its own: Ctrl-C reaches the test alone, which then stops its children in order.
            self.child = subprocess.Popen(argv, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                          env=env, cwd=ROOT, start_new_session=True)
        self.wanted = True
        self.frozen = False
        self.bad_exit = None  # text, when it ended other than asked

    @property
    def pid(self):
        return self.child.pid

    def alive(self):
        return self.child.poll() is None

    def freeze(self):
        self.child.send_signal(signal.SIGSTOP)
        self.frozen = True

    def thaw(self):
        self.child.send_signal(signal.SIGCONT)
        self.frozen = False

    def kill(self):
        """As by a power cut; its children go with it."""
        self.wanted = False
        try:
            os.killpg(self.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.child.wait()

    def stop(self, limit=20.0):
        """SIGTERM and wait; returns the exit status. One that does not end is killed and None returned."""
        self.wanted = False
        if self.frozen:
            self.thaw()
        self.child.terminate()
        try:
            status = self.child.wait(limit * SLOWER)
        except subprocess.TimeoutExpired:
            self.kill()
            self.bad_exit = f"{self.name} did not end within {limit * SLOWER:g} s of SIGTERM"
            return None
        if status:
            self.bad_exit = f"{self.name} ended with status {status}"
        return status

    def wait(self, limit=20.0):
        """Waits until it ends by itself; returns its exit status."""
        self.wanted = False
        wait_for(f"{self.name} to end", lambda: not self.alive(), limit)
        return self.child.returncode

    def log(self):
        with open(self.log_path, errors="replace") as log:
            return log.read()


class Farm:
    """One coordinator and its workers."""

    def __init__(self):
        self.dir = tempfile.mkdtemp(prefix="smalti-test-")
        self.state = os.path.join(self.dir, "state")
        self.port = 0        # any, at first; a restarted coordinator takes the port of the first again
        self.url = None
        self.server = None
        self.processes = []

    def __enter__(self):
        """For tests that need several farms: with farm.Farm() as f: ..."""
        return self

    def __exit__(self, kind, value, trace):
        self.kill()
        if kind:
            self.show_logs(Tap())
        self.remove()

    def start(self, name, argv, env=None):
        """Any other program that should be stopped at the end, with a log."""
        log_path = os.path.join(self.dir, f"{len(self.processes):02}-{name}.log")
        process = Process(name, argv, log_path, env)
        self.processes.append(process)
        return process

    def start_server(self, *flags, limit=20.0):
        """Returns when it answers. The state directory is kept from one start to the next."""
        announce = os.path.join(self.dir, "announce")
        if os.path.exists(announce):
            os.unlink(announce)
        self.server = self.start("smaltid", [
            os.path.join(BIN, "smaltid"), "--port", str(self.port), "--state", self.state,
            "--announce", announce, *flags])

        def address():
            with open(announce) as file:
                return file.read().strip()

        self.url = wait_for("smaltid to listen", address, limit, self.check).rstrip("/")
        self.port = int(self.url.rsplit(":", 1)[1])
        wait_for("smaltid to be healthy", lambda: self.call("GET", "/healthz").status == 200, limit, self.check)
        return self.server

    def start_worker(self, *flags):
        return self.start("worker", [os.path.join(BIN, "smalti-worker"), "--server", self.url,
                                     "--cache", os.path.join(self.dir, "cache"), *flags])

    def run(self, *args, limit=120.0, **options):
        """The CLI, to its end: a CompletedProcess with text output."""
        return subprocess.run([os.path.join(BIN, "smalti"), *args], cwd=ROOT, text=True, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=limit * SLOWER,
                              check=False, **options)

    def call(self, method, path, body=None, headers=None, limit=30.0):
        return request(method, self.url + path, body, headers, limit)

    def get(self, path):
        reply = self.call("GET", path)
        if reply.status != 200:
            raise Failure(f"GET {path}: {reply.status} {reply.body[:500]!r}")
        return reply.json()

    def submit(self, document, priority=None):
        """A scene document, or the path of one; returns the job's id."""
        if isinstance(document, str):
            with open(os.path.join(ROOT, document), "rb") as file:
                document = json.load(file)
        query = "" if priority is None else f"?priority={priority}"
        reply = self.call("POST", "/v1/jobs" + query, document)
        if reply.status != 201:
            raise Failure(f"POST /v1/jobs: {reply.status} {reply.body[:500]!r}")
        return reply.json()["id"]

    def upload(self, data):
        """An asset's bytes; returns its name."""
        name = hashlib.sha256(data).hexdigest()
        reply = self.call("PUT", f"/v1/assets/{name}", data, {"Content-Type": "application/octet-stream"})
        if reply.status not in (200, 201):
            raise Failure(f"PUT /v1/assets/{name}: {reply.status} {reply.body[:500]!r}")
        return name

    def job(self, job):
        return self.get(f"/v1/jobs/{job}")

    def done(self, job, limit=120.0):
        """Waits until the job is done; any other end is a failure."""
        ended = self.finish(job, limit)
        if ended["state"] != "done":
            raise Failure(f"job {job} is {ended['state']}: {ended['failure']}")
        return ended

    def lease(self, want, wait_ms=5000):
        """Leases for a worker that the test plays itself."""
        version = self.get("/healthz")["version"]
        body = {"worker": "by-hand", "threads": 1, "version": version, "want": want, "wait_ms": wait_ms}
        reply = self.call("POST", "/v1/leases", body)
        if reply.status != 200:
            raise Failure(f"POST /v1/leases: {reply.status} {reply.body[:500]!r}")
        return reply.json()["leases"]

    def deliver(self, lease, body):
        return self.call("PUT", f"/v1/leases/{lease['lease']}?worker=by-hand&want=0", body,
                         {"Content-Type": "application/octet-stream"})

    def finish(self, job, limit=120.0):
        """Waits until the job has ended, in whichever state, and returns it."""
        return self.wait_for(f"job {job} to end", lambda: self._ended(self.job(job)), limit)

    @staticmethod
    def _ended(job):
        return job if job["state"] in ("done", "failed", "cancelled") else None

    def wait_for(self, what, condition, limit=30.0):
        return wait_for(what, condition, limit, self.check)

    def check(self):
        """A program that should be alive and is not ends the test at once, not after a limit."""
        for process in self.processes:
            if process.wanted and not process.alive():
                process.wanted = False
                process.bad_exit = f"{process.name} ended with status {process.child.returncode}"
                raise Failure(f"{process.bad_exit} (pid {process.pid})")

    def stop(self):
        """Stops all, workers before the coordinator; returns what did not end as it should."""
        for process in reversed(self.processes):
            if process.alive():
                process.stop()
            elif process.wanted:
                process.bad_exit = f"{process.name} ended by itself, with status {process.child.returncode}"
        return [process.bad_exit for process in self.processes if process.bad_exit]

    def kill(self):
        for process in self.processes:
            process.kill()

    def show_logs(self, tap, lines=40):
        for process in self.processes:
            tail = process.log().splitlines()[-lines:]
            tap.diag(f"--- {process.name} (pid {process.pid}), the end of its log")
            tap.diag("\n".join(tail))

    def remove(self):
        shutil.rmtree(self.dir, ignore_errors=True)


def _terminate(*_):
    raise KeyboardInterrupt


def _run(test, farm, tap):
    try:
        test(farm, tap)
        bad = farm.stop()
        tap.ok(not bad, "every program stops on SIGTERM with status 0", *bad)
    except Failure as failure:
        tap.ok(False, "the test runs to its end", failure)
    except KeyboardInterrupt:
        tap.ok(False, "the test runs to its end", "interrupted")
    except Exception:  # of the test itself: reported like any other failure
        tap.ok(False, "the test runs to its end", traceback.format_exc())


def main(test):
    """Runs test(farm, tap) and exits with its verdict."""
    signal.signal(signal.SIGTERM, _terminate)
    for program in ("smaltid", "smalti-worker"):
        if not os.access(os.path.join(BIN, program), os.X_OK):
            print(f"Bail out! {os.path.join(BIN, program)} is not there: run make first", flush=True)
            sys.exit(2)
    tap, farm = Tap(), Farm()
    try:
        _run(test, farm, tap)
    finally:
        farm.kill()
        if tap.failed:
            farm.show_logs(tap)
        farm.remove()
    sys.exit(tap.done())
