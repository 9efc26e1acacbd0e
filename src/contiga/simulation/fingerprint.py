"""Identify a simulation by a digest of all that decides its results.

A checkpoint carries it, so that a run never goes on from the steps of another case. File names
are taken relative to the folder of the case: a folder that was moved is still the same case.
"""

from __future__ import annotations

import json
import re
from typing import NamedTuple

from contiga.contact.contact import Contact
from contiga.dynamics.free import Dependent
from contiga.dynamics.prescribed import pose_at
from contiga.dynamics.shapes import ControlPoints
from contiga.dynamics.stepping import AutoSteps, ended
from contiga.simulation.model import Model
from contiga.simulation.things import Things
from contiga.slaves.slave import Slave

# The end of a run does not distinguish cases: its times do, as far as they go.
_END_LINE = re.compile(r"^(\[time\]\n(?:(?!\[).*\n)*?)end = .*\n", re.M)
# Nor do entries that concern only reports and plots.
_PRESENTATION = re.compile(
    r"^title = .*\n|^report = (true|false)\n|^(plot|reference) = \[\]\n"
    r"|\n\[\[(plot|reference)\]\]\n((?!\[).+\n)*",
    re.M,
)


class Identity(NamedTuple):
    """The digest of a simulation, with parts that it could not include."""

    fingerprint: str
    unknown: tuple[str, ...]
    """Names of compiled code that affects the results and cannot be read."""


def fingerprint_of(model: Model, end: float | None = None) -> str:
    """Return the digest of `identity_of`."""
    return identity_of(model, end).fingerprint


def identity_of(model: Model, end: float | None = None) -> Identity:
    """Return the digest of a case and its inputs, and the names of code that it cannot include.

    Case, times, geometry, slaves, motions, contacts and output count; title, plots, references and
    whether there is a report do not. `end` replaces that of the run: a case that goes on for longer
    is the same until then. Raises `InputError` if the steps do not fit into the time until that
    end.
    """
    digest = _Digest()
    times = (model.stepping if end is None else ended(model.stepping, end)).planned()
    # The text of the case, with file names relative to its folder.
    folder = model.base_folder.resolve().as_posix()
    quoted = json.dumps(folder, ensure_ascii=False)[:-1]  # as the text has it: "/a/b
    text = model.case_text.replace(f"{quoted.rstrip('/')}/", '"')
    digest.text(_PRESENTATION.sub("", _END_LINE.sub(r"\1", text)))
    digest.arrays("times", times)
    output = model.output
    inside = tuple(output.fields), output.cells, output.interval
    digest.text(repr((output.every, tuple(output.formats), output.size, *inside)))
    digest.arrays("gravity", model.gravity)
    digest.text(repr((type(model.stepping).__name__, model.allow_unstable)))
    if model.settling is not None:
        digest.text(repr(model.settling))
    if isinstance(model.stepping, AutoSteps):
        digest.text(repr((model.stepping.safety, model.stepping.shortest)))
    digest.add_value([dict(model.springs), model.loads, model.sensors])
    if model.gas:
        digest.add_value(dict(model.gas))
    if model.slip_rings:
        digest.add_value(dict(model.slip_rings))
    if model.joints:
        digest.add_value(dict(model.joints))
    for name, part in model.bodies.items():
        digest.text(f"motion of {name}")
        if isinstance(part.motion, Dependent):
            digest.add_value(part.motion)
        else:
            digest.arrays("poses", *(pose_at(part.motion, float(t)) for t in times))
        if isinstance(part.motion, ControlPoints):
            digest.arrays("shapes", *(part.motion.control_points(float(t)) for t in times))
        part.body.digest(digest)
    for name, (slave, _) in model.slaves.items():
        digest.text(name)
        digest.slave(slave)
        model.mechanism.nodes[name].digest(digest, times)
    for pair in model.contacts:
        digest.text(repr((pair.name, pair.master, pair.slave)))
        digest.contact(pair.contact)
        if pair.contact.master is not model.bodies[pair.master].body:
            pair.contact.master.digest(digest)
        if pair.contact.slave is not model.slaves[pair.slave].slave:
            digest.slave(pair.contact.slave)
    return Identity(digest.hexdigest(), tuple(sorted(digest.unknown)))


class _Digest(Things):
    """A digest of a model; items enter with type and shape, so that none can pass for another."""

    def slave(self, slave: Slave) -> None:
        """Add points, connectivity, active points and nodal values of a slave to the digest."""
        nodal = slave.area, slave.thickness, slave.mass
        self.arrays("slave", slave.points, slave.facets, slave.quads, slave.active, *nodal)

    def contact(self, contact: Contact) -> None:
        """Add options, law, friction and area method of a contact to the digest."""
        options = contact.search, contact.contact_type, contact.on_edge, contact.through
        self.text(
            repr((*options, contact.foot, contact.depth, contact.weights, contact.quadrature))
        )
        if contact.half_thickness is not None:
            self.arrays("shell", contact.half_thickness)
        self.add_value(contact.law)
        self.add_value(contact.friction)
        self.add_value(contact.area)
