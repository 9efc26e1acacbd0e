"""What sensors and springs of a run have measured, as channels of ISO/TS 13499 (ISO-MME)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import InputError
from contiga.io.out.iso_mme import MmeChannel
from contiga.io.units import base_factor
from contiga.records import FloatArray

_EVEN = 1e-6
_CLASSES = {"CFC1000": "A", "CFC600": "B", "CFC180": "C", "CFC60": "D"}
_UNFILTERED = "0"


class _Kind(NamedTuple):
    """What a column holds."""

    dimension: str
    """Physical dimension in a code."""
    powers: tuple[int, int, int]
    """Of length, mass and time in its unit."""
    unit: str
    """In SI, as the format writes it."""


_KINDS = (
    (r"(?:filtered_)?a([xyz]?)", _Kind("AC", (1, 0, -2), "m/(s*s)")),
    (r"v([xyz]?)|rate()", _Kind("VE", (1, 0, -1), "m/s")),
    (r"([xyz])|distance()|elongation()", _Kind("DS", (1, 0, 0), "m")),
    (r"f([xyz]?)|(?:filtered_)?force()", _Kind("FO", (1, 1, -2), "N")),
    (r"m([xyz])", _Kind("MO", (2, 1, -2), "Nm")),
    (r"angle(?:_([xyz]))?", _Kind("AN", (0, 0, 0), "rad")),
)
_RESULTANTS = ("a", "v", "f", "filtered_a")


def channels_of(history: Mapping[str, FloatArray], summary: Mapping[str, Any]) -> list[MmeChannel]:
    """The channels of all sensors and springs, in SI units, at even times.

    Steps that differ are brought to their median by linear interpolation.

    Raises
    ------
    InputError
        The run has no units, or nobody who measures.
    """
    units = summary.get("units") or {}
    if not all(units.get(key) for key in ("length", "mass", "time")):
        raise InputError("the run has no units", where="units", remedy="Run a case file with them")
    base = [base_factor(units[key], key) for key in ("length", "mass", "time")]
    owners = {**(summary.get("sensors") or {}), **(summary.get("springs") or {})}
    if not owners:
        raise InputError(
            "nothing is measured: the run has no sensors and no springs",
            where="sensor",
            remedy="Add a [[sensor]] to the case",
        )
    times, codes = history["time"], _codes(owners)
    grid = _even(times)
    found = []
    for name, told in owners.items():
        for column, kind, direction in _columns(history, name):
            factor = float(np.prod([b**p for b, p in zip(base, kind.powers, strict=True)]))
            values = np.interp(grid, times, history[f"{name}.{column}"]) * factor
            cls = str(told.get("filter")) if column.startswith("filtered_") else ""
            code = codes[name] + kind.dimension + direction + _CLASSES.get(cls, _UNFILTERED)
            interval = float(grid[-1] - grid[0]) / max(len(grid) - 1, 1) * base[2]
            start, filter = float(grid[0]) * base[2], cls.removeprefix("CFC") or "NOVALUE"
            label = f"{name} {column}"
            found.append(MmeChannel(code, label, kind.unit, start, interval, values, filter))
    return found


def _columns(history: Mapping[str, FloatArray], name: str) -> Iterator[tuple[str, _Kind, str]]:
    """Columns of an owner that channels can hold, with their kind and direction."""
    for whole in history:
        owner, _, column = whole.rpartition(".")
        if owner != name or not np.isfinite(history[whole]).all():
            continue
        for pattern, kind in _KINDS:
            if match := re.fullmatch(pattern, column):
                axis = next((found for found in match.groups() if found), "")
                yield column, kind, axis.upper() or ("R" if column in _RESULTANTS else "0")


def _codes(owners: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """The first twelve characters of the codes: as given, else made of the name."""
    codes: dict[str, str] = {}
    for name, told in owners.items():
        place = re.sub(r"[^A-Z0-9]", "", name.upper())[:4].ljust(4, "0")
        made = (f"10{place}{k:02d}0000" for k in range(100))
        codes[name] = told.get("code") or next(c for c in made if c not in codes.values())
    return codes


def _even(times: FloatArray) -> FloatArray:
    steps = np.diff(times)
    if len(steps) == 0 or np.ptp(steps) <= _EVEN * steps.max():
        return times
    count = round(float(times[-1] - times[0]) / float(np.median(steps)))
    return np.linspace(times[0], times[-1], count + 1)
