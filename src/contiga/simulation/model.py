"""Define the model of a simulation: bodies, slaves, contacts and steps. Runs do not change it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import positive
from contiga.contact.contact import Contact
from contiga.contact.shape import shape_of
from contiga.display import Displayed, Facts
from contiga.dynamics.free import Dependent, Free, is_driven
from contiga.dynamics.gas import Chamber
from contiga.dynamics.joints import Joint
from contiga.dynamics.kinks import merge_kinks
from contiga.dynamics.linkage import OPEN, Fit, Linkage, check_fit, joint_ends
from contiga.dynamics.loads import Load
from contiga.dynamics.nodes import SlaveState
from contiga.dynamics.prescribed import BodyMotion, SlaveMotion, kinks_in, pose_at
from contiga.dynamics.pulses import check_covers
from contiga.dynamics.shapes import ControlPoints, ControlPointsOf
from contiga.dynamics.slip_rings import SlipRing
from contiga.dynamics.springs import Spring
from contiga.dynamics.stepping import Stepping
from contiga.errors import ContigaError, InputError
from contiga.geometry.net import net_of
from contiga.io.naming import check_name
from contiga.masters.protocol import Master
from contiga.matter.element_fields import FIELDS
from contiga.records import FloatArray, IndexArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.gas import GasSystem
from contiga.simulation.mechanism import Mechanism, mechanism_of
from contiga.simulation.sensor import (
    RELATIVE_MEASURES,
    SPRING_MEASURES,
    RelativeSensor,
    Sensor,
)
from contiga.simulation.settle import Settle
from contiga.simulation.slave_sensor import NodeSensor, SlaveSensor, nodes_of, slave_of
from contiga.slaves.slave import Slave

AnySensor = Sensor | RelativeSensor | SlaveSensor
COLUMN_NAME = "must have a name of its own: columns of the history are called by it"


class BodyPart(NamedTuple):
    """A body with its motion."""

    body: Master
    motion: BodyMotion | Dependent


class SlavePart(NamedTuple):
    """A slave with its motion."""

    slave: Slave
    motion: SlaveMotion | Dependent


class ContactPart(NamedTuple):
    """A contact between a body and a slave of the simulation, by their names."""

    name: str
    """Prefix of its columns in the history, if there are several contacts."""
    master: str
    """Name of the body."""
    slave: str
    """Name of the slave."""
    contact: Contact


class OutputOptions(NamedTuple):
    """The files that a run writes, and how often: ``Simulation(output=…)``.

    Examples
    --------
    >>> import contiga as cg
    >>> rarely = cg.OutputOptions(every=20, size=5.0)
    >>> rarely.formats, rarely.report
    (('vtkhdf', 'csv'), True)
    """

    every: int = 1
    """Steps from one set of fields to the next."""
    formats: tuple[str, ...] = ("vtkhdf", "csv")
    report: bool = True
    size: float | None = None
    """Longest side of the triangles of bodies in fields, length; as few triangles as follow the
    surface if omitted."""
    fields: tuple[str, ...] = tuple(FIELDS)
    """Element quantities in the fields of deforming slaves."""
    cells: bool = False
    """Whether facets also have these quantities, of the elements behind them, not nodal means."""
    interval: float | None = None
    """Time from one set of fields to the next, in place of `every`."""


class ShapeMotions:
    """Motions of the control points of bodies: by a table, or with a slave of splines."""

    def __init__(self, motions: Mapping[str, object]) -> None:
        kinds = ControlPoints | ControlPointsOf
        self.of = {name: motion for name, motion in motions.items() if isinstance(motion, kinds)}

    def points(self, body: str, time: float, slaves: Mapping[str, SlaveState]) -> FloatArray | None:
        """Return the control points (m, 3) of a body at a time; None if it keeps its shape."""
        motion = self.of.get(body)
        if isinstance(motion, ControlPointsOf):
            return slaves[motion.slave].matter["q"]
        return None if motion is None else motion.control_points(time)

    def velocity(
        self, body: str, time: float, slaves: Mapping[str, SlaveState]
    ) -> FloatArray | None:
        """Return the velocities (m, 3) of the control points; None if the body keeps its shape."""
        motion = self.of.get(body)
        if isinstance(motion, ControlPointsOf):
            return slaves[motion.slave].matter["q_velocity"]
        return None if motion is None else motion.control_velocity(time)

    def is_prescribed(self, body: str) -> bool:
        """Return whether a table moves the control points of a body, and so does work."""
        return isinstance(self.of.get(body), ControlPoints)

    def slave_of(self, body: str) -> str | None:
        """Return the slave whose degrees of freedom are the control points; None without."""
        motion = self.of.get(body)
        return motion.slave if isinstance(motion, ControlPointsOf) else None


@dataclass(frozen=True, kw_only=True, repr=False)
class Model(Displayed):
    """The checked input of a run. `contiga.Simulation` makes it and runs it.

    Raises
    ------
    InputError
        Contacts with unknown sides or with the same name; parts that do not fit together.
    """

    bodies: Mapping[str, BodyPart]
    slaves: Mapping[str, SlavePart]
    contacts: tuple[ContactPart, ...]
    stepping: Stepping
    gravity: FloatArray = field(default_factory=lambda: np.zeros(3))
    """(3,) acceleration of free bodies and nodes, world axes."""
    springs: Mapping[str, Spring] = field(default_factory=dict)
    slip_rings: Mapping[str, SlipRing] = field(default_factory=dict)
    joints: Mapping[str, Joint] = field(default_factory=dict)
    loads: tuple[Load, ...] = ()
    gas: Mapping[str, Chamber] = field(default_factory=dict)
    sensors: tuple[AnySensor, ...] = ()
    allow_unstable: bool = False
    """Whether steps longer than the critical one are allowed."""
    title: str = ""
    units: tuple[str, str, str] = ("", "", "")
    """Names of the length, mass and time units; empty if unknown."""
    output: OutputOptions = field(default_factory=OutputOptions)
    case_text: str = ""
    """The resolved case, written beside the results."""
    base_folder: Path = Path()
    """Folder of the case file."""
    findings: tuple[Finding, ...] = ()
    """Findings about its files from reading them; `check` reports them."""
    settling: Settle | None = None
    """How the model comes to rest before a run; None if it does not."""

    def __post_init__(self) -> None:
        names = [part.name for part in self.contacts]
        parts = {"bodies": self.bodies, "slaves": self.slaves, "contacts": names}
        parts |= {
            "springs": self.springs,
            "slip_rings": self.slip_rings,
            "joints": self.joints,
            "gas": self.gas,
            "sensors": [sensor.name for sensor in self.sensors],
        }
        for kind, named in parts.items():
            for name in named:
                check_name(name, f"{kind}: name")
        pulled = self.mechanism.masses and self.springs
        has_moving_parts = len(self.mechanism.free) or self.mechanism.deforms or pulled or self.gas
        if not (names or has_moving_parts) or len(set(names)) < len(names):
            raise InputError(
                "there must be contacts, each with a name of its own", where="contacts", found=names
            )
        for part in self.contacts:
            _check_name("master", part.master, self.bodies)
            _check_name("slave", part.slave, self.slaves)
        check_movers(self)
        check_shapes(self)
        check_settle(self)
        check_sensors(self)
        check_springs(self)
        check_gas(self)
        check_joints(self)
        check_triggers(self)
        if self.output.interval is not None:
            positive(self.output.interval, "output: interval")
        for name in self.output.fields:
            _check_name("field", name, FIELDS, "output: fields")

    @cached_property
    def driven_contacts(self) -> frozenset[str]:
        """Names of the contacts with a side that a prescribed motion drives."""
        system = self.mechanism
        return frozenset(
            part.name
            for part in self.contacts
            if is_driven(self.slaves[part.slave].motion)
            or system.root_of(part.master) in system.driven
            or system.carrier_of_slave.get(part.slave) in system.driven
        )

    @cached_property
    def shapes(self) -> ShapeMotions:
        """Motions of the control points of bodies."""
        return ShapeMotions({name: part.motion for name, part in self.bodies.items()})

    @cached_property
    def point_sensors(self) -> tuple[Sensor, ...]:
        """Sensors of points of one body."""
        return tuple(sensor for sensor in self.sensors if isinstance(sensor, Sensor))

    @cached_property
    def relative(self) -> tuple[RelativeSensor, ...]:
        """Sensors between two bodies."""
        return tuple(sensor for sensor in self.sensors if isinstance(sensor, RelativeSensor))

    @cached_property
    def triggered(self) -> tuple[Sensor | RelativeSensor, ...]:
        """Sensors that have a trigger."""
        every: list[Sensor | RelativeSensor] = [*self.point_sensors, *self.relative]
        return tuple(sensor for sensor in every if sensor.trigger is not None)

    @cached_property
    def fired_kinks(self) -> Mapping[str, FloatArray]:
        """Times (k,) from the firing of a trigger to kinks of its devices, and 0, by sensor."""
        kinks: dict[str, list[FloatArray]] = {
            sensor.name: [np.zeros(1)] for sensor in self.triggered
        }
        for spring in self.springs.values():
            if (pretensioner := spring.devices.pretensioner) is not None:
                kinks[pretensioner.trigger].append(pretensioner.kinks)
        for chamber in self.gas.values():
            for device in chamber.waiting.values():
                kinks[str(device.trigger)].append(device.kinks)
        return {name: np.unique(np.concatenate(times)) for name, times in kinks.items()}

    @cached_property
    def slave_sensors(self) -> tuple[SlaveSensor, ...]:
        """Sensors of slaves."""
        return tuple(sensor for sensor in self.sensors if isinstance(sensor, SlaveSensor))

    @cached_property
    def sensor_nodes(self) -> Mapping[str, IndexArray]:
        """Nodes (k,) that each sensor of a slave measures, by its name."""
        return {
            sensor.name: nodes_of(sensor, self.slaves[slave_of(sensor)].slave.points)
            for sensor in self.slave_sensors
        }

    @cached_property
    def mechanism(self) -> Mechanism:
        """The parts that forces move, and their masses."""
        parts = self.bodies, self.slaves, self.contacts, self.springs, self.loads, self.slip_rings
        return mechanism_of(*parts, gas=bool(self.gas))

    @cached_property
    def chambers(self) -> GasSystem:
        """The gas in slaves."""
        slaves = {name: part.slave for name, part in self.slaves.items()}
        return GasSystem(self.gas, slaves)

    @cached_property
    def origins(self) -> FloatArray:
        """Poses (n, 4, 4) of the bodies at the start."""
        poses = np.broadcast_to(np.eye(4), (len(self.bodies), 4, 4)).copy()
        for i, motion in self.mechanism.driven.items():
            poses[i] = pose_at(motion, self.stepping.start)
        return poses[self.mechanism.root]

    @cached_property
    def linkage(self) -> Linkage:
        """All joints as one system of constraints."""
        system = self.mechanism
        bodies = joint_ends(self.joints, system.index, system.root)
        rows = np.array([[system.row.get(i, -1) for i in pair] for pair in bodies.tolist()])
        return Linkage(
            self.joints, bodies, rows.reshape(-1, 2).astype(np.int32), self.origins, system.fixed
        )

    @cached_property
    def joint_fit(self) -> Fit:
        """Free bodies at the start, moved so that all joints are closed."""
        return self.linkage.fit(self.mechanism.start, self.origins)

    @cached_property
    def kinks(self) -> tuple[float, ...]:
        """Times of kinks and jumps of loads, inflators and motions: automatic steps end there."""
        bodies, slaves = self.bodies.values(), self.slaves.values()
        motions = [*(p.motion for p in bodies), *(p.motion for p in slaves)]
        movers: list[object] = [*motions, *self.loads, *self.gas.values()]
        return merge_kinks(map(kinks_in, movers), self.stepping.start, self.stepping.end)

    def _facts(self) -> Facts:
        planned = self.stepping.planned()
        return [
            ("bodies", ", ".join(self.bodies)),
            ("slaves", ", ".join(self.slaves)),
            ("contacts", ", ".join(part.name for part in self.contacts)),
            ("time", (float(planned[0]), float(planned[-1]))),
            ("steps", len(planned) - 1),
        ]


def column_prefixes(model: Model) -> dict[str, str]:
    """Return the prefix of the history columns of each contact, empty for a single contact."""
    several = len(model.contacts) > 1
    return {part.name: f"{part.name}." if several else "" for part in model.contacts}


def _check_name(role: str, name: str, names: Iterable[str], where: str = "") -> None:
    if name not in list(names):
        raise InputError(
            f"names a {role} that is not there",
            where=where or f"contacts: {role}",
            found=name,
            allowed=", ".join(map(repr, names)),
        )


def _check_column_name(
    name: str, used_names: Iterable[str], where: str, allowed: str, message: str = COLUMN_NAME
) -> None:
    """Raise `InputError` for a name in use: columns of the history have it as their prefix."""
    if name in used_names:
        raise InputError(message, where=where, found=name, allowed=allowed)


def check_settle(model: Model) -> None:
    """Raise `InputError` for bodies to come to rest that are unknown, not free or in motion."""
    for name in model.settling.bodies if model.settling is not None else ():
        _check_name("body", name, model.bodies, "settle: bodies")
        motion = model.bodies[name].motion
        if not isinstance(motion, Free):
            raise InputError(
                "is not free: its motion is prescribed", where="settle: bodies", found=name
            )
        if motion.velocity.any() or motion.spin.any():
            raise InputError(
                "comes to rest, and has a velocity at the start",
                where="settle: bodies",
                found=name,
                remedy="Leave it out: then it stays where it starts until the run begins",
            )


def check_shapes(model: Model) -> None:
    """Raise `InputError` for bodies that cannot change their shape as their motion prescribes.

    Contacts of such a body are tried with its first control points.
    """
    for name, motion in model.shapes.of.items():
        where = f"bodies[{name!r}]: motion"
        parts = [part for part in model.contacts if part.master == name]
        rest = (
            motion.points[0]
            if isinstance(motion, ControlPoints)
            else _control_points_at_rest(model, name)
        )
        try:
            for part in parts:
                shape_of(part.contact.master, part.contact.follows_feet, rest)
        except ContigaError as error:
            raise InputError(str(error), where=where) from error


def _control_points_at_rest(model: Model, name: str) -> FloatArray:
    """Return the control points (m, 3) at rest of a body that a slave's degrees of freedom move.

    Raises `InputError` unless the slave is a shell of splines whose patches the body has, with
    control points equal to 1e-9 of its size.
    """
    slave = model.shapes.slave_of(name)
    where = f"bodies[{name!r}]: motion"
    if slave is None or slave not in model.slaves:
        raise InputError(
            "names a slave that is not there",
            where=where,
            found=slave,
            allowed=", ".join(map(repr, model.slaves)),
        )
    net = getattr(getattr(model.mechanism.nodes[slave], "matter", None), "net", None)
    body = model.bodies[name].body.faces
    if net is None or body is None:
        raise InputError(
            "only a slave that deforms as a shell of splines has control points",
            where=where,
            found=slave,
            allowed="motion.Deforming(material=assemble_shell(…)) of the slave, and a body of the "
            "same patches",
        )
    body_net = net_of(body)
    is_same = len(body_net.control) == len(net.control) and all(
        np.array_equal(first, second)
        for first, second in zip(body_net.control, net.control, strict=True)
    )
    if not is_same or not np.allclose(body_net.points, net.points, rtol=0.0, atol=1e-9 * body.size):
        raise InputError(
            "the body must have the patches that the shell of the slave has",
            where=where,
            found=f"{len(body_net.points)} control points, and {len(net.points)} of the shell",
            allowed="cg.Body of the surfaces that assemble_shell was given",
        )
    return net.points


def check_springs(model: Model) -> None:
    """Raise `InputError` for springs and slip rings that share a name with other columns.

    Filters of springs without units are refused as well.
    """
    used_names = {*model.bodies, *(part.name for part in model.contacts), "energy"}
    used_names |= {sensor.name for sensor in model.sensors}
    for name in model.slip_rings:
        allowed = "not that of a body, a contact, a sensor or a spring"
        where = f"slip_rings[{name!r}]: name"
        _check_column_name(name, used_names | model.springs.keys(), where, allowed)
    for name, spring in model.springs.items():
        where = f"springs[{name!r}]"
        allowed = "not that of a body, a contact or a sensor"
        _check_column_name(name, used_names, f"{where}: name", allowed)
        if spring.filter and not all(model.units):
            raise InputError(
                "needs units: seconds must be known",
                where=f"{where}: filter",
                remedy='Give the simulation its units, as units=("mm", "g", "ms")',
            )


def check_gas(model: Model) -> None:
    """Raise `InputError` for chambers with a name in use, or that facets do not enclose."""
    used_names = {*model.bodies, *(part.name for part in model.contacts), "energy"}
    used_names |= {*model.springs, *model.slip_rings}
    used_names |= {sensor.name for sensor in model.sensors}
    for name in model.gas:
        allowed = "not that of a body, a contact, a spring, a slip ring or a sensor"
        _check_column_name(name, used_names, f"gas[{name!r}]: name", allowed)
    assert model.chambers.physics is not None


def check_joints(model: Model) -> None:
    """Refuse joints with a name in use, without a free body, or that cannot be closed.

    Raises
    ------
    InputError
        Such a joint; a body that its joints move at the start, although it must not settle.
    """
    if not model.joints:
        return
    used_names = {*model.bodies, *(part.name for part in model.contacts), "energy"}
    used_names |= {*model.springs, *model.slip_rings, *model.gas}
    used_names |= {sensor.name for sensor in model.sensors}
    for name in model.joints:
        allowed = "a name that no body, contact, spring, slip ring, gas or sensor has"
        message = "must have a name of its own: it names columns of the history"
        _check_column_name(name, used_names, f"joint {name!r}: name", allowed, message)
    fit = model.joint_fit
    check_fit(model.linkage, fit)
    if model.settling is None:
        return
    size = float(model.linkage.table.size[0])
    for k, i in enumerate(model.mechanism.free):
        name = list(model.bodies)[i]
        displacement = max(fit.moved[k] / size, fit.turned[k])
        if name not in model.settling.bodies and displacement > OPEN:
            raise InputError(
                "closing its joints moves it, and it is not to settle: it is moved by "
                f"{fit.moved[k]:.4g} and turned by {fit.turned[k]:.4g} rad",
                where="settle: bodies",
                found=name,
                remedy="Place it so that its joints are closed, or let it settle as well",
            )


def check_triggers(model: Model) -> None:
    """Raise `InputError` for devices that wait for an unknown sensor, or one without a trigger."""
    waiting = [
        (f"spring {name!r}: {device}", trigger)
        for name, spring in model.springs.items()
        for device, trigger in spring.devices.triggers.items()
    ]
    waiting += [
        (f"gas {name!r}: {place}", str(device.trigger))
        for name, chamber in model.gas.items()
        for place, device in chamber.waiting.items()
    ]
    sensor_names, trigger_names = (
        {sensor.name for sensor in model.sensors},
        {sensor.name for sensor in model.triggered},
    )
    for where, trigger in waiting:
        if trigger not in trigger_names:
            raise InputError(
                "has no trigger" if trigger in sensor_names else "no sensor of this name is there",
                where=f"{where}: trigger",
                found=trigger,
                allowed=", ".join(map(repr, sorted(trigger_names)))
                or "the name of a sensor with a trigger",
                remedy="Give that sensor a trigger" if trigger in sensor_names else None,
            )


def check_sensors(model: Model) -> None:
    """Raise `InputError` for sensors of unknown parts, or that share a name with other columns.

    Also refused are criteria and filters without units, forces between two bodies that no spring
    joins, sections of slaves without elements, and sensors of no node.
    """
    used_names = [*model.bodies, *(part.name for part in model.contacts), "energy"]
    for i, sensor in enumerate(model.sensors):
        where = f"sensors[{i}]"
        if isinstance(sensor, RelativeSensor):
            for body in sensor.between:
                _check_name("body", body, model.bodies, f"{where}: between")
            # Force and moment between two bodies are those of the springs between them.
            joined = (set(spring.between) for spring in model.springs.values())
            if set(SPRING_MEASURES) & set(sensor.measures) and set(sensor.between) not in joined:
                raise InputError(
                    "force and moment are those of springs, and none is between the two",
                    where=f"{where}: measures",
                    found=", ".join(sensor.measures),
                    allowed=", ".join(map(repr, RELATIVE_MEASURES)),
                )
        elif isinstance(sensor, SlaveSensor):
            # A section needs elements, and nodes on both sides.
            key = "node" if isinstance(sensor, NodeSensor) else "section"
            name = slave_of(sensor)
            _check_name("slave", name, model.slaves, f"{where}: {key}")
            if key == "section" and not model.mechanism.nodes[name].has_sections:
                raise InputError(
                    "the slave has no elements whose nodes carry a force",
                    where=f"{where}: section",
                    found=name,
                    allowed="a slave of finite elements that deforms",
                )
            nodes_of(sensor, model.slaves[name].slave.points)
        else:
            _check_name("body", sensor.body, model.bodies, f"{where}: body")
        if (sensor.criteria or getattr(sensor, "filter", None)) and not all(model.units):
            raise InputError(
                "need units: g and seconds must be known",
                where=f"{where}: {'criteria' if sensor.criteria else 'filter'}",
                remedy='Give the simulation its units, as units=("mm", "g", "ms")',
            )
        allowed = "not that of a body, a contact or another sensor"
        _check_column_name(sensor.name, used_names, f"{where}: name", allowed)
        used_names.append(sensor.name)


def check_movers(model: Model) -> None:
    """Raise `InputError` for contacts within one body, and for tables that do not cover the run."""
    system = model.mechanism
    for part in model.contacts:
        host = system.carrier_of_slave.get(part.slave)
        if host is not None and host == system.root_of(part.master):
            raise InputError(
                "its slave is attached to its master: they never touch anew",
                where=f"contacts: {part.name}",
                found=part.slave,
                remedy="Attach the slave to another body",
            )
    span = model.stepping.start, model.stepping.end
    movers: list[tuple[str, object]] = [
        (f"bodies[{name!r}]: motion", part.motion) for name, part in model.bodies.items()
    ]
    movers += [
        (f"slaves[{name!r}]: motion", getattr(part.motion, "motion", None))
        for name, part in model.slaves.items()
    ]
    loads = [(f"loads[{i}]", load) for i, load in enumerate(model.loads)]
    for name, slave in model.slaves.items():
        on_nodes = getattr(slave.motion, "loads", ())
        loads += [(f"slaves[{name!r}]: loads[{i}]", load) for i, load in enumerate(on_nodes)]
        driven = getattr(slave.motion, "driven", ())
        loads += [
            (f"slaves[{name!r}]: driven[{i}]", table.get("motion"))
            for i, table in enumerate(driven)
        ]
    for where, mover in (*movers, *loads):
        covered = getattr(mover, "span", None)
        if covered is not None:
            check_covers(covered, *span, where)
