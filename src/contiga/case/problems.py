"""Errors of pydantic about a case in contiga's own form: place, rule, value, allowed values."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from contiga.case.names import Misnamed, misnamed
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

    `data` stands under `key`; some of its tables may be from the files of `origins`.
    """
    details = error.errors(include_url=False)
    problems = [problem_of(detail, data, key) for detail in details]
    problems += [one.error for one in misnamed_in(data, details)]
    if len(problems) == 1:
        return traced(problems[0], origins or {}, file)
    return listed([traced(one, origins or {}, "") for one in problems], file)


def traced(error: InputError, origins: Origins, file: str) -> InputError:
    """Return `error`, which names a key of a case, with the file that this was read from.

    That is the file of `origins`, else `file`.
    """
    where = error.where or ""
    match = _TABLE.match(where)
    origin = origins.get((match[1], int(match[2]))) if match else None
    if match is not None and origin is not None:
        file, where = origin.file, f"{match[1]}[{origin.row}]{where[match.end() :]}"
    return _elsewhere(error, _join(file, where))


def misnamed_in(data: object, details: Sequence[ErrorDetails]) -> list[Misnamed]:
    """Return unresolved references, which pydantic does not check if other tables are wrong."""
    return misnamed(data, [one["loc"] for one in details]) if isinstance(data, Mapping) else []


def listed(problems: Sequence[Fault], file: str) -> InputError:
    """Return one error that contains several; `file` is the case's."""
    lines = [str(problem) for problem in problems[:_MAX_LISTED]]
    if len(problems) > _MAX_LISTED:
        lines.append(f"and {len(problems) - _MAX_LISTED} more")
    return CaseError(f"{len(problems)} things are wrong\n  " + "\n  ".join(lines), where=file)


class Together:
    """Collector of the errors of a case, so that all are reported at once.

    Parameters
    ----------
    file : of the case
    origins : of tables that other files have
    """

    def __init__(self, file: str, origins: Origins) -> None:
        self._file, self._origins = file, origins
        self._errors: list[tuple[Fault, str]] = []

    @contextmanager
    def at(self, key: str) -> Iterator[None]:
        """Collect a `Fault` raised inside, with the key of the case it belongs to."""
        try:
            yield
        except (InputError, MissingPackageError) as error:
            self._errors.append((error, key))

    @property
    def errors(self) -> tuple[tuple[Fault, str], ...]:
        """The collected errors, each with its key."""
        return tuple(self._errors)

    def tell(self) -> None:
        """Raise the collected errors, if there are any.

        Raises
        ------
        InputError, MissingPackageError
            The only one.
        CaseError
            All of them as one list.
        """
        if not self._errors:
            return
        first, key = self._errors[0]
        if len(self._errors) == 1:
            raise placed(first, key, self._file, self._origins) from first
        faults = [placed(one, key, "", self._origins) for one, key in self._errors]
        raise listed(faults, self._file) from first


def first_problem(error: ValidationError, data: object, key: str) -> InputError:
    """Return the first error in the table under `key`."""
    return problem_of(error.errors(include_url=False)[0], data, key)


def placed(fault: Fault, key: str, file: str, origins: Origins) -> Fault:
    """Return `fault` with the key of the case it belongs to, in the file that has it."""
    if isinstance(fault, MissingPackageError):
        return MissingPackageError(f"{_join(file, key)}: {fault}")
    return traced(relocated(fault, key, ""), origins, file)


def relocated(error: InputError, key: str, file: str) -> InputError:
    """Return `error` with the key of the case it belongs to; an `InputError` as a `CaseError`."""
    return _elsewhere(error, _join(file, _inside(key, error.where)))


def _elsewhere(error: InputError, where: str | None) -> InputError:
    """Return `error` at another place; a plain `InputError` as a `CaseError`."""
    kind = CaseError if type(error) is InputError else type(error)
    details: dict[str, Any] = {"allowed": error.allowed, "remedy": error.remedy}
    if error.has_found:
        details["found"] = _short(error.found)
    return kind(error.what, where=where, **details)


