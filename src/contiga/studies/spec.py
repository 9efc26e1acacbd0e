"""The tables of the study file; reading and checking a study."""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, PrivateAttr, ValidationError, model_validator

from contiga.case.problems import case_error
from contiga.case.spec import ExistingFile, Spec, suggest
from contiga.errors import CaseError, FileError
from contiga.studies.expressions import Expression
from contiga.studies.map_spec import MapSpec
from contiga.studies.quantities import Quantity, quantity_of
from contiga.studies.targets import TargetsSpec

_LIMIT = re.compile(r"(.+?)\s*(<=|>=)\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)")
MAX_CASES = 1_000_000
"""Largest number of cases of a study: more is a mistaken grid."""
RESERVED = ("case", "status", "message")
"""Columns that every table has."""

Keys = Annotated[
    list[str], BeforeValidator(lambda value: [value] if isinstance(value, str) else value)
]
"""One key or several."""
CaseCount = Annotated[int, Field(ge=1, le=MAX_CASES)]
VariableName = Annotated[str, Field(pattern=r"^[A-Za-z_]\w*$")]


class VariableSpec(Spec):
    """A `[[variable]]`: a value that differs from case to case."""

    name: VariableName | None = None
    """Name in rules and columns; its key if omitted."""
    key: Keys = Field(default_factory=list)
    """Keys of the case, as `--set` takes them, that have its value."""
    values: Annotated[list[Any], Field(min_length=1)] | None = None
    column: str | None = None
    """Column in the table of the study."""
    low: float | None = None
    high: float | None = None
    count: Annotated[int, Field(ge=2, le=MAX_CASES)] | None = None
    """Number of values from `low` to `high`; without it they are sampled or optimised."""
    scale: Literal["linear", "log"] = "linear"
    whole: bool = False
    """Whether values between `low` and `high` are rounded to whole numbers."""
    refines: bool = False
    """Whether its values are meshes from coarse to fine: the page shows the convergence."""
    unit: str = ""
    """Unit for labels."""

    @property
    def label(self) -> str:
        """Its label in the table: its name, or its first key."""
        return self.name if self.name is not None else self.key[0]

    @property
    def ranged(self) -> bool:
        """Whether it may be any value between `low` and `high`, because no `count` is given."""
        return self.low is not None and self.count is None

    @model_validator(mode="after")
    def _values_come_one_way(self) -> Self:
        """Check that a key or a name is given, and one consistent source of values."""
        if not self.key and self.name is None:
            raise CaseError("is missing: a variable has a key of the case, or a name", where="key")
        has_source = {
            "values": self.values is not None,
            "column": self.column is not None,
            "low and high": self.low is not None or self.high is not None,
        }
        sources = [source for source in has_source if has_source[source]]
        if len(sources) != 1:
            raise CaseError(
                "its values come exactly one way",
                where=self.label,
                found=", ".join(sources) or "none",
                allowed="values = […], column = …, or low = …, high = … (and count = …)",
            )
        if sources != ["low and high"]:
            if self.count is not None or self.whole or self.scale != "linear":
                raise CaseError(
                    "count, scale and whole are for low and high",
                    where=self.label,
                    found=sources[0],
                )
            return self
        if self.low is None or self.high is None or not self.low < self.high:
            raise CaseError(
                "must go from low to high",
                where=self.label,
                found=f"low = {self.low}, high = {self.high}",
            )
        if self.scale == "log" and self.low <= 0.0:
            raise CaseError(
                "a logarithmic scale begins above zero",
                where=f"{self.label}: low",
                found=self.low,
                allowed="> 0",
            )
        return self


class SampleSpec(Spec):
    """`[sample]`: points in the box of all variables that have `low` and `high` and no count."""

    kind: Literal["latin-hypercube", "sobol"]
    count: CaseCount
    """Number of points; for Sobol's points a power of two is best."""
    seed: Annotated[int, Field(ge=0)] = 0


class RuleSpec(Spec):
    """A `[[rule]]`: a key that depends on variables, or a condition on them."""

    key: Keys = Field(default_factory=list)
    value: str | None = None
    """An expression of variables."""
    require: str | None = None
    """A comparison: cases that do not fulfil it are left out."""

    @model_validator(mode="after")
    def _is_one_of_two(self) -> Self:
        """Check that the rule has key and value, or a requirement alone, and that it parses."""
        if (self.value is None) == (self.require is None) or bool(self.key) != bool(self.value):
            raise CaseError(
                "a rule sets a key, or requires something",
                found=", ".join(sorted(self.model_fields_set)) or "nothing",
                allowed='key = "…", value = "…", or require = "…"',
            )
        assert self.expression is not None
        return self

    @property
    def expression(self) -> Expression:
        """The expression of `value` or `require`, parsed anew; a bad one raises a CaseError."""
        text = self.value if self.value is not None else self.require
        assert text is not None
        return Expression(text, "value" if self.require is None else "require")


