"""Tables of an included file, with other names and in another posture.

Points move with the body that they are on, else with the placement. Directions, velocities and
forces turn with the placement; those that follow a body turn with the body.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, cast

import numpy as np

from contiga.arrays.ordered import product
from contiga.case.belt_spec import BeltSpec
from contiga.case.include_spec import IncludeSpec
from contiga.case.points_spec import BodyPoints
from contiga.case.problems import errors_at
from contiga.dynamics.belt import FREE
from contiga.dynamics.springs import GROUND
from contiga.errors import CaseError
from contiga.records import FloatArray
from contiga.rigid import quaternion
from contiga.rigid.transform import unit_axis

KEYS = (
    *("body", "slave", "belt", "contact", "load", "spring", "slip_ring", "joint", "gas"),
    *("sensor", "plot", "reference"),
)
"""Keys of the tables that an included file may have."""
Table = dict[str, Any]
_QUARTER_TOL = 1e-12
"""Largest departure of an entry of a rotation by quarter turns from 0 or ±1."""


class Included(NamedTuple):
    """An included file, checked, and the poses of its bodies."""

    spec: IncludeSpec
    tables: Any
    """Its tables."""
    names: frozenset[str]
    """Names that it defines."""
    placement: FloatArray
    """(4, 4), of all of it."""
    posture: Mapping[str, FloatArray]
    """Poses (4, 4) by body, from joints; they come before the placement, others stay as drawn."""

    def name(self, name: str) -> str:
        """Return the name in the case for a name in the file."""
        return self.spec.prefix + name if name in self.names else name

    def pose(self, body: str) -> FloatArray:
        """Return the pose (4, 4) that moves points on a body from where they are drawn.

        It is the posture of the body, then the placement; of other names the placement alone.
        """
        if body not in self.posture:
            return self.placement
        return product(self.placement, self.posture[body])

    @property
    def rotation(self) -> FloatArray:
        """Rotation (3, 3) of its placement."""
        return self.placement[:3, :3]

    def channel(self, name: str) -> str:
        """Return the name in the case of a channel of the file."""
        owner, dot, column = name.rpartition(".")
        return f"{self.name(owner)}{dot}{column}"


def names_of(tables: Any) -> frozenset[str]:
    """Return the names that the tables of a file define, default names and belt ends included."""
    named = (*tables.body, *tables.slave, *tables.belt, *tables.gas, *tables.sensor)
    with_default_name = (*tables.spring, *tables.slip_ring, *tables.joint)
    names = {spec.name for spec in named} | {spec.instance.name for spec in with_default_name}
    names |= {contact.title for contact in tables.contact}
    return frozenset(names | {f"{belt.name} {end}" for belt in tables.belt for end in belt.webbing})


def tables_posed(included: Included) -> dict[str, list[Table]]:
    """Return the tables of a file by key, as a case in that posture would have them.

    Raises
    ------
    CaseError
        A table cannot be placed: the message has its key in the file.
    """
    tables: dict[str, list[Table]] = {}
    for key in KEYS:
        tables[key] = []
        for i, spec in enumerate(getattr(included.tables, key)):
            table = spec.model_dump(exclude_none=True, by_alias=True)
            with errors_at(f"{key}[{i}]", included.spec.file):
                _pose_table(included, key, spec, table)
            tables[key].append(table)
    return tables


def _pose_table(included: Included, key: str, spec: Any, table: Table) -> None:
    """Change `table`, which `spec` was made from, to its names and place in the case."""
    match key:
        case "body":
            _pose_body(included, spec, table)
        case "slave":
            _pose_slave(included, spec, table)
        case "belt":
            _pose_belt(included, spec, table)
        case "contact":
            table["name"] = included.name(spec.title)
            for side in ("master", "slave"):
                table[side] = included.name(table[side])
        case "load":
            pose = included.pose(spec.body)
            table["body"] = included.name(spec.body)
            if "at" in table:
                table["at"] = _point(pose, table["at"])
            for load in ("force", "moment"):
                if load in table:
                    rotation = pose[:3, :3] if spec.follow else included.rotation
                    table[load] = _over_time(rotation, table[load])
        case "spring":
            table["name"] = included.name(spec.instance.name)
            table["between"] = [_end(included, name) for name in spec.between]
            table["at"] = _points(included, spec.between, spec.at)
            _name_triggers(included, table)
        case "slip_ring":
            table["name"] = included.name(spec.instance.name)
            table["between"] = [included.name(name) for name in spec.between]
        case "joint":
            _pose_joint(included, spec, table)
        case "gas":
            _pose_gas(included, spec, table)
        case "sensor":
            _pose_sensor(included, spec, table)
        case "plot":
            table["x"] = included.channel(spec.x)
            table["y"] = [included.channel(name) for name in spec.channels]
        case "reference":
            table["x"] = included.channel(spec.x)
            table["channel"] = included.channel(spec.channel)


def _pose_body(included: Included, spec: Any, table: Table) -> None:
    """Pose the `table` of a body; CaseError if joints would move one whose motion is prescribed."""
    pose = included.pose(spec.name)
    table["name"] = included.name(spec.name)
    _pose_source(included, table["geometry"], pose)
    if "reference_point" in table:
        table["reference_point"] = _point(pose, table["reference_point"])
    mass = table.get("mass", {})
    if "centre" in mass:
        mass["centre"] = _point(pose, mass["centre"])
    if "inertia" in mass:
        xx, yy, zz, xy, yz, xz = mass["inertia"]
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        rotated = product(product(pose[:3, :3], tensor), pose[:3, :3].T)
        rows = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
        mass["inertia"] = [float(rotated[i, j]) for i, j in rows]
    is_prescribed = spec.motion.kind not in ("free", "attached", "fixed")
    posture = included.posture.get(spec.name, np.eye(4))
    if is_prescribed and not np.array_equal(posture, np.eye(4)):
        raise CaseError(
            "joints would move a body whose motion is told beforehand",
            where="motion",
            found=spec.motion.kind,
            remedy="Make it the root, or draw it where it starts",
        )
    _pose_motion(included, spec.motion, table["motion"], pose)


def _pose_slave(included: Included, spec: Any, table: Table) -> None:
    """Pose the `table` of a slave with the bodies that carry it."""
    pose = _pose_of_slave(included, spec)
    table["name"] = included.name(spec.name)
    source = table[spec.source_key]
    _pose_source(included, source, pose)
    if isinstance(spec.points, BodyPoints):
        source["body"] = included.name(spec.points.body)
    motion = table["motion"]
    _pose_motion(included, spec.motion, motion, pose)
    if spec.motion.kind == "deform":
        _pose_deforming(included, spec.motion, motion, pose)


def _pose_of_slave(included: Included, spec: Any) -> FloatArray:
    """Return the pose (4, 4) of the bodies that carry a slave; the placement if none does.

    Raises
    ------
    CaseError
        Joints move these bodies apart.
    """
    carriers = [name for _, name in spec.motion.named_bodies()]
    if isinstance(spec.points, BodyPoints):
        carriers.insert(0, spec.points.body)
    poses = [included.pose(name) for name in carriers] or [included.placement]
    for name, pose in zip(carriers, poses, strict=False):
        if not np.array_equal(pose, poses[0]):
            raise CaseError(
                "joints move the bodies that carry this slave apart",
                where=spec.source_key,
                found=f"{carriers[0]}, {name}",
                remedy="Leave these joints as drawn",
            )
    return poses[0]


def _pose_source(included: Included, table: Table, pose: FloatArray) -> None:
    """Pose the `table` of a geometry, or of points: append rotation and translation to its `then`.

    A step that changes nothing is left out. Names in `align` and `place` get the prefix.
    """
    for key, reference in (("align", "to"), ("place", "on")):
        if reference in table.get(key, {}):
            table[key][reference] = included.name(table[key][reference])
    steps: list[Table] = []
    q = quaternion.from_matrix(pose[:3, :3])
    sine = float(np.sqrt(np.square(q[1:]).sum()))
    if sine > 0.0:
        degrees = math.degrees(2.0 * math.atan2(sine, float(q[0])))
        steps.append({"rotate": {"axis": (q[1:] / sine).tolist(), "degrees": degrees}})
    if pose[:3, 3].any():
        steps.append({"translate": pose[:3, 3].tolist()})
    table["then"] = [*table.get("then", []), *steps]


def _pose_motion(included: Included, spec: Any, motion: Table, pose: FloatArray) -> None:
    """Pose `motion`, the table of the motion of a body or a slave whose own pose is `pose`.

    Raises
    ------
    CaseError
        A motion that says itself where points are, or directions held askew, cannot be posed.
    """
    kind = spec.kind
    if kind == "attached":
        motion["body"] = included.name(spec.body)
    elif kind in ("free", "deform") and "velocity" in motion:
        motion["velocity"] = _velocity(included, spec)
        if kind == "free":
            motion["spin"] = _vector(included.rotation, motion["spin"])
            motion["hold"] = _directions(included.rotation, motion["hold"], "motion.hold")
    elif kind in ("deform", "series"):
        if not np.array_equal(pose, np.eye(4)):
            _refuse("motion", "says itself where its points are, and cannot be placed", kind)
    else:
        _pose_prescribed(included, spec, motion)


def _velocity(included: Included, spec: Any) -> list[float]:
    """Return the velocity at the start: the part's own, turned, else that of the `include`."""
    velocity = included.spec.velocity
    if velocity is not None and "velocity" not in spec.model_fields_set:
        return velocity
    return _vector(included.rotation, spec.velocity)


