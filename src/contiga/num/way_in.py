"""How what Python hands a kernel is laid out for it: by functions that a module has once.

numba writes the code that looks at an array for each array, and for all arrays of a tuple what
holds and lets go each of them, twice. In kernels that are handed the tables of a body that was a
fifth of all machine code.
"""

from __future__ import annotations

from typing import Any

import llvmlite.ir as ir
from numba.core import cgutils
from numba.core import types as numba_types
from numba.core.pythonapi import NativeValue, PythonAPI
from numba.np.numpy_support import as_dtype

types: Any = numba_types
HEAD = ir.LiteralStructType([cgutils.voidptr_t, cgutils.voidptr_t, cgutils.intp_t, cgutils.intp_t])
"""What the struct of an array begins with, whatever it holds: owner, parent, items, their size."""
ITEM_SIZE = 3
HELD, BORROWED = "NRT_adapt_ndarray_from_python", "numba_adapt_ndarray"
"""numba's functions that fill the struct of an array, and hold it or leave that to the caller."""


class Api(PythonAPI):  # type: ignore[misc]
    """What numba asks how things of Python are read."""

    def to_native_value(self, typ: Any, obj: Any) -> Any:
        """The value of a thing of Python."""
        if type(typ) is not types.Array:
            return super().to_native_value(typ, obj)
        place = cgutils.alloca_once(self.builder, self.context.get_value_type(typ))
        failed = adapted(self, typ, obj, place, HELD if self.context.enable_nrt else BORROWED)
        return NativeValue(self.builder.load(place), is_error=failed)


def adapted(api: Any, of: Any, value: Any, place: Any, how: str) -> Any:
    """Code that fills the struct of an array at a place; whether that failed."""
    function = shared(api, f"contiga_{how}", [cgutils.voidptr_t, cgutils.intp_t])
    if function.is_declaration:
        _write_adapter(api.context, function, how)
    size = cgutils.intp_t(as_dtype(of.dtype).itemsize)
    return api.builder.call(function, [value, api.builder.bitcast(place, cgutils.voidptr_t), size])


def _write_adapter(context: Any, function: Any, how: str) -> None:
    """The code of the function that fills the struct of an array."""
    builder = ir.IRBuilder(function.append_basic_block())
    api = context.get_python_api(builder)
    value, place, size = function.args
    kind = ir.FunctionType(cgutils.int32_t, [api.pyobj, cgutils.voidptr_t])
    code = builder.call(cgutils.get_or_insert_function(builder.module, kind, how), [value, place])
    head = builder.bitcast(place, HEAD.as_pointer())
    own = builder.load(cgutils.gep_inbounds(builder, head, 0, ITEM_SIZE))
    failed = builder.or_(cgutils.is_not_null(builder, code), builder.icmp_unsigned("!=", own, size))
    with cgutils.if_unlikely(builder, failed):
        text = "an array whose numbers have another size than the kernel was compiled for"
        api.err_set_string("PyExc_TypeError", text)
    builder.ret(failed)


def shared(api: Any, name: str, arguments: list[Any]) -> Any:
    """A function of the module that is given a thing of Python, and tells whether it failed."""
    kind = ir.FunctionType(cgutils.bool_t, [api.pyobj, *arguments])
    function = cgutils.get_or_insert_function(api.module, kind, name)
    if function.is_declaration:
        function.linkage = "linkonce_odr"
        function.attributes.add("noinline")
    return function
