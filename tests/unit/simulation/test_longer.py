"""A run that had ended goes on to a later end, with the bits of one run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.sample import full

import contiga as cg
from contiga import Simulation
from contiga.dynamics.stepping import AutoSteps, EqualSteps, GivenTimes
from contiga.errors import CheckpointError
from contiga.io.out.vtkhdf import read_fields
from contiga.simulation.model import OutputOptions

from .sameness import same_history, same_output, same_states

Make = Callable[..., Simulation]
StopAfter = Callable[[int], Callable[[int, int, int], None]]


def until(whole: Simulation, k: int) -> Simulation:
    """The simulation as far as the step of row `k`."""
    return replace(whole, stepping=GivenTimes(whole.stepping.planned()[: k + 1]))


@pytest.mark.parametrize(
    ("output", "ends"),
    [
        ({"every": 1}, (6,)), ({"every": 3}, (4,)), ({"every": 4}, (1,)), ({"every": 4}, (8,)),
        ({"every": 4}, (5, 6, 10)), ({"interval": 0.7}, (5, 6, 10)),
    ],
)  # fmt: skip
def test_a_longer_run_is_one_run(
    make: Make, tmp_path: Path, output: dict[str, float], ends: tuple[int, ...]
) -> None:
    whole = make(output=OutputOptions(**output))
    expected = whole.run(tmp_path / "whole")
    for i, k in enumerate(ends):
        until(whole, k).run(tmp_path / "parts", resume=i > 0)
        assert (tmp_path / "parts" / "history.csv").is_file()
    result = whole.run(tmp_path / "parts", resume=True)
    same_history(expected.history, result.history)
    same_states(expected.state, result.state)
    same_output(tmp_path)
    assert result.summary["notes"] == expected.summary["notes"]
    names = [sorted(p.name for p in (tmp_path / k).iterdir()) for k in ("whole", "parts")]
    assert names[0] == names[1]


def test_what_a_run_left_stays_until_the_longer_one_is_through(
    make: Make, stop_after: StopAfter, stop: type[Exception], tmp_path: Path
) -> None:
    whole = make(output=OutputOptions(every=4))
    expected = whole.run(tmp_path / "whole")
    until(whole, 6).run(tmp_path / "parts")
    before = (tmp_path / "parts" / "history.csv").read_bytes()
    for steps in (8, 9):
        with pytest.raises(stop):
            whole.run(tmp_path / "parts", resume=True, progress=stop_after(steps))
        assert (tmp_path / "parts" / "history.csv").read_bytes() == before
        assert len(read_fields(tmp_path / "parts" / "fields.vtkhdf").times) == 3
    result = whole.run(tmp_path / "parts", resume=True)
    same_history(expected.history, result.history)
    same_output(tmp_path)


def fall(end: float, stepping: type, step: float) -> Simulation:
    """A ball falls on a sheet, and bounces."""
    ball = cg.Body([cg.shapes.sphere(radius=1.0, centre=(0.0, 0.0, 1.1))])
    points = cg.clouds.sample(cg.shapes.plane(width=1.0, length=1.0), 5, 5)
    sheet = cg.Slave(points, area=np.full(25, 0.04))
    mass = ball.mass_properties(1.0)
    free = cg.motion.Free(
        mass=mass.mass, centre=mass.centre, inertia=mass.inertia, velocity=(0, 0, -1)
    )
    law = cg.PenaltyLaw(500.0, per_area=True)
    text = f"[time]\nstart = 0.0\nend = {end!r}\nstep = {step!r}\n"
    return Simulation(
        bodies={"ball": (ball, free)},
        slaves={"sheet": sheet},
        contacts=[cg.Contact(ball, sheet, law=law)],
        stepping=stepping(0.0, end, largest=step)
        if stepping is AutoSteps
        else stepping(0.0, end, step),
        case_text=text,
        output=OutputOptions(every=3),
    )


def test_equal_steps_that_divide_are_those_of_one_run(tmp_path: Path) -> None:
    expected = fall(1.0, EqualSteps, 0.03125).run(tmp_path / "whole")
    fall(0.5, EqualSteps, 0.03125).run(tmp_path / "parts")
    result = fall(1.0, EqualSteps, 0.03125).run(tmp_path / "parts", resume=True)
    assert expected.history["n_contact"].max() > 0
    same_history(expected.history, result.history)
    same_states(expected.state, result.state)
    assert result.summary["notes"] == expected.summary["notes"]


@pytest.mark.parametrize(("stepping", "step"), [(EqualSteps, 0.03), *full((AutoSteps, 0.02))])
def test_it_is_told_where_the_bits_are_others(tmp_path: Path, stepping: type, step: float) -> None:
    expected = fall(1.0, stepping, step).run()
    fall(0.5, stepping, step).run(tmp_path)
    answer = fall(1.0, stepping, step).run(tmp_path, resume=True)
    (note,) = [text for text in answer.summary["notes"] if "went on" in text]
    assert "t = 0.5" in note
    assert "not bit for bit" in note
    last = [result.history["ball.z"][-1] for result in (expected, answer)]
    assert last[0] != last[1]
    np.testing.assert_allclose(last[1], last[0], atol=2e-3)


def test_an_earlier_end_is_refused(tmp_path: Path) -> None:
    fall(0.5, EqualSteps, 0.03125).run(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(CheckpointError, match=r"of a run to t = 0\.5.*an end of 0\.5 or later"):
        fall(0.25, EqualSteps, 0.03125).run(tmp_path, resume=True)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_another_step_is_another_case(tmp_path: Path) -> None:
    fall(0.5, EqualSteps, 0.03125).run(tmp_path)
    for other in (0.0625, 0.75):
        with pytest.raises(CheckpointError, match="another case"):
            fall(1.0, EqualSteps, other).run(tmp_path, resume=True)


def test_fields_that_are_gone_are_told(make: Make, tmp_path: Path) -> None:
    whole = make()
    until(whole, 6).run(tmp_path)
    (tmp_path / "fields.vtkhdf").unlink()
    with pytest.raises(CheckpointError, match="fields of the run that is to go on are not there"):
        whole.run(tmp_path, resume=True)
