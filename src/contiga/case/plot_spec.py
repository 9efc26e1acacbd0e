"""The `plot` and `reference` tables of a case: figures of channels, and curves of tests."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, ValidationInfo, model_validator

from contiga.case.curve_spec import units_of_case
from contiga.case.problems import validated
from contiga.case.spec import ExistingFile, Spec, is_number, must_be
from contiga.errors import CaseError
from contiga.io.channels import unknown_channel
from contiga.io.column_units import kind_of_column
from contiga.io.measured import read_measured
from contiga.io.units import Quantity

Row = Annotated[list[float], Field(min_length=2, max_length=2)]
BandRow = Annotated[list[float], Field(min_length=3, max_length=3)]


class PlotSpec(Spec):
    """A `[[plot]]`: a figure of channels over another channel."""

    x: str = "time"
    """Channel of the abscissa."""
    y: str | Annotated[list[str], Field(min_length=1)]
    """Channels to draw, of one unit."""

    @property
    def channels(self) -> list[str]:
        """The names in `y`."""
        return [self.y] if isinstance(self.y, str) else self.y

    def describe(self) -> str:
        """Describe the table in words."""
        return f"{', '.join(self.channels)} over {self.x}"


class _MeasuredFile(Spec):
    """Keys of a `[[reference]]` that tell the place of its curve."""

    file: ExistingFile
    columns: list[str] | None = None
    """Columns of the abscissa and the value in a csv file."""
    code: str | None = None
    """Code of the channel of an ISO-MME test, or its first characters."""
    unit: str | None = None
    """Unit of the values, where the file does not give it."""
    x_unit: str | None = None
    """Unit of the abscissa, where the file does not give it."""


class _CorridorFile(Spec):
    """A corridor that is a file in place of a fraction."""

    corridor: ExistingFile


class ReferenceSpec(Spec):
    """A `[[reference]]`: the curve of a test, to be drawn beside a channel of the run.

    The file is read with the case, which then has the points in its own units.
    """

    channel: str
    """Channel of the run that was measured."""
    x: str = "time"
    """Channel of the abscissa."""
    name: str
    """Name of the curve; the name of its file if omitted."""
    points: Annotated[list[Row], Field(min_length=2)]
    """[x, value] in the units of the case."""
    shift: Annotated[
        float | str,
        must_be(
            lambda value: is_number(value) or value == "onset",
            "must be a number, or the word onset",
            'a time, or "onset"',
            words=["onset"],
        ),
    ] = 0.0
    """Shift of the abscissa; "onset" moves the onset of the test to the onset of the run."""
    corridor: (
        Annotated[
            float | list[BandRow],
            must_be(
                lambda value: isinstance(value, list) or (is_number(value) and value > 0.0),
                "must be a fraction of the greatest magnitude, or a file",
                'a number above 0, such as 0.1, or "corridor.csv"',
            ),
        ]
        | None
    ) = None
    """Half the width of a band about the curve as a fraction of its greatest magnitude, or rows
    [x, lower, upper], which are shifted with the curve."""

    @classmethod
    def known_keys(cls, data: dict[str, Any]) -> list[str]:
        """Return the keys of the table, and the keys of a file in place of points."""
        return list(dict.fromkeys([*_MeasuredFile.model_fields, *super().known_keys(data)]))

    @model_validator(mode="before")
    @classmethod
    def _read_files(cls, data: Any, info: ValidationInfo) -> Any:
        """Return a copy of the table with the points of its file and the rows of its corridor.

        Values are converted to the units of the case; a missing name is that of the file, or
        "test". InputError if a file, its channel, or the choice of file or points is wrong.
        """
        if not isinstance(data, dict):
            return data
        kinds = _kind_of(data, "x", "time"), _kind_of(data, "channel")
        data = dict(data)
        file_keys = {key: data.pop(key) for key in _MeasuredFile.model_fields if key in data}
        if ("points" in data) == ("file" in file_keys):
            raise CaseError("must have exactly one of the keys file or points")
        if "file" not in file_keys and file_keys:
            raise CaseError(
                "is a key of a file, and points are in the units of the case",
                where=next(iter(file_keys)),
            )
        x_unit = unit = None
        if file_keys:
            measured = validated(_MeasuredFile, file_keys, info.context)
            x_unit, unit = measured.x_unit, measured.unit
            data.setdefault("name", Path(measured.file).name)
            data["points"] = read_measured(
                measured.file,
                kinds,
                units_of_case(info.context),
                columns=measured.columns,
                code=measured.code,
                units=(x_unit, unit),
            ).tolist()
        data.setdefault("name", "test")
        if isinstance(data.get("corridor"), str):
            corridor = {"corridor": data["corridor"]}
            data["corridor"] = read_measured(
                validated(_CorridorFile, corridor, info.context).corridor,
                (*kinds, kinds[1]),
                units_of_case(info.context),
                units=(x_unit, unit),
            ).tolist()
        return data

    @model_validator(mode="after")
    def _curve_can_be_drawn(self) -> Self:
        """Refuse times that do not rise, a corridor upside down, and an onset without time."""
        rows = [("points", self.points)]
        if isinstance(self.corridor, list):
            rows.append(("corridor", self.corridor))
            if any(low > high for _, low, high in self.corridor):
                raise CaseError("the lower values are above the upper ones", where="corridor")
        if self.x == "time":
            for key, table in rows:
                if (np.diff([row[0] for row in table]) <= 0.0).any():
                    raise CaseError("the times must increase from row to row", where=key)
        elif self.shift == "onset":
            raise CaseError("is for a curve over time", where="shift", found=self.shift)
        return self

    def describe(self) -> str:
        """Describe the table in words."""
        span = f"{self.points[0][0]:g} to {self.points[-1][0]:g}"
        moved = ", shifted to the onset of the run" if self.shift == "onset" else ""
        if is_number(self.shift) and self.shift:
            moved = f", shifted by {self.shift:g}"
        band = ""
        if self.corridor is not None:
            wide = is_number(self.corridor)
            band = f", corridor of {100 * self.corridor:g} %" if wide else ", corridor of its own"
        return f"{self.channel} over {self.x}, {len(self.points)} points, {span}{moved}{band}"

    def check_overlap(self, start: float, end: float) -> None:
        """Refuse a curve over time that has no time in common with a run from `start` to `end`.

        A curve that is shifted to the onset of the run passes.
        """
        if self.x != "time" or not is_number(self.shift):
            return
        first, last = (row[0] + float(self.shift) for row in (self.points[0], self.points[-1]))
        if not max(first, start) < min(last, end):
            raise CaseError(
                "has no time in common with the run",
                where="shift" if self.shift else "points",
                found=f"{first:g} to {last:g}",
                allowed=f"times from {start:g} to {end:g}",
                remedy='Set shift = "onset" to have both begin at one time',
            )


def _kind_of(data: dict[str, Any], key: str, default: str | None = None) -> Quantity:
    """Return the quantity of the channel that a table names.

    Raises
    ------
    CaseError
        The key is missing without a `default`, or names no channel.
    """
    if key not in data and default is None:
        raise CaseError("is missing", where=key, allowed="the channel of the run that was measured")
    name = data.get(key, default)
    kind = kind_of_column(name) if isinstance(name, str) else None
    if kind is None:
        raise CaseError(
            "is not a channel of a run",
            where=key,
            found=name,
            allowed="a column of the history, such as head_cg.a; or the travel of a sensor",
        )
    return kind


def check_channel(key: str, name: str, channels: Iterable[str]) -> None:
    """Refuse a channel that a run of the case will not have."""
    names = {"time", *channels}
    if name not in names:
        raise CaseError(**unknown_channel("the run will have no such channel", key, name, names))


def check_kinds(key: str, names: list[str]) -> None:
    """Refuse channels of different quantities in one figure; unknown channels are left out."""
    kinds = {kind for name in names if (kind := kind_of_column(name)) is not None}
    if len(kinds) > 1:
        raise CaseError(
            "the channels of one figure must have one unit",
            where=key,
            found=", ".join(names),
            allowed="a [[plot]] for each unit",
        )
