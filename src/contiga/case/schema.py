"""The tables of the case file; reading and checking a case.

Everything that can be known without reading CAD and meshes is checked here; the rest is checked
when the case is built.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import (
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationError,
    create_model,
    model_validator,
)

from contiga.case.belt_spec import BeltSpec
from contiga.case.case_file import read_text, tables_in
from contiga.case.columns import channels_of_case
from contiga.case.contact_spec import ContactSpec
from contiga.case.device_spec import SlipRingSpec
from contiga.case.gas_spec import GasSpec
from contiga.case.geometry_spec import GeometrySpec
from contiga.case.include import INCLUDE, CaseTables, with_includes
from contiga.case.included_tables import KEYS
from contiga.case.joint_spec import JointSpec
from contiga.case.load_spec import LoadSpec
from contiga.case.mass_spec import MassSpec
from contiga.case.motion_spec import BodyMotionSpec, SeriesSpec, SlaveMotionSpec
from contiga.case.names import EITHER, check_apart, check_defined, check_fires, check_unique
from contiga.case.output_spec import OutputSpec
from contiga.case.placed_spec import Placed, matrix_of
from contiga.case.placement_order import order_of, references
from contiga.case.plot_spec import PlotSpec, ReferenceSpec, check_channel, check_kinds
from contiga.case.points_spec import BodyPoints, PointsSpec, Sampling
from contiga.case.problems import Origin, case_error, check_at
from contiga.case.rigid_spec import FixedSpec
from contiga.case.sensor_spec import PointSensorSpec, RelativeSensorSpec, SensorSpec
from contiga.case.settings import with_settings
from contiga.case.settle_spec import SettleSpec
from contiga.case.sides import LayeredSpec, Sides, sides_of
from contiga.case.spec import (
    LengthUnit,
    MassUnit,
    Name,
    NotNegative,
    Positive,
    Spec,
    TimeUnit,
    Vector,
    is_number,
    raise_together,
    suggest,
)
from contiga.case.spring_spec import SpringSpec
from contiga.case.surface_spec import RefineSpec, check_surface
from contiga.dynamics.springs import GROUND
from contiga.dynamics.stepping import AutoSteps, EqualSteps
from contiga.errors import CaseError


def _number_or_auto(value: Any) -> Any:
    """Return `value`; CaseError unless it is "auto" or a number above zero."""
    if value == "auto" or is_number(value):
        if value != "auto" and not value > 0.0:
            raise CaseError("is too small", found=value, allowed='> 0, or "auto"')
        return value
    raise CaseError(
        'must be a number, or "auto"', found=value, allowed="> 0", remedy=suggest(value, ["auto"])
    )


class UnitsSpec(Spec):
    """`[units]`: the units of all numbers of the case. CAD and mesh files are converted to them."""

    length: LengthUnit
    mass: MassUnit
    time: TimeUnit


class TimeSpec(Spec):
    """`[time]`: from `start` to `end` in steps of `step`; the last one may be shorter."""

    start: float = 0.0
    end: float
    step: Annotated[float | str, BeforeValidator(_number_or_auto)]
    """Time step, or "auto"."""
    safety: Positive = 0.9
    """Largest share of the critical step that "auto" takes."""
    largest: Positive | None = None
    """Largest step of "auto"; a two hundredth of the time if omitted."""
    shortest: Positive | None = None
    """Smallest step of "auto", except for stability; 1/500 of the critical step if omitted."""
    allow_unstable: bool = False
    """Whether a step longer than the critical one is allowed."""

    @model_validator(mode="after")
    def _time_goes_forward(self) -> Self:
        for name in ("largest", "shortest"):
            if self.step != "auto" and getattr(self, name) is not None:
                raise CaseError('is for step = "auto"', where=name, found=getattr(self, name))
        self.stepping()
        return self

    def stepping(self) -> EqualSteps | AutoSteps:
        """Return the times of the run; InputError if they do not go forward."""
        if isinstance(self.step, str):
            bounds = self.largest or 0.0, self.shortest or 0.0
            return AutoSteps(self.start, self.end, self.safety, *bounds)
        return EqualSteps(self.start, self.end, self.step)


class WorldSpec(Spec):
    """`[world]`: loads on all parts."""

    gravity: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Acceleration of free bodies and nodes, in the units of the case."""


