"""The brute-force oracle, as a fixture."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture(scope="session")
def oracle() -> ModuleType:
    """Every triangle against every point; and small meshes."""
    path = Path(__file__).with_name("oracle.py")
    spec = importlib.util.spec_from_file_location("contiga_test_facet_oracle", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
