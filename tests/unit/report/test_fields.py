"""Fields that are read once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.io.out.vtkhdf import read_fields
from contiga.report.fields import ReadOnce
from contiga.report.frames import frames_of
from contiga.report.peak import at_frame
from contiga.report.run_folder import Units

from .conftest import write_fields

UNITS = Units("mm", "g", "ms", "mm²", "N", "N·mm", "MPa")


@pytest.fixture
def counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A series, and what has been read of it."""
    write_fields(tmp_path / "fields.vtkhdf")
    series, reads = read_fields(tmp_path / "fields.vtkhdf"), []
    points, data = series.points, series.data
    monkeypatch.setattr(series, "points", lambda i: reads.append((i, "points")) or points(i))
    monkeypatch.setattr(series, "data", lambda i, name: reads.append((i, name)) or data(i, name))
    return series, reads


def test_steps_are_those_of_the_file(counted) -> None:
    series, _ = counted
    once = ReadOnce(series)
    assert (once.names, once.parts) == (series.names, series.parts)
    assert once.rows("sheet") == series.rows("sheet")
    np.testing.assert_array_equal(once.times, series.times)
    for i in (2, 0, 0, 2, 1):
        np.testing.assert_array_equal(once.points(i), series.points(i))
        for name in series.names:
            np.testing.assert_array_equal(once.data(i, name), series.data(i, name))


def test_nothing_of_a_step_is_read_twice(counted) -> None:
    series, reads = counted
    once = ReadOnce(series)
    peak = at_frame(once, 2)
    assert len(reads) == len(set(reads)) == 4
    reads.clear()
    frames_of(once, None, 2, peak, UNITS)
    assert len(reads) == len(set(reads))
    assert {i for i, _ in reads} == set(range(len(series.times)))


def test_what_is_shared_cannot_be_written_to(counted) -> None:
    points = ReadOnce(counted[0]).points(0)
    with pytest.raises(ValueError, match="read-only"):
        points[0] = 0.0
