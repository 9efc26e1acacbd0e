"""A contact between a rigid master and a slave: from positions to forces, step by step."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from contiga.area.facet import FacetArea
from contiga.area.method import AreaInput, AreaMethod, Areas, Outlines, Rest, prepared
from contiga.area.nodal import NodalArea
from contiga.area.offset import offset_ratio
from contiga.contact.checks import (
    check_master,
    check_methods,
    check_needs,
    check_through,
    checked_answer,
    choice,
    kind,
    law_of,
    locked,
)
from contiga.contact.curved import detect_on_curves
from contiga.contact.detect import detect_at_start
from contiga.contact.state import State
from contiga.contact.state_outlines import outlines_of_state
from contiga.contact.tracked import Detected, Last, Options
from contiga.errors import InputError
from contiga.laws.normal import Law, StressLaw
from contiga.masters.protocol import Master, Surface
from contiga.num.arrays import as_points, positive
from contiga.num.pose import as_pose, identity
from contiga.num.rigid import to_body, to_world, turn_to_world
from contiga.records import FloatArray, IntArray, LawInput, Projection, rows_of
from contiga.shown import Facts, Shown
from contiga.slaves.slave import Slave

SEARCHES = ("intersection", "penetration")
TYPES = ("slave", "master", "combined")
EDGES = ("release", "hold")
THROUGH = ("release", "hold")

# Share of its size an open body reaches behind its faces when nothing else is said.
OPEN_DEPTH = 0.1
# Distance from the surface below which a point counts as on it: a share of the body's size (feet
# are that exact) and one of its coordinates (they are rounded).
SAME_PLACE = 4e-12
ROUNDING = 32.0 * np.finfo(np.float64).eps


StageClock = Callable[[str], AbstractContextManager[None]]
"""Called with the name of a stage, gives a context that times it."""


def _untimed(_: str) -> AbstractContextManager[None]:
    return nullcontext()


class Contact(Shown):
    """Contact of a slave with a rigid master.

    Parameters
    ----------
    master : the rigid body: exact geometry, or triangles
    slave : the points, and what they know of facets, areas, thickness and mass
    law : from penetration and area to force
    area : nodal contact areas; `FacetArea` if omitted, the slave's tributary areas for a slave
        without facets
    search : "intersection": a point is in contact from the step in which its path enters the body
        from the free side; "penetration": from the step in which it lies inside
    contact_type : which side deforms (thesis, 3.2). "slave": areas of the slave. "master": the
        areas of the master; those of methods that measure on the slave are carried there along
        the normal. "combined": both, the penetration is
        split so that the stresses agree; needs stress laws of both
    on_edge : "release" points whose foot leaves the surface over a border, or "hold" them on it
    through : "release" points that leave a body by another wall than they came in by, or "hold"
        what went right through on the wall it came in by until it is back; needs search by
        intersection
    master_law : stress law of the master, for type "combined"
    depth : deepest penetration that search by penetration takes for one, length; without limit
        for closed bodies and a tenth of the size for open ones if omitted

    Raises
    ------
    InputError
        An option that is not known, a law that lacks what it needs (thickness, mass), areas that
        do not fit the slave.

    Examples
    --------
    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    >>> pad = cg.Slave([[0.0, 0.0, 1.1]], area=[0.5])
    >>> contact = cg.Contact(ball, pad, law=cg.PenaltyLaw(100.0))
    >>> state = contact.start(pad.points)
    >>> state = contact.step(state, pad.points - [0.0, 0.0, 0.2], dt=1.0)
    >>> round(state.max_penetration, 12), abs(state.total_force.round(9)).tolist()
    (0.1, [0.0, 0.0, 10.0])
    """

    def __init__(
        self,
        master: Master,
        slave: Slave,
        *,
        law: Law,
        area: AreaMethod | None = None,
        search: str = "intersection",
        contact_type: str = "slave",
        on_edge: str = "release",
        through: str = "release",
        master_law: StressLaw | None = None,
        depth: float | None = None,
    ) -> None:
        choice("search", search, SEARCHES)
        choice("contact_type", contact_type, TYPES)
        choice("on_edge", on_edge, EDGES)
        choice("through", through, THROUGH)
        check_through(through, search)
        kind("slave", slave, Slave)
        check_methods(law, area)
        check_master(master, area)
        self.master = master
        self.slave = slave
        self.contact_type = contact_type
        self.law = law_of(law, master_law, contact_type)
        self.area: AreaMethod = _default_area(slave) if area is None else area
        check_needs(self.law, slave)
        rest = Rest(slave.points, slave.facets, slave.area, master)
        self._prepared = prepared(self.area, rest)
        self.search = search
        self.on_edge = on_edge
        self.through = through
        self.depth = None if depth is None else positive(depth, "depth", finite=False)

    def _facts(self) -> Facts:
        return [
            ("slave", self.slave.name or len(self.slave)),
            ("master", self.master.name or type(self.master).__name__),
            ("law", type(self.law).__name__),
            ("area", type(self.area).__name__),
            ("search", self.search),
            ("type", self.contact_type),
        ]

    @property
    def _surface(self) -> Surface:
        return self.master.surface

    @cached_property
    def _options(self) -> Options:
        # Kept: size and borders of a mesh cost as much as a small step.
        closed, size, bounds = self._surface.closed, self.master.size, self.master.bounds()
        depth = self.depth
        if depth is None:
            depth = np.inf if closed else OPEN_DEPTH * size
        band = SAME_PLACE * size + ROUNDING * float(np.abs(bounds).max())
        hold, through = self.on_edge == "hold", self.through == "hold"
        inside = self.search == "penetration"
        return Options(inside, hold, through, depth, closed, size, band, bounds)

    def start(
        self, points: ArrayLike, pose: ArrayLike | None = None, *, clock: StageClock = _untimed
    ) -> State:
        """The state at the start.

        Search by intersection starts without contact: a point that begins inside has not come in
        from the free side, and would make a force at once. Search by penetration takes it.

        Parameters
        ----------
        points : (n, 3) slave points, world axes
        pose : (4, 4) X_WB of the master, the identity if omitted
        clock : times the stages

        Raises
        ------
        InputError
            Points that do not fit the slave, a pose that is not one.
        """
        p_W, X_WB = self._checked(points, pose)
        with clock("search"):
            p_B = to_body(X_WB, p_W)
            found = detect_at_start(self._surface, p_B, self.slave.active, self._options)
        none = np.zeros((len(p_B), self.law.n_memory))
        return self._respond(found, (p_W, p_B, X_WB), (np.zeros(len(p_B)), none), 0.0, clock)

    def step(
        self,
        state: State,
        points: ArrayLike,
        pose: ArrayLike | None = None,
        dt: float = 1.0,
        *,
        clock: StageClock = _untimed,
    ) -> State:
        """The state after a step in which the slave went to `points` and the master to `pose`.

        Pure: `state` is not changed, and the same arguments give the same bits.

        Parameters
        ----------
        state : of the last step
        points : (n, 3) slave points, world axes
        pose : (4, 4) X_WB of the master, the identity if omitted
        dt : length of the step, > 0
        clock : times the stages

        Raises
        ------
        InputError
            Points that do not fit the slave or the state, a pose that is not one, dt ≤ 0.
        """
        p_W, X_WB = self._checked(points, pose)
        dt = positive(dt, "dt")
        self._check_state(state)
        with clock("search"):
            p_B = to_body(X_WB, p_W)
            last = Last(state.points_B, state.patch, state.uv, state.near, state.safe_distance)
            poses = state.pose, X_WB
            found = detect_on_curves(
                self._surface, p_B, last, self.slave.active, self._options, poses
            )
            rate = _rates(state, found, p_B, dt)
        return self._respond(found, (p_W, p_B, X_WB), (rate, state.memory), dt, clock)

    def outlines(self, state: State, pose: ArrayLike | None = None) -> Outlines | None:
        """Closed lines around the regions of contact of `state`, world axes.

        Parameters
        ----------
        state : of this contact
        pose : (4, 4) X_WB of the master then, the identity if omitted

        Returns
        -------
        Outlines
            On the slave or the master, whichever the area is measured on; None for area methods
            that do not tell where contact ends (constant nodal areas).
        """
        self._check_state(state)
        X_WB = identity() if pose is None else as_pose(pose)
        return outlines_of_state(state, X_WB, self.master, self.area, self._side, self._prepared)

    @property
    def has_outlines(self) -> bool:
        """Whether the area method tells where contact ends."""
        return hasattr(self.area, "outlines")

    @property
    def _side(self) -> str:
        return "master" if self.contact_type == "master" else "slave"

    def _checked(self, points: ArrayLike, pose: ArrayLike | None) -> tuple[FloatArray, FloatArray]:
        p_W = as_points(points)
        if len(p_W) != len(self.slave):
            raise InputError(
                "points must have one row a slave point",
                where="points",
                found=len(p_W),
                allowed=str(len(self.slave)),
            )
        return p_W, identity() if pose is None else as_pose(pose)

    def _check_state(self, state: State) -> None:
        kind("state", state, State)
        if len(state.status) != len(self.slave):
            raise InputError(
                "the state is of another slave",
                where="state",
                found=len(state.status),
                allowed=f"{len(self.slave)} points",
            )
        if state.memory.shape[1] != self.law.n_memory:
            raise InputError(
                "the state is of another law",
                where="state.memory",
                found=state.memory.shape,
                allowed=f"({len(self.slave)}, {self.law.n_memory})",
            )
        pieces = self.master.n_pieces
        if int(state.patch.max(initial=-1)) >= pieces:
            raise InputError(
                "the state is of another master",
                where="state.patch",
                found=int(state.patch.max()),
                allowed=f"-1 … {pieces - 1}",
            )

    def _law_input(
        self,
        rows: IntArray,
        penetration: tuple[FloatArray, FloatArray],
        area: FloatArray,
        dt: float,
        memory: FloatArray,
    ) -> LawInput:
        """What the law sees of the points `rows`, of penetration (λ, dλ/dt)."""
        thickness, mass = self.slave.thickness, self.slave.mass
        return LawInput(
            locked(penetration[0]),
            penetration[1],
            locked(area),
            None if thickness is None else thickness[rows],
            None if mass is None else mass[rows],
            dt,
            memory,
        )

    def _wrench(self, force: FloatArray, foot_W: FloatArray, X_WB: FloatArray) -> FloatArray:
        """(6,) force and moment on the master about its reference point, world axes."""
        reference_W = to_world(X_WB, self.master.reference_point[None, :])[0]
        moment = np.cross(foot_W - reference_W, force).sum(axis=0)
        return 0.0 - np.concatenate((force.sum(axis=0), moment))

    def _respond(
        self,
        found: Detected,
        where: tuple[FloatArray, FloatArray, FloatArray],
        past: tuple[FloatArray, FloatArray],
        dt: float,
        clock: StageClock,
    ) -> State:
        """Areas, forces and sums of what the search has found.

        `where` is (p_W, p_B, X_WB), `past` the rate of λ (n,) and what the law remembers (n, m).
        """
        p_W, p_B, X_WB = where
        rate, memory = past
        rows = np.flatnonzero(found.feet.patch >= 0).astype(np.int32)
        feet = rows_of(found.feet, rows)
        with clock("area"):
            areas = self._areas(rows, p_B, feet)
        with clock("forces"):
            depth = np.maximum(-feet.gap, 0.0)
            inp = self._law_input(rows, (depth, rate[rows]), areas.area, dt, memory[rows])
            answer = checked_answer(self.law, inp)
            n_W = turn_to_world(X_WB, feet.normal)
            foot_W = to_world(X_WB, feet.point)
            force = answer.force[:, None] * n_W
            wrench = self._wrench(force, foot_W, X_WB)
        n = len(p_W)
        return State(
            status=found.status,
            feature=found.feet.feature,
            patch=found.feet.patch,
            uv=found.uv,
            near=found.near,
            penetration=_scattered(n, rows, depth),
            normal=_scattered(n, rows, n_W),
            foot=_scattered(n, rows, foot_W, p_W),
            area=_scattered(n, rows, areas.area),
            force=_scattered(n, rows, force),
            stiffness=_scattered(n, rows, answer.stiffness),
            stored=np.asarray(answer.stored.sum()),
            memory=_scattered(n, rows, answer.memory),
            clusters=_scattered(n, rows, areas.clusters, np.full(n, -1, np.int32)),
            points_B=p_B,
            pose=X_WB,
            certified=found.feet.certified,
            safe_distance=found.safe_distance,
            wrench=wrench,
        )

    def _areas(self, rows: IntArray, p_B: FloatArray, feet: Projection) -> Areas:
        side = self._side
        own = self.slave.area
        inp = AreaInput(self.master, rows, p_B, feet, own, side, self._prepared)
        areas = self.area.measure(inp)
        if side == "slave" or areas.on == "master":
            return areas
        return areas._replace(area=areas.area / offset_ratio(self.master, feet))


def _default_area(slave: Slave) -> AreaMethod:
    has_facets = slave.facets is not None and len(slave.facets) > 0
    return FacetArea() if has_facets else NodalArea()


def _rates(state: State, found: Detected, p_B: FloatArray, dt: float) -> FloatArray:
    """(n,) dλ/dt: the change of λ of old contacts, the speed of approach of new ones."""
    now = np.maximum(-found.feet.gap, 0.0)
    old = (now - state.penetration) / dt
    with np.errstate(invalid="ignore"):
        approach = -((p_B - state.points_B) * found.feet.normal).sum(axis=1) / dt
    return np.where(state.patch >= 0, old, np.where(np.isfinite(approach), approach, 0.0))


def _scattered(
    n: int, rows: np.ndarray, values: np.ndarray, base: np.ndarray | None = None
) -> np.ndarray:
    """`values` in their rows of an array of n, `base` (zero if omitted) in the others."""
    whole = np.zeros((n, *values.shape[1:]), values.dtype) if base is None else base.copy()
    whole[rows] = values
    return whole
