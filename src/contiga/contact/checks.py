"""Check the parts and options of a contact, and the states given to it."""

from __future__ import annotations

from contiga.area.hull import HullArea
from contiga.area.method import AreaMethod
from contiga.area.nodal import NodalArea
from contiga.arrays.layout import not_negative
from contiga.contact.state import State
from contiga.errors import InputError
from contiga.laws.by_face import FaceLaws
from contiga.laws.combined import CombinedLaw, forces_in_series
from contiga.laws.normal import ForceLaw, Law, StressLaw
from contiga.masters.protocol import Master, is_master
from contiga.slaves.sampling import QUADRATURES
from contiga.slaves.slave import Slave


def check_methods(law: object, area: object) -> None:
    """Raise `InputError` for an object, or a class, that is no law or no area method.

    An `area` of None is allowed.
    """
    attributes = ("respond", "n_memory", "needs_mass", "needs_thickness")
    if hasattr(law, "forces") and not hasattr(law, "respond"):
        raise InputError(
            "the law answers by `forces`; a contact asks it to `respond`",
            where="law",
            found=type(law).__name__,
            allowed="respond(LawInput) -> LawOutput(force, stiffness, stored, memory)",
            remedy="Rename it respond, answer LawOutput, and set n_memory = 0",
        )
    if isinstance(law, type) or not all(hasattr(law, name) for name in attributes):
        raise InputError(
            "expected a force law, such as PenaltyLaw(100.0)",
            where="law",
            found=law,
            allowed="ForceLaw, StressLaw, PenaltyLaw, AdaptiveLaw, or an object like them with "
            "respond, n_memory, needs_mass and needs_thickness",
        )
    if area is not None and (isinstance(area, type) or not isinstance(area, AreaMethod)):
        raise InputError(
            "the area must be a method, such as NodalArea(0.5)",
            where="area",
            found=area,
            allowed="FacetArea, CloudArea, HullArea, NodalArea, or an object with measure",
        )


def check_master(master: Master, area: AreaMethod | None) -> None:
    """Raise `InputError` for an object that is no master, or areas that need patches it lacks.

    `Master.check` may raise errors of its own for a master that cannot serve.
    """
    if not is_master(master):
        raise InputError(
            "the master must be a Body or a TriMesh",
            where="master",
            found=type(master).__name__,
            allowed="one of them, or an object of a class derived from contiga.Master",
        )
    master.check()
    if master.faces is None and isinstance(area, HullArea):
        raise InputError(
            "hulls are drawn in the (u, v) of a patch, which a mesh does not have",
            where="area",
            found="HullArea",
            allowed="FacetArea, CloudArea or NodalArea for a master of triangles",
        )


def check_friction(friction: object) -> None:
    """Raise `InputError` for an object, or a class, that is no friction; None is allowed.

    The coefficient of a viscous friction must not be negative.
    """
    if friction is None:
        return
    if isinstance(friction, type) or not all(
        hasattr(friction, name) for name in ("respond", "n_memory", "slid")
    ):
        raise InputError(
            "expected a friction law, such as Coulomb(0.3)",
            where="friction",
            found=friction,
            allowed="Coulomb, ViscousFriction, or an object with respond, n_memory and slid",
        )
    if getattr(friction, "viscosity", None) is not None:
        not_negative(getattr(friction, "coefficient", None), "friction.coefficient")


def check_sampling(quadrature: str | int, weights: str, law: Law, area: AreaMethod) -> None:
    """Raise `InputError` for quadrature points with options that exclude them."""
    error = None if quadrature == "nodes" else unfit_for_facets(weights, law, area)
    if error is not None:
        raise error


def unfit_for_facets(weights: str, law: Law, area: AreaMethod) -> InputError | None:
    """Return the error if a contact cannot have quadrature points; None if it can.

    They need weights "rest", a law per area, and areas that are not given for each node.
    """
    if weights != "rest":
        return InputError(
            "quadrature points weigh the force by their share of the facets at rest",
            where="weights",
            found=weights,
            allowed='"rest", or quadrature="nodes"',
        )
    if getattr(law, "per_area", True) is False:
        return InputError(
            "a stiffness per point would grow with the number of quadrature points",
            where="law",
            found="per_area=False",
            remedy='Give the stiffness of a unit area with per_area=True, or quadrature="nodes"',
        )
    if isinstance(area, NodalArea) and area.value is not None:
        return InputError(
            "quadrature points take their areas from the facets, not from the nodes",
            where="area",
            found="NodalArea(value)",
            allowed='FacetArea(), NodalArea(), or quadrature="nodes"',
        )
    return None


def check_shell(thickness: object, contact_type: str, area: AreaMethod) -> None:
    """Raise `InputError` for a thickness with a type or areas of contact that exclude it.

    The slave must be the side that deforms, and areas must be measured on it, not by feet.
    """
    if thickness is None:
        return
    if contact_type != "slave":
        raise InputError(
            "a shell with a thickness gives way by itself",
            where="contact_type",
            found=contact_type,
            allowed='"slave", or no shell_thickness',
        )
    by_feet = isinstance(area, HullArea) or getattr(area, "by", "rest") == "feet"
    if by_feet or getattr(area, "on", None) == "master":
        raise InputError(
            "areas of a shell with a thickness are measured on its mid-surface",
            where="area",
            found=area,
            allowed='FacetArea(), NodalArea(), CloudArea() by "rest" on the slave',
        )


