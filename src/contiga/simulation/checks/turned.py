"""Find open faces with the free side on the wrong side."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.arrays.ordered import product
from contiga.contact.dry_run import SURFACE_TOL, spread
from contiga.records import FloatArray, empty_projection
from contiga.rigid.frames import to_body
from contiga.simulation.checks.finding import Finding, Quantities
from contiga.simulation.checks.scene import MAX_POINTS, Pair
from contiga.simulation.system_state import SystemState
from contiga.statuses import Status


def behind_finding(pair: Pair, text: str) -> Finding:
    """Return the finding that an open face most likely has the wrong free side."""
    return Finding(
        "behind",
        pair.where,
        f"{text}: contact takes what comes in from its free side",
        "If its free side is to be the other one, turn it with flip = true in "
        f"{pair.part.master} (Python: body.flipped()); else start them on its free side",
    )


def starts_behind(pair: Pair) -> bool:
    """Return whether more points with a foot within an open face start behind it than before it."""
    gaps = _gaps(pair, *pair.placement(float(pair.model.stepping.start)))
    return bool((gaps < 0.0).sum() > (gaps > 0.0).sum())


def comes_out_from_behind(pair: Pair, fmt: Quantities) -> Iterator[Finding]:
    """Report points that start in contact behind an open face and come out through it.

    Points that are pressed in go deeper first.
    """
    start, later = pair.dry_runs[0], pair.dry_runs[1:2]
    if pair.body.closed or len(start.rows) == 0 or not later or not starts_behind(pair):
        return
    if later[0].penetration.sum() < start.penetration.sum():
        yield behind_finding(
            pair,
            f"{len(start.rows)} points of {pair.part.slave} that are followed start behind "
            f"{pair.part.master}, an open face, up to {fmt(float(start.penetration.max()))} from "
            "it, and come out through it",
        )


def comes_from_behind(pair: Pair, fmt: Quantities) -> Iterator[Finding]:
    """Report slaves that come to an open face from behind.

    Of the points that touch or come from behind, more than half must come from behind. A slave that
    is partly inside at the start, and mostly behind (`starts_behind`), is left to the check of the
    start.
    """
    if pair.body.closed or (len(pair.dry_runs[0].inside) and starts_behind(pair)):
        return
    touched = np.concatenate([run.rows for run in pair.dry_runs])
    rows_from_behind = np.concatenate([run.from_behind for run in pair.dry_runs])
    coming, first = np.unique(rows_from_behind, return_index=True)
    if not 2 * len(coming) > len(np.union1d(touched, coming)):
        return
    counts = np.cumsum([len(run.from_behind) for run in pair.dry_runs])
    time = float(pair.shown_times[np.searchsorted(counts, first.min(), side="right")])
    followed = min(int(pair.slave.active.sum()), MAX_POINTS)
    yield behind_finding(
        pair,
        f"{len(coming)} of {followed} points of {pair.part.slave} that are followed come to "
        f"{pair.part.master}, an open face, from behind, at t = {fmt(time, 'time')} first",
    )


def met_from_behind(pair: Pair, last: SystemState, *, met: bool) -> Iterator[Finding]:
    """Report slaves behind an open face at the start that met or passed it in the run.

    Nothing is reported if the face has turned by more than a right angle in the run: they may have
    met correctly.
    """
    if pair.foretold or pair.body.closed or not starts_behind(pair):
        return
    first = pair.placement(float(pair.model.stepping.start))[1]
    now = last.bodies[pair.part.master].pose
    gaps = _gaps(pair, last.slaves[pair.part.slave].points, now)
    passed = (gaps > 0.0).sum() > (gaps < 0.0).sum()
    turned = np.trace(product(now[:3, :3], first[:3, :3].T)) < 1.0  # by more than a right angle
    if not turned and (met or passed):
        yield behind_finding(
            pair,
            f"most points of {pair.part.slave} start behind {pair.part.master}, an open face, and "
            + ("meet it" if met else "have passed it without contact at the end"),
        )


def _gaps(pair: Pair, points: FloatArray, X_WB: FloatArray) -> FloatArray:
    """Return the gaps (k,) of points with feet within an open face, without points on it.

    At most `MAX_POINTS` active points are measured.
    """
    rows = np.flatnonzero(pair.slave.active & np.isfinite(points).all(axis=1))
    p_B = to_body(X_WB, np.ascontiguousarray(points[spread(rows, MAX_POINTS)]))
    feet = empty_projection(len(p_B))
    pair.body.surface.closest(p_B, np.arange(len(p_B), dtype=np.int32), feet)
    within = (feet.status == Status.OK) & (np.abs(feet.gap) > SURFACE_TOL * pair.body.size)
    return feet.gap[within]