class Limit(Spec):
    """A condition of `subject_to`: a quantity that must stay on one side of a number."""

    quantity: str
    is_upper: bool
    """Whether the number is an upper bound, or a lower one."""
    bound: float

    def excess(self, value: float) -> float:
        """Return the excess of a value over the bound; zero or less is within."""
        return value - self.bound if self.is_upper else self.bound - value


class GoalSpec(Spec):
    """`goal`: a quantity that Optuna makes small or large."""

    minimise: str | None = None
    maximise: str | None = None
    subject_to: list[str] = Field(default_factory=list)
    """Conditions ``quantity <= number`` or ``>=``."""
    trials: CaseCount = 50
    batch: CaseCount = 4
    """Number of cases chosen and run at once; the next depend on all before them."""
    seed: Annotated[int, Field(ge=0)] = 0

    @model_validator(mode="after")
    def _goal_is_one(self) -> Self:
        """Check that one quantity is minimised or maximised, and that the limits parse."""
        if (self.minimise is None) == (self.maximise is None):
            raise CaseError(
                "a goal is one quantity", allowed="minimise = …, or maximise = …, one of them"
            )
        assert self.limits is not None
        return self

    @property
    def quantity(self) -> str:
        """The quantity to be made small or large."""
        text = self.minimise if self.minimise is not None else self.maximise
        assert text is not None
        return text

    @property
    def limits(self) -> list[Limit]:
        """The parsed `subject_to`; a text that is no limit raises a CaseError."""
        limits = []
        for text in self.subject_to:
            match = _LIMIT.fullmatch(text.strip())
            if match is None:
                raise CaseError(
                    "is not a limit",
                    where="subject_to",
                    found=text,
                    allowed='such as "max(max_penetration) <= 45"',
                )
            quantity, sign, bound = match.groups()
            limits.append(Limit(quantity=quantity, is_upper=sign == "<=", bound=float(bound)))
        return limits


