"""From a checked case to a simulation: files are read, shapes made, references resolved."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from contiga.area.facet import FacetArea
from contiga.area.method import AreaMethod
from contiga.area.nodal import NodalArea
from contiga.case.contact_spec import (
    CloudAreaSpec,
    ConstantAreaSpec,
    ContactSpec,
    FacetAreaSpec,
    HullAreaSpec,
)
from contiga.case.geometry_spec import FileGeometry
from contiga.case.motion_spec import AttachedSpec, FreeSpec, RigidMotionSpec, SeriesSpec
from contiga.case.part_cache import PartCache
from contiga.case.points_spec import BodyPoints
from contiga.case.problems import relocated
from contiga.case.pulse_spec import AccelerationSpec, VelocitySpec
from contiga.case.schema import BodySpec, Case, SlaveSpec
from contiga.case.standing import order_of
from contiga.case.toml import resolved_toml
from contiga.contact.contact import Contact
from contiga.contact.preloaded import preload_search
from contiga.dynamics.free import Attached, Free
from contiga.dynamics.prescribed import BodyMotion, Moved, SlaveMotion
from contiga.dynamics.pulses import check_covers
from contiga.dynamics.springs import Spring
from contiga.errors import CaseError, InputError
from contiga.io.mesh.series import MeshSeries, find_files
from contiga.io.units import length_factor
from contiga.laws.normal import StressLaw
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


def build(case: Case, *, parts: PartCache | None = None) -> Simulation:
    """The simulation a case describes.

    Parameters
    ----------
    parts : bodies and slaves that cases before it had in common with it; none if omitted

    Raises
    ------
    InputError
        A file cannot be read, a slave lacks what a law or an area needs; the message says the key
        of the case. Nothing has been written by then.

    Examples
    --------
    >>> import contiga as cg
    >>> cg.build(cg.load_case("case.toml")).bodies["head"].body.closed
    True
    """
    made = _parts(case, PartCache() if parts is None else parts)
    bodies = {}
    for i, body_spec in enumerate(case.body):
        body = made[body_spec.name]
        assert not isinstance(body, Slave)
        if body_spec.reference_point is not None:
            body = body.about(body_spec.reference_point)
        bodies[body_spec.name] = BodyPart(body, _body_motion(case, i, body))
    slaves = {}
    for i, slave_spec in enumerate(case.slave):
        slave = made[slave_spec.name]
        assert isinstance(slave, Slave)
        with _at(case, f"slave[{i}].motion"):
            slaves[slave_spec.name] = SlavePart(slave, _slave_motion(slave_spec, slave, case))
    return Simulation(
        gravity=case.world.gravity,
        allow_unstable=case.time.allow_unstable,
        loads=[spec.load for spec in case.load],
        springs=_springs(case),
        sensors=[spec.sensor for spec in case.sensor],
        title=case.title,
        units=(case.units.length, case.units.mass, case.units.time),
        stepping=case.time.stepping(),
        bodies=bodies,
        slaves=slaves,
        contacts=tuple(_contacts(case, bodies, slaves)),
        output=OutputOptions(case.output.every, tuple(case.output.formats), case.output.report),
        case_text=resolved_toml(case),
        base_folder=case.file.parent,
    )


def run(
    case: Case,
    out: str | Path | None = None,
    *,
    resume: bool = False,
    strict: bool = False,
    keep: int | None = None,
    progress: Callable[[int, int, int], None] | None = None,
    on_check: Callable[[tuple[Finding, ...]], Any] | None = None,
    on_finish: Callable[[Path], Any] | None = None,
    on_pace: Callable[[str], Any] | None = None,
    on_slow: Callable[[str], Any] | None = None,
    parts: PartCache | None = None,
) -> Result:
    """Build a case and run it.

    Parameters
    ----------
    out : folder for the results; None keeps them in memory only
    resume : go on from the checkpoint in `out`
    strict : refuse a model that looks wrong; stop at the first point that is not certified
    keep : as `Simulation.run`
    progress : called with steps done, steps in all, points in contact
    on_check : called before the first step with what looks wrong about the model
    on_finish : called with `out` after a run that is to have a report
    on_pace : called with what set each step that chose itself
    on_slow : called once, with why, where the end is out of reach
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
    wanted = on_finish if case.output.report else None
    options = RunOptions(
        resume, strict, keep, progress, on_check, None, wanted, clock, on_pace, on_slow
    )
    return carry_out(simulation, out, options)


