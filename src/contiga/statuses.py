"""Results of kernels for a point, as enumerations whose members have an advice."""

from __future__ import annotations

from enum import IntEnum
from typing import Self


class Advised(IntEnum):
    """Numbers with a sentence for users: their meaning, and what to do.

    >>> Status(3).advice
    'Not converged; take smaller steps, or project with mode="global".'
    """

    advice: str

    def __new__(cls, value: int, advice: str) -> Self:
        member = int.__new__(cls, value)
        member._value_ = value
        member.advice = advice
        return member


class Feature(Advised):
    """Feature that a foot lies on, which defines the normal there."""

    NONE = -1, "There is no foot: the status says why."
    FACE = 0, "The foot lies inside a face, and the normal is the surface's."
    EDGE = (
        1,
        "The foot lies on an edge (a crease between faces, a trimmed or a natural border); take "
        "the normal of the record, not that of one face.",
    )
    VERTEX = (
        2,
        "The foot lies on a corner, or on a pole where a whole side of a patch is one point; take "
        "the normal of the record, not that of one face.",
    )


class Status(Advised):
    """Outcome of a projection or first hit of one point."""

    OK = 0, "Converged: the foot is a stationary point, or the closest point of a border."
    BORDER = (
        1,
        "Converged on a true border: the surface ends before the foot's normal reaches the point, "
        "and a contact releases or holds such a point as its on_edge says.",
    )
    TRIMMED = (
        2,
        "The tracked foot ran into a part of the patch that is trimmed away; project with "
        'mode="global" for the closest point of what is left.',
    )
    MAX_ITERATIONS = 3, 'Not converged; take smaller steps, or project with mode="global".'
    BRANCH_EVENT = (
        4,
        "Newton's method from the last foot has come to no minimum, as where a point crosses a "
        "focal surface: the foot is the closest point instead; smaller steps show where.",
    )
    NOT_FINITE = 5, "The point has a NaN or infinite coordinate; mend the input."
    NO_HIT = (
        6,
        "The segment meets the surface nowhere from its free side (first hit only); where it "
        "should, look at its ends and at the side the normals point to.",
    )
    AT_START = (
        7,
        "The segment starts on the surface and leads inside, so that its fraction is 0 (first hit "
        "only).",
    )
    BUDGET = (
        8,
        "The search opened as many cells as it may, and its answer is the best found, not proved "
        "(of a first hit perhaps none); mend the geometry there: weights that differ by many "
        "decades, collapsed or folded patches.",
    )
