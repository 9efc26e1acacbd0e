"""The curves of a case: tables, numbers, CSV files and curves of LS-DYNA keyword decks.

A file is read when the case is: from then on the case has its points, in its own units.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, ValidationInfo

from contiga.case.problems import validated
from contiga.case.spec import ExistingFile, Spec, is_number
from contiga.curves.characteristic import Characteristic
from contiga.errors import CaseError, InputError
from contiga.io.curves import read_curve
from contiga.io.units import Quantity, Units, base_factor

Extrapolation = Literal["linear", "constant", "error"]


class CurveTable(Spec):
    """`{ points = [[x, y], …], extrapolation = "linear" }`."""

    points: list[list[float]]
    extrapolation: Extrapolation = "linear"

    def describe(self) -> str:
        """Describe the table in words."""
        (x0, _), (x1, y1) = self.points[0], self.points[-1]
        beyond = {"linear": "goes on straight", "constant": "held", "error": "the run stops"}
        return (
            f"{len(self.points)} points from x = {x0:g} to ({x1:g}, {y1:g}), "
            f"{beyond[self.extrapolation]} beyond"
        )


class CurveFile(Spec):
    """`{ file, columns | curve, units, extrapolation }`: a CSV file, or a deck with curves."""

    file: ExistingFile
    columns: list[str] | None = None
    curve: int | None = None
    units: list[str] | None = None
    extrapolation: Extrapolation = "linear"


def _curve_of(x: Quantity, y: Quantity) -> Any:
    """Return the type of a curve of `y` over `x`, whose check reads a file that it names."""

    def as_table(value: Any, info: ValidationInfo) -> Any:
        """Return a number as a line through the origin, a list as points, and a file as its points.

        Other tables are returned as they are. CaseError for another value.
        """
        if is_number(value):
            return {"points": [[0.0, 0.0], [1.0, value]]}
        if isinstance(value, list):
            return {"points": value}
        if isinstance(value, dict) and "file" in value:
            spec = validated(CurveFile, value, info.context)
            table = read_curve(
                spec.file,
                (x, y),
                units_of_case(info.context),
                columns=spec.columns,
                curve=spec.curve,
                units=spec.units,
            )
            return {"points": table.tolist(), "extrapolation": spec.extrapolation}
        if isinstance(value, dict | CurveTable):
            return value
        raise CaseError(
            "must be a curve",
            found=value,
            allowed="a number, [[x, y], …], "
            '{ points = [[x, y], …], extrapolation = "linear" } or { file = "foam.csv" }',
        )

    return Annotated[CurveTable, BeforeValidator(as_table)]


def units_of_case(context: dict[str, Any] | None) -> Units:
    """Return length, mass and time unit of the case that is being read.

    If they are wrong, m, kg and s are returned: that error is reported separately.
    """
    table = (context or {}).get("units")
    dimensions = ("length", "mass", "time")
    try:
        length, mass, time = (table[dimension] for dimension in dimensions)  # type: ignore[index]
        for unit, dimension in zip((length, mass, time), dimensions, strict=True):
            base_factor(unit, dimension)
    except (TypeError, KeyError, InputError):
        return ("m", "kg", "s")
    return (length, mass, time)


if TYPE_CHECKING:
    ForceCurve = CurveTable
    StressCurve = CurveTable
    DampingCurve = CurveTable
    Amplification = CurveTable
    BeltCurve = CurveTable
    JointCurve = CurveTable
else:
    ForceCurve = _curve_of("length", "force")
    StressCurve = _curve_of("ratio", "stress")
    DampingCurve = _curve_of("rate", "stress")
    Amplification = _curve_of("rate", "ratio")
    BeltCurve = _curve_of("ratio", "force")
    # Moment over angle or force over travel: files have the units of the case.
    JointCurve = _curve_of("ratio", "ratio")


def with_characteristics(arguments: dict[str, Any]) -> dict[str, Any]:
    """Return `arguments` with each curve as a characteristic, which errors call by its argument."""
    return {
        name: Characteristic(value.points, extrapolation=value.extrapolation, name=name)
        if isinstance(value, CurveTable)
        else value
        for name, value in arguments.items()
    }
