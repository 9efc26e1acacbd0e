"""The type of tuples that are passed to kernels by pointer (see `contiga.pointer_records`).

A call from Python lays the members of the tuple out in memory of its own, which stays as it is
until the kernel returns. So what is read from there may be read once and kept: loads are marked as
invariant. The arrays are held by whoever calls; kernels count no references to them.
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
BORROWED = "numba_adapt_ndarray"
"""Numba's function that fills the struct of an array without owning it."""


class Reference(types.Type):  # type: ignore[misc]
    """A pointer to the members of a named tuple of the numba type `members`."""

    def __init__(self, members: Any) -> None:
        self.members = members
        kind = members.instance_class
        # The names of types go into the names of functions: the full one has thousands of letters.
        # To numba types of one name are one: fields and module belong to it.
        full = f"{kind.__module__} {members.fields} {members}"
        name = f"{kind.__qualname__}{sha256(full.encode()).hexdigest()[:DIGITS]}"
        super().__init__(f"ref{name}")


@register_model(Reference)
class ReferenceModel(models.OpaqueModel):  # type: ignore[misc]
    """A pointer."""


_of_tuple = typeof_impl.dispatch(tuple)


def _type_of(value: tuple[Any, ...], asked: Any) -> Any:
    """Return the type of a tuple of a marked class."""
    members = _of_tuple(value, asked)
    return None if members is None else Reference(members)


for_each_marked(lambda kind: typeof_impl.register(kind, _type_of))


@unbox(Reference)  # type: ignore[untyped-decorator]
def lay_out(reference: Reference, value: Any, c: Any) -> NativeValue:
    """Lay out the members of a Python tuple in memory; return a pointer to them."""
    place = cgutils.alloca_once(c.builder, _room(c.context, reference.members))
    failed = _laid_out(c.pyapi, reference, value, place)
    # Loads marked as invariant may go up to where their pointer is made, but not before the
    # members are there: what this instruction, which does nothing, gives back is made after them.
    pointer = ir.IntType(8).as_pointer()
    place = c.builder.asm(
        ir.FunctionType(pointer, [pointer]),
        "",
        "=r,0,~{memory}",
        [c.builder.bitcast(place, pointer)],
        side_effect=True,
    )
    return NativeValue(place, is_error=failed)


def _room(context: Any, members: Any) -> Any:
    """Return the memory type for a tuple.

    It has its members, and room for those members that are passed by pointer too.
    """
    return ir.LiteralStructType(
        [context.get_value_type(members), *(_room(context, part) for part in _within(members))]
    )


def _laid_out(api: Any, reference: Reference, value: Any, place: Any) -> Any:
    """Emit code that lays out the members of a tuple in its `_room`; return the error flag."""
    function = shared(api, f"contiga_lay_out_{reference.name}", [place.type])
    if function.is_declaration:
        builder = ir.IRBuilder(function.append_basic_block())
        given, home = function.args
        count = len(place.type.pointee.elements)
        first, *rooms = (cgutils.gep_inbounds(builder, home, 0, k) for k in range(count))
        inside = api.context.get_python_api(builder)
        failed = _fill(inside, reference.members, given, first, iter(rooms))
        builder.ret(failed)
    return api.builder.call(function, [value, place])


def _within(of: Any) -> list[Any]:
    """Return the members of the tuples in a tuple that are passed by pointer, in order."""
    if isinstance(of, Reference):
        return [of.members]
    parts = of.types if isinstance(of, types.BaseTuple) else ()
    return [inner for part in parts for inner in _within(part)]


