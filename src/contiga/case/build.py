"""Build the simulation of a checked case: read files, make shapes, resolve references."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.case.contact_made import area_of, contact_of
from contiga.case.deform_spec import DeformSpec
from contiga.case.geometry_spec import FileGeometry
from contiga.case.motion_spec import AttachedSpec, FreeSpec, SeriesSpec
from contiga.case.output_spec import OutputSpec
from contiga.case.part_cache import PartCache
from contiga.case.points_spec import BodyPoints
from contiga.case.problems import Fault, Together
from contiga.case.reading import told_of
from contiga.case.schema import BodySpec, Case, SlaveSpec
from contiga.case.slave_motion import check_elements, nodes_named, prescribed, slave_motion
from contiga.case.standing import order_of, references
from contiga.case.surface_spec import RefineSpec, meshed_of, surface_of
from contiga.case.toml import resolved_toml
from contiga.contact.preloaded import preload_search
from contiga.dynamics.belt import Belt
from contiga.dynamics.free import Attached, Dependent
from contiga.dynamics.gas import Chamber
from contiga.dynamics.prescribed import BodyMotion, Fixed, pose_at
from contiga.dynamics.springs import Spring
from contiga.errors import CaseError
from contiga.io.cad.formats import was_read
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
    parts : bodies and slaves that cases before it had in common with it; none if omitted

    Raises
    ------
    InputError, MissingPackageError
        A file cannot be read, a slave lacks what a law or an area needs; the message says the key
        of the case, and tells everything wrong at once. Nothing has been written by then.

    Examples
    --------
    >>> import contiga as cg
    >>> cg.build(cg.load_case("case.toml")).bodies["head"].body.closed
    True
    """
    wrong = Together(str(case.file), case.origins)
    made = _pieces(case, PartCache() if parts is None else parts, wrong)
    wrong.tell()
    return Simulation(
        gravity=case.world.gravity,
        allow_unstable=case.time.allow_unstable,
        settling=None if case.settle is None else case.settle.made,
        loads=[spec.made for spec in case.load],
        springs=made.springs,
        slip_rings=[spec.made for spec in case.slip_ring],
        joints=[spec.made for spec in case.joint],
        gas=made.gas,
        sensors=[spec.made for spec in case.sensor],
        title=case.title,
        units=(case.units.length, case.units.mass, case.units.time),
        stepping=case.time.stepping(),
        bodies=made.bodies,
        slaves=made.slaves,
        contacts=made.contacts,
        output=_output(case.output),
        case_text=resolved_toml(case),
        base_folder=case.file.parent,
        findings=made.findings,
    )


class _Pieces(NamedTuple):
    """The parts of a simulation that could be made."""

    springs: dict[str, Spring]
    gas: dict[str, Chamber]
    bodies: dict[str, BodyPart]
    slaves: dict[str, SlavePart]
    contacts: tuple[ContactPart, ...]
    findings: tuple[Finding, ...]
    """Findings about the files, in the order in which they were read."""


def _output(spec: OutputSpec) -> OutputOptions:
    formats, fields = tuple(spec.formats), tuple(spec.fields)
    return OutputOptions(
        spec.every, formats, spec.report, spec.size, fields, spec.cells, spec.interval
    )


def _pieces(case: Case, cache: PartCache, wrong: Together) -> _Pieces:
    # Cheap checks come first in the list of errors.
    springs = _springs(case, wrong)
    gas = _gas(case, wrong)
    motions = _told_motions(case, wrong)
    findings: list[Finding] = []
    made = _parts(case, cache, wrong, findings)
    bodies = _bodies(case, made, motions, wrong)
    slaves = _slaves(case, made, motions, wrong)
    belts = _belts(case, made, motions, wrong)
    slaves |= {name: SlavePart(belt.slave, belt.motion) for name, belt in belts.items()}
    for i, spec in enumerate(case.belt):
        for name, spring in _webbing(f"belt[{i}]", belts.get(spec.name), wrong).items():
            with wrong.at(f"belt[{i}]"):
                _add_spring(springs, name, spring)
    contacts = _contacts(case, bodies, slaves, wrong)
    return _Pieces(springs, gas, bodies, slaves, contacts, tuple(findings))