class StudySpec(Spec):
    """A whole study file. Its file names are absolute."""

    title: str = "Study"
    base: ExistingFile | None = None
    """The base case; in Python it may be given as a case."""
    set: dict[str, Any] = Field(default_factory=dict)
    """Settings of all cases that override the base case, by key."""
    table: ExistingFile | None = None
    """CSV file with a header and a row for each case."""
    targets: TargetsSpec | None = None
    """Points on a body, a row for each case, in place of a table."""
    variable: Annotated[list[VariableSpec], Field(min_length=1)]
    sample: SampleSpec | None = None
    rule: list[RuleSpec] = Field(default_factory=list)
    collect: (
        Annotated[list[str], Field(min_length=1)] | Annotated[dict[str, str], Field(min_length=1)]
    )
    """Quantities collected from each case: a list, or a table by the names of their columns."""
    goal: GoalSpec | None = None
    map: MapSpec | None = None
    retries: Annotated[int, Field(ge=0)] = 3
    """Number of restarts of a case whose worker was lost."""

    _file: Path = PrivateAttr(default=Path("study.toml"))

    @property
    def file(self) -> Path:
        """The file of the study."""
        return self._file

    @property
    def labels(self) -> list[str]:
        """The labels of the variables in the table."""
        return [variable.label for variable in self.variable]

    @property
    def quantities(self) -> dict[str, Quantity]:
        """The quantities collected from each case, by column, with those of the goal after them."""
        named = self.collect if isinstance(self.collect, dict) else {q: q for q in self.collect}
        quantities = {name: quantity_of(text) for name, text in named.items()}
        if self.goal is not None:
            for text in (self.goal.quantity, *(limit.quantity for limit in self.goal.limits)):
                if text not in quantities:
                    quantities[text] = quantity_of(text)
        return quantities

    @model_validator(mode="after")
    def _column_names_are_unique(self) -> Self:
        """Check that labels, quantities and the `RESERVED` columns all have different names."""
        names = [*RESERVED, *self.labels, *self.quantities]
        for name, count in Counter(names).items():
            if count > 1:
                raise CaseError(
                    "two columns of the table have this name",
                    where="variable" if name in self.labels else "collect",
                    found=name,
                    allowed=f"each name once; {', '.join(RESERVED)} are taken",
                )
        return self

    @model_validator(mode="after")
    def _variables_have_their_values(self) -> Self:
        """Check that columns have a table or targets, and ranged variables a sample or a goal."""
        columns = {v.label: v.column for v in self.variable if v.column is not None}
        if self.table is not None and self.targets is not None:
            raise CaseError("are in place of a table", where="targets", allowed="one of the two")
        if columns and self.table is None and self.targets is None:
            raise CaseError("is missing: a variable is a column of it", where="table")
        if self.table is not None and not columns:
            raise CaseError("no variable is a column of the table", where="table", found=self.table)
        if self.targets is not None:
            self.targets.check_columns(columns)
        ranged = [v.label for v in self.variable if v.ranged]
        if self.goal is None and bool(ranged) != (self.sample is not None):
            raise CaseError(
                "variables with low and high and no count are sampled",
                where=ranged[0] if ranged else "sample",
                allowed='count = …, or sample = { kind = "latin-hypercube", count = … }'
                if ranged
                else "a variable with low and high",
            )
        return self

    @model_validator(mode="after")
    def _an_optimiser_chooses_the_cases(self) -> Self:
        """Check that a goal comes without sample, columns and required conditions."""
        if self.goal is None:
            return self
        column = next((v.label for v in self.variable if v.column is not None), None)
        if self.sample is not None or column is not None:
            raise CaseError(
                "an optimiser chooses the cases: there is no sample and no table beside it",
                where="goal",
                found="sample" if column is None else column,
                allowed="variables with values = […], or with low = …, high = …",
            )
        for rule in self.rule:
            if rule.require is not None:
                raise CaseError(
                    "an optimiser chooses the cases: none can be left out",
                    where="rule.require",
                    found=rule.require,
                    allowed="subject_to of the goal",
                )
        return self

    @model_validator(mode="after")
    def _names_are_those_of_variables(self) -> Self:
        """Check that rules and map name variables and columns, and that each variable is used."""
        names = [v.name for v in self.variable if v.name is not None]
        for i, rule in enumerate(self.rule):
            expression = rule.expression
            expression.where = f"rule[{i}].{expression.where}"
            expression.check_names(names)
        used = {name for rule in self.rule for name in rule.expression.names}
        used |= set(self.map.at) if self.map is not None else set()
        for variable in self.variable:
            if not variable.key and variable.name not in used:
                raise CaseError(
                    "no key and no rule uses this variable",
                    where="variable",
                    found=variable.name,
                    allowed="a key of the case, or a rule with its name",
                )
        if self.map is not None:
            references = [("at", name, self.labels) for name in self.map.at]
            if self.map.colour is not None:
                references.append(("colour", self.map.colour, list(self.quantities)))
            for key, name, allowed in references:
                if name not in allowed:
                    raise CaseError(
                        "is not known",
                        where=f"map.{key}",
                        found=name,
                        allowed=", ".join(allowed),
                        remedy=suggest(name, allowed),
                    )
        return self


def study_of(data: Mapping[str, Any], file: Path) -> StudySpec:
    """Check the tables of a study file and return the study; file names start from its folder.

    Raises
    ------
    CaseError, FileError
        A key or value is wrong, or a file is missing: the message says the key, what was found and
        what is allowed.
    """
    try:
        study = StudySpec.model_validate(dict(data), context={"folder": file.parent})
    except ValidationError as error:
        raise case_error(error, data, str(file)) from error
    study._file = file
    return study


def load_study(path: str | Path) -> StudySpec:
    """Read and check a study file.

    Raises
    ------
    FileError
        The file is missing or cannot be read, or one it names is not there.
    CaseError
        It is not TOML, is a case, names no base case, or has a wrong key or value.
    """
    path = Path(path)
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError as error:
        raise FileError("no such file", where=str(path), allowed="a study file (TOML)") from error
    except OSError as error:
        raise FileError(f"cannot be read ({error.strerror})", where=str(path)) from error
    except (ValueError, RecursionError) as error:
        raise CaseError(f"is not valid TOML: {error}", where=str(path)) from error
    if "contact" in data and "variable" not in data:
        raise CaseError(
            "is a case, not a study",
            where=str(path),
            allowed=f'a file with base = "{path.name}" and what varies in it',
            remedy="One case is run by: contiga run",
        )
    study = study_of(data, path)
    if study.base is None:
        raise CaseError("is missing", where=f"{path}: base", allowed="the file of the base case")
    return study
