"""Define a contact between a master and a slave: from positions to forces, step by step.

`Contact.step` is one step: checks, the search (`detect`), rates, laws and friction (`respond`), and
the new state.
"""

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
    check_choices,
    check_friction,
    check_master,
    check_methods,
    check_needs,
    check_sampling,
    check_shell,
    check_state,
    check_type,
    law_of,
)
from contiga.contact.curved import detect_on_curves, is_turned
from contiga.contact.detect import detect, detect_at_start
from contiga.contact.dry_run import DryRun, dry_run
from contiga.contact.kernels.totals_nb import WORK
from contiga.contact.loads import NO_FORCES, NO_POINTS, Column, guard_states_of
from contiga.contact.measured import Measure
from contiga.contact.points import default_area, half_of, pressure_of, sampling_of
from contiga.contact.respond import (
    TRUSTED_LAWS,
    ContactRows,
    Frame,
    PreviousStep,
    Velocities,
    carried_feet,
    contact_rows,
    forces,
    kept_columns,
    relative_velocity,
    respond,
)
from contiga.contact.reused import reusable_arrays
from contiga.contact.search_records import (
    Columns,
    Detection,
    Last,
    Options,
    WorkspacePool,
    options_of,
)
from contiga.contact.shape import Shape, shape_of
from contiga.contact.state import State, own_arrays, state_of
from contiga.contact.tangent import (
    ContactSetup,
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
from contiga.records import (
    FloatArray,
    IndexArray,
    IntArray,
    LawInput,
    Projection,
    SurfacePlaces,
    rows_of,
)
from contiga.rigid.frames import checked_pose, to_body, turn_to_world
from contiga.rigid.pose import identity
from contiga.rigid.transform import PoseLike, vector
from contiga.slaves.slave import Slave

if TYPE_CHECKING:
    from scipy.sparse import csr_array

StageClock = Callable[[str], AbstractContextManager[None]]
"""Function from the name of a stage to a context that times it."""
_NO_CLOCK: AbstractContextManager[None] = nullcontext()


def untimed(_: str) -> AbstractContextManager[None]:
    """Return a context that times nothing."""
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
        check_type("slave", slave, Slave)
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
        rest_input = Rest(slave.points, slave.facets, slave.area, master)
        prepared_data = prepared(self.area, rest_input)
        side = "master" if contact_type == "master" else "slave"
        self._sampling = sampling_of(
            slave, quadrature, weights, weights_of(self.area, rest_input, prepared_data), self.law
        )
        self.half_thickness = half = half_of(shell_thickness, slave, self._sampling)
        self._measure = Measure(master, self.area, side, slave.area, prepared_data, half)
        self.search = search
        self.on_edge = on_edge
        self.through = through
        self.foot = foot
        self.depth = None if depth is None else positive(depth, "depth", finite=False)
        self._workspaces = WorkspacePool()

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
        # Copies and pickles get the surface from the master again.
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
        # Cached: size and borders of a mesh cost as much as a small step.
        through = self.through == "hold"
        nearest = self.foot == "nearest" and not through  # held points need tracked feet
        flags = self.search == "penetration", self.on_edge == "hold", through, nearest
        half = self.half_thickness
        return options_of(flags, self.depth, self._surface.closed, self.master, half)

    def start(
        self,
        points: ArrayLike,
        pose: PoseLike | None = None,
        *,
        control_points: ArrayLike | None = None,
        clock: StageClock = untimed,
    ) -> State:
        """Return the state at the start.

        A search by intersection starts without contact: a point inside has not entered from the
        free side, and would have a force at once. A search by penetration takes it into contact.

        Parameters
        ----------
        points : (n, 3) slave points, world axes
        pose : X_WB of the master, (4, 4), a scipy `Rotation` or a pair (R, t); the identity if
            omitted
        control_points : (m, 3) of the master, as in `step`
        clock : times the stages

        Raises
        ------
        InputError
            Points that do not fit the slave, a pose that is not one, control points that do not fit
            the master.
        """
        p_W, X_WB = self._checked_places(points, pose)
        shape = None
        if control_points is not None:
            shape = shape_of(self.master, self.follows_feet, control_points)
        with clock("search"):
            p_B, surface = to_body(X_WB, p_W), self._surface if shape is None else shape.surface
            detected = detect_at_start(surface, p_B, self._sampling.active, self._options)
        touching = contact_rows(detected, p_B, None)
        return self._respond(detected, touching, (p_B, X_WB), None, clock, shape=shape)

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
        """Return the state after a step that moves the slave to `points` and the master to `pose`.

        Pure: `state` is not changed, and the same arguments give the same bits.

        Parameters
        ----------
        state : state after the last step
        points : (n, 3) slave points, world axes
        pose : X_WB of the master, (4, 4), a scipy `Rotation` or a pair (R, t); the identity if
            omitted
        dt : length of the step, > 0; or 0 in statics, without rates: laws and friction still have
            memory and slip, and `AdaptiveLaw`, which would have no force, refuses it. It may be
            omitted if no force depends on it: without damping, velocity-dependent friction and
            `AdaptiveLaw`, or with `velocity`
        velocity : (n, 3) of the slave points, world axes. With it and `twist` the rates of damping
            and friction are exact; without, they are changes over the step
        twist : (v, w) of the master, each (3,), world axes: velocity of its frame's origin and
            spin in radians per time. It may be omitted for a master at rest
        control_points : (m, 3) of the master, body axes, in the order of `body.net`, which change
            its shape; the forces on them are `state.control_force`. Not with `foot="tracked"` or
            `through="hold"`. If omitted the master keeps its shape in `state`
        control_velocity : (m, 3) of the control points, body axes; needed with `velocity` if
            control points are given
        clock : times the stages
        out : a state of this contact before `state` that is no longer needed: its arrays are
            overwritten, which saves their allocation, and it becomes the result. If the step fails
            nothing is left in it

        Raises
        ------
        InputError
            Points that do not fit the slave or the state, a pose that is not one, dt < 0 or
            omitted where a force depends on it, one of velocity and twist without the other, an
            `out` that is not another state of this contact with arrays of its own, control points
            that do not fit the master, or without the velocities that go with them.
        """
        p_W, X_WB = self._checked_places(points, pose)
        dt = self._checked_step(dt, velocity)
        state = self._checked_state(state)
        speed = relative_velocity(self._sampling, p_W, (state.pose, X_WB), velocity, twist)
        shape = self._changed_shape(state, control_points, control_velocity, speed is not None)
        past = PreviousStep(state, dt, speed, shape)
        if out is None:
            columns, p_B = Columns.of(len(p_W)), np.empty(p_W.shape)
        else:
            columns, p_B = reusable_arrays(out, state, p_W, self)
        workspace = self._workspaces.take(len(p_W))
        try:
            with clock("search"):
                surface = self._surface if shape is None else shape.surface
                active, options, memory = self._sampling.active, self._options, (workspace, columns)
                last = last_of(state)
                if is_turned((state.pose, X_WB)) and options.half is None and shape is None:
                    to_body(X_WB, p_W, p_B)
                    poses = state.pose, X_WB
                    detected = detect_on_curves(surface, p_B, last, active, options, poses, memory)
                else:
                    moved = p_W, X_WB
                    detected = detect(surface, p_B, last, active, options, memory, moved, shape)
                touching = contact_rows(detected, p_B, past)
            return self._respond(detected, touching, (p_B, X_WB), past, clock, out, shape)
        finally:
            self._workspaces.give(workspace)

    def _checked_step(self, dt: float | None, velocity: ArrayLike | None) -> float:
        """Return the length of a step, checked: 1 if omitted, 0 in statics.

        Raises
        ------
        InputError
            A length that is not a positive number, zero with a law that needs a step, or none where
            forces depend on it.
        """
        laws = self.law, self.friction
        follows_step = any(getattr(law, "stiffness_follows_step", False) for law in laws)
        if dt is not None:
            is_number = isinstance(dt, int | float | np.number) and not isinstance(dt, bool)
            is_static = is_number and dt == 0 and not follows_step
            return 0.0 if is_static else positive(dt, "dt")
        has_rate = velocity is None and any(getattr(law, "has_rate", False) for law in laws)
        if follows_step or has_rate:
            raise InputError(
                "is missing: forces of this contact depend on rates",
                where="dt",
                allowed="the length of the step, > 0",
            )
        return 1.0

    def _changed_shape(
        self,
        state: State,
        control_points: ArrayLike | None,
        velocity: ArrayLike | None,
        has_velocities: bool,
    ) -> Shape | None:
        """Return the shape of the master after a step from `state`; None for a constant shape.

        Without `control_points` a master that has changed before keeps its shape, at rest.
        `velocity` (m, 3) are velocities of the control points; `has_velocities` is whether those of
        the slave are given, which must go with them.

        Raises
        ------
        InputError
            Velocities without control points, or of one side only; see also `shape_of`.
        """
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
            velocity = np.zeros(state.control_points.shape) if has_velocities else None
        if has_velocities != (velocity is not None):
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
        """Yield the results of the search alone, one per placement; raises as `start` does.

        `placements` are slave points (n, 3), world axes, and poses of the master, as in `start`. At
        most `most` points are followed after the start, evenly spread; all if omitted.
        """
        checked = (self._checked_places(points, pose) for points, pose in placements)
        return dry_run(self._surface, checked, (self._sampling.active, most), self._options)

    def tangent(self, state: State) -> csr_array:
        """Return ∂force/∂points (3 n, 3 n), sparse: how forces on the slave change with its points.

        The derivative is that of the step that made `state`, with a constant state before it. It is
        exact, except that measured areas (`weights="area"`) are constant. For a point that just
        touches it is the derivative towards larger penetration. Rows and columns are x, y, z of
        point after point, world axes. Without contact there are no entries.

        Raises
        ------
        InputError
            The state is not the result of a start or a step, or the law has no derivatives.

        >>> import contiga as cg
        >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
        >>> pad = cg.Slave([[0.0, 0.0, 1.1]], area=[0.5])
        >>> contact = cg.Contact(ball, pad, law=cg.PenaltyLaw(100.0))
        >>> state = contact.step(contact.start(pad.points), pad.points - [0.0, 0.0, 0.2])
        >>> contact.tangent(state).toarray().diagonal().round(9).tolist()
        [11.111111111, 11.111111111, -100.0]
        """
        return tangent_of(*self._derivative_input(state))

    def linearise(self, state: State) -> Linearisation:
        """Return all first derivatives of the step that made `state`. Raises as `tangent` does.

        They are derivatives of the forces on the slave's points and of the wrench on the master,
        with respect to points, pose of the master, and given velocities; with given control points
        also derivatives of the forces on these, and with respect to these.
        """
        return linearisation_of(*self._derivative_input(state))

    def kinks(self, state: State) -> IntArray:
        """Return the points (k,) of `State.kinks`. Raises as `tangent` does for the state."""
        return kinks_of(*self._derivative_input(state))

    def _derivative_input(self, state: State) -> tuple[ContactSetup, State, StepInputs]:
        """Return this contact for derivatives, the state, and the inputs of its step.

        Raises
        ------
        InputError
            Another contact made the state, or no step did.
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
        setup = ContactSetup(*laws, self._sampling, self.half_thickness, self._reference_point)
        return setup, state, inputs

    def area_input(self, state: State) -> AreaInput:
        """Return the nodes in contact in `state` as input of area methods."""
        return self._measure.input_of(self._checked_state(state))

    def areas(self, state: State) -> Areas:
        """Return contact areas and regions of the nodes in contact in `state`, one row each.

        `state.area`, `state.total_area` and other properties on areas use this.
        """
        return self._measure.areas(self._cached_area_input(state))

    def _cached_area_input(self, state: State) -> AreaInput:
        """Return `area_input`, cached in the state."""
        arrays = vars(state)
        if "_area_input" not in arrays:
            arrays["_area_input"] = self.area_input(state)
        area_input: AreaInput = arrays["_area_input"]
        return area_input

    def pressure(self, state: State) -> FloatArray:
        """Return the pressure (n,) at each node: normal force over the area that carries it.

        This is the area that weighs the force, or the measured one if no area does; zero without
        contact.
        """
        return pressure_of(self._sampling, state)

    def slid(self, state: State) -> FloatArray:
        """Return the slip (m, 3) of each point since it entered, body axes.

        It is zero without contact and without friction.
        """
        if self.friction is None:
            return np.zeros((len(state.status), 3))
        return self.friction.slid(state.friction_memory)

    def outlines(self, state: State, pose: PoseLike | None = None) -> Outlines | None:
        """Return closed lines around the regions of contact of `state`, world axes.

        Parameters
        ----------
        state : of this contact
        pose : X_WB of the master for the lines, as in `start`; that of the state if omitted

        Returns
        -------
        Outlines
            On the slave or the master, on which the area is measured; None for area methods without
            a limit of contact (constant nodal areas).
        """
        state = self._checked_state(state)
        X_WB = state.pose if pose is None else checked_pose(pose)
        return self._measure.outlines(self._cached_area_input(state), X_WB)

    def nodal_sum(self, rows: IndexArray, values: FloatArray) -> Column:
        """Return the nodal sums of `values` (k,) at the points of contact `rows` (k,).

        Quadrature points share their values among the corners of their facet, and the column has a
        row for every node of the slave; without these points its rows are `rows`.
        """
        if self._sampling.first == 0:  # the points are nodes
            return Column(rows, values)
        sums = self._sampling.nodal_sum(rows, values)
        return Column(np.arange(len(sums)), sums)

    def covered(self, state: State) -> FloatArray:
        """Return the share (f,) of each facet, by area at rest, of points with a normal force.

        The slave must have facets.
        """
        return self._sampling.covered(state.kept.normal_force.nonzero().rows, self.slave)

    @property
    def has_outlines(self) -> bool:
        """Whether the area method has outlines of the regions of contact."""
        return hasattr(self.area, "outlines")

    def _checked_places(
        self, points: ArrayLike, pose: PoseLike | None
    ) -> tuple[FloatArray, FloatArray]:
        """Return all points of contact (m, 3), world axes, and the pose, identity if omitted.

        Raises
        ------
        InputError
            Not one row of numbers per slave point, or a pose that is not one.
        """
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
        return p_W, identity() if pose is None else checked_pose(pose)

    def _checked_state(self, state: State) -> State:
        """Return the state with arrays for kernels: itself if a contact made it, else a new one.

        Raises
        ------
        InputError
            Points, memories or patches of the state do not fit this contact.
        """
        if getattr(state, "_maker", None) is not self:
            grip = 0 if self.friction is None else self.friction.n_memory
            check_state(state, self._sampling.n_points, (self.law.n_memory, grip))
        for name in ("patch", "last_patch"):  # a user may have written to them
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
        detected: Detection,
        touching: ContactRows,
        places: tuple[FloatArray, FloatArray],
        past: PreviousStep | None,
        clock: StageClock,
        out: State | None = None,
        shape: Shape | None = None,
    ) -> State:
        """Return the state with the forces on the points in contact.

        Areas are measured here only if they weigh the forces. `places` are all points, body axes,
        and the pose; `past` is None at the start; `out` is a state to be overwritten and returned;
        `shape` is that of a master whose control points were given.
        """
        sampling, law, (p_B, X_WB), feet = self._sampling, self.law, places, detected.feet
        points = touching.from_point(sampling.first) if sampling.first else touching
        rows = points.rows
        area_input = areas = None
        if self.weights == "area":
            with clock("area"):
                area_input = self._measure.input(p_B, feet.patch, rows_of(feet, rows))
                areas = self._measure.areas(area_input)
        with clock("forces"):
            if areas is not None:
                area = areas.area
            else:
                area = np.ones(len(rows)) if sampling.weight is None else sampling.weight[rows]
            law_input = self._law_input(points, area, feet, past)
            response = respond(law, self.friction, points, law_input, past)
            # The forces act at the slave's points, so that those on slave and master balance with
            # their moments, whatever friction adds along the surface.
            frame = Frame(X_WB, self._reference_point)
            point_forces, is_damped = forces(points, response, p_B, past, frame)
        fields: dict[str, Any] = {
            "status": detected.status,
            "feature": feet.feature,
            "patch": feet.patch,
            "uv": detected.uv,
            "last_patch": detected.last_patch,
            "points_B": p_B,
            "pose": X_WB,
            "certified": feet.certified,
            "safe_distance": detected.safe_distance,
            "wrench": point_forces.totals[:WORK],
            "energies": point_forces.totals[WORK:],
            "control_points": NO_POINTS,
            "control_force": NO_POINTS,
        }
        if shape is not None:
            force_B = response.normal.force[:, None] * points.normal
            if response.friction is not None:
                force_B = force_B + response.friction.force
            at_feet = SurfacePlaces(feet.patch[rows], detected.uv[rows])
            on_net = shape.spread(at_feet, p_B[rows], -force_B)
            fields |= {"control_points": shape.now, "control_force": turn_to_world(X_WB, on_net)}
        if areas is not None:  # not to be measured again
            fields |= {"_area_input": area_input, "areas": areas}
        force = Column(rows, point_forces.force)
        if sampling.first:
            fields["force"] = nodal = sampling.nodal(rows, point_forces.force)
            fields["wrench"][:3] = 0.0 - nodal.sum(axis=0)
            force = Column(np.arange(len(nodal), dtype=np.int32), nodal)
        fields["inputs"] = StepInputs(
            points,
            law_input,
            response.inputs,
            NO_FORCES if past is None else carried_feet(past),
            None if past is None or past.velocity is None else past.velocity.twist,
            None if shape is None else shape.before,
            None if shape is None else shape.velocity,
        )
        kept = kept_columns(touching, rows, response, point_forces, is_damped)
        kept = kept._replace(force=force, guard_B=detected.guards)
        return state_of(fields, kept, self, out)

    def _law_input(
        self,
        points: ContactRows,
        area: FloatArray,
        feet: Projection,
        past: PreviousStep | None,
    ) -> LawInput:
        """Return the input of the law for the points that carry forces.

        Arrays are read-only for laws that are not of this package; memories of new points are zero.
        At the start, where `past` is None, the length of the step is zero.
        """
        sampling, law, rows, depth = self._sampling, self.law, points.rows, points.depth
        if type(law) not in TRUSTED_LAWS:  # other laws must not write to these arrays
            depth, area = locked(depth), locked(area)
        thickness, mass = sampling.thickness, sampling.mass
        memory = np.zeros((len(rows), law.n_memory))
        if past is not None and law.n_memory:
            memory = past.state.kept.memory.at(rows)
        return LawInput(
            depth,
            points.rate,
            area,
            None if thickness is None else thickness[rows],
            None if mass is None else mass[rows],
            0.0 if past is None else past.dt,
            memory,
            feet.patch[rows] if getattr(law, "needs_patch", False) else None,
        )


def last_of(state: State) -> Last:
    """Return what the search of a step needs of the state before it."""
    guard_states = guard_states_of(
        state.kept.penetration, state.kept.normal_B.values, state.kept.guard_B
    )
    feet = state.patch, state.uv, state.last_patch
    return Last(state.points_B, *feet, state.safe_distance, guard_states)
