"""A row of a study's table: one case, what it was and what came of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

from contiga.io.out.files import write_json

ROW = "row.json"
DONE, FAILED, LOST = "done", "failed", "lost"
"""What came of a case: all its numbers; a message; its worker died as often as it was begun."""


class Row(NamedTuple):
    """One case. In the file of its folder it is the truth that tables are made of."""

    number: int
    status: str
    message: str
    """Of a case that failed, and of quantities that one lacks."""
    values: dict[str, Any]
    """Of the variables."""
    collected: dict[str, float]
    """NaN where there is none."""
    seconds: float
    """It took, compiling of kernels included."""

    def write(self, folder: Path) -> None:
        """Write the row into the folder of its case, whole or not at all."""
        collected = {k: None if v != v else v for k, v in self.collected.items()}
        write_json(folder / ROW, {**self._asdict(), "collected": collected})

    def of_case(self, values: dict[str, Any], quantities: list[str]) -> bool:
        """Whether it is the row of a case with these values, of which this is collected."""
        return self.values == values and list(self.collected) == quantities


def read_row(folder: Path) -> Row | None:
    """The row in the folder of a case; None where there is none that can be read."""
    try:
        row: dict[str, Any] = json.loads((folder / ROW).read_text(encoding="utf-8"))
        collected = {k: float("nan") if v is None else v for k, v in row["collected"].items()}
        return Row(**{**row, "collected": collected})
    except (OSError, ValueError, KeyError, TypeError):
        return None
