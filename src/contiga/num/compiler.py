"""How kernels are compiled: each once, in one version.

What is to be compiled is compiled by one process at a time; others wait for it and read it. Locks
are by kernel and types: as kernels call each other in no circle, neither can processes that wait.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import cache, cached_property
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Protocol

from numba import njit
from numba.core import event
from numba.core import types as numba_types
from numba.core.bytecode import FunctionIdentity
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, DefaultPassBuilder
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import NoPythonSupportedFeatureValidation
from numba.core.typing.templates import _OverloadFunctionTemplate
from numba.core.untyped_passes import ExtractByteCode
from numba.extending import overload
from numba.np import arrayobj, linalg

from contiga.num import lean as lean  # numba, without what it does for nothing
from contiga.num.libraries import CalledLibrary, LinkedLibrary, module_of
from contiga.num.locks import alone
from contiga.num.passes import LEAN
from contiga.num.resident import types_read
from contiga.num.stamps import stamp_at_import
from contiga.num.uncounted import Uncounted

types: Any = numba_types
DIGITS = 12
PLACE_IN_MEMORY = re.compile(r"\b0x[0-9a-f]+")
"""In the names of types of functions: another process has another."""
LOCAL = "<locals>"
"""In the names of functions made in functions: there may be several of one name."""
Call = tuple[str, str, str, Any]
"""(Name of a function, its module, its kernel, types of its arguments)."""
CALLED: dict[str, Call] = {}
"""Where a function that is called by name comes from."""


class Company(Protocol):
    """Others who compile, too. They are told of a kernel by its module, its name and the types of
    its arguments."""

    def before(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """It is needed and not kept, and will be compiled unless it is kept after this."""

    def after(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """It is kept, or cannot be compiled."""


COMPANY: list[Company] = []
"""Of this process."""


class KernelCompiler(Compiler):  # type: ignore[misc]
    """numba's compiler, for kernels that Python calls, linked into the kernels that do."""

    state: Any
    library: type[JITCodeLibrary] | None = None
    uncounted = True

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *rest: Any) -> None:
        if library is None and self.library is not None:
            library = self.library(targetctx.codegen(), self.library.__name__)
            library.enable_object_caching()
        super().__init__(typingctx, targetctx, library, *rest)

    def compile_extra(self, func: Any) -> Any:
        """Compile a Python function."""
        with _short_message(), _linked_overloads():
            return super().compile_extra(func)

    def define_pipelines(self) -> list[Any]:
        """numba's passes that have something to do, and one that looks whether references are to be
        counted."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        if self.uncounted:
            passes.add_pass_after(Uncounted, NoPythonSupportedFeatureValidation)
        passes.passes = [(LEAN.get(one, one), why) for one, why in passes.passes]
        passes._ENFORCING = False  # what is known of variables, after each pass: see `passes`
        passes.finalize()
        return [passes]


class InnerCompiler(KernelCompiler):
    """The same, with a library that is linked and not run."""

    library = LinkedLibrary


class OverloadCompiler(InnerCompiler):
    """The same for what numba has as Python, which may count references by hand."""

    uncounted = False


@contextmanager
def _linked_overloads() -> Iterator[None]:
    """Within this, what numba has of its own as Python is compiled to be linked, and not to run.

    It would be optimised by itself, and get a way in from C.
    """
    asked = getattr(_OverloadFunctionTemplate, "_get_jit_decorator", None)
    if asked is None:  # a numba to come does it elsewhere
        yield
        return

    def decorated(self: Any) -> Any:
        jit = asked(self)
        own = {"pipeline_class": OverloadCompiler, "no_cfunc_wrapper": True}
        return lambda **options: jit(**(options | own))

    _OverloadFunctionTemplate._get_jit_decorator = decorated
    try:
        yield
    finally:
        _OverloadFunctionTemplate._get_jit_decorator = asked


class CalledCompiler(KernelCompiler):
    """The same, with a library that is called."""

    library = CalledLibrary

    def compile_extra(self, func: Any) -> Any:
        """Compile a Python function, under a name that is the same in every process."""
        known = self.state.func_id = FunctionIdentity.from_function(func)
        if LOCAL not in known.func_qualname:
            known.unique_id = int(stamp_at_import(func)[:DIGITS], 16)
            known.unique_name = f"{known.func_qualname}${known.unique_id}"
        ExtractByteCode().run_pass(self.state)
        self.state.lifted = ()
        self.state.lifted_from = None
        with _short_message(), _linked_overloads():
            return self._compile_bytecode()


def _shapes_differ(source: Any, target: Any) -> None:
    """Raise the error of an array that does not fit the slice it is written to."""


@overload(_shapes_differ)  # type: ignore[untyped-decorator]
def _raise_that_shapes_differ(source: Any, target: Any) -> Any:
    """numba's own writes out both shapes, with a thousand lines of code for numbers as text."""

    def raised(source: Any, target: Any) -> None:
        raise ValueError("cannot assign to a slice of another shape")

    return raised


