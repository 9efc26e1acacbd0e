"""The same bits: fresh or cached, one thread or two, in any order, for any processor's vectors."""

from __future__ import annotations

import json
import os
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


@pytest.fixture(scope="module")
def bits(tmp_path_factory):
    """Runs ``bits.py`` with some environment; all runs share one folder for compiled kernels."""
    folder = tmp_path_factory.mktemp("kernels")

    def run(seed=0, threads=1, **environment):
        env = {k: v for k, v in os.environ.items() if k != "NUMBA_DISABLE_JIT"}
        env |= {"NUMBA_CACHE_DIR": str(folder), "NUMBA_NUM_THREADS": str(threads)} | environment
        script = Path(__file__).with_name("bits.py")
        command = [sys.executable, "-W", "ignore", str(script), str(seed)]
        done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="module")
def fresh(bits):
    """What kernels give that were compiled in the process."""
    return bits()


@pytest.mark.slow
def test_from_the_cache_the_bits_are_those_of_the_first_time(bits, fresh):
    assert bits() == fresh


@pytest.mark.slow
def test_on_two_threads_the_bits_are_those_of_one(bits, fresh):
    assert bits(threads=2) == fresh


@pytest.mark.slow
def test_in_another_order_every_point_has_the_same_bits(bits, fresh):
    """Sums over points, and those of facets at a node, are taken in the order of the slave."""
    other = bits(seed=5)
    assert other.pop("sums over points") != ""
    assert other == {name: fresh[name] for name in other}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="names of processors are those of x86-64")
def test_for_narrower_vectors_the_bits_are_the_same(bits, fresh):
    import platform

    if platform.machine() not in ("x86_64", "AMD64"):
        pytest.skip("not a x86-64 machine")
    assert bits(**V3) == fresh
