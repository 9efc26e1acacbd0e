"""Memory that is given back stays in the process."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

FAULTS = """
import resource
import numpy as np
{first}
def steps(count):
    for _ in range(count):
        [np.ones(40_000) for _ in range(12)]
steps(3)
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
steps(20)
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""
KEPT = "from contiga.num.heap import keep_freed; keep_freed()"


def _pages_asked_for(first: str) -> int:
    """Pages that 20 times a dozen arrays of 320 kB make a new process ask for."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("MALLOC_")}
    code = FAULTS.format(first=first)
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    return int(ran.stdout)


@pytest.mark.skipif(
    platform.libc_ver()[0] != "glibc", reason="other libraries keep by their own rules"
)
def test_arrays_that_come_again_cost_no_new_pages() -> None:
    assert _pages_asked_for("import contiga.num.threads") < 200
    assert _pages_asked_for(KEPT) < 200
