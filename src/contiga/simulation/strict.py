"""Stopping a run at the first point whose search is not proved."""

from __future__ import annotations

import numpy as np

from contiga.contact.state import State
from contiga.errors import RunError
from contiga.records import ContactStatus
from contiga.simulation.system_state import SystemState

DOUBTFUL = {
    ContactStatus.LOST: "could not be solved",
    ContactStatus.FOUND: "lies inside and was not seen to come in",
    ContactStatus.REACQUIRED: "has lost its foot, which was found again elsewhere",
}


def check_proved(state: SystemState) -> None:
    """Refuse to go on where a point of any contact is not certified.

    Raises
    ------
    RunError
        Names the contact, the time, the first such point and what is the matter with it.
    """
    for name, contact in state.contacts.items():
        text = _first_doubt(contact)
        if text is not None:
            remedy = "Take smaller steps, or run without --strict"
            raise RunError(f"{name}: at t = {state.time:g} {text}. {remedy}")


def _first_doubt(state: State) -> str | None:
    for status, text in DOUBTFUL.items():
        rows = np.flatnonzero(state.status == status)
        if len(rows):
            return f"point {rows[0]} {text} ({status.name}, {len(rows)} points)"
    rows = np.flatnonzero(state.in_contact & (state.certified == 0))
    if len(rows):
        return f"the foot of point {rows[0]} is converged but not proved ({len(rows)} points)"
    return None
