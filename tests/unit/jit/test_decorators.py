"""Compiled kernels are kept by all their sources: an old one can never be run."""

from __future__ import annotations

import importlib
import os
import re
import shutil
import subprocess
import sys

import pytest

from contiga.jit.cache import KernelCache, Sourced
from contiga.jit.stamps import PACKAGE

HOW = """
import sys

from numba import njit

from contiga.jit import kernel

cached = kernel(linked=True) if sys.argv[2:] != ["numba"] else njit(cache=True)
"""
CALLEE = """
from tiny.how import cached

@cached
def callee(x):
    return x + {0}
"""
CALLER = """
from tiny.how import cached

{0}

@cached
def caller(x):
    return callee(x)
"""
RUN = """
import sys
from pathlib import Path

folder = Path(sys.argv[1])
sys.path.insert(0, str(folder))
from contiga.jit.stamps import PACKAGES

PACKAGES.append(folder / "tiny")
from tiny._caller_nb import caller

print(caller(1), sum(caller.stats.cache_hits.values()))
"""
LOCATORS = """
import sys
from importlib import import_module

for name in sys.argv[1:]:
    for value in vars(import_module(name)).values():
        cache = getattr(value, "_cache", None)
        if hasattr(cache, "_impl"):
            print(type(cache._impl.locator).__name__)
"""
LATE = """
import sys
from pathlib import Path

folder = Path(sys.argv[1])
sys.path.insert(0, str(folder))
from contiga.jit.stamps import PACKAGES

PACKAGES.append(folder / "tiny")
from tiny.late import late

file = folder / "tiny" / "late.py"
file.write_text(file.read_text().replace("+ 10", sys.argv[2]))
print(late(1), sum(late.stats.cache_hits.values()))
"""
IMPORTS = (
    "from tiny._callee_nb import callee",
    "from tiny.between import callee",
    "from ._callee_nb import (\n    callee,  # in brackets (even so)\n)",
)


@pytest.fixture
def tiny(tmp_path):
    """A package of two kernel files, the one imported by the other."""
    folder = tmp_path / "tiny"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "how.py").write_text(HOW)
    (folder / "between.py").write_text("from . import _callee_nb\ncallee = _callee_nb.callee\n")
    (folder / "_callee_nb.py").write_text(CALLEE.format(10))
    (folder / "_caller_nb.py").write_text(CALLER.format(IMPORTS[0]))
    return folder


def kept(tiny):
    """The folder of kernels of its processes."""
    return tiny.parent / "kept" / "contiga"


def called(tiny, by="ours", **environment):
    """What the caller gives for 1 in a fresh process, and how often its code came from a file."""
    env = {k: v for k, v in os.environ.items() if k != "NUMBA_DISABLE_JIT"}
    env |= {"NUMBA_CACHE_DIR": str(kept(tiny).parent)} | environment
    # Without -B Python's own cache would miss a file that is changed within a second.
    run = [sys.executable, "-B", "-c", RUN, str(tiny.parent), by]
    found = subprocess.run(run, env=env, capture_output=True, text=True, check=True)
    value, hits = found.stdout.split()
    return int(value), int(hits)


@pytest.mark.parametrize(
    "line",
    [
        pytest.param(IMPORTS[0], id="straight", marks=pytest.mark.full),
        pytest.param(IMPORTS[1], id="through another file"),
        pytest.param(IMPORTS[2], id="relative", marks=pytest.mark.full),
    ],
)
def test_a_caller_is_compiled_anew_when_a_file_it_imports_has_changed(tiny, line):
    (tiny / "_caller_nb.py").write_text(CALLER.format(line))
    assert called(tiny) == (11, 0)
    assert called(tiny) == (11, 1)
    (tiny / "_callee_nb.py").write_text(CALLEE.format(20))
    assert called(tiny) == (21, 0)
    assert called(tiny) == (21, 1)


def test_numbas_own_stamp_runs_the_old_callee(tiny):
    """What the stamps are for: should numba learn it, they may go."""
    assert called(tiny, by="numba") == (11, 0)
    (tiny / "_callee_nb.py").write_text(CALLEE.format(20))
    assert called(tiny, by="numba") == (11, 1)


