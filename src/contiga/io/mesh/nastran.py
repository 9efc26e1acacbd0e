"""Nastran bulk data: grid points with their systems, shells and solids by property.

Cards that make or move grid points and elements are carried out, or refused by name and line; cards
of families that do neither (properties, materials, loads, constraints, rigid and line elements …)
are passed over. Card layouts: MSC Nastran Quick Reference Guide.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from contiga.errors import FileError, MeshError
from contiga.io.mesh.nastran_cards import Card, read_cards
from contiga.io.mesh.nastran_systems import CORDS, Grids
from contiga.io.mesh.numbered import Elements, raw_mesh
from contiga.io.mesh.raw import RawMesh
from contiga.slaves.cells import N_NODES

SUFFIXES = (".bdf", ".nas", ".fem")


class _Kind(NamedTuple):
    """The cells of an element type."""

    linear: str
    quadratic: str
    """Cell with mid-side nodes; "" if the type has none."""
    order: tuple[int, ...] = ()
    """Places on the card of the quadratic cell's nodes in VTK's order; empty if it is the same."""


_BRICK = (*range(12), *range(16, 20), *range(12, 16))
_WEDGE = (*range(9), *range(12, 15), *range(9, 12))
_ELEMENTS = {
    "CTRIA3": _Kind("triangle", ""),
    "CTRIAR": _Kind("triangle", ""),
    "CTRIA6": _Kind("triangle", "triangle6"),
    "CQUAD4": _Kind("quad", ""),
    "CQUADR": _Kind("quad", ""),
    "CQUAD8": _Kind("quad", "quad8"),
    "CQUAD": _Kind("quad", "quad9"),
    "CSHEAR": _Kind("quad", ""),
    "CTETRA": _Kind("tetra", "tetra10"),
    "CHEXA": _Kind("hexahedron", "hexahedron20", _BRICK),
    "CPENTA": _Kind("wedge", "wedge15", _WEDGE),
    "CPYRAM": _Kind("pyramid", "pyramid13"),
    "CPYRA": _Kind("pyramid", "pyramid13"),
}
_IGNORED = re.compile(
    r"P\w*|MAT\w*|MPC\w*|MOM\w*|MDLPRM|MODTRAK|MONPNT\d|MKAERO\d|SPC\w*|SET\d?|SUPORT\d?|SPOINT"
    r"|SLOAD|SNORM|SPLINE\d|FORCE\w*|FREQ\w*|FLUTTER|FLFACT|LOAD\w*|LSEQ|TAB\w*|TEMP\w*|TF|TIC\w*"
    r"|TLOAD\d|TSTEP\w*|EIG\w+|EPOINT|DAREA|DELAY|DPHASE|DLOAD|DESVAR|DRESP\d|DV[MPC]REL\d|DCONSTR"
    r"|DCONADD|DOPTPRM|DEQATN|DLINK|DTABLE\d?|DSCREEN|DTI|DMI\w*|DEFORM|RBE\d\w*|RBAR\d?|RROD|RSPLINE"
    r"|RSSCON|RTRPLT\d?|RFORCE\w*|RLOAD\d|RAND\w+|ASET\d?|ACCEL\d?|AE\w+|BSET\d?|BC\w+|BSURF\w*"
    r"|BLSEG|BFRIC|BNDF\w+|BOLT\w*|GRAV|GENEL|GUST|NLPARM|NLPCI|NLSTEP|NOLIN\d|NSM\w*|QBDY\d|QHBDY"
    r"|QSET\d?|QVECT|QVOL|USET\d?|OMIT\d?|VIEW\w*|CROD|CONROD|CTUBE|CBAR|CBEAM3?|CBEND|CBUSH\w*"
    r"|CELAS\d|CDAMP\d|CMASS\d|CONM\d|CGAP|CVISC|CWELD|CFAST|CSEAM|CSET\d?|CHBDY\w|CONV\w?|CAERO\d"
    r"|CREEP|CBARAO|BAROR|BEAMOR|ECHO(?:ON|OFF)"
)
"""Names of cards that neither make nor move grid points, shells or solids."""


def read_nastran(path: Path) -> RawMesh:
    """Return the mesh of a bulk data deck with its included files; a group for each property.

    An element without a property has its own number as one.

    Raises
    ------
    FileError
        Not a deck, or an included file is missing.
    MeshError
        An unknown card, a number that is not one or is given twice, a system that does not exist,
        an element of a grid point that does not exist, or with some mid-side nodes but not all.
    """
    grids = Grids()
    elements: dict[str, Elements] = {}
    places: dict[int, str] = {}
    is_empty = True
    for card in read_cards(path):
        is_empty = False
        if card.name.endswith("_"):  # meshio marks elements with mid-side nodes: CHEXA_
            card = card._replace(name=card.name.rstrip("_"))
        match card.name:
            case "GRID":
                grids.read_grid(card)
            case "GRDSET":
                grids.read_defaults(card)
            case name if name in CORDS:
                grids.read_system(card)
            case name if name in _ELEMENTS:
                number = card.whole(0)
                if number in places:
                    raise MeshError(
                        "an element is given twice",
                        where=card.where,
                        found=f"element {number}",
                        allowed=f"each number once; it is there in {places[number]}",
                    )
                places[number] = card.where
                kind, nodes = _cell(card)
                same_kind = elements.setdefault(kind, Elements(kind, [], [], []))
                same_kind.nodes.append(nodes)
                same_kind.properties.append(card.whole(1, number))
                same_kind.where.append(card.where)
            case name if not _IGNORED.fullmatch(name):
                raise MeshError(
                    "a card that is not known here, and may make or move grid points or elements",
                    where=card.where,
                    remedy="Leave it out if it does neither; else write the mesh without it",
                )
    if is_empty:
        raise FileError("not a Nastran deck", where=str(path), allowed="cards such as GRID")
    return raw_mesh(grids.positions(), list(elements.values()), str(path), "numbers given by GRID")


def _cell(card: Card) -> tuple[str, list[int]]:
    """Return kind and nodes, in VTK's order, of an element: linear if it names no mid-side node.

    A CQUAD without its centre node is a "quad8".

    Raises
    ------
    MeshError
        A corner is left out, or some mid-side nodes but not all.
    """
    kind = _ELEMENTS[card.name]
    n_corners = N_NODES[kind.linear]
    count = N_NODES.get(kind.quadratic, n_corners)
    nodes = [card.whole(2 + k) for k in range(count)]
    middles = nodes[n_corners:]
    if not all(nodes[:n_corners]):
        raise MeshError("a corner is left out", where=card.where, found=card.fields[2:])
    if not any(middles):
        return kind.linear, nodes[:n_corners]
    if kind.quadratic == "quad9" and not middles[-1]:
        kind, nodes, middles = _ELEMENTS["CQUAD8"], nodes[:-1], middles[:-1]
    if not all(middles):
        raise MeshError(
            "some mid-side nodes are left out, which is not carried out",
            where=card.where,
            allowed="all of them, or none",
        )
    return kind.quadratic, [nodes[k] for k in kind.order] if kind.order else nodes
