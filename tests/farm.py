"""A real farm on loopback for the end-to-end tests: smaltid, workers, faults. Standard library only.

    with Farm(["--tile", "32"]) as farm:
        farm.worker("--threads", "2")
        job = farm.submit(scene("cornell-box.json", width=64, height=64, spp=16))
        print(farm.wait_job(job, "done", 60)["image"]["digest"])

Every process is stopped when the block ends, however it ends, and a test that failed shows the last
lines of their logs. Nothing sleeps for a fixed time: wait_for polls a condition up to a limit.
BIN names the folder of the programs (default build/bin).
"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parent.parent
BIN = pathlib.Path(os.environ.get("BIN", ROOT / "build" / "bin")).resolve()


class Tap:
    """Test Anything Protocol, for prove."""

    def __init__(self):
        self.count = self.failed = 0

    def ok(self, condition, text):
        self.count += 1
        self.failed += not condition
        print(f"{'' if condition else 'not '}ok {self.count} - {text}", flush=True)
        return condition

    def skip(self, text):
        self.count += 1
        print(f"ok {self.count} # skip {text}", flush=True)

    def diag(self, text):
        for line in text.splitlines():
            print(f"# {line}", flush=True)

    def done(self):
        print(f"1..{self.count}")
        return 1 if self.failed else 0


def scene(name, width=None, height=None, **target):
    """An example scene as text, at another size and with another target (spp, error, seconds)."""
    document = json.loads((ROOT / "scenes" / name).read_text())
    document["film"]["width"] = width or document["film"]["width"]
    document["film"]["height"] = height or document["film"]["height"]
    document["film"].pop("crop", None)
    if target:
        document.setdefault("settings", {})["target"] = target
    return json.dumps(document)


def tool_local(document, threads=1, tile=64):
    """The digest of the document rendered in one process, without a farm."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "scene.json")
        path.write_text(document)
        out = pathlib.Path(folder, "out.exr")
        subprocess.run([BIN / "tool_local", path, out, "--threads", str(threads), "--tile", str(tile)],
                       check=True, stdout=subprocess.DEVNULL)
        digest = subprocess.run([BIN / "smalti", "digest", out], check=True, capture_output=True, text=True)
        return digest.stdout.split()[0]


