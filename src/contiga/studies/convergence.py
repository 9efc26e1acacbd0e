"""Convergence of collected quantities over finer meshes."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from contiga.report.style import number
from contiga.studies.row import Row
from contiga.studies.spec import StudySpec


class Line(NamedTuple):
    """One quantity over the meshes, for fixed values of all other variables."""

    label: str
    """Values of the other variables."""
    rows: list[int]
    """Numbers of the cases, coarse to fine."""
    values: list[float]
    """Values of the quantity, coarse to fine."""
    errors: list[float]
    """Distances of all values but the last from the last, the finest."""
    order: float
    """Order of convergence in the mesh size; NaN if it cannot be determined."""


def sizes_of(levels: list[float]) -> list[float]:
    """Return the sizes of meshes, from coarse to fine, over that of the first.

    Rising levels are counts of elements along a side, falling ones are sizes.

    >>> sizes_of([10.0, 20.0, 40.0]), sizes_of([4.0, 2.0, 1.0])
    ([1.0, 0.5, 0.25], [1.0, 0.5, 0.25])
    """
    rises = levels[-1] > levels[0]
    return [levels[0] / level if rises else level / levels[0] for level in levels]


def lines_of(study: StudySpec, rows: list[Row], quantity: str) -> list[Line]:
    """Return a line for each choice of the other variables that has a row for every mesh.

    Rows of failed cases count, with NaN. The study must have a refined variable.
    """
    refined = refined_variable(study)
    assert refined is not None
    assert refined.values is not None
    other_labels = [label for label in study.labels if label != refined.label]
    groups: dict[str, dict[str, Row]] = {}
    for row in rows:
        label = ", ".join(f"{name} {row.values[name]}" for name in other_labels)
        groups.setdefault(label, {})[repr(row.values[refined.label])] = row
    levels = [repr(value) for value in refined.values]
    sizes = sizes_of([float(value) for value in refined.values])
    lines = []
    for label, by_level in groups.items():
        if all(level in by_level for level in levels):
            cases = [by_level[level] for level in levels]
            values = [row.collected[quantity] for row in cases]
            errors = [abs(value - values[-1]) for value in values[:-1]]
            numbers = [row.number for row in cases]
            order = order_of(values, sizes)
            lines.append(Line(label or quantity, numbers, values, errors, order))
    return lines


def refined_variable(study: StudySpec) -> Any:
    """Return the first variable that `refines` and has several positive numbers; None without."""
    for variable in study.variable:
        numeric = variable.values is not None and all(
            isinstance(value, int | float) and value > 0 for value in variable.values
        )
        if variable.refines and numeric and len(variable.values or ()) > 1:
            return variable
    return None


def order_of(values: list[float], sizes: list[float]) -> float:
    """Return the order p of values c + a h^p at sizes h, from the last three (Roache 1998, 5.4).

    The order is NaN if it is not between 0.01 and 12, if the values do not approach a limit from
    one side, the sizes do not fall, or there are fewer than three finite values.

    >>> round(order_of([1.0 + h**2 for h in (1.0, 0.5, 0.25)], [1.0, 0.5, 0.25]), 9)
    2.0
    """
    from scipy.optimize import brentq

    if len(values) < 3 or not np.isfinite(values[-3:]).all():
        return math.nan
    (a, b, c), (p, q, r) = values[-3:], sizes[-3:]
    if not p > q > r or (a - b) * (b - c) <= 0.0:
        return math.nan
    ratio = (a - b) / (b - c)

    def residual(order: float) -> float:
        return float((p**order - q**order) / (q**order - r**order) - ratio)

    low, high = 0.01, 12.0
    if residual(low) * residual(high) > 0.0:
        return math.nan
    return float(brentq(residual, low, high))


def line_in_words(line: Line) -> str:
    """Return the finest value of a line, its change in per cent, and its order, as a sentence."""
    text = f"{line.label}: {number(line.values[-1])} at the finest"
    if line.values[-1] != 0.0 and line.errors:
        text += (
            f", {number(100.0 * line.errors[-1] / abs(line.values[-1]), 2)} % from the one before"
        )
    return text if math.isnan(line.order) else f"{text}, order {number(line.order, 2)}"
