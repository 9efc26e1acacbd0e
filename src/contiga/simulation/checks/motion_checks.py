"""Find slaves that start inside, and slaves that never come near."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.simulation.checks.approach import closest_approach
from contiga.simulation.checks.finding import Finding, Said
from contiga.simulation.checks.scene import Pair, Scene
from contiga.simulation.checks.turned import behind, from_behind, mostly_behind, out_from_behind

# Share of the body's size that counts as touching.
_TOUCHING = 1e-6


def check_motion(scene: Scene) -> Iterator[Finding]:
    """Report who starts inside, and who never comes near."""
    for pair in scene.pairs:
        yield from _starts(pair, scene.said)
        yield from from_behind(pair, scene.said)
        # Whether what is free here is first turned aside by another contact.
        turned_aside = pair.free and any(
            other is not pair and other.free and other.foretold and other.touches
            for other in scene.pairs
        )
        if pair.foretold and not pair.touches and not turned_aside:
            yield from _never(pair, scene.said)


def _inward(pair: Pair) -> bool:
    """Return whether the normals of a closed body point into it: outside counts as inside then."""
    if not pair.body.closed:
        return False
    low, high = pair.body.bounds()
    outside = high + (1.0 + 0.1 * np.arange(1, 4)) * (high - low).max()
    return bool(pair.body.contains(outside[None, :])[0])


def _starts(pair: Pair, said: Said) -> Iterator[Finding]:
    """Report points that are on the contact side from the start."""
    start = pair.dry_runs[0]
    rows = start.inside
    if len(rows) == 0:
        # Search by penetration has taken what lies inside.
        if len(start.rows) and _inward(pair):
            yield _turned(pair, len(start.rows))
        yield from out_from_behind(pair, said)
        return
    slave, body = pair.part.slave, pair.part.master
    active = max(int(pair.slave.active.sum()), len(rows))
    deepest = start.deepest
    number = f"{len(rows)} of {active} points of {slave}"
    if _inward(pair):
        yield _turned(pair, len(rows))
        return
    if mostly_behind(pair):
        yield behind(
            pair, f"{number} start behind {body}, an open face, up to {said(deepest)} from it"
        )
        return
    there = "inside" if pair.contact.half_thickness is None else "within half their thickness of"
    yield Finding(
        "inside",
        pair.where,
        f"{number} start {there} {body}, up to {said(deepest)} deep, and make no force: search by "
        "intersection takes what comes in from the free side",
        f"Start {said(deepest)} further away, or take them from the start with search = "
        '"penetration"',
    )


def _turned(pair: Pair, count: int) -> Finding:
    return Finding(
        "inward",
        f"body {pair.part.master}",
        f"its normals point inward, so that all around it counts as inside: {count} points of "
        f"{pair.part.slave} do at the start",
        "Turn it with flip = true (Python: body.flipped()); where the slave belongs in its "
        "cavity, start it there",
    )


def _never(pair: Pair, said: Said) -> Iterator[Finding]:
    """Report sides that never meet, and how near they come."""
    if len(pair.dry_runs[0].inside) or not pair.slave.active.any():
        return
    closest = closest_approach(pair)
    if closest is None:
        return
    slave, body = pair.part.slave, pair.part.master
    when = f"at t = {said(closest.time, 'time')}"
    if closest.distance > _TOUCHING * pair.body.size:
        flight = " in free flight" if pair.free else ""
        near, distance = f"{slave} never comes closer to {body} than", closest.bound
        if distance == 0.0:
            near = f"{slave}, looked at {len(pair.shown_times)} times, is no closer to {body} than"
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
            f"{near} {said(distance)}{flight}, {when}{wide}",
            "Look at where they are placed, at their units and at the direction of their motion"
            + hint,
        )
