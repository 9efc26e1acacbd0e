"""All joints between bodies together: how they start, and what they do in a step."""

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
from contiga.dynamics.rigid_bodies import Placed, started
from contiga.dynamics.springs import GROUND
from contiga.errors import InputError
from contiga.jit import straight
from contiga.records import FloatArray
from contiga.rigid import quaternion
from contiga.rigid import rigid_lanes as lanes

OPEN = 1e-10
"""Misfit, over the size of a mechanism, beyond which its joints are not closed."""
_RANK = 1e-9
"""Singular value, over the largest, below which constraints depend on others."""
_PART = 1e-6
"""Of the largest entry: what takes part in a dependence."""
LAW_NUMBERS = len(JointLawState._fields)


class JointStates(NamedTuple):
    """All joints at one time: g joints, c coordinates, l laws."""

    values: FloatArray
    """(c,) coordinates: radians, or length."""
    rates: FloatArray
    """(c,)."""
    ways: FloatArray
    """(c, 6) force on the second body and moment on it about its marker of a unit force of each
    coordinate, world axes."""
    points: FloatArray
    """(g, 3) markers of the second bodies, world."""
    reactions: FloatArray
    """(g, 6) force of each joint on its second body and moment about its marker, world axes."""
    laws: FloatArray
    """(l, 9) as `JointLawState`."""

    def law(self, k: int) -> JointLawState:
        """Return the state of a law by its number."""
        return JointLawState(*self.laws[k].tolist())


class Fit(NamedTuple):
    """How bodies were made to fit their joints at the start."""

    rows: FloatArray
    """(b, 19) free bodies, columns by `contiga.rigid.rigid_lanes`."""
    moved: FloatArray
    """(b,) how far the centre of each was moved, length."""
    turned: FloatArray
    """(b,) and by which angle, radians."""
    misfit: float
    """Largest that is left, over the size of the mechanism."""
    gaps: Mapping[str, float]
    """Largest misfit of each joint that does not close: length, or sine of an angle."""
    redundant: int
    """Number of constraint rows that depend on others."""
    dependent: tuple[str, ...]
    """Joints of which such rows are."""


class Law(NamedTuple):
    """A law of a coordinate of a joint."""

    joint: str
    coordinate: str
    of: int
    """Number of the coordinate."""
    law: JointLaw


class _Constraints(NamedTuple):
    """The constraint rows of all joints, as the fields of a `JointTable`."""

    constraints: NDArray[np.int32]
    first: NDArray[np.int32]
    full: NDArray[np.int32]
    couples: NDArray[np.int32]


