"""The compilation pipeline of kernels: the passes of numba that they need, and three of ours.

`Uncounted` takes away counting that counts nothing. `Prepared` chooses before all others what
becomes of the code (`libraries`), and by what name kernels in other processes call it. `Fused`
looks for expressions of whole arrays only where there are some. The passes of `UNUSED` are for what
kernels do not have; each of the dearer ones finds the lifetimes of all variables anew. The code is
the same without them.
"""

from __future__ import annotations

from typing import Any

from numba.core import ir
from numba.core import types as numba_types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import AnalysisPass, register_pass
from numba.core.typed_passes import (
    AnnotateTypes,
    DumpParforDiagnostics,
    InlineOverloads,
    NopythonRewrites,
    NoPythonSupportedFeatureValidation,
)
from numba.core.untyped_passes import (
    InlineClosureLikes,
    LiteralPropagationSubPipelinePass,
    LiteralUnroll,
    MakeFunctionToJitFunction,
    TranslateByteCode,
    WithLifting,
)

from contiga.jit.libraries import CalledLibrary, LinkedLibrary
from contiga.jit.stamps import LOCAL, stamp_at_import
from contiga.jit.uncounted import Uncounted

types: Any = numba_types
DIGITS = 12
UNUSED = (
    *(InlineClosureLikes, MakeFunctionToJitFunction),  # functions within kernels, comprehensions
    InlineOverloads,  # functions of numba's own with inline="always"; of kernels one has it
    *(LiteralUnroll, LiteralPropagationSubPipelinePass),  # literal_unroll, mixed containers
    *(WithLifting, DumpParforDiagnostics),  # with, parallel loops
    AnnotateTypes,  # text for inspect_types, which would be kept beside the code
)
"""Passes of numba that are left out. Code that needs one of them does not compile."""
REWRITTEN = "binop", "inplace_binop", "unary", "call"
"""Expressions that numba may fuse into a larger one if they make an array."""


class KernelCompiler(CompilerBase):  # type: ignore[misc]
    """Compiler of kernels that Python calls, linked into the kernels that call them."""

    state: Any
    library: type[JITCodeLibrary] | None = None

    def define_pipelines(self) -> list[Any]:
        """Return the passes of numba's nopython mode and ours."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.passes = [
            (Fused if of is NopythonRewrites else of, name)
            for of, name in passes.passes
            if of not in UNUSED
        ]
        if self.library is not None:
            self.state.kind_of_library = self.library
            passes.add_pass_after(Prepared, TranslateByteCode)
        passes.add_pass_after(Uncounted, NoPythonSupportedFeatureValidation)
        passes.finalize()
        return [passes]


class InnerCompiler(KernelCompiler):
    """Compiler of kernels whose library is linked into callers and not run."""

    library = LinkedLibrary


class CalledCompiler(KernelCompiler):
    """Compiler of kernels whose library is called."""

    library = CalledLibrary


@register_pass(mutates_CFG=False, analysis_only=True)
class Prepared(AnalysisPass):  # type: ignore[misc]
    """Pass that makes the library of a kernel, with names that are equal in every process."""

    _name = "contiga_prepared"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Make the library; the kernel itself is unchanged."""
        kind, known = state.kind_of_library, state.func_id
        state.library = kind(state.targetctx.codegen(), kind.__name__)
        state.library.enable_object_caching()
        if kind is CalledLibrary and LOCAL not in known.func_qualname:
            known.unique_id = int(stamp_at_import(known.func)[:DIGITS], 16)
            known.unique_name = f"{known.func_qualname}${known.unique_id}"
        return False


@register_pass(mutates_CFG=True, analysis_only=False)
class Fused(NopythonRewrites):  # type: ignore[misc]
    """Pass of numba's rewrites of typed kernels, for arithmetic with whole arrays."""

    _name = "contiga_fused"

    def run_pass(self, state: Any) -> bool:
        """Run the rewrites unless the kernel only has arithmetic with numbers."""
        made = (
            state.typemap[line.target.name]
            for block in state.func_ir.blocks.values()
            for line in block.find_insts(ir.Assign)
            if isinstance(line.value, ir.Expr) and line.value.op in REWRITTEN
        )
        return any(isinstance(of, types.Array) for of in made) and bool(super().run_pass(state))
