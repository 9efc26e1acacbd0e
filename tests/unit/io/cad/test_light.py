"""The door to CAD files is light: the process that reads starts before this one has loaded much."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ("numba", "scipy", "OCP", "contiga.search.track.project", "contiga.geometry.body_mesh")


@pytest.mark.parametrize(
    ("module", "spared"),
    [
        ("contiga.io.cad.cad_parts", HEAVY),
        ("contiga.io.cad.step_iges", ("OCP", "contiga.search.track.project")),
        (
            "contiga.masters.body",
            ("OCP", "contiga.search.track.project", "contiga.geometry.body_mesh"),
        ),
    ],
)
def test_what_is_not_needed_at_once_is_not_imported(module: str, spared: tuple[str, ...]) -> None:
    code = f"import sys, {module}; print(*(name for name in {spared} if name in sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