class BodySpec(LayeredSpec):
    """A `[[body]]`: a rigid master surface."""

    name: Name
    geometry: GeometrySpec
    mass: MassSpec | None = None
    """Mass of a free body, or of one attached to it; it has no effect on other bodies."""
    motion: BodyMotionSpec = Field(default_factory=FixedSpec)
    reference_point: Vector | None = None
    """Point of the placed body about which moments are taken; its geometry's origin if omitted."""

    @property
    def source(self) -> Placed:
        """The table of its shape, which places it."""
        return self.geometry

    @property
    def source_key(self) -> str:
        """The key of the table `source` in the case file."""
        return "geometry"


class SlaveSpec(Spec):
    """A `[[slave]]`: points that may touch a body."""

    name: Name
    points: PointsSpec | None = None
    geometry: GeometrySpec | None = None
    """Patches that make the slave a surface of splines, in place of `points`."""
    refine: RefineSpec | None = None
    """Degree and elements of a `geometry`."""
    mesh: Sampling | None = None
    """Triangulation of a `geometry`, in place of splines."""
    motion: SlaveMotionSpec = Field(default_factory=FixedSpec)
    thickness: Positive | None = None
    """Thickness of every node, in place of the file's."""
    area: Positive | None = None
    """Tributary area of every node, in place of the area from the facets."""
    mass: NotNegative | None = None
    """Mass of every node, in place of the file's."""

    @property
    def source(self) -> Placed:
        """The source of its points: `points` or `geometry`."""
        source = self.points or self.geometry
        assert source is not None
        return source

    @property
    def source_key(self) -> str:
        """The key of that source."""
        return "geometry" if self.points is None else "points"

    def describe_source(self) -> str:
        """Describe the source of its points."""
        if self.points is not None:
            return self.points.describe_selection()
        assert self.geometry is not None
        if self.mesh is not None:
            elements = self.mesh.describe_mesh()
        else:
            elements = (self.refine or RefineSpec()).describe()
        return f"{self.geometry.describe()}, {elements}"

    @model_validator(mode="after")
    def _points_or_geometry(self) -> Self:
        """Refuse both or neither of points and geometry, and keys that do not go with it."""
        if (self.points is None) == (self.geometry is None):
            raise CaseError(
                "must have exactly one of the keys points or geometry",
                found="neither" if self.points is None else "both",
                allowed="points of a mesh or cloud; or the geometry of a surface of splines",
            )
        if self.geometry is not None:
            check_surface(self.geometry, self.refine, self.mesh)
            return self
        for key in ("refine", "mesh"):
            if getattr(self, key) is not None:
                raise CaseError("is for a geometry, and the slave has points", where=key)
        return self

    @model_validator(mode="after")
    def _a_series_says_where_points_are(self) -> Self:
        placed = [key for key in ("align", "place", "then") if getattr(self.source, key)]
        if placed and isinstance(self.motion, SeriesSpec):
            raise CaseError(
                "does nothing: a series of files says where the points are",
                where=f"{self.source_key}.{placed[0]}",
                remedy="Place what it meets instead, or give the series a motion `then`",
            )
        return self

    @model_validator(mode="before")
    @classmethod
    def _points_of_a_body_go_with_it(cls, data: Any) -> Any:
        """Return the table with points of a body attached to it, unless it has a motion."""
        points = data.get("points") if isinstance(data, dict) else None
        if isinstance(points, dict) and isinstance(points.get("body"), str):
            return {"motion": {"kind": "attached", "body": points["body"]}} | data
        return data


