"""`[settle]`: that a case comes to rest before it runs."""

from __future__ import annotations

from pydantic import Field

from contiga.case.spec import Count, MadeSpec, Name, Positive
from contiga.simulation.settle import Settle


class SettleSpec(MadeSpec[Settle]):
    """`[settle]`: `contiga.Settle`, with all its options."""

    makes = Settle
    tolerance: Positive = 1e-3
    """Unbalanced forces over loads at which it rests."""
    steps: Count = 20_000
    """Most that it may take."""
    bodies: list[Name] = Field(default_factory=list)
    """Free bodies that come to rest as well."""

    def describe(self) -> str:
        """Say it in words."""
        of = f", with {', '.join(self.bodies)}" if self.bodies else ""
        return f"to {self.tolerance:g} of the loads, in {self.steps} steps at most{of}"
