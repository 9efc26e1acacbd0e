"""Kernels come out of their cache ahead of their first call, and none is compiled for it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

SOURCE = """
from numba import njit

@njit(cache=True)
def doubled(x):
    return 2 * x
"""
RUN = """
import sys

sys.path.insert(0, sys.argv[1])
from contiga.jit.preload import preload
from kernels_of_mine import doubled

print(preload([doubled]), len(doubled.overloads))
if sys.argv[2] == "call":
    doubled(1), doubled(1.5)
    print(preload([doubled]))
"""


def said(folder: Path, what: str) -> list[str]:
    command = [sys.executable, "-c", RUN, str(folder), what]
    env = os.environ | {"NUMBA_CACHE_DIR": str(folder / "kept")}
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def test_what_the_cache_holds_is_loaded_and_nothing_is_compiled(tmp_path: Path) -> None:
    (tmp_path / "kernels_of_mine.py").write_text(SOURCE)
    assert said(tmp_path, "call") == ["0 0", "0"]
    assert said(tmp_path, "look") == ["2 2"]
    for data in (tmp_path / "kept").rglob("*.1.nbc"):
        data.unlink()
    assert said(tmp_path, "look") == ["1 1"]


def test_a_function_that_is_not_compiled_is_passed_over() -> None:
    from contiga.jit.preload import preload

    assert preload([len]) == 0


def test_a_kernel_is_missing_until_it_is_kept(tmp_path: Path) -> None:
    (tmp_path / "kernels_of_mine.py").write_text(SOURCE)
    run = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from contiga.jit.preload import is_missing\n"
        "from kernels_of_mine import doubled\n"
        "print(is_missing(doubled)); doubled(1); print(is_missing(doubled), is_missing(len))\n"
    )
    command = [sys.executable, "-c", run, str(tmp_path)]
    how = {"env": os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}, "text": True}
    said = [subprocess.run(command, capture_output=True, **how).stdout for _ in range(2)]
    assert said == ["True\nFalse False\n", "False\nFalse False\n"]
