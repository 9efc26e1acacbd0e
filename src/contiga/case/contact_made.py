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
from contiga.case.law_spec import LawSpec, PenaltySpec
from contiga.case.sides import Sides
from contiga.contact.checks import unfit_for_facets
from contiga.contact.contact import Contact
from contiga.dynamics.deforming import Deforming
from contiga.errors import CaseError
from contiga.laws.law import Law
from contiga.masters.protocol import Master
from contiga.simulation.model import SlavePart
from contiga.slaves.slave import Slave


def area_of(spec: ContactSpec, slave: Slave, given: bool) -> AreaMethod:
    """Return the area method of the case; facets, unless the case gave the nodes an area."""
    if isinstance(spec.area, FacetAreaSpec | CloudAreaSpec | HullAreaSpec):
        return spec.area.made
    if isinstance(spec.area, ConstantAreaSpec):
        return NodalArea(spec.area.value)
    if spec.area is None and slave.facets is not None and not given:
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


def _scaled_law(spec: LawSpec | None, slave: SlavePart) -> Law | None:
    """Return the law whose stiffness is a multiple of that of the slave's elements, or None."""
    if not isinstance(spec, PenaltySpec) or spec.scale is None:
        return None
    if not isinstance(slave.motion, Deforming):
        raise CaseError(
            "is of the stiffness of elements, and the slave has none",
            where="law.scale",
            found=spec.scale,
            allowed='stiffness, or a slave with motion = { kind = "deform" }',
        )
    return spec.scaled(slave.motion.contact_stiffness(slave.slave))


def _thickness_of(spec: ContactSpec, slave: SlavePart) -> ArrayLike | None:
    """Return the thickness of the slave as a shell, or None if it does not count."""
    if spec.shell_thickness is not True:
        return spec.shell_thickness or None
    known = slave.slave.thickness
    if isinstance(slave.motion, Deforming):
        known = slave.motion.nodal_thickness(slave.slave)
    if known is None or not known.any():
        raise CaseError(
            f"the thickness of {slave.slave.name!r} is not known",
            where="shell_thickness",
            found=True,
            allowed="a length, or a slave of membranes or shells with a thickness",
        )
    return known


def _quadrature_of(spec: ContactSpec, slave: SlavePart, law: Law, area: AreaMethod) -> str | int:
    """Choose points on the facets for a slave that deforms, if it has facets and may use them.

    The nodes of solids carry evenly spread loads unevenly, and are few. Bars and points have nodes
    alone. Nodes of splines are the points of a rule of quadrature, and lie on the surface.
    """
    if spec.quadrature is not None:
        return spec.quadrature
    facets = slave.slave.facets
    if not isinstance(slave.motion, Deforming) or facets is None or len(facets) == 0:
        return "nodes"
    if slave.slave.surfaces is not None:
        return "nodes"
    return "nodes" if unfit_for_facets(spec.weights, law, area) else QUADRATURE


def contact_of(
    spec: ContactSpec, sides: Sides, body: Master, slave: SlavePart, area: AreaMethod
) -> Contact:
    """Return the contact of a table, between parts that are placed already."""
    law, points = _scaled_law(spec.law, slave) or sides.law, slave.slave
    if isinstance(slave.motion, Deforming) and getattr(law, "needs_mass", False):
        points = slave.motion.with_masses(points)
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
        quadrature=_quadrature_of(spec, slave, law, area),
        shell_thickness=_thickness_of(spec, slave),
        friction=None if spec.friction is None else spec.friction.made,
        master_law=sides.master_law,  # type: ignore[arg-type]  # the schema refuses others
        depth=spec.depth,
    )
