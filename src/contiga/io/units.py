"""Conversion of units: factors between length, mass and time units, and derived labels.

The library itself is unit-free. `pint` knows the units; nothing else imports it.
"""

from __future__ import annotations

import math
import re
from difflib import get_close_matches
from functools import lru_cache
from typing import Any

from contiga.errors import UnitError
from contiga.extras import require

COMMON = {
    "length": ("m", "mm", "cm", "um", "km", "in", "ft"),
    "mass": ("kg", "g", "mg", "t", "lb", "slug"),
    "time": ("s", "ms", "us", "min", "h"),
}
_BASE = {"length": "m", "mass": "kg", "time": "s"}
_NAMES = {
    "length": (*COMMON["length"], "millimetre", "metre", "centimetre", "inch", "foot", "mile"),
    "mass": (*COMMON["mass"], "kilogram", "gram", "tonne", "pound"),
    "time": (*COMMON["time"], "second", "millisecond", "minute", "hour"),
}
_SPELLINGS = {
    "mil": "thou",
    "mils": "thou",
    "inches": "inch",
    "feet": "foot",
    "tonne": "metric_ton",
    "t": "metric_ton",
}
# Results of pint for these units; loading pint takes half a second.
_PLAIN = {
    "length": {
        "m": 1.0,
        "metre": 1.0,
        "mm": 0.001,
        "millimetre": 0.001,
        "cm": 0.01,
        "centimetre": 0.01,
        "um": 1e-6,
        "km": 1000.0,
        "in": 0.0254,
        "inch": 0.0254,
    },
    "mass": {"kg": 1.0, "g": 0.001, "mg": 1e-6, "t": 1000.0},
    "time": {"s": 1.0, "ms": 0.001, "us": 1e-6, "min": 60.0, "h": 3600.0},
}
# In m/s and m/s².
_RATES = {
    1: {"kph": 1.0 / 3.6, "kmh": 1.0 / 3.6, "mph": 0.44704},
    2: {"g": 9.80665, "G": 9.80665, "g0": 9.80665, "gn": 9.80665},
}
# Units of torque; pint takes Nm for number-metre, a unit of yarn.
_TORQUE = re.compile(r"\b([kM]?N)(m|mm)\b")
_RATE_KINDS = {1: "velocity", 2: "acceleration"}
_RATE_EXAMPLES = {1: "m/s, mm/ms, km/h, mph", 2: "g, m/s^2, mm/ms^2, in/s^2"}
_RATE = re.compile(
    r"^\s*([^/()]+?)\s*/\s*\(?\s*([^/()^²*2]+?)\s*(\^2|²|\*\*2|2|/\s*[^/()]+)?\s*\)?\s*$"
)
_SQUARE = re.compile(r"\(\s*(\w+)\s*\*\s*\1\s*\)")
_FORCES = {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "kN": 1e3, "MN": 1e6, "GN": 1e9, "dyn": 1e-5}
_ENERGIES = {"J": 1.0, "mJ": 1e-3, "uJ": 1e-6, "kJ": 1e3, "MJ": 1e6}
_MOMENTS = {"Nm": 1.0, "N*m": 1.0, "N*mm": 1e-3, "Nmm": 1e-3, "kNm": 1e3, "kN*mm": 1.0}
_STRESSES = {"Pa": 1.0, "mPa": 1e-3, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12}


@lru_cache(maxsize=1)
def _registry() -> Any:
    require(f"a unit other than {', '.join(u for units in _PLAIN.values() for u in units)}", "pint")
    import pint

    return pint.UnitRegistry()


