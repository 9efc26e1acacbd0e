"""Materials of an LS-DYNA deck whose parts deform in a case.

Card layouts: LS-DYNA Keyword User's Manual, volume II.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from contiga.io.mesh.lsdyna_cards import Layout, Row, layout

BLATZ_KO = 0.463
"""Poisson's ratio of *MAT_BLATZ-KO_RUBBER."""
_AOPT_VECTOR = 2.0
"""AOPT of material axes given by one vector for all elements."""
_PIOLA_FORMS = (4.0, 14.0)
"""FORM of fabrics with curves of second Piola-Kirchhoff stress over Green strain."""
_CURVE_FORMS = (4.0, 13.0, 14.0, 24.0)
"""Magnitudes of FORM with curves of either kind."""


class SoftLaw(NamedTuple):
    """A law of `contiga.materials`, in the units of the deck."""

    table: dict[str, Any]
    """Table of `material`, without its curves."""
    modulus: float
    """Young's modulus; of fabric along the warp, of foam in tension."""
    poisson: float
    note: str = ""
    """Features of the card that are left out."""
    curves: Mapping[str, int] = MappingProxyType({})
    """Numbers of the curves in the deck, by key of the table."""
    membrane: bool = False
    """Whether it is for membranes only."""
    by_rate: int = 0
    """Number of the table of its loading curves by rate; 0 without one."""


Law = Callable[[list[Row]], SoftLaw | str]
CARDS: dict[str, tuple[Layout, ...]] = {}
"""Cards of the materials that are understood, by the end of the keyword, *MAT_…."""
SOFT: dict[str, Law] = {}
"""Functions from the cards of a material to its law, or to the reason for none."""


def _add_cards(names: tuple[str, ...], cards: tuple[str, ...]) -> None:
    CARDS.update(dict.fromkeys(names, tuple(map(layout, cards))))


def _material(*names: str, cards: tuple[str, ...]) -> Callable[[Law], Law]:
    """Return a decorator that makes a function the law of *MAT_… of these names; note the cards."""
    _add_cards(names, cards)

    def register(law: Law) -> Law:
        SOFT.update(dict.fromkeys(names, law))
        return law

    return register


# Materials of which no part deforms in a case.
_add_cards(("PLASTIC_KINEMATIC", "003"), ("MID RO E PR SIGY ETAN BETA", "SRC SRP FS VP"))
_add_cards(
    ("RIGID", "020"),
    ("MID RO E PR N COUPLE M ALIAS", "CMO CON1 CON2", "~LCO/A1 ~A2 ~A3 ~V1 ~V2 ~V3"),
)
_add_cards(
    ("PIECEWISE_LINEAR_PLASTICITY", "024"),
    (
        "MID RO E PR SIGY ETAN FAIL=1e21 TDEL",
        "C P LCSS LCSR VP",
        "EPS1 EPS2 EPS3 EPS4 EPS5 EPS6 EPS7 EPS8",
        "ES1 ES2 ES3 ES4 ES5 ES6 ES7 ES8",
    ),
)
_add_cards(("CRUSHABLE_FOAM", "063"), ("MID RO E PR LCID TSC DAMP=0.1 MODEL",))


@_material("ELASTIC", "001", cards=("MID RO E PR DA DB K",))
def _elastic(rows: list[Row]) -> SoftLaw | str:
    modulus, poisson = rows[0].reals("E PR")
    if modulus <= 0.0:
        return "no modulus"
    return SoftLaw({"kind": "elastic", "young": modulus, "poisson": poisson}, modulus, poisson)


def _neo_hooke(shear: float, poisson: float, note: str) -> SoftLaw | str:
    """Return the neo-Hooke law of a shear modulus; the reason for none if a number is invalid."""
    if shear <= 0.0:
        return "no shear modulus"
    if not 0.0 <= poisson < 0.5:
        return f"Poisson's ratio {poisson:g}, not from 0 to below 0.5"
    young = 2.0 * shear * (1.0 + poisson)
    table = {"kind": "neo-hooke", "young": young, "poisson": poisson, "volume": "nodes"}
    return SoftLaw(table, young, poisson, note)


@_material("BLATZ-KO_RUBBER", "007", cards=("MID RO G REF",))
def _blatz_ko(rows: list[Row]) -> SoftLaw | str:
    return _neo_hooke(rows[0].real("G"), BLATZ_KO, "neo-Hooke of its shear modulus")


@_material("MOONEY-RIVLIN_RUBBER", "027", cards=("MID RO PR A B REF", "SGL SW ST LCID"))
def _mooney_rivlin(rows: list[Row]) -> SoftLaw | str:
    poisson, a, b = rows[0].reals("PR A B")
    return _neo_hooke(2.0 * (a + b), poisson, f"neo-Hooke of 2 (A + B), B is {b:g}" if b else "")