def _pose_prescribed(included: Included, spec: Any, motion: Table) -> None:
    """Turn `motion`, a prescribed one, with the placement, which also moves centres of rotation.

    Raises
    ------
    CaseError
        Poses of the world, or a file of three columns, would have to turn.
    """
    rotation = included.rotation
    kind = spec.kind
    if kind == "combine":
        for motion_spec, table in zip(spec.motions, motion["motions"], strict=True):
            _pose_prescribed(included, motion_spec, table)
    elif kind == "translate":
        motion["table"] = [[row[0], *_vector(rotation, row[1:])] for row in spec.table]
    elif kind == "rotate":
        motion["axis"] = _vector(rotation, unit_axis(spec.axis))
        motion["centre"] = _point(included.placement, spec.centre)
    elif kind in ("velocity", "acceleration"):
        if kind == "acceleration":
            motion["velocity"] = _vector(rotation, spec.velocity)
        if spec.direction is not None:
            motion["direction"] = _vector(rotation, unit_axis(spec.direction))
        elif spec.table is not None:
            motion["table"] = [[row[0], *_vector(rotation, row[1:])] for row in spec.table]
        elif not np.array_equal(rotation, np.eye(3)):
            _refuse("motion.file", "its three columns cannot be turned", spec.file)
    elif kind == "poses" and not np.array_equal(included.placement, np.eye(4)):
        _refuse("motion", "poses of the world cannot be placed", kind)


