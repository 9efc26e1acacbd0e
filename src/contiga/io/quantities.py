"""Quantities of curves and histories, and the factors that convert their units."""

from __future__ import annotations

from math import pi
from typing import Literal

from contiga.errors import UnitError
from contiga.io.units import (
    acceleration_factor,
    area_size,
    base_factor,
    energy_size,
    force_size,
    length_factor,
    moment_size,
    stress_size,
    time_factor,
    velocity_factor,
    volume_size,
    without_noise,
)

Quantity = Literal[
    "ratio",
    "length",
    "mass",
    "time",
    "rate",
    "velocity",
    "acceleration",
    "force",
    "stress",
    "moment",
    "energy",
    "area",
    "volume",
    "angle",
    "spin",
    "temperature",
    "seconds",
]
Units = tuple[str, str, str]
"""Length, mass and time unit of a case."""

_RATIOS = {"1": 1.0, "-": 1.0, "": 1.0, "mm/mm": 1.0, "m/m": 1.0, "%": 0.01, "percent": 0.01}
_EXAMPLES = {
    "ratio": "1 or %",
    "rate": "1/s, 1/ms",
    "force": "N, kN, lbf",
    "stress": "Pa, MPa, GPa, N/mm^2, psi",
    "moment": "Nm, N*mm, lbf*ft",
    "energy": "J, mJ, kJ",
    "area": "mm^2, m^2",
    "volume": "mm^3, m^3",
    "angle": "rad, deg",
    "spin": "rad/s, deg/s",
    "temperature": "K",
    "seconds": "s",
}
_SIZES = {
    "force": force_size,
    "stress": stress_size,
    "moment": moment_size,
    "energy": energy_size,
    "area": area_size,
    "volume": volume_size,
}
"""Functions that return the size of a unit in SI units, and None for a unit of something else."""
_ANGLES = {"rad": 1.0, "deg": pi / 180.0, "°": pi / 180.0, "degree": pi / 180.0}
_POWERS: dict[Quantity, tuple[int, int, int]] = {
    "length": (1, 0, 0),
    "mass": (0, 1, 0),
    "time": (0, 0, 1),
    "rate": (0, 0, -1),
    "velocity": (1, 0, -1),
    "acceleration": (1, 0, -2),
    "force": (1, 1, -2),
    "stress": (-1, 1, -2),
    "moment": (2, 1, -2),
    "energy": (2, 1, -2),
    "area": (2, 0, 0),
    "volume": (3, 0, 0),
    "spin": (0, 0, -1),
}
"""Powers of length, mass and time in a quantity; other quantities have none."""


def consistent_size(quantity: Quantity, units: Units) -> float:
    """Return the size of the consistent unit of a quantity, in SI units.

    Parameters
    ----------
    quantity : quantity of the unit
    units : length, mass and time unit

    >>> consistent_size("stress", ("mm", "kg", "ms"))
    1000000000.0
    """
    sizes = zip(units, ("length", "mass", "time"), strict=True)
    powers = _POWERS.get(quantity, (0, 0, 0))
    size = 1.0
    for (unit, dimension), power in zip(sizes, powers, strict=True):
        size *= base_factor(unit, dimension) ** power
    return float(f"{size:.15g}")


def quantity_factor(unit: str, quantity: Quantity, units: Units, where: str | None = None) -> float:
    """Return the factor that converts numbers in `unit` to the units of a case.

    Parameters
    ----------
    unit : "1", "%", "mm", "kN", "MPa", "1/s", "Nm", "deg", …
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
    text = unit.strip()
    if quantity in ("rate", "spin"):
        over, slash, of = text.partition("/")
        overs = {"1": 1.0} if quantity == "rate" else {"1": 1.0, **_ANGLES}
        if over.strip() not in overs or not slash:
            raise _no_unit(unit, quantity, where)
        return overs[over.strip()] / time_factor(of, time, where)
    if quantity == "mass":
        return without_noise(base_factor(text, "mass", where) / base_factor(mass, "mass"))
    if (size_of := _SIZES.get(quantity)) is not None:
        size = size_of(text)
        if size is None:
            raise _no_unit(unit, quantity, where)
        return without_noise(size / consistent_size(quantity, units))
    names = {"ratio": _RATIOS, "angle": _ANGLES, "temperature": {"K": 1.0}, "seconds": {"s": 1.0}}
    if text not in names[quantity]:
        raise _no_unit(unit, quantity, where)
    return names[quantity][text]


def _no_unit(unit: str, quantity: str, where: str | None) -> UnitError:
    meanings = {"ratio": "a strain or a factor", "rate": "a rate of strain", "seconds": "time"}
    meaning = meanings.get(quantity, quantity)
    return UnitError(
        f"not a unit of {meaning}",
        where=where,
        found=unit,
        allowed=f"such as {_EXAMPLES[quantity]}",
    )
