"""Kernels that are compiled when they are first called, and not with their callers.

What most runs never come to would be a tenth of all compiling. Callers of such a kernel know the
type of its answer, which is declared, and a slot: a place in memory for its address, one for all
callers in a process. Code that finds it empty takes the GIL, whether it runs with it or without,
and calls `address_of` as Python does; an exception of that, Ctrl-C too, is one of its own. Threads
that come to it at once wait for the one that compiles. A call takes a load and a comparison more
than that of another kernel.

The name of a slot is made from the stamp of the kernel's sources and the types of its arguments, so
it is the same in every process. A caller is kept with the names of its slots, and what they stand
for is known once it is read.
"""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from typing import Any

from llvmlite import ir
from numba.core import cgutils
from numba.core import types as numba_types
from numba.core.compiler_lock import global_compiler_lock
from numba.core.imputils import impl_ret_new_ref
from numba.core.sigutils import normalize_signature
from numba.core.typing.templates import make_concrete_template, signature

from contiga.jit.dispatcher import KernelDispatcher, decorator, plain
from contiga.jit.libraries import CALLED
from contiga.jit.pipeline import CalledCompiler
from contiga.jit.stamps import LOCAL, stamp_at_import

types: Any = numba_types
ASK = "contiga_address_of"
"""Name of the compiled function that asks for an address."""
SLOT = "contiga_slot_"
"""What names of slots begin with."""
POINTER = 8
"""Bytes of an address."""
SLOTS: dict[str, tuple[LazyDispatcher, Any]] = {}
"""By the name of a slot: its kernel, and the types of the arguments."""


class LazyDispatcher(KernelDispatcher):
    """A kernel whose callers know what it answers, and where its address will be."""

    returns: Any

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """What numba asks how a call is to be typed: nothing is compiled."""
        called, given = self.fold_argument_types(args, kws)
        arguments = tuple(plain(of) for of in given)
        self.known_as(arguments)
        name, case = self.py_func.__name__, signature(self.returns, *arguments)
        return make_concrete_template(f"CallTemplate({name})", name, [case]), called, arguments, {}

    def get_overload(self, sig: Any) -> str:
        """What numba looks up how a call is to be compiled by."""
        return self.known_as(normalize_signature(sig)[0])

    def known_as(self, arguments: Any) -> str:
        """The name of the slot; from now on what it stands for is known."""
        home = self.py_func.__module__, self.py_func.__qualname__
        own = id(self) if LOCAL in home[1] else stamp_at_import(self.py_func)
        # Not numba's name, in which types of records are counted as a process meets them.
        of = repr((*home, own, str(arguments)))
        name = f"{SLOT}{sha256(of.encode()).hexdigest()}"
        if name not in SLOTS:
            SLOTS[name] = self, arguments
            CALLED[name] = (name, *home, arguments)
            self.targetctx.insert_func_defn([(_caller(name, self.returns), name, arguments)])
        return name

    def address(self, arguments: Any) -> int:
        """Where the kernel is, once it is read or compiled.

        Raises TypeError where it does not answer what is declared.
        """
        with global_compiler_lock:
            self.compile(arguments)
            result = self.overloads[arguments]
            answer = result.signature.return_type
            if answer != self.returns:
                raise TypeError(f"{self.py_func.__name__} answers {answer}, not {self.returns}")
            return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


def lazily(returns: Any, **options: Any) -> Callable[[Any], Any]:
    """A decorator of kernels that are compiled when kernels call them; options are numba's."""
    decorate = decorator(CalledCompiler, LazyDispatcher, **options)

    def decorated(function: Any) -> Any:
        made = decorate(function)
        if isinstance(made, LazyDispatcher):  # a plain function where compiling is switched off
            made.returns = returns
        return made

    return decorated


def address_of(name: str) -> int:
    """What belongs into a slot; compiled callers ask."""
    kernel, arguments = SLOTS[name]
    return kernel.address(arguments)


def compile_all() -> None:
    """Have all kernels that what is there by now might call, and those that these might."""
    done: set[str] = set()
    while waiting := set(SLOTS) - done:
        for name in sorted(waiting):
            address_of(name)
        done |= waiting


def _caller(name: str, returns: Any) -> Any:
    """What compiles a call by way of a slot."""

    def call(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        convention = context.call_conv
        kind = convention.get_function_type(returns, sig.args)
        callee = builder.bitcast(_filled(context, builder, name), kind.as_pointer())
        status, answer = convention.call_function(builder, callee, returns, sig.args, args)
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return impl_ret_new_ref(context, builder, returns, answer)

    return call


def _filled(context: Any, builder: Any, name: str) -> Any:
    """The address in a slot, which is asked for where it is empty."""
    module = builder.module
    slot = module.globals.get(name)
    if slot is None:
        slot = cgutils.add_global_variable(module, cgutils.voidptr_t, name)
        slot.linkage = "common"  # one for all modules, as numba's places of environments
        slot.initializer = ir.Constant(slot.type.pointee, None)
    found = builder.load_atomic(slot, "acquire", POINTER)
    address = cgutils.alloca_once_value(builder, found)
    with cgutils.if_unlikely(builder, cgutils.is_null(builder, found)):
        text = context.insert_const_string(module, name)
        found = builder.call(_asking(context, module), [text])
        with cgutils.if_unlikely(builder, cgutils.is_null(builder, found)):
            context.call_conv.return_exc(builder)
        builder.store_atomic(found, slot, "release", POINTER)
        builder.store(found, address)
    return builder.load(address)


def _asking(context: Any, module: Any) -> Any:
    """The function of a module that asks `address_of`; none with Python's exception set."""
    kind = ir.FunctionType(cgutils.voidptr_t, [cgutils.voidptr_t])
    function = cgutils.get_or_insert_function(module, kind, ASK)
    if not function.is_declaration:
        return function
    function.linkage = "linkonce_odr"
    function.attributes.add("noinline")
    builder = ir.IRBuilder(function.append_basic_block())
    python = context.get_python_api(builder)
    gil = python.gil_ensure()
    # All but the last of these take null for what failed before them, and leave the exception.
    here = python.import_module(context.insert_const_string(module, __name__))
    name = python.string_from_string(function.args[0])
    answer = python.call_method(here, address_of.__name__, [name])
    address = cgutils.alloca_once_value(builder, ir.Constant(cgutils.voidptr_t, None))
    with builder.if_then(cgutils.is_not_null(builder, answer)):
        builder.store(python.long_as_voidptr(answer), address)
    for made in (here, name, answer):
        python.decref(made)
    python.gil_release(gil)
    builder.ret(builder.load(address))
    return function
