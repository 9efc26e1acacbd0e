"""Units of input: their sizes, factors to the units of a case, and labels of derived units.

The library itself is unit-free. `QUANTITIES` has the usual units, and this module reads products
of them. `pint`, which takes half a second to load, has the rare ones; nothing else imports it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from difflib import get_close_matches
from functools import lru_cache
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

from contiga.errors import UnitError
from contiga.extras import require

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
Powers = tuple[int, int, int, int]
"""Powers of length, mass, time and angle."""
Base = Literal["length", "mass", "time"]
BASE: tuple[Base, Base, Base] = ("length", "mass", "time")


class Kind(NamedTuple):
    """A quantity and its usual units."""

    powers: Powers | None
    """Powers of its units; None if it has only the units named here, in any case."""
    examples: str
    sizes: Mapping[str, float] = MappingProxyType({})
    """Units by name, in SI units."""


QUANTITIES: dict[Quantity, Kind] = {
    "ratio": Kind(
        (0, 0, 0, 0), "1 or %", {"1": 1.0, "-": 1.0, "": 1.0, "%": 0.01, "percent": 0.01}
    ),
    "length": Kind(
        (1, 0, 0, 0),
        "m, mm, cm, um, km, in, ft",
        {
            "m": 1.0,
            "mm": 1e-3,
            "cm": 1e-2,
            "um": 1e-6,
            "km": 1e3,
            "in": 0.0254,
            "ft": 0.3048,
            "metre": 1.0,
            "millimetre": 1e-3,
            "centimetre": 1e-2,
            "mil": 2.54e-5,
            "inch": 0.0254,
            "inches": 0.0254,
            "foot": 0.3048,
            "feet": 0.3048,
            "mile": 1609.344,
        },
    ),
    "mass": Kind(
        (0, 1, 0, 0),
        "kg, g, mg, t, lb, slug",
        {
            "kg": 1.0,
            "g": 1e-3,
            "mg": 1e-6,
            "t": 1e3,
            "lb": 0.45359237,
            "kilogram": 1.0,
            "gram": 1e-3,
            "tonne": 1e3,
            "pound": 0.45359237,
        },
    ),
    "time": Kind(
        (0, 0, 1, 0),
        "s, ms, us, min, h",
        {
            "s": 1.0,
            "ms": 1e-3,
            "us": 1e-6,
            "min": 60.0,
            "h": 3600.0,
            "second": 1.0,
            "millisecond": 1e-3,
            "minute": 60.0,
            "hour": 3600.0,
        },
    ),
    "rate": Kind((0, 0, -1, 0), "1/s, 1/ms"),
    "velocity": Kind(
        (1, 0, -1, 0),
        "m/s, mm/ms, km/h, mph",
        {"kph": 1.0 / 3.6, "kmh": 1.0 / 3.6, "mph": 0.44704},
    ),
    "acceleration": Kind(
        (1, 0, -2, 0),
        "g, m/s^2, mm/ms^2, in/s^2",
        {"g": 9.80665, "G": 9.80665, "g0": 9.80665, "gn": 9.80665},
    ),
    "force": Kind(
        (1, 1, -2, 0),
        "N, kN, lbf",
        {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "kN": 1e3, "MN": 1e6, "GN": 1e9, "dyn": 1e-5},
    ),
    "stress": Kind(
        (-1, 1, -2, 0),
        "Pa, MPa, GPa, N/mm^2, psi",
        {"Pa": 1.0, "mPa": 1e-3, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12},
    ),
    "moment": Kind(
        (2, 1, -2, 0),
        "Nm, N*mm, lbf*ft",
        {"Nm": 1.0, "Nmm": 1e-3, "kNm": 1e3, "kNmm": 1.0, "MNm": 1e6, "MNmm": 1e3},
    ),
    "energy": Kind(
        (2, 1, -2, 0), "J, mJ, kJ", {"J": 1.0, "mJ": 1e-3, "uJ": 1e-6, "kJ": 1e3, "MJ": 1e6}
    ),
    "area": Kind((2, 0, 0, 0), "mm^2, m^2"),
    "volume": Kind((3, 0, 0, 0), "mm^3, m^3"),
    "angle": Kind(
        (0, 0, 0, 1),
        "rad, deg",
        {"rad": 1.0, "deg": math.pi / 180.0, "degree": math.pi / 180.0, "°": math.pi / 180.0},
    ),
    "spin": Kind((0, 0, -1, 1), "rad/s, deg/s, 1/s"),
    "temperature": Kind(None, "K", {"K": 1.0}),
    "seconds": Kind(None, "s", {"s": 1.0}),
}
_MEANINGS = {"ratio": "a strain or a factor", "rate": "a rate of strain", "seconds": "time"}
_MAX_POWER = 9
_TOKEN = re.compile(r"\^?-?\d+|[^\W\d]+|[%°*/()]")
"""A power or the number 1, a name, or a sign of a product."""


class Size(NamedTuple):
    """Size of a unit in SI units, and its powers of length, mass, time and angle."""

    value: float
    powers: Powers

    def times(self, other: Size, power: int) -> Size:
        """Return the product with a power of another unit."""
        scale = other.value ** abs(power)
        value = self.value * scale if power >= 0 else self.value / scale
        a, b, c, d = (p + power * q for p, q in zip(self.powers, other.powers, strict=True))
        return Size(value, (a, b, c, d))


ONE = Size(1.0, (0, 0, 0, 0))
_SYMBOLS = {
    name: Size(size, kind.powers)
    for quantity, kind in reversed(QUANTITIES.items())  # in a product g is a mass
    if kind.powers is not None
    for name, size in kind.sizes.items()
}


@lru_cache(maxsize=256)
def base_factor(unit: str, dimension: Base, where: str | None = None) -> float:
    """Return how many SI base units (m, kg, s) one `unit` is; results are kept.

    Parameters
    ----------
    unit : any spelling that this table or `pint` knows: "mm", "millimetre", "in", "INCH", …
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
    return si_size(unit, dimension, where)


