"""Work out where everything in a model stands at any time, as far as that is known beforehand.

What is prescribed stands where its motion says. What is free flies on from its start, under gravity
alone: so it goes until it first touches something, where neither springs nor loads act.
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
from contiga.dynamics.prescribed import BodyMotion, Moved, is_told, pose_at, rows_in
from contiga.masters.protocol import Master
from contiga.records import FloatArray
from contiga.rigid import pose, quaternion
from contiga.rigid.pose import to_quaternion
from contiga.rigid.rigid_lanes import CENTRE
from contiga.simulation.checks.finding import Said
from contiga.simulation.model import ContactPart, Model
from contiga.slaves.slave import Slave

# Standings a motion is gone through in, and points of contact that take part in that.
STANDINGS = 25
MAX_POINTS = 2_000
# The same where each standing is read from a file.
_STANDINGS_FROM_FILES = 7
# Times that the way of one side past the other is followed at, beside the rows of tables: as many
# as are planned, and as many as let nothing turn farther in between, in radians.
PLANNED = 100
TURN = 0.5
# A pulse of a second at 10 kHz; of more, which take longer than anybody would wait for a check, the
# way is not followed.
MAX_TIMES = 10_000
# Part of a span over which a velocity or a turn is taken.
INSTANT = 1e-3


class Pair:
    """One contact of the model: its two sides, and their relative motion over time."""

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
    def _host(self) -> int:
        """Number of the master, or of the body that it is attached to."""
        return self.model.mechanism.root_of(self.part.master)

    @cached_property
    def free(self) -> bool:
        """Whether forces move one of the sides: its way is known only until it first touches."""
        movers = self.model.mechanism.row
        return self._host in movers or self._mover.host in movers or self._mover.mass is not None

    @cached_property
    def foretold(self) -> bool:
        """Whether the relative motion of the sides is known until they touch."""
        if self.free and self.model.settling is not None:
            return False  # it starts from where it has come to rest
        if self.free and self._devices:
            return False
        if self._mover.mass is not None and self._mover.flight is None:
            return False
        return all(isinstance(motion, Dependent) or is_told(motion) for motion in self._motions)

    @property
    def _devices(self) -> bool:
        """Whether more than gravity moves free parts before anything touches."""
        model = self.model
        return bool(model.springs or model.joints or model.loads or model.gas)

    @cached_property
    def approach(self) -> FloatArray:
        """Times (k,) from the start to the first touch, as far as the motion is known.

        Elements stand still until then, where no load and no motion moves them.
        """
        if self.foretold:
            return self.shown_times[: _until_touched(self.dry_runs)]
        motions = self._motions
        told = isinstance(motions[0], Dependent) or is_told(motions[0])
        pushed = self._devices or self.model.settling is not None
        times = spread(self.model.stepping.planned(), 2 * STANDINGS)
        if pushed or not (self._mover.stands and told):
            return times[:1]
        standing = (self.standing(time) for time in times.tolist())
        return times[: _until_touched(self.contact.dry_run(standing, most=MAX_POINTS))]

    @cached_property
    def _motions(self) -> tuple[object, object]:
        """The motions of the body and the slave, or of the bodies that they are attached to."""
        slave: object = self.model.slaves[self.part.slave].motion
        if self._mover.host is not None:
            slave = self._body_motion(self._mover.host)
        return self._body_motion(self._host), slave

    @cached_property
    def times(self) -> FloatArray:
        """Times (k,) of the run between which the sides turn little against each other.

        Among them are planned steps and all rows of the motions' tables.
        """
        times = np.union1d(spread(self.model.stepping.planned(), PLANNED), self._turns)
        if len(times) > MAX_TIMES:
            return spread(times, MAX_TIMES)
        spans = list(pairwise(times.tolist()))
        counts = [1 + int(self._turned(first, last) / TURN) for first, last in spans]
        if sum(counts) >= MAX_TIMES:
            return times
        parts = [np.linspace(*span, n + 1)[1:] for span, n in zip(spans, counts, strict=True)]
        return np.concatenate([times[:1], *parts])

    @cached_property
    def followed(self) -> bool:
        """Whether `times` are close enough for the motion in between to be known."""
        spans = pairwise(self.times.tolist())
        return set(self._turns) <= set(self.times) and all(
            self._turned(first, last) <= 2.0 * TURN for first, last in spans
        )

    def _turned(self, first: float, last: float) -> float:
        """Return the angle between the sides' turns at two times, radians, by their rate half way.

        No table has a row between the two times.
        """
        middle, instant = 0.5 * (first + last), INSTANT * (last - first)
        X, Y = self.relative_at(middle), self.relative_at(middle + instant)
        if X is None or Y is None:
            return 0.0
        turn = quaternion.rotation_vector(to_quaternion(X), to_quaternion(Y))
        return length(turn) / INSTANT

    @cached_property
    def _turns(self) -> FloatArray:
        """Times (k,) of the run at which a row of the motion's tables stands."""
        start, end = self.model.stepping.start, self.model.stepping.end
        rows = np.concatenate([rows_in(motion) for motion in self._motions])
        return np.unique(rows[(rows > start) & (rows < end)])

    def standing(self, time: float) -> tuple[FloatArray, FloatArray]:
        """Return slave points (n, 3), world axes, and the pose (4, 4) of the master."""
        slave_pose, points = self._slave_pose(time), self.slave.points
        motion = self.model.slaves[self.part.slave].motion
        if slave_pose is not None:
            points = pose.apply(slave_pose, points)
        elif self._mover.flight is not None:
            points = points + self._flight(self._mover.flight, time)
        elif not isinstance(motion, Dependent):
            points = motion.points(time)
        # What neither flies nor follows a motion stays, as far as anybody knows.
        return points, self._body_pose(self._host, time)

    def _slave_pose(self, time: float) -> FloatArray | None:
        """Return the motion (4, 4) of the slave from where it was given; None if it deforms."""
        mover, motion = self._mover, self.model.slaves[self.part.slave].motion
        if mover.host is not None:
            return self._body_pose(mover.host, time)
        if mover.flight is not None and mover.flight.ndim == 1:
            return pose.translation(self._flight(mover.flight, time))
        if isinstance(motion, Moved) and isinstance(motion.base, np.ndarray):
            same = np.array_equal(motion.base, self.slave.points)
            return pose_at(motion.motion, time) if same else None
        return None

    def _flight(self, velocity: FloatArray, time: float) -> FloatArray:
        t = time - self.model.stepping.start
        return velocity * t + 0.5 * t * t * self.model.gravity

    def _body_motion(self, i: int) -> BodyMotion | Dependent:
        """Return the motion of the body with number `i`, which is attached to none."""
        return list(self.model.bodies.values())[i].motion

    def _body_pose(self, i: int, time: float) -> FloatArray:
        system, motion = self.model.mechanism, self._body_motion(i)
        if not isinstance(motion, Dependent):
            return pose_at(motion, time)
        assert isinstance(motion, Free)
        t = time - self.model.stepping.start
        centre = system.start[system.row[i], CENTRE : CENTRE + 3]
        turn = pose.identity()
        if motion.spin.any():
            turn = pose.rotation(motion.spin, length(motion.spin) * t, centre)
        way = self._flight(motion.velocity, time)
        if motion.hold:
            way = way * [axis not in motion.hold for axis in "xyz"]
        return pose.compose(pose.translation(way), turn)

    def relative_at(self, time: float) -> FloatArray | None:
        """Return the pose (4, 4) of the slave in the master's axes; None where it deforms."""
        if time not in self._relative:
            carried = self._slave_pose(time)
            self._relative[time] = (
                None
                if carried is None
                else pose.relative(self._body_pose(self._host, time), carried)
            )
        return self._relative[time]

    @cached_property
    def relative(self) -> FloatArray | None:
        """Poses (k, 4, 4) of the slave in the master's axes at `times`; None where it deforms."""
        poses = [self.relative_at(float(time)) for time in self.times]
        if poses[0] is None:
            return None
        return np.array(poses)

    @cached_property
    def shown_times(self) -> FloatArray:
        """Times (k,) at which the search looks at the motion: STANDINGS, and where it turns."""
        read = self.relative_at(float(self.model.stepping.start)) is None
        times = spread(self.model.stepping.planned(), _STANDINGS_FROM_FILES if read else STANDINGS)
        return times if read else np.union1d(times, spread(self._turns, STANDINGS))

    @cached_property
    def dry_runs(self) -> list[DryRun]:
        """The search at `shown_times`, as far as the motion is known.

        It ends at the first touch where forces move a side, and at the start where nothing
        is known.
        """
        standing = (self.standing(time) for time in self.shown_times.tolist())
        seen: list[DryRun] = []
        for one in self.contact.dry_run(standing, most=MAX_POINTS):
            seen.append(one)
            if not self.foretold or (self.free and len(one.rows)):
                break
        return seen

    @cached_property
    def slave_size(self) -> float:
        """Length of the diagonal of the box around the slave's active points."""
        return length(np.ptp(self.slave.bounds(), axis=0))

    @cached_property
    def touches(self) -> bool:
        """Whether the search finds any point in contact."""
        return any(len(seen.rows) for seen in self.dry_runs)


class Scene:
    """All that the checks ask of a model, worked out once."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.said = Said(model.units)
        # Of bodies that change their shape it is not foretold how slaves come to them.
        changing = model.shapes.of
        self.pairs = [Pair(model, one) for one in model.contacts if one.master not in changing]


def _until_touched(runs: Iterable[DryRun]) -> int:
    """Return how many searches there are up to the first with a point in contact, or in all."""
    count = 0
    for seen in runs:
        count += 1
        if len(seen.rows):
            break
    return count