@contextmanager
def _at(case: Case, key: str) -> Iterator[None]:
    """Tells the key of the case an error inside belongs to."""
    try:
        yield
    except InputError as error:
        raise relocated(error, key, str(case.file)) from error


def _contacts(
    case: Case, bodies: Mapping[str, BodyPart], slaves: Mapping[str, SlavePart]
) -> Iterator[ContactPart]:
    measured = {spec.name for spec in case.slave if spec.area is not None}
    for i, spec in enumerate(case.contact):
        with _at(case, f"contact[{i}]"):
            body, slave = bodies[spec.master].body, slaves[spec.slave].slave
            contact = _contact(spec, body, slave, _area(spec, slave, spec.slave in measured))
        yield ContactPart(spec.title, spec.master, spec.slave, contact)


def _parts(case: Case, cache: PartCache) -> dict[str, Master | Slave]:
    """Bodies and slaves where they stand before any motion, by name."""
    keys = {spec.name: f"body[{i}].geometry" for i, spec in enumerate(case.body)}
    keys |= {spec.name: f"slave[{i}].points" for i, spec in enumerate(case.slave)}
    if any(isinstance(spec.geometry, FileGeometry) for spec in case.body):
        preload_search()  # CAD's reader is being loaded, too
    raw: dict[str, Body | TriMesh] = {}
    for body_spec in case.body:
        with _at(case, keys[body_spec.name]):
            raw[body_spec.name] = _body(body_spec, case.units.length, cache)
    parts: dict[str, Master | Slave] = {}
    for name in order_of(case.parts):
        spec = case.parts[name]
        with _at(case, keys[name]):
            if isinstance(spec, BodySpec):
                parts[name] = spec.geometry.standing(raw[name], parts)
            else:
                met = [raw[one.master].size for one in case.contact if one.slave == name]
                parts[name] = _slave(spec, case.units.length, parts, met, cache)
    return parts


def _body(spec: BodySpec, unit: str, cache: PartCache) -> Body | TriMesh:
    """The body before it is placed by others."""

    def make() -> Body | TriMesh:
        body = spec.geometry.body(spec.name, unit)
        body.check()
        return body

    return cache.part(spec.geometry, spec.name, unit, make)


def _body_motion(case: Case, i: int, body: Master) -> BodyMotion | Free | Attached:
    """How a body moves, with its mass where forces move it."""
    spec = case.body[i]
    motion, mass = spec.motion, None
    if isinstance(motion, FreeSpec | AttachedSpec) and spec.mass is not None:
        with _at(case, f"body[{i}].mass"):
            mass = spec.mass.properties(body)
    if isinstance(motion, AttachedSpec):
        return Attached(motion.body, mass)
    with _at(case, f"body[{i}].motion"):
        if isinstance(motion, FreeSpec):
            return motion.moved(mass)
        return _prescribed(motion, case)


def _prescribed(spec: RigidMotionSpec | VelocitySpec | AccelerationSpec, case: Case) -> BodyMotion:
    """A motion that is told beforehand, in the units of the case."""
    if isinstance(spec, VelocitySpec | AccelerationSpec):
        motion = spec.motion_in((case.units.length, case.units.mass, case.units.time))
        check_covers(motion.span, case.time.start, case.time.end, "table")
        return motion
    return spec.motion


