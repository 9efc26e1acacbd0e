"""Which points of a slave carry contact, and over what area."""

from __future__ import annotations

from contiga.area.facet import FacetArea
from contiga.area.method import AreaMethod
from contiga.area.nodal import NodalArea
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.slaves.sampling import RULES, Sampling
from contiga.slaves.slave import Slave


def default_area(slave: Slave) -> AreaMethod:
    """How contact areas are measured where nothing is said."""
    has_facets = slave.facets is not None and len(slave.facets) > 0
    return FacetArea() if has_facets else NodalArea()


def sampling_of(
    slave: Slave, quadrature: str | int, weights: str, fixed: FloatArray | None
) -> Sampling:
    """The points of contact and their fixed areas."""
    if quadrature != "nodes":
        return Sampling(slave, None, RULES[int(quadrature)])
    if weights == "rest" and fixed is None:
        raise InputError(
            "nothing tells the areas of the slave's points at rest",
            where="weights",
            found="a cloud without areas",
            allowed="a slave with facets or areas, NodalArea(value), CloudArea() of a sheet",
            remedy='Give them, or take weights="area": measured areas weigh the force, which then '
            "makes and loses energy",
        )
    return Sampling(slave, fixed if weights == "rest" else None)