def _pose_deforming(included: Included, spec: Any, motion: Table, pose: FloatArray) -> None:
    """Pose the selections of nodes and the warp directions in `motion` of a slave that deforms.

    Selections and directions turn with the slave's `pose`; held directions, driving motions and
    forces with the placement. Warp directions stay if a file has the shape of reference.

    Raises
    ------
    CaseError
        A box or held directions would turn by other than quarters, or scales along axes at all.
    """
    rotation = pose[:3, :3]
    for key in ("fixed", "driven", "attached", "masses", "loads"):
        for k, table in enumerate(motion.get(key, [])):
            node_spec = getattr(spec, key)[k]
            with errors_at(f"motion.{key}[{k}]"):
                _pose_nodes(table, pose)
                if "hold" in table:
                    table["hold"] = _directions(included.rotation, table["hold"], "hold")
                if key == "attached":
                    table["body"] = included.name(node_spec.body)
                elif key == "driven":
                    _pose_prescribed(included, node_spec.motion, table["motion"])
                elif "force" in table:
                    table["force"] = _over_time(included.rotation, table["force"])
    if isinstance(motion.get("reference", {}).get("scale"), list) and not np.array_equal(
        rotation, np.eye(3)
    ):
        _refuse("motion.reference.scale", "is along x, y and z, and cannot be turned", "three")
    if spec.reference is None or spec.reference.file is None:
        for part in (motion, *motion.get("parts", [])):
            if "direction" in part.get("material", {}):
                part["material"]["direction"] = _vector(rotation, part["material"]["direction"])


