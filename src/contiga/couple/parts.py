"""Make the contacts between masters and slaves on bodies of a MuJoCo model, each checked."""

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
    """Return contacts with the names of their sides, in the order given.

    Raises
    ------
    InputError
        An object that is no master or slave; a slave without a contact; contacts of other sides, or
        with the same name; both sides on one body.
    """
    for name, carrier in masters.items():
        _check("masters", name, carrier.carried, is_master(carrier.carried), "a Body or a TriMesh")
    for name, carrier in slaves.items():
        _check("slaves", name, carrier.carried, isinstance(carrier.carried, Slave), "a Slave")
    bodies = {name: BodyPart(carrier.carried, Fixed()) for name, carrier in masters.items()}
    points = {name: slave_part(name, carrier.carried) for name, carrier in slaves.items()}
    parts = contact_parts(contacts, bodies, points)
    names = [part.name for part in parts]
    if not names or len(set(names)) < len(names):
        raise InputError(
            "there must be contacts, each with a name of its own",
            where="contacts",
            found=names,
            remedy="Two of one pair need names: contacts={name: contact}",
        )
    idle = slaves.keys() - {part.slave for part in parts}
    if idle:
        raise InputError(
            "a slave has no contact",
            where="slaves",
            found=", ".join(name for name in slaves if name in idle),
            remedy="Make a Contact with it, or leave it out",
        )
    for part in parts:
        pair = masters[part.master].body, slaves[part.slave].body
        if model.body_weldid[pair[0]] == model.body_weldid[pair[1]]:
            raise InputError(
                "its slave and its master stand on one body: they never touch anew",
                where=f"contacts: {part.name}",
                found=" and ".join(repr(model.body(body).name) for body in pair),
                remedy="Put the slave on another body, or give one of the two a joint",
            )
    return parts


def _check(where: str, name: str, value: object, fits: bool, allowed: str) -> None:
    if not fits:
        raise InputError(
            "must be one",
            where=f"{where}[{name!r}]",
            found=type(value).__name__,
            allowed=f'{allowed}, or (one, "name of a MuJoCo body")',
        )
