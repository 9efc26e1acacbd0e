"""Fixtures shared by all tests."""

from __future__ import annotations

import atexit
import importlib.util
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numba
import pytest
from hypothesis import settings
from tests.durations import Durations
from tests.sample import FULL

from contiga.cache_folder import FOLDER

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


def pytest_configure(config: pytest.Config) -> None:
    """Know and measure which tests are long."""
    config.pluginmanager.register(Durations())


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what only `make stress` asks for."""
    left = [] if FULL else [item for item in items if item.get_closest_marker("full")]
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if not item.get_closest_marker("full")]


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Without the compiler only files with tests for that are imported: others take minutes."""
    if not numba.config.DISABLE_JIT or collection_path.suffix != ".py":
        return None
    if INTERPRETED in collection_path.read_text(encoding="utf-8"):
        return None
    return True


DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


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
