"""From a study to its cases: grids, lists, tables and samples, and the rules between variables."""

from __future__ import annotations

import itertools
import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.case.settings import with_settings
from contiga.errors import CaseError, FileError
from contiga.io.sheet import Sheet, read_sheet
from contiga.records import FloatArray
from contiga.studies.spec import SampleSpec, StudySpec, VariableSpec

MOST = 1_000_000
"""Cases of a study at most: more is a grid of the wrong kind."""
_HOLES = ("", "nan", "inf", "-inf", "+inf")


class StudyCase(NamedTuple):
    """One case of a study."""

    number: int
    """From 1 on."""
    values: dict[str, Any]
    """Of the variables, by what the table calls them."""
    settings: dict[str, Any]
    """Over the base case, by key."""

    @property
    def name(self) -> str:
        """Of its folder."""
        return f"{self.number:04d}"


def cases_of(
    study: StudySpec, targets: Sequence[Mapping[str, Any]] | None = None
) -> list[StudyCase]:
    """The cases of a study without a goal, in order: the last variable changes fastest.

    Rows of the table, or of `targets` by column, go slowest, samples fastest.

    Raises
    ------
    FileError
        The table cannot be read, lacks a column, or has a hole.
    CaseError
        A rule cannot be worked out or leaves nothing over; more cases than anybody runs.
    """
    ways: list[list[dict[str, Any]]] = []
    if study.table is not None:
        ways.append(_rows_of_table(study))
    if targets is not None:
        named = {v.label: v.column for v in study.variable if v.column is not None}
        ways.append([{label: row[column] for label, column in named.items()} for row in targets])
    ways += [
        [{variable.label: value} for value in listed_values(variable)]
        for variable in study.variable
        if variable.column is None and not variable.ranged
    ]
    if study.sample is not None:
        ways.append(_samples(study.sample, [v for v in study.variable if v.ranged]))
    count = int(np.prod([float(len(way)) for way in ways]))
    if count > MOST:
        raise CaseError(
            "too many cases",
            where=str(study.file),
            found=count,
            allowed=f"up to {MOST}",
            remedy="Sample the variables: low and high without count, and a [sample]",
        )
    kept = [
        {label: values[label] for label in study.labels}
        for values in map(_merged, itertools.product(*ways))
        if _fulfils(study, values)
    ]
    if not kept:
        raise CaseError(
            "no case fulfils the rules",
            where=f"{study.file}: rule",
            found=f"{count} left out",
            allowed="rules that leave a case over",
        )
    return [case_of(study, number, values) for number, values in enumerate(kept, start=1)]


def case_of(study: StudySpec, number: int, values: Mapping[str, Any]) -> StudyCase:
    """A case by the values of its variables: what is set for all, variables, then rules."""
    settings: dict[str, Any] = dict(study.set)
    for variable in study.variable:
        settings |= dict.fromkeys(variable.key, values[variable.label])
    for i, rule in enumerate(study.rule):
        if rule.value is not None:
            expression = rule.expression
            expression.where = f"{study.file}: rule[{i}].value"
            settings |= dict.fromkeys(rule.key, expression.value(values))
    return StudyCase(number, dict(values), settings)


def listed_values(variable: VariableSpec) -> list[Any]:
    """The values of a variable that has some of its own: a list, or evenly from low to high."""
    if variable.values is not None:
        return list(variable.values)
    assert variable.low is not None
    assert variable.high is not None
    assert variable.count is not None
    space = np.geomspace if variable.scale == "log" else np.linspace
    values = space(variable.low, variable.high, variable.count).tolist()
    return [round(value) for value in values] if variable.whole else values


