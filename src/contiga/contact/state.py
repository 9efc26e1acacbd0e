"""Define the state of a contact: a record of arrays, new at every step."""

from __future__ import annotations

from dataclasses import InitVar, dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from contiga.area.method import AreaInput, Areas
from contiga.arrays.layout import as_contiguous
from contiga.arrays.ordered import product
from contiga.contact.loads import NO_POINTS, Column, Guards, KeptColumns
from contiga.display import Displayed, Facts
from contiga.errors import InputError
from contiga.records import IN_CONTACT, ByteArray, FloatArray, IntArray
from contiga.rigid.frames import to_world, turn_to_world

_TOUCHES = np.zeros(256, dtype=bool)
"""Whether each number of a byte is a status of points in contact."""
_TOUCHES[list(IN_CONTACT)] = True


class ContactEnergy(NamedTuple):
    """Energies of a contact since its start: `stored` is the present one, the others are sums."""

    work: float
    """Work done on the contact by the motion of its two sides, by the trapezoidal rule over each
    step, as in a central difference or Verlet integrator; it includes the energy stored at the
    start."""
    stored: float
    """Energy that the law and sticking friction would return."""
    hysteresis: float
    """Loss by a separate unloading curve of the law."""
    damping: float
    """Loss by damping of the law."""
    friction: float
    """Loss by sliding."""

    @property
    def error(self) -> float:
        """Error of the energy balance.

        It is the error of integration, which falls with the square of the step, and the energy that
        forces gain or lose if they are not the gradient of an energy.
        """
        return self.work - self.stored - self.hysteresis - self.damping - self.friction


class HeldInWorld(NamedTuple):
    """The points in contact and the normals at their feet, world axes."""

    points: Column
    normals: Column


class Owner(Protocol):
    """The methods of its contact that a state uses."""

    @property
    def weights(self) -> str:
        """The weights of the force: areas at "rest", or the measured contact "area"."""

    def area_input(self, state: State) -> AreaInput:
        """The nodes in contact, as area methods see them."""

    def areas(self, state: State) -> Areas:
        """Nodal contact areas, one row a node in contact."""

    def pressure(self, state: State) -> FloatArray:
        """Return the pressure (n,) of the law at each node, zero without contact."""

    def slid(self, state: State) -> FloatArray:
        """Return the slip (m, 3) of each point since it entered, body axes."""

    def kinks(self, state: State) -> IntArray:
        """Return the points (k,) that another piece of the master pushes than before."""