def faults_of(case: Case) -> tuple[tuple[Fault, str], ...]:
    """Return the faults in the parts of a case, each with its key, the cheapest to find first."""
    wrong = Together(str(case.file), case.origins)
    _pieces(case, PartCache(), wrong)
    return wrong.errors


def run(
    case: Case,
    out: str | Path | None = None,
    how: RunOptions = DEFAULT,
    *,
    parts: PartCache | None = None,
) -> Result:
    """Build a case and run it.

    Parameters
    ----------
    case : the checked case
    out : folder for the results; None keeps them in memory only
    how : its clock is that of building, too; its `on_finish` is for a run that is to have a report
    parts : as `build`

    Raises
    ------
    OutputError
        As `Simulation.run`; also where the copy of the case would replace the case file.
    """
    clock = Clock()
    with clock.watching(), clock("total"), clock("build"):
        simulation = build(case, parts=parts)
        if out is not None:
            keep_case_file(Path(out), case.file, simulation.case_text)
    wanted = how.on_finish if case.output.report else None
    return carry_out(simulation, out, how._replace(clock=clock, on_finish=wanted))


def _contacts(
    case: Case,
    bodies: Mapping[str, BodyPart],
    slaves: Mapping[str, SlavePart],
    wrong: Together,
) -> tuple[ContactPart, ...]:
    """Return the contacts between the parts that could be made."""
    measured = {spec.name for spec in case.slave if spec.area is not None}
    made = []
    for i, spec in enumerate(case.contact):
        if spec.master in bodies and spec.slave in slaves:
            body, slave = bodies[spec.master].body, slaves[spec.slave]
            with wrong.at(f"contact[{i}]"):
                area = area_of(spec, slave.slave, spec.slave in measured)
                contact = contact_of(spec, case.sides(spec), body, slave, area)
                made.append(ContactPart(spec.title, spec.master, spec.slave, contact))
    return tuple(made)


def _told_motions(case: Case, wrong: Together) -> dict[str, BodyMotion]:
    """Return the prescribed motions, by the key of the case."""
    entries: list[tuple[str, Any]] = [
        *((f"body[{i}].motion", spec.motion) for i, spec in enumerate(case.body)),
        *((f"slave[{i}].motion", spec.motion) for i, spec in enumerate(case.slave)),
    ]
    motions = {}
    for key, motion in entries:
        if not isinstance(motion, FreeSpec | AttachedSpec | SeriesSpec | DeformSpec):
            with wrong.at(key):
                motions[key] = prescribed(motion, case)
    return motions


def _parts(
    case: Case, cache: PartCache, wrong: Together, findings: list[Finding]
) -> dict[str, Master | Slave]:
    """Return the bodies and slaves that can be made, by name, at their places before any motion.

    What is told while files are read is added to `findings`.
    """
    keys = {spec.name: f"body[{i}].geometry" for i, spec in enumerate(case.body)}
    keys |= {spec.name: f"slave[{i}].{spec.source_key}" for i, spec in enumerate(case.slave)}
    if any(_is_unread(spec) for spec in case.body):
        preload_search()  # while a worker loads the reader of CAD
    raw: dict[str, Body | TriMesh] = {}
    for body_spec in case.body:
        with wrong.at(keys[body_spec.name]), told_of("body", body_spec.name, findings):
            raw[body_spec.name] = _body(body_spec, case.units.length, cache)
    parts: dict[str, Master | Slave] = {}
    drawn: dict[str, Master | Slave] = {}  # before the steps of `then`
    for name in order_of(case.parts):
        spec = case.parts[name]
        needed = {other for _, other in references(spec)}
        if not needed <= parts.keys() or (isinstance(spec, BodySpec) and name not in raw):
            continue  # the error of the part it is placed by is reported
        source = spec.geometry if isinstance(spec, BodySpec) else spec.source
        seen = drawn if source.then else parts
        with wrong.at(keys[name]):
            if isinstance(spec, BodySpec):
                body = spec.geometry.standing(raw[name], seen)
                drawn[name], parts[name] = body, source.moved(body)
            else:
                met = [one.master for one in case.contact if one.slave == name]
                sizes = [raw[master].size for master in met if master in raw]
                with told_of("slave", name, findings):
                    slave = _slave(spec, case.units.length, seen, sizes, cache)
                    drawn[name], parts[name] = slave, source.moved(slave)
    return parts