@lru_cache(maxsize=256)
def base_factor(unit: str, dimension: str, where: str | None = None) -> float:
    """Return the number of SI base units (m, kg, s) in one `unit`.

    Parameters
    ----------
    unit : any spelling `pint` knows: "mm", "millimetre", "in", "INCH", …
    dimension : "length", "mass" or "time"
    where : file or key the unit stands in, for the message

    Raises
    ------
    UnitError
        The unit is not known, or is one of another dimension.
    MissingPackageError
        The unit is a rare one, and pint, which knows them all, is not installed.

    >>> base_factor("mm", "length")
    0.001
    """
    text = unit.strip() if isinstance(unit, str) else ""
    # "Mm" is not "mm", but "MM" is what CAD files write for it.
    if dimension == "mass" and text.lower() in ("ton", "tons"):
        raise UnitError(
            "there are several of that name",
            where=where,
            found=unit,
            allowed="t (1000 kg), short_ton, long_ton",
            remedy='A system of mm, s and MPa has "t"',
        )
    plain = _PLAIN[dimension].get(text.lower() if text.isupper() else text)
    if plain is not None:
        return plain
    readings = _readings(text)
    for quantity in readings:
        if quantity.check(f"[{dimension}]"):
            return float(quantity.to(_BASE[dimension]).magnitude)
    known = f"a unit of {dimension}, such as {', '.join(COMMON[dimension])}"
    if readings:
        raise UnitError(f"not a unit of {dimension}", where=where, found=unit, allowed=known)
    close = get_close_matches(text, _NAMES[dimension], n=1, cutoff=0.7) if text else []
    raise UnitError(
        "not a known unit",
        where=where,
        found=unit,
        allowed=known,
        remedy=f"Did you mean {close[0]!r}?" if close else None,
    )


def _readings(text: str) -> list[Any]:
    """Return one `text` as a quantity, in its own spelling and in lower case ("MM", "INCH")."""
    registry = _registry()
    readings = []
    for spelling in dict.fromkeys((text, text.lower())):
        try:
            unit = registry.parse_units(_SPELLINGS.get(spelling, _TORQUE.sub(r"(\1*\2)", spelling)))
        except Exception:  # pint raises its own errors, the tokenizer's and Python's alike
            continue
        if spelling:
            readings.append(1.0 * unit)
    return readings


def length_factor(from_unit: str, to_unit: str, where: str | None = None) -> float:
    """Return the factor from lengths in `from_unit` to `to_unit`.

    >>> length_factor("in", "mm")
    25.4
    """
    return _ratio(from_unit, to_unit, "length", where)


def time_factor(from_unit: str, to_unit: str, where: str | None = None) -> float:
    """Return the factor from times in `from_unit` to `to_unit`."""
    return _ratio(from_unit, to_unit, "time", where)


def velocity_factor(unit: str, length: str, time: str, where: str | None = None) -> float:
    """Return the factor from velocities in `unit` to `length` per `time`.

    Parameters
    ----------
    unit : a length by a time ("m/s", "mm/ms", "km/h"), or "mph", "kph"
    length, time : units of the result
    where : file or key the unit stands in, for the message

    Raises
    ------
    UnitError
        It is no unit of velocity.

    >>> 36.0 * velocity_factor("km/h", "m", "s")
    10.0
    """
    return _rate_ratio(unit, 1, length, time, where)


def acceleration_factor(unit: str, length: str, time: str, where: str | None = None) -> float:
    """Return the factor from accelerations in `unit` to `length` per `time` squared.

    Parameters
    ----------
    unit : "g" (9.80665 m/s²), or a length by the square of a time ("m/s^2", "mm/ms²", "m/s/s")
    length, time : units of the result
    where : file or key the unit stands in, for the message

    Raises
    ------
    UnitError
        It is no unit of acceleration.

    >>> acceleration_factor("g", "mm", "ms")
    0.00980665
    """
    return _rate_ratio(unit, 2, length, time, where)


def _rate_ratio(unit: str, power: int, length: str, time: str, where: str | None) -> float:
    case = base_factor(length, "length") / base_factor(time, "time") ** power
    return without_noise(_rate_in_si(unit, power, where) / case)


