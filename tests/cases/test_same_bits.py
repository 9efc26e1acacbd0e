"""The same bits: fresh or cached, one thread or two, in any order, for any processor's vectors."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

# The third level of x86-64 (AVX2 and fused multiply-adds), whatever more the machine has.
V3 = {
    "NUMBA_CPU_NAME": "x86-64-v3",
    "NUMBA_CPU_FEATURES": "+avx,+avx2,+bmi,+bmi2,+cx16,+f16c,+fma,+lzcnt,+movbe,+popcnt,+sahf,"
    "+sse3,+sse4.1,+sse4.2,+ssse3",
    "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
    "OPENBLAS_CORETYPE": "Haswell",
}


def started(folder=None, seed=0, threads=1, **environment):
    """Start ``bits.py`` with some environment, compiled kernels kept in `folder` or as ever."""
    env = {k: v for k, v in os.environ.items() if k != "NUMBA_DISABLE_JIT"}
    env |= {"NUMBA_NUM_THREADS": str(threads)} | environment
    if folder is not None:
        env["NUMBA_CACHE_DIR"] = str(folder)
    script = Path(__file__).with_name("bits.py")
    command = [sys.executable, "-W", "ignore", str(script), str(seed)]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, env=env, stdout=pipe, stderr=pipe, text=True)


def ended(process):
    """The hashes it printed."""
    out, errors = process.communicate()
    assert process.returncode == 0, errors
    return json.loads(out)


@pytest.fixture(scope="module")
def narrow():
    """Narrower vectors than the machine's own, where their names are known."""
    return V3 if platform.machine() in ("x86_64", "AMD64") else {}


@pytest.fixture(scope="module")
def kept():
    """What kernels give that are kept where runs keep them, for the vectors of this machine."""
    return ended(started())


@pytest.mark.full
def test_compiled_just_now_and_for_narrower_vectors_the_bits_are_the_same(kept, narrow, tmp_path):
    """Twice: all kernels compiled anew, and taken from the files."""
    for _ in range(2):
        assert ended(started(tmp_path, **narrow)) == kept


def test_on_two_threads_the_bits_are_those_of_one(kept):
    assert ended(started(threads=2)) == kept


def test_in_another_order_every_point_has_the_same_bits(kept):
    """Sums over points, and those of facets at a node, are taken in the order of the slave."""
    other = ended(started(seed=5))
    assert other.pop("sums over points") != ""
    assert other == {name: kept[name] for name in other}