def _springs(case: Case) -> dict[str, Spring]:
    """Springs by name: their own, or that of the bodies they are between."""
    springs: dict[str, Spring] = {}
    for i, spec in enumerate(case.spring):
        name = spec.name or "-".join(spec.between)
        with _at(case, f"spring[{i}].name"):
            if name in springs:
                raise CaseError(
                    "another spring is called so",
                    found=name,
                    remedy="Give each spring a name of its own",
                )
        springs[name] = spec.spring
    return springs


def _slave(
    spec: SlaveSpec,
    unit: str,
    parts: Mapping[str, Master | Slave],
    met: list[float],
    cache: PartCache,
) -> Slave:
    """The slave under its name in the case, with the nodal values the case gives it.

    `met` are sizes of the bodies that it has contacts with.
    """
    if isinstance(spec.points, BodyPoints):
        body = parts[spec.points.body]
        assert not isinstance(body, Slave)
        slave = spec.points.sampled(body, met)
    else:
        slave = cache.part(spec.points, spec.name, unit, lambda: spec.points.slave(spec.name, unit))
    slave = spec.points.standing(slave, parts)

    def nodal(given: float | None, own: FloatArray | None) -> FloatArray | None:
        return own if given is None else np.full(len(slave), given)

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
    )


def _slave_motion(spec: SlaveSpec, slave: Slave, case: Case) -> SlaveMotion | Free | Attached:
    motion = spec.motion
    if isinstance(motion, FreeSpec):
        return motion.moved(None)
    if isinstance(motion, AttachedSpec):
        return Attached(motion.body)
    if not isinstance(motion, SeriesSpec):
        return Moved(slave.points, _prescribed(motion, case))
    series = _series(motion, case)
    count = len(series.points(case.time.start))
    if count != len(slave):
        raise CaseError(
            "the files of the series do not have the points of the slave",
            where="files",
            found=f"{count} points",
            allowed=f"{len(slave)}",
        )
    return series if motion.then is None else Moved(series, motion.then.motion)


def _series(spec: SeriesSpec, case: Case) -> MeshSeries:
    files = find_files(spec.files)
    start, end = case.time.start, case.time.end
    if spec.times is not None:
        times = np.array(spec.times)
    elif spec.step is not None:
        times = start + spec.step * np.arange(len(files))
    else:
        times = np.linspace(start, end, len(files))
    factor = 1.0 if spec.unit is None else length_factor(spec.unit, case.units.length)
    return MeshSeries(files, times, factor=factor)


def _area(spec: ContactSpec, slave: Slave, given: bool) -> AreaMethod:
    """The method the case asks for; facets, unless the case gave the nodes an area."""
    if isinstance(spec.area, FacetAreaSpec | CloudAreaSpec | HullAreaSpec):
        return spec.area.method
    if isinstance(spec.area, ConstantAreaSpec):
        return NodalArea(spec.area.value)
    if spec.area is None and slave.facets is not None and not given:
        return FacetArea()
    if slave.area is None:
        raise CaseError(
            f"the points of {slave.name!r} have no facets to take areas from",
            where="area",
            found="none" if spec.area is None else spec.area.kind,
            allowed='{ kind = "constant", value = … }, { kind = "cloud" }, { kind = "hull" }, '
            "or an area of the slave",
        )
    return NodalArea()


def _contact(spec: ContactSpec, body: Master, slave: Slave, area: AreaMethod) -> Contact:
    master_law = None if spec.master_law is None else spec.master_law.law
    # The schema refuses other laws on the master's side.
    assert master_law is None or isinstance(master_law, StressLaw)
    return Contact(
        body,
        slave,
        law=spec.law.law,
        area=area,
        search=spec.search,
        contact_type=spec.type,
        on_edge=spec.on_edge,
        through=spec.through,
        foot=spec.foot,
        weights=spec.weights,
        quadrature=spec.quadrature,
        friction=None if spec.friction is None else spec.friction.friction,
        master_law=master_law,
        depth=spec.depth,
    )
