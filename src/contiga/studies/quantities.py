"""Quantities collected from a case: criteria of sensors, and numbers of history columns."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import trapezoid

from contiga.errors import CaseError
from contiga.io.column_units import column_units
from contiga.io.naming import closest
from contiga.records import FloatArray
from contiga.simulation.sensor import ALL_CRITERIA

_CALL = re.compile(r"(\w+)\((.+?)(?:,\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*)?\)")
_PLAIN = ("energy_error", "steps", "warnings")
_EXAMPLES = '"head_cg.HIC15", "max(force)", "at(head.vz, 5.0)", "energy_error"'


_OF_COLUMN: dict[str, Callable[[FloatArray, FloatArray], float]] = {
    "max": lambda times, values: float(values.max()),
    "min": lambda times, values: float(values.min()),
    "peak": lambda times, values: float(values[np.argmax(np.abs(values))]),
    "mean": lambda times, values: float(
        trapezoid(values, times) / (times[-1] - times[0]) if times[-1] > times[0] else values[0]
    ),
    "start": lambda times, values: float(values[0]),
    "end": lambda times, values: float(values[-1]),
    "time_of_max": lambda times, values: float(times[np.argmax(values)]),
    "time_of_min": lambda times, values: float(times[np.argmin(values)]),
    "time_of_peak": lambda times, values: float(times[np.argmax(np.abs(values))]),
}
"""Numbers of a column over time: `peak` is the value of largest magnitude, `mean` the integral over
the duration; times are those of the first extreme."""


class Quantity(NamedTuple):
    """One number of a case. See `quantity_of`."""

    text: str
    """The quantity as a study file writes it."""
    kind: str
    """"criterion", "at", one of `_OF_COLUMN`, or one of `_PLAIN`."""
    name: str = ""
    """Name of the column, or of the sensor."""
    criterion: str = ""
    time: float = 0.0
    """Time of the kind "at"."""

    def check(self, columns: list[str], criteria: list[str], end: float) -> None:
        """Refuse columns and criteria that a case will not have, and times after its end.

        Parameters
        ----------
        columns : names of columns of its history
        criteria : names ``sensor.criterion`` of its criteria
        end : time at which it ends

        Raises
        ------
        CaseError
            It will not have the quantity.
        """
        if self.kind in _PLAIN:
            return
        name, names, noun = self.name, columns, "column of the history"
        if self.kind == "criterion":
            name, names, noun = self.text, criteria, "criterion of a sensor"
        if name not in names:
            raise CaseError(
                f"the cases have no such {noun}",
                where="collect",
                found=self.text,
                allowed=", ".join(names) or "none: no sensor of the base case has criteria",
                remedy=closest(name, [*criteria, *columns]),
            )
        if self.kind == "at" and self.time > end:
            raise CaseError(
                "is after the end of the cases",
                where="collect",
                found=self.text,
                allowed=f"up to {end:g}",
            )

    def unit(self, units: tuple[str, str, str]) -> str:
        """Return the unit of the quantity for `units` of length, mass and time; empty without."""
        if self.kind == "criterion":
            return ALL_CRITERIA[self.criterion].unit
        if self.kind in _PLAIN:
            return ""
        column = "time" if self.kind.startswith("time_of") else self.name
        return column_units([column], units).get(column, "")

    def value(self, history: Mapping[str, FloatArray], summary: Mapping[str, Any]) -> float:
        """Return the number from the results of a run; NaN if it has none.

        Rows of a column that are not finite are left out. A value at a time is linear between rows,
        and constant beyond the first and the last.

        Parameters
        ----------
        history : columns (n,) by name
        summary : the content of summary.json
        """
        if self.kind == "energy_error":
            return float((summary.get("energy") or {}).get("relative", np.nan))
        if self.kind == "steps":
            return float(summary["steps"])
        if self.kind == "warnings":
            return float(len(summary["warnings"]))
        if self.kind == "criterion":
            sensor = (summary.get("sensors") or {}).get(self.name) or {"criteria": {}}
            return float(sensor["criteria"].get(self.criterion, {"value": np.nan})["value"])
        # Columns of a single contact have its name in `columns_of_case`, but not in a history.
        column = history.get(self.name, history.get(self.name.rpartition(".")[2]))
        if column is None:
            return float("nan")
        is_finite = np.isfinite(column)
        times, values = np.asarray(history["time"])[is_finite], np.asarray(column)[is_finite]
        if not len(values):
            return float("nan")
        if self.kind == "at":
            return float(np.interp(self.time, times, values))
        return _OF_COLUMN[self.kind](times, values)


def quantity_of(text: str) -> Quantity:
    """Return a quantity from its text in a study file.

    ``sensor.CRITERION``; ``max(column)`` and others of a column of the history;
    ``at(column, time)``; ``energy_error``, ``steps``, ``warnings``.

    Raises
    ------
    CaseError
        It is none of these.

    >>> quantity_of("at(head.vz, 5)").time, quantity_of("head_cg.HIC15").criterion
    (5.0, 'HIC15')
    """
    text = text.strip()
    if text in _PLAIN:
        return Quantity(text, text)
    call = _CALL.fullmatch(text)
    if call is None:
        sensor, dot, criterion = text.rpartition(".")
        if not dot or "(" in text or not sensor:
            raise _no_quantity(text)
        return Quantity(text, "criterion", sensor, criterion)
    kind, name, time = call.groups()
    if kind == "at" and time is not None:
        return Quantity(text, kind, name.strip(), time=float(time))
    if kind not in _OF_COLUMN or time is not None:
        raise _no_quantity(text, closest(kind, [*_OF_COLUMN, "at"]))
    return Quantity(text, kind, name.strip())


def _no_quantity(text: str, remedy: str | None = None) -> CaseError:
    functions = ", ".join([*_OF_COLUMN, "at"])
    return CaseError(
        "cannot be collected",
        where="collect",
        found=text,
        allowed=f"such as {_EXAMPLES}; of columns {functions}",
        remedy=remedy,
    )
