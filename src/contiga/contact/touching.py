"""The points in contact after a step, with all that is known of them before forces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact.kernels import carrying_nb
from contiga.contact.loads import NO_ROWS, NONE, NOWHERE
from contiga.contact.motion import RelativeVelocity
from contiga.contact.search_records import BoolArray, Detected
from contiga.contact.state import State
from contiga.contact.state_rows import kept_of
from contiga.jit import straight
from contiga.records import FloatArray, IndexArray, IntArray


class PreviousStep(NamedTuple):
    """How the points came where they are."""

    state: State
    """Of the last step."""
    dt: float
    velocity: RelativeVelocity | None
    """Against the body, where it is known exactly."""


class ContactRows(NamedTuple):
    """Points in contact, one row each, body axes."""

    rows: IntArray
    depth: FloatArray
    """(k,) λ."""
    normal: FloatArray
    foot: FloatArray
    path: FloatArray
    """(k, 3) against the body in the step; zero at the start and of points without a past."""
    old: BoolArray
    """(k,) whether each was in contact before."""
    rate: FloatArray
    """(k,) dλ/dt: exact where velocities are given, else of old contacts the change of λ over the
    step and of new ones their speed of approach; zero at the start."""
    velocity: FloatArray
    """(k, 3) against the body; (0, 3) where velocities are not given."""

    @classmethod
    def of(cls, rows: IntArray, velocity: FloatArray = NOWHERE) -> ContactRows:
        """Make one of these rows, with nothing else filled in."""
        k = len(rows)
        depth, rate, old = np.empty(k), np.empty(k), np.empty(k, np.bool_)
        three = np.empty((k, 3)), np.empty((k, 3)), np.empty((k, 3))
        return cls(rows, depth, *three, old, rate, velocity)

    def since(self, first: int) -> ContactRows:
        """Those of them from the point `first` on: the ones that carry forces."""
        if first == 0:
            return self
        k = int(np.searchsorted(self.rows, first))
        return ContactRows._make(values[k:] for values in self)


class LastDepths(NamedTuple):
    """Where points were at the last step, and how deep."""

    patch: IntArray
    """(n,) patch of their feet, −1 without contact."""
    points: FloatArray
    """(n, 3)."""
    rows: IndexArray
    """(k,) the points in contact, ascending."""
    depth: FloatArray
    """(k,) how deep they were."""


def touching(detected: Detected, p_B: FloatArray, past: PreviousStep | None) -> ContactRows:
    """What is known of the points in contact before forces."""
    rows, gather = detected.held, straight(carrying_nb.gather)
    if past is None:
        points = ContactRows.of(rows)
        last = LastDepths(np.full(len(p_B), -1, np.int32), p_B, NO_ROWS, NONE)
        gather(detected.feet, p_B, last, 1.0, points)
        points.rate.fill(0.0)
        return points
    state = past.state
    last = LastDepths(state.patch, state.points_B, *kept_of(state).deep)
    points = ContactRows.of(rows, NOWHERE if past.velocity is None else past.velocity.at(rows))
    gather(detected.feet, p_B, last, past.dt, points)
    return points
