"""Where the work done on a contact goes, step by step."""

from __future__ import annotations

from typing import NamedTuple

from contiga.records import FloatArray


class ContactEnergy(NamedTuple):
    """Energies of a contact since its start. Only `stored` is a state; the others add up."""

    work: float
    """Done on the contact by what moves its two sides, by the trapezoidal rule over each step;
    what was stored at the start counts as done."""
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
        """Work that is nowhere: the error of integrating over steps, which falls with their
        square, and what forces that are no gradient make or lose."""
        return self.work - self.stored - self.hysteresis - self.damping - self.friction


def half_work(force: FloatArray, path: FloatArray) -> float:
    """Work against forces (k, 3) at one end of the step, on points that went along `path` (k, 3),
    by the trapezoidal rule: half of it, the forces at the other end do the rest.

    A central difference or Verlet integrator moves bodies by just this work.
    """
    return float(-0.5 * (force * path).sum())
