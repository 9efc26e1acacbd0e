"""Build the simulation of a checked case: read files, make shapes, resolve references."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.case.contact_build import area_of, contact_of
from contiga.case.deform_spec import DeformSpec
from contiga.case.geometry_spec import FileGeometry
from contiga.case.motion_spec import AttachedSpec, FreeSpec, SeriesSpec
from contiga.case.part_cache import PartCache
from contiga.case.placement_order import order_of, references
from contiga.case.points_spec import BodyPoints
from contiga.case.problems import ErrorCollector, Fault
from contiga.case.reading import warnings_as_findings
from contiga.case.schema import BodySpec, Case, SlaveSpec
from contiga.case.slave_motion import (
    check_elements,
    nodes_named,
    prescribed_motion_of,
    slave_motion,
)
from contiga.case.surface_spec import RefineSpec, meshed_of, surface_of
from contiga.case.toml import resolved_toml
from contiga.contact.preloaded import preload_search
from contiga.dynamics.belt import Belt
from contiga.dynamics.free import Attached, Dependent
from contiga.dynamics.gas import Chamber
from contiga.dynamics.prescribed import BodyMotion, Fixed, pose_at
from contiga.dynamics.springs import Spring
from contiga.errors import CaseError
from contiga.io.cad.formats import is_cached
from contiga.masters.body import Body
from contiga.masters.protocol import Master
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.clock import Clock
from contiga.simulation.model import BodyPart, ContactPart, OutputOptions, SlavePart
from contiga.simulation.output_folder import keep_case_file
from contiga.simulation.result import Result
from contiga.simulation.run import RunOptions, carry_out
from contiga.simulation.simulation import Simulation
from contiga.slaves.slave import Slave
from contiga.triangles.trimesh import TriMesh

DEFAULT = RunOptions()


def build(case: Case, *, parts: PartCache | None = None) -> Simulation:
    """Return the simulation that a case describes.

    Parameters
    ----------
    case : the checked case
    parts : cache of bodies and slaves that several cases have in common; none if omitted

    Raises
    ------
    InputError, MissingPackageError
        A file cannot be read, a slave lacks what a law or an area needs; the message has the key
        of the case, and lists all errors at once. Nothing has been written yet.

    Examples
    --------
    >>> import contiga as cg
    >>> cg.build(cg.load_case("case.toml")).bodies["head"].body.closed
    True
    """
    errors = ErrorCollector(str(case.file), case.origins)
    parts_of_case = _build_parts(case, PartCache() if parts is None else parts, errors)
    errors.raise_all()
    output = case.output
    return Simulation(
        gravity=case.world.gravity,
        allow_unstable=case.time.allow_unstable,
        settling=None if case.settle is None else case.settle.instance,
        loads=[spec.instance for spec in case.load],
        springs=parts_of_case.springs,
        slip_rings=[spec.instance for spec in case.slip_ring],
        joints=[spec.instance for spec in case.joint],
        gas=parts_of_case.gas,
        sensors=[spec.instance for spec in case.sensor],
        title=case.title,
        units=(case.units.length, case.units.mass, case.units.time),
        stepping=case.time.stepping(),
        bodies=parts_of_case.bodies,
        slaves=parts_of_case.slaves,
        contacts=parts_of_case.contacts,
        output=OutputOptions(
            output.every,
            tuple(output.formats),
            output.report,
            output.size,
            tuple(output.fields),
            output.cells,
            output.interval,
        ),
        case_text=resolved_toml(case),
        base_folder=case.file.parent,
        findings=parts_of_case.findings,
    )


class _Parts(NamedTuple):
    """The parts of a simulation that could be made."""

    springs: dict[str, Spring]
    gas: dict[str, Chamber]
    bodies: dict[str, BodyPart]
    slaves: dict[str, SlavePart]
    contacts: tuple[ContactPart, ...]
    findings: tuple[Finding, ...]
    """Findings about the files, in the order in which they were read."""


def _build_parts(case: Case, cache: PartCache, errors: ErrorCollector) -> _Parts:
    """Return the parts of a case; their errors are added to `errors`, those of cheap checks first.

    Parts with an error are left out, with the contacts that they have.
    """
    springs: dict[str, Spring] = {}

    def add_spring(name: str, spring: Spring) -> None:
        if name in springs:
            raise CaseError(
                "another spring has this name",
                found=name,
                remedy="Give each spring a name of its own",
            )
        springs[name] = spring

    for i, spring_spec in enumerate(case.spring):
        with errors.at(f"spring[{i}].name"):
            add_spring(spring_spec.instance.name, spring_spec.instance)
    units = case.units.length, case.units.mass, case.units.time
    slave_specs = {slave.name: slave for slave in case.slave}
    gas: dict[str, Chamber] = {}
    for i, gas_spec in enumerate(case.gas):
        with errors.at(f"gas[{i}]"):
            nodes_of = partial(nodes_named, slave_specs[gas_spec.slave])
            gas[gas_spec.name] = gas_spec.chamber(units, nodes_of)
    motions = _prescribed_motions(case, errors)
    findings: list[Finding] = []
    geometry = _placed_geometry(case, cache, errors, findings)
    bodies = _bodies(case, geometry, motions, errors)
    slaves: dict[str, SlavePart] = {}
    for i, slave_spec in enumerate(case.slave):
        slave, key = geometry.get(slave_spec.name), f"slave[{i}].motion"
        if slave is None:
            continue
        assert isinstance(slave, Slave)
        with errors.at(key):
            motion = slave_motion(slave_spec, slave, case, motions.get(key))
            slaves[slave_spec.name] = SlavePart(slave, motion)
    belts = _belts(case, geometry, motions, errors)
    slaves |= {name: SlavePart(belt.slave, belt.motion) for name, belt in belts.items()}
    for i, belt_spec in enumerate(case.belt):
        belt_springs: dict[str, Spring] = {}
        if belt_spec.name in belts:
            with errors.at(f"belt[{i}]"):
                belt_springs = belts[belt_spec.name].springs
        for name, spring in belt_springs.items():
            with errors.at(f"belt[{i}]"):
                add_spring(name, spring)
    has_area = {spec.name for spec in case.slave if spec.area is not None}
    contacts = []
    for i, spec in enumerate(case.contact):
        if spec.master in bodies and spec.slave in slaves:
            body, slave_part = bodies[spec.master].body, slaves[spec.slave]
            with errors.at(f"contact[{i}]"):
                area = area_of(spec, slave_part.slave, spec.slave in has_area)
                contact = contact_of(spec, case.sides(spec), body, slave_part, area)
                contacts.append(ContactPart(spec.title, spec.master, spec.slave, contact))
    return _Parts(springs, gas, bodies, slaves, tuple(contacts), tuple(findings))


def faults_of(case: Case) -> tuple[tuple[Fault, str], ...]:
    """Return the faults in the parts of a case, each with its key, the cheapest to find first."""
    errors = ErrorCollector(str(case.file), case.origins)
    _build_parts(case, PartCache(), errors)
    return errors.faults


def run(
    case: Case,
    out: str | Path | None = None,
    how: RunOptions = DEFAULT,
    *,
    parts: PartCache | None = None,
) -> Result:
    """Build a case and run it; the case with all defaults is written to `out`, too.

    Parameters
    ----------
    case : the checked case
    out : folder for the results; None keeps them in memory only
    how : options of the run; `on_finish` is called only if the case asks for a report
    parts : as `build`

    Raises
    ------
    InputError, MissingPackageError
        As `build`.
    OutputError
        As `Simulation.run`; also where the copy of the case would replace the case file.
    """
    clock = Clock()
    with clock.watching(), clock("total"), clock("build"):
        simulation = build(case, parts=parts)
        if out is not None:
            keep_case_file(Path(out), case.file, simulation.case_text)
    on_finish = how.on_finish if case.output.report else None
    return carry_out(simulation, out, how._replace(clock=clock, on_finish=on_finish))


def _prescribed_motions(case: Case, errors: ErrorCollector) -> dict[str, BodyMotion]:
    """Return the prescribed motions of bodies and slaves, by the key of the case: body[0].motion.

    A motion with an error is left out.
    """
    entries: list[tuple[str, Any]] = [
        *((f"body[{i}].motion", spec.motion) for i, spec in enumerate(case.body)),
        *((f"slave[{i}].motion", spec.motion) for i, spec in enumerate(case.slave)),
    ]
    motions = {}
    for key, motion in entries:
        if not isinstance(motion, FreeSpec | AttachedSpec | SeriesSpec | DeformSpec):
            with errors.at(key):
                motions[key] = prescribed_motion_of(motion, case)
    return motions


def _placed_geometry(
    case: Case, cache: PartCache, errors: ErrorCollector, findings: list[Finding]
) -> dict[str, Master | Slave]:
    """Return the bodies and slaves that can be made, by name, at their places before any motion.

    Warnings of readers of files are added to `findings`. Parts that are placed by one that cannot
    be made are left out without an error of their own. If CAD has to be read, the search is loaded
    meanwhile.
    """
    unit = case.units.length
    keys = {spec.name: f"body[{i}].{spec.source_key}" for i, spec in enumerate(case.body)}
    keys |= {spec.name: f"slave[{i}].{spec.source_key}" for i, spec in enumerate(case.slave)}
    # Results for files that have been read before are mostly cached.
    if any(
        isinstance(spec.geometry, FileGeometry) and not is_cached(Path(spec.geometry.file))
        for spec in case.body
    ):
        preload_search()  # while a worker loads the reader of CAD
    bodies: dict[str, Body | TriMesh] = {}  # before they are placed relative to others
    for body_spec in case.body:
        name = body_spec.name
        with errors.at(keys[name]), warnings_as_findings("body", name, findings):
            make = partial(_checked_body, body_spec, unit)
            bodies[name] = cache.part(body_spec.geometry, name, unit, make)
    parts: dict[str, Master | Slave] = {}
    before_then: dict[str, Master | Slave] = {}  # before the steps of `then`
    for name in order_of(case.parts):
        spec = case.parts[name]
        references_of_part = {reference for _, reference in references(spec)}
        if not references_of_part <= parts.keys() or (
            isinstance(spec, BodySpec) and name not in bodies
        ):
            continue  # the error of the part it is placed by is reported
        source = spec.source
        neighbours = before_then if source.then else parts
        with errors.at(keys[name]):
            if isinstance(spec, BodySpec):
                body = spec.geometry.place_part(bodies[name], neighbours)
                before_then[name], parts[name] = body, source.moved(body)
            else:
                masters = [contact.master for contact in case.contact if contact.slave == name]
                sizes = [bodies[master].size for master in masters if master in bodies]
                with warnings_as_findings("slave", name, findings):
                    slave = _slave(spec, unit, neighbours, sizes, cache)
                    before_then[name], parts[name] = slave, source.moved(slave)
    return parts


def _checked_body(spec: BodySpec, unit: str) -> Body | TriMesh:
    """Return the body of a table before it is placed by others; InputError if its check fails."""
    body = spec.geometry.body(spec.name, unit)
    body.check()
    return body


def _slave(
    spec: SlaveSpec,
    unit: str,
    parts: Mapping[str, Master | Slave],
    master_sizes: list[float],
    cache: PartCache,
) -> Slave:
    """Return the slave under its name in the case, placed, but for the steps of `then`.

    Nodal values of the case replace the values of its file at all nodes. `parts` are those placed
    already, `master_sizes` the sizes of the bodies that it has contacts with.
    """
    points, geometry, mesh = spec.points, spec.geometry, spec.mesh
    names = spec.name, unit
    if isinstance(points, BodyPoints):
        body = parts[points.body]
        assert not isinstance(body, Slave)
        slave = points.sampled(body, master_sizes)
    elif points is not None:
        slave = cache.part(points, *names, partial(points.slave, *names))
    else:
        assert geometry is not None
        if mesh is not None:
            slave = meshed_of(geometry, mesh, names, master_sizes)
        else:
            slave = surface_of(geometry, spec.refine or RefineSpec(), names)
    slave = spec.source.place_part(slave, parts)

    def nodal(value: float | None, values_of_file: FloatArray | None) -> FloatArray | None:
        return values_of_file if value is None else np.full(len(slave), value)

    return Slave(
        slave.points,
        slave.facets,
        area=nodal(spec.area, slave.area),
        thickness=nodal(spec.thickness, slave.thickness),
        mass=nodal(spec.mass, slave.mass),
        active=slave.active,
        name=spec.name,
        unit=slave.unit,
        cells=slave.cells,
        parts=slave.parts,
        elements=slave.elements,
        surfaces=slave.surfaces,
    )


def _bodies(
    case: Case,
    geometry: Mapping[str, Master | Slave],
    motions: Mapping[str, BodyMotion],
    errors: ErrorCollector,
) -> dict[str, BodyPart]:
    """Return the bodies with their motions, and with their masses if forces move them.

    A body whose motion or mass has an error is fixed, or attached without a mass, so that its
    contacts are checked all the same.
    """
    bodies = {}
    for i, spec in enumerate(case.body):
        body, motion, mass = geometry.get(spec.name), spec.motion, None
        if body is None:
            continue
        assert not isinstance(body, Slave)
        if spec.reference_point is not None:
            body = body.with_reference_point(spec.reference_point)
        if isinstance(motion, FreeSpec | AttachedSpec) and spec.mass is not None:
            with errors.at(f"body[{i}].mass"):
                mass = spec.mass.properties(body)
        motion_of_body: BodyMotion | Dependent | None = motions.get(f"body[{i}].motion")
        if isinstance(motion, AttachedSpec):
            motion_of_body = Attached(motion.body, mass)
        elif isinstance(motion, FreeSpec) and mass is not None:
            with errors.at(f"body[{i}].motion"):
                motion_of_body = motion.moved(mass)
        bodies[spec.name] = BodyPart(body, Fixed() if motion_of_body is None else motion_of_body)
    return bodies


def _belts(
    case: Case,
    geometry: Mapping[str, Master | Slave],
    motions: Mapping[str, BodyMotion],
    errors: ErrorCollector,
) -> dict[str, Belt]:
    """Return the belts over the bodies at their places at the start of the run.

    Prescribed motions, or those of carriers, bring bodies there. Belts with an error, or over
    bodies that could not be made, are left out.
    """
    if not case.belt:
        return {}
    specs = {spec.name: (spec, f"body[{i}].motion") for i, spec in enumerate(case.body)}
    bodies: dict[str, Master] = {}
    for name, body in geometry.items():
        if isinstance(body, Slave):
            continue
        # A body that is attached moves with its carrier.
        carrier, key = specs[name]
        chain = {name}
        while isinstance(carrier.motion, AttachedSpec) and carrier.motion.body not in chain:
            chain.add(carrier.motion.body)
            carrier, key = specs[carrier.motion.body]
        bodies[name] = body
        if key in motions:
            pose = pose_at(motions[key], case.time.start)
            if not np.array_equal(pose, np.eye(4)):
                bodies[name] = body.transformed(pose)
    belts = {}
    for i, spec in enumerate(case.belt):
        if not bodies.keys() >= {*spec.path.over}:
            continue  # their errors are reported
        with errors.at(f"belt[{i}]"):
            belt = spec.belt_over(bodies)
            check_elements(spec.name, belt.slave, belt.motion)
            belts[spec.name] = belt
    return belts


def belts_of(case: Case) -> dict[str, Belt]:
    """Return the belts of a case by name; bodies and slaves are built, contacts are not.

    Raises
    ------
    InputError, MissingPackageError
        As `build`.
    """
    errors = ErrorCollector(str(case.file), case.origins)
    motions = _prescribed_motions(case, errors)
    belts = _belts(case, _placed_geometry(case, PartCache(), errors, []), motions, errors)
    errors.raise_all()
    return belts
