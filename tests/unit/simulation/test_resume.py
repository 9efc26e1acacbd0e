"""A run that was stopped goes on with the same bits."""

from __future__ import annotations

import re
from errno import EACCES
from pathlib import Path

import numpy as np
import pytest
from tests.sample import full

import contiga as cg
from contiga import Simulation
from contiga.errors import CheckpointError, FileError
from contiga.io.out.hdf5 import whole_file
from contiga.io.out.vtkhdf import read_fields
from contiga.simulation import fields as fields_module
from contiga.simulation.checkpoint import read_checkpoint
from contiga.simulation.model import OutputOptions

from .makers import Make, StopAfter
from .sameness import same_history, same_output, same_states


@pytest.mark.parametrize(
    ("steps", "every"),
    [
        *((1, 4), (5, 1), (13, 4)),
        *full((1, 1), (5, 4), (12, 1), (12, 4), (13, 1)),
    ],
)
def test_stopped_and_resumed_is_uninterrupted(
    make: Make, stop_after: StopAfter, stop: type[Exception], tmp_path: Path, steps: int, every: int
) -> None:
    simulation = make(output=OutputOptions(every=every))
    whole = simulation.run(tmp_path / "whole")
    with pytest.raises(stop):
        simulation.run(tmp_path / "parts", progress=stop_after(steps))
    assert not (tmp_path / "parts" / "history.csv").exists()
    resumed = make(output=OutputOptions(every=every)).run(tmp_path / "parts", resume=True)
    same_history(whole.history, resumed.history)
    same_states(whole.state, resumed.state)
    same_output(tmp_path)
    names = [sorted(p.name for p in (tmp_path / k).iterdir()) for k in ("whole", "parts")]
    assert names[0] == names[1]
    headers = [
        (tmp_path / k / "history.csv").read_text().splitlines()[0] for k in ("whole", "parts")
    ]
    assert headers[0] == headers[1]


