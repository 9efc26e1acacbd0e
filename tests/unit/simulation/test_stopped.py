"""Runs that are stopped, that are not alone in their folder, or whose disk is full."""

from __future__ import annotations

import json
import os
import shutil
from errno import ENOSPC
from pathlib import Path

import numpy as np
import pytest

from contiga import Simulation
from contiga.errors import OutputError
from contiga.io.out import full_disk
from contiga.io.out.vtkhdf import FieldsWriter
from contiga.simulation.output_folder import LOCK

from .conftest import make_simulation

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
    out, own = tmp_path / "out", FieldsWriter._append_array

    def append(self: FieldsWriter, name: str, values: np.ndarray) -> int:
        start = own(self, name, values)
        if self.n_steps == steps:
            assert len(open_below(out)) == 3  # fields, outlines and the lock
            raise KeyboardInterrupt
        return start

    monkeypatch.setattr(FieldsWriter, "_append_array", append)
    with pytest.raises(KeyboardInterrupt) as caught:
        simulation.run(out)
    assert not open_below(out)
    del caught  # till here it holds the run
    assert out.exists() == (steps > 0)


def test_a_folder_is_written_by_one_run_at_a_time(simulation: Simulation, tmp_path: Path) -> None:
    """The second ended the first with a file that was not found."""
    out, refused = tmp_path / "out", []

    def second(done: int) -> None:
        if done % 4:
            return
        who = json.loads((out / LOCK).read_text(encoding="utf-8"))
        assert who["pid"] == os.getpid()
        with pytest.raises(OutputError) as caught:
            make_simulation().run(out)
        refused.append(str(caught.value))

    counted = iter(range(99))
    history = simulation.run(out, on_step=lambda _: second(next(counted))).history
    for message in refused:
        assert message.startswith(f"{out}: another run writes to this folder; found 'process ")
    assert len(refused) == len(range(0, len(history["time"]), 4)) > 2
    assert not (out / LOCK).exists()
    make_simulation().run(out)


def test_what_a_killed_run_left_keeps_nobody_out(simulation: Simulation, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / LOCK).write_text('{"pid": 1, "host": "gone"', encoding="utf-8")
    simulation.run(tmp_path / "out")
    assert not (tmp_path / "out" / LOCK).exists()


@pytest.mark.parametrize("made", ["symbolic", "dangling", "hard", "folder"])
def test_a_lock_that_leads_elsewhere_is_refused(
    made: str, simulation: Simulation, tmp_path: Path
) -> None:
    """The file elsewhere was emptied, and had the number of the process written into it."""
    (out := tmp_path / "out").mkdir()
    (elsewhere := tmp_path / "thesis.txt").write_text("years of work")
    if made == "folder":
        (out / LOCK).mkdir()
    elif made == "hard":
        (out / LOCK).hardlink_to(elsewhere)
    else:
        (out / LOCK).symlink_to(elsewhere if made == "symbolic" else tmp_path / "none")
    with pytest.raises(OutputError, match=rf"{LOCK}: is not the lock that a run makes.*Remove it"):
        simulation.run(out)
    assert elsewhere.read_text() == "years of work"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "thesis.txt"]
    assert [path.name for path in out.iterdir()] == [LOCK]


def test_of_what_a_killed_run_left_reports_that_are_being_written_stay(
    simulation: Simulation, tmp_path: Path
) -> None:
    simulation.run(tmp_path)
    gone, *stay = (
        tmp_path / f".{stem}.0123abcd{end}"
        for stem, end in (("summary", ".json"), ("report", ".html"), ("peak", ".png"))
    )
    for path in (gone, *stay):
        path.touch()
    simulation.run(tmp_path)
    assert not gone.exists()
    assert all(path.exists() for path in stay)


@pytest.mark.parametrize("steps", [0, 1, 5])
def test_a_full_disk_is_told_and_the_run_goes_on_once_there_is_room(
    steps: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, done = tmp_path / "out", []
    whole = make_simulation().run(tmp_path / "whole").history
    usage = shutil.disk_usage

    def filled(path: Path) -> object:
        free = 300_000_000 if len(done) < steps else 1_400_000
        return usage(path)._replace(free=free)

    with monkeypatch.context() as patched:
        patched.setattr(full_disk.shutil, "disk_usage", filled)
        with pytest.raises(OutputError, match=r"the disk is full; found '1\.4 MB left'") as caught:
            make_simulation().run(out, on_step=done.append)
    assert out.exists() == (steps > 0)
    assert ("goes on with --resume" in str(caught.value)) == (steps > 0)
    if steps:
        assert not list(out.glob(".*"))
        history = make_simulation().run(out, resume=True).history
        np.testing.assert_array_equal(history["force"], whole["force"])


def test_a_disk_too_full_for_a_checkpoint_leaves_nothing(
    simulation: Simulation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(ENOSPC, "No space left on device")

    monkeypatch.setattr("contiga.io.out.files.os.fsync", full)
    with pytest.raises(OutputError, match=r"the disk is full\. Make room on it$"):
        simulation.run(tmp_path / "out")
    assert not (tmp_path / "out").exists()
