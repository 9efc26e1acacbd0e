"""Contents of a preview: parts at the start, their prescribed motion, gaps of contacts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.contact.search_records import reach_of
from contiga.dynamics.deforming import Deforming
from contiga.dynamics.free import Dependent, Free
from contiga.masters.nearness import gaps_and_feet, nearest
from contiga.records import FloatArray, IntArray
from contiga.rendering.camera import unit
from contiga.report.run_folder import Units, units_of
from contiga.rigid.frames import to_body, to_world
from contiga.simulation.checks.approach import closest_approach
from contiga.simulation.checks.scene import Pair
from contiga.simulation.joints import joint_lines
from contiga.simulation.model import BodyPart, Model, SlavePart
from contiga.simulation.step import Placement, place
from contiga.slaves.slave import box_of

COLOURS = ("#8fa3bd", "#9db89a", "#b8a0c4", "#d2b27c", "#88b4b4", "#a9a9b4")
"""Colours of the free sides of bodies, in turn."""
CONTACT_SIDE = "#c9806a"
SLAVES = ("#cfc5aa", "#b9c8ad", "#d6b9a2")
_TRIANGLE_TOL = 5e-4
"""Largest departure of the drawn triangles from a body, relative to its size."""
_MAX_PROJECTED = 200
"""Largest number of points of a slave that are projected to see whether it is a skin."""
_N_NORMALS = 9
"""Number of normals shown on each body."""
_N_TIMES = 61
"""Number of instants through which a motion is drawn."""


class Drawn(NamedTuple):
    """A part at its place at the start."""

    name: str
    is_body: bool
    points: FloatArray
    """(n, 3), world axes."""
    triangles: IntArray
    """(m, 3) rows of the points, none for a bare cloud."""
    active: NDArray[np.bool_]
    """(n,) points that take part in contact."""
    colour: str

    @property
    def box(self) -> FloatArray:
        """The box (2, 3) of the fully drawn points: of a slave its active ones, if any."""
        return box_of(self.points, self.active)


class Arrow(NamedTuple):
    """A direction at a place: a normal, or the velocity of a free part."""

    name: str
    at: FloatArray
    """(3,) its place."""
    vector: FloatArray
    """(3,) a unit vector, or a velocity."""


class MotionPath(NamedTuple):
    """The prescribed paths of a few points of a part."""

    name: str
    lines: FloatArray
    """(k, times, 3) paths."""


class Gap(NamedTuple):
    """The closest point of a slave, or the deepest one inside, and its foot at the start."""

    contact: str
    master: str
    slave: str
    value: float
    """Gap, length; negative if the slave begins inside."""
    ends: FloatArray
    """(2, 3) the point and its foot."""
    approach: tuple[float, float] | None = None
    """Lower bound of the distance, and its time, if prescribed motions never let the sides meet."""


class Tie(NamedTuple):
    """A line of the preview at the start of the run: a spring, or part of a joint."""

    name: str
    ends: FloatArray
    """(2, 3), world axes."""
    kind: str = "spring"
    """"spring" or "joint"."""


class Stage(NamedTuple):
    """The contents of a preview."""

    title: str
    units: Units
    parts: tuple[Drawn, ...]
    normals: tuple[Arrow, ...]
    paths: tuple[MotionPath, ...]
    velocities: tuple[Arrow, ...]
    gaps: tuple[Gap, ...]
    ties: tuple[Tie, ...] = ()

    @property
    def velocity_ends(self) -> FloatArray:
        """Start and tip (k, 2, 3) of an arrow for each of `velocities`, world axes.

        It ends behind the box of its part, so that neither this part nor the part ahead hides it.
        Its length is 0.4 of the part's size, whatever the speed.
        """
        ends = []
        for arrow in self.velocities:
            part, towards = self.part(arrow.name), unit(arrow.vector)
            extent = np.ptp(part.box, axis=0)
            size = float(np.linalg.norm(extent))
            tip = arrow.at - (0.5 * float(extent @ np.abs(towards)) + 0.04 * size) * towards
            ends.append([tip - 0.4 * size * towards, tip])
        return np.reshape(ends, (-1, 2, 3))

    @property
    def box(self) -> FloatArray:
        """The lowest and highest corner (2, 3) of a box about all parts, springs and joints."""
        boxes = np.array(
            [part.box for part in self.parts] + [np.sort(tie.ends, axis=0) for tie in self.ties]
        )
        return np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])

    @property
    def plane(self) -> bool:
        """Whether the problem is plane: slave points have one z, and no normal has a z component.

        Tolerances are 1e-9 of the size of the scene, and 1e-6. False without slaves.
        """
        slaves = [part.points[:, 2] for part in self.parts if not part.is_body]
        flat = bool(slaves) and np.ptp(np.concatenate(slaves)) <= 1e-9 * float(np.ptp(self.box))
        return bool(flat and all(abs(arrow.vector[2]) < 1e-6 for arrow in self.normals))

    def part(self, name: str) -> Drawn:
        """Return the part of this name, which must exist."""
        return next(part for part in self.parts if part.name == name)


def stage_of(model: Model) -> Stage:
    """Return the contents of a preview of a model, placed at the start of its time.

    Velocities are those of free and deforming parts, of slaves the mean of their nodes; parts at
    rest have none.
    """
    start = place(model, None, model.stepping.start)
    parts = tuple(_parts(model, start))
    velocities = []
    for part in parts:
        motion = _entry_of(model, part).motion
        if isinstance(motion, Free | Deforming):
            velocity = np.reshape(motion.velocity, (-1, 3)).mean(axis=0)
            if velocity.any():
                velocities.append(Arrow(part.name, part.box.mean(axis=0), velocity))
    return Stage(
        title=model.title or "Preview",
        units=units_of(dict(zip(("length", "mass", "time"), model.units, strict=True))),
        parts=parts,
        normals=tuple(arrow for part in parts if part.is_body for arrow in _normals(part)),
        paths=tuple(_motion_paths(model, parts)),
        velocities=tuple(velocities),
        gaps=tuple(_gaps(model, start)),
        ties=(
            *(Tie(name, spring.at) for name, spring in model.springs.items()),
            *(
                Tie(name, line, "joint")
                for name, lines in joint_lines(model).items()
                for line in lines
            ),
        ),
    )


def _entry_of(model: Model, part: Drawn) -> BodyPart | SlavePart:
    """Return the entry of a model that a part shows."""
    return model.bodies[part.name] if part.is_body else model.slaves[part.name]


def _parts(model: Model, start: Placement) -> Iterator[Drawn]:
    """Yield bodies as triangles, then slaves as their facets with active corners.

    A slave without such facets is a cloud, and so is one that lies on the body that carries it: the
    surface of this is drawn already.
    """
    for k, (name, part) in enumerate(model.bodies.items()):
        mesh = part.body.tessellate(_TRIANGLE_TOL * part.body.size)
        points = to_world(start.bodies[name].pose, mesh.vertices)
        active = np.ones(len(points), np.bool_)
        yield Drawn(name, True, points, mesh.triangles, active, COLOURS[k % len(COLOURS)])
    bodies = [part.body for part in model.bodies.values()]
    for k, (name, slave_part) in enumerate(model.slaves.items()):
        slave = slave_part.slave
        facets = np.zeros((0, 3), np.int32) if slave.facets is None else slave.facets
        triangles = facets[slave.active[facets].all(axis=1)]
        host = model.mechanism.carrier_of_slave.get(name)
        if host is not None:
            body = bodies[host]
            gaps = body.project(slave.points[:: len(slave.points) // _MAX_PROJECTED + 1]).gap
            if np.nanmax(np.abs(gaps)) <= 4.0 * _TRIANGLE_TOL * body.size:
                triangles = triangles[:0]
        points = np.asarray(start.slaves[name].points)
        yield Drawn(name, False, points, triangles, slave.active, SLAVES[k % len(SLAVES)])


def _normals(part: Drawn) -> Iterator[Arrow]:
    """Yield unit normals to the free side at up to nine triangles, by farthest-point sampling.

    The first is at the first triangle, each next one at the middle farthest from all before.
    Triangles without area are skipped.
    """
    corners = part.points[part.triangles]
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.linalg.norm(crosses, axis=1)
    has_area = sizes > 1e-9 * sizes.max(initial=0.0)
    middles, normals = corners[has_area].mean(axis=1), crosses[has_area] / sizes[has_area, None]
    distances = np.full(len(middles), np.inf)  # squared, to the nearest normal so far
    for _ in range(min(_N_NORMALS, len(middles))):
        row = int(distances.argmax())
        yield Arrow(part.name, middles[row], normals[row])
        distances = np.minimum(distances, np.square(middles - middles[row]).sum(axis=1))


def _motion_paths(model: Model, parts: tuple[Drawn, ...]) -> Iterator[MotionPath]:
    """Yield the path of the middle of each part whose motion is prescribed.

    If the part turns, two of its ends have paths, too. Parts that stay in place are skipped.
    """
    times = np.linspace(model.stepping.start, model.stepping.end, _N_TIMES)
    placements = [place(model, None, float(time)) for time in times]
    for part in parts:
        if isinstance(_entry_of(model, part).motion, Dependent):
            continue
        # The middle of the box, and the two ends of its longest side.
        ends = np.tile(part.box.mean(axis=0), (3, 1))
        axis = int(np.ptp(part.box, axis=0).argmax())
        ends[1:, axis] = part.box[:, axis]
        if part.is_body:
            poses = np.array([placement.bodies[part.name].pose for placement in placements])
            p_B = to_body(poses[0], ends)
            lines = np.array([to_world(pose, p_B) for pose in poses]).transpose(1, 0, 2)
        else:
            rows = np.square(part.points[:, None] - ends[None]).sum(axis=2).argmin(axis=0)
            lines = np.array([p.slaves[part.name].points[rows] for p in placements])
            lines = lines.transpose(1, 0, 2)
        shifts = lines - lines[:, :1]
        if np.abs(shifts).max() <= 1e-9 * max(float(np.ptp(part.box)), 1e-300):
            continue
        is_translation = np.abs(shifts - shifts[:1]).max() <= 1e-6 * np.abs(shifts).max()
        yield MotionPath(part.name, lines[:1] if is_translation else lines)


def _gaps(model: Model, start: Placement) -> Iterator[Gap]:
    """Yield the smallest gap of each contact at the start, over the active points of its slave.

    If both motions are prescribed and the sides are proved to never meet, `approach` is a
    lower bound of their distance, and its time; else None. A contact without active points is
    skipped.
    """
    for part in model.contacts:
        points = np.asarray(start.slaves[part.slave].points)
        active = model.slaves[part.slave].slave.active & np.isfinite(points).all(axis=1)
        rows = np.flatnonzero(active).astype(np.int32)
        if len(rows) == 0:
            continue
        body, pose = model.bodies[part.master].body, start.bodies[part.master].pose
        p_B, reach = to_body(pose, points), reach_of(part.contact.depth, body.closed, body.size)
        gaps = nearest(body.surface, p_B, rows, depth=reach)
        row = slice(gaps.row, gaps.row + 1)
        _, feet = gaps_and_feet(body.surface, p_B[row], reach)
        ends = np.stack([points[gaps.row], to_world(pose, feet.point)[0]])
        pair, approach = Pair(model, part), None
        if pair.foretold and not pair.touches:
            closest = closest_approach(pair)
            if closest is not None and closest.bound > 0.0:
                approach = closest.bound, closest.time
        yield Gap(part.name, part.master, part.slave, gaps.gap, ends, approach)
