"""cpu.py - renders in a process of one thread, and the CPU seconds they take.

CPU is user and system time of the process by wait4. What a render costs beside its samples (start, reading, building
the tree, writing) is taken away by measuring twice: a render of `more` samples per pixel minus one of `few`.
SPDX-License-Identifier: MIT
"""

import os
import subprocess
import sys


def of(argv):
    """CPU seconds and output of a program; its failure is ours."""
    with subprocess.Popen(argv, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE) as process:
        output = process.stdout.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{argv[0]} ended with status {process.returncode}")
    return used.ru_utime + used.ru_stime, output.decode().strip()


def of_samples(tool, few, more, image):
    """CPU seconds of the samples that the document `more` has beyond `few`, and the image's digest."""
    fixed, _ = of([tool, few, image])
    whole, digest = of([tool, more, image])
    return whole - fixed, digest
