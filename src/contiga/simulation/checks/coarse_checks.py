"""Find facets that are too coarse: a body passes between their points of contact."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.ordered import length, row_lengths
from contiga.contact.contact import Contact
from contiga.contact.dry_run import spread
from contiga.laws.normal import PenaltyLaw
from contiga.masters.nearness import lower_bounds
from contiga.records import FloatArray, IndexArray
from contiga.rigid.frames import to_body
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Pair, Scene
from contiga.slaves.sampling import RULES
from contiga.slaves.slave import Slave

# Facets that are looked at, those that the body comes near to first, and parts of their sides.
_FACETS = 200
_PARTS = 6
# Standings at which it is looked how far the body reaches through a facet.
_LOOKS = 5
# Of the longest side of a facet: how far a body may reach through before a point is touched. A ball
# that is as large as the gaps between the nodes of squares goes no farther, a corner of a cube no
# farther between three points a facet.
_THROUGH = 0.5
_COVER = {"nodes": 0.71, 1: 0.53, 3: 0.37, 6: 0.27, 12: 0.23}
"""Radius of the largest circle without a point of contact on a plane of halved squares, as a share
of the squares' side."""


class _Missed(NamedTuple):
    """A body that reaches through a facet before a point of contact around it is touched."""

    reach: float
    """How far, along the normal of the facet."""
    time: float
    """When that begins."""
    side: float
    """The longest one of the facet."""
    deepest: float
    """How far a point of the facet lies inside: half of what is as wide as the body there."""


def check_coarse(scene: Scene) -> Iterator[Finding]:
    """Report bodies that are thinner than the facets of a slave and pass between its points."""
    for pair in scene.pairs:
        near, since = _near(pair, pair.approach)
        times = pair.approach[since:]
        if len(times) < 2 or len(near) == 0:
            continue
        corners = np.asarray(pair.slave.facets)[near]
        quadrature = pair.contact.quadrature
        own = np.eye(3) if quadrature == "nodes" else RULES[int(quadrature)].shape
        steps = np.arange(_PARTS + 1)
        i, j = (each.ravel() for each in np.meshgrid(steps, steps))
        rows = np.stack([i, j, _PARTS - i - j], axis=1) / _PARTS
        shape = np.concatenate([own, rows[(rows[:, 2] >= 0.0) & (rows.max(axis=1) < 1.0)]])
        inside, depth = _followed(pair, times, corners, shape)
        parts = np.split(inside, [len(own)], axis=2)
        own_touched, begin = (
            # The first standing at which a point is inside: one past the last where none ever is.
            np.where(part.any(axis=(0, 2)), part.any(axis=2).argmax(axis=0), len(times))
            for part in parts
        )
        # The first standing at which a point around it is touched.
        around = np.full(len(pair.slave), len(times))
        np.minimum.at(around, corners, own_touched[:, None])
        until = around[corners].min(axis=1)
        found = []
        for k in np.flatnonzero(begin < until).tolist():
            out = np.flatnonzero(~inside[begin[k] : until[k], k].any(axis=1))
            span = np.arange(begin[k], begin[k] + out[0] if len(out) else until[k])
            looks = [
                _ends(pair, float(times[i]), shape[inside[i, k]], corners[k])
                for i in spread(span, _LOOKS).tolist()
            ]
            largest_paths = np.array([ends.max(axis=1) for ends in looks])
            # Once it is in, that end of the body is the nearer one that has come through.
            first = int(np.argmax(largest_paths.min(axis=1) > 0.0))
            reach = float(largest_paths[:, np.argmin(largest_paths[first])].max())
            facet = pair.slave.points[corners[k]]
            longest = float(row_lengths(facet - np.roll(facet, 1, axis=0)).max())
            deepest = float(depth[span, k].max())
            found.append(_Missed(reach, float(times[begin[k]]), longest, deepest))
        missed = max(found, key=lambda one: one.reach / one.side, default=None)
        if missed is None or missed.reach <= _THROUGH * missed.side:
            continue
        said, now = scene.said, _COVER[pair.contact.quadrature]
        smaller = said(min(missed.deepest / now, 0.5 * missed.side))
        yield Finding(
            "coarse",
            pair.where,
            f"{pair.part.master} reaches {said(missed.reach)} through a facet of "
            f"{pair.part.slave} with a side of {said(missed.side)}, from "
            f"t = {said(missed.time, 'time')} on, before one of its points of contact "
            f"is touched: it is some {said(2.0 * missed.deepest)} wide there",
            f"Take facets of {smaller} there",
        )


