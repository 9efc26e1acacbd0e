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
from contiga.num.preload import preload
from kernels_of_mine import doubled

print(preload([doubled]), len(doubled.overloads))
if sys.argv[2] == "call":
    doubled(1), doubled(1.5)
    print(preload([doubled]))
"""


def said(folder: Path, what: str) -> list[str]:
    command = [sys.executable, "-c", RUN, str(folder), what]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def test_what_the_cache_holds_is_loaded_and_nothing_is_compiled(tmp_path: Path) -> None:
    (tmp_path / "kernels_of_mine.py").write_text(SOURCE)
    assert said(tmp_path, "call") == ["0 0", "0"]
    assert said(tmp_path, "look") == ["2 2"]
    for data in (tmp_path / "__pycache__").glob("*.1.nbc"):
        data.unlink()
    assert said(tmp_path, "look") == ["1 1"]


def test_a_function_that_is_not_compiled_is_passed_over() -> None:
    from contiga.num.preload import preload

    assert preload([len]) == 0


def test_a_kernel_is_missing_until_it_is_kept(tmp_path: Path) -> None:
    (tmp_path / "kernels_of_mine.py").write_text(SOURCE)
    run = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from contiga.num.preload import is_missing\n"
        "from kernels_of_mine import doubled\n"
        "print(is_missing(doubled)); doubled(1); print(is_missing(doubled), is_missing(len))\n"
    )
    command = [sys.executable, "-c", run, str(tmp_path)]
    said = [subprocess.run(command, capture_output=True, text=True).stdout for _ in range(2)]
    assert said == ["True\nFalse False\n", "False\nFalse False\n"]


def test_loading_a_kernel_leaves_scipy_alone_and_numba_can_do_without_ours() -> None:
    """scipy.linalg takes as long to import as numba; a kernel of somebody else's may need it."""
    code = (
        "import sys; import numpy as np; from numba import njit\n"
        "from contiga.num.kernels.rigid_nb import to_body\n"
        "to_body(np.zeros((1, 3)), np.eye(4), np.zeros((1, 3)), 0, 1)\n"
        "print('scipy.linalg' in sys.modules)\n"
        "print(njit(lambda a: np.linalg.inv(a) @ a)(2.0 * np.eye(2)).tolist())"
    )
    command = [sys.executable, "-c", code]
    env = {k: v for k, v in os.environ.items() if k != "NUMBA_DISABLE_JIT"}
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["False", "[[1.0, 0.0], [0.0, 1.0]]"]
