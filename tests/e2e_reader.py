"""Always openable: whoever opens the EXR at any moment finds it whole (P6). SPDX-License-Identifier: MIT"""

import os
import shutil
import subprocess

import farm

OPENS, AT_ONCE = 1000, 25


def test(f, t):
    f.start_server("--tile", "32", "--image-interval", "0")
    f.start_worker("--threads", "1")
    job = f.submit(farm.scene("cornell-box.json", 200, 150, spp=1 << 20))
    path = os.path.join(f.state, "jobs", job, "image.exr")
    f.wait_for("a first image", lambda: os.path.exists(path))
    bad, images = 0, set()
    for _ in range(OPENS // AT_ONCE):
        # The OpenEXR library opens the file, decodes every pixel; the CLI hashes them.
        result = f.run("digest", *[path] * AT_ONCE)
        bad += result.returncode != 0
        images |= {line.split()[0] for line in result.stdout.splitlines()}
    t.equal(bad, 0, f"{OPENS} opens while the file is being replaced")
    t.ok(len(images) > 3, f"{len(images)} different images were seen")
    t.equal(f.job(job)["state"], "running", "the job was running all the time")
    for tool in (["exrheader"], ["oiiotool", "--stats"]):
        if not shutil.which(tool[0]):
            t.skip(f"{tool[0]} reads it at any moment", "not installed")
            continue
        failed = sum(subprocess.run([*tool, path], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                    check=False).returncode != 0 for _ in range(20))
        t.equal(failed, 0, f"{tool[0]} reads it at any moment")
    t.equal(f.call("DELETE", f"/v1/jobs/{job}").status, 200, "the job is cancelled")
    t.equal(f.run("digest", path).returncode, 0, "and leaves its best image")


farm.main(test)
