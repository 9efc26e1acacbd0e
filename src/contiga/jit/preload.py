"""Loading of cached kernels ahead of their first call, in idle time."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from contiga.jit.cache import KernelCache


def preload(kernels: Iterable[Any]) -> int:
    """Load the installed or cached versions of `kernels`; return their number.

    Kernels without one are left to their first call; nothing is compiled but a version whose file
    cannot be read. Without a compiler (``NUMBA_DISABLE_JIT``) there is nothing to load.
    """
    loaded = 0
    for kernel in kernels:
        for signature in _cached_signatures(kernel):
            kernel.compile(signature)
            loaded += 1
    return loaded


def is_missing(kernel: Any) -> bool:
    """Return whether a kernel would have to be compiled: no version is loaded, installed or cached.

    False without a compiler.
    """
    is_cached = getattr(kernel, "_cache", None) is not None
    return is_cached and not (kernel.overloads or _cached_signatures(kernel))


def _cached_signatures(kernel: Any) -> list[Any]:
    """Return the signatures of a kernel that are installed or cached, but not loaded."""
    cache = getattr(kernel, "_cache", None)
    if cache is None:
        return []
    kernel.targetctx.refresh()  # the order in which numba's own loading does it
    signatures: list[Any] = []
    if isinstance(cache, KernelCache):
        signatures = cache.prebuilt_signatures(kernel.targetctx)
    if not signatures and getattr(cache, "_enabled", False):
        codegen, files = kernel.targetctx.codegen(), cache._cache_file
        signatures = [
            key[0]
            for key, name in files._load_index().items()
            if key == cache._index_key(key[0], codegen) and Path(files._data_path(name)).is_file()
        ]
    return [signature for signature in signatures if signature not in kernel.overloads]
