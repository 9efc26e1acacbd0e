"""Which step has the greatest force, and whether it waits to be written."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from contiga import Simulation
from contiga.simulation.checkpoint import Peak
from contiga.simulation.history import history_row, measured_columns, total_force
from contiga.simulation.model import ContactPart
from contiga.simulation.step import StepResult
from contiga.simulation.system_state import SystemState


@pytest.fixture
def state(simulation: Simulation) -> SystemState:
    return simulation.start()


def test_a_greater_force_waits_where_it_is_not_written(state: SystemState) -> None:
    peak = Peak().after(state, 2.0, 4, written=False)
    assert peak == (2.0, 4, state)
    assert peak.after(state, 3.0, 5, written=True) == (3.0, 5, None)


@pytest.mark.parametrize("force", [1.0, 2.0, np.nan])
def test_no_greater_force_changes_nothing(state: SystemState, force: float) -> None:
    peak = Peak(2.0, 4, state)
    for written in (False, True):
        assert peak.after(state, force, 5, written=written) is peak


@pytest.mark.parametrize("force", [0.0, np.nan])
def test_without_a_force_there_is_no_peak(state: SystemState, force: float) -> None:
    assert Peak().after(state, force, 0, written=False) == (0.0, -1, None)


def test_the_force_is_that_of_all_contacts(make: Callable[..., Simulation]) -> None:
    (part,) = make().contacts
    twice = tuple(ContactPart(name, part.master, part.slave, part.contact) for name in "ab")
    one, two = make(), make(contacts=twice)
    forces = []
    for simulation in (one, two):
        state = simulation.start()
        for _ in range(6):
            state = simulation.step(state)
        walls = dict.fromkeys(state.contacts, 0.0)
        row = history_row(simulation, StepResult(state, walls), None, measured=False)
        forces.append(total_force(simulation, row))
        measured = measured_columns(simulation, state)
        assert set(measured) == {name for name in row if np.isnan(row[name])}
        whole = history_row(simulation, StepResult(state, walls), None, measured=True)
        assert measured == {name: whole[name] for name in measured}
    assert forces[1] == 2.0 * forces[0] > 0.0