@_material(
    "LOW_DENSITY_FOAM",
    "057",
    cards=("MID RO E LCID TC=1e20 HU=1 BETA DAMP=0.05", "SHAPE=1 FAIL BVFLAG ED BETA1 KCON REF"),
)
def _foam(rows: list[Row]) -> SoftLaw | str:
    modulus, hysteresis = rows[0].reals("E HU")
    curve, shape = rows[0].whole("LCID"), rows[1].real("SHAPE")
    if modulus <= 0.0 or curve <= 0:
        return "no modulus E" if curve > 0 else "no curve LCID"
    table = {"kind": "foam", "hysteresis": hysteresis, "shape": shape, "tension": modulus}
    return SoftLaw(table, modulus, 0.0, curves={"loading": curve})


@_material(
    "FU_CHANG_FOAM",
    "083",
    cards=(
        "MID RO E KCON TC=1e20 FAIL DAMP=0.05 TBID",
        "BVFLAG SFLAG RFLAG TFLAG PVID SRAF REF HU",
        "D0 N0 N1 N2 N3 C0 C1 C2",
        "C3 C4 C5 AIJ SIJ MINR MAXR SHAPE",
        "EXPON=1 RIULD",
    ),
)
def _foam_with_rates(rows: list[Row]) -> SoftLaw | str:
    """Return the foam with a table of curves by rate; the form with fitted constants has no law."""
    modulus, by_rate = rows[0].real("E"), rows[0].whole("TBID")
    is_nominal, hysteresis = rows[1].reals("SFLAG HU")
    shape = rows[3].real("SHAPE")
    if modulus <= 0.0 or by_rate <= 0:
        return "no modulus E" if by_rate > 0 else "no table TBID"
    # HU = 0 unloads as it loads, without rates.
    table = {
        "kind": "foam",
        "hysteresis": hysteresis or 1.0,
        "shape": shape or 1.0,
        "tension": modulus,
    }
    note = "" if is_nominal else "its rates are taken as of nominal strain, SFLAG is 0"
    return SoftLaw(table, modulus, 0.0, note, by_rate=by_rate)


@_material(
    "FABRIC",
    "034",
    cards=(
        "MID RO EA EB EC PRBA PRCA PRCB",
        "GAB GBC GCA CSE EL PRL LRATIO DAMP",
        "AOPT FLC FAC ELA LNRC FORM FVOPT TSRFAC",
        "P1 RGBRTH A0REF A1 A2 A3 X0 X1",
        "V1 V2 V3 P4 P5 P6 BETA ISREFG",
        "LCA LCB LCAB LCUA LCUB LCUAB RL",
        "LCAA LCBB H DT P5 ECOAT SCOAT TCOAT",
    ),
)
def _fabric(rows: list[Row]) -> SoftLaw | str:
    """Return an elastic membrane, or a woven one with moduli or curves along warp and weft.

    It is elastic if it has one modulus, no GAB and no curves. There is no law, but the reason in
    words, without EA, for curves of a FORM other than 4 and 14 (second Piola-Kirchhoff stress), and
    for woven axes other than of AOPT 2.
    """
    warp, weft, poisson = rows[0].reals("EA EB PRBA")
    shear, no_compression = rows[1].reals("GAB CSE")
    aopt, form = rows[2].reals("AOPT FORM")
    direction = list(rows[3].reals("A1 A2 A3"))
    all_curves = rows[5].wholes("LCA LCB LCAB LCUA LCUB LCUAB")
    warp_curve, weft_curve, shear_curve, *unloading_curves = all_curves
    if warp <= 0.0:
        return "no modulus EA"
    by_curves = form in _PIOLA_FORMS and warp_curve > 0
    if not by_curves and (form in _PIOLA_FORMS or any(all_curves) or abs(form) in _CURVE_FORMS):
        return f"FORM {form:g} with its curves"
    if not by_curves and shear == 0.0 and weft in (0.0, warp):
        table = {"kind": "elastic", "young": warp, "poisson": poisson}
        table["compression"] = not no_compression
        return SoftLaw(table, warp, poisson, membrane=True)
    if aopt != _AOPT_VECTOR or not any(direction):
        return f"AOPT {aopt:g}, its axes are no vector A of AOPT 2"
    compression = 0.0 if no_compression else 1.0
    table = {"kind": "fabric", "direction": direction, "compression": compression}
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
    notes += ["it unloads as it loads"] if by_curves and any(unloading_curves) else []
    return SoftLaw(table, warp, 0.0, ", ".join(notes), curves, membrane=True)