@pytest.mark.parametrize("every", [4, *full(3)])
def test_the_peak_is_written_wherever_a_run_was_stopped(
    make: Make, stop_after: StopAfter, stop: type[Exception], tmp_path: Path, every: int
) -> None:
    simulation = make(output=OutputOptions(every=every))
    whole = simulation.run(tmp_path / "whole")
    times = simulation.stepping.planned()
    peak = int(np.argmax(whole.history["force"]))
    kept = []
    for steps in range(1, len(times)):
        with pytest.raises(stop):
            simulation.run(tmp_path / "parts", progress=stop_after(steps))
        read = read_checkpoint(tmp_path / "parts" / "checkpoint.h5", simulation)
        if read.peak.state is not None:
            kept.append(steps)
            assert (
                read.peak.state.time == times[read.peak.row] > times[(steps - 1) // every * every]
            )
        resumed = simulation.run(tmp_path / "parts", resume=True)
        same_history(whole.history, resumed.history)
        same_output(tmp_path)
    # Contact begins in row 2, and row 6 has the peak: where `every` misses it, it waits for row 8.
    assert kept == {3: [3, 5, 6], 4: [3, 4, 6, 7, 8]}[every]
    assert times[peak] in read_fields(tmp_path / "parts" / "fields.vtkhdf").times


def test_a_run_can_be_stopped_again_and_again(
    make: Make, stop_after: StopAfter, stop: type[Exception], tmp_path: Path
) -> None:
    whole = make().run(tmp_path / "whole")
    for steps in (2, 3, 9):
        with pytest.raises(stop):
            make().run(tmp_path / "parts", progress=stop_after(steps), resume=steps > 2)
    resumed = make().run(tmp_path / "parts", resume=True)
    same_history(whole.history, resumed.history)
    same_output(tmp_path)


@pytest.mark.parametrize("after", [False, True])
def test_a_stop_while_fields_are_written_leaves_whole_steps(
    make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, after: bool
) -> None:
    whole = make().run(tmp_path / "whole")
    real = fields_module.Fields.append
    with monkeypatch.context() as patched:

        def append(self: fields_module.Fields, moment: object) -> None:
            late = moment.time > 6.5  # type: ignore[attr-defined]
            if late and not after:
                raise KeyboardInterrupt
            real(self, moment)  # type: ignore[arg-type]
            if late:
                raise KeyboardInterrupt

        patched.setattr(fields_module.Fields, "append", append)
        with pytest.raises(KeyboardInterrupt):
            make().run(tmp_path / "parts")
    resumed = make().run(tmp_path / "parts", resume=True)
    same_history(whole.history, resumed.history)
    same_output(tmp_path)


def test_a_finished_run_is_resumed_without_a_step(simulation: Simulation, tmp_path: Path) -> None:
    whole = simulation.run(tmp_path)
    before = read_fields(tmp_path / "fields.vtkhdf")
    content = (tmp_path / "fields.vtkhdf").read_bytes()
    again = simulation.run(
        tmp_path, resume=True, progress=lambda *_: pytest.fail("a step was taken")
    )
    same_history(whole.history, again.history)
    same_states(whole.state, again.state)
    assert (tmp_path / "fields.vtkhdf").read_bytes() == content
    assert len(before.times) == 13


def test_without_resume_a_stopped_run_begins_again(
    simulation: Simulation, stop_after: StopAfter, stop: type[Exception], tmp_path: Path
) -> None:
    with pytest.raises(stop):
        simulation.run(tmp_path, progress=stop_after(5))
    calls: list[int] = []
    simulation.run(tmp_path, progress=lambda done, *_: calls.append(done))
    assert calls[0] == 1


def test_nothing_to_resume_is_told(simulation: Simulation, tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match="no checkpoint to go on from") as error:
        simulation.run(tmp_path / "new", resume=True)
    assert error.value.exit_code == 2
    assert not (tmp_path / "new").exists()


DAMAGE = {
    "empty": lambda content: b"",
    "cut off": lambda content: content[: len(content) // 3],
    "text": lambda content: b"not a checkpoint",
    "overwritten": lambda content: b"\0" * 512 + content[512:],
    "one bit": lambda content: content[:-9] + bytes([content[-9] ^ 4]) + content[-8:],
}


@pytest.mark.parametrize("how", DAMAGE)
def test_a_damaged_checkpoint_is_told_and_kept(
    simulation: Simulation, tmp_path: Path, how: str
) -> None:
    simulation.run(tmp_path)
    path = tmp_path / "checkpoint.h5"
    path.write_bytes(DAMAGE[how](path.read_bytes()))
    damaged = path.read_bytes()
    told = re.escape(f"{path}: the checkpoint is damaged, and there is none before it. Run the")
    with pytest.raises(CheckpointError, match=told) as error:
        simulation.run(tmp_path, resume=True)
    assert error.value.exit_code == 2
    assert path.read_bytes() == damaged


def test_a_checkpoint_without_a_seal_is_of_an_older_version(
    make: Make, stop_after: StopAfter, stop: type[Exception], tmp_path: Path
) -> None:
    with pytest.raises(stop):
        make().run(tmp_path, progress=stop_after(3))
    path = tmp_path / "checkpoint.h5"
    path.write_bytes(path.read_bytes()[512:])
    told = r"checkpoint\.h5: the checkpoint was written by an older version\. Go on with that"
    with pytest.raises(CheckpointError, match=told):
        make().run(tmp_path, resume=True)
    with pytest.raises(FileError, match=told):
        cg.open_result(tmp_path)


def test_a_checkpoint_that_cannot_be_read_is_told(
    make: Make,
    stop_after: StopAfter,
    stop: type[Exception],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refused(*_: object) -> None:
        raise PermissionError(EACCES, "Permission denied")

    with pytest.raises(stop):
        make().run(tmp_path, progress=stop_after(3))
    monkeypatch.setattr(Path, "read_bytes", refused)
    monkeypatch.setattr(Path, "open", refused)
    with pytest.raises(CheckpointError, match="cannot be read: Permission denied"):
        read_checkpoint(tmp_path / "checkpoint.h5", make())


def test_the_checkpoint_before_a_damaged_one_is_named_and_serves(
    make: Make, stop_after: StopAfter, stop: type[Exception], tmp_path: Path, always: None
) -> None:
    whole = make().run(tmp_path / "whole")
    with pytest.raises(stop):
        make().run(tmp_path / "parts", progress=stop_after(7))
    path, before = (tmp_path / "parts" / f"checkpoint{k}.h5" for k in ("", ".before"))
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(CheckpointError, match=r"is damaged; the one before is checkpoint\.before"):
        make().run(tmp_path / "parts", resume=True)
    with pytest.raises(FileError, match=r"is damaged; the one before is checkpoint\.before"):
        cg.open_result(tmp_path / "parts")
    content = before.read_bytes()
    before.write_bytes(content[:-1])
    with pytest.raises(CheckpointError, match="is damaged, and there is none before it"):
        make().run(tmp_path / "parts", resume=True)
    before.write_bytes(content)
    before.replace(path)
    same_history(whole.history, make().run(tmp_path / "parts", resume=True).history)
    same_output(tmp_path)


@pytest.mark.parametrize(
    "missing",
    [
        "history",
        "peak",
        "contacts/dip/uv",
        "contacts",
        "slaves/sheet/velocities",
        "bodies",
        "energy",
        None,
    ],
)
def test_a_checkpoint_of_a_later_format_is_told(
    simulation: Simulation, tmp_path: Path, missing: str | None
) -> None:
    import h5py

    simulation.run(tmp_path)
    path = tmp_path / "checkpoint.h5"
    with h5py.File(path) as old, whole_file(path, sealed=True) as file:
        for name in old:
            old.copy(name, file)
        for name, value in old.attrs.items():
            file.attrs[name] = value
        if missing is None:
            file.attrs["format"] = 99
        else:
            del file[missing]
    with pytest.raises(CheckpointError, match="cannot be read"):
        simulation.run(tmp_path, resume=True)


def test_a_checkpoint_keeps_every_bit(simulation: Simulation, tmp_path: Path) -> None:
    result = simulation.run(tmp_path)
    read = read_checkpoint(tmp_path / "checkpoint.h5", simulation)
    assert (read.done, read.written) == (13, 13)
    assert read.peak == (result.history["force"].max(), np.argmax(result.history["force"]), None)
    same_states(read.state, result.state)
    same_history(read.history, result.history)
