"""Layers through the whole line: any farm gives the same ones, the file has them, the image is the same without.

SPDX-License-Identifier: MIT
"""

import subprocess

import farm

ALL = {"layers": ["albedo", "normal", "depth", "position", "material"], "bounces": 2}
CHANNELS = ["A", "B", "G", "R", "Z"] + [f"{name}.{c}" for name in
    ("albedo", "bounce0", "bounce1", "error") for c in "BGR"] + ["material"] + [f"normal.{c}" for c in "XYZ"] + [
    f"position.{c}" for c in "XYZ"] + [f"rest.{c}" for c in "BGR"] + ["samples"]


def document(spp=24, **film):
    d = farm.scene("glass-and-metal.json", 60, 44, spp=spp)
    d["film"].update(film)
    return d


def render(f, workers, tile, doc):
    """Returns the image's digest and its path."""
    f.start_server("--tile", str(tile))
    for _ in range(workers):
        f.start_worker()
    job = f.submit(doc)
    digest = f.done(job)["image"]["digest"]
    path = f"{f.dir}/{job}.exr"
    with open(path, "wb") as file:
        file.write(f.call("GET", f"/v1/jobs/{job}/image.exr").body)
    return digest, path


def header(path):
    return subprocess.run(["exrheader", path], capture_output=True, text=True, check=True).stdout


def the_file(t):
    """Two jobs of one farm, with layers and without."""
    with farm.Farm() as f, farm.Farm() as other:
        digest, path = render(f, 1, 64, document(**ALL))
        _, plain = render(other, 1, 64, document())
        t.ok(all(f"    {c}, " in header(path) for c in CHANNELS), "the file has the layers that were asked for", header(path))
        t.ok("bounce0" not in header(plain) and "    Z, " not in header(plain), "and no others")
        same = subprocess.run(["oiiotool", path, "--ch", "R,G,B,A", plain, "--ch", "R,G,B,A", "--fail", "0", "--hardfail", "0",
                               "--diff"], capture_output=True, text=True, check=False)
        t.ok("PASS" in same.stdout, "without layers the colour is the same", same.stdout, same.stderr)
        t.equal(f.run("digest", path).stdout.split()[0], digest, "smalti digest reads the same from the file")
    return digest


def restart(t):
    """The coordinator is killed half way: layers come back from the film on disk."""
    doc = document(spp=160, **ALL)
    with farm.Farm() as f:
        server = f.start_server("--tile", "16", "--checkpoint", "0.1")
        f.start_worker("--threads", "1")
        job = f.submit(doc)
        f.wait_for("some passes", lambda: f.job(job)["samples"] > 60 * 44 * 40)
        server.kill()
        f.start_server("--tile", "16")
        t.ok("recovered samples=" in f.server.log(), "its film was on disk")
        t.equal(f.done(job)["image"]["digest"], farm.local_digest(doc), "after kill -9 of the coordinator the same layers")


def test(_, t):
    digest = the_file(t)
    for workers, tile in ((3, 16), (2, 40)):
        with farm.Farm() as f:
            t.equal(render(f, workers, tile, document(**ALL))[0], digest,
                    f"{workers} workers, tiles of {tile} px: the same layers")
    t.equal(farm.local_digest(document(**ALL)), digest, "one process gives the same layers")
    restart(t)


farm.main(test)
