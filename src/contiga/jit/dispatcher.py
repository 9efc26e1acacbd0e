"""Dispatchers of kernels with one version each, cached in files.

numba compiles a version for each width of an integer, and for each value if that is a constant.
Between kernels all integers are 64 bits here, so that a first run compiles each kernel once.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

from numba import config
from numba.core import types as numba_types
from numba.core.registry import CPUDispatcher

from contiga.jit.cache import KernelCache
from contiga.jit.libraries import CALLED
from contiga.jit.pipeline import CalledCompiler, KernelCompiler
from contiga.jit.stamps import stamp_at_import

types: Any = numba_types


class KernelDispatcher(CPUDispatcher):  # type: ignore[misc]
    """A kernel with one version for calls from kernels, for any integer types."""

    entries: tuple[Callable[..., Any], ...] = ()
    """Its versions as calls without checks of arguments: see `contiga.jit.straight`."""

    def enable_caching(self) -> None:
        """Enable the cache; its files are located at the first read or write.

        Most kernels of an import are not called in a process. The stamp of the sources is that of
        now, at import.
        """
        stamp_at_import(self.py_func)
        self.__dict__.pop("_cache", None)

    @cached_property
    def _cache(self) -> Any:
        return KernelCache(self.py_func)

    def compile(self, signature: Any) -> Any:
        """Return a version, read from the cache or compiled; its lock is released in any case."""
        try:
            return super().compile(signature)
        finally:
            if isinstance(self._cache, KernelCache):  # not from a pickle
                self._cache.done(signature)

    def known_as(self, arguments: Any) -> str:
        """Return the name by which callers link a version, after it is read or compiled."""
        self.compile(arguments)
        return str(self.overloads[arguments].fndesc.mangled_name)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return numba's template for the types of a call between kernels, by `kernel_type`."""
        args = tuple(kernel_type(kind) for kind in args)
        return super().get_call_template(args, {name: kernel_type(kws[name]) for name in kws})

    def add_overload(self, compiled: Any) -> None:
        """Register a version in `entries`, and in `CALLED` if callers call it by name."""
        super().add_overload(compiled)
        self.entries = *self.entries, compiled.entry_point
        if issubclass(self._compiler.pipeline_class, CalledCompiler):
            name, arguments = compiled.fndesc.mangled_name, tuple(compiled.signature.args)
            home = self.py_func.__module__, self.py_func.__qualname__
            CALLED[name] = (name, *home, arguments)


def kernel_type(kind: Any) -> Any:
    """Return the argument type that stands for a type in kernels.

    Shorter integers are int64, literals their type, also in tuples; all others are themselves.
    """
    kind = types.unliteral(kind)
    if isinstance(kind, types.Integer) and kind.bitwidth < types.int64.bitwidth:
        return types.int64
    if isinstance(kind, (types.Tuple, types.UniTuple)):
        return types.BaseTuple.from_types([kernel_type(part) for part in kind])
    return kind


def decorator(
    compiler: type[KernelCompiler],
    kind: type[KernelDispatcher] = KernelDispatcher,
    pipeline_class: Any = None,
    **options: Any,
) -> Callable[[Any], Any]:
    """Return a decorator of cached kernels of a compiler; options are numba's.

    With ``NUMBA_DISABLE_JIT`` it returns functions as they are. By default quotients by zero are
    infinite or NaN and raise nothing. A kernel without this option would take it, and with it its
    name, from the first kernel that calls it.
    """
    target_options = {"nopython": True, "no_cfunc_wrapper": True, "error_model": "numpy"} | options

    def decorate(function: Any) -> Any:
        if config.DISABLE_JIT:
            return function
        dispatcher = kind(
            function, targetoptions=dict(target_options), pipeline_class=pipeline_class or compiler
        )
        dispatcher.enable_caching()
        return dispatcher

    return decorate
