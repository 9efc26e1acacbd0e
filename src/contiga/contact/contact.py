"""A contact between a rigid master and a slave: from positions to forces, step by step."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from contiga.area.method import AreaInput, AreaMethod, Areas, Outlines, Rest, prepared, weights_of
from contiga.arrays.layout import as_points, locked, positive, read_only
from contiga.contact.checks import (
    MasterLaw,
    check_friction,
    check_master,
    check_methods,
    check_needs,
    check_sampling,
    check_shell,
    check_state,
    kind,
    law_of,
)
from contiga.contact.choices import check_choices
from contiga.contact.curved import detect_on_curves, is_turned
from contiga.contact.detect import detect, detect_at_start
from contiga.contact.dry_run import DryRun, dry_run
from contiga.contact.kernels.totals_nb import WORK
from contiga.contact.loads import NO_FORCES, NOWHERE, Column, Kept, holds_of
from contiga.contact.measured import Measure
from contiga.contact.points import default_area, half_of, pressure_of, sampling_of
from contiga.contact.respond import (
    PLAIN,
    ContactRows,
    Frame,
    PreviousStep,
    Velocities,
    feet_carried,
    forces,
    relative_velocity,
    respond,
    touching,
)
from contiga.contact.reused import given_up
from contiga.contact.search_records import (
    BoolArray,
    Columns,
    Detected,
    Last,
    Options,
    Workspace,
    Workspaces,
    options_of,
)
from contiga.contact.shape import Shape, shape_of
from contiga.contact.state import State, own_arrays, state_of
from contiga.contact.tangent import (
    Asked,
    Linearisation,
    StepInputs,
    kinks_of,
    linearisation_of,
    tangent_of,
)
from contiga.display import Displayed, Facts
from contiga.errors import InputError
from contiga.laws.friction import Friction
from contiga.laws.normal import Law
from contiga.masters.protocol import Master, Surface
from contiga.records import FloatArray, IndexArray, IntArray, LawInput, SurfacePlaces, rows_of
from contiga.rigid.frames import standing, to_body, turn_to_world
from contiga.rigid.pose import identity
from contiga.rigid.transform import PoseLike, vector
from contiga.slaves.slave import Slave

if TYPE_CHECKING:
    from scipy.sparse import csr_array

StageClock = Callable[[str], AbstractContextManager[None]]
"""Called with the name of a stage, gives a context that times it."""
_NO_CLOCK: AbstractContextManager[None] = nullcontext()


def untimed(_: str) -> AbstractContextManager[None]:
    """Give a context that times nothing."""
    return _NO_CLOCK


class Contact(Displayed):
    """Contact of a slave with a rigid master.

    Parameters
    ----------
    master : the rigid body: exact geometry, or triangles
    slave : the points, and what they know of facets, areas, thickness and mass
    law : from penetration and area to force
    area : how the contact areas of results are measured; `FacetArea` if omitted, the slave's
        tributary areas for a slave without facets
    search : "intersection": a point is in contact from the step in which its path enters the body
        from the free side; "penetration": from the step in which it lies inside
    contact_type : which side deforms (thesis, 3.2). "slave": areas of the slave. "master": the
        areas of the master; those of methods that measure on the slave are carried there along
        the normal. "combined": both in series; needs stress laws of both, or force laws
    on_edge : "release" points whose foot leaves the surface over a border, or "hold" them on it
    weights : area that the law gives a point. "rest": a fixed one, the point's share of the slave
        at rest (of `NodalArea(value)` that value), so that forces are the gradient of an energy.
        "area": the contact area as it is measured in each step, as in the thesis; such forces make
        and lose energy
    quadrature : points of contact. "nodes": the slave's nodes. 1, 3, 6 or 12: so many points on
        each facet, for coarse meshes
    shell_thickness : (n,) or one for every point, length: the slave's points are the mid-surface of
        a shell so thick, and contact begins at half of it, on every side. The nearest wall pushes
        then, wherever a point came in. Facets have it where all their corners do
    friction : `Coulomb` or `ViscousFriction`; none if omitted
    through : tunnelling. "release": points that leave a body by another wall than they came in by
        are free. "hold": they stay on that wall until they are back; needs search by intersection
    foot : the wall that pushes a point. "nearest": the nearest one that is not opposite to the
        wall that holds it, so that depth is a function of the place, whatever the way in.
        "tracked": the one it came in by, followed as a local minimum of the distance, as in the
        thesis; so it is with `through="hold"`, whatever is said here
    master_law : for type "combined": a law as `law`, or `FaceLaws` of stress laws
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
        weights: str = "rest",
        quadrature: str | int = "nodes",
        shell_thickness: ArrayLike | None = None,
        friction: Friction | None = None,
        through: str = "release",
        foot: str = "nearest",
        master_law: MasterLaw | None = None,
        depth: float | None = None,
    ) -> None:
        check_choices(
            {
                "search": search,
                "contact_type": contact_type,
                "on_edge": on_edge,
                "weights": weights,
                "quadrature": quadrature,
                "through": through,
                "foot": foot,
            },
            shell_thickness is not None,
        )
        kind("slave", slave, Slave)
        check_methods(law, area)
        check_friction(friction)
        check_master(master, area)
        self.master = master
        self._reference_point = read_only(vector(master.reference_point, "reference_point"))
        self.slave = slave
        self.contact_type = contact_type
        self.law = law_of(law, master_law, contact_type)
        self.friction = friction
        self.area: AreaMethod = default_area(slave) if area is None else area
        check_needs(self.law, slave, master)
        self.weights = weights
        self.quadrature = quadrature
        check_sampling(quadrature, weights, self.law, self.area)
        check_shell(shell_thickness, contact_type, self.area)
        rest = Rest(slave.points, slave.facets, slave.area, master)
        kept = prepared(self.area, rest)
        side = "master" if contact_type == "master" else "slave"
        self._sampling = sampling_of(
            slave, quadrature, weights, weights_of(self.area, rest, kept), self.law
        )
        self.half_thickness = half = half_of(shell_thickness, slave, self._sampling)
        self._measure = Measure(master, self.area, side, slave.area, kept, half)
        self.search = search
        self.on_edge = on_edge
        self.through = through
        self.foot = foot
        self.depth = None if depth is None else positive(depth, "depth", finite=False)
        self._workspaces = Workspaces()

    def _facts(self) -> Facts:
        return [
            ("slave", self.slave.name or len(self.slave)),
            ("master", self.master.name or type(self.master).__name__),
            ("law", type(self.law).__name__),
            ("area", type(self.area).__name__),
            ("search", self.search),
            ("type", self.contact_type),
            ("weights", self.weights),
            ("quadrature", self.quadrature),
            *([] if self.half_thickness is None else [("shell", "half its thickness")]),
            *([] if self.friction is None else [("friction", type(self.friction).__name__)]),
        ]

    @cached_property
    def _surface(self) -> Surface:
        return self.master.surface

    def __getstate__(self) -> dict[str, Any]:
        # Copies, and what is written to files, ask the master for it themselves.
        return {name: value for name, value in vars(self).items() if name != "_surface"}

    @cached_property
    def _n_pieces(self) -> int:
        return self.master.n_pieces

    @property
    def follows_feet(self) -> bool:
        """Whether contact is at tracked feet on the walls entered, not at closest points."""
        return self.half_thickness is None and not self._options.nearest

    @cached_property
    def _options(self) -> Options:
        # Kept: size and borders of a mesh cost as much as a small step.
        through = self.through == "hold"
        nearest = self.foot == "nearest" and not through  # what is held must be followed
        how = self.search == "penetration", self.on_edge == "hold", through, nearest
        half = self.half_thickness
        return options_of(how, self.depth, self._surface.closed, self.master, half)

    def start(
        self,
        points: ArrayLike,
        pose: PoseLike | None = None,
        *,
        control_points: ArrayLike | None = None,
        clock: StageClock = untimed,
    ) -> State:
        """The state at the start.

        Search by intersection starts without contact: a point that begins inside has not come in
        from the free side, and would make a force at once. Search by penetration takes it.

        Parameters
        ----------
        points : (n, 3) slave points, world axes
        pose : X_WB of the master, (4, 4), a scipy `Rotation` or a pair (R, t); the identity if
            omitted
        control_points : (m, 3) of the master, as of `step`
        clock : times the stages

        Raises
        ------
        InputError
            Points that do not fit the slave, a pose that is not one, control points that do not fit
            the master.
        """
        p_W, X_WB = self._checked(points, pose)
        shape = None
        if control_points is not None:
            shape = shape_of(self.master, self.follows_feet, control_points)
        with clock("search"):
            p_B, surface = to_body(X_WB, p_W), self._surface if shape is None else shape.surface
            detected = detect_at_start(surface, p_B, self._sampling.active, self._options)
        held = touching(detected, p_B, None)
        return self._respond(detected, held, (p_B, X_WB), None, clock, shape=shape)

    def step(
        self,
        state: State,
        points: ArrayLike,
        pose: PoseLike | None = None,
        dt: float | None = None,
        *,
        velocity: ArrayLike | None = None,
        twist: Velocities | None = None,
        control_points: ArrayLike | None = None,
        control_velocity: ArrayLike | None = None,
        clock: StageClock = untimed,
        out: State | None = None,
    ) -> State:
        """The state after a step that takes the slave to `points` and the master to `pose`.

        Pure: `state` is not changed, and the same arguments give the same bits.

        Parameters
        ----------
        state : of the last step
        points : (n, 3) slave points, world axes
        pose : X_WB of the master, (4, 4), a scipy `Rotation` or a pair (R, t); the identity if
            omitted
        dt : length of the step, > 0; or 0 in statics, where there are no rates, and laws and
            friction remember and slide all the same; `AdaptiveLaw` has no force there, and refuses
            it. May be omitted where no force depends on it: without damping, friction that depends
            on the velocity and `AdaptiveLaw`, or with `velocity`
        velocity : (n, 3) of the slave points, world axes. Damping and friction take rates and
            slip from it and `twist`, exact; without, from the step's change
        twist : (v, w) of the master, each (3,), world axes: velocity of its frame's origin and
            spin in radians a time. May be omitted of a master that stands still
        control_points : (m, 3) of the master, body axes, in the order of `body.net`: it changes its
            shape. `state.control_force` are the forces on them. Not with `foot="tracked"` or
            `through="hold"`. If omitted the master keeps the shape that it has in `state`
        control_velocity : (m, 3) of the control points, body axes; needed beside `velocity` where
            control points are given
        clock : times the stages
        out : a state of this contact that nobody needs any more, of an earlier step than `state`:
            its arrays are written over, which saves asking for new ones, and it becomes the answer.
            Of a step that then fails nothing is left in it

        Raises
        ------
        InputError
            Points that do not fit the slave or the state, a pose that is not one, dt < 0 or
            omitted where a force depends on it, one of velocity and twist without the other, an
            `out` that is not another state of this contact with arrays of its own, control points
            that do not fit the master, or without the velocities that go with them.
        """
        p_W, X_WB = self._checked(points, pose)
        laws = self.law, self.friction
        follows_step = any(getattr(law, "stiffness_follows_step", False) for law in laws)
        if dt is not None:
            is_number = isinstance(dt, int | float | np.number) and not isinstance(dt, bool)
            static = is_number and dt == 0 and not follows_step
            dt = 0.0 if static else positive(dt, "dt")
        elif follows_step or (
            velocity is None and any(getattr(law, "has_rate", False) for law in laws)
        ):
            raise InputError(
                "is missing: forces of this contact depend on rates",
                where="dt",
                allowed="the length of the step, > 0",
            )
        else:
            dt = 1.0
        state = self._checked_state(state)
        poses, active = (state.pose, X_WB), self._sampling.active
        speed = relative_velocity(self._sampling, p_W, poses, velocity, twist)
        shape = self._shape(state, control_points, control_velocity, speed is not None)
        past = PreviousStep(state, dt, speed, shape)
        if out is None:
            columns, p_B = Columns.of(len(p_W)), np.empty(p_W.shape)
        else:
            columns, p_B = given_up(out, state, p_W, self)
        memory = workspace, _ = self._workspaces.take(len(p_W)), columns
        try:
            with clock("search"):
                surface = self._surface if shape is None else shape.surface
                detected, held = detect_moved(
                    surface, (p_W, X_WB, p_B), past, active, self._options, memory
                )
            return self._respond(detected, held, (p_B, X_WB), past, clock, out, shape)
        finally:
            self._workspaces.give(workspace)

    def _shape(
        self,
        state: State,
        control_points: ArrayLike | None,
        velocity: ArrayLike | None,
        with_velocities: bool,
    ) -> Shape | None:
        """The shape of the master after a step from `state`; None of one that keeps its own."""
        if control_points is None and velocity is not None:
            raise InputError(
                "the velocity of control points is given and these are not",
                where="control_points",
                allowed="both or neither",
            )
        if control_points is None and len(state.control_points) == 0:
            return None
        if control_points is None:
            control_points = state.control_points
            velocity = np.zeros(state.control_points.shape) if with_velocities else None
        if with_velocities != (velocity is not None):
            raise InputError(
                "goes with the velocity of the slave",
                where="control_velocity",
                found="one without the other",
                allowed="both or neither",
                remedy="Give control_velocity=(m, 3), velocity=(n, 3) and twist=(v, w)",
            )
        before = state.control_points
        return shape_of(self.master, self.follows_feet, control_points, before, velocity)

    def dry_run(
        self, placements: Iterable[tuple[ArrayLike, PoseLike | None]], *, most: int | None = None
    ) -> Iterator[DryRun]:
        """The search alone, without forces, over a series of poses. Raises as `start` does.

        `placements` are slave points (n, 3), world axes, and poses of the master, as of `start`.
        Of the points in contact after the start `most` are followed, spread evenly; all if omitted.
        """
        checked = (self._checked(points, pose) for points, pose in placements)
        return dry_run(self._surface, checked, (self._sampling.active, most), self._options)

    def tangent(self, state: State) -> csr_array:
        """Return ∂force/∂points (3 n, 3 n), sparse: how forces on the slave change with its points.

        Of the step that has made `state`, whose own past stays as it was; exact but where areas
        are measured (`weights="area"`), which are held. Of a point that only just touches it is
        that of going deeper. Rows and columns are x, y, z of point after point, world axes.
        Without contact there are no entries.

        Raises
        ------
        InputError
            The state was not made by a start or a step, or the law has no derivatives.

        >>> import contiga as cg
        >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
        >>> pad = cg.Slave([[0.0, 0.0, 1.1]], area=[0.5])
        >>> contact = cg.Contact(ball, pad, law=cg.PenaltyLaw(100.0))
        >>> state = contact.step(contact.start(pad.points), pad.points - [0.0, 0.0, 0.2])
        >>> contact.tangent(state).toarray().diagonal().round(9).tolist()
        [11.111111111, 11.111111111, -100.0]
        """
        return tangent_of(*self._asked(state))

    def linearise(self, state: State) -> Linearisation:
        """All first derivatives of the step that has made `state`.

        Those of the forces on the slave's points and of the wrench on the master, over the points,
        over the pose of the master, and over velocities where the step was given some; and of the
        forces on points and on control points over both where it was given control points. Raises
        as `tangent` does.
        """
        return linearisation_of(*self._asked(state))

    def kinks(self, state: State) -> IntArray:
        """Return (k,) rows of `State.kinks`. Raises as `tangent` does of the state."""
        return kinks_of(*self._asked(state))

    def _asked(self, state: State) -> tuple[Asked, State, StepInputs]:
        """Return this contact as its derivatives need it, a state, and the laws' input.

        The input is that of the step which made the state.
        """
        state = self._checked_state(state)
        if state._maker not in (None, self):
            raise InputError(
                "another contact has made the state: its forces are by that one's law",
                where="state",
                allowed="states that start and step of this contact answer",
            )
        inputs: StepInputs | None = vars(state).get("inputs")
        if inputs is None:
            raise InputError(
                "the state does not know the step that made it",
                where="state",
                allowed="a state as start and step answer it",
                remedy="Of a state that was rebuilt, step from it to the same points",
            )
        surface, shape = self._surface, None
        if inputs.control_before is not None:
            change = inputs.control_before, inputs.control_velocity
            shape = shape_of(self.master, self.follows_feet, state.control_points, *change)
            surface = shape.surface
        laws = surface, shape, self.law, self.friction
        asked = Asked(*laws, self._sampling, self.half_thickness, self._reference_point)
        return asked, state, inputs

    def area_input(self, state: State) -> AreaInput:
        """The nodes in contact in `state`, as area methods see them."""
        return self._measure.input_of(self._checked_state(state))

    def areas(self, state: State) -> Areas:
        """Contact areas and regions of the nodes in contact in `state`, one row each.

        `state.area`, `state.total_area` and what else is about areas come from here.
        """
        return self._measure.areas(self._seen(state))

    def _seen(self, state: State) -> AreaInput:
        """`area_input`, looked up once."""
        arrays = vars(state)
        if "_seen" not in arrays:
            arrays["_seen"] = self.area_input(state)
        seen: AreaInput = arrays["_seen"]
        return seen

    def pressure(self, state: State) -> FloatArray:
        """Return (n,) pressure at each node: normal force over its contact area."""
        return pressure_of(self._sampling, state)

    def slid(self, state: State) -> FloatArray:
        """Return (m, 3) sliding distance of each point in contact since it came in, body axes."""
        if self.friction is None:
            return np.zeros((len(state.status), 3))
        return self.friction.slid(state.friction_memory)

    def outlines(self, state: State, pose: PoseLike | None = None) -> Outlines | None:
        """Closed lines around the regions of contact of `state`, world axes.

        Parameters
        ----------
        state : of this contact
        pose : X_WB of the master to draw them at, as of `start`; that of the state if omitted

        Returns
        -------
        Outlines
            On the slave or the master, whichever the area is measured on; None for area methods
            that do not tell where contact ends (constant nodal areas).
        """
        state = self._checked_state(state)
        X_WB = state.pose if pose is None else standing(pose)
        return self._measure.outlines(self._seen(state), X_WB)

    def nodal_sum(self, rows: IndexArray, values: FloatArray) -> Column:
        """At the slave's nodes, of `values` (k,) at the points of contact `rows` (k,)."""
        if self._sampling.first == 0:  # the points are nodes
            return Column(rows, values)
        sums = self._sampling.nodal_sum(rows, values)
        return Column(np.arange(len(sums)), sums)

    def covered(self, state: State) -> FloatArray:
        """Return the share (f,) of each facet that the points that push stand for, by area at rest.

        The slave must have facets.
        """
        return self._sampling.covered(state.kept.normal_force.nonzero().rows, self.slave)

    @property
    def has_outlines(self) -> bool:
        """Whether the area method has outlines of the regions of contact."""
        return hasattr(self.area, "outlines")

    def _checked(self, points: ArrayLike, pose: PoseLike | None) -> tuple[FloatArray, FloatArray]:
        """Points of contact and pose."""
        p_W = as_points(points)
        if len(p_W) != self._sampling.n_nodes:
            raise InputError(
                "points must have one row a slave point",
                where="points",
                found=len(p_W),
                allowed=str(self._sampling.n_nodes),
            )
        if self._sampling.first:
            p_W = self._sampling.points(p_W)
        return p_W, identity() if pose is None else standing(pose)

    def _checked_state(self, state: State) -> State:
        """The state, with arrays as kernels take them. One of another contact is refused."""
        if getattr(state, "_maker", None) is not self:
            grip = 0 if self.friction is None else self.friction.n_memory
            check_state(state, self._sampling.n_points, (self.law.n_memory, grip))
        for name in ("patch", "last_patch"):  # somebody may have written to them
            highest = int(getattr(state, name).max(initial=-1))
            if highest >= self._n_pieces:
                raise InputError(
                    "the state belongs to another master",
                    where=f"state.{name}",
                    found=highest,
                    allowed=f"-1 … {self._n_pieces - 1}",
                )
        return state if state._maker is self else own_arrays(state)

    def _respond(
        self,
        detected: Detected,
        held: ContactRows,
        places: tuple[FloatArray, FloatArray],
        past: PreviousStep | None,
        clock: StageClock,
        out: State | None = None,
        shape: Shape | None = None,
    ) -> State:
        """Forces and sums of what the search has found, points `held` in contact.

        `places` are those of all points, body axes, and the pose; `out` is a state that was given
        up, to become the answer; `shape` that of a master whose control points were given.
        """
        sampling, law, (p_B, X_WB), feet = self._sampling, self.law, places, detected.feet
        points = held.since(sampling.first) if sampling.first else held
        rows, depth = points.rows, points.depth
        seen = areas = None
        if self.weights == "area":
            with clock("area"):
                seen = self._measure.input(p_B, feet.patch, rows_of(feet, rows))
                areas = self._measure.areas(seen)
        with clock("forces"):
            if areas is not None:
                area = areas.area
            else:
                area = np.ones(len(rows)) if sampling.weight is None else sampling.weight[rows]
            if type(law) not in PLAIN:  # laws that are not ours cannot write to what they see
                depth, area = locked(depth), locked(area)
            thickness, mass = sampling.thickness, sampling.mass
            inp = LawInput(
                depth,
                points.rate,
                area,
                None if thickness is None else thickness[rows],
                None if mass is None else mass[rows],
                0.0 if past is None else past.dt,
                np.zeros((len(rows), law.n_memory))
                if past is None or law.n_memory == 0
                else past.state.kept.memory.at(rows),
                feet.patch[rows] if getattr(law, "needs_patch", False) else None,
            )
            response = respond(law, self.friction, points, inp, past)
            # The forces act where the slave's points are: so those on slave and master balance,
            # with their moments, whatever friction adds along the surface.
            frame = Frame(X_WB, self._reference_point)
            felt, is_damped = forces(points, response, p_B, past, frame)
        whole: dict[str, Any] = {
            "status": detected.status,
            "feature": feet.feature,
            "patch": feet.patch,
            "uv": detected.uv,
            "last_patch": detected.last_patch,
            "points_B": p_B,
            "pose": X_WB,
            "certified": feet.certified,
            "safe_distance": detected.safe_distance,
            "wrench": felt.totals[:WORK],
            "energies": felt.totals[WORK:],
            "control_points": NOWHERE,
            "control_force": NOWHERE,
        }
        if shape is not None:
            force_B = response.normal.force[:, None] * points.normal
            if response.friction is not None:
                force_B = force_B + response.friction.force
            at = SurfacePlaces(feet.patch[rows], detected.uv[rows])
            back = shape.spread(at, p_B[rows], -force_B)
            whole |= {"control_points": shape.now, "control_force": turn_to_world(X_WB, back)}
        if areas is not None:  # measured as the state was made, and not to be measured again
            whole |= {"_seen": seen, "areas": areas}
        force = Column(rows, felt.force)
        if sampling.first:
            whole["force"] = nodal = sampling.nodal(rows, felt.force)
            whole["wrench"][:3] = 0.0 - nodal.sum(axis=0)
            force = Column(np.arange(len(nodal), dtype=np.int32), nodal)
        answer, grip, seen_by_friction = response
        whole["inputs"] = StepInputs(
            points,
            inp,
            seen_by_friction,
            NO_FORCES if past is None else feet_carried(past),
            None if past is None or past.velocity is None else past.velocity.twist,
            None if shape is None else shape.before,
            None if shape is None else shape.velocity,
        )
        damping = answer.damping if is_damped else None
        kept = Kept(
            penetration=Column(held.rows, held.depth),
            normal_B=Column(held.rows, held.normal),
            foot_B=Column(held.rows, held.foot),
            guard_B=detected.opposed,
            normal_force=Column(rows, answer.force),
            stiffness=Column(rows, answer.stiffness),
            memory=Column(rows, answer.memory),
            force=force,
            stiffness_bound=None
            if answer.stiffness_bound is None
            else Column(rows, answer.stiffness_bound),
            damping=None if damping is None else Column(rows, damping),
            viscosity=None if damping is None else Column(rows, felt.viscosity),
            # Copies: whoever worked these out may go on with theirs.
            friction_memory=None
            if grip is None
            else Column(rows, np.array(grip.memory, np.float64)),
            traction_B=None if grip is None else Column(rows, grip.force),
            tangential=None if grip is None else Column(rows, np.array(grip.stiffness, np.float64)),
        )
        return state_of(whole, kept, self, out)


def detect_moved(
    surface: Surface,
    moved: tuple[FloatArray, FloatArray, FloatArray],
    past: PreviousStep,
    active: BoolArray,
    options: Options,
    memory: tuple[Workspace, Columns],
) -> tuple[Detected, ContactRows]:
    """One step of a body that goes from the pose of `past` to that it is `moved` to; see `detect`.

    `moved` are (p_W, X_WB, p_B): points in the world, the pose, and what body axes are written
    into.
    """
    p_W, X_WB, p_B = moved
    state = past.state
    place = state.patch, state.uv, state.last_patch
    holds = holds_of(state.kept.penetration, state.kept.normal_B.values, state.kept.guard_B)
    last = Last(state.points_B, *place, state.safe_distance, holds)
    poses = state.pose, X_WB
    if is_turned(poses) and options.half is None and past.shape is None:
        to_body(X_WB, p_W, p_B)
        detected = detect_on_curves(surface, p_B, last, active, options, poses, memory)
    else:
        moving = (p_W, X_WB), past.shape
        detected = detect(surface, p_B, last, active, options, memory, *moving)
    return detected, touching(detected, p_B, past)
