"""Find how far a part must move along a line until its gap to another has a given value."""

from __future__ import annotations

from contiga.errors import InputError
from contiga.placement.pair import Pair

_MIN_STEP = 2e-4
"""Least step along the line, as a share of the body's size."""
_MAX_ROUNDS = 20


def shift_to_gap(pair: Pair, gap: float, limits: tuple[float, float]) -> float | None:
    """Return the distance along the line at which the smallest gap is `gap`.

    It is None if there is no such place within `limits`. If no point is nearer than `gap`, search
    forward for the first such place, else back for the last such place behind. Gaps change by no
    more than the distance moved, so that no step as long as the smallest gap passes the place
    (sphere tracing: Hart, 1996). After each search `Pair.sharpen` adds the closest places of two
    bodies to the points of `pair`, and the search goes on from there until that changes nothing.

    Parameters
    ----------
    pair : the two parts, moved along the line; it collects points and gaps
    gap : length
    limits : largest distances forward and back, length

    Raises
    ------
    InputError
        The gap jumps over `gap`: points come round the border of an open body. Or each
        of 20 rounds adds places that are nearer than `gap` by more than the tolerance.
    """
    shift: float | None = 0.0
    for _ in range(_MAX_ROUNDS):
        assert shift is not None
        excess = pair.smallest_gap(shift) - gap
        if excess < -pair.tolerance:
            shift = _sphere_trace(pair, gap, shift, -1.0, limits[1])
        elif excess > pair.tolerance:
            shift = _sphere_trace(pair, gap, shift, 1.0, limits[0])
        if shift is None or not pair.sharpen(shift):
            return shift
    assert shift is not None
    if abs(pair.smallest_gap(shift) - gap) <= pair.tolerance:
        return shift
    raise InputError(
        f"the gap is not settled: each of {_MAX_ROUNDS} rounds found places that are nearer still",
        where="direction",
        found=f"a gap of {pair.smallest_gap(shift):.6g} where {gap:.6g} is sought",
        allowed=f"within {pair.tolerance:.3g}",
        remedy="Place it by slaves instead: points that stand for the places meant to touch",
    )


def _sphere_trace(pair: Pair, gap: float, start: float, sign: float, limit: float) -> float | None:
    """Return the first shift from `start` on at which the smallest gap is `gap`, to the tolerance.

    The search goes forward (sign 1) through free places, or back (sign −1) through places that are
    not free; it is None if there is none up to the limit. Steps of at least `_MIN_STEP` of the size
    may pass a touch that is shorter. Raises InputError if the gap jumps over `gap`.
    """
    shift = start
    while True:
        excess = sign * (pair.smallest_gap(shift) - gap)
        if excess <= pair.tolerance:
            break
        previous, shift = shift, shift + sign * max(excess, _MIN_STEP * pair.size)
        if (shift if sign > 0.0 else -previous) > limit:
            return None
    if excess >= -pair.tolerance:
        return shift

    from scipy.optimize import brentq  # few cases need it, and loading it takes longer than numba

    shift = float(
        brentq(
            lambda s: pair.smallest_gap(s) - gap,
            min(previous, shift),
            max(previous, shift),
            xtol=0.25 * pair.tolerance,
            rtol=1e-15,
        )
    )
    if abs(pair.smallest_gap(shift) - gap) > pair.tolerance:
        raise InputError(
            "the gap jumps on the way: points come round the border of an open body",
            where="direction",
            remedy="Choose another direction, or start from the free side",
        )
    return shift
