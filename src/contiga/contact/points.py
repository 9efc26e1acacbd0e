"""Which points of a slave carry contact, and over what area."""

from __future__ import annotations

import numpy as np

from contiga.area.facet import FacetArea
from contiga.area.method import AreaMethod
from contiga.area.nodal import NodalArea
from contiga.contact.state import State
from contiga.errors import InputError
from contiga.laws.law import Law
from contiga.records import FloatArray
from contiga.slaves.sampling import RULES, Sampling
from contiga.slaves.slave import Slave


def default_area(slave: Slave) -> AreaMethod:
    """How contact areas are measured where nothing is said."""
    has_facets = slave.facets is not None and len(slave.facets) > 0
    return FacetArea() if has_facets else NodalArea()


def sampling_of(
    slave: Slave, where: tuple[str | int, str], weights: str, fixed: FloatArray | None, law: Law
) -> Sampling:
    """The points of contact and their fixed areas, which only laws that need none do without.

    `where` are how many lie on each facet and on which side of it.
    """
    quadrature, side = where
    if quadrature != "nodes":
        return Sampling(slave, None, RULES[int(quadrature)], side)
    if weights == "rest" and fixed is None and getattr(law, "needs_area", True):
        raise InputError(
            "the areas of the slave's points at rest are unknown",
            where="weights",
            found="a cloud without areas",
            allowed="a slave with facets or areas, NodalArea(value), CloudArea() of a sheet",
            remedy='Give them, or take weights="area": measured areas weigh the force, which then '
            "makes and loses energy",
        )
    return Sampling(slave, fixed)


def pressure_of(sampling: Sampling, state: State) -> FloatArray:
    """(n,) normal force at each node over the area that carries it, zero without contact."""
    rows = np.flatnonzero(state.normal_force)
    force = sampling.nodal_sum(rows, state.normal_force[rows])
    if sampling.weight is None:
        weight = state.area
    else:
        touching = np.flatnonzero(state.patch >= 0)
        touching = touching[touching >= sampling.first]
        weight = sampling.nodal_sum(touching, sampling.weight[touching])
    pressure = np.zeros(len(force))
    np.divide(force, weight, out=pressure, where=weight > 0.0)
    return pressure
