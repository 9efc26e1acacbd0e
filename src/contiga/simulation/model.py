"""What a simulation is made of: bodies, slaves, contacts, steps of time. Never changes in a run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from contiga.contact.contact import Contact
from contiga.dynamics.prescribed import BodyMotion, SlaveMotion
from contiga.dynamics.stepping import Stepping
from contiga.errors import InputError
from contiga.masters.protocol import Master
from contiga.shown import Facts, Shown
from contiga.slaves.slave import Slave


class BodyPart(NamedTuple):
    """A body and how it moves."""

    body: Master
    motion: BodyMotion


class SlavePart(NamedTuple):
    """A slave and how it moves."""

    slave: Slave
    motion: SlaveMotion


class ContactPart(NamedTuple):
    """A contact between a body and a slave of the simulation, by their names."""

    name: str
    master: str
    slave: str
    contact: Contact


class OutputOptions(NamedTuple):
    """What a run writes."""

    every: int = 1
    """Steps from one set of fields to the next."""
    formats: tuple[str, ...] = ("vtkhdf", "csv")
    report: bool = True


@dataclass(frozen=True, kw_only=True, repr=False)
class Model(Shown):
    """What a run needs, checked. `contiga.Simulation` makes it and runs it.

    Raises
    ------
    InputError
        Contacts that name nothing or share a name.
    """

    bodies: Mapping[str, BodyPart]
    slaves: Mapping[str, SlavePart]
    contacts: tuple[ContactPart, ...]
    stepping: Stepping
    title: str = ""
    units: tuple[str, str, str] = ("", "", "")
    """Names of the length, mass and time units; empty where not said."""
    output: OutputOptions = field(default_factory=OutputOptions)
    case_text: str = ""
    """The resolved case, written beside the results."""
    base_folder: Path = Path()
    """Of the case file."""

    def __post_init__(self) -> None:
        names = [part.name for part in self.contacts]
        if not names or len(set(names)) < len(names):
            raise InputError(
                "there must be contacts, each with a name of its own", where="contacts", found=names
            )
        for part in self.contacts:
            _check_name("master", part.master, self.bodies)
            _check_name("slave", part.slave, self.slaves)

    def _facts(self) -> Facts:
        planned = self.stepping.planned()
        return [
            ("bodies", ", ".join(self.bodies)),
            ("slaves", ", ".join(self.slaves)),
            ("contacts", ", ".join(part.name for part in self.contacts)),
            ("time", (float(planned[0]), float(planned[-1]))),
            ("steps", len(planned) - 1),
        ]


def _check_name(role: str, name: str, known: Iterable[str]) -> None:
    if name not in list(known):
        raise InputError(
            f"a contact names a {role} that is not there",
            where=f"contacts: {role}",
            found=name,
            allowed=", ".join(map(repr, known)),
        )
