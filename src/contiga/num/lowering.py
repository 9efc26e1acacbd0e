"""How numba writes kernels for LLVM: with values in place of places in memory.

numba gives each variable that several blocks use a place on the stack, and each array whose fields
are looked at one more; LLVM's first passes then find out that none is needed. Of 100 instructions
that numba writes for a kernel two are arithmetic. Here a variable that is assigned once is the
value that it was given, what is read of a tuple or an array that was just put together is what
went into it, and a call hands on the caller's place for errors. LLVM makes the same code of it in
less time, and so does numba, which spends most of compiling on writing instructions.

What holds references that are counted (see `num.uncounted`) keeps its place.
"""

from __future__ import annotations

from collections import Counter
from functools import reduce
from typing import Any

from llvmlite.ir import Constant, IRBuilder, Undefined, instructions
from numba.core import cgutils, ir
from numba.core import types as numba_types
from numba.core.analysis import compute_cfg_from_blocks, compute_use_defs, must_use_alloca
from numba.core.callconv import RETCODE_OK, CPUCallConv
from numba.core.compiler_machinery import register_pass
from numba.core.cpu import CPUContext
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering
from numba.core.unsafe.eh import exception_check
from numba.np.arrayobj import fix_integer_index, load_item, store_item

from contiga.num.way_in import Api

types: Any = numba_types


class Builder(IRBuilder):  # type: ignore[misc]
    """Writes no instruction for a member of what it has put together itself."""

    def extract_value(self, agg: Any, idx: Any, name: str = "") -> Any:
        """A member of a struct or an array, by its index or by those of members in members."""
        path = list(idx) if isinstance(idx, (tuple, list)) else [idx]
        while path:
            if isinstance(agg, instructions.InsertValue):
                at = list(agg.indices)
                if at == path[: len(at)]:
                    agg, path = agg.value, path[len(at) :]
                elif path == at[: len(path)]:  # what is asked for was changed in part
                    break
                else:
                    agg = agg.aggregate
            elif isinstance(agg, Constant) and agg.constant in (None, Undefined):
                for k in path:
                    agg = Constant(agg.type.elements[k], agg.constant)
                return agg
            else:
                break
        return super().extract_value(agg, path, name) if path else agg


class Calls(CPUCallConv):  # type: ignore[misc]
    """Calls of kernels that hand on where the caller's own error is to be written.

    None of ours catches errors: whatever one raises goes up to Python.
    """

    def call_function(
        self,
        builder: Any,
        callee: Any,
        resty: Any,
        argtys: Any,
        args: Any,
        attrs: Any = None,
    ) -> Any:
        """A call; (status, value)."""
        lean = isinstance(builder, Builder) and not isinstance(resty, types.Optional)
        if not lean or attrs is not None:
            return super().call_function(builder, callee, resty, argtys, args, attrs)
        place = cgutils.alloca_once(builder, self.get_return_type(resty).pointee)
        flat = self._get_arg_packer(argtys).as_arguments(builder, args)
        own = self._get_excinfo_argument(builder.function)
        code = builder.call(callee, [place, own, *flat])
        value = self.context.get_returned_value(builder, resty, builder.load(place))
        return Ended(builder, code, own), value

    def return_status_propagate(self, builder: Any, status: Any) -> None:
        """Return with the error of a callee."""
        if isinstance(status, Ended):
            builder.ret(status.code)
        else:
            super().return_status_propagate(builder, status)


class Context(CPUContext):  # type: ignore[misc]
    """What numba asks how the machine is called."""

    @property
    def call_conv(self) -> Any:
        """How kernels call each other."""
        return Calls(self)

    def get_python_api(self, builder: Any) -> Any:
        """How Python is called."""
        return Api(self, builder)


