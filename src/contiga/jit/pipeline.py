"""How a kernel is compiled: numba's passes, and two of ours among them.

`Uncounted` takes away counting that counts nothing. `Prepared` chooses before all others what
becomes of the code (`libraries`), and by what name kernels in other processes call it.
"""

from __future__ import annotations

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import AnalysisPass, register_pass
from numba.core.typed_passes import NoPythonSupportedFeatureValidation
from numba.core.untyped_passes import TranslateByteCode

from contiga.jit.libraries import CalledLibrary, LinkedLibrary
from contiga.jit.stamps import LOCAL, stamp_at_import
from contiga.jit.uncounted import Uncounted

DIGITS = 12


class KernelCompiler(CompilerBase):  # type: ignore[misc]
    """For kernels that Python calls, linked into the kernels that do."""

    state: Any
    library: type[JITCodeLibrary] | None = None

    def define_pipelines(self) -> list[Any]:
        """numba's passes in nopython mode, and ours."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        if self.library is not None:
            self.state.kind_of_library = self.library
            passes.add_pass_after(Prepared, TranslateByteCode)
        passes.add_pass_after(Uncounted, NoPythonSupportedFeatureValidation)
        passes.finalize()
        return [passes]


class InnerCompiler(KernelCompiler):
    """The same, with a library that is linked and not run."""

    library = LinkedLibrary


class CalledCompiler(KernelCompiler):
    """The same, with a library that is called."""

    library = CalledLibrary


@register_pass(mutates_CFG=False, analysis_only=True)
class Prepared(AnalysisPass):  # type: ignore[misc]
    """Makes the library of a kernel, and names what is called alike in every process."""

    _name = "contiga_prepared"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """The kernel itself stays as it is."""
        kind, known = state.kind_of_library, state.func_id
        state.library = kind(state.targetctx.codegen(), kind.__name__)
        state.library.enable_object_caching()
        if kind is CalledLibrary and LOCAL not in known.func_qualname:
            known.unique_id = int(stamp_at_import(known.func)[:DIGITS], 16)
            known.unique_name = f"{known.func_qualname}${known.unique_id}"
        return False
