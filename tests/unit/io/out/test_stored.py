"""What a run has left, read without the packages of its fields."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.errors import MissingPackageError
from contiga.io.out.files import write_json
from contiga.io.out.history import write_history


def test_a_run_that_has_ended_is_read_without_h5py(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its checkpoint, which is there for a later end, cannot be read then."""
    from contiga.io.out import stored

    def missing(purpose: str, module: str) -> None:
        raise MissingPackageError(f"{purpose} needs {module}")

    monkeypatch.setattr(stored, "require", missing)
    write_history(tmp_path / "history.csv", {"time": np.arange(3.0)})
    write_json(tmp_path / "summary.json", {"title": "a", "steps": 2})
    (tmp_path / "checkpoint.h5").touch()
    monkeypatch.setattr(stored, "is_sealed", lambda path: True)
    assert stored.read_stored(tmp_path).finished
    (tmp_path / "summary.json").unlink()
    with pytest.raises(MissingPackageError, match="unfinished run"):
        stored.read_stored(tmp_path)