class Case(Spec):
    """A whole case. Its file names are absolute."""

    title: str = "contiga"
    units: UnitsSpec
    time: TimeSpec
    body: list[BodySpec] = Field(default_factory=list)
    """Rigid bodies; none is needed if a slave deforms."""
    slave: list[SlaveSpec] = Field(default_factory=list)
    belt: list[BeltSpec] = Field(default_factory=list)
    """Belts are slaves too: contacts, springs and sensors refer to them as such."""
    contact: list[ContactSpec] = Field(default_factory=list)
    world: WorldSpec = Field(default_factory=WorldSpec)
    settle: SettleSpec | None = None
    load: list[LoadSpec] = Field(default_factory=list)
    spring: list[SpringSpec] = Field(default_factory=list)
    slip_ring: list[SlipRingSpec] = Field(default_factory=list)
    joint: list[JointSpec] = Field(default_factory=list)
    gas: list[GasSpec] = Field(default_factory=list)
    sensor: list[SensorSpec] = Field(default_factory=list)
    plot: list[PlotSpec] = Field(default_factory=list)
    reference: list[ReferenceSpec] = Field(default_factory=list)
    output: OutputSpec = Field(default_factory=OutputSpec)

    _file: Path = PrivateAttr(default=Path("case.toml"))

    _origins: dict[tuple[str, int], Origin] = PrivateAttr(default_factory=dict)

    @property
    def file(self) -> Path:
        """The file of the case."""
        return self._file

    @property
    def origins(self) -> Mapping[tuple[str, int], Origin]:
        """The files and rows of tables that it includes, by their key and place."""
        return self._origins

    @classmethod
    def known_keys(cls, data: dict[str, Any]) -> list[str]:
        """Return the keys of a case; `include` is gone once its files are read."""
        return [*super().known_keys(data), INCLUDE]

    @property
    def parts(self) -> dict[str, BodySpec | SlaveSpec]:
        """Bodies and slaves by name.

        Belts are not among them.
        """
        bodies: dict[str, BodySpec | SlaveSpec] = {part.name: part for part in self.body}
        return bodies | {part.name: part for part in self.slave}

    @property
    def deforms(self) -> bool:
        """Whether there is a belt, or another slave of elements."""
        return bool(self.belt) or any(slave.motion.kind == "deform" for slave in self.slave)

    @property
    def _slaves(self) -> dict[str, str]:
        """The keys of slaves and belts, and their names."""
        named = {f"slave[{i}]": slave.name for i, slave in enumerate(self.slave)}
        return named | {f"belt[{i}]": belt.name for i, belt in enumerate(self.belt)}

    @model_validator(mode="after")
    def _parts_fit_together(self) -> Self:
        """Refuse a case in which nothing can happen; check names, places, laws and channels.

        All wrong names and places are reported at once, then circles of places and wrong laws, then
        channels that a run will not have.
        """
        deforms = self.deforms
        free = any(slave.motion.by_forces for slave in self.slave)
        nodes = deforms or bool(self.gas) or (free and bool(self.spring))
        moved = nodes or any(body.motion.by_forces for body in self.body)
        if not (self.body or nodes):
            raise CaseError("is missing", where="body", allowed="at least one [[body]]")
        if not (self.contact or moved):
            raise CaseError(
                "nothing can happen: there is no contact, and nothing that forces move",
                where="contact",
                allowed="a [[contact]] of a body and a slave; or, for springs and loads alone, a "
                '[[body]] with a mass and motion = { kind = "free" }',
            )
        names = self._name_checks()
        keys = {part.name: f"body[{i}]" for i, part in enumerate(self.body)}
        keys |= {part.name: f"slave[{i}]" for i, part in enumerate(self.slave)}
        placements = (
            partial(self._check_placement, name, reference, f"{keys[name]}.{key}")
            for name, part in self.parts.items()
            for key, reference in references(part)
        )
        raise_together(self, (*names, *self._reference_checks(), *placements))
        sides = (
            partial(check_at, f"contact[{i}]", self.sides, contact)
            for i, contact in enumerate(self.contact)
        )
        raise_together(self, (partial(order_of, self.parts), *sides))
        if self.plot or self.reference:
            raise_together(self, self._figure_checks())
        return self

    def _figure_checks(self) -> Iterator[Callable[[], object]]:
        """Yield checks that a run has the channels of plots and curves of tests.

        Channels of a plot must have one unit, and a curve of a test times in common with the run.
        """
        channels = channels_of_case(self)
        start, end = self.time.start, self.time.end
        for i, plot in enumerate(self.plot):
            yield partial(check_channel, f"plot[{i}].x", plot.x, channels)
            for name in plot.channels:
                yield partial(check_channel, f"plot[{i}].y", name, channels)
            yield partial(check_kinds, f"plot[{i}].y", plot.channels)
        for i, curve in enumerate(self.reference):
            yield partial(check_channel, f"reference[{i}].channel", curve.channel, channels)
            yield partial(check_channel, f"reference[{i}].x", curve.x, channels)
            yield partial(check_at, f"reference[{i}]", curve.check_overlap, start, end)

    def _name_checks(self) -> Iterator[Callable[[], object]]:
        """Yield checks that names of a kind are unique, and that contacts name a body and a slave.

        A body, a slave and a belt may not have the same name either.
        """
        for key, names in (
            ("body", [body.name for body in self.body]),
            ("slave", [slave.name for slave in self.slave]),
            ("belt", [belt.name for belt in self.belt]),
            ("contact", [contact.title for contact in self.contact]),
            ("slip_ring", [ring.instance.name for ring in self.slip_ring]),
            ("joint", [joint.instance.name for joint in self.joint]),
            ("gas", [chamber.name for chamber in self.gas]),
        ):
            yield partial(check_unique, key, names)
        bodies = [body.name for body in self.body]
        slaves = [*self._slaves.values()]
        rule = "a body and a slave must not have the same name"
        for key, slave in self._slaves.items():
            yield partial(check_apart, f"{key}.name", slave, bodies, rule)
        slaves_without_belts = [slave.name for slave in self.slave]
        rule = "a slave has this name: a belt is one, too"
        for i, belt in enumerate(self.belt):
            yield partial(check_apart, f"belt[{i}].name", belt.name, slaves_without_belts, rule)
        for i, contact in enumerate(self.contact):
            key = f"contact[{i}]"
            yield partial(check_defined, f"{key}.master", contact.master, "body", bodies, slaves)
            yield partial(check_defined, f"{key}.slave", contact.slave, "slave", slaves, bodies)

    def _reference_checks(self) -> Iterator[Callable[[], object]]:
        """Yield checks of the names in motions, loads, springs, joints, rings, gas and sensors.

        The last ones check each body, for a mass if forces move it.
        """
        bodies = [body.name for body in self.body]
        slaves = [*self._slaves.values()]
        for key, name in self._named_bodies():
            yield partial(check_defined, key, name, "body", bodies, slaves)
        for i, spring in enumerate(self.spring):
            for k, end in enumerate(spring.between):
                if end != GROUND:
                    key = f"spring[{i}].between[{k}]"
                    yield partial(check_defined, key, end, EITHER, bodies + slaves, [])
        for i, joint in enumerate(self.joint):
            for k, end in enumerate(joint.between):
                if end != GROUND:
                    key = f"joint[{i}].between[{k}]"
                    yield partial(check_defined, key, end, "body", bodies, slaves)
        segments = [spring.instance.name for spring in self.spring]
        segments += [f"{belt.name} {end}" for belt in self.belt for end in belt.webbing]
        for i, ring in enumerate(self.slip_ring):
            for k, segment in enumerate(ring.between):
                key = f"slip_ring[{i}].between[{k}]"
                yield partial(check_defined, key, segment, "spring", segments, [])
        sensors = [sensor.name for sensor in self.sensor]
        triggers = [
            sensor.name for sensor in self.sensor if getattr(sensor, "trigger", None) is not None
        ]
        for key, name in self._triggers():
            yield partial(check_fires, key, name, triggers, sensors)
        for i, chamber in enumerate(self.gas):
            yield partial(check_defined, f"gas[{i}].slave", chamber.slave, "slave", slaves, bodies)
        for i, sensor in enumerate(self.sensor):
            for key in ("node", "section"):
                if (slave := getattr(sensor, key, None)) is not None:
                    place = f"sensor[{i}].{key}"
                    yield partial(check_defined, place, slave, "slave", slaves, bodies)
        yield from (partial(self._check_body, i) for i in range(len(self.body)))

    def _triggers(self) -> Iterator[tuple[str, str]]:
        """Yield the keys of triggers, and the names of their sensors."""
        keys = {"retractor": "retractor.lock"}
        for i, spring in enumerate(self.spring):
            for device, name in spring.instance.devices.triggers.items():
                yield f"spring[{i}].{keys.get(device, device)}.trigger", name
        for i, belt in enumerate(self.belt):
            for end, webbing in belt.webbing.items():
                for device, name in webbing.instance.devices.triggers.items():
                    yield f"belt[{i}].{end}.{keys.get(device, device)}.trigger", name
        for i, chamber in enumerate(self.gas):
            for key, name in chamber.triggers():
                yield f"gas[{i}].{key}", name

    def _check_body(self, i: int) -> None:
        """Refuse a body without the mass that it needs, or with the name of the ground.

        That name is refused only if a spring or a joint is attached to the ground.
        """
        body = self.body[i]
        grounded = [f"spring[{k}]" for k, s in enumerate(self.spring) if GROUND in s.between]
        grounded += [f"joint[{k}]" for k, j in enumerate(self.joint) if GROUND in j.between]
        if body.name == GROUND and grounded:
            raise CaseError(
                f"means the world in {grounded[0]}",
                where=f"body[{i}].name",
                found=GROUND,
                remedy="Rename the body, also in the springs and joints that are attached to it",
            )
        if body.motion.by_forces and body.mass is None:
            raise CaseError(
                "is missing: a free body needs its mass",
                where=f"body[{i}].mass",
                allowed="{ density = … } of a closed body, or { total = …, centre, inertia }",
            )

    def _named_bodies(self) -> Iterator[tuple[str, str]]:
        """Yield the keys that name a body, but for contacts, springs and joints, and the names.

        A name that a slave has both in its points and in its motion is yielded once.
        """
        keys: dict[tuple[str, str], str] = {}  # by table and name, each name once
        for i, slave in enumerate(self.slave):
            if isinstance(slave.points, BodyPoints):
                keys[f"slave[{i}]", slave.points.body] = "points.body"
        motions = [
            *((f"body[{i}]", body.motion) for i, body in enumerate(self.body)),
            *((f"slave[{i}]", slave.motion) for i, slave in enumerate(self.slave)),
        ]
        for part, motion in motions:
            for key, name in motion.named_bodies():
                keys.setdefault((part, name), f"motion.{key}")
        yield from ((f"{part}.{key}", name) for (part, name), key in keys.items())
        for i, belt in enumerate(self.belt):
            yield from ((f"belt[{i}].{key}", name) for key, name in belt.named_bodies())
        yield from ((f"load[{i}].body", load.body) for i, load in enumerate(self.load))
        settled = self.settle.bodies if self.settle is not None else []
        yield from ((f"settle.bodies[{k}]", name) for k, name in enumerate(settled))
        for i, sensor in enumerate(self.sensor):
            if isinstance(sensor, RelativeSensorSpec):
                for k, end in enumerate(sensor.between):
                    yield f"sensor[{i}].between[{k}]", end
            elif isinstance(sensor, PointSensorSpec):
                yield f"sensor[{i}].body", sensor.body

    def _check_placement(self, name: str, reference: str, key: str) -> None:
        """Refuse the part `reference`, by which the part `name` is placed, if it cannot be used.

        It must exist; one of two parts placed on each other must be a body, and a part of an
        included file must have been moved by the same steps.
        """
        parts = self.parts
        check_defined(key, reference, EITHER, [*parts], [])
        part, other = parts[name], parts[reference]
        bodies = [body.name for body in self.body]
        if key.endswith("place.on") and not {name, reference} & set(bodies):
            raise CaseError(
                "a slave cannot be placed on a slave: neither has a surface",
                where=key,
                found=reference,
                allowed=", ".join(f'"{body}"' for body in bodies),
            )
        steps = part.source.then
        if steps and not np.array_equal(matrix_of(steps), matrix_of(other.source.then)):
            raise CaseError(
                "joints of an included file, or its placement, move this part otherwise",
                where=key,
                found=reference,
                remedy=f"Place {name!r} by a transform in place of another part",
            )

    def sides(self, contact: ContactSpec) -> Sides:
        """Return the type of a contact, which tells the side that deforms, and the laws.

        Raises
        ------
        InputError
            As `sides_of`: a side that should deform has no law, or the laws do not fit.
        """
        bodies = {body.name: body for body in self.body}
        points = next((slave.points for slave in self.slave if slave.name == contact.slave), None)
        host = bodies[points.body] if isinstance(points, BodyPoints) else None
        return sides_of(contact, bodies[contact.master], host)


