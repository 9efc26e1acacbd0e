"""From a study to its cases: grids, lists, tables and samples, and the rules between variables."""

from __future__ import annotations

import itertools
import json
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.case.settings import table_of_key, with_settings
from contiga.errors import CaseError, FileError, UnitError
from contiga.io.sheet import Row, Sheet, as_number, read_sheet
from contiga.io.units import consistent_factor
from contiga.studies.spec import MAX_CASES, SampleSpec, StudySpec, VariableSpec

_UNIT_KEYS = ("unit", "units", "time_unit")
"""Keys of tables of a case whose numbers are in units of their own."""
_EMPTY_CELLS = ("", "nan", "inf", "-inf", "+inf")


class StudyCase(NamedTuple):
    """One case of a study."""

    number: int
    """Number of the case, from 1."""
    values: dict[str, Any]
    """Values of the variables, by their labels in the table."""
    settings: dict[str, Any]
    """Settings that override the base case, by key."""

    @property
    def name(self) -> str:
        """The name of its folder."""
        return f"{self.number:04d}"


def cases_of(
    study: StudySpec,
    targets: Sequence[Mapping[str, Any]] | None = None,
    base: Mapping[str, Any] | None = None,
) -> list[StudyCase]:
    """Return the cases of a study without a goal, in order: the last variable changes fastest.

    Rows of the table, or of `targets` by column, change slowest, samples fastest. Combinations that
    a rule's `require` refuses are left out, and the others are numbered from 1. Columns of the
    table with a unit in their head are converted to the units of the `base` case, given by its
    tables; without such columns `base` may be None.

    Raises
    ------
    FileError
        The table cannot be read, lacks a column or a value, or has no rows.
    UnitError
        The head of a column has a unit that cannot be converted, or has one although the numbers
        of its key have a unit of their own in the case, or another one than the variable's `unit`.
    CaseError
        A rule cannot be worked out or leaves no case over; more than `MAX_CASES` combinations.
    """
    axes: list[list[dict[str, Any]]] = []
    if study.table is not None:
        axes.append(_rows_of_table(study, base or {}))
    if targets is not None:
        columns = {v.label: v.column for v in study.variable if v.column is not None}
        axes.append([{label: row[column] for label, column in columns.items()} for row in targets])
    axes += [
        [{variable.label: value} for value in listed_values(variable)]
        for variable in study.variable
        if variable.column is None and not variable.ranged
    ]
    if study.sample is not None:
        axes.append(_samples(study.sample, [v for v in study.variable if v.ranged]))
    count = int(np.prod([float(len(axis)) for axis in axes]))
    if count > MAX_CASES:
        raise CaseError(
            "too many cases",
            where=str(study.file),
            found=count,
            allowed=f"up to {MAX_CASES}",
            remedy="Sample the variables: low and high without count, and a [sample]",
        )
    cases = []
    for parts in itertools.product(*axes):
        values = {label: value for part in parts for label, value in part.items()}
        if all(rule.expression.value(values) for rule in study.rule if rule.require is not None):
            cases.append({label: values[label] for label in study.labels})
    if not cases:
        raise CaseError(
            "no case fulfils the rules",
            where=f"{study.file}: rule",
            found=f"{count} left out",
            allowed="rules that leave a case over",
        )
    return [case_of(study, number, values) for number, values in enumerate(cases, start=1)]


def case_of(study: StudySpec, number: int, values: Mapping[str, Any]) -> StudyCase:
    """Return a case from the values of its variables: common settings, variables, then rules.

    Later settings of a key replace earlier ones. A rule that cannot be worked out raises a
    CaseError.
    """
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
    """Return the values of a variable with `values` or `count`: the list, or from low to high.

    `count` values are equally spaced, or in equal ratios on a logarithmic scale; `whole` ones are
    rounded, so that some may be equal.
    """
    if variable.values is not None:
        return list(variable.values)
    assert variable.low is not None
    assert variable.high is not None
    assert variable.count is not None
    space = np.geomspace if variable.scale == "log" else np.linspace
    values = space(variable.low, variable.high, variable.count).tolist()
    return [round(value) for value in values] if variable.whole else values