class Ended:
    """How a call ended: whether with an error, and where that is written."""

    def __init__(self, builder: Any, code: Any, place: Any) -> None:
        self.code = code
        self.excinfoptr = place
        self._builder = builder

    @property
    def is_error(self) -> Any:
        """Whether with an error."""
        return self._builder.icmp_signed("!=", self.code, RETCODE_OK)


class Values(Lower):  # type: ignore[misc]
    """Writes a kernel with the values of its variables."""

    def setup_function(self, fndesc: Any) -> None:
        """Begin the function."""
        super().setup_function(fndesc)
        if self._lean:
            self.builder = Builder(self.entry_block)

    def _find_singly_assigned_variable(self) -> None:
        self._lean = (
            not self._disable_sroa_like_opt
            and self.generator_info is None
            and not any(_catches(block) for block in self.blocks.values())
        )
        if not self._lean:
            super()._find_singly_assigned_variable()
            return
        once, inner = _assigned_once(self.blocks)
        self._singly_assigned_vars = inner | {n for n in once - inner if not self._is_counted(n)}
        self._blk_local_varmap: dict[str, Any] = {}

    def _is_counted(self, name: str) -> bool:
        """Whether references to what a variable holds are counted."""
        if not self.context.enable_nrt:
            return False
        model = self.context.data_model_manager[self.typeof(name)]
        return bool(model.contains_nrt_meminfo())

    def storevar(self, value: Any, name: str, argidx: Any = None) -> None:
        """Give a variable a value."""
        own = self._lean and name not in self._singly_assigned_vars
        if not own or self._is_counted(name):
            super().storevar(value, name, argidx)
            return
        self._alloca_var(name, self.typeof(name))
        self.builder.store(value, self.getvar(name))

    def delvar(self, name: str) -> None:
        """Let a variable go, which is nothing where nothing is counted."""
        if not self._lean or self._is_counted(name):
            super().delvar(name)

    def lower_expr(self, resty: Any, expr: Any) -> Any:
        """The value of an expression."""
        written = EXPRESSIONS.get(expr.op) if self._lean else None
        value = None if written is None else written(self, resty, expr)
        return super().lower_expr(resty, expr) if value is None else value

    def lower_getitem(self, resty: Any, expr: Any, value: Any, index: Any, signature: Any) -> Any:
        """The value of an item, or of a part of an array."""
        kind, at = self.typeof(value.name), self.typeof(index.name)
        if not self._lean or not _is_picked(self.context, kind, at):
            return super().lower_getitem(resty, expr, value, index, signature)
        array = self.loadvar(value.name)
        place, rest = _place(self, kind, array, (at, self.loadvar(index.name)))
        if rest == kind.ndim:
            item = load_item(self.context, self.builder, kind, place)
        else:
            item = _part(self, (kind, array), signature.return_type, place, rest)
            self.incref(signature.return_type, item)
        return self.context.cast(self.builder, item, signature.return_type, resty)

    def lower_setitem(self, target_var: Any, index_var: Any, value_var: Any, sig: Any) -> Any:
        """Write an item."""
        kind, at = self.typeof(target_var.name), self.typeof(index_var.name)
        given = self.typeof(value_var.name)
        number = isinstance(given, (types.Number, types.Boolean))
        if not self._lean or not number or not _is_picked(self.context, kind, at, whole=True):
            return super().lower_setitem(target_var, index_var, value_var, sig)
        array, index = self.loadvar(target_var.name), self.loadvar(index_var.name)
        place, _ = _place(self, kind, array, (at, index))
        value = self.context.cast(self.builder, self.loadvar(value_var.name), given, kind.dtype)
        store_item(self.context, self.builder, kind, value, place)
        return None


def _is_picked(context: Any, kind: Any, index: Any, whole: bool = False) -> bool:
    """Whether an index is of whole numbers into an array, as many as it has axes or fewer."""
    if not isinstance(kind, types.Array) or context.enable_boundscheck:
        return False
    parts = index.types if isinstance(index, types.BaseTuple) else (index,)
    if not parts or not all(isinstance(part, types.Integer) for part in parts):
        return False
    return len(parts) == kind.ndim if whole else len(parts) <= kind.ndim


