"""The `load` tables of a case: forces and moments on bodies."""

from __future__ import annotations

import sys
from typing import Annotated, Any

from pydantic import BeforeValidator

from contiga.case.spec import InstanceSpec, Vector, is_number
from contiga.dynamics.loads import Load
from contiga.errors import CaseError


def _vector_or_rows(value: Any) -> Any:
    """Return `value`; CaseError unless it is a list of finite numbers, or of rows of such.

    Lengths are not checked.
    """
    # A union of types would give a message for each type.
    rows = value if isinstance(value, list) else [None]
    if not (all(map(is_number, rows)) or all(isinstance(row, list) for row in rows)):
        raise CaseError(
            "must be a vector, or rows over time",
            found=value,
            allowed="[x, y, z] or [[t, x, y, z], …]",
        )
    for k, row in enumerate(rows):
        for number in row if isinstance(row, list) else [row]:
            if not (is_number(number) and -sys.float_info.max <= number <= sys.float_info.max):
                raise CaseError(f"must be finite numbers, and entry {k} is not", found=row)
    return value


OverTime = Annotated[list[float] | list[list[float]], BeforeValidator(_vector_or_rows)]


class LoadSpec(InstanceSpec[Load]):
    """A `[[load]]`: `Load`, with all its options."""

    makes = Load
    body: str
    force: OverTime | None = None
    moment: OverTime | None = None
    at: Vector | None = None
    follow: bool = False
    smooth: bool = False

    def describe(self) -> str:
        """Describe the table in words."""
        loads = []
        for name, value in (("force", self.force), ("moment", self.moment)):
            if value is not None:
                rows = [row for row in value if isinstance(row, list)]
                loads.append(f"{name} {f'of {len(rows)} rows over time' if rows else value}")
        at = "" if self.at is None else f" at {self.at}"
        turning = ", turning with it" if self.follow else ""
        return f"{' and '.join(loads)} on {self.body}{at}{turning}"