def si_size(unit: str, quantity: Quantity, where: str | None = None) -> float:
    """Return the size of a unit of a quantity in SI units.

    Units of the table count first, then products of them as they are spelt, or in lower case if
    all is upper case, then those of pint.

    Parameters
    ----------
    unit : "1", "%", "mm", "kN", "MPa", "N/mm^2", "1/s", "km/h", "Nm", "deg", …
    quantity : quantity that it must be a unit of
    where : file or key the unit stands in, for the message

    Raises
    ------
    UnitError
        It is no unit of the quantity, or an ambiguous "ton".
    MissingPackageError
        The unit is a rare one, and pint, which knows them all, is not installed.

    >>> si_size("kN", "force"), si_size("N·mm", "moment"), si_size("g", "acceleration")
    (1000.0, 0.001, 9.80665)
    """
    text = unit.strip() if isinstance(unit, str) else ""
    kind = QUANTITIES[quantity]
    if text in kind.sizes:
        return kind.sizes[text]
    if quantity == "mass" and text.lower() in ("ton", "tons"):
        raise UnitError(
            "there are several of that name",
            where=where,
            found=unit,
            allowed="t (1000 kg), short_ton, long_ton",
            remedy='A system of mm, s and MPa has "t"',
        )
    readings = () if kind.powers is None else _readings(text)
    for size in readings:
        if _is_unit_of(size.powers, kind):
            return size.value
    meaning = _MEANINGS.get(quantity, quantity)
    if readings:
        what, powers = f"not a unit of {meaning}", readings[0].powers
        matches = [
            name
            for name, other in QUANTITIES.items()
            if text in other.sizes or _is_unit_of(powers, other)
        ]
        remedy = f"It is a unit of {' or '.join(matches)}" if matches else None
    else:
        close = get_close_matches(text, kind.sizes, n=1, cutoff=0.7) if text else []
        what = f"not a known unit of {meaning}"
        remedy = f"Did you mean {close[0]!r}?" if close else None
    raise UnitError(
        what,
        where=where,
        found=unit,
        allowed=f"a unit of {meaning}, such as {kind.examples}",
        remedy=remedy,
    )


def _is_unit_of(powers: Powers, kind: Kind) -> bool:
    """Return whether a unit of these powers measures a quantity; the angle may be missing.

    So 1/s may stand for rad/s; a pure number is no angle. False for a quantity that has only its
    named units.
    """
    if kind.powers is None:
        return False
    is_rate = any(powers[:3]) and powers[3] == 0
    return powers == kind.powers or (is_rate and powers[:3] == kind.powers[:3])


