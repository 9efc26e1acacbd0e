"""Materials of an LS-DYNA deck whose parts deform in a case as they do there.

Card layouts: LS-DYNA Keyword User's Manual, volume II.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

BLATZ_KO = 0.463
"""Poisson's ratio of *MAT_BLATZ-KO_RUBBER."""
_ALONG_A_VECTOR = 2.0
"""AOPT of material axes that are one vector for all elements."""
_BY_CURVES = (4.0, 14.0)
"""FORM of fabrics by curves of second Piola-Kirchhoff stress over Green's strain."""
_OTHER_CURVES = (4.0, 13.0, 14.0, 24.0)
"""Size of a FORM that has curves of one kind or another."""


class SoftLaw(NamedTuple):
    """A material of a case, `contiga.materials`."""

    table: dict[str, Any]
    """Of `material`, but for what is a curve."""
    modulus: float
    """Young's."""
    poisson: float
    note: str = ""
    """What of the card it is not."""
    curves: Mapping[str, int] = MappingProxyType({})
    """Numbers of the curves, by key of the table."""
    membrane: bool = False
    """Whether it is for membranes alone."""


class SoftCards(NamedTuple):
    """How a material is read."""

    cards: tuple[slice, ...]
    """Fields of its cards that are needed."""
    law: Callable[..., SoftLaw | str]
    """Asked with all of them; why they make none, where they do not."""


def _elastic(modulus: float, poisson: float) -> SoftLaw | str:
    if modulus <= 0.0:
        return "no modulus"
    return SoftLaw({"kind": "elastic", "young": modulus, "poisson": poisson}, modulus, poisson)


def _neo_hooke(shear: float, poisson: float, note: str) -> SoftLaw | str:
    if shear <= 0.0:
        return "no shear modulus"
    if not 0.0 <= poisson < 0.5:
        return f"Poisson's ratio {poisson:g}, not from 0 to below 0.5"
    young = 2.0 * shear * (1.0 + poisson)
    table = {"kind": "neo-hooke", "young": young, "poisson": poisson, "volume": "nodes"}
    return SoftLaw(table, young, poisson, note)


def _blatz_ko(shear: float) -> SoftLaw | str:
    return _neo_hooke(shear, BLATZ_KO, "neo-Hooke of its shear modulus")


def _mooney_rivlin(poisson: float, a: float, b: float) -> SoftLaw | str:
    return _neo_hooke(2.0 * (a + b), poisson, f"neo-Hooke of 2 (A + B), B is {b:g}" if b else "")


def _foam(
    modulus: float, curve: float, _cutoff: float, returned: float, shape: float
) -> SoftLaw | str:
    if modulus <= 0.0 or curve <= 0.0:
        return "no modulus E" if curve > 0.0 else "no curve LCID"
    table = {
        "kind": "foam",
        "hysteresis": returned or 1.0,
        "shape": shape or 1.0,
        "tension": modulus,
    }
    return SoftLaw(table, modulus, 0.0, curves={"loading": int(curve)})


def _fabric(*numbers: float) -> SoftLaw | str:
    """*MAT_FABRIC: isotropic where it has one modulus and no shear modulus of its own."""
    warp, weft, _, poisson, shear, _, _, slack, aopt, form, *rest = numbers
    direction, (warp_curve, weft_curve, shear_curve, *unloading) = rest[:3], map(int, rest[3:])
    if warp <= 0.0:
        return "no modulus EA"
    by_curves = form in _BY_CURVES and warp_curve > 0
    if not by_curves and (form in _BY_CURVES or any(rest[3:]) or abs(form) in _OTHER_CURVES):
        return f"FORM {form:g} with its curves"
    if not by_curves and shear == 0.0 and weft in (0.0, warp):
        table = {"kind": "elastic", "young": warp, "poisson": poisson, "compression": not slack}
        return SoftLaw(table, warp, poisson, membrane=True)
    if aopt != _ALONG_A_VECTOR or not any(direction):
        return f"AOPT {aopt:g}, its axes are no vector A of AOPT 2"
    table = {"kind": "fabric", "direction": direction, "compression": 0.0 if slack else 1.0}
    curves: dict[str, int] = {}
    for key, modulus, curve in (
        ("warp", warp, warp_curve),
        ("weft", weft or warp, weft_curve or (0 if weft else warp_curve)),
        ("shear", shear, shear_curve),
    ):
        if by_curves and curve > 0:
            curves[key] = curve
        else:
            table[key] = modulus
    notes = ["warp and weft do not contract each other"] if poisson else []
    notes += ["it unloads as it loads"] if by_curves and any(unloading) else []
    return SoftLaw(table, warp, 0.0, ", ".join(notes), curves, membrane=True)


_FABRIC_CARDS = (
    slice(2, 6),  # EA, EB, EC, PRBA
    slice(0, 4),  # GAB, GBC, GCA, CSE
    slice(0, 6, 5),  # AOPT, FORM
    slice(3, 6),  # A1, A2, A3
    slice(0, 0),
    slice(0, 6),  # LCA, LCB, LCAB, LCUA, LCUB, LCUAB
)

SOFT: dict[str, SoftCards] = {
    name: cards
    for names, cards in (
        (("ELASTIC", "001"), SoftCards((slice(2, 4),), _elastic)),
        (("BLATZ-KO_RUBBER", "007"), SoftCards((slice(2, 3),), _blatz_ko)),
        (("MOONEY-RIVLIN_RUBBER", "027"), SoftCards((slice(2, 5),), _mooney_rivlin)),
        (("FABRIC", "034"), SoftCards(_FABRIC_CARDS, _fabric)),
        (("LOW_DENSITY_FOAM", "057"), SoftCards((slice(2, 6), slice(0, 1)), _foam)),
    )
    for name in names
}
"""By the end of the keyword, *MAT_…."""
