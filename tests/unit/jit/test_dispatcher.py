"""Kernels that only kernels call are compiled within their callers, and nowhere else."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numba import njit

from contiga.jit import inner, kernel, straight
from contiga.jit.pipeline import InnerCompiler

part = partial(njit, no_cpython_wrapper=True, no_cfunc_wrapper=True, pipeline_class=InnerCompiler)

CALLED = {
    "inmost": "@inner(linked=False)\ndef inmost(x):\n    if x < 0.0:\n"
    "        raise ValueError('below zero')\n    return {1} * x\n",
    "between": "from tiny.inmost import inmost\n\n@inner()\ndef between(x):\n"
    "    return inmost(x) + inmost(2.0 * x)\n",
    "outer": "from tiny.between import between\n\n@kernel()\ndef outer(x):\n"
    "    return between(x){0}\n",
}
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
from contiga.jit.stamps import PACKAGES

PACKAGES.append(folder / "tiny")
from tiny.outer import outer
from tiny.between import between

print(outer(2.0), *(sum(k.stats.cache_hits.values()) for k in (outer, between)))
try:
    outer(-1.0)
except ValueError as error:
    print(error)
"""


def fresh(folder: Path) -> list[str]:
    """What a new process prints. Python's own cache would miss a file changed within a second."""
    run = [sys.executable, "-B", "-c", RUN, str(folder)]
    env = os.environ | {"NUMBA_CACHE_DIR": str(folder / "kept")}
    found = subprocess.run(run, env=env, capture_output=True, text=True, check=True)
    return found.stdout.split("\n")


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
    for linked in (third, shifted):
        (result,) = linked.overloads.values()
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
    head = "from contiga.jit import inner, kernel\n"

    def run(ending: str) -> list[str]:
        for name, text in MODULES.items():
            (folder / f"{name}.py").write_text(head + text.replace("{0}", ending))
        return fresh(tmp_path)

    assert run("") == ["7.0 0 0", "below zero", ""]
    assert run("") == ["7.0 1 0", "below zero", ""]
    assert run(" + 1.0") == ["8.0 0 1", "below zero", ""]


def test_kernels_called_by_name_are_found_by_other_processes(tmp_path: Path) -> None:
    """All new; all kept; a new caller of what is kept; a new callee; a callee that was lost."""
    folder = tmp_path / "tiny"
    folder.mkdir()
    (folder / "__init__.py").touch()
    head = "from contiga.jit import inner, kernel\n"

    def run(ending: str, factor: str = "3.0") -> list[str]:
        for name, text in CALLED.items():
            text = text.replace("{0}", ending).replace("{1}", factor)
            (folder / f"{name}.py").write_text(head + text)
        return fresh(tmp_path)

    assert run("") == ["18.0 0 0", "below zero", ""]
    assert run("") == ["18.0 1 0", "below zero", ""]
    assert run(" + 1.0") == ["19.0 0 1", "below zero", ""]
    assert run(" + 1.0", "5.0") == ["31.0 0 0", "below zero", ""]
    for file in tmp_path.rglob("inmost*.nb[ci]"):
        file.unlink()
    assert run(" + 1.0", "5.0") == ["31.0 1 0", "below zero", ""]


def test_a_kernel_called_by_name_is_in_none_of_its_callers() -> None:
    @inner(linked=False)
    def third(x):
        return x / 3.0

    @inner()
    def shifted(x):
        return third(x) + 1.0

    @kernel()
    def outer(x):
        return shifted(x) * 2.0

    assert outer(6.0) == 6.0
    (name,) = (result.fndesc.mangled_name for result in third.overloads.values())
    (result,) = outer.overloads.values()
    (found,) = (f for f in result.library._final_module.functions if f.name == name)
    assert found.is_declaration