@lru_cache(maxsize=256)
def _readings(text: str) -> tuple[Size, ...]:
    """Return the possible sizes of a unit, first as it is spelt, then in lower case; () for none.

    Lower case counts for upper case alone: CAD files write "MM" and "INCH", but "Mm" is not "mm".
    pint is asked only if no spelling is a product of units of the table.
    """
    spellings = (text, text.lower()) if text.isupper() else (text,)
    sizes = [size for size in map(_product_of, spellings) if size is not None]
    return tuple(sizes) or _pint_readings(text)


def _product_of(text: str) -> Size | None:
    """Return the size of a product such as N/mm^2, m/(s*s) or mm/ms²; None for anything else."""
    for sign, ascii_sign in (("**", "^"), ("²", "^2"), ("³", "^3"), ("·", "*")):
        text = text.replace(sign, ascii_sign)
    tokens = _TOKEN.findall(text)
    if "".join(tokens) != "".join(text.split()):
        return None
    try:
        size = _product(tokens)
    except (KeyError, IndexError, RecursionError):
        return None
    return None if tokens else size


def _product(tokens: list[str]) -> Size:
    """Return the size of the product at the front of `tokens`, and remove its tokens.

    It is read from left to right. Anything else, and a power above `_MAX_POWER`, raises a KeyError
    or an IndexError.
    """
    size, sign = ONE, 1
    while True:
        token = tokens.pop(0)
        factor = _product(tokens) if token == "(" else _SYMBOLS[token]
        if token == "(" and tokens.pop(0) != ")":
            raise KeyError(token)
        is_power = bool(tokens) and tokens[0].lstrip("^-").isdigit()
        power = int(tokens.pop(0).lstrip("^")) if is_power else 1
        if abs(power) > _MAX_POWER:
            raise KeyError(token)
        size = size.times(factor, sign * power)
        if not tokens or tokens[0] not in "*/":
            return size
        sign = 1 if tokens.pop(0) == "*" else -1


def _pint_readings(text: str) -> tuple[Size, ...]:
    """Return the sizes that pint gives for a text and its lower case, without those it cannot read.

    Units with other than whole powers of length, mass, time and angle are left out.
    """
    registry = _pint_registry()
    readings = []
    for spelling in dict.fromkeys((text, text.lower())):
        try:
            quantity = 1.0 * registry.parse_units(spelling)
            value = float(quantity.to_base_units().magnitude)
            angle = int(dict(quantity.to_root_units().unit_items()).get("radian", 0))
        except Exception:  # pint raises its own errors, the tokenizer's and Python's alike
            continue
        powers = dict(quantity.dimensionality)
        if not spelling or any(p % 1 or abs(p) > _MAX_POWER for p in powers.values()):
            continue
        length, mass, time = (int(powers.pop(f"[{base}]", 0)) for base in BASE)
        if not powers:
            readings.append(Size(value, (length, mass, time, angle)))
    return tuple(readings)


@lru_cache(maxsize=1)
def _pint_registry() -> Any:
    names = ", ".join(name for base in BASE for name in QUANTITIES[base].sizes)
    require(f"a unit other than {names}", "pint")
    import pint

    return pint.UnitRegistry()


def without_noise(factor: float) -> float:
    """Return the factor rounded to 15 digits if that changes it by rounding errors only.

    1e6 / 1e9 becomes 0.001, and 1 / 3.6 stays.
    """
    short = float(f"{factor:.15g}")
    return short if math.isclose(short, factor, rel_tol=4e-16) else factor


def consistent_size(quantity: Quantity, units: Units) -> float:
    """Return the size of the consistent unit of a quantity, in SI units, to 15 digits.

    It is 1 for a temperature and for seconds, which have the same unit in every case.

    Parameters
    ----------
    quantity : quantity of the unit
    units : length, mass and time unit

    >>> consistent_size("stress", ("mm", "kg", "ms"))
    1000000000.0
    """
    size = ONE
    for unit, base, power in zip(units, BASE, QUANTITIES[quantity].powers or (), strict=False):
        size = size.times(Size(base_factor(unit, base, "units"), ONE.powers), power)
    return float(f"{size.value:.15g}")


