"""The state of a contact: a record of arrays, new at every step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contiga.num.ordered import product
from contiga.records import IN_CONTACT, ByteArray, FloatArray, IntArray
from contiga.shown import Facts, Shown


@dataclass(frozen=True, eq=False, repr=False)
class State(Shown):
    """Where n slave points stand after a step, in world axes where not said otherwise.

    The arrays take 159 bytes a point, and eight for each number that the law remembers.

    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    >>> pad = cg.Slave([[0.0, 0.0, 1.1], [3.0, 0.0, 1.1]], area=[0.5, 0.5])
    >>> contact = cg.Contact(ball, pad, law=cg.PenaltyLaw(100.0))
    >>> state = contact.step(contact.start(pad.points), pad.points - [0.0, 0.0, 0.2], dt=1.0)
    >>> [cg.ContactStatus(s).name for s in state.status], state.penetration.round(12).tolist()
    (['NEW', 'FREE'], [0.1, 0.0])
    >>> round(float(state.stored), 12)
    0.5
    """

    status: ByteArray
    """(n,) `ContactStatus`."""
    feature: ByteArray
    """(n,) `Feature` of the foot, −1 without contact."""
    patch: IntArray
    """(n,) patch of the foot, −1 without contact."""
    uv: FloatArray
    """(n, 2) parameters of the foot; of a free point those on the patch `near`."""
    near: IntArray
    """(n,) patch of the foot that proved which side a free point is on, −1 where none did."""
    penetration: FloatArray
    """(n,) λ ≥ 0."""
    normal: FloatArray
    """(n, 3) unit normal at the foot, to the free side; zero without contact."""
    foot: FloatArray
    """(n, 3) foot; the point itself without contact."""
    area: FloatArray
    """(n,) nodal contact area, zero without contact."""
    force: FloatArray
    """(n, 3) on the slave points."""
    stiffness: FloatArray
    """(n,) of the contact force over the penetration, zero without contact."""
    stored: FloatArray
    """() elastic energy in the contact."""
    memory: FloatArray
    """(n, m) what the law remembers, zero without contact."""
    clusters: IntArray
    """(n,) connected region of contact, −1 without contact."""
    points_B: FloatArray
    """(n, 3) the slave points in the body's axes."""
    pose: FloatArray
    """(4, 4) X_WB of the master."""
    certified: ByteArray
    """(n,) 1 where the foot of a point in contact is proved: continued without a jump, or the
    closest point."""
    safe_distance: FloatArray
    """(n,) way a free point can go before it can touch, and a point in a closed body before it
    can have left. Negative of points that lie inside since the start: they have not come in."""
    wrench: FloatArray
    """(6,) force and moment about the body's reference point, on the master."""

    def _facts(self) -> Facts:
        return [
            ("points", len(self.status)),
            ("in contact", self.n_contact),
            ("deepest", self.max_penetration),
            ("force", tuple(map(float, self.total_force))),
            ("area", self.total_area),
            ("not proved", self.n_unproved),
        ]

    @property
    def in_contact(self) -> NDArray[np.bool_]:
        """(n,) which points carry contact."""
        return np.isin(self.status, IN_CONTACT)

    @property
    def n_contact(self) -> int:
        """Number of points in contact."""
        return int(self.in_contact.sum())

    @property
    def n_unproved(self) -> int:
        """Number of points in contact whose foot is merely converged."""
        return int((self.in_contact & (self.certified == 0)).sum())

    @property
    def max_penetration(self) -> float:
        """Largest penetration, zero without contact."""
        return float(self.penetration.max(initial=0.0))

    @property
    def total_force(self) -> FloatArray:
        """(3,) on the slave: the sum of `force`. The master feels the opposite."""
        total: FloatArray = self.force.sum(axis=0)
        return total

    @property
    def total_area(self) -> float:
        """Contact area."""
        return float(self.area.sum())

    @property
    def n_clusters(self) -> int:
        """Number of connected regions of contact."""
        return int(self.clusters.max(initial=-1)) + 1

    @property
    def mean_pressure(self) -> float:
        """Sum of the nodal forces' magnitudes over the contact area, zero without contact."""
        area = self.total_area
        return float(np.linalg.norm(self.force, axis=1).sum()) / area if area > 0.0 else 0.0

    @property
    def max_pressure(self) -> float:
        """Largest nodal pressure, zero without contact."""
        return float(self.pressure.max(initial=0.0))

    @property
    def centre_of_pressure(self) -> FloatArray:
        """(3,) mean of the feet, weighted by the nodal forces' magnitudes; NaN without force."""
        size = np.linalg.norm(self.force, axis=1)
        total = size.sum()
        if not total > 0.0:
            return np.full(3, np.nan)
        return product(size, self.foot) / total

    @property
    def pressure(self) -> FloatArray:
        """(n,) `|force|` over area, zero where there is none."""
        size = np.linalg.norm(self.force, axis=1)
        result = np.zeros_like(size)
        np.divide(size, self.area, out=result, where=self.area > 0.0)
        return result
