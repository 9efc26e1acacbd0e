"""The `load` tables of a case: forces and moments on bodies."""

from __future__ import annotations

import sys
from functools import cached_property
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, model_validator

from contiga.case.spec import Spec, Vector
from contiga.dynamics.loads import Load
from contiga.errors import CaseError


def _vector_or_rows(value: Any) -> Any:
    # One message where a union of types would give one for each.
    rows = value if isinstance(value, list) else [None]
    if not (all(map(_is_number, rows)) or all(isinstance(row, list) for row in rows)):
        raise CaseError(
            "must be a vector, or rows over time",
            found=value,
            allowed="[x, y, z] or [[t, x, y, z], …]",
        )
    for k, row in enumerate(rows):
        for number in row if isinstance(row, list) else [row]:
            if not (_is_number(number) and -sys.float_info.max <= number <= sys.float_info.max):
                raise CaseError(f"must be finite numbers, and entry {k} is not", found=row)
    return value


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


OverTime = Annotated[list[float] | list[list[float]], BeforeValidator(_vector_or_rows)]


class LoadSpec(Spec):
    """A `[[load]]`: `Load`, with all its options."""

    body: str
    force: OverTime | None = None
    moment: OverTime | None = None
    at: Vector | None = None
    follow: bool = False
    smooth: bool = False

    @cached_property
    def load(self) -> Load:
        """The load."""
        return Load(
            self.body,
            force=self.force,
            moment=self.moment,
            at=self.at,
            follow=self.follow,
            smooth=self.smooth,
        )

    @model_validator(mode="after")
    def _load_is_possible(self) -> Self:
        assert self.load is not None
        return self

    def describe(self) -> str:
        """In words."""
        given = []
        for name, value in (("force", self.force), ("moment", self.moment)):
            if value is not None:
                rows = [row for row in value if isinstance(row, list)]
                given.append(f"{name} {f'of {len(rows)} rows over time' if rows else value}")
        at = "" if self.at is None else f" at {self.at}"
        turning = ", turning with it" if self.follow else ""
        return f"{' and '.join(given)} on {self.body}{at}{turning}"
