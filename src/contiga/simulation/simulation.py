"""A whole simulation: bodies, slaves, contacts, times. Never changes in a run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contiga.contact.contact import Contact
from contiga.dynamics.prescribed import BodyMotion, SlaveMotion
from contiga.errors import InputError
from contiga.masters.protocol import Master
from contiga.records import FloatArray
from contiga.simulation.fingerprint import fingerprint_of
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


@dataclass(frozen=True)
class Simulation:
    """What a run needs.

    Parameters
    ----------
    title : of reports
    units : names of the length, mass and time units; empty where not said
    times : (n,) increasing; the first is the start
    bodies, slaves : by name
    contacts : one or more
    output : what to write
    case_text : the resolved case, written beside the results
    base_folder : of the case file

    Raises
    ------
    InputError
        Times that do not increase, contacts that name nothing or share a name.
    """

    title: str
    times: FloatArray
    bodies: dict[str, BodyPart]
    slaves: dict[str, SlavePart]
    contacts: tuple[ContactPart, ...]
    units: tuple[str, str, str] = ("", "", "")
    output: OutputOptions = field(default_factory=OutputOptions)
    case_text: str = ""
    base_folder: Path = Path()

    def __post_init__(self) -> None:
        times = np.asarray(self.times, dtype=np.float64)
        if times.ndim != 1 or len(times) == 0 or not np.isfinite(times).all():
            raise InputError(
                "the times must be finite numbers, one or more", where="times", found=times.shape
            )
        if (np.diff(times) <= 0.0).any():
            raise InputError("the times must increase", where="times")
        names = [part.name for part in self.contacts]
        if not names or len(set(names)) < len(names):
            raise InputError(
                "there must be contacts, each with a name of its own", where="contacts", found=names
            )
        for part in self.contacts:
            _check_name("master", part.master, self.bodies)
            _check_name("slave", part.slave, self.slaves)

    def fingerprint(self) -> str:
        """Of all that decides the results: see `contiga.simulation.fingerprint`."""
        return fingerprint_of(self)


def _check_name(role: str, name: str, known: Iterable[str]) -> None:
    if name not in list(known):
        raise InputError(
            f"a contact names a {role} that is not there",
            where=f"contacts: {role}",
            found=name,
            allowed=", ".join(map(repr, known)),
        )
