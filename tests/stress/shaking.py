"""Closed bodies shaken through clouds of points.

After each step a point is in contact exactly where it is inside and came in: all that start outside
have, once they are inside. A point that starts inside, searched by intersection, does not count
before it has been outside.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from tests.stress import truth
from tests.stress.fields import norm
from tests.stress.solids import Solid
from tests.stress.tally import Clock, Tally

import contiga as cg
from contiga.records import IN_CONTACT
from contiga.rigid.screw import screw_between

MOST_TURN = np.deg2rad(15.0)
"""About the mean pose: a step turns by up to twice that."""
FLAGS = tuple(
    int(value)
    for value in cg.ContactStatus
    if value.name not in ("FREE", "NEW", "OLD", "RELEASED", "SLID_OFF", "HELD")
)
"""Statuses that say that something was not solved, or had to be mended."""
PARTS = 64
"""Chords that the path of a point against a turning body is cut into."""
SHARES = np.linspace(0.0, 1.0, 9)
"""Shares of a step at which it is asked whether it passes a joint."""


def cloud(solid: Solid, n: int, scale: float, rng: np.random.Generator) -> np.ndarray:
    """n points within about `scale` sizes of the surface, half of them about its edges."""
    places = [truth.on_surface(solid, n, rng), truth.on_edges(solid, n // 2, rng)]
    p = np.concatenate([places[0][: n - n // 2], places[1]])
    p = np.concatenate([p, p[: n - len(p)]])
    return p + scale * solid.size * rng.normal(scale=0.5, size=p.shape)


def pose(solid: Solid, scale: float, rng: np.random.Generator) -> np.ndarray:
    """A pose moved by about `scale` sizes and turned as far as that moves, up to 15°."""
    axis = rng.normal(size=3)
    angle = min(scale, MOST_TURN) * rng.uniform(-1.0, 1.0)
    middle = solid.body.bounds().mean(axis=0)
    turn = cg.motion.pose.rotation(axis, angle, middle)
    shift = scale * solid.size * rng.uniform(-0.5, 0.5, 3)
    return cg.motion.pose.compose(cg.motion.pose.translation(shift), turn)


def in_body(X_WB: np.ndarray, p_W: np.ndarray) -> np.ndarray:
    """Points in the body's frame."""
    return (p_W - X_WB[:3, 3]) @ X_WB[:3, :3]


def paths(
    poses: tuple[np.ndarray, np.ndarray], ends: tuple[np.ndarray, np.ndarray]
) -> list[np.ndarray]:
    """Where points that go straight between their `ends` (n, 3) are in a body's frame: (n, 3) each.

    The body goes from one of its poses to the other on a screw.
    """
    way = screw_between(*poses)
    return [
        in_body(cg.motion.pose.compose(poses[0], way.pose(s)), (1.0 - s) * ends[0] + s * ends[1])
        for s in np.linspace(0.0, 1.0, PARTS + 1)
    ]


