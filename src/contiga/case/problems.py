"""Errors of pydantic about a case in contiga's own form: place, rule, value, allowed values."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from contiga.case.names import UnresolvedName, unresolved_names
from contiga.case.spec import suggest
from contiga.errors import CaseError, InputError, MissingPackageError
from contiga.io.naming import NAMES

Fault = InputError | MissingPackageError
"""An error that keeps a part of a case from being made."""
_MAX_CHARACTERS = 100
_MAX_LISTED = 12
_TABLE = re.compile(r"(\w+)\[(\d+)\]")
_KEY = re.compile(r"^[A-Za-z_]\w*(\[\d+\])*(\.\w+([ -]\w+)*(\[\d+\])*)*$")
_TYPES = {
    "float_type": "a number",
    "int_type": "a whole number",
    "bool_type": "true or false",
    "string_type": "text in quotes",
    "list_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
}


class Origin(NamedTuple):
    """The file and row of a table of a case that is not in its own file."""

    file: str
    row: int
    """Its place among the tables of its key in that file."""


Origins = Mapping[tuple[str, int], Origin]
"""By the key and the place of a table in the case."""


def case_error(
    error: ValidationError,
    data: object,
    file: str,
    *,
    key: str = "",
    origins: Origins | None = None,
) -> InputError:
    """Return one error with everything that pydantic found wrong in `data`, read from `file`.

    `data` stands under `key`; some of its tables may be from the files of `origins`. References
    that are unresolved are added; a single error is returned as it is, several as one list.
    """
    details = error.errors(include_url=False)
    errors = [error_of(detail, data, key) for detail in details]
    errors += [name.error for name in unresolved_in(data, details)]
    if len(errors) == 1:
        return in_its_file(errors[0], origins or {}, file)
    return combined_error([in_its_file(error, origins or {}, "") for error in errors], file)


def in_its_file(error: InputError, origins: Origins, file: str) -> InputError:
    """Return `error`, whose place is a key of a case, with the file that has this key.

    That is the file of `origins`, else `file`.
    """
    where = error.where or ""
    table = _TABLE.match(where)
    origin = origins.get((table[1], int(table[2]))) if table else None
    if table is not None and origin is not None:
        file, where = origin.file, f"{table[1]}[{origin.row}]{where[table.end() :]}"
    return _with_place(error, _file_and_key(file, where))


def unresolved_in(data: object, details: Sequence[ErrorDetails]) -> list[UnresolvedName]:
    """Return unresolved references, which pydantic does not check if other tables are wrong."""
    if not isinstance(data, Mapping):
        return []
    return unresolved_names(data, [detail["loc"] for detail in details])


def combined_error(faults: Sequence[Fault], file: str) -> InputError:
    """Return one error for the case `file` that lists the first 12 faults and counts the rest."""
    lines = [str(fault) for fault in faults[:_MAX_LISTED]]
    if len(faults) > _MAX_LISTED:
        lines.append(f"and {len(faults) - _MAX_LISTED} more")
    return CaseError(f"{len(faults)} things are wrong\n  " + "\n  ".join(lines), where=file)


class ErrorCollector:
    """Collector of the errors of a case, so that all are reported at once.

    Parameters
    ----------
    file : of the case
    origins : of tables that other files have
    """

    def __init__(self, file: str, origins: Origins) -> None:
        self._file, self._origins = file, origins
        self._faults: list[tuple[Fault, str]] = []

    @contextmanager
    def at(self, key: str) -> Iterator[None]:
        """Collect a `Fault` raised inside, with the key of the case it belongs to."""
        try:
            yield
        except (InputError, MissingPackageError) as error:
            self._faults.append((error, key))

    @property
    def faults(self) -> tuple[tuple[Fault, str], ...]:
        """The collected errors, each with its key."""
        return tuple(self._faults)

    def raise_all(self) -> None:
        """Raise the collected errors, if there are any.

        Raises
        ------
        InputError, MissingPackageError
            There is one only: a copy of it with file and key; a plain InputError as a CaseError.
        CaseError
            There are several, missing packages included: the first 12 as one list, and the number
            of the others.
        """
        if not self._faults:
            return
        first, key = self._faults[0]
        if len(self._faults) == 1:
            raise at_key(first, key, self._file, self._origins) from first
        faults = [at_key(fault, key, "", self._origins) for fault, key in self._faults]
        raise combined_error(faults, self._file) from first


def first_error(error: ValidationError, data: object, key: str) -> InputError:
    """Return the first error in the table under `key`."""
    return error_of(error.errors(include_url=False)[0], data, key)


def validated(kind: Any, data: Any, context: Any, key: str = "") -> Any:
    """Return `data`, which stands under `key`, as a value of a type; only its first error counts.

    Raises
    ------
    InputError
        The data are wrong.
    """
    try:
        return TypeAdapter(kind).validate_python(data, context=context)
    except ValidationError as error:
        raise first_error(error, data, key) from error


def at_key(fault: Fault, key: str, file: str, origins: Origins) -> Fault:
    """Return `fault` with the key of the case it belongs to, in the file that has it."""
    if isinstance(fault, MissingPackageError):
        return MissingPackageError(f"{_file_and_key(file, key)}: {fault}")
    return in_its_file(with_case_key(fault, key, ""), origins, file)


def with_case_key(error: InputError, key: str, file: str) -> InputError:
    """Return `error` with the key of the case it belongs to; an `InputError` as a `CaseError`.

    A place that the error has already follows the key, unless the key ends with it.
    """
    where = error.where
    if not where:
        path = key
    elif not _KEY.match(where):
        path = f"{key}: {where}" if key else where
    elif key == where or key.endswith(f".{where}"):
        path = key
    else:
        path = f"{key}.{where}" if key else where
    return _with_place(error, _file_and_key(file, path))


@contextmanager
def errors_at(key: str, file: str = "") -> Iterator[None]:
    """Raise each `InputError` from inside again, with the key of the case it belongs to."""
    try:
        yield
    except InputError as error:
        raise with_case_key(error, key, file) from error


def check_at(key: str, check: Callable[..., object], *arguments: object) -> None:
    """Carry out a check whose errors belong to a key of the case."""
    with errors_at(key):
        check(*arguments)


def _with_place(error: InputError, where: str | None) -> InputError:
    """Return a copy of `error` at the place `where`, with a long found value cut short.

    A plain `InputError` becomes a `CaseError`.
    """
    kind = CaseError if type(error) is InputError else type(error)
    details: dict[str, Any] = {"allowed": error.allowed, "remedy": error.remedy}
    if error.has_found:
        details["found"] = _short(error.found)
    return kind(error.what, where=where, **details)


def error_of(detail: ErrorDetails, data: object, key: str = "") -> InputError:
    """Return one error that pydantic found in `data`, which stands under `key`.

    An `InputError` of contiga's own checks keeps its text; pydantic's own are worded here.
    """
    path = key_path(detail["loc"], data, key)
    cause = (detail.get("ctx") or {}).get("error")
    if isinstance(cause, InputError):
        return with_case_key(cause, path, "")
    return CaseError(where=path or None, **_explained(detail))


def _explained(detail: ErrorDetails) -> dict[str, Any]:
    """Return the arguments of a `CaseError` for an error of pydantic's own.

    An unknown kind of error keeps pydantic's message.
    """
    kind, value, context = detail["type"], detail["input"], detail.get("ctx") or {}
    if kind == "missing":
        return {"what": "is missing"}
    found: dict[str, Any] = {"found": _short(value)}
    if kind == "list_type" and isinstance(value, Mapping) and len(detail["loc"]) == 1:
        brackets = f"Write [[{detail['loc'][0]}]] in double brackets: there may be several"
        return {"what": "must be a list of tables", **found, "remedy": brackets}
    if kind in _TYPES:
        return {"what": f"must be {_TYPES[kind]}", **found}
    if kind == "literal_error":
        options = re.findall(r"'([^']*)'", str(context["expected"]))
        allowed = ", ".join(f'"{option}"' for option in options)
        return {
            "what": "unknown value",
            **found,
            "allowed": allowed,
            "remedy": suggest(value, options),
        }
    if kind in ("greater_than", "greater_than_equal"):
        bound = context.get("gt", context.get("ge"))
        sign = ">" if "gt" in context else ">="
        return {"what": "is too small", **found, "allowed": f"{sign} {bound:g}"}
    if kind == "less_than_equal":
        return {"what": "is too large", **found, "allowed": f"<= {context['le']:g}"}
    if kind == "finite_number":
        return {"what": "must be finite", **found}
    if kind in ("too_short", "too_long"):
        lower, upper = context.get("min_length"), context.get("max_length")
        allowed = f"at most {upper}" if lower is None else f"at least {lower}"
        length = context["actual_length"]
        return {"what": "has the wrong length", "found": length, "allowed": allowed}
    if kind == "string_pattern_mismatch":
        return {"what": "is not a name", **found, "allowed": NAMES}
    return {"what": detail["msg"], **found}


def key_path(loc: Sequence[int | str], data: object, start: str = "") -> str:
    """Return the place of an error as a user would write it: ``contact[0].law.curve[1][0]``.

    Tags of unions, and keys that only a long form of the value would have, are left out.
    """
    path, value = start, data
    for part in loc:
        if isinstance(part, int):
            path += f"[{part}]"
            value = value[part] if isinstance(value, list) and part < len(value) else None
        elif not part.startswith("<") and (value is None or isinstance(value, Mapping)):
            path += f".{part}" if path else part
            value = value.get(part) if isinstance(value, Mapping) else None
    return path


def _file_and_key(file: str, key: str) -> str | None:
    return ": ".join(part for part in (file, key) if part) or None


def _short(value: object) -> object:
    """Return `value`, shortened if it is too long for a message; a table as its keys."""
    if isinstance(value, Mapping):
        return f"a table with {', '.join(map(str, value))}"[:_MAX_CHARACTERS]
    if isinstance(value, list) and len(repr(value)) > _MAX_CHARACTERS:
        return f"a list of {len(value)}"
    if isinstance(value, int) and len(repr(value)) > _MAX_CHARACTERS:
        return f"a number of {len(repr(value))} digits"
    if isinstance(value, str) and len(value) > _MAX_CHARACTERS:
        return value[:_MAX_CHARACTERS] + "…"
    return value
