"""`[settle]`: bring a case to rest before it runs."""

from __future__ import annotations

from pydantic import Field

from contiga.case.spec import Count, InstanceSpec, Name, Positive
from contiga.simulation.settle import Settle


class SettleSpec(InstanceSpec[Settle]):
    """`[settle]`: `contiga.Settle`, with all its options."""

    makes = Settle
    tolerance: Positive = 1e-3
    """Unbalanced forces over loads, below which it is at rest."""
    steps: Count = 20_000
    """Largest number of steps."""
    bodies: list[Name] = Field(default_factory=list)
    """Free bodies that are brought to rest too."""

    def describe(self) -> str:
        """Describe the table in words."""
        of = f", with {', '.join(self.bodies)}" if self.bodies else ""
        return f"to {self.tolerance:g} of the loads, in {self.steps} steps at most{of}"
