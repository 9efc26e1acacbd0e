"""Make the parts of a simulation from user input, each checked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeVar

from contiga.arrays.layout import check_types
from contiga.dynamics.deforming import Deforming
from contiga.dynamics.free import Dependent
from contiga.dynamics.gas import Chamber
from contiga.dynamics.joints import Joint
from contiga.dynamics.prescribed import Fixed, Moved
from contiga.dynamics.shapes import ControlPoints, ControlPointsOf
from contiga.dynamics.slip_rings import SlipRing
from contiga.dynamics.springs import Spring
from contiga.errors import InputError
from contiga.masters.protocol import is_master
from contiga.simulation.model import BodyPart, ContactPart, SlavePart
from contiga.slaves.slave import Slave

Part = TypeVar("Part")


def by_name(where: str, parts: Any) -> Mapping[str, Any]:
    """Return `parts` unchanged; raise `InputError` if they are no mapping."""
    if not isinstance(parts, Mapping):
        raise InputError("must be given by name", where=where, found=parts, allowed="a dict")
    return parts


def body_part(name: str, body_or_pair: Any) -> BodyPart:
    """Return a body with its motion, from a body or a pair; without a motion it stays in place.

    Raises `InputError` for an object that is no master, and for a motion without pose and twist.
    """
    body, motion = _with_motion(body_or_pair)
    if not is_master(body):
        raise InputError(
            "expected a Body or TriMesh",
            where=f"bodies[{name!r}]",
            found=type(body).__name__,
            allowed="a Body, a TriMesh, an object of a class derived from contiga.Master, or (one "
            "of them, its motion)",
        )
    if isinstance(motion, Deforming):
        raise InputError(
            "a body is rigid",
            where=f"bodies[{name!r}]: motion",
            found="Deforming",
            allowed="what deforms is a slave: its nodes may touch bodies",
        )
    if not isinstance(motion, Dependent):
        _check_motion(f"bodies[{name!r}]", motion, "pose", "twist")
    return BodyPart(body, motion)


def slave_part(name: str, slave_or_pair: Any) -> SlavePart:
    """Return a slave with its motion, from a slave or a pair; without a motion it stays in place.

    The motion of a body carries all points of the slave. Raises `InputError` for an object that is
    no slave, and for a motion that cannot move one.
    """
    slave, motion = _with_motion(slave_or_pair)
    if not isinstance(slave, Slave):
        raise InputError(
            "expected a Slave",
            where=f"slaves[{name!r}]",
            found=type(slave).__name__,
            allowed="a Slave, or (one, its motion)",
        )
    if isinstance(motion, ControlPoints | ControlPointsOf):
        raise InputError(
            "only bodies have control points",
            where=f"slaves[{name!r}]: motion",
            found=type(motion).__name__,
            allowed="motion.Deforming, motion.Free or a motion that carries its points",
        )
    if isinstance(motion, Dependent):
        return SlavePart(slave, motion)
    if hasattr(motion, "pose"):
        _check_motion(f"slaves[{name!r}]", motion, "pose", "twist")
        return SlavePart(slave, Moved(slave.points, motion))
    _check_motion(f"slaves[{name!r}]", motion, "points", "velocities")
    return SlavePart(slave, motion)


def _with_motion(part_or_pair: Any) -> tuple[Any, Any]:
    """Return an object and its motion; one that is not a pair is at rest."""
    if isinstance(part_or_pair, tuple) and len(part_or_pair) == 2:
        return part_or_pair
    return part_or_pair, Fixed()


def _check_motion(where: str, motion: object, *methods: str) -> None:
    """Raise `InputError` for a motion without one of the methods."""
    for method in methods:
        if not callable(getattr(motion, method, None)):
            raise InputError(
                f"its motion has no {method}(t)",
                where=where,
                found=type(motion).__name__,
                allowed="one of contiga.motion, or an object with "
                + " and ".join(f"{name}(t)" for name in methods),
            )


def contact_parts(
    contacts: Any, bodies: Mapping[str, BodyPart], slaves: Mapping[str, SlavePart]
) -> tuple[ContactPart, ...]:
    """Return contacts with the names of their sides, by the identity of master and slave.

    A contact without a name is called "<master>-<slave>"; parts with names stay as they are. Raises
    `InputError` for a contact with sides that are not among `bodies` and `slaves`.
    """
    if not isinstance(contacts, Mapping | Sequence):
        raise InputError(
            "must be several", where="contacts", found=contacts, allowed="a list, or a dict by name"
        )
    named = (
        contacts.items() if isinstance(contacts, Mapping) else ((None, item) for item in contacts)
    )
    parts = []
    for name, contact in named:
        if isinstance(contact, ContactPart):
            parts.append(contact)
            continue
        master = _name_of("master", contact, ((n, part.body) for n, part in bodies.items()))
        slave = _name_of("slave", contact, ((n, part.slave) for n, part in slaves.items()))
        parts.append(ContactPart(name or f"{master}-{slave}", master, slave, contact))
    return tuple(parts)


def _name_of(role: str, contact: Any, parts: Iterable[tuple[str, object]]) -> str:
    """Return the name of the part that is the same object as a side of a contact.

    `role` is "master" or "slave"; raises `InputError` if there is none.
    """
    part = getattr(contact, role, None)
    for name, candidate in parts:
        if part is not None and candidate is part:
            return name
    raise InputError(
        f"its {role} is none of the simulation's",
        where="contacts",
        found=type(contact).__name__,
        allowed="a Contact made with one of the bodies and one of the slaves",
    )


def spring_parts(parts: Any) -> dict[str, Spring]:
    """Return springs by name, from a dict, a list or one of them."""
    return _named_parts("springs", parts, Spring)


def slip_ring_parts(parts: Any) -> dict[str, SlipRing]:
    """Return slip rings by name, from a dict, a list or one of them."""
    return _named_parts("slip_rings", parts, SlipRing)


def joint_parts(parts: Any) -> dict[str, Joint]:
    """Return joints by name, from a dict, a list or one of them."""
    return _named_parts("joints", parts, Joint)


def gas_parts(parts: Any) -> dict[str, Chamber]:
    """Return chambers of gas by name, from a dict, a list or one of them."""
    named = _named_parts("gas", parts, Chamber)
    return {name: chamber.called(name) for name, chamber in named.items()}


def _named_parts(kind: str, parts: Any, of: type[Part]) -> dict[str, Part]:
    """Return parts of one type by name, from a dict, a list or a single part.

    In a list a part has its own name, or one made of kind and number, as "spring_0".

    Raises
    ------
    InputError
        Parts of another type, or two of one name.
    """
    if isinstance(parts, Mapping):
        named = list(parts.items())
    else:
        is_single = isinstance(parts, of) or not isinstance(parts, Sequence)
        named = [
            (getattr(part, "name", "") or f"{kind[:-1]}_{i}", part)
            for i, part in enumerate([parts] if is_single else parts)
        ]
    for name, part in named:
        if not isinstance(part, of):
            raise InputError(
                f"must be {kind}",
                where=f"{kind}[{name!r}]",
                found=type(part).__name__,
                allowed=f"a list of contiga.{of.__name__}, or a dict by name",
            )
    if len({name for name, _ in named}) < len(named):
        raise InputError(
            f"{kind} must have names of their own", where=kind, found=[n for n, _ in named]
        )
    return dict(named)


def parts_of_kind(where: str, items: Any, *kinds: type[Part]) -> tuple[Part, ...]:
    """Return loads or sensors as a tuple, also a single one; raise `InputError` for other types."""
    parts = tuple(items) if isinstance(items, Sequence) else (items,)
    allowed = f"a list of contiga.{' or contiga.'.join(kind.__name__ for kind in kinds)}"
    check_types(kinds, parts, where, f"must be {where}", allowed)
    return parts