def check_keys(study: StudySpec, base: Mapping[str, Any], settings: Mapping[str, Any]) -> None:
    """Refuse a key of the study that leads nowhere in its base case.

    Parameters
    ----------
    base : tables of the base case
    settings : of a case of the study

    Raises
    ------
    CaseError
        The message says whose key it is.
    """
    named = [("set", key) for key in study.set]
    named += [(f"variable {v.label!r}", key) for v in study.variable for key in v.key]
    named += [(f"rule[{i}]", key) for i, rule in enumerate(study.rule) for key in rule.key]
    seen: dict[str, str] = {}
    for where, key in named:
        if key in seen:
            raise CaseError(
                "two have this key of the case",
                where=f"{study.file}: {where}",
                found=key,
                allowed=f"one of them; the other is {seen[key]}",
            )
        seen[key] = where
    # What one sets another may go into: all together, one after the other.
    for i, (where, key) in enumerate(named):
        try:
            with_settings(base, {key: settings[key] for _, key in named[: i + 1]})
        except CaseError as error:
            raise CaseError(
                f"this key is none of the base case ({error.what})",
                where=f"{study.file}: {where}",
                found=key,
                allowed=error.allowed,
                remedy=error.remedy,
            ) from error


def _merged(parts: Sequence[dict[str, Any]]) -> dict[str, Any]:
    return {label: value for part in parts for label, value in part.items()}


def _fulfils(study: StudySpec, values: Mapping[str, Any]) -> bool:
    return all(rule.expression.value(values) for rule in study.rule if rule.require is not None)


def _samples(sample: SampleSpec, ranged: list[VariableSpec]) -> list[dict[str, Any]]:
    """Points in the box of the variables."""
    from scipy.stats import qmc

    if sample.kind == "sobol":
        with warnings.catch_warnings():  # the balance of counts that are no power of two
            warnings.simplefilter("ignore", UserWarning)
            unit = qmc.Sobol(len(ranged), rng=sample.seed).random(sample.count)
    else:
        unit = qmc.LatinHypercube(len(ranged), rng=sample.seed).random(sample.count)
    columns = [_scaled(v, unit[:, k]) for k, v in enumerate(ranged)]
    labels = [v.label for v in ranged]
    return [dict(zip(labels, row, strict=True)) for row in zip(*columns, strict=True)]


def _scaled(variable: VariableSpec, unit: FloatArray) -> list[float]:
    """Numbers of [0, 1) between the ends of a variable."""
    low, high = variable.low, variable.high
    assert low is not None
    assert high is not None
    values = low * (high / low) ** unit if variable.scale == "log" else low + (high - low) * unit
    return [round(value) for value in values] if variable.whole else list(map(float, values))


def _rows_of_table(study: StudySpec) -> list[dict[str, Any]]:
    """Rows of the table: values of those variables that are columns of it."""
    assert study.table is not None
    sheet = read_sheet(Path(study.table), "x, y, speed")
    sheet.check_header("x, y, speed")
    places = {v.label: _place(sheet, v.column) for v in study.variable if v.column is not None}
    if not sheet.rows:
        raise FileError("the table has no rows", where=study.table)
    return list(_cells(sheet, places))


def _place(sheet: Sheet, column: str) -> int:
    heads = [(name, sheet.head(k)[0]) for k, name in enumerate(sheet.names)]
    matching = [k for k, names in enumerate(heads) if column in names]
    if len(matching) != 1:
        raise FileError(
            f"the table has no column {column!r}" if not matching else f"{column!r} is there twice",
            where=f"{sheet.path}:{sheet.line}",
            found=", ".join(sheet.names),
        )
    return matching[0]


def _cells(sheet: Sheet, places: Mapping[str, int]) -> Iterator[dict[str, Any]]:
    for number, line in sheet.rows:
        cells = [cell.strip() for cell in line.split(sheet.mark)]
        holes = [k for k in places.values() if k >= len(cells) or cells[k].lower() in _HOLES]
        if len(cells) != len(sheet.names) or holes:
            raise FileError(
                "the table has a hole",
                where=f"{sheet.path}:{number}",
                found=line,
                allowed=f"a value in each of the {len(sheet.names)} columns",
            )
        yield {label: _value(cells[k]) for label, k in places.items()}


def _value(cell: str) -> Any:
    """A whole number, a number, or text."""
    for kind in (int, float):
        try:
            return kind(cell)
        except ValueError:
            continue
    return cell


def shown_value(value: Any) -> Any:
    """A value as a table shows it: numbers and text as they are, tables and lists as text."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return json.dumps(value, ensure_ascii=False)
    return value