class Judge:
    """Follows a cloud: who is inside, and who has been outside."""

    def __init__(
        self, solid: Solid, p_W: np.ndarray, X_WB: np.ndarray, by_penetration: bool, tally: Tally
    ) -> None:
        self.solid, self.tally = solid, tally
        self.world, self.pose = p_W, X_WB
        self.before = p_B = in_body(X_WB, p_W)
        self.sign = truth.signs(solid, p_B)
        self.came_in = np.full(len(p_B), by_penetration) | (self.sign >= 0)

    def step(self, p_W: np.ndarray, X_WB: np.ndarray, state: cg.State) -> None:
        """Judge one state."""
        solid, tally, p_B = self.solid, self.tally, in_body(X_WB, p_W)
        sign = truth.signs(solid, p_B)
        touching = np.isin(state.status, IN_CONTACT)
        odd = np.flatnonzero(((sign < 0) & self.came_in) != touching)
        sign = truth.settled(solid, p_B, sign, odd)
        known = self._history(p_W, X_WB, sign, touching)
        # On which side of a joint a point is or was is not known, nor if it came in from there.
        odd = odd[touching[odd] & ~self.came_in[odd]]
        way = p_B[odd] - self.before[odd]
        passed = [truth.at_a_joint(solid, self.before[odd] + k * way) for k in SHARES]
        odd = odd[(sign[odd] == 0) | np.any(passed, axis=0)]
        known[odd], self.came_in[odd] = False, True
        expected = (sign < 0) & self.came_in
        differs = known & (sign != 0) & (touching != expected)
        flagged = np.isin(state.status, FLAGS)
        tally.count += len(p_B)
        tally.flagged += int(flagged.sum())
        tally.doubtful += int((sign == 0).sum() + (~known).sum())
        values = {
            "before": self.before, "point": p_B, "status": state.status,
            "penetration": state.penetration,
        }  # fmt: skip
        lost, kept = differs & expected & ~flagged, differs & ~expected
        tally.fault("inside without contact", np.flatnonzero(lost), **values)
        tally.fault("contact without being inside", np.flatnonzero(kept), **values)
        self._feet(p_B, X_WB, state, touching & (sign < 0), values)
        self.before, self.world, self.pose = p_B, p_W, X_WB

    def _history(
        self, p_W: np.ndarray, X_WB: np.ndarray, sign: np.ndarray, touching: np.ndarray
    ) -> np.ndarray:
        """Note who has been outside; False for those whose last step may or may not have been."""
        self.came_in |= sign > 0
        asked = np.flatnonzero(~self.came_in)
        known = np.ones(len(p_W), bool)
        if len(asked):
            places = paths((self.pose, X_WB), (self.world[asked], p_W[asked]))
            leaves = [truth.may_leave(self.solid, a, b) for a, b in pairwise(places)]
            unsure = asked[np.any(leaves, axis=0)]
            known[unsure] = False
            self.came_in[unsure] |= touching[unsure]
        return known

    def _feet(
        self,
        p_B: np.ndarray,
        X_WB: np.ndarray,
        state: cg.State,
        rows: np.ndarray,
        values: dict[str, np.ndarray],
    ) -> None:
        """Feet lie on the surface, as far from their points as is said and no nearer than it."""
        field, size = self.solid.field, self.solid.size
        foot_B = in_body(X_WB, state.foot)
        off = np.abs(norm(foot_B - p_B) - state.penetration)
        bad = rows & ~(off <= 1e-9 * size)
        if field is not None:
            bad |= rows & ~(np.abs(field(foot_B)) <= truth.BAND * size)
            bad |= rows & (state.penetration < -field(p_B) - truth.BAND * size)
            bad[bad] = ~truth.at_a_joint(self.solid, foot_B[bad])
        self.tally.fault("foot not on the surface", np.flatnonzero(bad), foot=foot_B, **values)


def shake(
    solid: Solid, n: int, steps: int, scale: float, rng: np.random.Generator, search: str
) -> Tally:
    """One body through one cloud in steps of about `scale` sizes."""
    with Clock(Tally(f"shaking, {solid.name}")) as tally:
        p = cloud(solid, n, scale, rng)
        X = pose(solid, scale, rng)
        p = p[truth.signs(solid, in_body(X, p)) != 0]
        slave = cg.Slave(p, area=np.ones(len(p)))
        contact = cg.Contact(solid.body, slave, law=cg.PenaltyLaw(1.0), search=search)
        state = contact.start(p, X)
        judge = Judge(solid, p, X, search == "penetration", tally)
        for _ in range(steps):
            X = pose(solid, scale, rng)
            now = p + scale * solid.size * rng.normal(scale=0.2, size=p.shape)
            state = contact.step(state, now, X)
            judge.step(now, X, state)
    return tally


def shaken(solid: Solid, scales: np.ndarray, n: int, steps: int, seed: int) -> Tally:
    """One body at all scales, both searches in turn."""
    whole = Tally(f"shaking, {solid.name}")
    for k, scale in enumerate(scales):
        rng = np.random.default_rng([seed, k])
        search = "penetration" if k % 4 == 3 else "intersection"
        whole.add(shake(solid, n, steps, float(scale), rng, search))
    return whole
