"""Compute the positions of the parts of a model at any time, as far as they are known before a run.

Prescribed parts follow their motions. Free parts fly from the start under gravity alone, until they
first touch something, if neither springs nor loads act.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from itertools import pairwise

import numpy as np

from contiga.arrays.ordered import length
from contiga.contact.dry_run import DryRun, spread
from contiga.dynamics.free import Dependent, Free
from contiga.dynamics.nodes import NodeMover
from contiga.dynamics.prescribed import BodyMotion, Moved, is_known_ahead, pose_at, rows_in
from contiga.masters.protocol import Master
from contiga.records import FloatArray
from contiga.rigid import pose, quaternion
from contiga.rigid.pose import to_quaternion
from contiga.rigid.rigid_lanes import CENTRE
from contiga.simulation.checks.finding import Quantities
from contiga.simulation.model import ContactPart, Model
from contiga.slaves.slave import Slave

# Number of times at which a motion is searched, and largest number of points in the search.
STANDINGS = 25
MAX_POINTS = 2_000
# Number of times if positions are read from a file.
_STANDINGS_FROM_FILES = 7
# Times at which relative paths are followed, beside the rows of tables: planned times, and further
# ones so that nothing rotates more in between, radians.
PLANNED = 100
TURN = 0.5
# A pulse of a second at 10 kHz. Paths with more times are not followed: the check would take too
# long.
MAX_TIMES = 10_000
# Part of a span over which a velocity or a rotation rate is measured.
INSTANT = 1e-3


class Pair:
    """One contact of the model: its two sides and their relative motion over time."""

    def __init__(self, model: Model, part: ContactPart) -> None:
        self.model = model
        self.part = part
        self.contact = part.contact
        self.body: Master = model.bodies[part.master].body
        self.slave: Slave = model.slaves[part.slave].slave
        self.where = f"contact {part.name}"
        self._relative: dict[float, FloatArray | None] = {}

    @cached_property
    def _mover(self) -> NodeMover:
        """The mover of the slave's points."""
        return self.model.mechanism.nodes[self.part.slave]

    @cached_property
    def _master_number(self) -> int:
        """Number of the master, or of the body to which it is attached."""
        return self.model.mechanism.root_of(self.part.master)

    @cached_property
    def free(self) -> bool:
        """Whether forces move one of the sides: its motion is known only until the first touch."""
        movers = self.model.mechanism.row
        return (
            self._master_number in movers
            or self._mover.host in movers
            or self._mover.mass is not None
        )

    @cached_property
    def foretold(self) -> bool:
        """Whether the relative motion of the sides is known until they touch."""
        if self.free and self.model.settling is not None:
            return False  # the start is the state at rest
        if self.free and self._has_devices:
            return False
        if self._mover.mass is not None and self._mover.flight is None:
            return False
        return all(
            isinstance(motion, Dependent) or is_known_ahead(motion) for motion in self._motions
        )

    @property
    def _has_devices(self) -> bool:
        """Whether forces other than gravity move free parts before the first touch."""
        model = self.model
        return bool(model.springs or model.joints or model.loads or model.gas)

    @cached_property
    def approach(self) -> FloatArray:
        """Times (k,) from the start to the first touch, as far as the motion is known.

        Elements are at rest until then, if neither loads nor motions move them.
        """
        if self.foretold:
            return self.shown_times[: _searches_to_touch(self.dry_runs)]
        motions = self._motions
        is_known = isinstance(motions[0], Dependent) or is_known_ahead(motions[0])
        is_pushed = self._has_devices or self.model.settling is not None
        times = spread(self.model.stepping.planned(), 2 * STANDINGS)
        if is_pushed or not (self._mover.is_at_rest and is_known):
            return times[:1]
        placements = (self.placement(time) for time in times.tolist())
        return times[: _searches_to_touch(self.contact.dry_run(placements, most=MAX_POINTS))]

    @cached_property
    def _motions(self) -> tuple[object, object]:
        """The motions of the body and the slave, or of the bodies to which they are attached."""
        slave: object = self.model.slaves[self.part.slave].motion
        if self._mover.host is not None:
            slave = self._body_motion(self._mover.host)
        return self._body_motion(self._master_number), slave

    @cached_property
    def times(self) -> FloatArray:
        """Times (k,) of the run between which the sides rotate little relative to each other.

        They include up to `PLANNED` planned steps and all rows of the motions' tables. If these are
        too many for `MAX_TIMES`, rotations may be larger and rows left out: see `followed`.
        """
        times = np.union1d(spread(self.model.stepping.planned(), PLANNED), self._table_times)
        if len(times) > MAX_TIMES:
            return spread(times, MAX_TIMES)
        spans = list(pairwise(times.tolist()))
        counts = [1 + int(self._rotation_between(first, last) / TURN) for first, last in spans]
        if sum(counts) >= MAX_TIMES:
            return times
        parts = [np.linspace(*span, n + 1)[1:] for span, n in zip(spans, counts, strict=True)]
        return np.concatenate([times[:1], *parts])

    @cached_property
    def followed(self) -> bool:
        """Whether `times` are dense enough to bound the motion in between."""
        spans = pairwise(self.times.tolist())
        return set(self._table_times) <= set(self.times) and all(
            self._rotation_between(first, last) <= 2.0 * TURN for first, last in spans
        )

    def _rotation_between(self, first: float, last: float) -> float:
        """Return the relative rotation of the sides between two times, radians, by the middle rate.

        No table has a row between the two times. It is 0 for a slave that deforms.
        """
        middle, instant = 0.5 * (first + last), INSTANT * (last - first)
        X, Y = self.relative_at(middle), self.relative_at(middle + instant)
        if X is None or Y is None:
            return 0.0
        turn = quaternion.rotation_vector(to_quaternion(X), to_quaternion(Y))
        return length(turn) / INSTANT

    @cached_property
    def _table_times(self) -> FloatArray:
        """Times (k,) of the run at which a table of the motions has a row."""
        start, end = self.model.stepping.start, self.model.stepping.end
        rows = np.concatenate([rows_in(motion) for motion in self._motions])
        return np.unique(rows[(rows > start) & (rows < end)])

    def placement(self, time: float) -> tuple[FloatArray, FloatArray]:
        """Return slave points (n, 3), world axes, and the pose (4, 4) of the master.

        Points whose motion depends on forces other than gravity stay where they start.
        """
        slave_pose, points = self._slave_pose(time), self.slave.points
        motion = self.model.slaves[self.part.slave].motion
        if slave_pose is not None:
            points = pose.apply(slave_pose, points)
        elif self._mover.flight is not None:
            points = points + self._flight_displacement(self._mover.flight, time)
        elif not isinstance(motion, Dependent):
            points = motion.points(time)
        return points, self._body_pose(self._master_number, time)

    def _slave_pose(self, time: float) -> FloatArray | None:
        """Return the rigid motion (4, 4) of the slave from the start.

        None if it deforms, or if its motion has points of its own: those of the slave do not ride.
        """
        mover, motion = self._mover, self.model.slaves[self.part.slave].motion
        if mover.host is not None:
            return self._body_pose(mover.host, time)
        if mover.flight is not None and mover.flight.ndim == 1:
            return pose.translation(self._flight_displacement(mover.flight, time))
        if isinstance(motion, Moved) and isinstance(motion.base, np.ndarray):
            is_same = np.array_equal(motion.base, self.slave.points)
            return pose_at(motion.motion, time) if is_same else None
        return None

    def _flight_displacement(self, velocity: FloatArray, time: float) -> FloatArray:
        t = time - self.model.stepping.start
        return velocity * t + 0.5 * t * t * self.model.gravity

    def _body_motion(self, i: int) -> BodyMotion | Dependent:
        """Return the motion of the body with number `i`, which is not attached."""
        return list(self.model.bodies.values())[i].motion

    def _body_pose(self, i: int, time: float) -> FloatArray:
        """Return the pose (4, 4) of body `i`: prescribed, or in free flight at a constant spin.

        Held directions of a free body stay.
        """
        system, motion = self.model.mechanism, self._body_motion(i)
        if not isinstance(motion, Dependent):
            return pose_at(motion, time)
        assert isinstance(motion, Free)
        t = time - self.model.stepping.start
        centre = system.start[system.row[i], CENTRE : CENTRE + 3]
        turn = pose.identity()
        if motion.spin.any():
            turn = pose.rotation(motion.spin, length(motion.spin) * t, centre)
        displacement = self._flight_displacement(motion.velocity, time)
        if motion.hold:
            displacement = displacement * [axis not in motion.hold for axis in "xyz"]
        return pose.compose(pose.translation(displacement), turn)

    def relative_at(self, time: float) -> FloatArray | None:
        """Return the pose (4, 4) of the slave in the master's axes; None where `_slave_pose` is."""
        if time not in self._relative:
            slave_pose = self._slave_pose(time)
            self._relative[time] = (
                None
                if slave_pose is None
                else pose.relative(self._body_pose(self._master_number, time), slave_pose)
            )
        return self._relative[time]

    @cached_property
    def relative(self) -> FloatArray | None:
        """Poses (k, 4, 4) of the slave in the master's axes at `times`; None if it is not rigid."""
        poses = [self.relative_at(float(time)) for time in self.times]
        if poses[0] is None:
            return None
        return np.array(poses)

    @cached_property
    def shown_times(self) -> FloatArray:
        """Times (k,) of the search: up to `STANDINGS` planned ones, and as many rows of tables.

        Where the slave does not move rigidly they are up to `_STANDINGS_FROM_FILES` planned ones.
        """
        is_read = self.relative_at(float(self.model.stepping.start)) is None
        times = spread(
            self.model.stepping.planned(), _STANDINGS_FROM_FILES if is_read else STANDINGS
        )
        return times if is_read else np.union1d(times, spread(self._table_times, STANDINGS))

    @cached_property
    def dry_runs(self) -> list[DryRun]:
        """Results of the search at `shown_times`, as far as the motion is known.

        They end at the first touch if forces move a side, and at the start if nothing is known.
        """
        placements = (self.placement(time) for time in self.shown_times.tolist())
        runs: list[DryRun] = []
        for run in self.contact.dry_run(placements, most=MAX_POINTS):
            runs.append(run)
            if not self.foretold or (self.free and len(run.rows)):
                break
        return runs

    @cached_property
    def slave_size(self) -> float:
        """Length of the diagonal of the box around the slave's active points."""
        return length(np.ptp(self.slave.bounds(), axis=0))

    @cached_property
    def touches(self) -> bool:
        """Whether the search finds any point in contact."""
        return any(len(seen.rows) for seen in self.dry_runs)


class Scene:
    """The data of a model for its checks, computed once."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.fmt = Quantities(model.units)
        # Contacts with bodies that change their shape are not predicted.
        changing = model.shapes.of
        self.pairs = [Pair(model, part) for part in model.contacts if part.master not in changing]


def _searches_to_touch(runs: Iterable[DryRun]) -> int:
    """Return the number of searches up to the first point in contact; all if there is none."""
    count = 0
    for run in runs:
        count += 1
        if len(run.rows):
            break
    return count
