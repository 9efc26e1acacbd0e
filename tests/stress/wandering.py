"""Points that wander through solids, and whether their depths are those of the rule."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from tests.stress import shaking, truth
from tests.stress.fields import norm
from tests.stress.rule import Held, every, follow, look, start, straight
from tests.stress.subjects import Subject
from tests.stress.tally import Clock, Tally

import contiga as cg

SAME = 1e-9
"""Depths closer than this, relative to the size, are the same."""


CLOSER = 1024
"""Looks at a path that is followed once more, where fewer say something else than contiga."""


FINER = 8
"""How much finer a path is followed to see whether what it comes to hangs on the steps."""


def walk(
    item: Subject, n: int, scale: float, rng: np.random.Generator
) -> Callable[..., np.ndarray]:
    """Steps of about `scale` sizes near a solid; who gets far goes back to where it began."""
    solid = item.solid
    home = shaking.cloud(solid, n, scale, rng)
    low, high = solid.body.bounds()
    home[: n // 4] = rng.uniform(low, high, (n // 4, 3))

    def next_place(p: np.ndarray | None = None) -> np.ndarray:
        if p is None:
            return home
        p = p + scale * solid.size * rng.normal(scale=0.4, size=p.shape)
        lost = truth.values(solid, p) > scale * solid.size
        return np.where(lost[:, None], home, p)

    return next_place


class Judge(NamedTuple):
    """Compares the depths of steps with those of the rule."""

    item: Subject
    crossings: bool
    """Whether the search is by intersection."""
    tally: Tally

    def step(self, states: tuple[cg.State, cg.State], places: np.ndarray, held: Held) -> Held:
        """What to go on with, after a step on the paths `places` (k, n, 3)."""
        (solid, rule), tally, (last, state), p = self.item, self.tally, states, places[-1]
        seen = look(rule, places)
        fine, coarse, once = (
            follow(rule, every(rule, seen, finer), held, crossings=self.crossings)
            for finer in (1, FINER, len(places) - 1)
        )
        within, inside = SAME * solid.size, seen.inside
        known = ~np.isnan(fine.depth)
        # Beside the surface, and where it hangs on short steps what the rule says.
        doubtful = known & ~(np.abs(fine.depth - coarse.depth) <= within)
        doubtful |= np.abs(truth.values(solid, p)) <= truth.BAND * solid.size
        if not self.crossings:
            doubtful |= held.guard.any(axis=1) & inside[-1] & ~inside.all(axis=0)
        # Between two looks a path may leave and come in again.
        apart = norm(p - places[0]) / (len(places) - 1)
        began = ~held.guard.any(axis=1) & inside.all(axis=0)
        doubtful |= began & (seen.distance.min(axis=0) <= apart)
        wrong = known & ~doubtful & ~(np.abs(state.penetration - fine.depth) <= within)
        closer = wrong.copy()
        if wrong.any():
            rows = np.flatnonzero(wrong)
            wrong[rows] = ~self._in_small_steps(places, held, rows, state, within)
        if solid.shape is not None:
            wrong[wrong] = ~truth.at_a_joint(solid, state.foot_B[wrong])
        flagged = np.isin(state.status, shaking.FLAGS)
        own = np.where(state.guard_B.any(axis=1)[:, None], state.guard_B, state.normal_B)
        change = np.abs(state.penetration - last.penetration) - norm(p - places[0])
        jumps = held.guard.any(axis=1) & inside.all(axis=0) & (change > within)
        long = wrong & (np.abs(state.penetration - once.depth) <= within)
        tally.count += len(p)
        tally.doubtful += int(doubtful.sum())
        tally.flagged += int(flagged.sum())
        tally.note("held from afar", int((~known).sum()))
        values = {
            "before": places[0], "point": p, "guard": held.guard, "was": last.penetration,
            "expected": fine.depth, "penetration": state.penetration, "status": state.status,
            "own": own,
        }  # fmt: skip
        kinds = {
            "a long step is not many short ones": long,
            "depth not that of the rule": wrong & ~long,
            "depth jumps": jumps & ~wrong & ~flagged,
        }
        for kind, rows in kinds.items():
            tally.fault(kind, np.flatnonzero(rows), **values)
        anew = (~known | doubtful | closer | flagged)[:, None]
        depth = np.where(anew[:, 0], state.penetration, fine.depth)
        return Held(depth, np.where(anew, own, fine.guard))

    def _in_small_steps(
        self,
        places: np.ndarray,
        held: Held,
        rows: np.ndarray,
        state: cg.State,
        within: float,
    ) -> np.ndarray:
        """Which of some rows, on straight paths, are right by looks that are much closer."""
        seen = look(self.item.rule, straight(places[0, rows], places[-1, rows], CLOSER))
        own = Held(held.depth[rows], held.guard[rows])
        depth = follow(self.item.rule, seen, own, crossings=self.crossings).depth
        right = np.abs(state.penetration[rows] - depth) <= within
        self.tally.note("followed in small steps", int(right.sum()))
        return np.asarray(right)


def wander(item: Subject, scale: float, n: int, steps: int, seed: Sequence[int]) -> Tally:
    """One cloud of points about one body, in steps of about `scale` sizes."""
    solid, rule = item
    rng = np.random.default_rng(seed)
    with Clock(Tally(f"rule, {solid.name}")) as tally:
        next_place = walk(item, n, scale, rng)
        p, X_WB = next_place(), shaking.pose(solid, 1.0, rng)
        search = "penetration" if seed[-1] % 4 == 3 else "intersection"
        slave = cg.Slave(p, area=np.ones(n))
        contact = cg.Contact(solid.body, slave, law=cg.PenaltyLaw(1.0), search=search)
        state = contact.start(cg.motion.pose.apply(X_WB, p), X_WB)
        judge = Judge(item, search == "intersection", tally)
        held = Held(np.zeros(n), np.zeros((n, 3))) if judge.crossings else start(rule, p)
        for _ in range(steps):
            before, last, p = p, state, next_place(p)
            state = contact.step(last, cg.motion.pose.apply(X_WB, p), X_WB)
            held = judge.step((last, state), straight(before, p, 64), held)
    return tally


def wandered(item: Subject, scales: np.ndarray, n: int, steps: int, seed: int) -> Tally:
    """One body at all scales."""
    whole = Tally(f"rule, {item.solid.name}")
    for k, scale in enumerate(scales):
        whole.add(wander(item, float(scale), n, steps, (seed, k)))
    return whole