def _pose_nodes(table: Table, pose: FloatArray) -> None:
    """Pose the place in `table` that selects nodes.

    Raises
    ------
    CaseError
        A box would turn by other than quarters, or a curve would move.
    """
    rotation = pose[:3, :3]
    if "plane" in table:
        point, normal = table["plane"]
        table["plane"] = [_point(pose, point), _vector(rotation, normal)]
    for key in ("side", "layer"):
        if key in table:
            table[key]["direction"] = _vector(rotation, table[key]["direction"])
    if "box" in table:
        _check_quarters(rotation, "box")
        corners = np.array([_point(pose, corner) for corner in table["box"]])
        table["box"] = [corners.min(axis=0).tolist(), corners.max(axis=0).tolist()]
    if "curve" in table and not np.array_equal(pose, np.eye(4)):
        _refuse("curve", "cannot be placed", "a curve")


def _pose_belt(included: Included, spec: BeltSpec, table: Table) -> None:
    """Pose the `table` of a belt: ends move with their anchors, `via` points with the placement."""
    path = table["path"]
    path["over"] = [included.name(name) for name in spec.path.over]
    path["via"] = [_point(included.placement, point) for point in spec.path.via]
    for key, anchor in zip(("start", "end"), spec.anchors, strict=True):
        path[key] = _point(included.pose(anchor), path[key])
    table["name"] = included.name(spec.name)
    table["anchors"] = [_end(included, name) for name in spec.anchors]
    table["velocity"] = _velocity(included, spec)
    for end in spec.webbing:
        _name_triggers(included, table[end])


def _pose_joint(included: Included, spec: Any, table: Table) -> None:
    """Pose the `table` of a joint, whose points and axes move with its bodies.

    Laws start at the coordinates of the posture. The first point is shifted along the axis, so that
    both points meet at the given travel.
    """
    joint = spec.instance
    rotations = [included.pose(name)[:3, :3] for name in joint.between]
    table["name"] = included.name(joint.name)
    table["between"] = [_end(included, name) for name in joint.between]
    table["at"] = _points(included, joint.between, joint.at.tolist())
    if spec.axis is not None or joint.kind == "spherical":
        table["axis"] = [_vector(rotations[side], joint.axis[side]) for side in (0, 1)]
    coordinates = included.spec.coordinates({joint.name: joint}).get(joint.name, {})
    if "travel" in coordinates:
        start = joint.laws["travel"].start if "travel" in joint.laws else 0.0
        shift = (float(coordinates["travel"]) - start) * joint.axis[0]  # type: ignore[arg-type]
        table["at"][0] = _point(included.pose(joint.between[0]), joint.at[0] + shift)
    for key, value in coordinates.items():
        # The axes on both bodies say how far the cone is open.
        if key not in ("cone", "about") and (value or key in table):
            table[key] = table.get(key, {}) | {"start": value}


def _pose_gas(included: Included, spec: Any, table: Table) -> None:
    """Pose openings in `table` with the slave; names of triggers and chambers get the prefix."""
    table["name"] = included.name(spec.name)
    table["slave"] = included.name(spec.slave)
    slaves = {slave.name: slave for slave in included.tables.slave}
    pose = included.placement
    if spec.slave in slaves:
        pose = _pose_of_slave(included, slaves[spec.slave])
    for kind in ("inflator", "vent"):
        for k, opening in enumerate(table[kind]):
            for key in ("trigger", "to"):
                if key in opening:
                    opening[key] = included.name(opening[key])
            with errors_at(f"{kind}[{k}].on"):
                _pose_nodes(opening.get("on", {}), pose)


