"""Quantities and units of the columns of a history."""

from __future__ import annotations

import re
from collections.abc import Iterable

from contiga.io.units import Quantity, Units, consistent_size, derived_units

_KINDS: tuple[tuple[str, Quantity], ...] = (
    (r"n_\w+|q[wxyz]|strain", "ratio"),
    (r"time", "time"),
    (r"wall_time", "seconds"),
    (
        r"max_penetration|centre_[xyz]|[xyz]|elongation|distance|paid_out|travel|pulled_in|slipped",
        "length",
    ),
    (r"angle(_[xyz12])?|cone|twist", "angle"),
    (r"v[xyz]?|rate", "velocity"),
    (r"(filtered_)?a[xyz]?", "acceleration"),
    (r"w[xyz]", "spin"),
    (r"(filtered_)?force|force_[xyz]|friction_[xyz]|f[xyz]?", "force"),
    (r"moment_[xyz]|m[xyz]", "moment"),
    (r"area", "area"),
    (r"((mean|max)_)?pressure", "stress"),
    (r"work|(\w+_)?energy_\w+|flow_(in|out)", "energy"),
    (r"travel_force", "force"),
    (r"(angle(_[12])?|cone|twist)_force", "moment"),
    (r"temperature", "temperature"),
    (r"volume", "volume"),
    (r"mass", "mass"),
)


def kind_of_column(column: str) -> Quantity | None:
    """Return the quantity of a column or channel of a history; None for an unknown name.

    The part after the last dot decides, except for an owner "energy".

    >>> kind_of_column("head.ax"), kind_of_column("energy.total"), kind_of_column("head.forse")
    ('acceleration', 'energy', None)
    """
    owner, _, name = column.rpartition(".")
    if owner == "energy":
        return "energy"
    return next((kind for pattern, kind in _KINDS if re.fullmatch(pattern, name)), None)


def column_kind(column: str) -> Quantity:
    """Return the quantity of a column; "ratio" for counts, quaternions and unknown names."""
    return kind_of_column(column) or "ratio"


def column_factor(column: str, old: Units, new: Units) -> float:
    """Return the factor, to 15 digits, that converts a column from one set of units to another.

    It is 1 for an unknown column.

    Parameters
    ----------
    column : name of the column
    old, new : length, mass and time unit

    >>> column_factor("head.ax", ("mm", "g", "ms"), ("m", "kg", "s"))
    1000.0
    """
    kind = column_kind(column)
    return float(f"{consistent_size(kind, old) / consistent_size(kind, new):.15g}")


def column_units(columns: Iterable[str], units: Units) -> dict[str, str]:
    """Return the unit of each column by name: "" for counts, quaternions and unknown names.

    The result is empty if one of `units` is "".

    Parameters
    ----------
    columns : names of columns
    units : length, mass and time unit

    >>> column_units(["time", "force_x", "head.ax", "energy.total"], ("mm", "g", "ms"))
    {'time': 'ms', 'force_x': 'N', 'head.ax': 'mm/ms²', 'energy.total': 'mJ'}
    """
    length, mass, time = units
    if not all(units):
        return {}
    names: dict[str, str] = derived_units(length, mass, time) | {
        "ratio": "",
        "time": time,
        "seconds": "s",
        "angle": "rad",
        "length": length,
        "mass": mass,
        "volume": f"{length}³",
        "temperature": "K",
        "acceleration": f"{length}/{time}²",
        "spin": f"rad/{time}",
    }
    return {column: names[column_kind(column)] for column in columns}
