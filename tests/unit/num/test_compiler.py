"""Kernels that only kernels call are compiled within their callers, and nowhere else."""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from numba import njit

from contiga.num.compiler import InnerCompiler

part = partial(njit, no_cpython_wrapper=True, no_cfunc_wrapper=True, pipeline_class=InnerCompiler)

MODULES = {
    "inmost": "@inner()\ndef inmost(x):\n    if x < 0.0:\n        raise ValueError('below zero')\n"
    "    return 3.0 * x\n",
    "between": "from tiny.inmost import inmost\n\n@inner()\ndef between(x):\n"
    "    return inmost(x) + 1.0\n",
    "outer": "from tiny.between import between\n\n@kernel()\ndef outer(x):\n"
    "    return between(x){0}\n",
}
RUN = """
import sys
from pathlib import Path

folder = Path(sys.argv[1])
sys.path.insert(0, str(folder))
from contiga.num import jit

jit.keep_by_sources(folder / "tiny")
from tiny.outer import outer
from tiny.between import between

print(outer(2.0), *(sum(k.stats.cache_hits.values()) for k in (outer, between)))
try:
    outer(-1.0)
except ValueError as error:
    print(error)
"""


def test_a_linked_kernel_has_no_machine_code_and_its_caller_has_it_all() -> None:
    @part
    def third(x: float) -> float:
        return x / 3.0

    @part
    def shifted(x: float) -> float:
        return third(x) + 1.0

    @njit
    def outer(x: float) -> float:
        return shifted(x) * 2.0

    assert outer(6.0) == 6.0
    for kernel in (third, shifted):
        (result,) = kernel.overloads.values()
        assert not list(result.library.get_defined_functions())
    (result,) = outer.overloads.values()
    assert list(result.library.get_defined_functions())


def test_exceptions_of_linked_kernels_arrive() -> None:
    @part
    def refuse(x: float) -> float:
        if x < 0.0:
            raise ValueError("below zero")
        return x

    @njit
    def outer(x: float) -> float:
        return refuse(x)

    assert outer(1.0) == 1.0
    with pytest.raises(ValueError, match="below zero"):
        outer(-1.0)


def test_a_changed_caller_is_linked_with_kernels_from_the_cache(tmp_path: Path) -> None:
    """All new; all from the cache; then a new caller of kept kernels, which have to be linked."""
    folder = tmp_path / "tiny"
    folder.mkdir()
    (folder / "__init__.py").touch()
    head = "from contiga.num.jit import inner, kernel\n"

    def run(ending: str) -> list[str]:
        for name, text in MODULES.items():
            (folder / f"{name}.py").write_text(head + text.replace("{0}", ending))
        answer = subprocess.run(
            [sys.executable, "-c", RUN, str(tmp_path)], capture_output=True, text=True, check=True
        )
        return answer.stdout.split("\n")

    assert run("") == ["7.0 0 0", "below zero", ""]
    assert run("") == ["7.0 1 0", "below zero", ""]
    assert run(" + 1.0") == ["8.0 0 1", "below zero", ""]
