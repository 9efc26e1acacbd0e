"""Fixtures shared by all tests."""

from __future__ import annotations

import atexit
import importlib.util
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numba
import pytest
from hypothesis import settings

from contiga.cache_folder import FOLDER
from contiga.jit.dispatcher import KernelDispatcher

# Files are read, and what is worked out of them is not what a run before has left.
os.environ[FOLDER] = "0"
KEPT = "CONTIGA_TEST_KEPT"
"""Environment variable: where modules that use `kept` keep what they have read in this run."""
if KEPT not in os.environ:  # the processes that share the tests have it from the first
    os.environ[KEPT] = tempfile.mkdtemp(prefix="contiga-tests-")
    atexit.register(shutil.rmtree, os.environ[KEPT], ignore_errors=True)

# No test is timed: the first example may compile or import what it needs.
settings.register_profile("untimed", settings.default, deadline=None)
settings.load_profile("untimed")

INTERPRETED = "mark.interpreted"


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Without the compiler only files with tests for that are imported: others take minutes."""
    if not numba.config.DISABLE_JIT or collection_path.suffix != ".py":
        return None
    if INTERPRETED in collection_path.read_text(encoding="utf-8"):
        return None
    return True


DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


NEXT_LOOK = 16
"""Of calls of a kernel in a test the arguments of the first are looked at, of the 16th, the 256th
and so on: a look costs more than many calls."""
_calls: dict[KernelDispatcher, tuple[int, int]] = {}
"""How often a kernel was called in this test, and at which call it is looked at next."""
_types: dict[int, tuple[tuple[Any, ...], Any]] = {}
"""Types of the records of this test, which are as large as costly to look through: by their id."""


@pytest.fixture(autouse=True)
def _looked_at_anew() -> None:
    _calls.clear()
    _types.clear()


def _type_of(argument: Any) -> Any:
    if not isinstance(argument, tuple):
        return numba.typeof(argument)
    known = _types.get(id(argument))
    if known is None:
        known = _types[id(argument)] = argument, numba.typeof(argument)
    return known[1]


@pytest.fixture(scope="session", autouse=True)
def _looked_at() -> Iterator[None]:
    """In tests kernels that are called straight look at the types of what they are handed."""
    entry = KernelDispatcher.straight.fget
    assert entry is not None

    def straight(kernel: KernelDispatcher) -> Callable[..., Any]:
        result = entry(kernel)
        if result is kernel:
            return kernel

        def call(*arguments: Any) -> Any:
            calls, look = _calls.get(kernel, (1, 1))
            if calls < look:
                _calls[kernel] = calls + 1, look
                return result(*arguments)
            _calls[kernel] = calls + 1, NEXT_LOOK * look
            (known,) = kernel.overloads
            given = tuple(map(_type_of, arguments))
            assert given == known, f"{kernel.py_func.__name__} was handed {given}, not {known}"
            return result(*arguments)

        return call

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(KernelDispatcher, "straight", property(straight))
        yield


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """Folder of the public CAD files and meshes; its absence fails under CI and skips elsewhere."""
    if not DATA.is_dir():
        if os.environ.get("CI"):
            pytest.fail(f"the data folder {DATA} is missing")
        pytest.skip("no shared data beside the project")
    return DATA


@pytest.fixture(scope="module")
def kept() -> Iterator[None]:
    """A large file is read once, not anew by each test: for tests of what is done with it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(FOLDER, os.environ[KEPT])
        yield


@pytest.fixture(scope="session")
def solids() -> ModuleType:
    """Solids made by OpenCASCADE, see `occ_solids`."""
    path = Path(__file__).with_name("occ_solids.py")
    spec = importlib.util.spec_from_file_location("contiga_test_solids", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