def without_noise(factor: float) -> float:
    """Return the neighbour with 15 digits, the accuracy of units, if there is one.

    For example 0.001 for 1e6 / 1e9.

    1 / 3.6 is no number of 15 digits, and stays.
    """
    short = float(f"{factor:.15g}")
    return short if math.isclose(short, factor, rel_tol=4e-16) else factor


def _rate_in_si(unit: str, power: int, where: str | None) -> float:
    """Return one `unit` of velocity (power 1) or acceleration (2) in m and s."""
    text = unit.strip() if isinstance(unit, str) else ""
    named = _RATES[power].get(text)
    if named is not None:
        return named
    parts = _rate_parts(text)
    if parts is None or parts[2] != power:
        other = text in _RATES[3 - power] or (parts is not None and parts[2] == 3 - power)
        what = f"a unit of {_RATE_KINDS[3 - power]}, not" if other else "not a unit"
        raise UnitError(
            f"{what} of {_RATE_KINDS[power]}",
            where=where,
            found=unit,
            allowed=f"a unit of {_RATE_KINDS[power]}, such as {_RATE_EXAMPLES[power]}",
        )
    size = base_factor(parts[0], "length", where)
    return size / base_factor(parts[1], "time", where) ** power


def _rate_parts(text: str) -> tuple[str, str, int] | None:
    """Return length, time and power of time of a quotient such as m/s^2 or m/s/s."""
    # ISO-MME files say m/(s*s).
    match = _RATE.match(_SQUARE.sub(r"\1^2", text))
    if match is None:
        return None
    length, time, square = match.groups()
    if square is not None and square.startswith("/") and square[1:].strip() != time:
        return None
    return length, time, 1 if square is None else 2


def _ratio(from_unit: str, to_unit: str, dimension: str, where: str | None) -> float:
    a = base_factor(from_unit, dimension, where)
    b = base_factor(to_unit, dimension, where)
    # 15 digits: 0.0254 / 0.001 is 25.4, not its neighbour, and no unit is known to more.
    return float(f"{a / b:.15g}")


def derived_units(length: str, mass: str, time: str) -> dict[str, str]:
    """Return the labels of the derived units of a consistent set.

    Returns
    -------
    dict
        "area", "velocity", "force", "moment", "stress", "energy". Coherent SI names where one
        fits, else the product of the base units.

    >>> derived_units("mm", "kg", "ms")["stress"]
    'GPa'
    """
    l = base_factor(length, "length")
    m = base_factor(mass, "mass")
    t = base_factor(time, "time")
    force = _name_of_size(m * l / t**2, _FORCES) or f"{mass}·{length}/{time}²"
    stress = _name_of_size(m / (l * t**2), _STRESSES) or f"{mass}/({length}·{time}²)"
    return {
        "area": f"{length}²",
        "velocity": f"{length}/{time}",
        "force": force,
        "moment": f"{force}·{length}",
        "stress": stress,
        "energy": _name_of_size(m * l**2 / t**2, _ENERGIES) or f"{force}·{length}",
    }


def force_size(unit: str) -> float | None:
    """Return one `unit` in N; None if it is no unit of force.

    >>> force_size("kN"), force_size("mm")
    (1000.0, None)
    """
    return _size(unit, _FORCES, "[force]", "N")


def stress_size(unit: str) -> float | None:
    """Return one `unit`, such as MPa or N/mm^2, in Pa; None if it is no unit of stress."""
    return _size(unit, _STRESSES, "[pressure]", "Pa")


def with_unit(label: str, unit: str) -> str:
    """Return ``label [unit]``, or the one of both that is not empty.

    >>> with_unit("force", "N"), with_unit("strain", ""), with_unit("", "g")
    ('force [N]', 'strain', '[g]')
    """
    return f"{label} [{unit}]".strip() if unit else label


