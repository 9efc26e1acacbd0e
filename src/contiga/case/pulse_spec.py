"""Motions of a case by velocity or acceleration over time, in units of their own."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, Self

from pydantic import Field, model_validator

from contiga.case.spec import Axis, ExistingFile, MotionSpec, TimeUnit, Vector
from contiga.dynamics.prescribed import BodyMotion
from contiga.dynamics.pulse_files import read_pulse
from contiga.dynamics.pulses import Accelerated, Velocity
from contiga.errors import CaseError
from contiga.io.curves import read_curve
from contiga.io.mesh.lsdyna import SUFFIXES
from contiga.io.units import Quantity, Units, acceleration_factor, time_factor, velocity_factor
from contiga.records import FloatArray

# Any units serve to check whether a pulse is valid.
_ANY_UNITS = ("m", "kg", "s")


class _PulseSpec(MotionSpec):
    kind: str
    table: list[list[float]] | None = None
    file: ExistingFile | None = None
    columns: list[str] | None = None
    """Columns of the file: the time, and one or three values."""
    curve: int | None = None
    """Number of the curve in a keyword deck."""
    unit: str | None = None
    """Unit of the values, if it is not the case's; the header of a file may give it too."""
    time_unit: TimeUnit | None = None
    direction: Axis | None = None
    smooth: bool = False

    def motion_in(self, units: Units) -> BodyMotion:
        """Return the motion in the units of the case."""
        raise NotImplementedError

    @model_validator(mode="after")
    def _motion_is_possible(self) -> Self:
        """Refuse both or neither of table and file, keys of another source, and a wrong pulse."""
        if (self.table is None) == (self.file is None):
            raise CaseError("must have exactly one of the keys table or file")
        if self.columns is not None and self.file is None:
            raise CaseError("only a file has columns", where="columns", found=self.columns)
        if self.curve is not None and not self._is_deck:
            raise CaseError(
                "only a keyword deck has numbered curves",
                where="curve",
                found=self.curve,
                allowed="a file that ends in " + ", ".join(SUFFIXES),
            )
        assert self.motion_in(_ANY_UNITS) is not None
        return self

    @property
    def _is_deck(self) -> bool:
        return self.file is not None and Path(self.file).suffix.lower() in SUFFIXES

    def _rows(
        self, units: Units, quantity: Literal["velocity", "acceleration"]
    ) -> FloatArray | list[list[float]]:
        """Return the rows t, values of the table or the file, in the units of the case.

        Raises
        ------
        InputError
            A unit, the file or its columns are wrong.
        """
        length, _, time = units
        factor_of = velocity_factor if quantity == "velocity" else acceleration_factor
        factor = 1.0 if self.unit is None else factor_of(self.unit, length, time, "unit")
        if self.file is not None and self._is_deck:
            unit = f"{length}/{time}" if quantity == "velocity" else f"{length}/{time}^2"
            units_of_file = [self.time_unit or time, self.unit or unit]
            kinds: tuple[Quantity, Quantity] = ("time", quantity)
            return read_curve(
                self.file,
                kinds,
                units,
                columns=self.columns,
                curve=self.curve,
                units=units_of_file,
            )
        if self.file is not None:
            return read_pulse(
                self.file,
                units=(length, time),
                columns=self.columns,
                time_unit=self.time_unit,
                unit=self.unit,
                quantity=quantity,
            )
        to_time = 1.0 if self.time_unit is None else time_factor(self.time_unit, time, "time_unit")
        rows = self.table or []
        return [[to_time * t for t in row[:1]] + [factor * v for v in row[1:]] for row in rows]

    def describe(self) -> str:
        """Describe the table in words."""
        if self.table is None:
            curve = "" if self.curve is None else f"curve {self.curve} of "
            source = f"{curve}the file {self.file}"
        else:
            span = f"t = {self.table[0][0]:g} to {self.table[-1][0]:g}"
            source = f"a table of {len(self.table)} rows, {span} {self.time_unit or ''}".strip()
        unit = "" if self.unit is None else f" in {self.unit}"
        direction = "" if self.direction is None else f" along {self.direction}"
        return f"{self.kind}{unit}{direction} from {source}{', smooth' if self.smooth else ''}"


class VelocitySpec(_PulseSpec):
    """`{ kind = "velocity", table | file, columns, unit, time_unit, direction, smooth }`."""

    kind: Literal["velocity"] = "velocity"

    def motion_in(self, units: Units) -> Velocity:
        """Return the motion in the units of the case."""
        rows = self._rows(units, "velocity")
        return Velocity(rows, direction=self.direction, smooth=self.smooth)


class AccelerationSpec(_PulseSpec):
    """`{ kind = "acceleration", …, velocity }`: keys of a velocity, and the initial velocity."""

    kind: Literal["acceleration"] = "acceleration"
    velocity: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Velocity at the first row, in the units of the case."""

    def motion_in(self, units: Units) -> Accelerated:
        """Return the motion in the units of the case."""
        rows = self._rows(units, "acceleration")
        return Accelerated(
            rows, direction=self.direction, velocity=self.velocity, smooth=self.smooth
        )

    def describe(self) -> str:
        """Describe the table in words."""
        start = f", at first with the velocity {self.velocity}" if any(self.velocity) else ""
        return super().describe() + start
