#!/usr/bin/env python3
"""Always openable: whoever opens the EXR at any moment finds it whole (P6)."""
import shutil
import subprocess
import sys

from farm import Farm, Tap, scene

tap = Tap()
OPENS = 1000

with Farm(["--tile", "32", "--image-interval", "0"]) as farm:
    farm.worker("--threads", "1")
    job = farm.submit(scene("cornell-box.json", width=200, height=150, spp=4096))
    path = farm.state / "jobs" / job / "image.exr"
    farm.wait_for(path.exists, 60, "a first image")
    bad, versions = 0, set()
    for i in range(OPENS // 25):
        # One call of the CLI opens the file, decodes every pixel and hashes it, 25 times over.
        result = farm.cli("digest", *[str(path)] * 25, check=False)
        bad += result.returncode != 0
        versions |= set(line.split()[0] for line in result.stdout.splitlines())
    tap.ok(bad == 0, f"{OPENS} opens while the file is rewritten, none failed")
    tap.ok(len(versions) > 3, f"{len(versions)} different images were seen")
    tap.ok(farm.job(job)["state"] == "running", "the job was running all the time")
    for tool in (["exrheader", str(path)], ["oiiotool", "--stats", str(path)]):
        if not shutil.which(tool[0]):
            tap.skip(f"{tool[0]} is not installed")
            continue
        failed = sum(subprocess.run(tool, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode != 0
                     for _ in range(20))
        tap.ok(failed == 0, f"{tool[0]} reads it at any moment")
    farm.delete(f"/v1/jobs/{job}")
    farm.wait_job(job, "cancelled", 30)
    tap.ok(farm.cli("digest", str(path), check=False).returncode == 0, "a cancelled job leaves its best image")
sys.exit(tap.done())