_FIELDS: dict[str, Any] = {
    key: (field.annotation, field) for key, field in Case.model_fields.items() if key in KEYS
}
IncludedTables = create_model("IncludedTables", __base__=Spec, **_FIELDS)
"""Tables that a file may have which a case includes."""


def load_case(path: str | Path, *, set: Mapping[str, Any] | None = None) -> Case:
    """Read and check a case file.

    Parameters
    ----------
    path : the case file
    set : values that stand in place of the file's, by key: places or names lead into lists, such
        as ``"contact[0].law.damping"`` and ``"body.head.motion.velocity"``

    Raises
    ------
    FileError
        The case file, or a file it names, is missing or cannot be read.
    CaseError
        It is not TOML, or something in it is wrong; the message says the key, what was found and
        what is allowed, and lists all errors at once. Or a key of `set` leads nowhere.
    UnitError
        The name of a unit is unknown.

    Examples
    --------
    >>> import contiga as cg
    >>> case = cg.load_case("case.toml")
    >>> case.title, [body.name for body in case.body]
    ('Head of 4.54 kg into foam at 6.7 m/s', ['head'])
    >>> slower = cg.load_case("case.toml", set={"body.head.motion.velocity": [0, 0, -5]})
    >>> slower.body[0].motion.velocity
    [0.0, 0.0, -5.0]
    """
    path = Path(path)
    return parse_case(read_text(path), path, set=set)


