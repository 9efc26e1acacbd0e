"""Find slaves that start inside a body, and slaves that never come near it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.simulation.checks.approach import closest_approach
from contiga.simulation.checks.finding import Finding, Quantities
from contiga.simulation.checks.scene import Pair, Scene
from contiga.simulation.checks.turned import (
    behind_finding,
    comes_from_behind,
    comes_out_from_behind,
    starts_behind,
)

# Share of the body's size that counts as touching.
_TOUCH_TOL = 1e-6


def check_motion(scene: Scene) -> Iterator[Finding]:
    """Report slaves that start inside, come from behind an open face, or never come near.

    The last needs a known motion, and no other contact that may turn free parts aside first.
    """
    for pair in scene.pairs:
        yield from _starts_inside(pair, scene.fmt)
        yield from comes_from_behind(pair, scene.fmt)
        # Another contact may deflect the free parts first.
        turned_aside = pair.free and any(
            other is not pair and other.free and other.foretold and other.touches
            for other in scene.pairs
        )
        if pair.foretold and not pair.touches and not turned_aside:
            yield from _never_meets(pair, scene.fmt)


def _normals_point_inward(pair: Pair) -> bool:
    """Return whether the normals of a closed body point inward.

    A point clearly outside its box then counts as inside.
    """
    if not pair.body.closed:
        return False
    low, high = pair.body.bounds()
    outside = high + (1.0 + 0.1 * np.arange(1, 4)) * (high - low).max()
    return bool(pair.body.contains(outside[None, :])[0])


def _starts_inside(pair: Pair, fmt: Quantities) -> Iterator[Finding]:
    """Report points that start inside or behind the body, by the likeliest cause.

    The cause is normals that point inward, then a free side on the wrong side, else the placement.
    Points in contact at the start are reported only for the first two.
    """
    start = pair.dry_runs[0]
    rows = start.inside
    if len(rows) == 0:
        # A search by penetration has taken points inside into contact.
        if len(start.rows) and _normals_point_inward(pair):
            yield _inward_finding(pair, len(start.rows))
        yield from comes_out_from_behind(pair, fmt)
        return
    slave, body = pair.part.slave, pair.part.master
    active = max(int(pair.slave.active.sum()), len(rows))
    deepest = start.deepest
    number = f"{len(rows)} of {active} points of {slave}"
    if _normals_point_inward(pair):
        yield _inward_finding(pair, len(rows))
        return
    if starts_behind(pair):
        yield behind_finding(
            pair, f"{number} start behind {body}, an open face, up to {fmt(deepest)} from it"
        )
        return
    relation = "inside" if pair.contact.half_thickness is None else "within half their thickness of"
    yield Finding(
        "inside",
        pair.where,
        f"{number} start {relation} {body}, up to {fmt(deepest)} deep, and make no force: search "
        "by intersection takes what comes in from the free side",
        f"Start {fmt(deepest)} further away, or take them from the start with search = "
        '"penetration"',
    )


def _inward_finding(pair: Pair, count: int) -> Finding:
    return Finding(
        "inward",
        f"body {pair.part.master}",
        f"its normals point inward, so that all around it counts as inside: {count} points of "
        f"{pair.part.slave} do at the start",
        "Turn it with flip = true (Python: body.flipped()); where the slave belongs in its "
        "cavity, start it there",
    )


def _never_meets(pair: Pair, fmt: Quantities) -> Iterator[Finding]:
    """Report sides that never meet, with their smallest distance or its lower bound.

    Nothing is reported if points start inside or none is active, if the distance is at most
    `_TOUCH_TOL` of the body's size, or if `closest_approach` is None. A slave that deforms has no
    bound: its smallest distance at `shown_times` is reported, with their number.
    """
    if len(pair.dry_runs[0].inside) or not pair.slave.active.any():
        return
    closest = closest_approach(pair)
    if closest is None:
        return
    slave, body = pair.part.slave, pair.part.master
    when = f"at t = {fmt(closest.time, 'time')}"
    if closest.distance > _TOUCH_TOL * pair.body.size:
        flight = " in free flight" if pair.free else ""
        statement, distance = f"{slave} never comes closer to {body} than", closest.bound
        if distance == 0.0:
            statement = (
                f"{slave}, looked at {len(pair.shown_times)} times, is no closer to {body} than"
            )
            distance = closest.distance
        size = min(pair.body.size, pair.slave_size or np.inf)
        wide = ""
        if distance > size:
            wide = f", {distance / size:.3g} times the size of the smaller of them"
        hint, facets = "", pair.slave.facets
        if facets is not None and len(facets) and pair.contact.quadrature == "nodes":
            corners = pair.slave.points[facets[:, :2]]
            edges = np.sqrt(np.square(corners[:, 1] - corners[:, 0]).sum(axis=1))
            if np.median(edges) > closest.distance:  # the body may go in between nodes
                hint = (
                    "; facets are larger than that: quadrature = 6 puts points of contact on them"
                )
        yield Finding(
            "apart",
            pair.where,
            f"{statement} {fmt(distance)}{flight}, {when}{wide}",
            "Look at where they are placed, at their units and at the direction of their motion"
            + hint,
        )
