"""Track the step with the greatest force of a run until it is written."""

from __future__ import annotations

from typing import NamedTuple

from contiga.simulation.system_state import SystemState


class Peak(NamedTuple):
    """The greatest force so far, of all contacts together."""

    force: float = 0.0
    row: int = -1
    """Of the history; −1 before there is any force."""
    state: SystemState | None = None
    """State that is still to be written; None once written."""

    def after(self, state: SystemState, force: float, row: int, *, written: bool) -> Peak:
        """Return the peak after one more step; `written` if its fields are written anyway."""
        if not force > self.force:  # nor where it is NaN
            return self
        return Peak(force, row, None if written else state)
