"""Tables of a file that is included, with other names and in another posture.

Points go with the body that they are of, else with the placement; directions, velocities and forces
turn with the placement, those on a body that follow it with the body.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, NamedTuple, cast

import numpy as np

from contiga.arrays.ordered import product
from contiga.case.belt_spec import BeltSpec
from contiga.case.include_spec import IncludeSpec
from contiga.case.points_spec import BodyPoints
from contiga.case.problems import relocated
from contiga.dynamics.belt import FREE
from contiga.dynamics.springs import GROUND
from contiga.errors import CaseError, InputError
from contiga.records import FloatArray
from contiga.rigid import quaternion
from contiga.rigid.transform import unit_axis

Table = dict[str, Any]
_STILL = [0.0, 0.0, 0.0]
_SQUARE = 1e-12
"""Entry of a rotation by quarter turns that departs so little from 0 or ±1."""


class Included(NamedTuple):
    """A file that is included, checked, and where its bodies stand."""

    spec: IncludeSpec
    tables: Any
    """Its tables."""
    names: frozenset[str]
    """Names that it defines."""
    placement: FloatArray
    """(4, 4), of all of it."""
    posture: Mapping[str, FloatArray]
    """Poses (4, 4) by body that joints move it by before; others stay as drawn."""

    def called(self, name: str) -> str:
        """Return the name in the case of what is called `name` in the file."""
        return self.spec.prefix + name if name in self.names else name

    def pose(self, body: str) -> FloatArray:
        """Return the pose (4, 4) that moves what is drawn on a body."""
        if body not in self.posture:
            return self.placement
        return product(self.placement, self.posture[body])

    @property
    def turn(self) -> FloatArray:
        """Rotation (3, 3) of its placement."""
        return self.placement[:3, :3]

    @property
    def moves(self) -> bool:
        """Whether its placement does anything."""
        return not np.array_equal(self.placement, np.eye(4))

    def channel(self, name: str) -> str:
        """Return the name in the case of a channel of the file."""
        owner, dot, column = name.rpartition(".")
        return f"{self.called(owner)}{dot}{column}"


def names_of(tables: Any) -> frozenset[str]:
    """Return the names that the tables of a file define."""
    named = (*tables.body, *tables.slave, *tables.belt, *tables.gas, *tables.sensor)
    made = (*tables.spring, *tables.slip_ring, *tables.joint)
    names = {one.name for one in named} | {one.made.name for one in made}
    names |= {contact.title for contact in tables.contact}
    return frozenset(names | {f"{belt.name} {end}" for belt in tables.belt for end in belt.webbing})


def tables_posed(included: Included) -> dict[str, list[Table]]:
    """Return the tables of a file by key, as a case in that posture would have them.

    Raises
    ------
    CaseError
        Something that cannot be placed so: the message says where it stands in the file.
    """
    tables: dict[str, list[Table]] = {}
    for key, pose in POSERS.items():
        tables[key] = []
        for i, spec in enumerate(getattr(included.tables, key)):
            table = spec.model_dump(exclude_none=True, by_alias=True)
            try:
                pose(included, spec, table)
            except InputError as error:
                raise relocated(error, f"{key}[{i}]", included.spec.file) from error
            tables[key].append(table)
    return tables


def _pose_body(included: Included, spec: Any, table: Table) -> None:
    pose = included.pose(spec.name)
    table["name"] = included.called(spec.name)
    _pose_source(included, table["geometry"], pose)
    if "reference_point" in table:
        table["reference_point"] = _point(pose, table["reference_point"])
    mass = table.get("mass", {})
    if "centre" in mass:
        mass["centre"] = _point(pose, mass["centre"])
    if "inertia" in mass:
        xx, yy, zz, xy, yz, xz = mass["inertia"]
        own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        turned = product(product(pose[:3, :3], own), pose[:3, :3].T)
        rows = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
        mass["inertia"] = [float(turned[i, j]) for i, j in rows]
    told = spec.motion.kind not in ("free", "attached", "fixed")
    if told and not np.array_equal(included.posture.get(spec.name, np.eye(4)), np.eye(4)):
        raise CaseError(
            "joints would move a body whose motion is told beforehand",
            where="motion",
            found=spec.motion.kind,
            remedy="Make it the root, or draw it where it starts",
        )
    _pose_motion(included, spec.motion, table["motion"], pose)


def _pose_slave(included: Included, spec: Any, table: Table) -> None:
    pose = _pose_of_slave(included, spec)
    table["name"] = included.called(spec.name)
    source = table[spec.source_key]
    _pose_source(included, source, pose)
    if isinstance(spec.points, BodyPoints):
        source["body"] = included.called(spec.points.body)
    motion = table["motion"]
    _pose_motion(included, spec.motion, motion, pose)
    if spec.motion.kind == "deform":
        _pose_deforming(included, spec.motion, motion, pose)


def _pose_of_slave(included: Included, spec: Any) -> FloatArray:
    """Return the pose of the bodies that carry a slave; the placement where none does."""
    carriers = [name for _, name in spec.motion.named_bodies()]
    if isinstance(spec.points, BodyPoints):
        carriers.insert(0, spec.points.body)
    poses = [included.pose(name) for name in carriers] or [included.placement]
    for name, other in zip(carriers, poses, strict=False):
        if not np.array_equal(other, poses[0]):
            raise CaseError(
                "joints move the bodies that carry this slave apart",
                where=spec.source_key,
                found=f"{carriers[0]}, {name}",
                remedy="Leave these joints as drawn",
            )
    return poses[0]


def _pose_source(included: Included, table: Table, pose: FloatArray) -> None:
    """Pose a geometry, or points."""
    for key, name in (("align", "to"), ("place", "on")):
        if name in table.get(key, {}):
            table[key][name] = included.called(table[key][name])
    table["then"] = [*table.get("then", []), *_steps(pose)]


def _pose_motion(included: Included, spec: Any, motion: Table, pose: FloatArray) -> None:
    """Pose the motion of a body or a slave, whose own pose is given."""
    kind = spec.kind
    if kind == "attached":
        motion["body"] = included.called(spec.body)
    elif kind in ("free", "deform") and "velocity" in motion:
        motion["velocity"] = _velocity(included, spec)
        if kind == "free":
            motion["spin"] = _vector(included.turn, motion["spin"])
            motion["hold"] = _ways(included.turn, motion["hold"], "motion.hold")
    elif kind in ("deform", "series"):
        if not np.array_equal(pose, np.eye(4)):
            _refuse("motion", "says itself where its points are, and cannot be placed", kind)
    else:
        _pose_told(included, spec, motion)


def _velocity(included: Included, spec: Any) -> list[float]:
    """Return the velocity at the start: its own, else that of the `include`."""
    given = included.spec.velocity
    if given is not None and "velocity" not in spec.model_fields_set:
        return given
    return _vector(included.turn, spec.velocity)


def _pose_told(included: Included, spec: Any, motion: Table) -> None:
    """Pose a motion that is told beforehand."""
    turn = included.turn
    kind = spec.kind
    if kind == "combine":
        for one, part in zip(spec.motions, motion["motions"], strict=True):
            _pose_told(included, one, part)
    elif kind == "translate":
        motion["table"] = [[row[0], *_vector(turn, row[1:])] for row in spec.table]
    elif kind == "rotate":
        motion["axis"] = _vector(turn, unit_axis(spec.axis))
        motion["centre"] = _point(included.placement, spec.centre)
    elif kind in ("velocity", "acceleration"):
        if kind == "acceleration":
            motion["velocity"] = _vector(turn, spec.velocity)
        if spec.direction is not None:
            motion["direction"] = _vector(turn, unit_axis(spec.direction))
        elif spec.table is not None:
            motion["table"] = [[row[0], *_vector(turn, row[1:])] for row in spec.table]
        elif not np.array_equal(turn, np.eye(3)):
            _refuse("motion.file", "its three columns cannot be turned", spec.file)
    elif kind == "poses" and included.moves:
        _refuse("motion", "poses of the world cannot be placed", kind)


def _pose_deforming(included: Included, spec: Any, motion: Table, pose: FloatArray) -> None:
    """Pose what a slave that deforms says of its nodes and materials."""
    turn = pose[:3, :3]
    turned = not np.array_equal(turn, np.eye(3))
    for key in ("fixed", "driven", "attached", "masses", "loads"):
        for k, one in enumerate(motion.get(key, [])):
            given = getattr(spec, key)[k]
            try:
                _pose_nodes(one, pose)
                if "hold" in one:
                    one["hold"] = _ways(included.turn, one["hold"], "hold")
                if key == "attached":
                    one["body"] = included.called(given.body)
                elif key == "driven":
                    _pose_told(included, given.motion, one["motion"])
                elif "force" in one:
                    one["force"] = _over_time(included.turn, one["force"])
            except InputError as error:
                raise relocated(error, f"motion.{key}[{k}]", "") from error
    if isinstance(motion.get("reference", {}).get("scale"), list) and turned:
        _refuse("motion.reference.scale", "is along x, y and z, and cannot be turned", "three")
    if spec.reference is None or spec.reference.file is None:
        for made in (motion, *motion.get("parts", [])):
            if "direction" in made.get("material", {}):
                made["material"]["direction"] = _vector(turn, made["material"]["direction"])


def _pose_nodes(table: Table, pose: FloatArray) -> None:
    """Pose the place that chooses nodes."""
    turn = pose[:3, :3]
    if "plane" in table:
        point, normal = table["plane"]
        table["plane"] = [_point(pose, point), _vector(turn, normal)]
    for key in ("side", "layer"):
        if key in table:
            table[key]["direction"] = _vector(turn, table[key]["direction"])
    if "box" in table:
        _quarters(turn, "box")
        corners = np.array([_point(pose, corner) for corner in table["box"]])
        table["box"] = [corners.min(axis=0).tolist(), corners.max(axis=0).tolist()]
    if "curve" in table and not np.array_equal(pose, np.eye(4)):
        _refuse("curve", "cannot be placed", "a curve")


def _pose_belt(included: Included, spec: BeltSpec, table: Table) -> None:
    path = table["path"]
    path["over"] = [included.called(name) for name in spec.path.over]
    path["via"] = [_point(included.placement, point) for point in spec.path.via]
    for key, anchor in zip(("start", "end"), spec.anchors, strict=True):
        path[key] = _point(included.pose(anchor), path[key])
    table["name"] = included.called(spec.name)
    table["anchors"] = [_end(included, name) for name in spec.anchors]
    table["velocity"] = _velocity(included, spec)
    for end in spec.webbing:
        _name_triggers(included, table[end])


def _pose_contact(included: Included, spec: Any, table: Table) -> None:
    table["name"] = included.called(spec.title)
    for key in ("master", "slave"):
        table[key] = included.called(table[key])


def _pose_load(included: Included, spec: Any, table: Table) -> None:
    pose = included.pose(spec.body)
    table["body"] = included.called(spec.body)
    if "at" in table:
        table["at"] = _point(pose, table["at"])
    for key in ("force", "moment"):
        if key in table:
            table[key] = _over_time(pose[:3, :3] if spec.follow else included.turn, table[key])


def _pose_spring(included: Included, spec: Any, table: Table) -> None:
    table["name"] = included.called(spec.made.name)
    table["between"] = [_end(included, name) for name in spec.between]
    table["at"] = _points(included, spec.between, spec.at)
    _name_triggers(included, table)


def _pose_slip_ring(included: Included, spec: Any, table: Table) -> None:
    table["name"] = included.called(spec.made.name)
    table["between"] = [included.called(name) for name in spec.between]


def _pose_joint(included: Included, spec: Any, table: Table) -> None:
    joint = spec.made
    turns = [included.pose(name)[:3, :3] for name in joint.between]
    table["name"] = included.called(joint.name)
    table["between"] = [_end(included, name) for name in joint.between]
    table["at"] = _points(included, joint.between, joint.at.tolist())
    if spec.axis is not None or joint.kind == "spherical":
        table["axis"] = [_vector(turns[side], joint.axis[side]) for side in (0, 1)]
    given = included.spec.coordinates({joint.name: joint}).get(joint.name, {})
    if "travel" in given:
        # A joint starts at its travel where both points of `at` meet.
        drawn = joint.laws["travel"].start if "travel" in joint.laws else 0.0
        way = (float(given["travel"]) - drawn) * joint.axis[0]  # type: ignore[arg-type]
        table["at"][0] = _point(included.pose(joint.between[0]), joint.at[0] + way)
    for key, value in given.items():
        # The axes on both bodies say how far the cone is open.
        if key not in ("cone", "about") and (value or key in table):
            table[key] = table.get(key, {}) | {"start": value}


def _pose_gas(included: Included, spec: Any, table: Table) -> None:
    table["name"] = included.called(spec.name)
    table["slave"] = included.called(spec.slave)
    slaves = {one.name: one for one in included.tables.slave}
    pose = included.placement
    if spec.slave in slaves:
        pose = _pose_of_slave(included, slaves[spec.slave])
    for kind in ("inflator", "vent"):
        for k, opening in enumerate(table[kind]):
            for key in ("trigger", "to"):
                if key in opening:
                    opening[key] = included.called(opening[key])
            try:
                _pose_nodes(opening.get("on", {}), pose)
            except InputError as error:
                raise relocated(error, f"{kind}[{k}].on", "") from error


def _pose_sensor(included: Included, spec: Any, table: Table) -> None:
    table["name"] = included.called(spec.name)
    slaves = {one.name: one for one in included.tables.slave}
    for key in ("node", "section"):
        if key in table:
            slave = slaves.get(table[key])
            pose = included.placement if slave is None else _pose_of_slave(included, slave)
            if "at" in table:
                table["at"] = _point(pose, table["at"])
            _pose_nodes(table, pose)
            table[key] = included.called(table[key])
            return
    bodies = [spec.body] if "body" in table else spec.between
    if "at" in table and "body" in table:
        table["at"] = _point(included.pose(spec.body), table["at"])
    elif "at" in table:
        table["at"] = _points(included, spec.between, spec.at)
    turn = included.pose(bodies[0])[:3, :3]
    if spec.axes != "world" and not np.array_equal(turn, np.eye(3)):
        rows = np.eye(3) if isinstance(spec.axes, str) else np.array(spec.axes)
        table["axes"] = [_vector(turn, row) for row in rows]
    for key in ("body", "between"):
        if key in table:
            named = table[key]
            table[key] = included.called(named) if key == "body" else [*map(included.called, named)]


def _pose_plot(included: Included, spec: Any, table: Table) -> None:
    table["x"] = included.channel(spec.x)
    table["y"] = [included.channel(name) for name in spec.channels]


def _pose_reference(included: Included, spec: Any, table: Table) -> None:
    table["x"] = included.channel(spec.x)
    table["channel"] = included.channel(spec.channel)


def _name_triggers(included: Included, table: Table) -> None:
    """Name the sensors that devices of a spring wait for."""
    devices = [table.get(key, {}) for key in ("pretensioner", "release")]
    devices.append(table.get("retractor", {}).get("lock", {}))
    for device in devices:
        if "trigger" in device:
            device["trigger"] = included.called(device["trigger"])


def _end(included: Included, name: str) -> str:
    return name if name in (GROUND, FREE) else included.called(name)


def _points(included: Included, bodies: Iterable[str], points: Any) -> list[list[float]]:
    """Return points, one on each body, where these are."""
    return [_point(included.pose(b), p) for b, p in zip(bodies, points, strict=True)]


def _point(pose: FloatArray, point: Any) -> list[float]:
    values = product(pose[:3, :3], np.asarray(point, np.float64)) + pose[:3, 3]
    return cast("list[float]", values.tolist())


def _vector(turn: FloatArray, vector: Any) -> list[float]:
    return cast("list[float]", product(turn, np.asarray(vector, np.float64)).tolist())


def _over_time(turn: FloatArray, given: Any) -> Any:
    """Turn a vector, or rows [t, x, y, z]."""
    if given and isinstance(given[0], list):
        return [[row[0], *_vector(turn, row[1:])] for row in given]
    return _vector(turn, given)


def _ways(turn: FloatArray, ways: list[str], where: str) -> list[str]:
    """Turn directions that are held: of x, y, z, rx, ry, rz."""
    moved = [way for way in ways if way in "xyz"]
    turned = [way[1:] for way in ways if way not in "xyz"]
    if len(moved) in (0, 3) and len(turned) in (0, 3):
        return ways
    _quarters(turn, where)
    named = partial(_way, turn)
    return [*map(named, moved), *(f"r{named(way)}" for way in turned)]


def _way(turn: FloatArray, way: str) -> str:
    return "xyz"[int(np.argmax(np.abs(turn[:, "xyz".index(way)])))]


def _quarters(turn: FloatArray, where: str) -> None:
    """Refuse a rotation that is not one of quarter turns about the axes of the world."""
    if np.abs(turn - np.round(turn)).max() > _SQUARE:
        _refuse(where, "is along the axes of the world, and turns by quarters alone", where)


def _refuse(where: str, what: str, found: object) -> None:
    remedy = "Write this table in the case itself, at its final place"
    raise CaseError(what, where=where, found=found, remedy=remedy)


def _steps(pose: FloatArray) -> list[Table]:
    """Return a pose as steps of a transform."""
    steps: list[Table] = []
    q = quaternion.from_matrix(pose[:3, :3])
    sine = float(np.sqrt(np.square(q[1:]).sum()))
    if sine > 0.0:
        degrees = math.degrees(2.0 * math.atan2(sine, float(q[0])))
        steps.append({"rotate": {"axis": (q[1:] / sine).tolist(), "degrees": degrees}})
    if pose[:3, 3].any():
        steps.append({"translate": pose[:3, 3].tolist()})
    return steps


POSERS: Mapping[str, Callable[[Included, Any, Table], None]] = {
    "body": _pose_body,
    "slave": _pose_slave,
    "belt": _pose_belt,
    "contact": _pose_contact,
    "load": _pose_load,
    "spring": _pose_spring,
    "slip_ring": _pose_slip_ring,
    "joint": _pose_joint,
    "gas": _pose_gas,
    "sensor": _pose_sensor,
    "plot": _pose_plot,
    "reference": _pose_reference,
}
"""Tables that a file may have which a case includes, and how each is posed."""