@cache
def _know_arrays() -> None:
    """Have numba load what it knows of arrays, and not all of `scipy.linalg` with it.

    It looks there whether there is a BLAS, which takes as long as to import numba, before any
    kernel is read. Ours call none; for those of others numba looks again when they are compiled.
    """
    looked = getattr(linalg, "ensure_blas", None)
    if looked is None or find_spec("scipy") is None:
        return
    linalg.ensure_blas = lambda: None
    try:
        import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = looked


@contextmanager
def _short_message() -> Iterator[None]:
    """Within this, numba compiles slices that are written to with the error above; with its own
    where a numba to come raises it elsewhere."""
    own = getattr(arrayobj, "raise_with_shape_context", None)
    if own is None:
        yield
        return
    arrayobj.raise_with_shape_context = _shapes_differ
    try:
        yield
    finally:
        arrayobj.raise_with_shape_context = own


class KernelCacheImpl(CompileResultCacheImpl):  # type: ignore[misc]
    """What of a compiled kernel is kept: numba's own, and what it calls by name."""

    def check_cachable(self, compiled: Any) -> bool:
        """Not where it calls what another process would not find."""
        found = all(LOCAL not in kernel for _, _, kernel, _ in _calls(compiled.library))
        return found and bool(super().check_cachable(compiled))

    def reduce(self, compiled: Any) -> Any:
        """What is written."""
        return _calls(compiled.library), super().reduce(compiled)

    def rebuild(self, target: Any, kept: Any) -> Any:
        """A compiled kernel of what was written, once all that it calls is there (`known_as`).

        None where that has another name by now: it is compiled anew.
        """
        calls, own = kept
        for name, module, kernel, arguments in calls:
            if getattr(import_module(module), kernel).known_as(arguments) != name:
                return None
        compiled = super().rebuild(target, own)
        library = compiled.library
        if library.name == CalledLibrary.__name__:
            library._shared_module = module_of([], library._final_module)
        return compiled


def _calls(library: Any) -> list[Call]:
    """Of `CALLED`, what a library calls by name."""
    linked = isinstance(library, LinkedLibrary)
    module = library._shared_module if linked else library._final_module
    declared = (function for function in module.functions if function.is_declaration)
    names = (named.name for named in (*declared, *module.global_variables))
    return [CALLED[name] for name in names if name in CALLED]


class KernelCache(FunctionCache):  # type: ignore[misc]
    """Compiled kernels in files."""

    _impl_class = KernelCacheImpl

    def __init__(self, function: Any) -> None:
        _know_arrays()
        super().__init__(function)
        self._home = function.__module__, function.__qualname__
        self._locks: dict[Any, ExitStack] = {}

    def load_overload(self, signature: Any, target: Any) -> Any:
        """What is kept. Where nothing is, the caller compiles, and alone, until `done`."""
        found = super().load_overload(signature, target)
        if found is None and signature not in self._locks:
            for company in COMPANY:
                with _waiting():
                    company.before(*self._home, signature)
            lock = self._locks[signature] = ExitStack()
            lock.enter_context(self._alone(str(signature), _waiting))
            found = super().load_overload(signature, target)
        return found

    def _index_key(self, signature: Any, codegen: Any) -> Any:
        return *super()._index_key(signature, codegen), types_read(self._py_func)

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """numba's own reads the index of a kernel, and writes it with one line more."""
        with self._alone("index"):
            super().save_overload(signature, compiled)

    def done(self, signature: Any) -> None:
        """It is there, or cannot be compiled: others may look."""
        self._locks.pop(signature, ExitStack()).close()
        for company in COMPANY:
            company.after(*self._home, signature)

    def _alone(self, what: str, *how: Any) -> AbstractContextManager[None]:
        name = f"{self._cache_file._index_name} {PLACE_IN_MEMORY.sub('', what)}"
        return alone(self._cache_path, name, *how)


