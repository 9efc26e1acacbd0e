"""A whole simulation: bodies, slaves, contacts, times. Never changes in a run."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from numpy.typing import NDArray

from contiga.geometry.body import Body
from contiga.geometry.trimesh import TriMesh
from contiga.io.slave import Slave
from contiga.motion.prescribed import BodyMotion, SlaveMotion
from contiga.records import FloatArray
from contiga.sim.contact import Contact


class BodyPart(NamedTuple):
    """A body and how it moves."""

    body: Body | TriMesh
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
        """Of all that decides the results: case, geometry, slaves, contacts, where things move."""
        digest = hashlib.sha256(self.case_text.encode())
        _add(digest, "times", self.times)
        for name, part in self.bodies.items():
            _add(digest, name, part.body.reference_point)
            _add(digest, "poses", *(part.motion.pose(float(t)) for t in self.times))
            _add_shape(digest, part.body)
        for name, (slave, motion) in self.slaves.items():
            _add(digest, name, slave.points, slave.area, slave.thickness, slave.mass, slave.active)
            _add(digest, "points", motion.points(float(self.times[-1])))
        for contact in self.contacts:
            law = contact.contact
            options = (law.search, law.contact_type, law.on_edge, type(law.law).__name__)
            digest.update(repr((contact.name, contact.master, contact.slave, *options)).encode())
        return digest.hexdigest()


def _add_shape(digest: hashlib._Hash, body: Body | TriMesh) -> None:
    if isinstance(body, TriMesh):
        _add(digest, f"mesh {body.normal_kind}", body.vertices, body.triangles)
        return
    for patch, loops in zip(body.patches, body.trims, strict=True):
        _add(digest, "patch", *patch.knots, patch.control_points, patch.weights)
        for curve in chain.from_iterable(loops or ()):
            _add(digest, "trim", curve.knots, curve.control_points, curve.weights)


def _add(digest: hashlib._Hash, label: str, *arrays: NDArray[Any] | None) -> None:
    """Add arrays under a label; their lengths are added too, so that none runs into the next."""
    digest.update(f"{label}:{len(arrays)}".encode())
    for array in arrays:
        digest.update(b"none" if array is None else str(array.shape).encode() + array.tobytes())