def test_all_integers_are_one_version() -> None:
    @inner()
    def of(pair, table, k):
        return table[pair[0], pair[1]] + k

    @kernel()
    def outer(table, small):
        return (
            of((0, 1), table, 2) + of((small[0], 0), table, small[0]) + of((1, small[0]), table, 0)
        )

    table = np.arange(6.0).reshape(2, 3)
    assert outer(table, np.ones(2, np.int32)) == 1.0 + 2 + 3.0 + 1 + 4.0
    assert len(of.overloads) == 1


def divided(tmp_path: Path) -> Callable[..., str]:
    """A kernel, and two that call it and divide in different ways; what is called in a process of
    its own, by which of them, and what that said: a quotient by zero and the kernel's names."""
    folder = tmp_path / "tiny"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "callee.py").write_text(
        "from contiga.jit import inner\n\n@inner(linked=False)\ndef callee(x):\n"
        "    return 1.0 / x\n"
    )
    for model in ("python", "numpy"):
        (folder / f"by_{model}.py").write_text(
            "from contiga.jit import kernel\nfrom tiny.callee import callee\n\n"
            f"@kernel(error_model='{model}')\ndef by_{model}(x):\n    return callee(x) + 1.0\n"
        )
    code = (
        "import sys; from pathlib import Path\nfolder = Path(sys.argv[1])\n"
        "sys.path.insert(0, str(folder))\nfrom contiga.jit.stamps import PACKAGES\n"
        "PACKAGES.append(folder / 'tiny')\n"
        "from tiny.by_{0} import by_{0} as one\nfrom tiny.callee import callee\n"
        "print(one(0.0), *(r.fndesc.mangled_name for r in callee.overloads.values()))"
    )

    def said(model: str, **environment: str) -> str:
        run = [sys.executable, "-c", code.replace("{0}", model), str(tmp_path)]
        env = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "kept")} | environment
        return subprocess.run(run, capture_output=True, text=True, check=True, env=env).stdout

    return said


def forget(tmp_path: Path, kernel: str) -> None:
    """Remove what is kept of a kernel of `divided`."""
    files = list(tmp_path.rglob(f"{kernel}.{kernel}*.nb[ci]"))
    assert files
    for file in files:
        file.unlink()


def test_whoever_calls_a_kernel_first_its_name_is_the_same(tmp_path: Path) -> None:
    said = divided(tmp_path)
    first = said("python")
    assert first.startswith("inf ")
    forget(tmp_path, "callee")
    assert said("numpy") == first
    assert said("python") == first


def test_a_kept_kernel_whose_callee_has_another_name_by_now_is_compiled_anew(
    tmp_path: Path,
) -> None:
    """What would be called is not there: LLVM would end the process."""
    said = divided(tmp_path)
    first = said("python")
    forget(tmp_path, "callee")
    other = said("numpy", NUMBA_DEBUGINFO="1")  # a part of the names
    assert other != first
    assert said("python") == other


def test_a_kernel_is_called_straight_once_it_has_its_one_version() -> None:
    @kernel()
    def first(numbers, n):  # type: ignore[no-untyped-def]
        return numbers[0] + n

    assert straight(first) is first
    assert first(np.arange(3.0), 2) == 2.0
    assert straight(first) is not first
    assert straight(first)(np.arange(1.0, 3.0), 2) == 3.0
    first(np.arange(3), 2)
    assert straight(first) is first


def test_a_kernel_called_straight_takes_numbers_for_what_it_was_compiled_for() -> None:
    """What callers hand over is looked at in tests/cases/test_kernel_list.py."""

    @kernel()
    def first(numbers):  # type: ignore[no-untyped-def]
        return numbers[0]

    first(np.arange(3.0))
    whole = np.array([1])
    assert straight(first)(whole) == whole.view(np.float64)[0]


def test_an_error_of_a_kernel_called_straight_arrives() -> None:
    @kernel(error_model="python")
    def quotient(x, y):  # type: ignore[no-untyped-def]
        return x / y

    assert quotient(1.0, 2.0) == 0.5
    with pytest.raises(ZeroDivisionError):
        straight(quotient)(1.0, 0.0)


def test_what_is_no_kernel_is_called_as_it_is() -> None:
    assert straight(len) is len
