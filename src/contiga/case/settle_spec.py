"""`[settle]`: that a case comes to rest before it runs."""

from __future__ import annotations

from functools import cached_property

from pydantic import Field

from contiga.case.spec import Count, Name, Positive, Spec
from contiga.simulation.settle import Settle


class SettleSpec(Spec):
    """`[settle]`: `contiga.Settle`, with all its options."""

    tolerance: Positive = 1e-3
    """Unbalanced forces over loads at which it rests."""
    steps: Count = 20_000
    """Most that it may take."""
    bodies: list[Name] = Field(default_factory=list)
    """Free bodies that come to rest as well."""

    @cached_property
    def settle(self) -> Settle:
        """How it comes to rest."""
        return Settle(tolerance=self.tolerance, steps=self.steps, bodies=self.bodies)

    def describe(self) -> str:
        """In words."""
        of = f", with {', '.join(self.bodies)}" if self.bodies else ""
        return f"to {self.tolerance:g} of the loads, in {self.steps} steps at most{of}"
