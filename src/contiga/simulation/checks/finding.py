"""Define a finding: something about a model that its author most likely did not mean."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, NoReturn

from contiga.errors import InputError
from contiga.io.units import base_factor, derived_units


class Finding(NamedTuple):
    """A doubt about a model: what looks wrong, where, and what to do.

    >>> print(Finding("apart", "contact pad-head", "never closer than 3 mm", "Move the pad"))
    contact pad-head: never closer than 3 mm. Move the pad
    """

    rule: str
    """What was looked at: a word of `docs/checks.md`."""
    where: str
    """Which part of the model."""
    text: str
    """What about it, with the numbers."""
    remedy: str
    """What to do."""

    def __str__(self) -> str:
        return f"{self.where}: {self.text}. {self.remedy}"


def together(told: tuple[Finding, ...], shown: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """Join findings of the model with those of its run that are new."""
    known = {(one.rule, one.where) for one in told}
    return told + tuple(one for one in shown if (one.rule, one.where) not in known)


def raise_findings(findings: tuple[Finding, ...]) -> NoReturn:
    """Refuse a model because of its first finding.

    Raises
    ------
    InputError
        Tells that one, and how many there are.
    """
    first, more = findings[0], len(findings) - 1
    also = f" ({more} more like this)" if more else ""
    raise InputError(f"{first.text}{also}", where=first.where, remedy=first.remedy)


class Said:
    """Quantities in the words of messages, with the names of their units where these are known.

    Parameters
    ----------
    units : names of length, mass and time; empty where not said
    """

    def __init__(self, units: Sequence[str]) -> None:
        self.known = all(units)
        self._units = tuple(units)
        self._names = derived_units(*units) if self.known else {}

    def __call__(self, value: float, quantity: str = "length") -> str:
        """Return `value` with its unit; `quantity` is "length", "time", "force" and so on."""
        return f"{value:.4g} {self._name(quantity)}".rstrip()

    def si(self, length: int, mass: int, time: int) -> float:
        """Return how many SI units one unit of these powers is; 1 where the units are not known."""
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