def _is_unread(spec: BodySpec) -> bool:
    """Return whether a body's file has not been read before; for others most results are cached."""
    return isinstance(spec.geometry, FileGeometry) and not was_read(Path(spec.geometry.file))


def _bodies(
    case: Case,
    made: Mapping[str, Master | Slave],
    motions: Mapping[str, BodyMotion],
    wrong: Together,
) -> dict[str, BodyPart]:
    """Return the bodies with their motions, and with their masses if forces move them."""
    bodies = {}
    for i, spec in enumerate(case.body):
        body, motion, mass = made.get(spec.name), spec.motion, None
        if body is None:
            continue
        assert not isinstance(body, Slave)
        if spec.reference_point is not None:
            body = body.with_reference_point(spec.reference_point)
        if isinstance(motion, FreeSpec | AttachedSpec) and spec.mass is not None:
            with wrong.at(f"body[{i}].mass"):
                mass = spec.mass.properties(body)
        moved: BodyMotion | Dependent | None = motions.get(f"body[{i}].motion")
        if isinstance(motion, AttachedSpec):
            moved = Attached(motion.body, mass)
        elif isinstance(motion, FreeSpec) and mass is not None:
            with wrong.at(f"body[{i}].motion"):
                moved = motion.moved(mass)
        # The error in its motion is reported; its contacts are checked all the same.
        bodies[spec.name] = BodyPart(body, Fixed() if moved is None else moved)
    return bodies


def _slaves(
    case: Case,
    made: Mapping[str, Master | Slave],
    motions: Mapping[str, BodyMotion],
    wrong: Together,
) -> dict[str, SlavePart]:
    """Return the slaves with their motions."""
    slaves = {}
    for i, spec in enumerate(case.slave):
        slave, key = made.get(spec.name), f"slave[{i}].motion"
        if slave is None:
            continue
        assert isinstance(slave, Slave)
        with wrong.at(key):
            slaves[spec.name] = SlavePart(slave, slave_motion(spec, slave, case, motions.get(key)))
    return slaves


def _belts(
    case: Case,
    made: Mapping[str, Master | Slave],
    motions: Mapping[str, BodyMotion],
    wrong: Together,
) -> dict[str, Belt]:
    """Return the belts over the bodies at their places at the start."""
    bodies = _at_start(case, made, motions) if case.belt else {}
    belts = {}
    for i, spec in enumerate(case.belt):
        if not bodies.keys() >= {*spec.path.over}:
            continue  # their errors are reported
        with wrong.at(f"belt[{i}]"):
            belt = spec.laid(bodies)
            check_elements(spec.name, belt.slave, belt.motion)
            belts[spec.name] = belt
    return belts


