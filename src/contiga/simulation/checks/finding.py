"""Define a finding: a property of a model that its author most likely did not intend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, NoReturn

from contiga.errors import InputError
from contiga.io.units import base_factor, derived_units


class Finding(NamedTuple):
    """A doubt about a model: the problem, its place, and a remedy.

    >>> print(Finding("apart", "contact pad-head", "never closer than 3 mm", "Move the pad"))
    contact pad-head: never closer than 3 mm. Move the pad
    """

    rule: str
    """Name of the rule, as in `docs/checks.md`."""
    where: str
    """Part of the model."""
    text: str
    """Description of the problem, with numbers."""
    remedy: str
    """Advice."""

    def __str__(self) -> str:
        return f"{self.where}: {self.text}. {self.remedy}"


def merged(of_model: tuple[Finding, ...], of_run: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """Return findings of the model, and those of its run whose rule and place are new."""
    places = {(finding.rule, finding.where) for finding in of_model}
    return of_model + tuple(new for new in of_run if (new.rule, new.where) not in places)


def raise_findings(findings: tuple[Finding, ...]) -> NoReturn:
    """Raise `InputError` with the first finding and the number of the others."""
    first, n_others = findings[0], len(findings) - 1
    suffix = f" ({n_others} more like this)" if n_others else ""
    raise InputError(f"{first.text}{suffix}", where=first.where, remedy=first.remedy)


class Quantities:
    """Format quantities for messages, with the names of their units if these are known.

    Parameters
    ----------
    units : names of length, mass and time; empty if unknown
    """

    def __init__(self, units: Sequence[str]) -> None:
        self.known = all(units)
        self._units = tuple(units)
        self._names = derived_units(*units) if self.known else {}

    def __call__(self, value: float, quantity: str = "length") -> str:
        """Return `value` with the unit of a `quantity` such as "length", "time" or "force"."""
        return f"{value:.4g} {self._name(quantity)}".rstrip()

    def si(self, length: int, mass: int, time: int) -> float:
        """Return the unit of these powers of base units in SI units; 1 if the units are unknown."""
        if not self.known:
            return 1.0
        factors = [
            base_factor(unit, of)
            for unit, of in zip(self._units, ("length", "mass", "time"), strict=True)
        ]
        return float(factors[0] ** length * factors[1] ** mass * factors[2] ** time)

    def unit(self, kind: str) -> str:
        """Return the name of a unit, or "units of" its quantity."""
        return self._name(kind) or f"units of {kind}"

    def _name(self, quantity: str) -> str:
        base_units = dict(zip(("length", "mass", "time"), self._units, strict=True))
        return base_units.get(quantity) or self._names.get(quantity, "")
