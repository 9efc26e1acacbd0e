"""What a run has left, read while it goes on, after it was stopped and once it has ended."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.errors import FileError, MissingPackageError
from contiga.report import write_report
from contiga.simulation import recorder

from .conftest import make_simulation


def sensed() -> cg.Simulation:
    return make_simulation(sensors=[cg.Sensor("cog", "ball", criteria=["HIC15"])])


@pytest.fixture
def at_every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder, "CHECKPOINT_SECONDS", 0.0)


def test_a_run_that_has_ended(tmp_path: Path) -> None:
    done = sensed().run(tmp_path / "out")
    stored = cg.open_result(tmp_path / "out")
    assert stored.finished
    assert stored.summary == done.summary
    for name, column in done.history.items():
        np.testing.assert_array_equal(stored.history[name], column)
    np.testing.assert_array_equal(stored.sensors["cog"]["ax"], done.history["cog.ax"])
    fields = stored.fields
    assert fields is not None
    assert len(fields.times) == 13
    k = stored.at(6.1)
    assert abs(fields.times[k] - 6.1) == np.abs(fields.times - 6.1).min()
    assert fields.points(k)[fields.rows("sheet")].shape == (225, 3)


@pytest.mark.usefixtures("at_every_step")
def test_a_run_that_goes_on(tmp_path: Path) -> None:
    seen = []

    def look(state: cg.SystemState) -> None:
        stored = cg.open_result(tmp_path / "out")
        assert not stored.finished
        assert stored.time == state.time
        assert stored.summary["unfinished"] == {"time": state.time, "end": 12.0}
        assert stored.fields is not None
        assert stored.fields.times[-1] == state.time
        seen.append(stored.history["force"][-1])

    # Over what an earlier run has left there.
    sensed().run(tmp_path / "out")
    done = sensed().run(tmp_path / "out", on_step=look)
    np.testing.assert_array_equal(seen, done.history["force"])
    assert cg.open_result(tmp_path / "out").finished


@pytest.mark.parametrize("formats", [("vtkhdf", "csv"), ("csv",)])
def test_a_run_that_was_stopped(tmp_path: Path, formats: tuple[str, ...]) -> None:
    whole = sensed().run(tmp_path / "out").history

    def stop(state: cg.SystemState) -> None:
        if state.time > 6.0:
            raise KeyboardInterrupt

    simulation = make_simulation(
        sensors=[cg.Sensor("cog", "ball", criteria=["HIC15"])],
        output=make_simulation().output._replace(formats=formats),
    )
    with pytest.raises(KeyboardInterrupt):
        simulation.run(tmp_path / "out", on_step=stop)
    stored = cg.open_result(tmp_path / "out")
    assert not stored.finished
    n = len(stored.history["time"])
    assert 1 < n < 13
    np.testing.assert_array_equal(stored.history["force"], whole["force"][:n])
    assert (stored.fields is not None) == ("vtkhdf" in formats)
    assert stored.summary["sensors"]["cog"]["criteria"]["HIC15"]["value"] > 0.0
    page = write_report(tmp_path / "out").read_text(encoding="utf-8")
    assert "<b>unfinished</b>" in page
    assert "the run has not ended: it stands at t = " in page
    assert ("<h2>3D view</h2>" in page) == ("vtkhdf" in formats)
    simulation.run(tmp_path / "out", resume=True)
    assert cg.open_result(tmp_path / "out").finished


def test_what_is_no_run_is_told(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no such output folder"):
        cg.open_result(tmp_path / "none")
    with pytest.raises(
        FileError, match=r"not the output folder of a run: summary\.json is missing"
    ):
        cg.open_result(tmp_path)

    def look(_: object) -> None:
        with pytest.raises(FileError, match="the run has just begun"):
            cg.open_result(tmp_path / "out")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sensed().run(tmp_path / "out", on_step=look)


def test_a_damaged_checkpoint_keeps_nobody_from_a_run_that_has_ended(tmp_path: Path) -> None:
    sensed().run(tmp_path)
    (tmp_path / "checkpoint.h5").write_bytes(b"damaged")
    assert cg.open_result(tmp_path).finished


def test_a_run_is_shown_without_the_package_that_reads_fields(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_simulation().run(tmp_path / "out")
    assert ", recorded 13," in repr(cg.open_result(tmp_path / "out"))
    monkeypatch.setitem(sys.modules, "h5py", None)
    result = cg.open_result(tmp_path / "out")
    assert ", recorded unknown," in repr(result)
    with pytest.raises(MissingPackageError, match="h5py, which is not installed"):
        _ = result.fields
