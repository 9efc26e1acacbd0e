"""Find how far one part is to be moved along a line until its gap to another is a given one."""

from __future__ import annotations

from contiga.errors import InputError
from contiga.placement.pair import Pair

_STEP = 2e-4
"""Least step along the line, in parts of the body's size: what grazes within it may be passed."""
_ROUNDS = 20


def shift_to_gap(pair: Pair, gap: float, most: tuple[float, float]) -> float | None:
    """The way along the line to the place where the least gap is `gap`; None if there is none.

    From a place that is free, no point nearer than `gap`, forward to the first such place; from
    one that is not, back to the last such place before it. Gaps change by no more than the way
    moved, so no step as long as the least gap passes the place (sphere tracing: Hart, 1996).
    Points of two bodies are added where they come closest until that changes nothing.

    Parameters
    ----------
    pair : the two parts, moved along the line
    gap : length
    most : how far to look forward and back, length

    Raises
    ------
    InputError
        The gap jumps over the one wanted: points come round the border of an open body. Or places
        still nearer are found each time it is reached.
    """
    shift: float | None = 0.0
    for _ in range(_ROUNDS):
        assert shift is not None
        free = pair.least(shift) - gap
        if free < -pair.tolerance:
            shift = _back(pair, gap, (shift, -most[1]))
        elif free > pair.tolerance:
            shift = _forward(pair, gap, (shift, most[0]))
        if shift is None or not pair.sharpen(shift):
            return shift
    assert shift is not None
    if abs(pair.least(shift) - gap) <= pair.tolerance:
        return shift
    raise InputError(
        f"the gap is not settled: each of {_ROUNDS} rounds found places that are nearer still",
        where="direction",
        found=f"a gap of {pair.least(shift):.6g} where {gap:.6g} is sought",
        allowed=f"within {pair.tolerance:.3g}",
        remedy="Place it by slaves instead: points that stand for the places meant to touch",
    )


def _forward(pair: Pair, gap: float, span: tuple[float, float]) -> float | None:
    """The first place from span[0], where all is free, to span[1] with the least gap `gap`."""
    shift, end = span
    while True:
        free = pair.least(shift) - gap
        if free <= pair.tolerance:
            break
        before, shift = shift, shift + max(free, _STEP * pair.size)
        if shift > end:
            return None
    return shift if free >= -pair.tolerance else _between(pair, gap, (before, shift))


def _back(pair: Pair, gap: float, span: tuple[float, float]) -> float | None:
    """The last place before span[0], where not all is free, and not before span[1]."""
    shift, end = span
    while True:
        free = pair.least(shift) - gap
        if free >= -pair.tolerance:
            break
        before, shift = shift, shift - max(-free, _STEP * pair.size)
        if before < end:
            return None
    return shift if free <= pair.tolerance else _between(pair, gap, (shift, before))


def _between(pair: Pair, gap: float, span: tuple[float, float]) -> float:
    """The place between a free one and one that is not at which the least gap is `gap`."""
    from scipy.optimize import brentq  # which few cases need takes longer to load than numba

    def free(shift: float) -> float:
        return pair.least(shift) - gap

    shift = float(brentq(free, *span, xtol=0.25 * pair.tolerance, rtol=1e-15))
    if abs(free(shift)) > pair.tolerance:
        raise InputError(
            "the gap jumps on the way: points come round the border of an open body",
            where="direction",
            remedy="Choose another direction, or start from the free side",
        )
    return shift
