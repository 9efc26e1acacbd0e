"""numba's passes over a kernel, without the work of those that would find nothing to do.

Most passes go through all statements, and after each numba works out anew where every variable
lives, ten times for a kernel. Those that may need that do so themselves.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.core import config, ir
from numba.core import types as numba_types
from numba.core.compiler_machinery import AnalysisPass, FunctionPass, register_pass
from numba.core.typed_passes import AnnotateTypes, IRLegalization, NativeLowering, NopythonRewrites
from numba.core.untyped_passes import InlineClosureLikes

from contiga.num.lowering import Lowering

types: Any = numba_types
OPERATORS = ("binop", "inplace_binop", "unary")


@register_pass(mutates_CFG=True, analysis_only=False)
class Closures(FunctionPass):  # type: ignore[misc]
    """numba's pass of functions in functions, of lists made into arrays and of `reduce`."""

    _name = "contiga_closures"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Run numba's where there are any."""
        if any(_makes(line.value) for line in _assigned(state)):
            return bool(InlineClosureLikes().run_pass(state))
        return False


@register_pass(mutates_CFG=True, analysis_only=False)
class Rewrites(FunctionPass):  # type: ignore[misc]
    """numba's pass of arithmetic with whole arrays, fields by name and arrays of constants."""

    _name = "contiga_rewrites"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Run numba's where there are any."""
        if any(_rewritten(line, state.typemap) for line in _lines(state)):
            return bool(NopythonRewrites().run_pass(state))
        return False


@register_pass(mutates_CFG=False, analysis_only=True)
class Legal(AnalysisPass):  # type: ignore[misc]
    """numba's pass that writes down where each variable is let go."""

    _name = "contiga_legal"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Run numba's where that is more than nothing: references are counted, or it is a
        generator."""
        if state.targetctx.enable_nrt or state.func_ir.is_generator:
            return bool(IRLegalization().run_pass(state))
        return False


@register_pass(mutates_CFG=False, analysis_only=True)
class Annotated(AnalysisPass):  # type: ignore[misc]
    """numba's pass that keeps the source of a kernel with the types of all that is in it."""

    _name = "contiga_annotated"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Run numba's where somebody has asked for it to be shown."""
        state.type_annotation = None
        if config.ANNOTATE or config.HTML:
            return bool(AnnotateTypes().run_pass(state))
        return False


def _lines(state: Any) -> list[Any]:
    return [line for block in state.func_ir.blocks.values() for line in block.body]


def _assigned(state: Any) -> list[Any]:
    return [line for line in _lines(state) if isinstance(line, ir.Assign)]


def _makes(value: Any) -> bool:
    """Whether a value is a list, or a function that may be put in place of its calls."""
    if isinstance(value, ir.Expr):
        return value.op in ("make_function", "build_list")
    named = isinstance(value, (ir.Global, ir.FreeVar))
    return named and getattr(value.value, "__name__", "") in ("reduce", "stencil")


def _rewritten(line: Any, typemap: Any) -> bool:
    """Whether numba might write something else for a statement."""
    if isinstance(line, ir.SetItem):
        return isinstance(typemap[line.index.name], types.StringLiteral)
    if not isinstance(line, ir.Assign) or not isinstance(line.value, ir.Expr):
        return False
    value = line.value
    if value.op == "getitem":
        return isinstance(typemap[value.index.name], types.StringLiteral)
    if value.op == "build_list":
        return True
    if not isinstance(typemap[line.target.name], types.Array):
        return False
    if value.op == "call":
        return isinstance(getattr(typemap[value.func.name], "typing_key", None), np.ufunc)
    return value.op in OPERATORS


LEAN = {
    InlineClosureLikes: Closures,
    NopythonRewrites: Rewrites,
    IRLegalization: Legal,
    AnnotateTypes: Annotated,
    NativeLowering: Lowering,
}
"""Passes of ours, by those of numba that they stand for."""
