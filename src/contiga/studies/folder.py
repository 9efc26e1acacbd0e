"""The folder of a study: its definition, the rows of its cases, and their table."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from hashlib import sha256
from pathlib import Path
from time import perf_counter
from typing import Any

from contiga.case.schema import Case
from contiga.errors import OutputError
from contiga.io.out.files import open_folder, write_json
from contiga.studies.one_case import CASES, Base
from contiga.studies.row import ROW, Row
from contiga.studies.spec import StudySpec
from contiga.studies.table import Table, table_of

MANIFEST, PAGE, MAP = "study.json", "study.html", "map.png"
OPTUNA = "optuna.log"
_WRITING_RATIO = 20.0
"""Time between two writings of the table, over the time of the last writing."""
_MIN_SECONDS = 2.0
"""Smallest time between two writings of the table."""
_MISSING = "nothing"
_NOT_COMPARED = re.compile(
    r"(base: )?title|map(\..+)?|retries|goal\.trials|base: (output\.report|plot.*|reference.*)"
)
"""Keys that do not distinguish studies: they change the drawings, or the extent of the study."""


class StudyFolder:
    """The folder of a study while it runs.

    Parameters
    ----------
    path : of the folder
    study : the specification of the study
    base : of its cases
    case : the base case, checked
    """

    def __init__(self, path: Path, study: StudySpec, base: Base, case: Case) -> None:
        self.path, self.base = path, base
        self._study = study
        tables = study.model_dump(mode="json", exclude_none=True, exclude={"base", "table"})
        self._manifest = dict(_flat(tables, ""))
        """Everything that determines the rows of a study, by key; files by their content."""
        case_tables = case.model_dump(mode="json", exclude_none=True)
        self._manifest |= {f"base: {key}": value for key, value in _flat(case_tables, "")}
        if study.table is not None:
            self._manifest["table"] = _content(study.table)
        self.rows: dict[int, Row] = {}
        """Rows by number."""
        self._written_at, self._writing_time = perf_counter(), 0.0

    def check(self, *, resume: bool) -> None:
        """Refuse a folder that belongs to something else. Nothing is written.

        Raises
        ------
        OutputError
            It holds rows of a study that is not to be resumed. Or it is to be resumed, and holds no
            study, or one that differs in a key that determines the rows.
        """
        manifest = self.path / MANIFEST
        if not resume and manifest.is_file() and next((self.path / CASES).glob(f"*/{ROW}"), None):
            raise OutputError(
                "the folder holds a study already",
                where=str(self.path),
                allowed="a new or empty folder, or --resume to run what is missing",
            )
        if not resume:
            return
        try:
            before: dict[str, Any] = json.loads(manifest.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise OutputError(
                "there is no study to resume",
                where=str(manifest),
                remedy="Run it without --resume",
            ) from error
        for key in dict.fromkeys((*before, *self._manifest)):
            value, value_before = (d.get(key, _MISSING) for d in (self._manifest, before))
            if value_before != value and not _NOT_COMPARED.fullmatch(key):
                raise OutputError(
                    f"the study in the folder differs: {key}",
                    where=str(self._study.file),
                    found=value,
                    allowed=f"{value_before!r}, as the study was begun",
                    remedy="Give the changed study a folder of its own",
                )

    def open(self, rows: Iterable[Row]) -> None:
        """Make the folder, write ``study.json``, and store the rows that exist already.

        Raises
        ------
        OutputError
            It holds other files but no study, or cannot be written.
        """
        open_folder(self.path, (MANIFEST,), "study")
        write_json(self.path / MANIFEST, self._manifest)
        self.rows |= {row.number: row for row in rows}

    def take(self, row: Row) -> None:
        """Store a row as it comes, and rewrite the table if it was not written for a while.

        That is 2 s, or twenty times as long as the last writing took, if this is more.
        """
        self.rows[row.number] = row
        elapsed = perf_counter() - self._written_at
        if elapsed > max(_MIN_SECONDS, _WRITING_RATIO * self._writing_time):
            self.write_table()

    def write_table(self) -> Table:
        """Write the table of the rows so far, note how long that took, and return it."""
        start = perf_counter()
        table = self.table()
        table.write(self.path)
        self._written_at = perf_counter()
        self._writing_time = self._written_at - start
        return table

    def table(self) -> Table:
        """Return the table of the rows so far."""
        units = {v.label: v.unit for v in self._study.variable} | self.base.units
        return table_of(self.rows.values(), self._study.labels, list(self.base.quantities), units)


def _flat(value: Any, key: str) -> Iterator[tuple[str, Any]]:
    """Yield the leaves of nested tables with their keys; lists of plain values are leaves.

    The absolute path of a file becomes its name and digest (`_content`).
    """
    if isinstance(value, dict) and value:
        for name, entry in value.items():
            yield from _flat(entry, f"{key}.{name}" if key else str(name))
    elif isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value):
        for i, entry in enumerate(value):
            yield from _flat(entry, f"{key}[{i}]")
    elif isinstance(value, str) and Path(value).is_absolute() and Path(value).is_file():
        yield key, _content(value)
    else:
        yield key, value


def _content(file: str) -> str:
    """Return name and digest of a file: a study keeps its identity when its folder is moved."""
    return f"{Path(file).name}, sha256 {sha256(Path(file).read_bytes()).hexdigest()[:16]}"
