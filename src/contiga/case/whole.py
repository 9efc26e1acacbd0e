"""What is wrong with a case, all at once: tables that say what they may not, and parts that cannot
be made of the others."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from contiga.case.build import faults_of
from contiga.case.include import Whole
from contiga.case.names import Misnamed
from contiga.case.problems import Fault, listed, misnamed_in, placed, problem_of, traced
from contiga.case.schema import Case, case_of, read_text, tables_of
from contiga.errors import InputError

_PLACE = re.compile(r"^(\w+)\[(\d+)\]")
_Tables = Mapping[str, Any]


def load_whole(path: Path, *, set: Mapping[str, Any] | None = None) -> Case:
    """The case of a file that is to be built, as `load_case`.

    Where its tables are wrong, the parts that other tables describe are made all the same, and what
    is wrong with their files, places and masses ends the list.

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
        misnamed = misnamed_in(data, details)
        more = _faults_of_the_rest(tables, details, misnamed, path)
        if not more:
            raise
        problems = [*(problem_of(one, data) for one in details), *(one.error for one in misnamed)]
        told = [traced(one, origins, "") for one in problems]
        raise listed([*told, *more], str(path)) from error


def _faults_of_the_rest(
    read: Whole, details: Sequence[ErrorDetails], misnamed: Sequence[Misnamed], path: Path
) -> list[Fault]:
    """What is wrong with the parts that no wrong table is of; none where these make up no case."""
    data = read.data
    wrong = {(one.key, one.row) for one in misnamed}
    for one in details:
        match one["loc"]:
            case (str(key), int(i), *_):
                wrong.add((key, i))
            case _:
                return []
    places = {
        key: [i for i in range(len(entries)) if (key, i) not in wrong]
        for key, entries in data.items()
        if isinstance(entries, list)
    }
    tables = [entry for k, i in wrong if isinstance(entry := data[k][i], Mapping)]
    kept = _without_what_hangs_on_them(data, places, {table.get("name") for table in tables})
    try:
        case = Case.model_validate(kept, context={"folder": path.parent, "units": data["units"]})
    except ValidationError:
        return []
    case._file = path
    return [placed(fault, _at(key, places), "", read.origins) for fault, key in faults_of(case)]


def _without_what_hangs_on_them(
    data: _Tables, places: dict[str, list[int]], names: set[object]
) -> dict[str, Any]:
    """The tables at `places`, but for those that name one that is gone; they are struck off."""
    gone = {name for name in names if isinstance(name, str)}
    before = -1
    while before != len(gone):
        before = len(gone)
        for key, rows in places.items():
            hanging = [i for i in rows if _names(data[key][i]) & gone]
            gone |= {name for i in hanging if isinstance(name := data[key][i].get("name"), str)}
            places[key] = [i for i in rows if i not in hanging]
    return {**data, **{key: [data[key][i] for i in rows] for key, rows in places.items()}}


def _names(value: Any) -> set[str]:
    """All text in a table but for its own name."""
    if isinstance(value, str):
        return {value}
    if isinstance(value, Mapping):
        return set().union(*(_names(one) for key, one in value.items() if key != "name"))
    return set().union(*map(_names, value)) if isinstance(value, list) else set()


def _at(key: str, places: Mapping[str, list[int]]) -> str:
    """The key of the file, of one that counts the tables that were kept."""
    return _PLACE.sub(lambda m: f"{m[1]}[{places[m[1]][int(m[2])]}]", key)
