"""Whole runs: history, files, several contacts, what is left after errors."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga import Simulation
from contiga.dynamics.stepping import GivenTimes
from contiga.errors import InputError, OutputError
from contiga.io.out.history import read_history
from contiga.io.out.outlines import read_outlines
from contiga.io.out.vtkhdf import read_fields
from contiga.records import ContactStatus as Is
from contiga.simulation import step as step_module
from contiga.simulation.history import STATUS_OF_COLUMN
from contiga.simulation.model import ContactPart, OutputOptions

Make = Callable[..., Simulation]

COLUMNS = [
    "time",
    *("n_contact", "max_penetration", "force_x", "force_y", "force_z", "force"),
    *("moment_x", "moment_y", "moment_z", "area", "n_clusters", "mean_pressure", "max_pressure"),
    *("centre_x", "centre_y", "centre_z", "work", "energy_stored", "energy_hysteresis"),
    *("energy_damping", "energy_friction", "energy_error", "wall_time"),
    *STATUS_OF_COLUMN,
    "n_unproved",
    "n_tunnelled",
]


def test_the_history_has_a_row_a_step_of_what_the_states_say(simulation: Simulation) -> None:
    (part,) = simulation.contacts
    history = simulation.run().history
    assert list(history) == COLUMNS
    np.testing.assert_array_equal(history["time"], simulation.stepping.planned())
    motion = simulation.bodies["ball"].motion
    points = simulation.slaves["sheet"].slave.points
    state = part.contact.start(points, motion.pose(0.0))
    for k, time in enumerate(simulation.stepping.planned()):
        if k:
            dt = time - simulation.stepping.planned()[k - 1]
            at_rest = np.zeros_like(points)
            state = part.contact.step(
                state,
                points,
                motion.pose(time),
                dt,
                velocity=at_rest,
                twist=motion.twist(time),
            )
        expected = {
            "n_contact": state.n_contact,
            "max_penetration": state.max_penetration,
            "force": float(np.linalg.norm(state.total_force)),
            "area": state.total_area,
            "n_clusters": state.n_clusters,
            "mean_pressure": state.mean_pressure,
            "max_pressure": state.max_pressure,
            "n_unproved": state.n_unproved,
        } | dict(zip(("force_x", "force_y", "force_z"), state.total_force, strict=True))
        expected |= dict(zip(("moment_x", "moment_y", "moment_z"), state.wrench[3:], strict=True))
        expected |= {name: int((state.status == s).sum()) for name, s in STATUS_OF_COLUMN.items()}
        for name, value in expected.items():
            assert history[name][k] == pytest.approx(value, rel=1e-15, abs=0.0), (name, k)
    assert history["n_contact"].max() > 10
    assert history["n_contact"][[0, -1]].tolist() == [0, 0]


def test_counts_add_up(simulation: Simulation) -> None:
    history = simulation.run().history
    carried = history["n_new"] + history["n_old"] + history["n_held"]
    np.testing.assert_array_equal(carried, history["n_contact"])
    gone = history["n_released"] + history["n_slid_off"] + history["n_lost"]
    np.testing.assert_array_equal(np.diff(history["n_contact"]), history["n_new"][1:] - gone[1:])
    assert all(history[name].dtype == np.int64 for name in history if name.startswith("n_"))


def test_a_run_in_memory_is_the_run_on_disk(simulation: Simulation, tmp_path: Path) -> None:
    in_memory, on_disk = simulation.run(), simulation.run(tmp_path / "out")
    assert in_memory.out is None
    assert on_disk.out == tmp_path / "out"
    read = read_history(tmp_path / "out" / "history.csv")
    assert list(read) == list(in_memory.history)
    for name, column in in_memory.history.items():
        if name != "wall_time":
            np.testing.assert_array_equal(column, on_disk.history[name])
            np.testing.assert_array_equal(column, read[name])


def test_the_folder_holds_whole_files_only(simulation: Simulation, tmp_path: Path) -> None:
    simulation.run(tmp_path)
    names = sorted(path.name for path in tmp_path.iterdir())
    expected = ["case.toml", "checkpoint.h5", "fields.vtkhdf", "history.csv"]
    expected += ["outlines.vtkhdf", "summary.json"]
    assert names == expected
    assert (tmp_path / "case.toml").read_text() == simulation.case_text


def test_the_fields_are_those_of_the_states(simulation: Simulation, tmp_path: Path) -> None:
    result = simulation.run(tmp_path)
    (part,) = simulation.contacts
    fields = read_fields(tmp_path / "fields.vtkhdf")
    np.testing.assert_array_equal(fields.times, simulation.stepping.planned())
    rows = fields.rows("sheet")
    bodies = fields.rows("ball")
    points = simulation.slaves["sheet"].slave.points
    state = part.contact.start(points)
    for k, time in enumerate(simulation.stepping.planned()):
        X_WB = simulation.bodies["ball"].motion.pose(time)
        if k:
            dt = time - simulation.stepping.planned()[k - 1]
            twist = simulation.bodies["ball"].motion.twist(time)
            still = np.zeros_like(points)
            state = part.contact.step(state, points, X_WB, dt, velocity=still, twist=twist)
        on = state.in_contact
        np.testing.assert_array_equal(fields.points(k)[rows], points)
        for name, values in (
            ("contact_status", state.status),
            ("penetration", state.penetration),
            ("gap", np.where(on, -state.penetration, np.nan)),
            ("normal", state.normal),
            ("force", state.force),
            ("area", state.area),
            ("pressure", state.pressure),
            ("cluster", state.clusters),
        ):
            np.testing.assert_array_equal(fields.data(k, name)[rows], values, err_msg=name)
        assert (fields.data(k, "contact_status")[bodies] == -1).all()
        centre = X_WB[:3] @ [0.0, 0.0, 0.55, 1.0]
        distance = np.linalg.norm(fields.points(k)[bodies] - centre, axis=1)
        np.testing.assert_allclose(distance, 0.5, rtol=0, atol=1e-12)
    assert result.state.contacts["dip"].n_contact == state.n_contact


@pytest.mark.parametrize(
    ("every", "expected"),
    [
        (1, list(range(13))),
        (5, [0, 5, 6, 10, 12]),
        (6, [0, 6, 12]),
        (12, [0, 6, 12]),
        (100, [0, 6, 12]),
    ],
)
def test_fields_at_every_so_many_steps_at_the_peak_and_at_the_last(
    make: Make, tmp_path: Path, every: int, expected: list[int]
) -> None:
    simulation = make(output=OutputOptions(every=every))
    result = simulation.run(tmp_path)
    fields = read_fields(tmp_path / "fields.vtkhdf")
    np.testing.assert_array_equal(fields.times, simulation.stepping.planned()[expected])
    np.testing.assert_array_equal(
        read_outlines(tmp_path / "outlines.vtkhdf").times, simulation.stepping.planned()[expected]
    )
    assert len(result.history["time"]) == 13
    assert np.argmax(result.history["force"]) == 6, "the peak of the case"


def test_what_is_written_of_the_peak_is_its_own(make: Make, tmp_path: Path) -> None:
    whole = make().run(tmp_path / "whole")
    make(output=OutputOptions(every=100)).run(tmp_path / "few")
    one, other = (read_fields(tmp_path / k / "fields.vtkhdf") for k in ("whole", "few"))
    peak = int(np.argmax(whole.history["force"]))
    np.testing.assert_array_equal(other.points(1), one.points(peak))
    for name in one.names:
        assert other.data(1, name).tobytes() == one.data(peak, name).tobytes()
    lines = [
        read_outlines(tmp_path / k / "outlines.vtkhdf").loops(i)
        for k, i in (("whole", peak), ("few", 1))
    ]
    assert len(lines[0].points) > 0
    for a, b in zip(*lines, strict=True):
        assert a.tobytes() == b.tobytes()


def test_areas_are_measured_at_the_steps_that_are_written(make: Make, tmp_path: Path) -> None:
    history = make(output=OutputOptions(every=5)).run(tmp_path).history
    every = make().run().history
    written = [0, 5, 6, 10, 12]
    for name in ("area", "n_clusters", "mean_pressure"):
        assert np.flatnonzero(np.isfinite(history[name])).tolist() == written
        np.testing.assert_array_equal(history[name][written], every[name][written])
    for name in ("force", "max_pressure", "work", "n_contact"):
        np.testing.assert_array_equal(history[name], every[name])
    rows = (tmp_path / "history.csv").read_text().splitlines()
    assert rows[2].split(",")[rows[0].split(",").index("area [mm^2]")] == "nan"


def test_measured_areas_as_weights_are_told_and_warned_of(make: Make) -> None:
    (part,) = make().contacts
    own = part.contact
    contact = cg.Contact(own.master, own.slave, law=own.law, weights="area")
    result = make(contacts=(part._replace(contact=contact),), output=OutputOptions(every=5)).run()
    assert np.isfinite(result.history["area"]).all()
    (warning,) = (text for text in result.summary["warnings"] if "weights" in text)
    error, work = result.history["energy_error"][-1], result.history["work"].max()
    assert f"{error:.3g}" in warning
    assert f"{work:.3g}" in warning


def test_the_ledger_of_a_run_closes(make: Make) -> None:
    history = make(stepping=GivenTimes(np.linspace(0.0, 12.0, 601))).run().history
    assert history["energy_damping"][-1] > 0.03 * history["work"].max()
    assert history["energy_stored"][-1] == 0.0
    assert np.abs(history["energy_error"]).max() < 2e-4 * history["work"].max()


@pytest.mark.parametrize("formats", [(), ("csv",), ("vtkhdf",)])
def test_only_the_formats_asked_for_are_written(
    make: Make, tmp_path: Path, formats: tuple[str, ...]
) -> None:
    make(output=OutputOptions(formats=formats)).run(tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    written = {"csv": ["history.csv"], "vtkhdf": ["fields.vtkhdf", "outlines.vtkhdf"]}
    expected = {file for name in formats for file in written[name]}
    assert names == expected | {"case.toml", "checkpoint.h5", "summary.json"}


def test_progress_is_told_at_every_step(simulation: Simulation) -> None:
    calls: list[tuple[int, int, int]] = []
    result = simulation.run(progress=lambda *args: calls.append(args))
    assert [call[0] for call in calls] == list(range(1, 14))
    assert {call[1] for call in calls} == {13}
    np.testing.assert_array_equal([call[2] for call in calls], result.history["n_contact"])


def test_the_summary_counts_and_times(simulation: Simulation, tmp_path: Path) -> None:
    result = simulation.run(tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary == json.loads(json.dumps(result.summary))
    assert summary["title"] == simulation.title
    assert summary["units"] == {"length": "mm", "mass": "g", "time": "ms"}
    assert (summary["steps"], summary["n_points"]) == (12, 225)
    assert summary["statuses"]["dip"]["NEW"] == result.history["n_new"].sum()
    assert summary["inputs"]["ball"]["patches"] == 1
    assert summary["inputs"]["sheet"]["facets"] == 2 * 14**2
    assert summary["warnings"] == summary["notes"] == []
    counted = {name for name, n in summary["statuses"]["dip"].items() if n}
    assert {"NEW", "OLD"} <= counted
    assert summary["advice"] == {s.name: s.advice for s in cg.ContactStatus if s.name in counted}
    timings = summary["timings"]
    stages = ("search", "area", "forces", "output", "compile", "total")
    assert all(timings[stage] >= 0.0 for stage in stages)
    assert timings["search"] + timings["forces"] + timings["output"] <= timings["total"]


def _two(make: Make) -> Simulation:
    simulation = make()
    ball = simulation.bodies["ball"]
    sheet = simulation.slaves["sheet"].slave
    floor = cg.Body([cg.shapes.plane(width=3.0, length=3.0, centre=(0.0, 0.0, 0.1))])
    fixed = type(simulation.slaves["sheet"].motion.motion)()
    contact = cg.Contact(floor, sheet, law=cg.PenaltyLaw(3.0), search="penetration")
    return replace(
        simulation,
        bodies={"ball": ball, "floor": type(ball)(floor, fixed)},
        contacts=(*simulation.contacts, ContactPart("stand", "floor", "sheet", contact)),
    )


def test_several_contacts_prefix_their_columns(make: Make) -> None:
    two, one = _two(make).run().history, make().run().history
    names = [f"{contact}.{name}" for contact in ("dip", "stand") for name in COLUMNS[1:]]
    assert list(two) == ["time", *names]
    for name in COLUMNS[1:]:
        if name != "wall_time":
            np.testing.assert_array_equal(two[f"dip.{name}"], one[name])
    assert (two["stand.n_contact"] == 225).all()
    np.testing.assert_allclose(two["stand.force_z"], 225 * 3.0 * 0.1, rtol=1e-12)


def test_several_contacts_lay_their_fields_together(make: Make, tmp_path: Path) -> None:
    result = _two(make).run(tmp_path)
    fields = read_fields(tmp_path / "fields.vtkhdf")
    peak = int(result.history["dip.n_contact"].argmax())
    rows = fields.rows("sheet")
    force = fields.data(peak, "force")[rows].sum(axis=0)
    both = [
        sum(result.history[f"{name}.force_{axis}"][peak] for name in ("dip", "stand"))
        for axis in "xyz"
    ]
    np.testing.assert_allclose(force, both, rtol=1e-12, atol=1e-12)
    status = fields.data(peak, "contact_status")[rows]
    assert np.isin(status, (Is.NEW, Is.OLD)).all()


def test_an_error_in_the_middle_comes_out_and_leaves_a_checkpoint(
    simulation: Simulation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = step_module.place

    def place(sim: Simulation, last: object, time: float) -> object:
        if time > 4.5:
            raise InputError("a file of the series is missing")
        return real(sim, last, time)

    monkeypatch.setattr(step_module, "place", place)
    with pytest.raises(InputError, match="series"):
        simulation.run(tmp_path / "out")
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names - {"checkpoint.before.h5"} == {
        "checkpoint.h5",
        "fields.vtkhdf.part",
        "outlines.vtkhdf.part",
    }


def test_an_error_at_the_start_leaves_nothing(
    simulation: Simulation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def place(_: Simulation, __: object, ___: float) -> object:
        raise InputError("wrong from the start")

    monkeypatch.setattr(step_module, "place", place)
    with pytest.raises(InputError, match="from the start"):
        simulation.run(tmp_path / "out")
    assert not (tmp_path / "out").exists()
    (tmp_path / "own").mkdir()
    with pytest.raises(InputError, match="from the start"):
        simulation.run(tmp_path / "own")
    assert list((tmp_path / "own").iterdir()) == []


def test_an_output_folder_that_is_a_file_is_refused(simulation: Simulation, tmp_path: Path) -> None:
    (tmp_path / "out").write_text("mine")
    for path in (tmp_path / "out", tmp_path / "out" / "below"):
        with pytest.raises(OutputError) as error:
            simulation.run(path)
        assert str(path) in str(error.value)
        assert error.value.exit_code == 2
    assert (tmp_path / "out").read_text() == "mine"


def test_a_folder_of_other_files_is_left_alone(simulation: Simulation, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(OutputError, match="not of a run") as error:
        simulation.run(tmp_path)
    assert error.value.found == "thesis.tex"
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_run_replaces_an_earlier_one(make: Make, tmp_path: Path) -> None:
    make().run(tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    short = make(stepping=GivenTimes([0.0, 1.0]), title="short")
    short.run(tmp_path)
    assert len(read_history(tmp_path / "history.csv")["time"]) == 2
    assert len(read_fields(tmp_path / "fields.vtkhdf").times) == 2
    assert json.loads((tmp_path / "summary.json").read_text())["title"] == "short"
    assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize(
    ("formats", "gone"),
    [
        (("csv",), {"fields.vtkhdf", "outlines.vtkhdf", "report.html", "peak.png"}),
        (("vtkhdf",), {"history.csv", "report.html", "peak.png"}),
    ],
)
def test_an_earlier_runs_results_do_not_stay_beside_new_ones(
    make: Make, tmp_path: Path, formats: tuple[str, ...], gone: set[str]
) -> None:
    make().run(tmp_path)
    for name in ("report.html", "peak.png"):
        (tmp_path / name).write_text("of the first run")
    first = {path.name for path in tmp_path.iterdir()}
    assert gone <= first
    make(stepping=GivenTimes([0.0, 1.0]), output=OutputOptions(formats=formats)).run(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == first - gone


def test_a_case_alone_does_not_make_a_folder_that_of_a_run(
    simulation: Simulation, tmp_path: Path
) -> None:
    (tmp_path / "case.toml").write_text("mine")
    with pytest.raises(OutputError, match="not of a run"):
        simulation.run(tmp_path)
    assert (tmp_path / "case.toml").read_text() == "mine"


WRONG = {
    "no contacts": ({"contacts": ()}, "there must be contacts"),
    "bodies": ({"bodies": {}}, "names a master that is not there"),
    "slaves": ({"slaves": {}}, "names a slave that is not there"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_simulation_that_cannot_run_is_not_made(make: Make, what: str) -> None:
    changes, message = WRONG[what]
    with pytest.raises(InputError, match=message):
        make(**changes)
