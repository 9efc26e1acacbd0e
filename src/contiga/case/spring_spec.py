"""The `spring` tables of a case: springs and dampers between bodies, or to the ground."""

from __future__ import annotations

from functools import cached_property
from typing import Self

from pydantic import model_validator

from contiga.case.curve_spec import ForceCurve, if_given
from contiga.case.spec import Name, NotNegative, Positive, Spec
from contiga.dynamics.springs import Spring


class SpringSpec(Spec):
    """A `[[spring]]`: `Spring`, with all its options."""

    name: Name | None = None
    """How results call it; "<first>-<second>" if omitted."""
    between: list[str]
    at: list[list[float]]
    curve: ForceCurve | None = None
    """Force over elongation, tension positive."""
    unloading: ForceCurve | None = None
    hysteresis_slope: Positive | None = None
    damping: NotNegative = 0.0
    length: NotNegative | None = None
    """At rest; the distance of the points at the start if omitted."""
    filter: str | None = None
    """Of the force that results tell."""

    @cached_property
    def spring(self) -> Spring:
        """The spring."""
        return Spring(
            self.between,
            at=self.at,
            curve=if_given(self.curve, "curve"),
            unloading=if_given(self.unloading, "unloading"),
            hysteresis_slope=self.hysteresis_slope,
            damping=self.damping,
            length=self.length,
            name=self.name or "",
            filter=self.filter,
        )

    @model_validator(mode="after")
    def _spring_is_possible(self) -> Self:
        assert self.spring is not None
        return self

    def describe(self) -> str:
        """In words."""
        given = [
            f"{name} {curve.describe()}"
            for name, curve in (("curve", self.curve), ("unloading", self.unloading))
            if curve is not None
        ]
        given += [f"damping {self.damping:g}"] if self.damping else []
        given += [] if self.length is None else [f"length {self.length:g} at rest"]
        given += [] if self.filter is None else [self.filter]
        return f"between {' and '.join(self.between)}: {'; '.join(given)}"