@dataclass(frozen=True, eq=False, repr=False)
class State(Displayed):
    """The state of contact of n slave nodes after a step; world axes unless stated otherwise.

    Arrays (m,) have a row for each point of contact: the nodes, followed by the quadrature points
    of each facet; without these m = n. The arrays take 179 bytes per point, and eight for each
    number in the memory of laws. Arrays that are zero without contact are stored for points in
    contact only, and made when first used. The inputs of the laws in the step are stored as well,
    for its derivatives: 50 bytes per point in contact, and 140 more with friction. Properties,
    areas above all, are computed when first used.

    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    >>> pad = cg.Slave([[0.0, 0.0, 1.1], [3.0, 0.0, 1.1]], area=[0.5, 0.5])
    >>> contact = cg.Contact(ball, pad, law=cg.PenaltyLaw(100.0))
    >>> state = contact.step(contact.start(pad.points), pad.points - [0.0, 0.0, 0.2], dt=1.0)
    >>> [cg.ContactStatus(s).name for s in state.status], state.penetration.round(12).tolist()
    (['NEW', 'FREE'], [0.1, 0.0])
    >>> round(state.energy.stored, 12)
    0.5
    """

    status: ByteArray
    """(m,) `ContactStatus`."""
    feature: ByteArray
    """(m,) `Feature` of the foot, −1 without contact."""
    patch: IntArray
    """(m,) patch of the foot, −1 without contact."""
    uv: FloatArray
    """(m, 2) parameters of the foot; for a free point those on `last_patch`."""
    last_patch: IntArray
    """(m,) patch of the foot that proved the side of a free point, −1 without one."""
    penetration: FloatArray
    """(m,) λ ≥ 0."""
    normal_B: FloatArray
    """(m, 3) unit normal at the foot towards the free side, body axes; zero without contact."""
    guard_B: FloatArray
    """(m, 3) guard of a point whose nearest wall is opposite to the one that holds it, body axes;
    zero for other points, whose guard is the normal at the foot."""
    foot_B: FloatArray
    """(m, 3) foot, body axes; the point itself without contact."""
    points_B: FloatArray
    """(m, 3) the slave points, body axes."""
    pose: FloatArray
    """(4, 4) X_WB of the master."""
    normal_force: FloatArray
    """(m,) force along the normal; zero without contact."""
    force: FloatArray
    """(n, 3) force on the slave's nodes, friction included."""
    stiffness: FloatArray
    """(m,) slope of the normal force over the penetration, zero without contact."""
    stiffness_bound: FloatArray
    """(m,) `LawOutput.stiffness_bound`, zero without contact; (0,) for laws without."""
    damping: FloatArray
    """(m,) the part of `normal_force` that is due to the rate; (0,) for laws without."""
    viscosity: FloatArray
    """(m,) `damping` over the rate of penetration; (0,) for laws without."""
    memory: FloatArray
    """(m, k) memory of the law, zero without contact."""
    friction_memory: FloatArray
    """(m, k) memory of friction, body axes; k = 0 without."""
    traction_B: FloatArray
    """(m, 3) friction forces on the points, body axes; (0, 3) without friction."""
    tangential: FloatArray
    """(m,) stiffness of friction's springs; (0,) without friction."""
    certified: ByteArray
    """(m,) 1 if the foot of a point in contact is proved: continued without a jump, or the closest
    point."""
    safe_distance: FloatArray
    """(m,) path length up to which a free point cannot touch, and a point in a closed body cannot
    leave. It is negative for points inside since the start, which have not entered."""
    wrench: FloatArray
    """(6,) force and moment on the master about its reference point: the opposite of the forces at
    the slave's points."""
    energies: FloatArray
    """(5,) `energy` as an array."""
    control_points: FloatArray = field(default_factory=lambda: NO_POINTS)
    """(m, 3) of the master, body axes, in the order of `body.net`; (0, 3) for a constant shape."""
    control_force: FloatArray = field(default_factory=lambda: NO_POINTS)
    """(m, 3) forces on the master's control points, in balance with the forces on the slave's
    points and their moments; (0, 3) for a constant shape."""
    of: InitVar[Owner | None] = None
    """The contact of the state."""
    _maker: ClassVar[Owner | None] = None
    """The contact whose start or step made the state; None for a state made by hand."""

    def __post_init__(self, of: Owner | None) -> None:
        self.__dict__["_contact"] = of

    if not TYPE_CHECKING:  # mypy would accept any name

        def __getattr__(self, name: str) -> Any:
            """Return an array that is stored for some rows only, made on first use."""
            kept: KeptColumns | None = self.__dict__.get("kept")
            if kept is not None and name in KeptColumns._fields:
                whole = self.__dict__[name] = kept.whole(name, self.points_B)
                return whole
            spent = "" if self.__dict__ else " any more: it was the out of a step that failed"
            raise AttributeError(f"a State has no {name!r}{spent}", name=name, obj=self)

    @property
    def contact(self) -> Owner:
        """The contact of the state.

        Raises
        ------
        InputError
            The state was made by hand, without a contact.
        """
        owner: Owner | None = self.__dict__["_contact"]
        if owner is None:
            raise InputError(
                "the state belongs to no contact, which would measure its areas",
                where="state",
                allowed="states that Contact.start and Contact.step answer",
            )
        return owner

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All arrays for the next step, by name: `State(**arrays, of=contact)` is the state."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @cached_property
    def kept(self) -> KeptColumns:
        """Rows, for points in contact, of the arrays that are zero without contact.

        Steps store them; for a state made by hand they follow from the whole arrays.
        """
        touching = np.flatnonzero(self.patch >= 0).astype(np.int32)
        rows: dict[str, Any] = {}
        for name in KeptColumns._fields:
            array = getattr(self, name)
            rows[name] = (
                Column(touching, array[touching]) if len(array) == len(self.patch) else None
            )
        if rows["force"] is None:  # at nodes, while quadrature points carry forces
            rows["force"] = Column(np.arange(len(self.force), dtype=np.int32), self.force)
        if self.friction_memory.shape[1] == 0 and len(self.traction_B) == 0:
            rows["friction_memory"] = None
        guarded = rows["guard_B"].values.any(axis=1)
        rows["guard_B"] = Guards(touching[guarded], rows["guard_B"].values[guarded])
        return KeptColumns(**rows)

    @cached_property
    def held_W(self) -> HeldInWorld:
        """The points in contact and the normals at their feet, world axes."""
        rows, normals = self.kept.normal_B
        points = to_world(self.pose, self.points_B[rows])
        return HeldInWorld(Column(rows, points), Column(rows, turn_to_world(self.pose, normals)))

    def _facts(self) -> Facts:
        return [
            ("points", len(self.status)),
            ("in contact", self.n_contact),
            ("deepest", self.max_penetration),
            ("force", tuple(map(float, self.total_force))),
            ("not proved", self.n_unproved),
        ]

    @property
    def in_contact(self) -> NDArray[np.bool_]:
        """Whether each point (n,) is in contact."""
        return _TOUCHES[self.status]

    @property
    def n_contact(self) -> int:
        """Number of points in contact."""
        return int(self.in_contact.sum())

    @property
    def n_unproved(self) -> int:
        """Number of points in contact whose foot is not certified."""
        return int((self.in_contact & (self.certified == 0)).sum())

    @property
    def max_penetration(self) -> float:
        """Largest penetration, zero without contact."""
        deep = self.penetration if self._maker is None else self.kept.penetration.values
        return float(deep.max(initial=0.0))

    @property
    def total_force(self) -> FloatArray:
        """Force (3,) on the slave: the sum of `force`. The master feels the opposite."""
        total: FloatArray = self.force.sum(axis=0)
        return total

    @cached_property
    def energy(self) -> ContactEnergy:
        """Energy stored, dissipated by cause, and the balance error since the start."""
        return ContactEnergy(*self.energies.tolist())

    @cached_property
    def normal(self) -> FloatArray:
        """Unit normals (m, 3) at the feet, to the free side; zero without contact."""
        return turn_to_world(self.pose, self.normal_B)

    @cached_property
    def foot(self) -> FloatArray:
        """Feet (m, 3); the points themselves without contact."""
        return to_world(self.pose, self.foot_B)

    @cached_property
    def friction(self) -> FloatArray:
        """Friction forces (m, 3) on the points."""
        if len(self.traction_B) == 0:
            return np.zeros((len(self.status), 3))
        return turn_to_world(self.pose, self.traction_B)

    @cached_property
    def slip(self) -> FloatArray:
        """Slip (m, 3) of each point in contact over the body since it entered.

        It is carried along with the foot, and is zero without friction with a memory.
        """
        return turn_to_world(self.pose, self.contact.slid(self))

    @cached_property
    def kinks(self) -> IntArray:
        """Rows (k,), ascending, of points that another piece of the master pushes than before.

        These points are in contact before and after the step, and their feet have passed to another
        patch, to or from an edge or a vertex, or have jumped to another wall, more than twice as
        far as their derivative allows. Between the two states the derivative of their force jumps,
        and from wall to wall the force itself: Newton's method may oscillate there. For points that
        enter or leave see `status`.

        Raises
        ------
        InputError
            The state is not the result of a start or a step.
        """
        return self.contact.kinks(self)

    @cached_property
    def areas(self) -> Areas:
        """Contact areas and regions of the nodes in contact, measured on first use."""
        return self.contact.areas(self)

    @cached_property
    def area(self) -> FloatArray:
        """Nodal contact area (n,), zero without contact."""
        area = np.zeros(len(self.force))
        area[self._nodes] = self.areas.area
        return area

    @cached_property
    def clusters(self) -> IntArray:
        """Connected region of contact (n,), −1 without contact."""
        clusters = np.full(len(self.force), -1, np.int32)
        clusters[self._nodes] = self.areas.clusters
        return clusters

    @cached_property
    def _nodes(self) -> IntArray:
        """Nodes in contact."""
        return np.flatnonzero(self.patch[: len(self.force)] >= 0).astype(np.int32)

    @property
    def total_area(self) -> float:
        """Contact area."""
        return float(self.areas.area.sum())

    @property
    def n_clusters(self) -> int:
        """Number of connected regions of contact."""
        return int(self.areas.clusters.max(initial=-1)) + 1

    @property
    def mean_pressure(self) -> float:
        """Sum of the normal forces over the contact area, zero without contact."""
        area = self.total_area
        return float(self.normal_force.sum()) / area if area > 0.0 else 0.0

    @property
    def max_pressure(self) -> float:
        """Largest nodal pressure, zero without contact."""
        return float(self.pressure.max(initial=0.0))

    @property
    def centre_of_pressure(self) -> FloatArray:
        """Mean (3,) of the feet, weighted by normal forces; NaN without force."""
        rows, size = self.kept.normal_force.nonzero()
        total = size.sum()
        if not total > 0.0:
            return np.full(3, np.nan)
        mean = product(size, self.kept.foot_B.at(rows)) / total
        return to_world(self.pose, mean[None, :])[0]

    @cached_property
    def pressure(self) -> FloatArray:
        """Pressure (n,) at each node: normal force over its contact area."""
        return self.contact.pressure(self)


def state_of(
    fields_by_name: dict[str, Any], kept: KeptColumns, owner: Owner, spent: State | None = None
) -> State:
    """Return a state with these fields; other arrays are made of `kept` on first use.

    The state owns the arrays. A `spent` state is filled in instead of a new one.
    """
    state: State = object.__new__(State) if spent is None else spent
    vars(state).update(fields_by_name, _contact=owner, kept=kept, _maker=owner)
    return state


_TYPES = {"ByteArray": np.int8, "IntArray": np.int32, "FloatArray": np.float64}


def own_arrays(state: State) -> State:
    """Return the state with contiguous arrays of the types of kernels: itself if a step made it."""
    if state._maker is not None:
        return state
    arrays = {
        f.name: as_contiguous(getattr(state, f.name), _TYPES[str(f.type)]) for f in fields(state)
    }
    return State(**arrays, of=vars(state)["_contact"])