def _place(lower: Any, kind: Any, array: Any, at: tuple[Any, Any]) -> tuple[Any, int]:
    """Where an index points to in an array, and how many axes it goes along."""
    context, builder = lower.context, lower.builder
    shape, strides, data = (_field(lower, kind, array, k) for k in ("shape", "strides", "data"))
    (index, value), each = at, []
    for k, part in enumerate(index.types if isinstance(index, types.BaseTuple) else (index,)):
        own = builder.extract_value(value, k) if isinstance(index, types.BaseTuple) else value
        if isinstance(part, types.IntegerLiteral) and part.literal_value >= 0:
            each.append(context.get_constant(types.intp, part.literal_value))
        else:
            length = builder.extract_value(shape, k)
            each.append(fix_integer_index(context, builder, part, own, length))
    if kind.layout != "C":
        steps = [builder.mul(builder.extract_value(strides, k), i) for k, i in enumerate(each)]
        return cgutils.pointer_add(builder, data, reduce(builder.add, steps)), len(each)
    # As numba has it: each by how many items it skips.
    lengths = [builder.extract_value(shape, k) for k in range(1, kind.ndim)]
    steps = []
    for k, i in enumerate(each):
        skipped = lengths[k:]
        steps.append(builder.mul(i, reduce(builder.mul, skipped)) if skipped else i)
    return builder.gep(data, [reduce(builder.add, steps)]), len(each)


def _part(lower: Any, whole: tuple[Any, Any], kind: Any, place: Any, start: int) -> Any:
    """The array of type `kind` at a place in a larger one, of its axes from `start` on."""
    builder = lower.builder
    of, array = whole
    shape, strides = (_field(lower, of, array, name) for name in ("shape", "strides"))
    own = range(start, of.ndim)
    lengths = [builder.extract_value(shape, k) for k in own]
    model = lower.context.data_model_manager[kind]
    fields = {
        "meminfo": _field(lower, of, array, "meminfo"),
        "parent": _field(lower, of, array, "parent"),
        "nitems": reduce(builder.mul, lengths),
        "itemsize": _field(lower, of, array, "itemsize"),
        "data": place,
        "shape": cgutils.pack_array(builder, lengths),
        "strides": cgutils.pack_array(builder, [builder.extract_value(strides, k) for k in own]),
    }
    value = Constant(model.get_value_type(), Undefined)
    for name, field in fields.items():
        value = builder.insert_value(value, field, model.get_field_position(name))
    return value


def _field(lower: Any, kind: Any, array: Any, name: str) -> Any:
    """A field of an array."""
    model = lower.context.data_model_manager[kind]
    return lower.builder.extract_value(array, model.get_field_position(name))


def _shape(lower: Any, resty: Any, expr: Any) -> Any:
    """The shape of an array; nothing for other members."""
    kind = lower.typeof(expr.value.name)
    if expr.attr != "shape" or not isinstance(kind, types.Array):
        return None
    return _field(lower, kind, lower.loadvar(expr.value.name), "shape")


def _range(lower: Any, resty: Any, expr: Any) -> Any:
    """A range; nothing for other calls."""
    if not isinstance(resty, types.RangeType) or expr.kws or expr.vararg:
        return None
    called = lower.typeof(expr.func.name)
    if getattr(called, "typing_key", None) is not range:
        return None
    kind = resty.dtype
    ends = [
        lower.context.cast(lower.builder, lower.loadvar(of.name), lower.typeof(of.name), kind)
        for of in expr.args
    ]
    start = [lower.context.get_constant(kind, 0)] if len(ends) == 1 else []
    step = [lower.context.get_constant(kind, 1)] if len(ends) < 3 else []
    value = Constant(lower.context.get_value_type(resty), Undefined)
    for k, part in enumerate([*start, *ends, *step]):
        value = lower.builder.insert_value(value, part, k)
    return value


