"""The `load` tables of a case: forces and moments on bodies."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, model_validator

from contiga.case.spec import Spec, Vector
from contiga.dynamics.loads import Load
from contiga.errors import CaseError


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _vector_or_rows(value: Any) -> Any:
    # One message where a union of types would give one for each.
    rows = value if isinstance(value, list) else [None]
    if all(map(_is_number, rows)):
        return value
    if all(isinstance(row, list) and all(map(_is_number, row)) for row in rows):
        return value
    raise CaseError(
        "must be a vector, or rows over time",
        found=value,
        allowed="[x, y, z] or [[t, x, y, z], …]",
    )


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