def _fill(api: Any, of: Any, value: Any, place: Any, rooms: Iterator[Any]) -> Any:
    """Emit code that writes a Python object to a place; return the error flag."""
    builder, context = api.builder, api.context
    if isinstance(of, types.Array):
        return adapted(api, of, value, place)
    if isinstance(of, types.BaseTuple):
        failed = cgutils.false_bit
        for k, part in enumerate(of.types):
            at = cgutils.gep_inbounds(builder, place, 0, k)
            part_failed = _fill(api, part, api.tuple_getitem(value, k), at, rooms)
            failed = builder.or_(failed, part_failed)
        return failed
    if isinstance(of, Reference):
        room = next(rooms)
        builder.store(builder.bitcast(room, place.type.pointee), place)
        return _laid_out(api, of, value, room)
    if context.data_model_manager[of].contains_nrt_meminfo():
        raise TypeError(f"a tuple that is passed by pointer holds numbers and arrays, not {of}")
    native = api.to_native_value(of, value)
    builder.store(native.value, place)
    return native.is_error


def adapted(api: Any, of: Any, value: Any, place: Any) -> Any:
    """Emit code that fills the struct of an array at a place; return the error flag.

    By one function of the module for all arrays: numba writes it out for each, which in kernels
    that are handed the tables of a body was a fifth of all machine code.
    """
    function = shared(api, f"contiga_{BORROWED}", [cgutils.voidptr_t, cgutils.intp_t])
    if function.is_declaration:
        _write_adapter(api.context, function)
    size = cgutils.intp_t(as_dtype(of.dtype).itemsize)
    return api.builder.call(function, [value, api.builder.bitcast(place, cgutils.voidptr_t), size])


def _write_adapter(context: Any, function: Any) -> None:
    """Emit the function that fills the struct of an array."""
    builder = ir.IRBuilder(function.append_basic_block())
    api = context.get_python_api(builder)
    value, place, size = function.args
    kind = ir.FunctionType(cgutils.int32_t, [api.pyobj, cgutils.voidptr_t])
    fill = cgutils.get_or_insert_function(builder.module, kind, BORROWED)
    code = builder.call(fill, [value, place])
    head = builder.bitcast(place, HEAD.as_pointer())
    item_size = builder.load(cgutils.gep_inbounds(builder, head, 0, ITEM_SIZE))
    failed = builder.or_(
        cgutils.is_not_null(builder, code), builder.icmp_unsigned("!=", item_size, size)
    )
    with cgutils.if_unlikely(builder, failed):
        text = "an array whose numbers have another size than the kernel was compiled for"
        api.err_set_string("PyExc_TypeError", text)
    builder.ret(failed)


def shared(api: Any, name: str, arguments: list[Any]) -> Any:
    """Return a function of the module that takes a Python object and returns an error flag."""
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
    """Emit code that reads a member."""
    members = reference.members
    k = members.fields.index(name)
    whole = context.get_value_type(members).as_pointer()
    pointer = cgutils.gep_inbounds(builder, builder.bitcast(place, whole), 0, k)
    value = _read(builder, pointer, context.get_value_type(members[k]))
    return _uncounted(context, builder, members[k], value)


def _uncounted(context: Any, builder: Any, of: Any, value: Any) -> Any:
    """Return the same value with arrays without owner, whose reference counting does nothing."""
    if isinstance(of, types.Array):
        return builder.insert_value(value, ir.Constant(ir.IntType(8).as_pointer(), None), 0)
    if isinstance(of, types.BaseTuple):
        for k, part in enumerate(of.types):
            member = _uncounted(context, builder, part, builder.extract_value(value, k))
            value = builder.insert_value(value, member, k)
        return value
    return impl_ret_borrowed(context, builder, of, value)


def _read(builder: Any, pointer: Any, of: Any) -> Any:
    """Return the value at a pointer, read number by number."""
    if isinstance(of, (ir.LiteralStructType, ir.ArrayType)):
        value = ir.Constant(of, ir.Undefined)
        for k in range(len(of.elements) if isinstance(of, ir.LiteralStructType) else of.count):
            part = of.elements[k] if isinstance(of, ir.LiteralStructType) else of.element
            read = _read(builder, cgutils.gep_inbounds(builder, pointer, 0, k), part)
            value = builder.insert_value(value, read, k)
        return value
    value = builder.load(pointer)
    value.set_metadata("invariant.load", builder.module.add_metadata([]))
    return value
