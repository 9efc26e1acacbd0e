"""Contacts between what bodies of a MuJoCo model carry, each checked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contiga.couple.carriers import Carrier
from contiga.dynamics.prescribed import Fixed
from contiga.errors import InputError
from contiga.masters.protocol import is_master
from contiga.simulation.model import BodyPart, ContactPart
from contiga.simulation.parts import contact_parts, slave_part
from contiga.slaves.slave import Slave


def parts_of(
    model: Any, masters: Mapping[str, Carrier], slaves: Mapping[str, Carrier], contacts: Any
) -> tuple[ContactPart, ...]:
    """Contacts with the names of their sides.

    Raises
    ------
    InputError
        What is no master or slave; a slave that stands in no contact; contacts of others, or of one
        name; two sides on one body.
    """
    for name, one in masters.items():
        _check("masters", name, one.carried, is_master(one.carried), "a Body or a TriMesh")
    for name, one in slaves.items():
        _check("slaves", name, one.carried, isinstance(one.carried, Slave), "a Slave")
    bodies = {name: BodyPart(one.carried, Fixed()) for name, one in masters.items()}
    points = {name: slave_part(name, one.carried) for name, one in slaves.items()}
    parts = contact_parts(contacts, bodies, points)
    names = [part.name for part in parts]
    if not names or len(set(names)) < len(names):
        raise InputError(
            "there must be contacts, each with a name of its own",
            where="contacts",
            found=names,
            remedy="Two of one pair need names: contacts={name: contact}",
        )
    _check_used(slaves, [part.slave for part in parts])
    for part in parts:
        _check_apart(model, part, (masters[part.master].body, slaves[part.slave].body))
    return parts


def _check(where: str, name: str, value: object, fits: bool, allowed: str) -> None:
    if not fits:
        raise InputError(
            "must be one",
            where=f"{where}[{name!r}]",
            found=type(value).__name__,
            allowed=f'{allowed}, or (one, "name of a MuJoCo body")',
        )


def _check_used(slaves: Mapping[str, Carrier], used: list[str]) -> None:
    idle = [name for name in slaves if name not in used]
    if idle:
        raise InputError(
            "a slave has no contact",
            where="slaves",
            found=", ".join(idle),
            remedy="Make a Contact with it, or leave it out",
        )


def _check_apart(model: Any, part: ContactPart, pair: tuple[int, int]) -> None:
    if model.body_weldid[pair[0]] == model.body_weldid[pair[1]]:
        raise InputError(
            "its slave and its master stand on one body: they never touch anew",
            where=f"contacts: {part.name}",
            found=" and ".join(repr(model.body(body).name) for body in pair),
            remedy="Put the slave on another body, or give one of the two a joint",
        )
