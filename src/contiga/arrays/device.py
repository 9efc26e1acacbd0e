"""Rows of kernels on a GPU, one thread a row, and records whose arrays live there.

The CUDA target of numba compiles the unchanged source of the CPU's kernels. Kernels there cannot
follow the pointers of `contiga.pointer_records`: on the device the same members are in a plain
named tuple, which is unpacked into arguments.

`check_device` names missing requirements. The simulator (``NUMBA_ENABLE_CUDASIM=1``) runs threads,
and all that they call, as Python (``NUMBA_DISABLE_JIT=1``).
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from functools import cache
from math import ceil
from typing import Any

from numba import config

from contiga.errors import MissingPackageError, RunError

try:
    from numba import cuda
except ImportError:  # numba is to lose its own target
    cuda = None

THREADS = 64
"""Threads of a block. On an H200 128 take 1.05 to 1.1 times as long for tracked points, 256 1.2."""


def check_device() -> None:
    """Raise an error if kernels cannot be launched on a GPU, or on the simulator if that is set.

    Raises
    ------
    MissingPackageError
        numba-cuda is not installed. It replaces numba's built-in target, which is no longer
        maintained: in 0.68 it does not compile ``max``.
    RunError
        There is no GPU, or the simulator is set without NUMBA_DISABLE_JIT.
    """
    if cuda is not None and config.ENABLE_CUDASIM:
        if not config.DISABLE_JIT:
            raise RunError(
                "the simulator of CUDA runs kernels as Python: set NUMBA_DISABLE_JIT=1 beside "
                "NUMBA_ENABLE_CUDASIM=1"
            )
        return
    if getattr(cuda, "implementation", "") != "NVIDIA":
        raise MissingPackageError(
            "kernels on a GPU need numba-cuda, which is not installed. Install it with: "
            'pip install "numba-cuda[cu12]" (or cu13, as the driver has it)'
        )
    if not cuda.is_available():
        raise RunError("kernels on a GPU need one from NVIDIA with its driver; none was found")


def launch(row: Callable[..., None], n: int, *arguments: Any) -> None:
    """Start ``row(*arguments, k)`` for k = 0 … n − 1 on the GPU, each in a thread, in no order.

    It does not wait for the threads; copies of `on_host` do. Arguments are `resident` records and
    arrays, or tuples of them. The kernel of a `row` is compiled at its first launch and kept.
    """
    if n:
        _threads_of(row)[ceil(n / THREADS), THREADS](n, arguments)


@cache
def _threads_of(row: Callable[..., None]) -> Any:
    """Return the CUDA kernel that calls `row` in each thread."""

    @cuda.jit
    def thread(n, arguments):  # type: ignore[no-untyped-def]
        k = cuda.grid(1)
        if k < n:
            row(*arguments, k)

    return thread


def resident(record: Any) -> Any:
    """Return copies on the device of an array, or of all arrays in nested (named) tuples.

    Named tuples become plain named tuples of the same fields. Arrays that are on the device already
    are not copied.
    """
    if isinstance(record, tuple):
        return _like(record, map(resident, record))
    if hasattr(record, "copy_to_host"):
        return record
    return cuda.as_cuda_array(record) if is_resident(record) else cuda.to_device(record)


def is_resident(array: Any) -> bool:
    """Return whether an array is on the device already, by numba or another library."""
    return hasattr(array, "copy_to_host") or hasattr(array, "__cuda_array_interface__")


def on_host(record: Any) -> Any:
    """Return copies on the host of `resident` arrays, in plain tuples nested as `record`."""
    if isinstance(record, tuple):
        return _like(record, map(on_host, record))
    return record.copy_to_host()


def _like(record: Any, members: Any) -> Any:
    """Return a tuple of `members`, with the fields of `record` if it is a named tuple."""
    fields = getattr(record, "_fields", None)
    return tuple(members) if fields is None else _plain(type(record).__name__, fields)(*members)


@cache
def _plain(name: str, fields: tuple[str, ...]) -> Any:
    """Return the one named tuple of these fields, so that kernels are compiled once for it."""
    return namedtuple(name, fields)
