"""Stop a run at the first point whose foot is not certified."""

from __future__ import annotations

import numpy as np

from contiga.errors import RunError
from contiga.records import ContactStatus
from contiga.simulation.system_state import SystemState

DOUBTFUL = {
    ContactStatus.LOST: "could not be solved",
    ContactStatus.FOUND: "lies inside and was not seen to come in",
    ContactStatus.REACQUIRED: "has lost its foot, which was found again elsewhere",
}


def check_proved(state: SystemState) -> None:
    """Raise `RunError` with contact, time, point and status if a point is not certified."""
    for name, contact in state.contacts.items():
        doubts = []
        for status, text in DOUBTFUL.items():
            rows = np.flatnonzero(contact.status == status)
            if len(rows):
                doubts.append(f"point {rows[0]} {text} ({status.name}, {len(rows)} points)")
        rows = np.flatnonzero(contact.in_contact & (contact.certified == 0))
        if len(rows):
            what = "is converged but not proved"
            doubts.append(f"the foot of point {rows[0]} {what} ({len(rows)} points)")
        if doubts:
            remedy = "Take smaller steps, or run without --strict"
            raise RunError(f"{name}: at t = {state.time:g} {doubts[0]}. {remedy}")