def check_keys(study: StudySpec, base: Mapping[str, Any], settings: Mapping[str, Any]) -> None:
    """Refuse a key of the study that its base case does not have, or that is set twice.

    Parameters
    ----------
    study : the specification of the study
    base : tables of the base case
    settings : settings of any case of the study, by key

    Raises
    ------
    CaseError
        The message names the key, and whether a variable, a rule or `set` has it.
    """
    keys = [("set", key) for key in study.set]
    keys += [(f"variable {v.label!r}", key) for v in study.variable for key in v.key]
    keys += [(f"rule[{i}]", key) for i, rule in enumerate(study.rule) for key in rule.key]
    owners: dict[str, str] = {}
    for owner, key in keys:
        if key in owners:
            raise CaseError(
                "two entries set this key of the case",
                where=f"{study.file}: {owner}",
                found=key,
                allowed=f"one of them; the other is {owners[key]}",
            )
        owners[key] = owner
    # One setting may refer to a table that another sets: they are applied in turn.
    for i, (owner, key) in enumerate(keys):
        try:
            with_settings(base, {key: settings[key] for _, key in keys[: i + 1]})
        except CaseError as error:
            raise CaseError(
                f"the base case has no such key ({error.what})",
                where=f"{study.file}: {owner}",
                found=key,
                allowed=error.allowed,
                remedy=error.remedy,
            ) from error


def _samples(sample: SampleSpec, ranged: list[VariableSpec]) -> list[dict[str, Any]]:
    """Return values of the variables for each sample, by label; one seed gives the same samples."""
    from scipy.stats import qmc

    if sample.kind == "sobol":
        with warnings.catch_warnings():  # scipy warns of counts that are no power of two
            warnings.simplefilter("ignore", UserWarning)
            unit = qmc.Sobol(len(ranged), rng=sample.seed).random(sample.count)
    else:
        unit = qmc.LatinHypercube(len(ranged), rng=sample.seed).random(sample.count)
    columns: dict[str, list[float]] = {}
    for k, variable in enumerate(ranged):
        low, high, share = variable.low, variable.high, unit[:, k]
        assert low is not None
        assert high is not None
        if variable.scale == "log":
            values = low * (high / low) ** share
        else:
            values = low + (high - low) * share
        columns[variable.label] = [round(v) if variable.whole else float(v) for v in values]
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _rows_of_table(study: StudySpec, base: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of the table: the values of the variables that are columns of it, by label.

    A column with a unit in its head is converted to the units of the case. A UnitError is raised
    if the numbers of the variable's key have a unit of their own in the case, or if the label has
    another unit than the case; a FileError without rows, or at a missing value.
    """
    assert study.table is not None
    sheet = read_sheet(Path(study.table), "x, y, speed")
    sheet.check_header("x, y, speed")
    case = with_settings(base, {k: v for k, v in study.set.items() if k.startswith("units")})
    variables = [(v, sheet.column(v.column)) for v in study.variable if v.column is not None]
    columns: dict[str, tuple[int, float | None]] = {}
    for variable, column in variables:
        unit, where = sheet.unit(column), f"{sheet.where}: {sheet.heads[column].text}"
        columns[variable.label] = column, None
        if unit is None:
            continue
        unit_keys = [
            name for key in variable.key for name in _UNIT_KEYS if name in table_of_key(case, key)
        ]
        if unit_keys:
            raise UnitError(
                f"the numbers of this variable's key are in the {unit_keys[0]} that stands beside "
                "it",
                where=where,
                found=unit,
                allowed=f"no unit in the header, and numbers as {unit_keys[0]} says",
            )
        length, mass, time = (str(case["units"][name]) for name in ("length", "mass", "time"))
        if (
            variable.unit
            and consistent_factor(variable.unit, length, mass, time, variable.label) != 1.0
        ):
            raise UnitError(
                "a column with a unit is converted to the units of the case: its label must be one",
                where=f"{variable.label}: unit",
                found=variable.unit,
                allowed="none, or that of the case",
            )
        columns[variable.label] = column, consistent_factor(unit, length, mass, time, where)
    rows = [
        {label: _cell_value(sheet, row, *column) for label, column in columns.items()}
        for row in sheet.rows
    ]
    if not rows:
        raise FileError("the table has no rows", where=study.table)
    return rows


def _cell_value(sheet: Sheet, row: Row, column: int, factor: float | None) -> Any:
    """Return a cell: an integer, a number, or text; with a `factor`, a number times it.

    Raises
    ------
    FileError
        The row is short, the cell is empty or not finite, or it is text in a column with a factor.
    """
    where, text = f"{sheet.path}:{row.line}", sheet.mark.join(row.cells)
    if len(row.cells) < len(sheet.heads) or row.cells[column].lower() in _EMPTY_CELLS:
        raise FileError(
            "a value of the table is missing",
            where=where,
            found=text,
            allowed=f"a value in each of the {len(sheet.heads)} columns",
        )
    cell = row.cells[column]
    try:
        number = as_number(cell, sheet.mark)
    except ValueError:
        if factor is None:
            return cell
        raise FileError(
            "a text in a column with a unit", where=where, found=text, allowed="numbers"
        ) from None
    if factor not in (None, 1.0):
        return number * factor
    return int(cell) if cell.lstrip("+-").isdecimal() else number


def shown_value(value: Any) -> Any:
    """Return a value as a table shows it: numbers and text unchanged, all others as JSON."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return json.dumps(value, ensure_ascii=False)
    return value
