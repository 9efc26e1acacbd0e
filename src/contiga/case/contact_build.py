"""Make a contact from its table and the parts it names."""

from __future__ import annotations

from numpy.typing import ArrayLike

from contiga.area.facet import FacetArea
from contiga.area.method import AreaMethod
from contiga.area.nodal import NodalArea
from contiga.case.contact_spec import (
    QUADRATURE,
    CloudAreaSpec,
    ConstantAreaSpec,
    ContactSpec,
    FacetAreaSpec,
    HullAreaSpec,
)
from contiga.case.law_spec import PenaltySpec
from contiga.case.sides import Sides
from contiga.contact.checks import unfit_for_facets
from contiga.contact.contact import Contact
from contiga.dynamics.deforming import Deforming
from contiga.errors import CaseError
from contiga.laws.law import Law
from contiga.masters.protocol import Master
from contiga.simulation.model import SlavePart
from contiga.slaves.slave import Slave


def area_of(spec: ContactSpec, slave: Slave, has_area: bool) -> AreaMethod:
    """Return the area method of a contact.

    It is the method of the contact's table. By default facets are cut, if the slave has facets and
    the case gave it no nodal area (`has_area`); else, and for "tributary", nodal areas count.

    Raises
    ------
    CaseError
        Nodal areas are to count, and the slave has none.
    """
    if isinstance(spec.area, FacetAreaSpec | CloudAreaSpec | HullAreaSpec):
        return spec.area.instance
    if isinstance(spec.area, ConstantAreaSpec):
        return NodalArea(spec.area.value)
    if spec.area is None and slave.facets is not None and not has_area:
        return FacetArea()
    if slave.area is None:
        raise CaseError(
            f"the points of {slave.name!r} have no facets to take areas from",
            where="area",
            found="none" if spec.area is None else spec.area.kind,
            allowed='{ kind = "constant", value = … }, { kind = "cloud" }, { kind = "hull" }, '
            "or an area of the slave",
        )
    return NodalArea()


def contact_of(
    spec: ContactSpec, sides: Sides, body: Master, slave: SlavePart, area: AreaMethod
) -> Contact:
    """Return the contact of a table, between parts that are placed already.

    A slave that deforms has points of contact on its facets by default: the nodes of solids carry
    evenly spread loads unevenly, and are few. Bars and clouds have nodes alone; the nodes of
    splines are the points of a quadrature rule, and lie on the surface. If the law needs masses,
    the points get the nodal masses of the elements.

    Raises
    ------
    InputError
        The slave has no elements whose stiffness the law scales with, or no known thickness.
    """
    motion = slave.motion
    deforming = motion if isinstance(motion, Deforming) else None
    law: Law = sides.law
    if isinstance(spec.law, PenaltySpec) and spec.law.scale is not None:
        if deforming is None:
            raise CaseError(
                "is of the stiffness of elements, and the slave has none",
                where="law.scale",
                found=spec.law.scale,
                allowed='stiffness, or a slave with motion = { kind = "deform" }',
            )
        law = spec.law.scaled(deforming.contact_stiffness(slave.slave))
    points = slave.slave
    if deforming is not None and getattr(law, "needs_mass", False):
        points = deforming.with_masses(points)
    quadrature = spec.quadrature
    if quadrature is None:
        facets = slave.slave.facets
        on_facets = (
            deforming is not None
            and facets is not None
            and len(facets) > 0
            and slave.slave.surfaces is None
            and not unfit_for_facets(spec.weights, law, area)
        )
        quadrature = QUADRATURE if on_facets else "nodes"
    shell_thickness: ArrayLike | None = spec.shell_thickness or None
    if spec.shell_thickness is True:
        shell_thickness = thickness = slave.slave.thickness
        if deforming is not None:
            shell_thickness = thickness = deforming.nodal_thickness(slave.slave)
        if thickness is None or not thickness.any():
            raise CaseError(
                f"the thickness of {slave.slave.name!r} is not known",
                where="shell_thickness",
                found=True,
                allowed="a length, or a slave of membranes or shells with a thickness",
            )
    return Contact(
        body,
        points,
        law=law,
        area=area,
        search=spec.search,
        contact_type=sides.type,
        on_edge=spec.on_edge,
        through=spec.through,
        foot=spec.foot,
        weights=spec.weights,
        quadrature=quadrature,
        shell_thickness=shell_thickness,
        friction=None if spec.friction is None else spec.friction.instance,
        master_law=sides.master_law,  # type: ignore[arg-type]  # the schema refuses others
        depth=spec.depth,
    )
