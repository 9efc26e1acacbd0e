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


def started(folder, seed=0, threads=1, **environment):
    """Start ``bits.py`` with some environment, compiled kernels kept in `folder`."""
    env = {k: v for k, v in os.environ.items() if k != "NUMBA_DISABLE_JIT"}
    env |= {"NUMBA_CACHE_DIR": str(folder), "NUMBA_NUM_THREADS": str(threads)} | environment
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
def compiled(tmp_path_factory):
    """What kernels give that were compiled in the process: the machine's own, and narrower ones.

    Beside one another, since both take minutes to compile. With the folder of the machine's own.
    """
    own, narrow = tmp_path_factory.mktemp("own"), tmp_path_factory.mktemp("narrow")
    both = [started(own)]
    if platform.machine() in ("x86_64", "AMD64"):
        both.append(started(narrow, **V3))
    return own, *(ended(process) for process in both)


@pytest.mark.slow
def test_from_the_cache_the_bits_are_those_of_the_first_time(compiled):
    folder, fresh, *_ = compiled
    assert ended(started(folder)) == fresh


@pytest.mark.slow
def test_on_two_threads_the_bits_are_those_of_one(compiled):
    folder, fresh, *_ = compiled
    assert ended(started(folder, threads=2)) == fresh


@pytest.mark.slow
def test_in_another_order_every_point_has_the_same_bits(compiled):
    """Sums over points, and those of facets at a node, are taken in the order of the slave."""
    folder, fresh, *_ = compiled
    other = ended(started(folder, seed=5))
    assert other.pop("sums over points") != ""
    assert other == {name: fresh[name] for name in other}


@pytest.mark.slow
def test_for_narrower_vectors_the_bits_are_the_same(compiled):
    _, fresh, *narrow = compiled
    if not narrow:
        pytest.skip("the names of processors are those of x86-64")
    assert narrow == [fresh]
