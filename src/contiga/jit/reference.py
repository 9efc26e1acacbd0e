"""The type of tuples that are passed to kernels by pointer (see `contiga.pointer_records`).

A call from Python writes the members of the tuple to a memory of its own, which does not change
until the kernel returns. So a value read from there may be read once and kept: loads are marked as
invariant. The caller holds the arrays; kernels count no references to them.
"""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import sha256
from typing import Any

import llvmlite.ir as ir
from numba.core import cgutils
from numba.core import types as numba_types
from numba.core.imputils import impl_ret_borrowed, lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate
from numba.core.typing.typeof import typeof_impl
from numba.extending import NativeValue, infer_getattr, models, register_model, unbox
from numba.np.numpy_support import as_dtype

from contiga.pointer_records import for_each_marked

types: Any = numba_types
DIGITS = 12
HEAD = ir.LiteralStructType([cgutils.voidptr_t, cgutils.voidptr_t, cgutils.intp_t, cgutils.intp_t])
"""Head of the struct of an array, of any type: owner, parent, items, item size."""
ITEM_SIZE = 3
ADAPT_ARRAY = "numba_adapt_ndarray"
"""Numba's function that fills the struct of an array without owning it."""


class Reference(types.Type):  # type: ignore[misc]
    """A pointer to the members of a named tuple of the numba type `members`."""

    def __init__(self, members: Any) -> None:
        self.members = members
        kind = members.instance_class
        # Names of types are part of the names of functions, and the full one has thousands of
        # letters. For numba types of one name are the same: the hash includes fields and module.
        full = f"{kind.__module__} {members.fields} {members}"
        name = f"{kind.__qualname__}{sha256(full.encode()).hexdigest()[:DIGITS]}"
        super().__init__(f"ref{name}")


@register_model(Reference)
class ReferenceModel(models.OpaqueModel):  # type: ignore[misc]
    """A pointer."""


_of_tuple = typeof_impl.dispatch(tuple)


def _type_of(value: tuple[Any, ...], context: Any) -> Any:
    """Return the type of a tuple of a marked class; None if a member has no numba type."""
    members = _of_tuple(value, context)
    return None if members is None else Reference(members)


for_each_marked(lambda kind: typeof_impl.register(kind, _type_of))


@unbox(Reference)  # type: ignore[untyped-decorator]
def lay_out(reference: Reference, value: Any, c: Any) -> NativeValue:
    """Emit code that lays out the members of a Python tuple in memory.

    Returns a pointer to them, with the error flag. The memory is on the stack of the wrapper of the
    called kernel.
    """
    place = cgutils.alloca_once(c.builder, _memory_type(c.context, reference.members))
    failed = _call_layout(c.pyapi, reference, value, place)
    # Loads marked as invariant may move up to the definition of their pointer, but not above the
    # writes of the members: this instruction, which does nothing, defines the pointer after them.
    pointer = ir.IntType(8).as_pointer()
    place = c.builder.asm(
        ir.FunctionType(pointer, [pointer]),
        "",
        "=r,0,~{memory}",
        [c.builder.bitcast(place, pointer)],
        side_effect=True,
    )
    return NativeValue(place, is_error=failed)


def _memory_type(context: Any, members: Any) -> Any:
    """Return the memory type for a tuple.

    It has its members, and room for the members that are passed by pointer.
    """
    nested = (_memory_type(context, part) for part in _nested_members(members))
    return ir.LiteralStructType([context.get_value_type(members), *nested])


def _call_layout(api: Any, reference: Reference, value: Any, place: Any) -> Any:
    """Emit a call that writes the members of a tuple to its memory; return the error flag.

    The called function is made once for a module and type.
    """
    function = shared_function(api, f"contiga_lay_out_{reference.name}", [place.type])
    if function.is_declaration:
        builder = ir.IRBuilder(function.append_basic_block())
        source, target = function.args
        count = len(place.type.pointee.elements)
        first, *rooms = (cgutils.gep_inbounds(builder, target, 0, k) for k in range(count))
        inner_api = api.context.get_python_api(builder)
        failed = _emit_write(inner_api, reference.members, source, first, iter(rooms))
        builder.ret(failed)
    return api.builder.call(function, [value, place])


def _nested_members(kind: Any) -> list[Any]:
    """Return the members of the tuples in a tuple that are passed by pointer, in order."""
    if isinstance(kind, Reference):
        return [kind.members]
    parts = kind.types if isinstance(kind, types.BaseTuple) else ()
    return [inner for part in parts for inner in _nested_members(part)]


