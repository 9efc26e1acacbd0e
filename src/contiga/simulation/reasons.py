"""Define the reasons for the length of an automatic step, and the choice of a step."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple


class Reason(IntEnum):
    """The reason why a step is not longer. Histories contain the numbers: they never change."""

    LARGEST = 0
    GROWTH = 1
    SAMPLE = 2
    CRITICAL = 3
    SWING = 4
    TURN = 5
    KINK = 6
    END = 7
    WAY = 8
    CROSSING = 9
    STIFFER = 10
    ENERGY = 11
    SHORTEST = 12

    @property
    def text(self) -> str:
        """The reason in words."""
        return _TEXTS[self]

    @property
    def remedy(self) -> str:
        """Advice for longer steps; empty if there is none."""
        return _REMEDIES.get(self, "")


_TEXTS = {
    Reason.LARGEST: "no step is longer",
    Reason.GROWTH: "growth from the step before",
    Reason.SAMPLE: "samples for the filter of a sensor",
    Reason.CRITICAL: "share of the critical step",
    Reason.SWING: "the period of a body or node on its contacts and springs, or viscous friction",
    Reason.TURN: "a body turns",
    Reason.KINK: "a row of a table: load, pulse or motion",
    Reason.END: "the end of the run",
    Reason.WAY: "points go far against the master where they may touch",
    Reason.CROSSING: "points would go in and out within the step",
    Reason.STIFFER: "the contact or spring became stiffer within the step",
    Reason.ENERGY: "energy balance error too large",
    Reason.SHORTEST: "the shortest step that anything but stability may ask for",
}
_REMEDIES = {
    Reason.SAMPLE: "a lower class of filter",
    Reason.CRITICAL: "a softer law, less damping, or more mass where it is least",
    Reason.SWING: "a softer law or spring, or damping that brings what swings to rest",
    Reason.TURN: "a slower spin",
    Reason.KINK: "fewer rows in tables, or smooth ones",
    Reason.WAY: "a larger master, or less speed where it is near",
    Reason.CROSSING: "a thicker master, or less speed",
    Reason.STIFFER: "curves of laws without steep ends, and damping that sets in softly",
    Reason.ENERGY: "smooth normals, finer meshes, laws without jumps, or a larger time.shortest",
    Reason.SHORTEST: "smooth normals, finer meshes, laws without jumps, or a larger time.shortest",
}


class Cut(NamedTuple):
    """The longest step that is allowed, and the reason why it is not longer."""

    step: float
    """Length of the step, time."""
    reason: Reason
    of: str = ""
    """The contact, spring or body that limits the step; empty without one."""

    def text(self) -> str:
        """Return the choice in words.

        >>> Cut(0.1, Reason.TURN, "body 'wheel'").text()
        "a body turns (body 'wheel')"
        """
        return self.reason.text + (f" ({self.of})" if self.of else "")


class Choice(NamedTuple):
    """The choice of the length of a step, with its errors."""

    cut: Cut
    tries: int = 1
    """Number of steps computed, this one included."""
    energy_error: float = 0.0
    """Accepted energy balance error, which shorter steps have not reduced."""
    single: float = 0.0
    """ω h of single points whose swing the step does not follow."""
    lag: float = 0.0
    """Phase error of swinging single points in the step, radians."""
    late: float = 0.0
    """Time by which free nodes hand over a shared force early or late."""
