"""A whole simulation: bodies, slaves, contacts, times. Never changes in a run."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from contiga.geometry.body import Body
from contiga.io.slave import Slave
from contiga.motion.prescribed import BodyMotion, SlaveMotion
from contiga.records import FloatArray
from contiga.sim.contact import Contact


class BodyPart(NamedTuple):
    """A body and how it moves."""

    body: Body
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

    def fingerprint(self) -> str:
        """Of the case text, the geometry and the slaves: changes when any of them does."""
        digest = hashlib.sha256(self.case_text.encode())
        digest.update(self.times.tobytes())
        for name, part in self.bodies.items():
            digest.update(name.encode())
            for patch in part.body.patches:
                digest.update(patch.control_points.tobytes())
                for knots in patch.knots:
                    digest.update(knots.tobytes())
        for name, slave in self.slaves.items():
            digest.update(name.encode())
            digest.update(slave.slave.points.tobytes())
        return digest.hexdigest()
