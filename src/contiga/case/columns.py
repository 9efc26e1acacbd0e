"""Columns of the history of a case, known before it is built."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from contiga.case.belt_spec import BeltSpec
from contiga.case.contact_spec import ContactSpec
from contiga.case.device_spec import SlipRingSpec
from contiga.case.gas_spec import GasSpec
from contiga.case.joint_spec import JointSpec
from contiga.case.sensor_spec import PointSensorSpec, RelativeSensorSpec, SensorSpec
from contiga.case.spring_spec import SpringSpec
from contiga.dynamics.belt import BeltEnd
from contiga.dynamics.joints import KINDS
from contiga.dynamics.springs import Spring
from contiga.io.channels import channel_names
from contiga.simulation.gas import GAS_COLUMNS
from contiga.simulation.history import BODY_COLUMNS, STATUS_OF_COLUMN
from contiga.simulation.joints import JOINT_LAW_COLUMNS, REACTION_COLUMNS
from contiga.simulation.sensor import RELATIVE_COLUMNS, SENSOR_COLUMNS
from contiga.simulation.springs import DEVICE_COLUMNS, SLIP_RING_COLUMNS, SPRING_COLUMNS
from contiga.simulation.trigger import TRIGGER_COLUMNS

_OF_CONTACTS = (
    *("n_contact", "max_penetration", "force_x", "force_y", "force_z", "force"),
    *("moment_x", "moment_y", "moment_z", "area", "n_clusters", "mean_pressure", "max_pressure"),
    *("centre_x", "centre_y", "centre_z", "work", "energy_stored", "energy_hysteresis"),
    *(
        "energy_damping",
        "energy_friction",
        "energy_error",
        "wall_time",
        *STATUS_OF_COLUMN,
        "n_unproved",
    ),
    "n_tunnelled",
)
_OF_FRICTION = ("friction_x", "friction_y", "friction_z")
_OF_SYSTEM = (
    *("kinetic", "strain", "contact", "friction", "damping", "hysteresis"),
    *("external", "total", "error"),
)


class Tables(Protocol):
    """The tables of a `Case` that its columns depend on."""

    @property
    def body(self) -> Sequence[Any]:
        """Bodies, with `name` and `motion`."""

    @property
    def slave(self) -> Sequence[Any]:
        """Slaves, with `motion`."""

    @property
    def contact(self) -> Sequence[ContactSpec]: ...

    @property
    def sensor(self) -> Sequence[SensorSpec]: ...

    @property
    def spring(self) -> Sequence[SpringSpec]: ...

    @property
    def slip_ring(self) -> Sequence[SlipRingSpec]: ...

    @property
    def belt(self) -> Sequence[BeltSpec]: ...

    @property
    def joint(self) -> Sequence[JointSpec]: ...

    @property
    def gas(self) -> Sequence[GasSpec]: ...

    @property
    def deforms(self) -> bool:
        """Whether a slave is made of elements."""


def columns_of_case(case: Tables) -> list[str]:
    """Return the columns of the history of a run, without the time.

    The columns of a single contact have their bare names, as in the file, and also
    ``<contact>.<name>``. Columns of filtered accelerations are included, although a run whose steps
    are too long for the filter leaves them out.

    >>> import contiga as cg
    >>> columns = columns_of_case(cg.load_case("case.toml"))
    >>> [name in columns for name in ("force", "head-pad.force", "head.vz", "head_cg.a", "tail.vz")]
    [True, True, True, True, False]
    """
    columns: list[str] = []
    for contact in case.contact:
        names = [*_OF_CONTACTS, *(() if contact.friction is None else _OF_FRICTION)]
        if len(case.contact) == 1:
            columns += names
        columns += [f"{contact.title}.{name}" for name in names]
    for sensor in case.sensor:
        by_measure = RELATIVE_COLUMNS if isinstance(sensor, RelativeSensorSpec) else SENSOR_COLUMNS
        names = [name for measure in sensor.instance.measures for name in by_measure[measure]]
        if isinstance(sensor, PointSensorSpec) and sensor.filter is not None:
            names += ["filtered_ax", "filtered_ay", "filtered_az", "filtered_a"]
        if getattr(sensor, "trigger", None) is not None:
            names += TRIGGER_COLUMNS
        columns += [f"{sensor.name}.{name}" for name in names]
    springs: dict[str, Spring | BeltEnd] = {
        spec.instance.name: spec.instance for spec in case.spring
    }
    for belt in case.belt:
        springs |= {f"{belt.name} {end}": spec.instance for end, spec in belt.webbing.items()}
    for spring_name, spring in springs.items():
        names = [*SPRING_COLUMNS, *(["filtered_force"] if spring.filter else [])]
        names += DEVICE_COLUMNS if any(spring.devices) else ()
        columns += [f"{spring_name}.{name}" for name in names]
    columns += [
        f"{ring.instance.name}.{name}" for ring in case.slip_ring for name in SLIP_RING_COLUMNS
    ]
    for joint in (spec.instance for spec in case.joint):
        names = [*REACTION_COLUMNS, *KINDS[joint.kind].coordinates]
        names += [f"{key}_{name}" for key in joint.laws for name in JOINT_LAW_COLUMNS]
        columns += [f"{joint.name}.{name}" for name in names]
    columns += [f"{chamber.name}.{name}" for chamber in case.gas for name in GAS_COLUMNS]
    free_bodies = [body.name for body in case.body if body.motion.by_forces]
    columns += [f"{name}.{column}" for name in free_bodies for column in BODY_COLUMNS]
    nodes_move = case.deforms or any(slave.motion.by_forces for slave in case.slave)
    if free_bodies or case.spring or nodes_move:
        columns += [f"energy.{name}" for name in _OF_SYSTEM]
    if case.deforms:
        columns += ["energy.hourglass", "energy.viscosity"]
    if case.gas:
        columns.append("energy.gas")
    return columns


def channels_of_case(case: Tables) -> set[str]:
    """Return the channels of a run of the case: its columns, and channels derived from them."""
    contacts = [contact.title for contact in case.contact]
    laws = ((contact.title, contact.law) for contact in case.contact)
    layers = [title for title, law in laws if law is not None and law.kind == "stress"]
    return channel_names(columns_of_case(case), contacts, layers)


def criteria_of_case(case: Tables) -> list[str]:
    """Return the criteria that the sensors of a case ask for: ``<sensor>.<criterion>``."""
    sensors = [spec.instance for spec in case.sensor]
    return [f"{sensor.name}.{name}" for sensor in sensors for name in sensor.criteria]