def tool_payload(document, job, lease):
    """What a worker would deliver for this lease, traced by the real core."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "scene.json")
        path.write_text(document)
        numbers = [lease["tile"], lease["pass"], *lease["rect"], *lease["samples"]]
        return subprocess.run([BIN / "tool_payload", path, job, *map(str, numbers)], check=True,
                              capture_output=True).stdout


class Failure(Exception):
    pass


class Farm:
    def __init__(self, flags=()):
        self.flags = [str(f) for f in flags]
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="smalti-test-"))
        self.state = self.folder / "state"
        self.url = None
        self.port = 0
        self.coordinator = None
        self.workers = []
        self.started = 0

    # Life

    def __enter__(self):
        try:
            self.start_coordinator()
        except BaseException:
            self.__exit__(*sys.exc_info())
            raise
        return self

    def __exit__(self, kind, value, trace):
        for process in [*self.workers, self.coordinator]:
            if process and process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.kill()
                process.wait()
        if kind is not None and not issubclass(kind, SystemExit):
            self.show_logs()
        shutil.rmtree(self.folder, ignore_errors=True)
        return False

    def show_logs(self):
        for log in sorted(self.folder.glob("*.log")):
            for line in log.read_text(errors="replace").splitlines()[-30:]:
                print(f"# {log.name}: {line}", flush=True)

    def spawn(self, name, *argv):
        self.started += 1
        with open(self.folder / f"{self.started:03}-{name}.log", "wb") as log:
            return subprocess.Popen([str(a) for a in argv], stdin=subprocess.DEVNULL, stdout=log, stderr=log)

    def start_coordinator(self):
        """Starts it, on the same port and state as before when it ran before."""
        announce = self.folder / "url"
        announce.unlink(missing_ok=True)
        self.coordinator = self.spawn("smaltid", BIN / "smaltid", "--port", self.port, "--state", self.state,
                                      "--announce", announce, *self.flags)
        self.wait_for(lambda: announce.exists() or self.coordinator.poll() is not None, 30, "smaltid listens")
        if not announce.exists():
            raise Failure(f"smaltid exited with {self.coordinator.returncode}")
        self.url = announce.read_text().strip()
        self.port = int(self.url.rsplit(":", 1)[1])

    def kill_coordinator(self):
        self.kill(self.coordinator)

    def terminate_coordinator(self, limit):
        return self.terminate(self.coordinator, limit)

    def worker(self, *flags):
        process = self.spawn("worker", BIN / "smalti-worker", "--server", self.url, "--cache", self.folder / "cache",
                             *flags)
        self.workers.append(process)
        return process

    @staticmethod
    def kill(process):
        process.kill()
        process.wait()

    @staticmethod
    def freeze(process):
        process.send_signal(signal.SIGSTOP)

    @staticmethod
    def thaw(process):
        process.send_signal(signal.SIGCONT)

    @staticmethod
    def terminate(process, limit):
        """SIGTERM; its exit status."""
        process.terminate()
        return process.wait(timeout=limit)

    # HTTP

    def request(self, method, path, body=None, media=None, headers=None):
        """Status and answer: JSON as data, anything else as bytes. Errors are answers too."""
        request = urllib.request.Request(self.url + path, data=body, method=method, headers=dict(headers or {}))
        if media:
            request.add_header("Content-Type", media)
        elif body is not None:
            request.add_header("Content-Type", "application/json")
        try:
            with urllib.request.urlopen(request, timeout=60) as reply:
                return reply.status, self.decode(reply)
        except urllib.error.HTTPError as error:
            with error:
                return error.code, self.decode(error)

    @staticmethod
    def decode(reply):
        data = reply.read()
        return json.loads(data) if "json" in reply.headers.get("Content-Type", "") and data else data

    def must(self, method, path, **more):
        status, answer = self.request(method, path, **more)
        if status >= 400:
            raise Failure(f"{method} {path}: {status} {answer}")
        return answer

    def get(self, path):
        return self.must("GET", path)

    def post(self, path, data):
        return self.must("POST", path, body=json.dumps(data).encode())

    def put(self, path, body):
        return self.must("PUT", path, body=body, media="application/octet-stream")

    def delete(self, path):
        return self.must("DELETE", path)

    # Jobs

    def version(self):
        return self.get("/healthz")["version"]

    def submit(self, document):
        return self.must("POST", "/v1/jobs", body=document.encode())["id"]

    def jobs(self):
        return self.get("/v1/jobs")["jobs"]

    def job(self, job):
        return self.get(f"/v1/jobs/{job}")

    def wait_job(self, job, state, limit):
        last = {}

        def reached():
            last.update(self.job(job))
            if last["state"] in ("done", "failed", "cancelled") and last["state"] != state:
                raise Failure(f"job is {last['state']}: {last['failure']}")
            return last["state"] == state

        self.wait_for(reached, limit, f"job becomes {state}", explain=lambda: json.dumps(last))
        return last

    def lease(self, want, wait_ms=5000, worker="by-hand"):
        return self.post("/v1/leases", {"worker": worker, "threads": 1, "version": self.version(), "want": want,
                                        "wait_ms": wait_ms})["leases"]

    def download(self, job, name):
        path = self.folder / name
        path.write_bytes(self.get(f"/v1/jobs/{job}/{name}"))
        return path

    def cli(self, *argv, check=True):
        return subprocess.run([str(BIN / "smalti"), *map(str, argv)], check=check, capture_output=True, text=True,
                              env={**os.environ, "SMALTI_SERVER": self.url or ""})

    @staticmethod
    def wait_for(condition, limit, what, explain=lambda: ""):
        end = time.monotonic() + limit
        while not condition():
            if time.monotonic() > end:
                raise Failure(f"waited {limit} s in vain: {what} {explain()}")
            time.sleep(.02)