def _near(pair: Pair, times: FloatArray) -> tuple[IndexArray, int]:
    """Return the first facets that the body may touch, and the row of the last time before that."""
    slave, surface = pair.slave, pair.body.surface
    near: dict[int, None] = {}
    if slave.facets is None:
        return np.zeros(0, np.intp), 0
    whole = np.flatnonzero(slave.active[slave.facets].all(axis=1))
    facets = slave.facets[whole]
    longest = float(_radii(slave.points[facets]).max(initial=0.0))
    low, high = pair.body.bounds() + 2.0 * longest * np.array([[-1.0], [1.0]])
    since = 0
    for k, time in enumerate(times.tolist()):
        points, X_WB = pair.standing(time)
        p_B = to_body(X_WB, points)
        # Column by column: NumPy reduces rows of three at a tenth of the speed.
        x, y, z = ((p_B >= low) & (p_B <= high)).T
        boxed = x & y & z
        a, b, c = facets.T
        some = np.flatnonzero(boxed[a] | boxed[b] | boxed[c])
        corners = p_B[facets[some]]
        middle, radius = np.ascontiguousarray(corners.mean(axis=1)), _radii(corners)
        bounds = lower_bounds(surface, middle, np.arange(len(some), dtype=np.int32), None)
        since = since if near else max(k - 1, 0)
        near |= dict.fromkeys(whole[some[bounds <= radius]].tolist())
        if len(near) >= _FACETS:
            break
    return np.array(list(near)[:_FACETS], np.intp), since


def _radii(corners: FloatArray) -> FloatArray:
    """Return the distances (f,) from the centres of facets (f, 3, 3) to their farthest corners."""
    off = corners - corners.mean(axis=1, keepdims=True)
    return np.asarray(row_lengths(off.reshape(-1, 3)).reshape(-1, 3).max(axis=1))


def _followed(
    pair: Pair, times: FloatArray, corners: IndexArray, shape: FloatArray
) -> tuple[NDArray[np.bool_], FloatArray]:
    """Return which points of facets are in contact at `times`, and the depth of each facet.

    Contact is (t, f, k) by the contact's own search, the depth of the deepest point of a facet
    (t, f).
    """
    contact, n = pair.contact, len(corners) * len(shape)

    def placed(points: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("kc,fc...->fk...", shape, points[corners]).reshape(n, -1))

    standing = [pair.standing(time) for time in times.tolist()]
    half = contact.half_thickness
    probe = Contact(
        pair.body,
        Slave(placed(standing[0][0]), area=np.ones(n)),
        law=PenaltyLaw(1.0),
        search=contact.search,
        foot=contact.foot,
        shell_thickness=None if half is None else 2.0 * placed(half[: len(pair.slave)]).ravel(),
    )
    inside = np.zeros((len(times), n), np.bool_)
    depth = np.zeros((len(times), n))
    runs = probe.dry_run(((placed(points), X_WB) for points, X_WB in standing), most=n)
    for k, seen in enumerate(runs):
        inside[k, seen.rows], depth[k, seen.rows] = True, seen.penetration
    rows = len(times), len(corners), len(shape)
    return inside.reshape(rows), depth.reshape(rows).max(axis=2)


def _ends(pair: Pair, time: float, shape: FloatArray, corners: IndexArray) -> FloatArray:
    """Return how far the body reaches beyond points of a facet along its normal and against it.

    The points (k, 3) are in contact; the result is (2, k).
    """
    points, X_WB = pair.standing(time)
    facet = to_body(X_WB, points[corners])
    normal = np.cross(facet[1] - facet[0], facet[2] - facet[0])
    way = 2.0 * pair.body.size * normal / np.sqrt(normal @ normal)
    p_B, ends = np.ascontiguousarray(shape @ facet), []
    rows = np.arange(len(p_B), dtype=np.int32)
    for off in (way, -way):
        hit, sense = pair.body.surface.last_crossings(p_B + off, p_B, rows)
        ends.append(length(way) * np.where(sense != 0, 1.0 - hit.fraction, 1.0))
    return np.array(ends)
