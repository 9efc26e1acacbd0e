"""A compiler pass: kernels that allocate no arrays do not count references to their arguments.

numba counts the references to an array wherever a variable gets or releases it, and in tuples of
tables those of every array: half of the time of kernels that pass tables on. The arguments of a
kernel live until it returns, since the caller holds them. So if all its arrays are arguments, or
parts of them, there is nothing to count.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from numba.core import ir
from numba.core import types as numba_types
from numba.core.compiler_machinery import AnalysisPass, register_pass
from numba.core.errors import TypingError

from contiga.jit.scratch import SCRATCH

types: Any = numba_types
BORROWING_OPS = (
    *("getattr", "getitem", "static_getitem", "typed_getitem", "build_tuple", "cast", "phi"),
    *("getiter", "iternext", "pair_first", "exhaust_iter"),
)
"""Expressions whose arrays belong to their operands, unless an array is the index."""
BASIC_INDICES = types.Integer, types.SliceType, types.EllipsisType, types.StringLiteral
SLICE_WRITES = ir.SetItem, ir.StaticSetItem


@register_pass(mutates_CFG=False, analysis_only=True)
class SkipReferenceCounts(AnalysisPass):  # type: ignore[misc]
    """Pass that compiles a kernel that owns no array without reference counts."""

    _name = "contiga_uncounted"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Replace the target by one without reference counts if the kernel owns no array.

        The kernel is not changed, and the result False. Raises numba's TypingError for a kernel
        that returns an array of its stack.
        """
        _check_returned(state)
        if not _owns_arrays(state):
            context = state.targetctx.subtarget(enable_nrt=False)
            context.__dict__.pop("nrt", None)  # numba's, for a context that counts
            state.targetctx = context
        return False


def _owns_arrays(state: Any) -> bool:
    """Return whether a kernel allocates an array, gets one from a call, or returns one.

    Arrays of the stack do not count; a slice that is written from an array does, by a copy.
    """
    holds = _array_test(state)
    if holds(state.return_type):
        return True
    for block in state.func_ir.blocks.values():
        for line in block.body:
            if isinstance(line, ir.Assign):
                counted = holds(state.typemap[line.target.name])
                if counted and not _is_borrowed(line.value, state.typemap):
                    return True
            # A slice is written from a copy if the array may overlap with it.
            elif isinstance(line, SLICE_WRITES) and holds(state.typemap[line.value.name]):
                return True
    return False


def _check_returned(state: Any) -> None:
    """Refuse a kernel that returns an array of its stack, or a part or tuple of it.

    Raises numba's TypingError.
    """
    holds = _array_test(state)
    blocks = state.func_ir.blocks.values()
    assignments = [line for block in blocks for line in block.find_insts(ir.Assign)]
    arrays = [line for line in assignments if holds(state.typemap[line.target.name])]
    on_stack = {line.target.name for line in arrays if _is_scratch(line.value, state.typemap)}
    count = 0
    while count != len(on_stack):
        count = len(on_stack)
        on_stack |= {
            line.target.name for line in arrays if on_stack & _sources(line.value, state.typemap)
        }
    for block in blocks:
        for line in block.find_insts(ir.Return):
            if line.value.name in on_stack:
                raise TypingError("a kernel returns an array of its stack", loc=line.loc)


def _array_test(state: Any) -> Callable[[Any], bool]:
    """Return a function that tests whether a type is an array, or contains one."""
    models = state.targetctx.data_model_manager

    @cache
    def holds(of: Any) -> bool:
        return bool(models[of].contains_nrt_meminfo())

    return holds


def _is_scratch(value: Any, typemap: Any) -> bool:
    """Return whether a value is a new array on the stack."""
    if not isinstance(value, ir.Expr) or value.op != "call":
        return False
    return getattr(typemap[value.func.name], "typing_key", None) in SCRATCH


def _sources(value: Any, typemap: Any) -> set[str]:
    """Return the names of the variables that a value is, is a part of, or consists of."""
    if isinstance(value, ir.Var):
        return {value.name}
    if isinstance(value, ir.Expr) and _is_borrowed(value, typemap):
        return {of.name for of in value.list_vars()}
    return set()


def _is_borrowed(value: Any, typemap: Any) -> bool:
    """Return whether an array that is assigned to a variable belongs to another one or the stack.

    Arguments count as others.
    """
    if not isinstance(value, ir.Expr):
        return isinstance(value, (ir.Arg, ir.Var))
    if value.op == "call":
        return _is_scratch(value, typemap)
    if value.op == "getitem" or value.op == "typed_getitem":
        return _is_basic(typemap[value.index.name])
    if value.op == "static_getitem" and value.index_var is not None:
        return _is_basic(typemap[value.index_var.name])
    return value.op in BORROWING_OPS


def _is_basic(index: Any) -> bool:
    """Return whether an index selects a view, and not a copy."""
    if isinstance(index, types.BaseTuple):
        return all(_is_basic(part) for part in index.types)
    return isinstance(index, BASIC_INDICES)
