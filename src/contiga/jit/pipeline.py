"""The compilation pipeline of kernels: the passes of numba that they need, and three of ours.

`PrepareLibrary` runs first: it chooses whether the code is linked or called (`libraries`), and the
name by which kernels in other processes call it. `SkipReferenceCounts` removes reference counts
that have no effect. `FuseArrayExpressions` runs only if there are expressions of whole arrays. The
passes in `UNUSED` serve features that kernels do not have; each of the expensive ones recomputes
the lifetimes of all variables. The code is the same without them.
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
from contiga.jit.reference_counts import SkipReferenceCounts
from contiga.jit.stamps import LOCAL, stamp_at_import

types: Any = numba_types
DIGITS = 12
UNUSED = (
    *(InlineClosureLikes, MakeFunctionToJitFunction),  # functions within kernels, comprehensions
    InlineOverloads,  # numba's own functions with inline="always"
    *(LiteralUnroll, LiteralPropagationSubPipelinePass),  # literal_unroll, mixed containers
    *(WithLifting, DumpParforDiagnostics),  # with, parallel loops
    AnnotateTypes,  # text for inspect_types, which would be kept beside the code
)
"""Passes of numba that are left out. Code that needs one of them does not compile."""
FUSED_OPS = "binop", "inplace_binop", "unary", "call"
"""Expressions that numba may fuse into a larger one if their value is an array."""


class KernelCompiler(CompilerBase):  # type: ignore[misc]
    """Compiler of kernels that Python calls, linked into the kernels that call them."""

    state: Any
    library: type[JITCodeLibrary] | None = None
    """Kind of code library; None for numba's own."""

    def define_pipelines(self) -> list[Any]:
        """Return one pipeline: the passes of numba's nopython mode without `UNUSED`, and ours."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.passes = [
            (FuseArrayExpressions if kind is NopythonRewrites else kind, name)
            for kind, name in passes.passes
            if kind not in UNUSED
        ]
        if self.library is not None:
            self.state.kind_of_library = self.library
            passes.add_pass_after(PrepareLibrary, TranslateByteCode)
        passes.add_pass_after(SkipReferenceCounts, NoPythonSupportedFeatureValidation)
        passes.finalize()
        return [passes]


class InnerCompiler(KernelCompiler):
    """Compiler of kernels whose library is linked into callers and not run."""

    library = LinkedLibrary


class CalledCompiler(KernelCompiler):
    """Compiler of kernels whose library is called."""

    library = CalledLibrary


@register_pass(mutates_CFG=False, analysis_only=True)
class PrepareLibrary(AnalysisPass):  # type: ignore[misc]
    """Pass that creates the library of a kernel, with names that are equal in every process."""

    _name = "contiga_prepared"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Create `state.library`, and name a called kernel by its stamp; its code is unchanged.

        Returns False, for unchanged. Local functions keep numba's names.
        """
        kind, identity = state.kind_of_library, state.func_id
        state.library = kind(state.targetctx.codegen(), kind.__name__)
        state.library.enable_object_caching()
        if kind is CalledLibrary and LOCAL not in identity.func_qualname:
            identity.unique_id = int(stamp_at_import(identity.func)[:DIGITS], 16)
            identity.unique_name = f"{identity.func_qualname}${identity.unique_id}"
        return False


@register_pass(mutates_CFG=True, analysis_only=False)
class FuseArrayExpressions(NopythonRewrites):  # type: ignore[misc]
    """numba's pass that rewrites typed kernels, for arithmetic with whole arrays."""

    _name = "contiga_fused"

    def run_pass(self, state: Any) -> bool:
        """Run the rewrites unless the kernel has arithmetic with numbers only.

        Returns whether they have changed it.
        """
        values = (
            state.typemap[line.target.name]
            for block in state.func_ir.blocks.values()
            for line in block.find_insts(ir.Assign)
            if isinstance(line.value, ir.Expr) and line.value.op in FUSED_OPS
        )
        return any(isinstance(kind, types.Array) for kind in values) and bool(
            super().run_pass(state)
        )