def quantity_factor(unit: str, quantity: Quantity, units: Units, where: str | None = None) -> float:
    """Return the factor that converts a number in `unit` to the units of a case.

    Parameters
    ----------
    unit : "1", "%", "mm", "kN", "MPa", "1/s", "Nm", "deg", …
    quantity : quantity of the unit; a "ratio" is a strain or a factor, a "rate" a rate of strain
    units : length, mass and time unit of the case
    where : file or key the unit stands in, for the message

    Raises
    ------
    UnitError
        `unit` is not a unit of the quantity, or one of `units` not one of length, mass or time.
    MissingPackageError
        The unit is in no table here, and pint is not installed.

    >>> quantity_factor("MPa", "stress", ("mm", "kg", "ms"))
    0.001
    >>> quantity_factor("%", "ratio", ("mm", "kg", "ms"))
    0.01
    """
    return without_noise(si_size(unit, quantity, where) / consistent_size(quantity, units))


def length_factor(from_unit: str, to_unit: str, where: str | None = None) -> float:
    """Return the factor that converts a length in `from_unit` to `to_unit`.

    >>> length_factor("in", "mm")
    25.4
    """
    return _ratio(from_unit, to_unit, "length", where)


def time_factor(from_unit: str, to_unit: str, where: str | None = None) -> float:
    """Return the factor that converts a time in `from_unit` to `to_unit`."""
    return _ratio(from_unit, to_unit, "time", where)


def _ratio(from_unit: str, to_unit: str, base: Base, where: str | None) -> float:
    return without_noise(base_factor(from_unit, base, where) / base_factor(to_unit, base, where))


def velocity_factor(unit: str, length: str, time: str, where: str | None = None) -> float:
    """Return the factor that converts a velocity in `unit` to `length` by `time`.

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
    return quantity_factor(unit, "velocity", (length, "kg", time), where)


def acceleration_factor(unit: str, length: str, time: str, where: str | None = None) -> float:
    """Return the factor that converts an acceleration in `unit` to `length` by `time` squared.

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
    return quantity_factor(unit, "acceleration", (length, "kg", time), where)


def consistent_factor(unit: str, length: str, mass: str, time: str, where: str) -> float:
    """Return the factor that converts a number in `unit`, of any dimension, to a consistent set.

    Parameters
    ----------
    unit : product of powers of length, mass and time: "km/h", "kg/m^3", "MPa", "%"
    length, mass, time : units of the set
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
    if text in QUANTITIES["ratio"].sizes:
        return QUANTITIES["ratio"].sizes[text]
    readings = _readings(text)
    if not readings:
        raise UnitError(
            "not a unit of the quantities of a case",
            where=where,
            found=unit,
            allowed="such as mm, kg, ms, km/h, m/s^2, N, MPa, kg/m^3, 1/s, %",
            remedy="If it is none, take the brackets away",
        )
    size = readings[0]
    if size.powers[3] and not any(size.powers[:3]):
        raise UnitError(
            "an angle is not converted: some keys are in degrees, others in radians",
            where=where,
            found=unit,
            allowed="no unit in the header, and numbers as the key takes them",
        )
    for base, name, power in zip(BASE, (length, mass, time), size.powers, strict=False):
        size = size.times(Size(base_factor(name, base), ONE.powers), -power)
    return without_noise(size.value)


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

    def named(quantity: Quantity) -> str | None:
        size = consistent_size(quantity, (length, mass, time))
        return _name_of(size, QUANTITIES[quantity].sizes)

    force = named("force") or f"{mass}·{length}/{time}²"
    return {
        "area": f"{length}²",
        "velocity": f"{length}/{time}",
        "force": force,
        "moment": f"{force}·{length}",
        "stress": named("stress") or f"{mass}/({length}·{time}²)",
        "energy": named("energy") or f"{force}·{length}",
    }


def short_name(unit: str) -> str:
    """Return the usual short name of a length: "mm" for "millimetre" and "MM"; others stay.

    >>> short_name("INCH")
    'in'
    """
    return _name_of(base_factor(unit, "length"), QUANTITIES["length"].sizes) or unit


def _name_of(size: float, sizes: Mapping[str, float]) -> str | None:
    """Return the first name of a size among `sizes`, to a relative 1e-12; None if it has none."""
    names = (name for name, value in sizes.items() if math.isclose(value, size, rel_tol=1e-12))
    return next(names, None)


def with_unit(label: str, unit: str) -> str:
    """Return ``label [unit]``, or only the part that is not empty.

    >>> with_unit("force", "N"), with_unit("strain", ""), with_unit("", "g")
    ('force [N]', 'strain', '[g]')
    """
    return f"{label} [{unit}]".strip() if unit else label