def moment_size(unit: str) -> float | None:
    """Return one `unit` of a moment, such as Nm or N*mm, in Nm; None if it is none.

    >>> moment_size("Nm"), moment_size("N·mm")
    (1.0, 0.001)
    """
    return _size(unit.replace("·", "*"), _MOMENTS, "[energy]", "N*m")


def energy_size(unit: str) -> float | None:
    """Return one `unit` in J; None if it is no unit of energy."""
    return _size(unit, _ENERGIES, "[energy]", "J")


def area_size(unit: str) -> float | None:
    """Return one `unit`, such as mm^2, in m²; None if it is no unit of area."""
    return _size(unit.replace("²", "^2"), {"mm^2": 1e-6, "m^2": 1.0}, "[area]", "m^2")


def volume_size(unit: str) -> float | None:
    """Return one `unit`, such as mm^3, in m³; None if it is no unit of volume."""
    return _size(unit.replace("³", "^3"), {"mm^3": 1e-9, "m^3": 1.0}, "[volume]", "m^3")


def _size(unit: str, known: dict[str, float], dimension: str, base: str) -> float | None:
    if unit.strip() in known:
        return known[unit.strip()]
    for quantity in _readings(unit.strip()):
        if quantity.check(dimension):
            return float(quantity.to(base).magnitude)
    return None


def consistent_factor(unit: str, length: str, mass: str, time: str, where: str) -> float:
    """Return the factor from numbers in `unit`, of any dimension, to a consistent set of units.

    Parameters
    ----------
    unit : of a product of powers of length, mass and time: "km/h", "kg/m^3", "MPa", "%"
    length, mass, time : the consistent set of units
    where : file or key the unit stands in, for the message

    Raises
    ------
    UnitError
        It is no such unit; "g" or "G", of mass or of acceleration; an angle.

    >>> consistent_factor("g/cm^3", "mm", "kg", "ms", "density")
    1e-06
    """
    text = unit.strip()
    if text in ("g", "G"):
        raise UnitError(
            "a unit of mass and of acceleration",
            where=where,
            found=unit,
            allowed="kg or mg, m/s^2 or g_0",
        )
    if text in ("", "-", "1"):
        return 1.0
    if text in _RATES[1]:
        return velocity_factor(text, length, time)
    if text in _RATES[2]:
        return acceleration_factor(text, length, time)
    readings = _readings(text)
    powers = dict(readings[0].dimensionality) if readings else {"no unit": 1}
    sizes = {
        f"[{dimension}]": base_factor(one, dimension)
        for dimension, one in (("length", length), ("mass", mass), ("time", time))
    }
    if not powers.keys() <= sizes.keys() or any(power % 1 for power in powers.values()):
        raise UnitError(
            "not a unit of the quantities of a case",
            where=where,
            found=unit,
            allowed="such as mm, kg, ms, km/h, m/s^2, N, MPa, kg/m^3, 1/s, %",
            remedy="If it is none, take the brackets away",
        )
    size = readings[0].to_root_units()
    if not powers and size.units != size.units / size.units:
        raise UnitError(
            "an angle is not converted: some keys are in degrees, others in radians",
            where=where,
            found=unit,
            allowed="no unit in the header, and numbers as the key takes them",
        )
    factor = float(readings[0].to_base_units().magnitude)
    for dimension, power in powers.items():
        factor /= sizes[dimension] ** power
    return without_noise(factor)


def _name_of_size(value: float, names: dict[str, float]) -> str | None:
    for name, size in names.items():
        if math.isclose(value, size, rel_tol=1e-12):
            return name
    return None


def short_name(unit: str) -> str:
    """Return the short name of a length: "mm" for "millimetre" and "MM"; others are unchanged.

    >>> short_name("INCH")
    'in'
    """
    size = base_factor(unit, "length")
    for name in COMMON["length"]:
        if math.isclose(base_factor(name, "length"), size, rel_tol=1e-12):
            return name
    return unit
