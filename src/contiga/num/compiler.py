"""How kernels that only kernels call are compiled: once, within what Python calls.

numba links the code of a callee into each of its callers and optimises it there, all the way up.
It also optimises each kernel by itself and makes machine code of it, for calls from Python; for
kernels that Python never calls that is half of all compiling, for nothing. The libraries here hold
their code as it was lowered, to be linked. The engine is given the places of their environments
only, since the code of callers refers to those by name.
"""

from __future__ import annotations

from typing import Any

import llvmlite.binding as llvm
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class LinkedLibrary(JITCodeLibrary):  # type: ignore[misc]
    """Code of a kernel and of those that it calls, to be linked into its callers and not run."""

    _final_module: Any
    _shared_module: Any

    def _optimize_final_module(self) -> None:
        """Nothing: the caller that Python calls does it for all at once."""

    def _finalize_final_module(self) -> None:
        """Keep the code for the callers; the engine gets what they share."""
        self._shared_module = self._final_module.clone()
        for function in self._shared_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                function.linkage = "linkonce_odr"
        self._final_module = _environments_of(self._final_module)
        super()._finalize_final_module()


def _environments_of(module: Any) -> Any:
    """A module of nothing but the environments of `module`."""
    head = f'target triple = "{module.triple}"\ntarget datalayout = "{module.data_layout}"\n'
    own = [str(place) for place in module.global_variables if "NumbaEnv" in place.name]
    shared = llvm.parse_assembly(head + "\n".join(own))
    shared.name = module.name
    return shared


class InnerCompiler(Compiler):  # type: ignore[misc]
    """numba's compiler, with a library that is linked and not run."""

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *rest: Any) -> None:
        if library is None:
            library = LinkedLibrary(targetctx.codegen(), "linked")
            library.enable_object_caching()
        super().__init__(typingctx, targetctx, library, *rest)
