"""A run that was stopped goes on with the same bits."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable
from dataclasses import replace
from errno import EACCES
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga import Simulation
from contiga.dynamics.prescribed import Moved, Translate
from contiga.dynamics.stepping import AutoSteps, GivenTimes
from contiga.errors import CheckpointError, FileError
from contiga.io.out.hdf5 import whole_file
from contiga.io.out.vtkhdf import read_fields
from contiga.masters.body import Body
from contiga.simulation import fields as fields_module
from contiga.simulation.checkpoint import read_checkpoint
from contiga.simulation.model import ContactPart, OutputOptions

from .sameness import same_history, same_output, same_states

Make = Callable[..., Simulation]
StopAfter = Callable[[int], Callable[[int, int, int], None]]


@pytest.mark.parametrize("every", [1, 4])
@pytest.mark.parametrize("steps", [1, 5, 12, 13])
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


@pytest.mark.parametrize("every", [3, 4])
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


def _other_weights(s: Simulation) -> Simulation:
    (patch,) = s.bodies["ball"].body.patches
    weights = np.asarray(patch.weights).copy()
    weights[1, 1] *= 1.01
    other = cg.NurbsSurface(patch.degrees, patch.knots, patch.control_points, weights)
    return replace(s, bodies={"ball": s.bodies["ball"]._replace(body=Body([other]))})


def _other_options(s: Simulation) -> Simulation:
    (part,) = s.contacts
    contact = cg.Contact(part.contact.master, part.contact.slave, law=part.contact.law,
                         search="penetration")  # fmt: skip
    return replace(s, contacts=(ContactPart("dip", "ball", "sheet", contact),))


def _other_motion(s: Simulation) -> Simulation:
    moved = Translate([[0, 0, 0, 0], [12, 0.2, 0, -0.25]])
    return replace(s, bodies={"ball": s.bodies["ball"]._replace(motion=moved)})


def _other_thickness(s: Simulation) -> Simulation:
    old = s.slaves["sheet"]
    slave = cg.Slave(old.slave.points, old.slave.facets, thickness=np.full(225, 0.6))
    return replace(s, slaves={"sheet": old._replace(slave=slave)})


def _contact(**options: object) -> Callable[[Simulation], Simulation]:
    def change(s: Simulation) -> Simulation:
        (part,) = s.contacts
        old = part.contact
        given = {"law": old.law, **options}
        contact = cg.Contact(old.master, old.slave, **given)  # type: ignore[arg-type]
        return replace(s, contacts=(part._replace(contact=contact),))

    return change


def _other_way_of_the_slave(s: Simulation) -> Simulation:
    old = s.slaves["sheet"]
    aside = Translate([[0, 0, 0, 0], [6, 0.1, 0, 0], [12, 0, 0, 0]])
    moved = Moved(old.slave.points, aside)
    return replace(s, slaves={"sheet": old._replace(motion=moved)})


def _other_facets(s: Simulation) -> Simulation:
    old = s.slaves["sheet"].slave
    assert old.facets is not None
    slave = cg.Slave(
        old.points, old.facets[:-1], area=old.area, thickness=old.thickness, active=old.active
    )
    return replace(s, slaves={"sheet": s.slaves["sheet"]._replace(slave=slave)})


TABLE = [[0, 0], [0.1, 1.0], [1.0, 3.0]]
OTHERS = {
    "law's table": _contact(law=cg.StressLaw([[0, 0], [0.1, 1.1], [1.0, 3.0]], damping=0.2)),
    "law's number": _contact(law=cg.StressLaw(TABLE, damping=0.3)),
    "law's function": _contact(law=cg.StressLaw(lambda x: 10.0 * x, damping=0.2)),
    "depth": _contact(depth=0.4),
    "through": _contact(through="hold"),
    "area": _contact(area=cg.NodalArea()),
    "area's option": _contact(area=cg.FacetArea(on="master")),
    "facets": _other_facets,
    "way of the slave": _other_way_of_the_slave,
    "what is written": lambda s: replace(s, output=OutputOptions(every=2)),
    "text": lambda s: replace(s, case_text="friction = 0.3\n"),
    "times": lambda s: replace(s, stepping=GivenTimes(1.5 * s.stepping.planned())),
    "weights": _other_weights,
    "options": _other_options,
    "motion": _other_motion,
    "thickness": _other_thickness,
}


@pytest.mark.parametrize("what", OTHERS)
def test_a_checkpoint_of_another_case_is_told(
    simulation: Simulation, stop_after: StopAfter, stop: type[Exception], tmp_path: Path, what: str
) -> None:
    with pytest.raises(stop):
        simulation.run(tmp_path, progress=stop_after(4))
    before = sorted(path.name for path in tmp_path.iterdir())
    with pytest.raises(CheckpointError, match="another case") as error:
        OTHERS[what](simulation).run(tmp_path, resume=True)
    assert error.value.exit_code == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == before
    # The right case still goes on.
    assert len(simulation.run(tmp_path, resume=True).history["time"]) == 13


def test_equal_cases_built_twice_have_one_fingerprint(make: Make) -> None:
    assert make().fingerprint() == make().fingerprint()


def test_what_chooses_steps_tells(make: Make) -> None:
    def case(**options: float) -> str:
        return make(stepping=AutoSteps(0.0, 12.0, **options)).fingerprint()

    assert case(safety=0.9) == case() != case(safety=0.8)
    assert case(shortest=0.0) == case() != case(shortest=1e-3)


def test_what_is_only_told_of_a_case_tells_it_from_no_other(make: Make) -> None:
    def case(title: str, report: str, every: int) -> str:
        text = f'title = "{title}"\n\n[output]\nevery = {every}\nreport = {report}\n'
        return make(case_text=text).fingerprint()

    assert case("one", "true", 1) == case("another", "false", 1)
    assert case("one", "true", 1) != case("one", "true", 2)


def test_functions_are_told_apart_by_what_they_do(make: Make) -> None:
    def law(factor: float) -> cg.StressLaw:
        return cg.StressLaw(lambda x: np.where(x > 0.7, factor, 1.0) * x, thickness=0.5)

    def fingerprint(law: cg.StressLaw) -> str:
        return _contact(law=law)(make()).fingerprint()

    # They differ beyond every argument they are tried at: the closure tells.
    assert fingerprint(law(2.0)) == fingerprint(law(2.0))
    assert fingerprint(law(2.0)) != fingerprint(law(3.0))


def test_a_law_that_cannot_be_known_again_is_told(
    make: Make, stop_after: StopAfter, stop: type[Exception], tmp_path: Path
) -> None:
    law = cg.StressLaw(TABLE)
    object.__setattr__(law, "guard", threading.Lock())
    simulation = _contact(law=law)(make())
    with pytest.raises(stop):
        simulation.run(tmp_path, progress=stop_after(4))
    with pytest.warns(cg.errors.ContigaWarning, match=r"lock is compiled: whether it is what it"):
        simulation.run(tmp_path, resume=True)


def test_a_folder_that_was_moved_is_the_same_case(make: Make, tmp_path: Path) -> None:
    def simulation(folder: Path) -> Simulation:
        text = f'geometry = {{ file = "{folder.as_posix()}/part.step" }}\n'
        return make(case_text=text, base_folder=folder)

    here, there = simulation(tmp_path / "here"), simulation(tmp_path / "there")
    assert here.fingerprint() == there.fingerprint()
    other = replace(here, case_text=here.case_text.replace("part.step", "other.step"))
    assert other.fingerprint() != here.fingerprint()


def test_a_checkpoint_keeps_every_bit(simulation: Simulation, tmp_path: Path) -> None:
    result = simulation.run(tmp_path)
    read = read_checkpoint(tmp_path / "checkpoint.h5", simulation)
    assert (read.done, read.written) == (13, 13)
    assert read.peak == (result.history["force"].max(), np.argmax(result.history["force"]), None)
    same_states(read.state, result.state)
    same_history(read.history, result.history)
