"""The state of a contact: a record of arrays, new at every step."""

from __future__ import annotations

from dataclasses import InitVar, dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from contiga.area.method import AreaInput, Areas
from contiga.arrays.layout import as_contiguous
from contiga.arrays.ordered import product
from contiga.contact.loads import NOWHERE, Column, Guards, Kept
from contiga.display import Displayed, Facts
from contiga.errors import InputError
from contiga.records import IN_CONTACT, ByteArray, FloatArray, IntArray
from contiga.rigid.frames import to_world, turn_to_world

_TOUCHES = np.zeros(256, dtype=bool)
"""Which statuses, whatever number of a byte, are of points in contact."""
_TOUCHES[list(IN_CONTACT)] = True


class ContactEnergy(NamedTuple):
    """Energies of a contact since its start. Only `stored` is a state; the others add up."""

    work: float
    """Done on the contact by what moves its two sides, by the trapezoidal rule over each step, just
    the work by which a central difference or Verlet integrator moves bodies; what was stored at the
    start counts as done."""
    stored: float
    """What the law and sticking friction would give back."""
    hysteresis: float
    """Lost as the law unloads by another curve than it loads."""
    damping: float
    """Taken by the law's damping."""
    friction: float
    """Taken by sliding."""

    @property
    def error(self) -> float:
        """Error of the energy balance.

        It is that of integrating over steps, which falls with their square, and what forces that
        are no gradient make or lose.
        """
        return self.work - self.stored - self.hysteresis - self.damping - self.friction


class HeldInWorld(NamedTuple):
    """The points in contact and the normals at their feet, world axes."""

    points: Column
    normals: Column


class Owner(Protocol):
    """The questions that a state asks of its contact."""

    @property
    def weights(self) -> str:
        """The weights of the force: areas at "rest", or the contact "area" as it is measured."""

    def area_input(self, state: State) -> AreaInput:
        """The nodes in contact, as area methods see them."""

    def areas(self, state: State) -> Areas:
        """Nodal contact areas, one row a node in contact."""

    def pressure(self, state: State) -> FloatArray:
        """Return (n,) that of the law at each node, zero without contact."""

    def slid(self, state: State) -> FloatArray:
        """Return what each point has slid, body axes (m, 3)."""

    def kinks(self, state: State) -> IntArray:
        """Return (k,) points that another piece of the master pushes than before."""


