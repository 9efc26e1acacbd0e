"""Materials of an LS-DYNA deck whose parts deform in a case as they do there.

Card layouts: LS-DYNA Keyword User's Manual, volume II.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

BLATZ_KO = 0.463
"""Poisson's ratio of *MAT_BLATZ-KO_RUBBER."""


class SoftLaw(NamedTuple):
    """A material of a case, `contiga.materials`."""

    table: dict[str, Any]
    """Of `material`, but for the curve of a foam."""
    modulus: float
    """Young's."""
    poisson: float
    note: str = ""
    """What of the card it is not."""
    curve: int = 0
    """Number of the one that a foam is loaded by."""


class SoftCards(NamedTuple):
    """How a material is read."""

    first: int
    """Fields of the first card, from the modulus on."""
    second: int
    """Fields of the second."""
    law: Callable[..., SoftLaw | None]
    """Asked with all of them; None where they make none."""


def _elastic(modulus: float, poisson: float) -> SoftLaw | None:
    table = {"kind": "elastic", "young": modulus, "poisson": poisson}
    return SoftLaw(table, modulus, poisson) if modulus > 0.0 else None


def _neo_hooke(shear: float, poisson: float, note: str) -> SoftLaw | None:
    if shear <= 0.0 or not 0.0 <= poisson < 0.5:
        return None
    young = 2.0 * shear * (1.0 + poisson)
    table = {"kind": "neo-hooke", "young": young, "poisson": poisson, "volume": "nodes"}
    return SoftLaw(table, young, poisson, note)


def _blatz_ko(shear: float) -> SoftLaw | None:
    return _neo_hooke(shear, BLATZ_KO, "neo-Hooke of its shear modulus")


def _mooney_rivlin(poisson: float, a: float, b: float) -> SoftLaw | None:
    return _neo_hooke(2.0 * (a + b), poisson, f"neo-Hooke of 2 (A + B), B is {b:g}" if b else "")


def _foam(
    modulus: float, curve: float, _cutoff: float, returned: float, shape: float
) -> SoftLaw | None:
    if modulus <= 0.0 or curve <= 0.0:
        return None
    table = {
        "kind": "foam",
        "hysteresis": returned or 1.0,
        "shape": shape or 1.0,
        "tension": modulus,
    }
    return SoftLaw(table, modulus, 0.0, curve=int(curve))


SOFT: dict[str, SoftCards] = {
    name: cards
    for names, cards in (
        (("ELASTIC", "001"), SoftCards(2, 0, _elastic)),
        (("BLATZ-KO_RUBBER", "007"), SoftCards(1, 0, _blatz_ko)),
        (("MOONEY-RIVLIN_RUBBER", "027"), SoftCards(3, 0, _mooney_rivlin)),
        (("LOW_DENSITY_FOAM", "057"), SoftCards(4, 1, _foam)),
    )
    for name in names
}
"""By the end of the keyword, *MAT_…."""