def _emit_write(api: Any, kind: Any, value: Any, place: Any, rooms: Iterator[Any]) -> Any:
    """Emit code that writes a Python object to a place; return the error flag.

    `rooms` are the memories of tuples passed by pointer, in the order of `_nested_members`. Raises
    TypeError for members other than numbers, arrays and tuples.
    """
    builder, context = api.builder, api.context
    if isinstance(kind, types.Array):
        return _emit_array(api, kind, value, place)
    if isinstance(kind, types.BaseTuple):
        failed = cgutils.false_bit
        for k, part in enumerate(kind.types):
            at = cgutils.gep_inbounds(builder, place, 0, k)
            part_failed = _emit_write(api, part, api.tuple_getitem(value, k), at, rooms)
            failed = builder.or_(failed, part_failed)
        return failed
    if isinstance(kind, Reference):
        room = next(rooms)
        builder.store(builder.bitcast(room, place.type.pointee), place)
        return _call_layout(api, kind, value, room)
    if context.data_model_manager[kind].contains_nrt_meminfo():
        raise TypeError(f"a tuple that is passed by pointer holds numbers and arrays, not {kind}")
    native = api.to_native_value(kind, value)
    builder.store(native.value, place)
    return native.is_error


def _emit_array(api: Any, kind: Any, value: Any, place: Any) -> Any:
    """Emit code that fills the struct of an array at a place; return the error flag.

    Numbers of another size are an error at run time. One function of the module serves all arrays:
    numba emits its code for each, which was a fifth of all machine code in kernels that get the
    tables of a body.
    """
    function = shared_function(api, f"contiga_{ADAPT_ARRAY}", [cgutils.voidptr_t, cgutils.intp_t])
    if function.is_declaration:
        builder = ir.IRBuilder(function.append_basic_block())
        inner_api = api.context.get_python_api(builder)
        source, target, size = function.args
        adapter = ir.FunctionType(cgutils.int32_t, [api.pyobj, cgutils.voidptr_t])
        fill = cgutils.get_or_insert_function(builder.module, adapter, ADAPT_ARRAY)
        code = builder.call(fill, [source, target])
        head = builder.bitcast(target, HEAD.as_pointer())
        item_size = builder.load(cgutils.gep_inbounds(builder, head, 0, ITEM_SIZE))
        failed = builder.or_(
            cgutils.is_not_null(builder, code), builder.icmp_unsigned("!=", item_size, size)
        )
        with cgutils.if_unlikely(builder, failed):
            text = "an array whose numbers have another size than the kernel was compiled for"
            inner_api.err_set_string("PyExc_TypeError", text)
        builder.ret(failed)
    number_size = cgutils.intp_t(as_dtype(kind.dtype).itemsize)
    address = api.builder.bitcast(place, cgutils.voidptr_t)
    return api.builder.call(function, [value, address, number_size])


def shared_function(api: Any, name: str, arguments: list[Any]) -> Any:
    """Return the function of a name that takes a Python object and `arguments`, and returns a flag.

    A new one is only declared, for the caller to fill; it is shared by all modules and not inlined.
    """
    kind = ir.FunctionType(cgutils.bool_t, [api.pyobj, *arguments])
    function = cgutils.get_or_insert_function(api.module, kind, name)
    if function.is_declaration:
        function.linkage = "linkonce_odr"
        function.attributes.add("noinline")
    return function


@infer_getattr
class ReferenceAttributes(AttributeTemplate):  # type: ignore[misc]
    """Access to the members by name."""

    key = Reference

    def generic_resolve(self, reference: Reference, name: str) -> Any:
        """Return the type of a member; None for an unknown name."""
        fields = reference.members.fields
        return reference.members[fields.index(name)] if name in fields else None


@lower_getattr_generic(Reference)  # type: ignore[untyped-decorator]
def member(context: Any, builder: Any, reference: Reference, place: Any, name: str) -> Any:
    """Emit code that reads a member at a pointer; arrays have no owner (see `_without_owner`)."""
    members = reference.members
    k = members.fields.index(name)
    tuple_pointer = context.get_value_type(members).as_pointer()
    pointer = cgutils.gep_inbounds(builder, builder.bitcast(place, tuple_pointer), 0, k)
    value = _load(builder, pointer, context.get_value_type(members[k]))
    return _without_owner(context, builder, members[k], value)


def _without_owner(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """Return the value with arrays without owner, whose reference counts have no effect."""
    if isinstance(kind, types.Array):
        return builder.insert_value(value, ir.Constant(ir.IntType(8).as_pointer(), None), 0)
    if isinstance(kind, types.BaseTuple):
        for k, part in enumerate(kind.types):
            member = _without_owner(context, builder, part, builder.extract_value(value, k))
            value = builder.insert_value(value, member, k)
        return value
    return impl_ret_borrowed(context, builder, kind, value)


def _load(builder: Any, pointer: Any, kind: Any) -> Any:
    """Emit code that reads a value number by number, by invariant loads; return the value."""
    if isinstance(kind, (ir.LiteralStructType, ir.ArrayType)):
        value = ir.Constant(kind, ir.Undefined)
        is_struct = isinstance(kind, ir.LiteralStructType)
        for k in range(len(kind.elements) if is_struct else kind.count):
            part = kind.elements[k] if is_struct else kind.element
            member = _load(builder, cgutils.gep_inbounds(builder, pointer, 0, k), part)
            value = builder.insert_value(value, member, k)
        return value
    value = builder.load(pointer)
    value.set_metadata("invariant.load", builder.module.add_metadata([]))
    return value