def check_type(name: str, value: object, *types: type) -> None:
    """Raise `InputError` for a value that is not of one of these types."""
    if not isinstance(value, types):
        raise InputError(
            f"the {name} must be a {' or a '.join(type_.__name__ for type_ in types)}",
            where=name,
            found=type(value).__name__,
        )


MasterLaw = StressLaw | ForceLaw | FaceLaws
"""Laws of the master's side of a combined contact."""


def law_of(law: Law, master_law: MasterLaw | None, contact_type: str) -> Law:
    """Return the law of a contact: `law`, or both laws in series for type "combined".

    A `CombinedLaw` without `master_law` is returned itself.

    Raises
    ------
    InputError
        A combined contact without a law of the master, or another one with it.
    """
    if contact_type == "combined":
        if isinstance(law, CombinedLaw) and master_law is None:
            return law
        if master_law is None:
            raise InputError(
                "combined contact needs the characteristic of the master too",
                where="master_law",
                found=None,
                allowed="StressLaw, or ForceLaw on both sides",
            )
        if isinstance(master_law, FaceLaws):
            return master_law.with_slave(law)  # type: ignore[arg-type]  # checked there
        if isinstance(law, ForceLaw) and isinstance(master_law, ForceLaw):
            return forces_in_series(law, master_law)
        return CombinedLaw(law, master_law)  # type: ignore[arg-type]  # checked there
    if master_law is not None:
        raise InputError(
            "only combined contact has a law of the master",
            where="master_law",
            found=contact_type,
            allowed='contact_type "combined"',
        )
    return law


REMEDIES = {
    "thickness": "Give the slave a thickness, or the law one of its own",
    "mass": "Give the slave a mass, take Deforming.with_masses(slave) of one that deforms, or give "
    "the law an absolute damping",
}


def check_needs(law: Law, slave: Slave, master: Master) -> None:
    """Raise `InputError` for a slave or master that lacks what the law needs.

    `FaceLaws` need a patch of each number that they name; a nodal thickness or mass must be
    positive at each active point.
    """
    if isinstance(law, FaceLaws) and (master.faces is None or law.largest() >= master.n_pieces):
        allowed = "CAD" if master.faces is None else f"up to {master.n_pieces - 1}"
        raise InputError("no such face", where="law: faces", found=law.largest(), allowed=allowed)
    for name in ("thickness", "mass"):
        if not getattr(law, f"needs_{name}"):
            continue
        values = getattr(slave, name)
        n_missing = len(slave) if values is None else int((values[slave.active] <= 0.0).sum())
        if n_missing:
            raise InputError(
                f"the law needs the slave's nodal {name}",
                where="law",
                found=f"{n_missing} points without {name}",
                remedy=REMEDIES[name],
            )


def check_state(state: State, n_points: int, memories: tuple[int, int]) -> None:
    """Raise `InputError` for a state of another contact: its points or memories differ."""
    check_type("state", state, State)
    if len(state.status) != n_points:
        raise InputError(
            "the state belongs to another slave or quadrature",
            where="state",
            found=len(state.status),
            allowed=f"{n_points} points",
        )
    for name, owner, columns in zip(
        ("memory", "friction_memory"), ("law", "friction"), memories, strict=True
    ):
        shape = getattr(state, name).shape
        if shape[1] != columns:
            raise InputError(
                f"the state belongs to another {owner}",
                where=f"state.{name}",
                found=shape,
                allowed=f"({n_points}, {columns})",
            )


OPTIONS: dict[str, tuple[str | int, ...]] = {
    "search": ("intersection", "penetration"),
    "contact_type": ("slave", "master", "combined"),
    "on_edge": ("release", "hold"),
    "weights": ("rest", "area"),
    "quadrature": QUADRATURES,
    "through": ("release", "hold"),
    "foot": ("nearest", "tracked"),
}
"""Allowed values of each option."""


def check_choices(options: dict[str, str | int], has_thickness: bool) -> None:
    """Raise `InputError` for unknown values of options, and options that exclude each other.

    `through="hold"` needs paths, so no search by penetration; a shell with a thickness excludes it,
    and tracked feet.
    """
    for name, value in options.items():
        allowed = OPTIONS[name]
        if isinstance(value, bool) or value not in allowed:
            raise InputError(
                f"unknown {name}", where=name, found=value, allowed=", ".join(map(repr, allowed))
            )
    if options["through"] == "hold" and options["search"] == "penetration":
        raise InputError(
            "a search by penetration does not know where points enter, and cannot hold them there",
            where="through",
            found=options["through"],
            allowed='through="release", or search="intersection"',
        )
    if has_thickness and (options["foot"] == "tracked" or options["through"] == "hold"):
        raise InputError(
            "a shell with a thickness is pushed by the nearest wall",
            where="shell_thickness",
            found='foot="tracked"' if options["foot"] == "tracked" else 'through="hold"',
            allowed='no shell_thickness, or foot="nearest" and through="release"',
        )