def _pose_sensor(included: Included, spec: Any, table: Table) -> None:
    """Pose the `table` of a sensor with its slave or bodies; its own axes turn with the first body.

    Axes "world" stay as they are.
    """
    table["name"] = included.name(spec.name)
    slaves = {slave.name: slave for slave in included.tables.slave}
    for key in ("node", "section"):
        if key in table:
            slave = slaves.get(table[key])
            pose = included.placement if slave is None else _pose_of_slave(included, slave)
            if "at" in table:
                table["at"] = _point(pose, table["at"])
            _pose_nodes(table, pose)
            table[key] = included.name(table[key])
            return
    bodies = [spec.body] if "body" in table else spec.between
    if "at" in table and "body" in table:
        table["at"] = _point(included.pose(spec.body), table["at"])
    elif "at" in table:
        table["at"] = _points(included, spec.between, spec.at)
    rotation = included.pose(bodies[0])[:3, :3]
    if spec.axes != "world" and not np.array_equal(rotation, np.eye(3)):
        rows = np.eye(3) if isinstance(spec.axes, str) else np.array(spec.axes)
        table["axes"] = [_vector(rotation, row) for row in rows]
    if "body" in table:
        table["body"] = included.name(table["body"])
    if "between" in table:
        table["between"] = [included.name(name) for name in table["between"]]


def _name_triggers(included: Included, table: Table) -> None:
    """Replace names of sensors that trigger the devices in `table` by their names in the case."""
    devices = [table.get(key, {}) for key in ("pretensioner", "release")]
    devices.append(table.get("retractor", {}).get("lock", {}))
    for device in devices:
        if "trigger" in device:
            device["trigger"] = included.name(device["trigger"])


def _end(included: Included, name: str) -> str:
    return name if name in (GROUND, FREE) else included.name(name)


def _points(included: Included, bodies: Iterable[str], points: Any) -> list[list[float]]:
    """Return points, one on each body, moved with their bodies."""
    return [_point(included.pose(b), p) for b, p in zip(bodies, points, strict=True)]


def _point(pose: FloatArray, point: Any) -> list[float]:
    values = product(pose[:3, :3], np.asarray(point, np.float64)) + pose[:3, 3]
    return cast("list[float]", values.tolist())


def _vector(rotation: FloatArray, vector: Any) -> list[float]:
    return cast("list[float]", product(rotation, np.asarray(vector, np.float64)).tolist())


def _over_time(rotation: FloatArray, value: Any) -> Any:
    """Return a vector, or rows [t, x, y, z], turned by `rotation`."""
    if value and isinstance(value[0], list):
        return [[row[0], *_vector(rotation, row[1:])] for row in value]
    return _vector(rotation, value)


def _directions(rotation: FloatArray, directions: list[str], key: str) -> list[str]:
    """Return held `directions`, of x, y, z, rx, ry and rz, turned by `rotation`.

    All three, or none, of translations and rotations stay as they are.

    Raises
    ------
    CaseError
        Others would turn by other than quarters.
    """
    translations = [direction for direction in directions if direction in "xyz"]
    rotations = [direction[1:] for direction in directions if direction not in "xyz"]
    if len(translations) in (0, 3) and len(rotations) in (0, 3):
        return directions
    _check_quarters(rotation, key)
    columns = np.abs(rotation).argmax(axis=0)
    axes = {axis: "xyz"[columns["xyz".index(axis)]] for axis in "xyz"}
    return [*(axes[axis] for axis in translations), *(f"r{axes[axis]}" for axis in rotations)]


def _check_quarters(rotation: FloatArray, key: str) -> None:
    """Refuse a rotation that is not one of quarter turns about the axes of the world."""
    if np.abs(rotation - np.round(rotation)).max() > _QUARTER_TOL:
        _refuse(key, "is along the axes of the world, and turns by quarters alone", key)


def _refuse(key: str, rule: str, found: object) -> None:
    """Raise a CaseError that advises to write the table in the case itself."""
    remedy = "Write this table in the case itself, at its final place"
    raise CaseError(rule, where=key, found=found, remedy=remedy)
