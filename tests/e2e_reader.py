"""Always openable: whoever opens the EXR at any moment finds it whole (P6). SPDX-License-Identifier: MIT"""

import os
import shutil
import subprocess

import farm

OPENS, AT_ONCE, IMAGES = 1000, 25, 8


def test(f, t):
    f.start_server("--tile", "32", "--image-interval", "0")
    f.start_worker("--threads", "1")
    job = f.submit(farm.scene("cornell-box.json", 200, 150, spp=1 << 20))
    path = os.path.join(f.state, "jobs", job, "image.exr")
    f.wait_for("a first image", lambda: os.path.exists(path))
    bad, opens, images = 0, 0, set()

    def look():
        # The OpenEXR library opens the file and decodes every pixel; the CLI hashes them.
        nonlocal bad, opens
        result = f.run("digest", *[path] * AT_ONCE)
        opens += AT_ONCE
        bad += result.returncode != 0
        images.update(line.split()[0] for line in result.stdout.splitlines())
        return opens >= OPENS and len(images) >= IMAGES

    f.wait_for("enough opens and images", look, 120)
    t.equal(bad, 0, f"{opens} opens while {len(images)} images replaced each other")
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
