"""Convert columns of sensors, springs and joints into channels of ISO/TS 13499 (ISO-MME)."""

from __future__ import annotations

import re
import warnings
from collections import defaultdict
from collections.abc import Iterator, Mapping
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import ContigaWarning, InputError
from contiga.io.out.iso_mme import MmeChannel
from contiga.io.units import Quantity, base_factor, consistent_size
from contiga.records import FloatArray
from contiga.simulation.resampling import FINE, even_times, means, trapezoids

_MAX_CLASS = 1000
"""Channel frequency class whose sampling rate unequal steps are resampled to."""
_INTEGRATED = ("AC", "FO", "MO")
"""Dimensions whose integral resampling must conserve, also for a short pulse."""
_CLASSES = {"CFC1000": "A", "CFC600": "B", "CFC180": "C", "CFC60": "D"}
_UNFILTERED = "0"


class _Kind(NamedTuple):
    """The quantity that a column holds."""

    dimension: str
    """Physical dimension in a code."""
    quantity: Quantity
    unit: str
    """In SI, as the format writes it."""


_PATTERNS = (
    (r"(?:filtered_)?a([xyz]?)", _Kind("AC", "acceleration", "m/(s*s)")),
    (r"v([xyz]?)|rate()", _Kind("VE", "velocity", "m/s")),
    (r"([xyz])|distance()|elongation()|travel()", _Kind("DS", "length", "m")),
    (r"f([xyz]?)|(?:filtered_|travel_)?force()", _Kind("FO", "force", "N")),
    (r"m([xyz])|(?:angle(?:_([12]))?|cone|twist)_force", _Kind("MO", "moment", "Nm")),
    (r"w([xyz])", _Kind("AV", "spin", "rad/s")),
    (r"angle(?:_([xyz12]))?|cone|twist", _Kind("AN", "angle", "rad")),
)
_NUMBERS = {"cone": "1", "twist": "2", "cone_force": "1", "twist_force": "2"}
"""Directions of the second kind of coordinate of a joint."""
_RESULTANTS = ("a", "v", "f", "filtered_a")


def channels_of(history: Mapping[str, FloatArray], summary: Mapping[str, Any]) -> list[MmeChannel]:
    """Return the channels of all sensors, springs and joints, in SI units, at even times.

    Unequal steps are resampled at the interval of the fine rate of CFC 1000, or the shortest step
    if that is longer, but at most the median step. Accelerations, forces and moments keep their
    integrals; other quantities are interpolated linearly.

    Warns
    -----
    ContigaWarning
        Columns that are not finite are left out.

    Raises
    ------
    InputError
        The run has no units, or no sensors, springs and joints.
    """
    units = summary.get("units") or {}
    if not all(units.get(key) for key in ("length", "mass", "time")):
        raise InputError("the run has no units", where="units", remedy="Run a case file with them")
    names = units["length"], units["mass"], units["time"]
    second = base_factor(names[2], "time")
    owners: dict[str, Any] = {}
    for key in ("sensors", "springs", "joints"):
        owners |= summary.get(key) or {}
    if not owners:
        raise InputError(
            "nothing is measured: the run has no sensors, springs or joints",
            where="sensor",
            remedy="Add a [[sensor]] to the case",
        )
    times, codes = history["time"], _location_codes(owners)
    shortest = float(np.diff(times).min(initial=np.inf))
    grid = even_times(times, max(1.0 / (FINE * _MAX_CLASS * second), shortest))
    channels = []
    left_out = []
    for name, owner in owners.items():
        for column, kind, direction in _channel_columns(history, name):
            if not np.isfinite(history[f"{name}.{column}"]).all():
                left_out.append(f"{name}.{column}")
                continue
            values = history[f"{name}.{column}"]
            if grid is not times and kind.dimension in _INTEGRATED:
                impulses = trapezoids(times, values[:, None])
                values = means(grid, times, values[:, None], impulses)[:, 0]
            elif grid is not times:
                values = np.interp(grid, times, values)
            values = values * consistent_size(kind.quantity, names)
            cls = str(owner.get("filter")) if column.startswith("filtered_") else ""
            code = codes[name] + kind.dimension + direction + _CLASSES.get(cls, _UNFILTERED)
            interval = float(grid[-1] - grid[0]) / max(len(grid) - 1, 1) * second
            start, filter = float(grid[0]) * second, cls.removeprefix("CFC") or "NOVALUE"
            label = f"{name} {column}"
            channels.append(MmeChannel(code, label, kind.unit, start, interval, values, filter))
    if left_out:
        text = ", ".join(left_out)
        warnings.warn(f"left out, as they are not finite: {text}", ContigaWarning, 2)
    return channels


def _channel_columns(
    history: Mapping[str, FloatArray], name: str
) -> Iterator[tuple[str, _Kind, str]]:
    """Yield (column, kind, direction) for the columns of an owner that channels can hold.

    The direction is X, Y, Z, R for a resultant, a number, or 0.
    """
    for full_name in history:
        owner, _, column = full_name.rpartition(".")
        if owner != name:
            continue
        for pattern, kind in _PATTERNS:
            if match := re.fullmatch(pattern, column):
                axis = next((found for found in match.groups() if found), "").upper()
                default = "R" if column in _RESULTANTS else _NUMBERS.get(column, "0")
                yield column, kind, axis or default


def _location_codes(owners: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """Return the first twelve characters of the code of each owner: as given, else from its name.

    That is "10", the first four letters and digits, and a number: names with the same ones are
    numbered in order, without codes that are given.
    """
    codes: dict[str, str] = {
        name: owner["code"] for name, owner in owners.items() if owner.get("code")
    }
    used_codes = set(codes.values())
    numbers: defaultdict[str, Iterator[int]] = defaultdict(count)
    for name in owners:
        place = re.sub(r"[^A-Z0-9]", "", name.upper())[:4].ljust(4, "0")
        while name not in codes:
            high, low = divmod(next(numbers[place]), 100)
            code = f"10{place}{low:02d}{high:04d}"
            if code not in used_codes:
                codes[name] = code
    return codes
