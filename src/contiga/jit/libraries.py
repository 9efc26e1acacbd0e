"""Code libraries of kernels: linked into the code of their callers, or called.

numba links the code of a callee into each of its callers and optimises it there, all the way up. It
also optimises each kernel by itself and generates its machine code, for calls from Python; for
kernels that Python never calls this is half of all compiling, without use. A `LinkedLibrary` keeps
its code as it was lowered, to be linked. The engine gets only the addresses of its environments,
which the code of callers refers to by name.

A large kernel that is part of several others is better called: a `CalledLibrary` is compiled by
itself and gives its callers only its name. The name contains the stamp of its sources, so that code
compiled by another process calls the same function. The kernels that a cached kernel calls are
stored beside it, and loaded before it.
"""

from __future__ import annotations

from typing import Any

import llvmlite.binding as llvm
from numba.core.codegen import JITCodeLibrary

Call = tuple[str, str, str, Any]
"""Name of a function, its module, its kernel, and the types of its arguments."""
CALLED: dict[str, Call] = {}
"""Origins of the functions that are called by name."""


class LinkedLibrary(JITCodeLibrary):  # type: ignore[misc]
    """Code of a kernel and its callees that is linked into callers and not run itself."""

    _shared_module: Any
    _final_module: Any

    def _optimize_final_module(self) -> None:
        """Skip the optimisation: that of the kernel that Python calls includes this code."""

    def _finalize_final_module(self) -> None:
        """Keep the code for the callers; the engine gets the shared parts."""
        self._shared_module = self._final_module
        for function in self._shared_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                function.linkage = "linkonce_odr"
        environments = [
            str(at) for at in self._final_module.global_variables if "NumbaEnv" in at.name
        ]
        self._final_module = module_of(environments, self._final_module)
        super()._finalize_final_module()


class CalledLibrary(JITCodeLibrary):  # type: ignore[misc]
    """Code of a kernel that its callers call by name."""

    def _get_module_for_linking(self) -> Any:
        """Return an empty module for the callers to link."""
        self._ensure_finalized()
        return module_of([], self._final_module)

    def serialize_using_object_code(self) -> Any:
        """Return the serialised code: object code, and a module of the functions in it.

        numba looks for the names of functions in that module; theirs are empty.
        """
        defined = [function.name for function in self.get_defined_functions()]
        names = module_of(
            [f'define void @"{name}"() {{ ret void }}' for name in defined], self._final_module
        )
        return self.name, "object", (self._get_compiled_object(), names.as_bitcode())


def module_of(lines: list[str], like: Any) -> Any:
    """Return a module that contains only `lines`, of the kind of the module `like`."""
    head = f'target triple = "{like.triple}"\ntarget datalayout = "{like.data_layout}"\n'
    module = llvm.parse_assembly(head + "\n".join(lines))
    module.name = like.name
    return module


def calls_of(library: Any) -> list[Call]:
    """Return the entries of `CALLED` that a library calls by name, itself or by linked code."""
    linked = isinstance(library, LinkedLibrary)
    module = library._shared_module if linked else library._final_module
    names = (function.name for function in module.functions if function.is_declaration)
    return [CALLED[name] for name in names if name in CALLED]
