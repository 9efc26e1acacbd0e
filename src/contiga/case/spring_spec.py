"""The `spring` tables of a case: springs and dampers between bodies, or to the ground."""

from __future__ import annotations

from typing import Any

from contiga.case.curve_spec import ForceCurve, with_characteristics
from contiga.case.spec import MadeSpec, Name, NotNegative, Positive
from contiga.dynamics.springs import Spring


class SpringSpec(MadeSpec[Spring]):
    """A `[[spring]]`: `Spring`, with all its options."""

    makes = Spring
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

    def arguments(self) -> dict[str, Any]:
        """As `Spring` takes them."""
        return with_characteristics(super().arguments()) | {"name": self.name or ""}

    def describe(self) -> str:
        """Say it in words."""
        given = [
            f"{name} {curve.describe()}"
            for name, curve in (("curve", self.curve), ("unloading", self.unloading))
            if curve is not None
        ]
        given += [f"damping {self.damping:g}"] if self.damping else []
        given += [] if self.length is None else [f"length {self.length:g} at rest"]
        given += [] if self.filter is None else [self.filter]
        return f"between {' and '.join(self.between)}: {'; '.join(given)}"
