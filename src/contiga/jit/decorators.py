"""Decorators that turn a Python function into a kernel.

A `kernel` is called from Python, an `inner` one only from kernels: it is linked into its callers,
or compiled once and called. All are cached in files (`cache`), have one version (`dispatcher`) and
count references only to arrays that they allocate (`reference_counts`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contiga.jit import reference as reference  # the types of tuples of tables
from contiga.jit.dispatcher import decorator
from contiga.jit.pipeline import CalledCompiler, InnerCompiler, KernelCompiler

Decorator = Callable[[Any], Any]


def kernel(linked: bool = False, **options: Any) -> Decorator:
    """Return a decorator of kernels that Python calls, on any thread: they release the GIL.

    A kernel that other kernels also call very often is better `linked` into them.
    """
    return decorator(KernelCompiler if linked else CalledCompiler, nogil=True, **options)


def inner(linked: bool = True, **options: Any) -> Decorator:
    """Return a decorator of kernels that only kernels call.

    Without the wrapper for calls from Python they compile a fifth faster. A call from Python would
    crash; a test checks that there is none.

    Their code becomes part of that of their callers. A kernel that is not `linked` is compiled once
    and called, and its callers need not be optimised with its code in them: for work that takes
    longer than a call (some nanoseconds) and is a part of several kernels, or a large part of one.
    """
    compiler = InnerCompiler if linked else CalledCompiler
    return decorator(compiler, no_cpython_wrapper=True, **options)


def straight(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel's entry for frequent calls, which does not check its arguments.

    Dispatching checks the type of every array that a call passes: for the tables of a body and a
    few arrays this takes 8 µs, and the call itself 1 µs. The caller must have checked the types:
    arrays of other types would be read as those that the kernel was compiled for. All arguments are
    positional. Until the kernel has its one version it is called as usual.
    """
    entries: tuple[Callable[..., Any], ...] = getattr(function, "entries", ())
    return entries[0] if len(entries) == 1 else function


def inlined(**options: Any) -> Decorator:
    """Return a decorator of small kernels that LLVM inlines in their callers.

    numba's own ``inline="always"`` copies their source into each caller and infers all types again:
    the two kernels of crossings took 12 s to compile that way.
    """
    return inner(forceinline=True, **options)