def _range_iterator(lower: Any, resty: Any, expr: Any) -> Any:
    """An iterator over a range that goes up by ones; nothing for others."""
    if not isinstance(resty, types.RangeIteratorType):
        return None
    builder = lower.builder
    whole = lower.loadvar(expr.value.name)
    start, stop, step = (builder.extract_value(whole, k) for k in range(3))
    if not isinstance(step, Constant) or step.constant != 1:
        return None
    kind = start.type
    place, count = cgutils.alloca_once(builder, kind), cgutils.alloca_once(builder, kind)
    builder.store(start, place)
    builder.store(builder.sub(stop, start), count)
    value = Constant(lower.context.get_value_type(resty), Undefined)
    for k, part in enumerate((place, stop, step, count)):
        value = builder.insert_value(value, part, k)
    return value


def _range_next(lower: Any, resty: Any, expr: Any) -> Any:
    """The next number of a range, and whether there is one; nothing for other iterators."""
    if not isinstance(lower.typeof(expr.value.name), types.RangeIteratorType):
        return None
    builder = lower.builder
    iterator = lower.loadvar(expr.value.name)
    place, _, step, count = (builder.extract_value(iterator, k) for k in range(4))
    left, number = builder.load(count), builder.load(place)
    valid = builder.icmp_signed(">", left, left.type(0))
    with builder.if_then(valid):
        builder.store(builder.sub(left, left.type(1), flags=["nsw"]), count)
        builder.store(builder.add(number, step), place)
    value = Constant(lower.context.get_value_type(resty), Undefined)
    return builder.insert_value(builder.insert_value(value, number, 0), valid, 1)


def _first(lower: Any, resty: Any, expr: Any) -> Any:
    """The first of a pair."""
    value = lower.builder.extract_value(lower.loadvar(expr.value.name), 0)
    lower.incref(resty, value)
    return value


def _second(lower: Any, resty: Any, expr: Any) -> Any:
    """The second of a pair."""
    return lower.builder.extract_value(lower.loadvar(expr.value.name), 1)


EXPRESSIONS = {
    "getattr": _shape,
    "call": _range,
    "getiter": _range_iterator,
    "iternext": _range_next,
    "pair_first": _first,
    "pair_second": _second,
}
"""What writes expressions of a kind, or answers None for those that it leaves to numba."""


def _catches(block: Any) -> bool:
    """Whether a block asks for errors."""
    return any(
        isinstance(line.value, ir.Global) and line.value.value is exception_check
        for line in block.find_insts(ir.Assign)
    )


def _assigned_once(blocks: Any) -> tuple[set[str], set[str]]:
    """Names of the variables that are assigned once, ahead of all that use them, and of those of
    them that no other block uses.

    Blocks are written in the order of their labels, which need not be that in which they are run.
    """
    counts = Counter(
        line.target.name for block in blocks.values() for line in block.find_insts(ir.Assign)
    )
    found = compute_use_defs(blocks)
    home = {name: at for at, names in found.defmap.items() for name in names}
    values = {name for name in home if counts[name] == 1} - must_use_alloca(blocks)
    before = compute_cfg_from_blocks(blocks).dominators()
    for at, names in found.usemap.items():
        values -= {n for n in names & values if home[n] >= at or home[n] not in before[at]}
    return values, values.difference(*found.usemap.values())


@register_pass(mutates_CFG=True, analysis_only=False)
class Lowering(NativeLowering):  # type: ignore[misc]
    """numba's pass that writes a kernel for LLVM."""

    _name = "contiga_lowering"
    lowering_class = Values

    def run_pass(self, state: Any) -> bool:
        """Write it."""
        state.targetctx = state.targetctx.subtarget()
        state.targetctx.__class__ = Context
        return bool(super().run_pass(state))
