"""bench_farm: what the farm costs beside one process, and how it scales.

One job (Cornell box, 512 x 512, 256 spp) three ways, in turn, several times: one process with two threads and no
network (tool_local); a coordinator with two workers of one thread; a coordinator with one. CPU is user and system time of
every process of the way, start to end. Ratios are formed inside a round and their medians quoted, because the machine may be shared.
Last line: "bench-farm: CPU ratio X, throughput ratio Y". SPDX-License-Identifier: MIT
"""

import os
import resource
import statistics
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests"))
import farm  # pylint: disable=wrong-import-position

ROUNDS = int(os.environ.get("ROUNDS", "3"))
SCENE = farm.scene("cornell-box.json", 512, 512, spp=int(os.environ.get("SPP", "256")))


def cpu():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def with_farm(workers):
    """CPU seconds, seconds from first lease to last merge, digest."""
    before = cpu()
    with farm.Farm() as f:
        f.start_server()
        for _ in range(workers):
            f.start_worker("--threads", "1")
        job = f.done(f.submit(SCENE), 3600)
        f.stop()
    return cpu() - before, job["elapsed_seconds"], job["image"]["digest"]


def alone():
    before = cpu()
    digest = farm.local_digest(SCENE, threads=2)
    return cpu() - before, digest


cpu_ratios, speed_ratios = [], []
for i in range(ROUNDS):
    one_cpu, reference = alone()
    two_cpu, two_seconds, two_digest = with_farm(2)
    _, single_seconds, single_digest = with_farm(1)
    if not reference == two_digest == single_digest:
        sys.exit("bench-farm: digests differ")
    cpu_ratios.append(two_cpu / one_cpu)
    speed_ratios.append(single_seconds / two_seconds)
    print(f"round {i + 1}: one process {one_cpu:.1f} CPU s; two workers {two_cpu:.1f} CPU s, {two_seconds:.1f} s; "
          f"one worker {single_seconds:.1f} s", flush=True)
print(f"bench-farm: CPU ratio {statistics.median(cpu_ratios):.3f}, "
      f"throughput ratio {statistics.median(speed_ratios):.2f}")
