"""Find open faces whose free side faces away from the slave."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.arrays.ordered import product
from contiga.contact.dry_run import ON_IT, spread
from contiga.records import FloatArray, empty_projection
from contiga.rigid.frames import to_body
from contiga.simulation.checks.finding import Finding, Said
from contiga.simulation.checks.scene import MAX_POINTS, Pair
from contiga.simulation.system_state import SystemState
from contiga.statuses import Status


def behind(pair: Pair, text: str) -> Finding:
    """Return the finding that the free side of an open face is most likely the other one."""
    return Finding(
        "behind",
        pair.where,
        f"{text}: contact takes what comes in from its free side",
        "If its free side is to be the other one, turn it with flip = true in "
        f"{pair.part.master} (Python: body.flipped()); else start them on its free side",
    )


def mostly_behind(pair: Pair) -> bool:
    """Return whether most points that have a foot within an open face start behind it."""
    gaps = _gaps(pair, *pair.standing(float(pair.model.stepping.start)))
    return bool((gaps < 0.0).sum() > (gaps > 0.0).sum())


def out_from_behind(pair: Pair, said: Said) -> Iterator[Finding]:
    """Report points that start in contact behind an open face and come out through it.

    What is pressed in goes deeper first.
    """
    start, later = pair.dry_runs[0], pair.dry_runs[1:2]
    if pair.body.closed or len(start.rows) == 0 or not later or not mostly_behind(pair):
        return
    if later[0].penetration.sum() < start.penetration.sum():
        yield behind(
            pair,
            f"{len(start.rows)} points of {pair.part.slave} that are followed start behind "
            f"{pair.part.master}, an open face, up to {said(float(start.penetration.max()))} from "
            "it, and come out through it",
        )


def from_behind(pair: Pair, said: Said) -> Iterator[Finding]:
    """Report slaves most of whose points come to an open face from behind."""
    if pair.body.closed or (len(pair.dry_runs[0].inside) and mostly_behind(pair)):
        return
    met = np.concatenate([seen.rows for seen in pair.dry_runs])
    late = np.concatenate([seen.from_behind for seen in pair.dry_runs])
    came, first = np.unique(late, return_index=True)
    if not 2 * len(came) > len(np.union1d(met, came)):
        return
    counts = np.cumsum([len(seen.from_behind) for seen in pair.dry_runs])
    time = float(pair.shown_times[np.searchsorted(counts, first.min(), side="right")])
    followed = min(int(pair.slave.active.sum()), MAX_POINTS)
    yield behind(
        pair,
        f"{len(came)} of {followed} points of {pair.part.slave} that are followed come to "
        f"{pair.part.master}, an open face, from behind, at t = {said(time, 'time')} first",
    )


def ran_from_behind(pair: Pair, last: SystemState, *, met: bool) -> Iterator[Finding]:
    """Report slaves behind an open face at the start that have met or passed it in a run.

    Where the face has turned round meanwhile, they may have met in order.
    """
    if pair.foretold or pair.body.closed or not mostly_behind(pair):
        return
    first = pair.standing(float(pair.model.stepping.start))[1]
    now = last.bodies[pair.part.master].pose
    gaps = _gaps(pair, last.slaves[pair.part.slave].points, now)
    passed = (gaps > 0.0).sum() > (gaps < 0.0).sum()
    turned = np.trace(product(now[:3, :3], first[:3, :3].T)) < 1.0  # by more than a right angle
    if not turned and (met or passed):
        yield behind(
            pair,
            f"most points of {pair.part.slave} start behind {pair.part.master}, an open face, and "
            + ("meet it" if met else "have passed it without contact at the end"),
        )


def _gaps(pair: Pair, points: FloatArray, X_WB: FloatArray) -> FloatArray:
    """Return gaps (k,) of active points that have feet within an open face, but for those on it."""
    rows = np.flatnonzero(pair.slave.active & np.isfinite(points).all(axis=1))
    p_B = to_body(X_WB, np.ascontiguousarray(points[spread(rows, MAX_POINTS)]))
    feet = empty_projection(len(p_B))
    pair.body.surface.closest(p_B, np.arange(len(p_B), dtype=np.int32), feet)
    within = (feet.status == Status.OK) & (np.abs(feet.gap) > ON_IT * pair.body.size)
    return feet.gap[within]