def problem_of(detail: ErrorDetails, data: object, key: str = "", file: str = "") -> InputError:
    """Return one error that pydantic found in `data`, which stands under `key` in `file`."""
    path = key_path(detail["loc"], data, key)
    inner = (detail.get("ctx") or {}).get("error")
    if isinstance(inner, InputError):
        return relocated(inner, path, file)
    return CaseError(where=_join(file, path), **_words(detail))


def _wrong_length(context: Mapping[str, Any]) -> dict[str, Any]:
    least, most = context.get("min_length"), context.get("max_length")
    allowed = f"at most {most}" if least is None else f"at least {least}"
    length = context["actual_length"]
    return {"what": "has the wrong length", "found": length, "allowed": allowed}


def _words(detail: ErrorDetails) -> dict[str, Any]:
    """Return rule, value and allowed values of an error of pydantic's own."""
    kind, given, context = detail["type"], detail["input"], detail.get("ctx") or {}
    if kind == "missing":
        return {"what": "is missing"}
    said: dict[str, Any] = {"found": _short(given)}
    if kind == "list_type" and isinstance(given, Mapping) and len(detail["loc"]) == 1:
        brackets = f"Write [[{detail['loc'][0]}]] in double brackets: there may be several"
        return {"what": "must be a list of tables", **said, "remedy": brackets}
    if kind in _TYPES:
        return {"what": f"must be {_TYPES[kind]}", **said}
    if kind == "literal_error":
        options = re.findall(r"'([^']*)'", str(context["expected"]))
        allowed = ", ".join(f'"{option}"' for option in options)
        remedy = suggest(given, options)
        return {"what": "unknown value", **said, "allowed": allowed, "remedy": remedy}
    if kind in ("greater_than", "greater_than_equal"):
        bound = context.get("gt", context.get("ge"))
        sign = ">" if "gt" in context else ">="
        return {"what": "is too small", **said, "allowed": f"{sign} {bound:g}"}
    if kind == "less_than_equal":
        return {"what": "is too large", **said, "allowed": f"<= {context['le']:g}"}
    if kind == "finite_number":
        return {"what": "must be finite", **said}
    if kind in ("too_short", "too_long"):
        return _wrong_length(context)
    if kind == "string_pattern_mismatch":
        return {"what": "is not a name", **said, "allowed": NAMES}
    return {"what": detail["msg"], **said}


def key_path(loc: Sequence[int | str], data: object, start: str = "") -> str:
    """Return the place of an error as a user would write it: ``contact[0].law.curve[1][0]``.

    Tags of unions, and keys that only a long form of the value would have, are left out.
    """
    path, here = start, data
    for part in loc:
        if isinstance(part, int):
            path += f"[{part}]"
            here = here[part] if isinstance(here, list) and part < len(here) else None
        elif not part.startswith("<") and (here is None or isinstance(here, Mapping)):
            path += f".{part}" if path else part
            here = here.get(part) if isinstance(here, Mapping) else None
    return path


def _inside(path: str, where: str | None) -> str:
    if not where:
        return path
    if not _KEY.match(where):
        return f"{path}: {where}" if path else where
    if path.endswith(where) and (len(path) == len(where) or path[-len(where) - 1] == "."):
        return path
    return f"{path}.{where}" if path else where


def _join(file: str, path: str) -> str | None:
    return ": ".join(part for part in (file, path) if part) or None


def _short(value: object) -> object:
    """Return `value`, or its kind if it is too long for a message."""
    if isinstance(value, Mapping):
        return f"a table with {', '.join(map(str, value))}"[:_MAX_CHARACTERS]
    if isinstance(value, list) and len(repr(value)) > _MAX_CHARACTERS:
        return f"a list of {len(value)}"
    if isinstance(value, int) and len(repr(value)) > _MAX_CHARACTERS:
        return f"a number of {len(repr(value))} digits"
    if isinstance(value, str) and len(value) > _MAX_CHARACTERS:
        return value[:_MAX_CHARACTERS] + "…"
    return value
