"""Factors of what curves relate: strains, lengths, forces, stresses, rates."""

from __future__ import annotations

from typing import Literal

from contiga.errors import UnitError
from contiga.io.units import (
    acceleration_factor,
    base_factor,
    force_size,
    length_factor,
    stress_size,
    time_factor,
    velocity_factor,
    without_noise,
)

Quantity = Literal["ratio", "length", "time", "rate", "force", "stress", "velocity", "acceleration"]
Units = tuple[str, str, str]
"""Length, mass and time unit of a case."""

_RATIOS = {"1": 1.0, "-": 1.0, "": 1.0, "mm/mm": 1.0, "m/m": 1.0, "%": 0.01, "percent": 0.01}
_EXAMPLES = {
    "ratio": "1 or %",
    "rate": "1/s, 1/ms",
    "force": "N, kN, lbf",
    "stress": "Pa, MPa, GPa, N/mm^2, psi",
}


def quantity_factor(unit: str, quantity: Quantity, units: Units, where: str | None = None) -> float:
    """What a number in `unit` is multiplied by to be in the units of a case.

    Parameters
    ----------
    unit : "1", "%", "mm", "kN", "MPa", "1/s", …
    quantity : what it must be a unit of; a "ratio" is a strain or a factor, a "rate" is of strain
    units : length, mass and time unit of the case
    where : file or key the unit stands in, for the message

    Raises
    ------
    UnitError
        It is no unit of the quantity.

    >>> quantity_factor("MPa", "stress", ("mm", "kg", "ms"))
    0.001
    >>> quantity_factor("%", "ratio", ("mm", "kg", "ms"))
    0.01
    """
    length, mass, time = units
    if quantity == "length":
        return length_factor(unit, length, where)
    if quantity == "time":
        return time_factor(unit, time, where)
    if quantity == "velocity":
        return velocity_factor(unit, length, time, where)
    if quantity == "acceleration":
        return acceleration_factor(unit, length, time, where)
    if quantity == "ratio":
        if unit.strip() not in _RATIOS:
            raise _no_unit(unit, quantity, where)
        return _RATIOS[unit.strip()]
    if quantity == "rate":
        over, slash, of = unit.partition("/")
        if over.strip() != "1" or not slash:
            raise _no_unit(unit, quantity, where)
        return 1.0 / time_factor(of, time, where)
    m, l, t = base_factor(mass, "mass"), base_factor(length, "length"), base_factor(time, "time")
    size = force_size(unit) if quantity == "force" else stress_size(unit)
    if size is None:
        raise _no_unit(unit, quantity, where)
    return without_noise(size / (m * l / t**2 if quantity == "force" else m / (l * t**2)))


def _no_unit(unit: str, quantity: str, where: str | None) -> UnitError:
    meaning = {"ratio": "a strain or a factor", "rate": "a rate of strain"}.get(quantity, quantity)
    return UnitError(
        f"not a unit of {meaning}",
        where=where,
        found=unit,
        allowed=f"such as {_EXAMPLES[quantity]}",
    )
