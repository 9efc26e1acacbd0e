"""A row of a study's table: one case, its values and its results."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

from contiga.io.out.files import write_json

ROW = "row.json"
DONE, FAILED, LOST = "done", "failed", "lost"
"""Outcome of a case: complete; failed with a message; lost with its worker after all retries."""


class Row(NamedTuple):
    """One case. Tables are made from the row in the file of its folder."""

    number: int
    status: str
    """`DONE`, `FAILED` or `LOST`."""
    message: str
    """Message of a failed case, and of missing quantities."""
    values: dict[str, Any]
    """Values of the variables."""
    collected: dict[str, float]
    """Collected quantities; NaN if there is none."""
    seconds: float
    """Duration with the compiling of kernels, seconds."""

    def write(self, folder: Path) -> None:
        """Write the row into the folder of its case, whole or not at all; NaN becomes null."""
        collected = {k: None if v != v else v for k, v in self.collected.items()}
        write_json(folder / ROW, {**self._asdict(), "collected": collected})

    def of_case(self, values: dict[str, Any], quantities: list[str]) -> bool:
        """Return whether the row has these values of variables and quantities in this order."""
        return self.values == values and list(self.collected) == quantities


def read_row(folder: Path) -> Row | None:
    """Return the row in the folder of a case; None if there is none that can be read."""
    try:
        row: dict[str, Any] = json.loads((folder / ROW).read_text(encoding="utf-8"))
        collected = {k: float("nan") if v is None else v for k, v in row["collected"].items()}
        return Row(**{**row, "collected": collected})
    except (OSError, ValueError, KeyError, TypeError):
        return None
