"""Results of experiments as JSON and as one tidy CSV, and the machine of the run."""

from __future__ import annotations

import csv
import io
import math
import os
import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from contiga import __version__
from contiga.arrays.threads import thread_count
from contiga_validation.engine.experiment import Cell, ExperimentResult

HEADER = ("experiment", "table", "row", "column", "value")


def plain(value: Any) -> Cell:
    """Return `value` for JSON: numpy scalars as Python's, NaN and infinity as None.

    Booleans become "yes" and "no", values of other types text.
    """
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, str | int | float):
        return value
    return str(value)


def tidy_csv(results: Sequence[ExperimentResult]) -> str:
    """Return all tables as CSV, one value a row: experiment, table, row (from 1), column, value.

    None is an empty cell.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEADER)
    for entry in results:
        for table in entry.outcome.tables:
            for number, row in enumerate(table.rows, start=1):
                for column, value in zip(table.columns, row, strict=True):
                    cell = plain(value)
                    cell = "" if cell is None else cell
                    writer.writerow((entry.experiment.key, table.key, number, column, cell))
    return text.getvalue()


def as_json(results: Sequence[ExperimentResult], facts: dict[str, Any]) -> dict[str, Any]:
    """Return `facts` with all results, for JSON; pictures by their file names."""
    return {**facts, "experiments": [_entry(entry) for entry in results]}


def _entry(entry: ExperimentResult) -> dict[str, Any]:
    experiment, outcome = entry.experiment, entry.outcome
    return {
        "key": experiment.key,
        "chapter": experiment.chapter,
        "title": experiment.title,
        "where": experiment.where,
        "thesis": experiment.thesis,
        "difference": outcome.difference,
        "seconds": round(entry.seconds, 3),
        "compiling_seconds": round(entry.compiled, 3),
        "claims": [
            {"text": claim.text, "holds": bool(claim.holds), "measured": claim.measured}
            for claim in outcome.claims
        ],
        "tables": [
            {
                "key": table.key,
                "title": table.title,
                "columns": list(table.columns),
                "rows": [[plain(value) for value in row] for row in table.rows],
            }
            for table in outcome.tables
        ],
        "pictures": [
            {"key": picture.key, "file": f"figures/{picture.key}.png", "caption": picture.caption}
            for picture in outcome.pictures
        ],
    }


def machine() -> dict[str, Any]:
    """Return version, present time and machine of a run, for pages and JSON."""
    import numba
    import numpy as np

    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return {
        "version": __version__,
        "finished": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "threads": thread_count(),
        "cores": os.cpu_count() or 1,
        "processor": names[0] if names else platform.processor() or "unknown",
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": numba.__version__,
    }