def test_old_code_under_a_new_index_is_not_run(tiny):
    """As left by a process that ended between writing the index and the code."""
    called(tiny)
    old = list(kept(tiny).glob("_caller_nb*.nbc"))
    (tiny / "_callee_nb.py").write_text(CALLEE.format(20))
    called(tiny)
    for file in kept(tiny).glob("_caller_nb*.nbc"):
        if file not in old:
            file.unlink()
    assert called(tiny)[0] == 21


def test_a_file_that_changes_before_a_kernel_of_it_is_called_is_not_what_that_is_kept_by(tiny):
    """What is kept is looked for when a kernel is called; its stamp is of what was imported."""
    text = "from contiga.jit import kernel\n\n@kernel()\ndef late(x):\n    return x + 10\n"
    (tiny / "late.py").write_text(text)

    def run(then):
        command = [sys.executable, "-B", "-c", LATE, str(tiny.parent), then]
        env = os.environ | {"NUMBA_CACHE_DIR": str(kept(tiny).parent)}
        found = subprocess.run(command, env=env, capture_output=True, text=True, check=True)
        return found.stdout.split()

    assert run("+ 200") == ["11", "0"]
    assert run("+ 200") == ["201", "0"]
    assert run("+ 200") == ["201", "1"]


def test_what_is_kept_of_a_kernel_is_looked_for_when_it_is_called():
    code = (
        "from contiga.rigid.kernels.rigid_nb import to_body\n"
        "print('_cache' in vars(to_body)); to_body._cache; print('_cache' in vars(to_body))"
    )
    found = subprocess.run(
        [sys.executable, "-c", code],
        env={k: v for k, v in os.environ.items() if k != "NUMBA_DISABLE_JIT"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert found.stdout.split() == ["False", "True"]


def test_nothing_is_left_beside_the_sources(tiny):
    assert called(tiny) == (11, 0)
    assert not list(tiny.rglob("*.nb[ci]"))
    assert len(list(kept(tiny).glob("*.nb[ci]"))) == 4


def test_versions_of_a_package_lie_beside_each_other(tiny, tmp_path):
    """Those of two checkouts that are used in turn, and of two installations that are the same."""
    assert called(tiny) == (11, 0)
    (tiny / "_callee_nb.py").write_text(CALLEE.format(20))
    assert called(tiny) == (21, 0)
    (tiny / "_callee_nb.py").write_text(CALLEE.format(10))
    assert called(tiny) == (11, 1)
    other = tmp_path / "other" / "tiny"
    shutil.copytree(tiny, other)
    assert called(other, NUMBA_CACHE_DIR=str(kept(tiny).parent)) == (11, 1)


def kernel_files():
    files = sorted(PACKAGE.rglob("kernels/*_nb.py"))
    return [file for file in files if re.search(r"^@(kernel|inner)\b", file.read_text(), re.M)]


@pytest.mark.parametrize("file", kernel_files(), ids=lambda file: file.stem)
def test_a_kernel_is_decorated_by_what_says_how_it_is_kept(file):
    assert re.search(r"^from contiga\.jit import ", file.read_text(), re.M)


def test_every_kernel_of_ours_is_kept_so():
    names = [
        ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts) for file in kernel_files()
    ]
    found = subprocess.run(
        [sys.executable, "-c", LOCATORS, *names],
        env={k: v for k, v in os.environ.items() if k != "NUMBA_DISABLE_JIT"},
        capture_output=True,
        text=True,
        check=True,
    )
    kinds = found.stdout.split()
    assert len(kinds) > 200
    assert set(kinds) == {"Sourced"}


def test_files_that_are_not_ours_are_left_to_numba():
    cache = KernelCache(importlib.import_module)
    assert not isinstance(cache._impl.locator, Sourced)


def test_where_a_user_has_numba_look_elsewhere_the_stamps_are_still_ours(tiny):
    where = {"NUMBA_CACHE_LOCATOR_CLASSES": "UserWideCacheLocator", "XDG_CACHE_HOME": str(tiny)}
    assert called(tiny, **where) == (11, 0)
    (tiny / "_callee_nb.py").write_text(CALLEE.format(20))
    assert called(tiny, **where) == (21, 0)
    assert list(kept(tiny).glob("_caller_nb*.nbc"))