def parse_case(
    text: str, path: str | Path = "case.toml", *, set: Mapping[str, Any] | None = None
) -> Case:
    """Return the case in `text`; relative file names in it start from the folder of `path`.

    Raises
    ------
    CaseError, FileError, UnitError
        As `load_case`.
    """
    path = Path(path)
    return case_of(tables_of(text, path, set), path)


def tables_of(text: str, path: Path, set: Mapping[str, Any] | None = None) -> CaseTables:
    """Return the tables of a case and of the files that it includes, with the values of `set`.

    Raises
    ------
    CaseError, FileError
        The text is not TOML, a key of `set` leads nowhere, or a file that is included is wrong.
    """
    settings = dict(set or {})
    # Settings that decide how files are included are applied first, settings of the tables of
    # these files after they have been read.
    of_reading = {key: settings[key] for key in settings if key.startswith((INCLUDE, "units"))}
    of_tables = {key: settings[key] for key in settings if key not in of_reading}
    tables = with_includes(with_settings(tables_in(text, path), of_reading), path, IncludedTables)
    return tables._replace(data=with_settings(tables.data, of_tables))


def case_of(tables: CaseTables, path: Path) -> Case:
    """Return the case of tables, whose own file is `path`.

    Raises
    ------
    CaseError, FileError, UnitError
        As `load_case`.
    """
    context = {"folder": path.parent, "units": tables.data.get("units")}
    try:
        case = Case.model_validate(tables.data, context=context)
    except ValidationError as error:
        raise case_error(error, tables.data, str(path), origins=tables.origins) from error
    case._file, case._origins = path, tables.origins
    return case