@dataclass(frozen=True, eq=False, repr=False)
class State(Displayed):
    """The state of contact of n slave nodes after a step; world axes unless stated otherwise.

    A contact with quadrature points has m rows where (m,) is said: the nodes come first, and after
    them the points of each facet. Without, m = n. The arrays take 179 bytes a point, and
    eight for each number that the laws remember; of those that say nothing without contact only
    the rows in contact are kept, and the array is made when it is asked for. What laws were handed
    in the step is kept as well, for its derivatives: 50 bytes a point in contact, and 140 more with
    friction. What is not an array here is worked out when it is asked for: areas most of all.

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
    """(m, 2) parameters of the foot; of a free point those on `last_patch`."""
    last_patch: IntArray
    """(m,) patch of the foot that proved which side a free point is on, −1 where none did."""
    penetration: FloatArray
    """(m,) λ ≥ 0."""
    normal_B: FloatArray
    """(m, 3) unit normal at the foot, body axes, to the free side; zero without contact."""
    guard_B: FloatArray
    """(m, 3) of a point whose nearest wall is opposite to the one that holds it, the outward normal
    that tells so, body axes; zero of others, where it is that of the foot."""
    foot_B: FloatArray
    """(m, 3) foot, body axes; the point itself without contact."""
    points_B: FloatArray
    """(m, 3) the slave points in the body's axes."""
    pose: FloatArray
    """(4, 4) X_WB of the master."""
    normal_force: FloatArray
    """(m,) along the normal, on the points that carry; zero without contact."""
    force: FloatArray
    """(n, 3) on the slave's nodes, friction with it."""
    stiffness: FloatArray
    """(m,) of the normal force over the penetration, zero without contact."""
    stiffness_bound: FloatArray
    """(m,) `LawOutput.stiffness_bound`, zero without contact; (0,) of laws without."""
    damping: FloatArray
    """(m,) the part of `normal_force` that is due to the rate; (0,) of laws without."""
    viscosity: FloatArray
    """(m,) `damping` over the rate of penetration; (0,) of laws without."""
    memory: FloatArray
    """(m, k) what the law remembers, zero without contact."""
    friction_memory: FloatArray
    """(m, k) what friction remembers, body axes; k = 0 without."""
    traction_B: FloatArray
    """(m, 3) friction forces on the points, body axes; (0, 3) without friction."""
    tangential: FloatArray
    """(m,) stiffness of friction's springs; (0,) without friction."""
    certified: ByteArray
    """(m,) 1 where the foot of a point in contact is proved: continued without a jump, or the
    closest point."""
    safe_distance: FloatArray
    """(m,) way a free point can go before it can touch, and a point in a closed body before it
    can have left. Negative of points that lie inside since the start: they have not come in."""
    wrench: FloatArray
    """(6,) force and moment about the body's reference point, on the master: the opposite of the
    forces on the slave's points, where they are."""
    energies: FloatArray
    """(5,) `energy` as an array."""
    control_points: FloatArray = field(default_factory=lambda: NOWHERE)
    """(m, 3) of the master, body axes, in the order of `body.net`; (0, 3) where none were given: it
    keeps its shape."""
    control_force: FloatArray = field(default_factory=lambda: NOWHERE)
    """(m, 3) on the master's control points: with the forces on the slave's points their sum is
    zero, and so is that of their moments; (0, 3) where none were given."""
    of: InitVar[Owner | None] = None
    """The contact that this is a state of."""
    _maker: ClassVar[Owner | None] = None
    """The contact whose start or step has made it; None where somebody has by hand."""

    def __post_init__(self, of: Owner | None) -> None:
        self.__dict__["_contact"] = of

    if not TYPE_CHECKING:  # it would answer to any name

        def __getattr__(self, name: str) -> Any:
            """An array of which only some rows are kept, made when first asked for."""
            kept: Kept | None = self.__dict__.get("kept")
            if kept is not None and name in Kept._fields:
                whole = self.__dict__[name] = kept.whole(name, self.points_B)
                return whole
            spent = "" if self.__dict__ else " any more: it was the out of a step that failed"
            raise AttributeError(f"a State has no {name!r}{spent}", name=name, obj=self)

    @property
    def contact(self) -> Owner:
        """The contact that this is a state of.

        Raises
        ------
        InputError
            The state was made by hand, of none.
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
        """All that the next step needs, by name: `State(**arrays, of=contact)` is the state."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @cached_property
    def kept(self) -> Kept:
        """Rows of the arrays that say nothing without contact, for what goes on from the state.

        Steps make these and no whole arrays; here they are made of those.
        """
        held = np.flatnonzero(self.patch >= 0).astype(np.int32)
        rows: dict[str, Any] = {}
        for name in Kept._fields:
            whole = getattr(self, name)
            rows[name] = Column(held, whole[held]) if len(whole) == len(self.patch) else None
        if rows["force"] is None:  # of nodes, and points between them carry
            rows["force"] = Column(np.arange(len(self.force), dtype=np.int32), self.force)
        if self.friction_memory.shape[1] == 0 and len(self.traction_B) == 0:
            rows["friction_memory"] = None
        guarded = rows["guard_B"].values.any(axis=1)
        rows["guard_B"] = Guards(held[guarded], rows["guard_B"].values[guarded])
        return Kept(**rows)

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
        """Number of points in contact whose foot has converged but is not certified."""
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
        """Way (m, 3) that each point in contact has slid over the body since it came in.

        It is carried along with the foot; zero without friction that remembers it.
        """
        return turn_to_world(self.pose, self.contact.slid(self))

    @cached_property
    def kinks(self) -> IntArray:
        """Rows (k,), ascending, of points that another piece of the master pushes than before.

        Of points in contact before and after the step: their feet have passed to another patch, to
        or from an edge or a vertex, or have jumped to another wall, more than twice as far as their
        derivative says. Between the two states the derivative of their force jumps, and from wall
        to wall the force itself: Newton's method may go to and fro there. Points that come in or
        leave are told by `status`.

        Raises
        ------
        InputError
            The state was not made by a start or a step.
        """
        return self.contact.kinks(self)

    @cached_property
    def areas(self) -> Areas:
        """Contact areas and regions of the nodes in contact, measured when first asked for."""
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


def state_of(whole: dict[str, Any], kept: Kept, owner: Owner, spent: State | None = None) -> State:
    """A state of some fields by name, the others of which are made when asked for.

    The arrays are its own, and right for that contact. One that is `spent` becomes it.
    """
    state: State = object.__new__(State) if spent is None else spent
    vars(state).update(whole, _contact=owner, kept=kept, _maker=owner)
    return state


_TYPES = {"ByteArray": np.int8, "IntArray": np.int32, "FloatArray": np.float64}


def own_arrays(state: State) -> State:
    """The state with arrays as kernels take them: itself, where a contact has made it."""
    if state._maker is not None:
        return state
    arrays = {
        f.name: as_contiguous(getattr(state, f.name), _TYPES[str(f.type)]) for f in fields(state)
    }
    return State(**arrays, of=vars(state)["_contact"])