def _constraints(joints: Mapping[str, Joint], rows: NDArray[np.int32]) -> _Constraints:
    """Constraint rows in an order that keeps the envelope of their matrix small (E. Cuthill and
    J. McKee, 1969), and which of them free bodies couple, by their `rows` (g, 2)."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    shared = (rows[:, None, :, None] == rows[None, :, None, :]) & (rows >= 0)[:, None, :, None]
    order = reverse_cuthill_mckee(csr_array(shared.any(axis=(2, 3))), symmetric_mode=True)
    kinds = [KINDS[joint.kind].rows for joint in joints.values()]
    constraints = [(g, *row) for g in order.tolist() for row in kinds[g]]
    counts = np.array([len(kinds[g]) for g in order], np.intp)
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
    """Return the numbers (g, 2) of the bodies that joints are between in the end; −1 of the ground.

    Parameters
    ----------
    index : number of each body
    root : (n,) number of the body that each is fixed to, itself where it is not

    Raises
    ------
    InputError
        A body that is not there, one called "ground", a joint between two bodies that are one.
    """
    ends = np.full((len(joints), 2), -1, np.int32)
    for g, (name, joint) in enumerate(joints.items()):
        for side, body in enumerate(joint.between):
            where = f"joint {name!r}: between"
            if body == GROUND:
                if GROUND in index:
                    raise InputError(
                        "means the world, and is also the name of a body",
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
                "one of its bodies is attached to the other: the joint holds nothing",
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
    bodies : (g, 2) numbers of the bodies that they are between in the end; −1 of the ground
    rows : (g, 2) their rows among free bodies; −1 of others
    origins : (n, 4, 4) poses of all bodies at the start
    fixed : (b, 22) what never changes of free bodies
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
        coordinates: list[tuple[int, int]] = []
        self.coordinates: list[tuple[str, str]] = []
        """(joint, coordinate) by the numbers of the coordinates."""
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
            for coordinate, number in kind.coordinates.items():
                law = joint.laws.get(coordinate)
                if law is not None:
                    self.laws.append(Law(name, coordinate, len(coordinates), law))
                self.coordinates.append((name, coordinate))
                coordinates.append((g, number))
                starts.append(0.0 if law is None else law.start)
        self._starts = np.array(starts, np.float64)
        self.bodies = frozenset(bodies.ravel().tolist())
        """Numbers of the bodies that have joints; −1 of the ground."""
        # Arms of the bodies' centres and distances of the joints, whichever are larger.
        size = 0.0
        for g in range(len(joints)):
            for side in range(2):
                if (row := rows[g, side]) >= 0:
                    arm = points[g, side] - fixed[row, lanes.CENTRE_B : lanes.CENTRE_B + 3]
                    size = max(size, length(arm))
        every = np.array([joint.at for joint in joints.values()]).reshape(-1, 3)
        size = max(size, float(np.ptp(every, axis=0).max())) or 1.0
        self.table = JointTable(
            bodies,
            rows,
            points,
            axes,
            *_constraints(joints, rows),
            np.array(coordinates, np.int32).reshape(-1, 2),
            np.array([size]),
        )

    def fit(self, start: FloatArray, poses: FloatArray) -> Fit:
        """Free bodies from rows (b, 19) with all joints closed, moved as little as possible.

        Their velocities and spins are as given: `react` makes these fit.

        Parameters
        ----------
        poses : (n, 4, 4) of all bodies at the start; those of free ones are not used
        """
        rows, fixed, table = start.copy(), self.fixed, self.table
        work = work_for(table, len(rows))
        misfit = float(joints_nb.fit(rows, poses, fixed, table, work))
        before, after = started(start, fixed), started(rows, fixed)
        turned = np.zeros(len(rows))
        for b, row in enumerate(rows):
            # The angular momenta are those of the spins given, in the new orientations.
            own = slice(lanes.TURN, lanes.TURN + 4)
            turned[b] = length(quaternion.rotation_vector(start[b, own], row[own]))
            axes = product(
                after.poses[b, :3, :3], fixed[b, lanes.AXES : lanes.AXES + 9].reshape(3, 3)
            )
            moments = fixed[b, lanes.MOMENTS : lanes.MOMENTS + 3]
            momenta = moments * product(axes.T, before.twists[b, 3:])
            row[lanes.MOMENTUM : lanes.MOMENTUM + 3] = product(axes, momenta)
        way = rows[:, lanes.CENTRE : lanes.CENTRE + 3] - start[:, lanes.CENTRE : lanes.CENTRE + 3]
        gaps: dict[str, float] = {}
        joints_nb.misfits(rows, poses, fixed, table, work)
        for (g, kind, _, _), off in zip(
            table.constraints.tolist(), work.right.tolist(), strict=True
        ):
            size = 1.0 if kind == AXES else float(table.size[0])
            if not abs(off) <= OPEN * size:
                gaps[self.names[g]] = max(gaps.get(self.names[g], 0.0), abs(off))
        # Rows that depend on others, by the derivatives over the roots of the masses.
        spread = np.zeros((len(table.constraints), len(rows), 6))
        joints_nb.derive(rows, fixed, table, work)
        for m, (g, *_) in enumerate(table.constraints):
            for side in range(2):
                if (row := table.rows[g, side]) >= 0:
                    spread[m, row] += work.jacobian[m, side]
        ways = fixed[:, lanes.WAYS : lanes.WAYS + 6].astype(bool)
        moves = spread * ways
        moves[..., :3] /= np.sqrt(fixed[:, lanes.MASS])[:, None]
        moves[..., 3:] /= np.sqrt(fixed[:, lanes.MOMENTS + 1])[:, None]
        flat = moves.reshape(len(moves), -1)
        sizes = np.sqrt(np.square(flat).sum(axis=1, keepdims=True))
        left, singular, _ = np.linalg.svd(flat / np.where(sizes > 0.0, sizes, 1.0))
        rank = int((singular > _RANK * singular.max(initial=0.0)).sum())
        null = np.abs(left[:, rank:]).max(axis=1, initial=0.0)
        among = null > _PART * null.max(initial=1.0)
        dependent = [self.names[g] for g in np.unique(table.constraints[among, 0])]
        return Fit(
            rows,
            np.sqrt(np.square(way).sum(axis=1)),
            turned,
            misfit,
            gaps,
            len(flat) - rank,
            tuple(dependent),
        )

    def close(
        self,
        last: FloatArray,
        last_poses: FloatArray,
        free: Placed,
        poses: FloatArray,
        dt: float,
    ) -> float:
        """Correct a drift of free bodies so that all joints are closed; `free` is changed.

        Parameters
        ----------
        last, last_poses : (b, 19) and (n, 4, 4) before the step
        poses : (n, 4, 4) after it, of driven bodies
        dt : length of the step, > 0

        Returns
        -------
        float
            Largest misfit that is left, over the size of the mechanism.
        """
        work = work_for(self.table, len(last))
        return float(
            straight(joints_nb.close)(
                last, last_poses, free, poses, self.fixed, dt, self.table, work
            )
        )

    def worst(self, free: Placed, poses: FloatArray) -> tuple[str, float]:
        """Return the joint that is farthest from closed, and by how much: length, or the sine of
        an angle."""
        work = work_for(self.table, len(free.rows))
        joints_nb.misfits(free.rows, poses, self.fixed, self.table, work)
        m = int(np.argmax(np.where(np.isfinite(work.right), np.abs(work.right), np.inf)))
        return self.names[self.table.constraints[m, 0]], abs(float(work.right[m]))

    def react(
        self, free: Placed, poses: FloatArray, twists: FloatArray, accelerations: FloatArray
    ) -> tuple[float, FloatArray]:
        """Give free bodies the velocities that their joints allow, and add reactions to the forces
        on them; `free` is changed.

        Parameters
        ----------
        poses, twists, accelerations : (n, 4, 4), (n, 6), (n, 6) of driven bodies

        Returns
        -------
        tuple
            The kinetic energy, and the reactions (g, 6).
        """
        work = work_for(self.table, len(free.rows))
        reactions = np.empty((len(self.names), 6))
        kinetic = straight(joints_nb.react)(
            free, poses, twists, accelerations, self.fixed, self.table, work, reactions
        )
        return float(kinetic), reactions

    def measured(
        self, last: JointStates | None, poses: FloatArray, twists: FloatArray
    ) -> JointStates:
        """Return the joints where bodies at poses (n, 4, 4) with twists (n, 6) have them, laws and
        reactions as they were; `last` is None at the start."""
        g, c = len(self.names), len(self.coordinates)
        values = self._starts.copy() if last is None else last.values.copy()
        rates, ways, points = np.empty(c), np.empty((c, 6)), np.empty((g, 3))
        straight(joints_nb.measure)(poses, twists, self.table, points, values, rates, ways)
        none = np.zeros((g, 6)), np.zeros((len(self.laws), LAW_NUMBERS))
        reactions, laws = none if last is None else (last.reactions, last.laws)
        return JointStates(values, rates, ways, points, reactions, laws)

    def with_laws(self, last: JointStates | None, now: JointStates) -> JointStates:
        """Return the joints after a step from `last`, with what their laws have come to."""
        laws = np.empty((len(self.laws), LAW_NUMBERS))
        for k, (_, _, c, law) in enumerate(self.laws):
            value, rate = float(now.values[c]), float(now.rates[c])
            if last is None:
                laws[k] = law.begin(value, rate)
            else:
                laws[k] = law.step(last.law(k), value, rate)
        return now._replace(laws=laws)

    def add_laws(self, states: JointStates, poses: FloatArray, total: FloatArray) -> None:
        """Add what the laws do to the wrenches (n, 6) on bodies at `poses` (n, 4, 4)."""
        wrenches = np.zeros(states.reactions.shape)
        for k, (_, _, c, _) in enumerate(self.laws):
            wrenches[self.table.coordinates[c, 0]] -= states.laws[k, 1] * states.ways[c]
        straight(joints_nb.add_wrenches)(self.table, states.points, wrenches, poses, total)

    def add_reactions(self, states: JointStates, poses: FloatArray, total: FloatArray) -> None:
        """Add the reactions to the wrenches (n, 6) on bodies at `poses` (n, 4, 4)."""
        straight(joints_nb.add_wrenches)(self.table, states.points, states.reactions, poses, total)


def check_fit(linkage: Linkage, fit: Fit) -> None:
    """Refuse joints that nothing moves, and those that cannot be closed at the start.

    Raises
    ------
    InputError
        Names the joints that are open, how far, and those of them that contradict each other.
    """
    for name, rows in zip(linkage.names, linkage.table.rows.tolist(), strict=True):
        if max(rows) < 0:
            raise InputError(
                "no force moves either of its bodies: the joint would do nothing",
                where=f"joint {name!r}: between",
                found=list(linkage.joints[name].between),
                allowed="a free body at one end at least",
            )
    if not fit.gaps:
        return
    worst = max(fit.gaps, key=lambda name: fit.gaps[name])
    among = [name for name in fit.dependent if name in fit.gaps]
    against = f"joints {', '.join(map(repr, among))} contradict each other: " if among else ""
    raise InputError(
        f"{against}it cannot be closed at the start: {fit.gaps[worst]:.4g} is left (length, or "
        "sine of an angle) wherever its bodies are put",
        where=f"joint {worst!r}: at",
        found=linkage.joints[worst].at.tolist(),
        remedy="Move the points and axes of these joints, or remove one of them",
    )
