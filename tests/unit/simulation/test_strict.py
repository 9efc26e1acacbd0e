"""A strict run stops at the first point that is not certified, and says which and why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import contiga as cg
from contiga.errors import RunError
from contiga.records import ContactStatus as Is
from contiga.simulation.run import check_proved
from contiga.simulation.system_state import Energy

PLANE = cg.Body([cg.shapes.plane()])


def _moment(status: int, certified: int) -> cg.SystemState:
    points = np.array([[0.0, 0.0, 0.1], [0.1, 0.0, 0.1]])
    contact = cg.Contact(PLANE, cg.Slave(points, area=[1.0, 1.0]), law=cg.PenaltyLaw(1.0))
    state = contact.start(points)
    state = replace(
        state,
        status=np.array([Is.FREE, status], np.int8),
        certified=np.array([0, certified], np.int8),
    )
    return cg.SystemState(2.5, {}, {}, {"pad": state}, Energy(0.0))


@pytest.mark.parametrize("status", [Is.FREE, Is.NEW, Is.OLD, Is.HELD, Is.RELEASED, Is.SLID_OFF])
def test_what_is_certified_goes_on(status: int) -> None:
    check_proved(_moment(status, 1))


@pytest.mark.parametrize(
    ("status", "certified", "words"),
    [
        (Is.LOST, 0, "could not be solved"),
        (Is.FOUND, 1, "was not seen to come in"),
        (Is.REACQUIRED, 1, "has lost its foot"),
        (Is.OLD, 0, "converged but not proved"),
    ],
)
def test_what_is_not_stops_the_run(status: int, certified: int, words: str) -> None:
    with pytest.raises(RunError, match=words) as error:
        check_proved(_moment(status, certified))
    assert "pad: at t = 2.5" in str(error.value)
    assert "point 1" in str(error.value)
