"""The table of a study: a row for each case, in the order of their numbers."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contiga.extras import require
from contiga.io.out.files import atomic_write
from contiga.studies.cases import shown_value
from contiga.studies.row import Row

if TYPE_CHECKING:
    from pandas import DataFrame

HDF5, CSV = "table.h5", "table.csv"
_GROUP = "table"


class Table(NamedTuple):
    """Columns of equal length by name: numbers, or text."""

    columns: dict[str, list[Any]]
    variables: tuple[str, ...]
    quantities: tuple[str, ...]
    units: Mapping[str, str]
    """Units of the columns that have one."""

    def to_pandas(self) -> DataFrame:
        """Return a DataFrame of pandas, indexed by case numbers; `attrs["units"]` has the units.

        Without pandas a MissingPackageError is raised.
        """
        require("Study.to_pandas", "pandas")
        from pandas import DataFrame

        table = DataFrame(self.columns).set_index("case")
        table.attrs["units"] = dict(self.units)
        return table

    def write(self, folder: Path) -> None:
        """Write ``table.h5`` and ``table.csv``, each whole or not at all.

        Equal tables give equal bytes. In HDF5 a column that is not all numbers is stored as text;
        in CSV units stand in the header.
        """
        require("the table of a study", "h5py")
        import h5py

        with atomic_write(folder / HDF5) as temporary, h5py.File(temporary, "w") as file:
            group = file.create_group(_GROUP)
            group.attrs["columns"] = list(self.columns)
            group.attrs["variables"] = list(self.variables)
            group.attrs["quantities"] = list(self.quantities)
            for name, values in self.columns.items():
                if all(isinstance(value, int | float) for value in values):
                    group.create_dataset(name, data=np.array(values))
                    group[name].attrs["unit"] = self.units.get(name, "")
                else:
                    text = [str(value) for value in values]
                    group.create_dataset(name, data=text, dtype=h5py.string_dtype())
        with (
            atomic_write(folder / CSV) as temporary,
            temporary.open("w", newline="", encoding="utf-8") as csv_file,
        ):
            writer = csv.writer(csv_file, lineterminator="\n")
            heads = [(name, self.units.get(name, "")) for name in self.columns]
            writer.writerow([f"{name} [{unit}]" if unit else name for name, unit in heads])
            writer.writerows(zip(*self.columns.values(), strict=True))


def table_of(
    rows: Iterable[Row],
    variables: Sequence[str],
    quantities: Sequence[str],
    units: Mapping[str, str] | None = None,
) -> Table:
    """Return the table of rows in any order, sorted by their numbers; `units` are by column.

    Values that are neither numbers nor text become JSON (`shown_value`).
    """
    ordered = sorted(rows, key=lambda row: row.number)

    def column(part: str, name: str) -> list[Any]:
        values: list[Mapping[str, Any]] = [getattr(row, part) for row in ordered]
        return [shown_value(by_name[name]) for by_name in values]

    columns: dict[str, list[Any]] = {
        "case": [row.number for row in ordered],
        **{name: column("values", name) for name in variables},
        **{name: column("collected", name) for name in quantities},
        "status": [row.status for row in ordered],
        "message": [row.message for row in ordered],
    }
    known_units = {name: unit for name, unit in (units or {}).items() if unit}
    return Table(columns, tuple(variables), tuple(quantities), known_units)
