"""What a run's summary says of the statuses that were counted."""

from __future__ import annotations

from pathlib import Path

import pytest

import contiga as cg
from contiga.cli.commands import _print_result
from contiga.records import ContactStatus as Is
from contiga.simulation.checks.layers import thickness_of
from contiga.simulation.clock import Clock
from contiga.simulation.simulation import Simulation
from contiga.simulation.summary import NOTED, WARNED, summarise


def test_what_was_counted_is_told_with_its_advice(
    simulation: Simulation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    history = {name: column.copy() for name, column in simulation.run().history.items()}
    history["n_lost"][3:5] = 2
    history["n_held"][4] = 1
    summary = summarise(simulation, history, Clock())
    lost = f"dip: 4 times LOST. {Is.LOST.advice}"
    held = f"dip: 1 times HELD. {Is.HELD.advice}"
    assert (summary["notes"], summary["warnings"]) == ([held], [lost])
    assert summary["advice"].keys() >= {"LOST", "HELD", "NEW"}
    assert "FOUND" not in summary["advice"]
    _print_result(summary, history, tmp_path)
    said = capsys.readouterr().out.splitlines()
    assert {f"note: {held}", f"warning: {lost}"} < set(said)


def test_every_status_that_asks_for_something_is_told() -> None:
    assert {*NOTED, *WARNED, Is.REACQUIRED, Is.FREE, Is.NEW, Is.OLD, Is.RELEASED} == set(Is)


@pytest.mark.parametrize(("feet", "warned"), [(2000, False), (1999, True)])
def test_feet_found_again_are_warned_of_where_they_are_many(
    simulation: Simulation, feet: int, warned: bool
) -> None:
    history = {name: column.copy() for name, column in simulation.run().history.items()}
    history["n_reacquired"][3] = 2
    history["n_contact"][:] = 0
    history["n_contact"][4] = feet
    summary = summarise(simulation, history, Clock())
    told = [f"dip: 2 times REACQUIRED. {Is.REACQUIRED.advice}"]
    assert (summary["notes"], summary["warnings"]) == (([], told) if warned else (told, []))


@pytest.mark.parametrize(
    ("law", "thickness", "told"),
    [
        (cg.StressLaw(1.0), [5.0, 5.0], 5.0),
        (cg.StressLaw(1.0, thickness=3.0), [5.0, 6.0], 3.0),
        (cg.StressLaw(1.0), [5.0, 6.0], None),
        (cg.PenaltyLaw(1.0), [5.0, 5.0], None),
    ],
)
def test_a_layer_of_one_thickness_is_told(
    law: object, thickness: list[float], told: float | None
) -> None:
    """The strain of a contact is its penetration over that."""
    slave = cg.Slave([[0.0, 0, 0], [1.0, 0, 0]], area=[1.0, 1.0], thickness=thickness)
    contact = cg.Contact(cg.Body(cg.shapes.sphere(radius=1.0)), slave, law=law)
    assert thickness_of(contact) == told
