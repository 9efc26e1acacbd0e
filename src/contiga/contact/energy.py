"""Where the work done on a contact goes, step by step."""

from __future__ import annotations

from typing import NamedTuple


class ContactEnergy(NamedTuple):
    """Energies of a contact since its start. Only `stored` is a state; the others add up."""

    work: float
    """Done on the contact by what moves its two sides, by the trapezoidal rule over each step, just
    the work by which a central difference or Verlet integrator moves bodies; what was stored at the
    start counts as done."""
    stored: float
    """What the law and sticking friction would give back."""
    hysteresis: float
    """Lost as the law unloads by another curve than it loads."""
    damping: float
    """Taken by the law's damping."""
    friction: float
    """Taken by sliding."""

    @property
    def error(self) -> float:
        """Error of the energy balance: that of integrating over steps, which falls with their
        square, and what forces that are no gradient make or lose."""
        return self.work - self.stored - self.hysteresis - self.damping - self.friction
