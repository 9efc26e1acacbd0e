"""Units of the columns of a history, for those who read it elsewhere."""

from __future__ import annotations

import re
from collections.abc import Iterable

from contiga.io.units import derived_units

_KINDS = (
    (r"n_\w+|q[wxyz]", ""),
    (r"time", "time"),
    (r"wall_time", "wall"),
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


def column_units(columns: Iterable[str], units: tuple[str, str, str]) -> dict[str, str]:
    """The unit of each column, by name; "" of counts and quaternions, none where units are not.

    >>> column_units(["time", "force_x", "head.ax", "energy.total"], ("mm", "g", "ms"))
    {'time': 'ms', 'force_x': 'N', 'head.ax': 'mm/ms²', 'energy.total': 'mJ'}
    """
    length, mass, time = units
    if not all(units):
        return {}
    derived = derived_units(length, mass, time) | {
        "": "",
        "time": time,
        "wall": "s",
        "angle": "rad",
        "length": length,
        "mass": mass,
        "volume": f"{length}³",
        "temperature": "K",
        "acceleration": f"{length}/{time}²",
        "spin": f"rad/{time}",
    }
    kinds: dict[str, str] = {}
    for column in columns:
        owner, _, name = column.rpartition(".")
        matching = (kind for pattern, kind in _KINDS if re.fullmatch(pattern, name))
        kinds[column] = "energy" if owner == "energy" else next(matching, "")
    return {column: derived[kind] for column, kind in kinds.items()}