def _waiting() -> AbstractContextManager[None]:
    """Waiting for the compiler of another process counts as compiling."""
    return event.trigger_event("numba:compile", data={})


class KernelDispatcher(CPUDispatcher):  # type: ignore[misc]
    """A kernel with one version for calls from kernels, whatever integers they hand it.

    numba would make a version for each width, and for each value where that is a constant.
    """

    _entries: tuple[Callable[..., Any], ...] = ()

    @property
    def straight(self) -> Callable[..., Any]:
        """The kernel, called without a look at what it is handed, once it has its one version.

        Dispatching looks at the type of every array that a call hands over: of the tables of a body
        and a few arrays 8 µs, where the call itself takes one. So a caller hands it what it has
        looked at itself: arrays of other types would be taken for those it was compiled for.
        """
        return self._entries[0] if len(self._entries) == 1 else self

    def enable_caching(self) -> None:
        """Keep what is compiled: in files looked for when there is something to read or to write.

        Most kernels of an import are not called in a process.
        """
        stamp_at_import(self.py_func)
        self.__dict__.pop("_cache", None)

    @cached_property
    def _cache(self) -> Any:
        return KernelCache(self.py_func)

    def compile(self, signature: Any) -> Any:
        """Have a version: read, or compiled."""
        try:
            return super().compile(signature)
        finally:
            if isinstance(self._cache, KernelCache):  # not what came out of a pickle
                self._cache.done(signature)

    def known_as(self, arguments: Any) -> str:
        """The name by which callers know a version, once it is there: read, or compiled."""
        self.compile(arguments)
        return str(self.overloads[arguments].fndesc.mangled_name)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """What numba asks how a call is to be typed."""
        args = tuple(plain(of) for of in args)
        return super().get_call_template(args, {name: plain(kws[name]) for name in kws})

    def add_overload(self, compiled: Any) -> None:
        """What numba tells of a version that was compiled or read."""
        super().add_overload(compiled)
        self._entries = *self._entries, compiled.entry_point
        if issubclass(self._compiler.pipeline_class, CalledCompiler):
            name, arguments = compiled.fndesc.mangled_name, tuple(compiled.signature.args)
            home = self.py_func.__module__, self.py_func.__qualname__
            CALLED[name] = (name, *home, arguments)


def plain(of: Any) -> Any:
    """The type that stands for `of` among the arguments of kernels."""
    of = types.unliteral(of)
    if isinstance(of, types.Integer) and of.bitwidth < types.int64.bitwidth:
        return types.int64
    if isinstance(of, (types.Tuple, types.UniTuple)):
        return types.BaseTuple.from_types([plain(part) for part in of])
    return of


def decorator(compiler: type[KernelCompiler], **options: Any) -> Callable[[Any], Any]:
    """A decorator of kernels that a compiler makes and files keep; options are numba's.

    Quotients by zero are infinite or no numbers and raise nothing, unless it is said otherwise.
    A kernel that left that open would take it, and with it its name, from whatever calls it first.
    """
    own = {"no_cfunc_wrapper": True, "error_model": "numpy", "pipeline_class": compiler}
    decorate = njit(**(own | options))

    def decorated(function: Any) -> Any:
        made = decorate(function)
        if isinstance(made, CPUDispatcher):  # a plain function where compiling is switched off
            made.__class__ = KernelDispatcher
            made.enable_caching()
        return made

    return decorated