def _at_start(
    case: Case, made: Mapping[str, Master | Slave], motions: Mapping[str, BodyMotion]
) -> dict[str, Master]:
    """Return the bodies where their motions, or those of their carriers, have them at the start."""
    specs = {spec.name: (spec, f"body[{i}].motion") for i, spec in enumerate(case.body)}
    bodies = {}
    for name, body in made.items():
        if isinstance(body, Slave):
            continue
        carrier, key = specs[name]
        seen = {name}
        while isinstance(carrier.motion, AttachedSpec) and carrier.motion.body not in seen:
            seen.add(carrier.motion.body)
            carrier, key = specs[carrier.motion.body]
        bodies[name] = body
        if key in motions:
            pose = pose_at(motions[key], case.time.start)
            if not np.array_equal(pose, np.eye(4)):
                bodies[name] = body.transformed(pose)
    return bodies


def belts_of(case: Case) -> dict[str, Belt]:
    """Return the belts of a case by name.

    Raises
    ------
    InputError, MissingPackageError
        As `build`.
    """
    wrong = Together(str(case.file), case.origins)
    motions = _told_motions(case, wrong)
    belts = _belts(case, _parts(case, PartCache(), wrong, []), motions, wrong)
    wrong.tell()
    return belts


def _body(spec: BodySpec, unit: str, cache: PartCache) -> Body | TriMesh:
    """Return the body before it is placed relative to others."""

    def make() -> Body | TriMesh:
        body = spec.geometry.body(spec.name, unit)
        body.check()
        return body

    return cache.part(spec.geometry, spec.name, unit, make)


def _springs(case: Case, wrong: Together) -> dict[str, Spring]:
    """Return the springs by name: their own, or that of the bodies they connect."""
    springs: dict[str, Spring] = {}
    for i, spec in enumerate(case.spring):
        with wrong.at(f"spring[{i}].name"):
            _add_spring(springs, spec.made.name, spec.made)
    return springs


def _add_spring(springs: dict[str, Spring], name: str, spring: Spring) -> None:
    if name in springs:
        raise CaseError(
            "another spring has this name",
            found=name,
            remedy="Give each spring a name of its own",
        )
    springs[name] = spring


def _webbing(key: str, belt: Belt | None, wrong: Together) -> dict[str, Spring]:
    """Return the springs at the ends of a belt; none for a belt that could not be laid."""
    springs: dict[str, Spring] = {}
    if belt is not None:
        with wrong.at(key):
            springs = belt.springs
    return springs


def _gas(case: Case, wrong: Together) -> dict[str, Chamber]:
    """Return the chambers of gas by name."""
    units = case.units.length, case.units.mass, case.units.time
    slaves = {slave.name: slave for slave in case.slave}
    gas: dict[str, Chamber] = {}
    for i, spec in enumerate(case.gas):
        with wrong.at(f"gas[{i}]"):
            gas[spec.name] = spec.chamber(units, partial(nodes_named, slaves[spec.slave]))
    return gas


def _slave(
    spec: SlaveSpec,
    unit: str,
    parts: Mapping[str, Master | Slave],
    met: list[float],
    cache: PartCache,
) -> Slave:
    """Return the slave under its name in the case, with the nodal values that the case gives it.

    `met` are sizes of the bodies that it has contacts with.
    """
    slave = spec.source.standing(_raw_slave(spec, unit, parts, met, cache), parts)

    def nodal(given: float | None, of_slave: FloatArray | None) -> FloatArray | None:
        return of_slave if given is None else np.full(len(slave), given)

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


def _raw_slave(
    spec: SlaveSpec,
    unit: str,
    parts: Mapping[str, Master | Slave],
    met: list[float],
    cache: PartCache,
) -> Slave:
    """Return the slave before it is placed relative to others."""
    points, geometry, mesh = spec.points, spec.geometry, spec.mesh
    names = spec.name, unit
    if isinstance(points, BodyPoints):
        body = parts[points.body]
        assert not isinstance(body, Slave)
        return points.sampled(body, met)
    if points is not None:
        return cache.part(points, *names, lambda: points.slave(*names))
    assert geometry is not None
    if mesh is not None:
        return meshed_of(geometry, mesh, names, met)
    return surface_of(geometry, spec.refine or RefineSpec(), names)
