"""The `map` of a study: its quantity, its part, and its colours."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from contiga.case.spec import Spec
from contiga.errors import CaseError


class MapSpec(Spec):
    """`map`: a quantity as colours over a body, at points given by three variables."""

    body: str
    at: Annotated[list[str], Field(min_length=3, max_length=3)]
    """Names of the variables x, y, z."""
    colour: str | None = None
    """Column that is shown; the first collected quantity if omitted."""
    limits: Annotated[list[float], Field(min_length=2, max_length=2)] | None = None
    """Values at which the colours begin and end."""
    bands: Annotated[list[float], Field(min_length=1, max_length=11)] | None = None
    """Values at which one colour ends and the next begins, in place of `limits`."""
    between: Literal["linear", "nearest"] = "linear"
    """Interpolation between the points: linear, or the value of the nearest."""

    @model_validator(mode="after")
    def _colours_come_one_way(self) -> Self:
        """Check that bands and limits are not both given, and rise."""
        if self.bands is not None and self.limits is not None:
            raise CaseError(
                "colours come by bands, or between limits", where="bands", allowed="one of the two"
            )
        for name in ("bands", "limits"):
            values = getattr(self, name) or []
            if any(not a < b for a, b in pairwise(values)):
                raise CaseError("must rise", where=name, found=values)
        return self
