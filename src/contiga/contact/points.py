"""Choose the points of a slave that carry contact, and their areas."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from contiga.area.facet import FacetArea
from contiga.area.method import AreaMethod
from contiga.area.nodal import NodalArea
from contiga.arrays.layout import read_only
from contiga.contact.state import State
from contiga.errors import InputError
from contiga.laws.law import Law
from contiga.records import FloatArray
from contiga.slaves.checks import as_nodal
from contiga.slaves.sampling import Sampling
from contiga.slaves.slave import Slave

_COVER_TOL = 1e-9
"""Rounding of shape functions that add up to one."""


def default_area(slave: Slave) -> AreaMethod:
    """Return the default area method of a slave: `FacetArea` with facets, else `NodalArea`."""
    has_facets = slave.facets is not None and len(slave.facets) > 0
    return FacetArea() if has_facets else NodalArea()


def sampling_of(
    slave: Slave, quadrature: str | int, weights: str, fixed: FloatArray | None, law: Law
) -> Sampling:
    """Return the points of contact of a slave, with `fixed` areas (n,) for weights "rest".

    Raises
    ------
    InputError
        The law needs areas at rest, and they are unknown.
    """
    if quadrature != "nodes":
        return Sampling(slave, None, int(quadrature))
    if weights == "rest" and fixed is None and getattr(law, "needs_area", True):
        raise InputError(
            "the areas of the slave's points at rest are unknown",
            where="weights",
            found="a cloud without areas",
            allowed="a slave with facets or areas, NodalArea(value), CloudArea() of a sheet",
            remedy='Give them, or take weights="area": measured areas weigh the force, which then '
            "makes and loses energy",
        )
    return Sampling(slave, fixed if weights == "rest" else None)


def half_of(thickness: ArrayLike | None, slave: Slave, sampling: Sampling) -> FloatArray | None:
    """Return half the thickness (m,) of a shell at the points of contact; None without thickness.

    Quadrature points interpolate between the corners of their facet, if all of these have a
    thickness; else theirs is zero, as on facets of solids beside a shell.

    Raises
    ------
    InputError
        Neither a number nor one per point; negative values; zero everywhere.
    """
    if thickness is None:
        return None
    nodal = as_nodal(thickness, "shell_thickness", len(slave), slave.name)
    if nodal is None or isinstance(thickness, bool) or not nodal.any():
        raise InputError(
            "must be above zero somewhere",
            where="shell_thickness",
            found=thickness,
            allowed="a length, or (n,) one for each point of the slave",
        )
    corners = np.stack([0.5 * nodal, nodal > 0.0, nodal], axis=1)
    half, covered, _ = sampling.points(corners).T
    return read_only(np.where(covered > 1.0 - _COVER_TOL, half, 0.0))


def pressure_of(sampling: Sampling, state: State) -> FloatArray:
    """Return (n,) normal force at each node over the area that carries it, zero without contact.

    It is the share of fixed areas that is in contact, or the measured area if there are none.
    """
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
