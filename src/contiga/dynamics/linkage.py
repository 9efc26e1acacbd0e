"""The joints of a mechanism as one system of constraints: assembly at the start, steps, laws."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.ordered import length, product
from contiga.dynamics.joint_laws import JointLaw, JointLawState
from contiga.dynamics.joint_records import AXES, JointTable, work_for
from contiga.dynamics.joints import KINDS, Joint
from contiga.dynamics.kernels import joints_nb
from contiga.dynamics.rigid_bodies import Placed, bodies_at_start
from contiga.dynamics.springs import GROUND
from contiga.errors import InputError
from contiga.jit import straight
from contiga.records import FloatArray
from contiga.rigid import quaternion
from contiga.rigid import rigid_lanes as lanes

OPEN = 1e-10
"""Misfit, over the size of a mechanism, above which a joint is open."""
_RANK_TOL = 1e-9
"""Singular value, over the largest, below which constraints depend on others."""
_DEPENDENT_SHARE = 1e-6
"""Entry of a null vector, over the largest, above which its row takes part in a dependence."""
_LAW_FIELDS = len(JointLawState._fields)


class JointStates(NamedTuple):
    """State of all joints at one time: g joints, c coordinates, l laws."""

    values: FloatArray
    """(c,) coordinates: radians, or length."""
    rates: FloatArray
    """(c,) their time derivatives."""
    ways: FloatArray
    """(c, 6) generalised direction of each coordinate: force on the second body, and moment about
    its marker, per unit of the coordinate's force, world axes."""
    points: FloatArray
    """(g, 3) points of the second markers, world coordinates."""
    reactions: FloatArray
    """(g, 6) force of each joint on its second body and moment about its marker, world axes."""
    laws: FloatArray
    """(l, 9) fields of `JointLawState`."""

    def law(self, k: int) -> JointLawState:
        """Return the state of a law by its number."""
        return JointLawState(*self.laws[k].tolist())


class Fit(NamedTuple):
    """Assembly of the b free bodies at the start, with their joints closed."""

    rows: FloatArray
    """(b, 19) free bodies, columns by `contiga.rigid.rigid_lanes`."""
    moved: FloatArray
    """(b,) displacement of each centre of mass, length."""
    turned: FloatArray
    """(b,) rotation of each body, radians."""
    misfit: float
    """Largest misfit that remains, over the size of the mechanism."""
    gaps: Mapping[str, float]
    """Largest misfit of each joint that stays open: length, or sine of an angle."""
    redundant: int
    """Number of constraint rows that depend on others."""
    dependent: tuple[str, ...]
    """Joints whose rows take part in such a dependence."""


class Misfit(NamedTuple):
    """The joint that is farthest from closed."""

    joint: str
    gap: float
    """Length, or sine of an angle."""


class Reaction(NamedTuple):
    """Result of a kick with constraints."""

    kinetic: float
    """Kinetic energy of the free bodies."""
    reactions: FloatArray
    """(g, 6) as in `JointStates`."""


class Coordinate(NamedTuple):
    """Names of a coordinate."""

    joint: str
    name: str


class Law(NamedTuple):
    """The law of a coordinate of a joint."""

    joint: str
    coordinate: str
    number: int
    """Row of the coordinate in `JointStates`."""
    law: JointLaw


class _Redundancy(NamedTuple):
    """Constraints that depend on others: fields of a `Fit`."""

    redundant: int
    dependent: tuple[str, ...]


class _Constraints(NamedTuple):
    """The constraint rows of all joints: fields of a `JointTable`."""

    constraints: NDArray[np.int32]
    first: NDArray[np.int32]
    full: NDArray[np.int32]
    couples: NDArray[np.int32]


