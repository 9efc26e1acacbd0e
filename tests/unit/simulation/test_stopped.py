"""A run that is stopped in the midst of writing a step lets go of its files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from contiga import Simulation
from contiga.io.out.vtkhdf import FieldsWriter

HELD = Path("/proc/self/fd")


def open_below(folder: Path) -> list[str]:
    """Files that this process holds open, where the system tells."""
    paths = [str(entry.readlink()) for entry in HELD.iterdir() if entry.is_symlink()]
    return [path for path in paths if path.startswith(str(folder))]


@pytest.mark.skipif(not HELD.is_dir(), reason="the system does not tell")
@pytest.mark.parametrize("steps", [0, 2])
def test_a_run_that_is_stopped_holds_no_file(
    steps: int, simulation: Simulation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, own = tmp_path / "out", FieldsWriter._append

    def append(self: FieldsWriter, time: float, arrays: dict[str, Any]) -> None:
        own(self, time, arrays)
        if self.n_steps == steps:
            assert len(open_below(out)) == 2  # fields and outlines
            raise KeyboardInterrupt

    monkeypatch.setattr(FieldsWriter, "_append", append)
    with pytest.raises(KeyboardInterrupt) as caught:
        simulation.run(out)
    assert not open_below(out)
    del caught  # till here it holds the run
    assert out.exists() == (steps > 0)
