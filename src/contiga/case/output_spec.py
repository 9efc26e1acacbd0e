"""The output of a run: `[output]`."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from contiga.case.spec import Count, Positive, Spec
from contiga.errors import CaseError


class OutputSpec(Spec):
    """`[output]`."""

    every: Count = 1
    """Number of steps from one set of fields to the next; the history has all steps."""
    interval: Positive | None = None
    """Time from one set of fields to the next, in place of `every`."""
    formats: list[Literal["vtkhdf", "csv"]] = Field(default=["vtkhdf", "csv"])
    report: bool = True
    """Whether a report is written; it needs the history in format "csv"."""
    size: Positive | None = None
    """Longest side of the triangles that represent bodies in fields, length."""

    fields: list[Literal["stress", "von_mises", "strain", "principal_strain", "energy_density"]] = (
        Field(default=["stress", "von_mises", "strain", "principal_strain", "energy_density"])
    )
    """Fields of the inside of deforming slaves."""
    cells: bool = False
    """Whether facets also have the values of the elements behind them."""

    @model_validator(mode="after")
    def _by_steps_or_by_time(self) -> Self:
        if self.interval is not None and "every" in self.model_fields_set:
            raise CaseError(
                "is beside `every`", where="interval", allowed="one of them, steps or a time"
            )
        return self

    @model_validator(mode="after")
    def _report_has_its_history(self) -> Self:
        if self.report and "csv" not in self.formats:
            raise CaseError(
                'a report needs the format "csv"',
                where="formats",
                found=self.formats,
                remedy='Add "csv", or set report = false',
            )
        return self
