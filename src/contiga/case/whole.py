"""All errors of a case at once: in its tables, and in parts that cannot be made."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from contiga.case.build import faults_of
from contiga.case.case_file import read_text
from contiga.case.include import CaseTables
from contiga.case.names import UnresolvedName
from contiga.case.problems import (
    Fault,
    at_key,
    combined_error,
    error_of,
    in_its_file,
    unresolved_in,
)
from contiga.case.schema import Case, case_of, tables_of
from contiga.errors import InputError

_PLACE = re.compile(r"^(\w+)\[(\d+)\]")


def load_case_to_build(path: Path, *, set: Mapping[str, Any] | None = None) -> Case:
    """Return the case of a file that is to be built, as `load_case`.

    If its tables are wrong, the parts that the correct tables describe are built all the same, and
    the errors in their files, places and masses end the list.

    Raises
    ------
    InputError
        As `load_case`.
    """
    tables = tables_of(read_text(path), path, set)
    try:
        return case_of(tables, path)
    except InputError as error:
        cause = error.__cause__
        if not isinstance(cause, ValidationError):
            raise
        data, origins = tables
        details = cause.errors(include_url=False)
        unresolved = unresolved_in(data, details)
        faults = _faults_of_correct_tables(tables, details, unresolved, path)
        if not faults:
            raise
        errors = [*(error_of(detail, data) for detail in details), *(u.error for u in unresolved)]
        messages = [in_its_file(error, origins, "") for error in errors]
        raise combined_error([*messages, *faults], str(path)) from error


def _faults_of_correct_tables(
    tables: CaseTables,
    details: Sequence[ErrorDetails],
    unresolved: Sequence[UnresolvedName],
    path: Path,
) -> list[Fault]:
    """Return the errors in the parts without a wrong table, each with its key in the file.

    Parts that name a wrong part are left out, and so are those that name these. There are none if
    an error is not in a table of a list, or the rest makes up no case.
    """
    data = tables.data
    wrong = {(name.key, name.row) for name in unresolved}
    for detail in details:
        match detail["loc"]:
            case (str(key), int(i), *_):
                wrong.add((key, i))
            case _:
                return []
    rows_by_key = {
        key: [i for i in range(len(entries)) if (key, i) not in wrong]
        for key, entries in data.items()
        if isinstance(entries, list)
    }
    wrong_tables = [table for key, i in wrong if isinstance(table := data[key][i], Mapping)]
    missing = {name for table in wrong_tables if isinstance(name := table.get("name"), str)}
    # Tables that name a missing part are removed, and so are the tables that name these.
    count = -1
    while count != len(missing):
        count = len(missing)
        for key, rows in rows_by_key.items():
            removed = [i for i in rows if _names(data[key][i]) & missing]
            missing |= {name for i in removed if isinstance(name := data[key][i].get("name"), str)}
            rows_by_key[key] = [i for i in rows if i not in removed]
    correct = data | {key: [data[key][i] for i in rows] for key, rows in rows_by_key.items()}
    try:
        case = Case.model_validate(correct, context={"folder": path.parent, "units": data["units"]})
    except ValidationError:
        return []
    case._file = path

    def key_in_file(key: str) -> str:
        """Return the key in the file for a key that counts the correct tables."""
        return _PLACE.sub(lambda m: f"{m[1]}[{rows_by_key[m[1]][int(m[2])]}]", key)

    return [at_key(fault, key_in_file(key), "", tables.origins) for fault, key in faults_of(case)]


def _names(value: Any) -> set[str]:
    """Return all text in a table except its own name."""
    if isinstance(value, str):
        return {value}
    if isinstance(value, Mapping):
        return set().union(*(_names(entry) for key, entry in value.items() if key != "name"))
    return set().union(*map(_names, value)) if isinstance(value, list) else set()