def _constraints(joints: Mapping[str, Joint], rows: NDArray[np.int32]) -> _Constraints:
    """Return the constraint rows in an order of small envelope, their envelope, and their couples.

    `constraints` (m, 4) are joint, kind and the two axes of each row. The envelope `first` (m,) is
    the first column of each row of the matrix that may not be zero; `full` (m,) is the envelope of
    a full matrix, zeros. `couples` (p, 6) are ranges of rows, with a side each, of two joints (or
    one twice) that share a free body; such joints are neighbours (reverse order of E. Cuthill and
    J. McKee, 1969). `rows` (g, 2) are the free bodies of the joints, −1 for others.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    shared = (rows[:, None, :, None] == rows[None, :, None, :]) & (rows >= 0)[:, None, :, None]
    order = reverse_cuthill_mckee(csr_array(shared.any(axis=(2, 3))), symmetric_mode=True)
    of_joint = [KINDS[joint.kind].constraints for joint in joints.values()]
    constraints = [(g, *constraint) for g in order.tolist() for constraint in of_joint[g]]
    counts = np.array([len(of_joint[g]) for g in order], np.intp)
    ends = np.concatenate([[0], np.cumsum(counts)])
    first, couples = np.zeros(len(constraints), np.int32), []
    for p, g in enumerate(order):
        first[ends[p] : ends[p + 1]] = ends[p]
        for q, f in enumerate(order[: p + 1]):
            for side, other in np.argwhere(shared[g, f]).tolist():
                couples.append((ends[p], ends[p + 1], side, ends[q], ends[q + 1], other))
                first[ends[p] : ends[p + 1]] = np.minimum(first[ends[p]], ends[q])
    return _Constraints(
        np.array(constraints, np.int32).reshape(-1, 4),
        first,
        np.zeros_like(first),
        np.array(couples, np.int32).reshape(-1, 6),
    )


def joint_ends(
    joints: Mapping[str, Joint], index: Mapping[str, int], root: NDArray[np.intp]
) -> NDArray[np.int32]:
    """Return the numbers (g, 2) of the bodies that carry the ends of the joints; −1 for the ground.

    Parameters
    ----------
    joints : by name
    index : number of each body, by name
    root : (n,) number of the body that each body is attached to; its own if it is not

    Raises
    ------
    InputError
        An unknown body, a body named "ground", a joint between bodies attached to each other.
    """
    ends = np.full((len(joints), 2), -1, np.int32)
    for g, (name, joint) in enumerate(joints.items()):
        for side, body in enumerate(joint.between):
            where = f"joint {name!r}: between"
            if body == GROUND:
                if GROUND in index:
                    raise InputError(
                        "stands for the world, but a body has this name",
                        where=where,
                        found=GROUND,
                        remedy="Rename the body",
                    )
                continue
            if body not in index:
                raise InputError(
                    "no body of this name is there",
                    where=where,
                    found=body,
                    allowed=", ".join(map(repr, [*index, GROUND])),
                )
            ends[g, side] = root[index[body]]
        if ends[g, 0] == ends[g, 1]:
            raise InputError(
                "one of its bodies is attached to the other: the joint constrains nothing",
                where=f"joint {name!r}: between",
                found=list(joint.between),
                remedy="Remove the joint, or give both bodies motions of their own",
            )
    return ends


class Linkage:
    """The joints of a mechanism, laid out for kernels.

    Parameters
    ----------
    joints : by name
    bodies : (g, 2) numbers of the bodies that carry their ends; −1 for the ground
    rows : (g, 2) rows of these bodies among the free ones; −1 for others
    origins : (n, 4, 4) poses of all bodies at the start
    fixed : (b, 22) constants of the free bodies, columns by `contiga.rigid.rigid_lanes`
    """

    def __init__(
        self,
        joints: Mapping[str, Joint],
        bodies: NDArray[np.int32],
        rows: NDArray[np.int32],
        origins: FloatArray,
        fixed: FloatArray,
    ) -> None:
        self.joints, self.names, self.fixed = joints, list(joints), fixed
        points, axes = np.empty((len(joints), 2, 3)), np.empty((len(joints), 2, 3, 3))
        kinds_of_coordinates: list[tuple[int, int]] = []
        self.coordinates: list[Coordinate] = []
        """Names of the coordinates, by their numbers."""
        self.laws: list[Law] = []
        starts = []
        for g, (name, joint) in enumerate(joints.items()):
            for side, marker in enumerate(joint.markers()):
                points[g, side], axes[g, side] = marker.point, marker.axes
                if (body := bodies[g, side]) >= 0:
                    R, origin = origins[body, :3, :3], origins[body, :3, 3]
                    points[g, side] = product(R.T, marker.point - origin)
                    axes[g, side] = product(marker.axes, R)
            kind = KINDS[joint.kind]
            for coordinate, kind_of_coordinate in kind.coordinates.items():
                law = joint.laws.get(coordinate)
                if law is not None:
                    self.laws.append(Law(name, coordinate, len(self.coordinates), law))
                self.coordinates.append(Coordinate(name, coordinate))
                kinds_of_coordinates.append((g, kind_of_coordinate))
                starts.append(0.0 if law is None else law.start)
        self._starts = np.array(starts, np.float64)
        self.bodies = frozenset(bodies.ravel().tolist())
        """Numbers of the bodies that have joints; −1 for the ground."""
        # Size: the largest arm from a centre of mass, or extent of all joints, whichever is larger.
        size = 0.0
        for g in range(len(joints)):
            for side in range(2):
                if (row := rows[g, side]) >= 0:
                    arm = points[g, side] - fixed[row, lanes.CENTRE_B : lanes.CENTRE_B + 3]
                    size = max(size, length(arm))
        joint_points = np.array([joint.at for joint in joints.values()]).reshape(-1, 3)
        size = max(size, float(np.ptp(joint_points, axis=0).max())) or 1.0
        self.table = JointTable(
            bodies,
            rows,
            points,
            axes,
            *_constraints(joints, rows),
            np.array(kinds_of_coordinates, np.int32).reshape(-1, 2),
            np.array([size]),
        )

    def fit(self, start: FloatArray, poses: FloatArray) -> Fit:
        """Close all joints by the smallest motions of the free bodies, weighted by their masses.

        Velocities and spins stay as given: `react` makes them compatible with the joints. Joints
        that cannot be closed are in `Fit.gaps`; nothing is raised, and `start` is not changed.

        Parameters
        ----------
        start : (b, 19) free bodies as placed
        poses : (n, 4, 4) of all bodies at the start; those of free bodies are not used
        """
        rows, fixed, table = start.copy(), self.fixed, self.table
        work = work_for(table, len(rows))
        misfit = float(joints_nb.fit(rows, poses, fixed, table, work))
        before, after = bodies_at_start(start, fixed), bodies_at_start(rows, fixed)
        turned, turn = np.zeros(len(rows)), slice(lanes.TURN, lanes.TURN + 4)
        for b, row in enumerate(rows):
            turned[b] = length(quaternion.rotation_vector(start[b, turn], row[turn]))
            # The spins stay as given, so the angular momenta follow the new orientations.
            axes = product(
                after.poses[b, :3, :3], fixed[b, lanes.AXES : lanes.AXES + 9].reshape(3, 3)
            )
            moments = fixed[b, lanes.MOMENTS : lanes.MOMENTS + 3]
            momenta = moments * product(axes.T, before.twists[b, 3:])
            row[lanes.MOMENTUM : lanes.MOMENTUM + 3] = product(axes, momenta)
        centre = slice(lanes.CENTRE, lanes.CENTRE + 3)
        moved = np.sqrt(np.square(rows[:, centre] - start[:, centre]).sum(axis=1))
        gaps: dict[str, float] = {}
        joints_nb.misfits(rows, poses, fixed, table, work)
        for (g, kind, _, _), misfit_of_row in zip(
            table.constraints.tolist(), work.right.tolist(), strict=True
        ):
            size = 1.0 if kind == AXES else float(table.size[0])
            if not abs(misfit_of_row) <= OPEN * size:
                gaps[self.names[g]] = max(gaps.get(self.names[g], 0.0), abs(misfit_of_row))
        joints_nb.derive(rows, fixed, table, work)
        return Fit(rows, moved, turned, misfit, gaps, *self._redundancy(work.jacobian))

    def _redundancy(self, jacobian: FloatArray) -> _Redundancy:
        """Return the number of redundant constraints, and the names of the joints in dependencies.

        The number is m less the rank of the derivatives (m, 2, 6), each divided by the root of the
        body's mass or middle moment of inertia, and each row by its norm. Singular values up to
        `_RANK_TOL` of the largest count as zero.
        """
        table, fixed = self.table, self.fixed
        weighted = np.zeros((len(table.constraints), len(fixed), 6))
        for m, (g, *_) in enumerate(table.constraints):
            for side in range(2):
                if (row := table.rows[g, side]) >= 0:
                    weighted[m, row] += jacobian[m, side]
        weighted *= fixed[:, lanes.FREE_DIRECTIONS : lanes.FREE_DIRECTIONS + 6].astype(bool)
        weighted[..., :3] /= np.sqrt(fixed[:, lanes.MASS])[:, None]
        weighted[..., 3:] /= np.sqrt(fixed[:, lanes.MOMENTS + 1])[:, None]
        matrix = weighted.reshape(len(weighted), -1)
        norms = np.sqrt(np.square(matrix).sum(axis=1, keepdims=True))
        vectors, singular, _ = np.linalg.svd(matrix / np.where(norms > 0.0, norms, 1.0))
        rank = int((singular > _RANK_TOL * singular.max(initial=0.0)).sum())
        null = np.abs(vectors[:, rank:]).max(axis=1, initial=0.0)
        dependent = null > _DEPENDENT_SHARE * null.max(initial=1.0)
        joints = (self.names[g] for g in np.unique(table.constraints[dependent, 0]))
        return _Redundancy(len(matrix) - rank, tuple(joints))

    def close(
        self,
        last: FloatArray,
        last_poses: FloatArray,
        free: Placed,
        poses: FloatArray,
        dt: float,
    ) -> float:
        """Correct the drift of the free bodies in place so that all joints are closed.

        Joints that stay open raise nothing: the result tells of them, and `worst` names one.

        Parameters
        ----------
        last, last_poses : (b, 19) free bodies and (n, 4, 4) poses of all bodies before the step
        free : free bodies after the drift; rows, poses and predicted twists are changed
        poses : (n, 4, 4) after the step; those of driven bodies are used
        dt : length of the step, time, > 0

        Returns
        -------
        float
            Largest misfit that remains, over the size of the mechanism.
        """
        work = work_for(self.table, len(last))
        return float(
            straight(joints_nb.close)(
                last, last_poses, free, poses, self.fixed, dt, self.table, work
            )
        )

    def worst(self, free: Placed, poses: FloatArray) -> Misfit:
        """Return the joint with the largest misfit; lengths and sines are compared as they are.

        A misfit that is not finite is the largest. `poses` (n, 4, 4) are of all bodies, but only
        those of driven ones are used.
        """
        work = work_for(self.table, len(free.rows))
        joints_nb.misfits(free.rows, poses, self.fixed, self.table, work)
        m = int(np.argmax(np.where(np.isfinite(work.right), np.abs(work.right), np.inf)))
        return Misfit(self.names[self.table.constraints[m, 0]], abs(float(work.right[m])))

    def react(
        self, free: Placed, poses: FloatArray, twists: FloatArray, accelerations: FloatArray
    ) -> Reaction:
        """Project the velocities of the free bodies onto the constraints, in place.

        Reactions make their accelerations fulfil the constraints, and are added to the forces in
        `free.rows`. The result has the kinetic energy of the free bodies and the reactions (g, 6).

        Parameters
        ----------
        free : free bodies after their kick; rows and twists are changed
        poses, twists, accelerations : (n, 4, 4), (n, 6), (n, 6); those of driven bodies are used
        """
        work = work_for(self.table, len(free.rows))
        reactions = np.empty((len(self.names), 6))
        kinetic = straight(joints_nb.react)(
            free, poses, twists, accelerations, self.fixed, self.table, work, reactions
        )
        return Reaction(float(kinetic), reactions)

    def measured(
        self, last: JointStates | None, poses: FloatArray, twists: FloatArray
    ) -> JointStates:
        """Return the joints as measured from poses (n, 4, 4) and twists (n, 6) of all bodies.

        Angles continue those of `last` beyond ±π, or the `start` of the laws where it is None, at
        the start. Laws and reactions are those of `last`, or zeros.
        """
        g, c = len(self.names), len(self.coordinates)
        values = self._starts.copy() if last is None else last.values.copy()
        rates, ways, points = np.empty(c), np.empty((c, 6)), np.empty((g, 3))
        straight(joints_nb.measure)(poses, twists, self.table, points, values, rates, ways)
        if last is None:
            reactions, laws = np.zeros((g, 6)), np.zeros((len(self.laws), _LAW_FIELDS))
        else:
            reactions, laws = last.reactions, last.laws
        return JointStates(values, rates, ways, points, reactions, laws)

    def with_laws(self, last: JointStates | None, now: JointStates) -> JointStates:
        """Return a copy of the joints `now` with their laws advanced from `last`.

        `last` is None at the start, where the laws begin.
        """
        laws = np.empty((len(self.laws), _LAW_FIELDS))
        for k, entry in enumerate(self.laws):
            value, rate = float(now.values[entry.number]), float(now.rates[entry.number])
            if last is None:
                laws[k] = entry.law.begin(value, rate)
            else:
                laws[k] = entry.law.step(last.law(k), value, rate)
        return now._replace(laws=laws)

    def add_laws(self, states: JointStates, poses: FloatArray, total: FloatArray) -> None:
        """Add the laws' forces to the wrenches `total` (n, 6) on bodies at `poses` (n, 4, 4)."""
        wrenches = np.zeros(states.reactions.shape)
        for k, entry in enumerate(self.laws):
            joint = self.table.coordinates[entry.number, 0]
            wrenches[joint] -= states.law(k).force * states.ways[entry.number]
        straight(joints_nb.add_wrenches)(self.table, states.points, wrenches, poses, total)

    def add_reactions(self, states: JointStates, poses: FloatArray, total: FloatArray) -> None:
        """Add the reactions to the wrenches `total` (n, 6) on bodies at `poses` (n, 4, 4)."""
        straight(joints_nb.add_wrenches)(self.table, states.points, states.reactions, poses, total)


def check_fit(linkage: Linkage, fit: Fit) -> None:
    """Refuse joints without a free body, and joints that cannot be closed at the start.

    Raises
    ------
    InputError
        The first joint without a free body; else the joint with the largest misfit, with that
        misfit and the joints that contradict each other.
    """
    for name, rows in zip(linkage.names, linkage.table.rows.tolist(), strict=True):
        if max(rows) < 0:
            raise InputError(
                "no force moves either of its bodies: the joint would have no effect",
                where=f"joint {name!r}: between",
                found=list(linkage.joints[name].between),
                allowed="a free body at one end or at both",
            )
    if not fit.gaps:
        return
    worst = max(fit.gaps, key=lambda name: fit.gaps[name])
    opposed = [name for name in fit.dependent if name in fit.gaps]
    conflict = f"joints {', '.join(map(repr, opposed))} contradict each other: " if opposed else ""
    raise InputError(
        f"{conflict}it cannot be closed at the start: a misfit of {fit.gaps[worst]:.4g} (length, "
        "or sine of an angle) remains wherever its bodies are placed",
        where=f"joint {worst!r}: at",
        found=linkage.joints[worst].at.tolist(),
        remedy="Move the points and axes of these joints, or remove one of them",
    )
