"""Rows of kernels on a GPU: what is asked for, and launches on its simulator."""

from __future__ import annotations

import os
import subprocess
import sys
from types import SimpleNamespace

import pytest
from numba import config

from contiga.arrays import device
from contiga.errors import MissingPackageError, RunError

IN_THE_SIMULATOR = """
import numpy as np
from contiga.arrays.device import THREADS, check_device, launch, on_host, resident
from contiga.records import empty_projection


def row(given, factor, out, k):
    out[k, 0] += factor[0] * given.gap[k]
    out[k, 1] += k


check_device()
n = 2 * THREADS + 3
feet = empty_projection(n)
for part in feet:
    part[:] = 1
there = resident(feet)
assert type(there) is not type(feet) and there._fields == feet._fields
assert type(resident(feet)) is type(there)  # kernels are compiled once for it
for own, other in zip(on_host(there), feet, strict=True):
    np.testing.assert_array_equal(own, other)
    assert own.dtype == other.dtype
feet.gap[:] = 2.0
out = resident(np.zeros((n + 1, 2)))
launch(row, n, there, resident(np.array([3.0])), out)
found = on_host(out)
np.testing.assert_array_equal(found[:n], np.stack([np.full(n, 3.0), np.arange(n)], axis=1))
np.testing.assert_array_equal(found[n], 0.0)
launch(row, 0, there, there, out)
pair = on_host(resident((np.arange(3), (np.zeros(0), np.ones((2, 2), np.int8)))))
assert type(pair) is tuple and pair[1][0].shape == (0,) and pair[1][1].dtype == np.int8
print("done")
"""


def test_rows_are_each_done_once_and_records_come_back_as_they_went() -> None:
    run = subprocess.run(
        [sys.executable, "-c", IN_THE_SIMULATOR],
        env=dict(os.environ) | {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
    )
    assert run.stdout == "done\n", run.stderr


def without_simulator(patch: pytest.MonkeyPatch, cuda: object) -> None:
    patch.setattr(config, "ENABLE_CUDASIM", 0)
    patch.setattr(device, "cuda", cuda)


@pytest.mark.parametrize("cuda", [None, SimpleNamespace(implementation="Built-in")])
def test_the_package_that_is_needed_is_named(monkeypatch: pytest.MonkeyPatch, cuda: object) -> None:
    without_simulator(monkeypatch, cuda)
    with pytest.raises(MissingPackageError, match=r"need numba-cuda.*pip install \"numba-cuda"):
        device.check_device()


def test_a_machine_without_a_gpu_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    there = SimpleNamespace(implementation="NVIDIA", is_available=lambda: False)
    without_simulator(monkeypatch, there)
    with pytest.raises(RunError, match="none was found"):
        device.check_device()
    there.is_available = lambda: True
    device.check_device()


def test_the_simulator_is_refused_where_kernels_are_compiled(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(config, "ENABLE_CUDASIM", 1)
    monkeypatch.setattr(config, "DISABLE_JIT", 0)
    with pytest.raises(RunError, match="NUMBA_DISABLE_JIT=1"):
        device.check_device()
