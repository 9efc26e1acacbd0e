"""Slip rings: webbing that runs from one segment into another over an edge with friction.

With θ the angle by which the webbing turns there and μ its friction (Euler, Eytelwein),

    e^{−μ θ} ≤ T_b / T_a ≤ e^{μ θ}:

between these bounds the webbing sticks; beyond one it slips towards the larger tension until the
ratio is at the bound. Friction dissipates (T_b − T_a) dr.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from contiga.arrays.layout import not_negative
from contiga.curves.curve_records import Response
from contiga.dynamics.belt_devices import root
from contiga.errors import InputError


class SlipRingState(NamedTuple):
    """State of a slip ring."""

    slipped: float = 0.0
    """Length that slipped from the first segment into the second since the start."""
    friction: float = 0.0
    """Energy lost by friction since the start."""
    angle: float = 0.0
    """Angle by which the webbing turns, radians."""


@dataclass(frozen=True, init=False, eq=False)
class SlipRing:
    """A D-ring, the tongue of a buckle or the like, between two segments that end at one point.

    Parameters
    ----------
    between : names of two springs of webbing, which end at one point of one body, slave or the
        ground
    friction : μ, ≥ 0
    name : name in results; "<first>-<second>" if empty

    Raises
    ------
    InputError
        Not two names, a negative friction.

    Examples
    --------
    >>> SlipRing(("shoulder", "lap"), friction=0.2).name
    'shoulder-lap'
    """

    between: tuple[str, str]
    friction: float
    name: str

    def __init__(self, between: Sequence[str], *, friction: float = 0.0, name: str = "") -> None:
        names = () if isinstance(between, str) else tuple(between)
        if len(names) != 2 or names[0] == names[1] or not all(isinstance(n, str) for n in names):
            raise InputError(
                "must be two segments",
                where="between",
                found=between,
                allowed="two names of springs",
            )
        put = object.__setattr__
        put(self, "between", names)
        put(self, "friction", not_negative(friction, "friction"))
        put(self, "name", name or "-".join(names))

    def ratio(self, angle: float) -> float:
        """Return e^{μ θ}, the largest ratio of the tensions."""
        return math.exp(self.friction * angle)


def slip(
    first: Callable[[float], Response], second: Callable[[float], Response], ratio: float
) -> float:
    """Return the length that slips from the first segment into the second; may be negative.

    It is 0 if the webbing sticks; else the tensions end at the bound, to rounding (`root`).

    Parameters
    ----------
    first, second : responses over the length that is fed in
    ratio : e^{μ θ}
    """
    force_1, force_2 = first(0.0).force, second(0.0).force
    if force_2 > ratio * force_1:
        slack, tight, sign = first, second, 1.0
    elif force_1 > ratio * force_2:
        slack, tight, sign = second, first, -1.0
    else:
        return 0.0

    def excess(fed: float) -> tuple[float, float]:
        """Return the tight segment's force above the friction bound, and its slope."""
        low, high = slack(-fed), tight(fed)
        return high.force - ratio * low.force, -high.stiffness - ratio * low.stiffness

    value, slope = excess(0.0)
    return sign * root(excess, 0.0, value / -slope if slope < 0.0 else 1e-6 * value)
