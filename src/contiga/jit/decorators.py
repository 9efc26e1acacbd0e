"""Decorators that turn a Python function into a kernel.

What Python calls is a `kernel`, what only kernels call is an `inner` one: put into its callers, or
compiled once and called. All are kept in files (`cache`), have one version (`dispatcher`) and count
references only to arrays that they make (`uncounted`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contiga.jit import reference as reference  # the types of tuples of tables
from contiga.jit.dispatcher import decorator
from contiga.jit.pipeline import CalledCompiler, InnerCompiler, KernelCompiler

Decorator = Callable[[Any], Any]


def kernel(linked: bool = False, **options: Any) -> Decorator:
    """Decorator of kernels that Python calls, on any thread.

    What kernels call as well, all the time, is better `linked` into them.
    """
    return decorator(KernelCompiler if linked else CalledCompiler, nogil=True, **options)


def inner(linked: bool = True, **options: Any) -> Decorator:
    """Decorator of kernels that only kernels call.

    Without what a call from Python needs, they compile a fifth faster. Called from Python they
    would crash; a test sees to it that none is.

    Their code is put into that of their callers. What is not `linked` is compiled once and called,
    and none of its callers has to be optimised with its code in it: for what takes longer than a
    call (some nanoseconds) and is a part of several kernels, or a large part of one.
    """
    made_by = InnerCompiler if linked else CalledCompiler
    return decorator(made_by, no_cpython_wrapper=True, **options)


def straight(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel's entry for frequent calls, which does not check its arguments.

    Dispatching looks at the type of every array that a call hands over: of the tables of a body and
    a few arrays 8 µs, where the call itself takes one. So a caller hands it what it has looked at
    itself: arrays of other types would be taken for those it was compiled for. All arguments are
    given by their places. Until the kernel has its one version it is called as any other.
    """
    entries: tuple[Callable[..., Any], ...] = getattr(function, "entries", ())
    return entries[0] if len(entries) == 1 else function


def inlined(**options: Any) -> Decorator:
    """Decorator of a few lines that LLVM puts in place of their calls, whatever their size.

    numba's own ``inline="always"`` copies their text into each caller, anew and with all types to
    be found: the two kernels of crossings took 12 s to compile that way.
    """
    return inner(forceinline=True, **options)
