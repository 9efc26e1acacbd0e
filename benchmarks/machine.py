"""What the machine is, and what one of its cores can do: bytes and operations a second."""

from __future__ import annotations

import os
import platform
from functools import partial
from importlib.metadata import version
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from numba import njit

from benchmarks.sizes import Sizes
from benchmarks.timing import in_turns
from contiga.arrays.kernels.fma_nb import fma
from contiga.arrays.threads import thread_count

LANES = 64
CHAIN = 16
ROUNDS = 40


def _triad(a: np.ndarray, b: np.ndarray, c: np.ndarray, start: int, stop: int) -> None:
    for i in range(start, stop):
        c[i] = a[i] + 3.0 * b[i]


def _apart(x: np.ndarray, start: int, stop: int) -> None:
    """`CHAIN` · `ROUNDS` products and sums of each number; a row of `LANES` stays in the cache."""
    for i in range(start, stop):
        for _ in range(ROUNDS):
            for k in range(LANES):
                value = x[i, k]
                for _ in range(CHAIN):
                    value = value * 0.999 + 1e-3
                x[i, k] = value


def _fused(x: np.ndarray, start: int, stop: int) -> None:
    """As `_apart`, both in one instruction, as contiga's kernels write it."""
    for i in range(start, stop):
        for _ in range(ROUNDS):
            for k in range(LANES):
                value = x[i, k]
                for _ in range(CHAIN):
                    value = fma(value, 0.999, 1e-3)
                x[i, k] = value


def limits(size: Sizes) -> dict[str, float]:
    """Gigabytes and billions of operations in a second of one core's processor time.

    A product and a sum are two operations, "apart" in two instructions or "fused" in one.
    """
    triad = njit(nogil=True)(_triad)
    products = {"apart": njit(nogil=True)(_apart), "fused": njit(nogil=True)(_fused)}
    n = size.stream
    a, b, c = (np.full(n, x) for x in (1.0, 2.0, 0.0))
    rows = np.ones((max(n // 10_000, 16), LANES))
    works = {"gigabytes": lambda _: triad(a, b, c, 0, n)}
    for name, kernel in products.items():
        works[name] = partial(_run, kernel, rows)
    seconds = in_turns(works, size.rounds, process_time)
    amount = {"gigabytes": 24.0 * n} | dict.fromkeys(products, 2.0 * CHAIN * ROUNDS * rows.size)
    return {name: 1e-9 * amount[name] / t for name, t in seconds.items()}


def _run(kernel: Any, rows: np.ndarray, _: int) -> None:
    kernel(rows, 0, len(rows))


def described() -> dict[str, Any]:
    """Processor, cores, memory and versions."""
    lines = Path("/proc/cpuinfo")
    names = lines.read_text(encoding="utf-8").splitlines() if lines.is_file() else []
    model = next((x.partition(":")[2].strip() for x in names if x.startswith("model name")), "")
    return {
        "processor": model or platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "threads": thread_count(),
        "load": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
        "python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "numba", "scipy")},
    }
