"""The `map` of a study: what is drawn over which part, and by what colours."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from contiga.case.spec import Spec
from contiga.errors import CaseError


class MapSpec(Spec):
    """`map`: a quantity as colours over a body, at the points that three variables say."""

    body: str
    at: Annotated[list[str], Field(min_length=3, max_length=3)]
    """Names of the variables x, y, z."""
    colour: str | None = None
    """The first quantity that is collected if omitted."""
    limits: Annotated[list[float], Field(min_length=2, max_length=2)] | None = None
    """Values the colours begin and end at."""
    bands: Annotated[list[float], Field(min_length=1, max_length=11)] | None = None
    """Values at which one colour gives way to the next, in place of `limits`."""
    between: Literal["linear", "nearest"] = "linear"
    """What is drawn between the points: linear between them, or the value of the nearest."""

    @model_validator(mode="after")
    def _colours_come_one_way(self) -> Self:
        if self.bands is not None and self.limits is not None:
            raise CaseError(
                "colours come by bands, or between limits", where="bands", allowed="one of the two"
            )
        for name in ("bands", "limits"):
            values = getattr(self, name) or []
            if any(not a < b for a, b in pairwise(values)):
                raise CaseError("must rise", where=name, found=values)
        return self
