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

# Largest number of facets to examine, the first that the body comes near to, and parts of a side.
_FACETS = 200
_PARTS = 6
# Times at which the reach of the body through a facet is measured.
_MAX_LOOKS = 5
# Allowed reach of a body through a facet before a point is touched, as a share of its longest side:
# the reach of a ball as large as the gaps between nodes of squares, and of the corner of a cube
# between three points per facet.
_REACH_TOL = 0.5
_COVER_RADIUS = {"nodes": 0.71, 1: 0.53, 3: 0.37, 6: 0.27, 12: 0.23}
"""Radius of the largest circle without points of contact on a plane of halved squares, over the
side of the squares."""


class _MissedFacet(NamedTuple):
    """A body that reaches through a facet before a point of contact around it is touched."""

    reach: float
    """Reach along the normal of the facet, length."""
    time: float
    """Time of the first reach."""
    side: float
    """Longest side of the facet."""
    deepest: float
    """Largest depth of a point of the facet: half of the width of the body there."""


def check_coarse(scene: Scene) -> Iterator[Finding]:
    """Report bodies that pass between the points of facets, for each contact the worst facet.

    A body must reach through a facet by `_REACH_TOL` of its longest side before a point of contact
    around it is touched.
    """
    for pair in scene.pairs:
        facets, first_row = _first_near_facets(pair, pair.approach)
        times = pair.approach[first_row:]
        if len(times) < 2 or len(facets) == 0:
            continue
        corners = np.asarray(pair.slave.facets)[facets]
        quadrature = pair.contact.quadrature
        own_shape = np.eye(3) if quadrature == "nodes" else RULES[int(quadrature)].shape
        steps = np.arange(_PARTS + 1)
        i, j = (each.ravel() for each in np.meshgrid(steps, steps))
        rows = np.stack([i, j, _PARTS - i - j], axis=1) / _PARTS
        shape = np.concatenate([own_shape, rows[(rows[:, 2] >= 0.0) & (rows.max(axis=1) < 1.0)]])
        inside, depth = _contact_history(pair, times, corners, shape)
        parts = np.split(inside, [len(own_shape)], axis=2)
        own_touched, first_inside = (
            # Number of the first time with a point inside; one past the last without any.
            np.where(part.any(axis=(0, 2)), part.any(axis=2).argmax(axis=0), len(times))
            for part in parts
        )
        # Number of the first time with a corner touched.
        around = np.full(len(pair.slave), len(times))
        np.minimum.at(around, corners, own_touched[:, None])
        first_touch = around[corners].min(axis=1)
        missed_facets = []
        for k in np.flatnonzero(first_inside < first_touch).tolist():
            out = np.flatnonzero(~inside[first_inside[k] : first_touch[k], k].any(axis=1))
            span = np.arange(
                first_inside[k], first_inside[k] + out[0] if len(out) else first_touch[k]
            )
            reaches = [
                _reach_through(pair, float(times[i]), shape[inside[i, k]], corners[k])
                for i in spread(span, _MAX_LOOKS).tolist()
            ]
            largest_paths = np.array([ends.max(axis=1) for ends in reaches])
            # The nearer end of the body at the first reach is the one that came through.
            first = int(np.argmax(largest_paths.min(axis=1) > 0.0))
            reach = float(largest_paths[:, np.argmin(largest_paths[first])].max())
            points = pair.slave.points[corners[k]]
            longest = float(row_lengths(points - np.roll(points, 1, axis=0)).max())
            deepest = float(depth[span, k].max())
            missed_facets.append(
                _MissedFacet(reach, float(times[first_inside[k]]), longest, deepest)
            )
        missed = max(missed_facets, key=lambda facet: facet.reach / facet.side, default=None)
        if missed is None or missed.reach <= _REACH_TOL * missed.side:
            continue
        quantity, cover_radius = scene.fmt, _COVER_RADIUS[pair.contact.quadrature]
        smaller = quantity(min(missed.deepest / cover_radius, 0.5 * missed.side))
        yield Finding(
            "coarse",
            pair.where,
            f"{pair.part.master} reaches {quantity(missed.reach)} through a facet of "
            f"{pair.part.slave} with a side of {quantity(missed.side)}, from "
            f"t = {quantity(missed.time, 'time')} on, before one of its points of contact "
            f"is touched: it is some {quantity(2.0 * missed.deepest)} wide there",
            f"Take facets of {smaller} there",
        )


def _first_near_facets(pair: Pair, times: FloatArray) -> tuple[IndexArray, int]:
    """Return the first facets that the body may touch, and the row of the time before in `times`.

    At most `_FACETS` facets, with active nodes only, are returned, in order of time; none for a
    cloud of points.
    """
    slave, surface = pair.slave, pair.body.surface
    near_facets: dict[int, None] = {}
    if slave.facets is None:
        return np.zeros(0, np.intp), 0
    active_facets = np.flatnonzero(slave.active[slave.facets].all(axis=1))
    facets = slave.facets[active_facets]
    longest = float(_facet_radii(slave.points[facets]).max(initial=0.0))
    low, high = pair.body.bounds() + 2.0 * longest * np.array([[-1.0], [1.0]])
    first_row = 0
    for k, time in enumerate(times.tolist()):
        points, X_WB = pair.placement(time)
        p_B = to_body(X_WB, points)
        # Column by column: NumPy reduces rows of three at a tenth of the speed.
        x, y, z = ((p_B >= low) & (p_B <= high)).T
        is_boxed = x & y & z
        a, b, c = facets.T
        boxed_facets = np.flatnonzero(is_boxed[a] | is_boxed[b] | is_boxed[c])
        corners = p_B[facets[boxed_facets]]
        middle, radius = np.ascontiguousarray(corners.mean(axis=1)), _facet_radii(corners)
        bounds = lower_bounds(surface, middle, np.arange(len(boxed_facets), dtype=np.int32), None)
        first_row = first_row if near_facets else max(k - 1, 0)
        near_facets |= dict.fromkeys(active_facets[boxed_facets[bounds <= radius]].tolist())
        if len(near_facets) >= _FACETS:
            break
    return np.array(list(near_facets)[:_FACETS], np.intp), first_row


def _facet_radii(corners: FloatArray) -> FloatArray:
    """Return the distances (f,) from the centres of facets (f, 3, 3) to their farthest corners."""
    off = corners - corners.mean(axis=1, keepdims=True)
    return np.asarray(row_lengths(off.reshape(-1, 3)).reshape(-1, 3).max(axis=1))


def _contact_history(
    pair: Pair, times: FloatArray, corners: IndexArray, shape: FloatArray
) -> tuple[NDArray[np.bool_], FloatArray]:
    """Return a mask of the points of facets in contact at `times`, and the depth of each facet.

    The mask is (t, f, k) by the contact's own search, the depth of the deepest point of a facet
    (t, f).
    """
    contact, n = pair.contact, len(corners) * len(shape)

    def placed(points: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("kc,fc...->fk...", shape, points[corners]).reshape(n, -1))

    placements = [pair.placement(time) for time in times.tolist()]
    half_thickness = contact.half_thickness
    contact_of_points = Contact(
        pair.body,
        Slave(placed(placements[0][0]), area=np.ones(n)),
        law=PenaltyLaw(1.0),
        search=contact.search,
        foot=contact.foot,
        shell_thickness=None
        if half_thickness is None
        else 2.0 * placed(half_thickness[: len(pair.slave)]).ravel(),
    )
    inside = np.zeros((len(times), n), np.bool_)
    depth = np.zeros((len(times), n))
    runs = contact_of_points.dry_run(
        ((placed(points), X_WB) for points, X_WB in placements), most=n
    )
    for k, result in enumerate(runs):
        inside[k, result.rows], depth[k, result.rows] = True, result.penetration
    rows = len(times), len(corners), len(shape)
    return inside.reshape(rows), depth.reshape(rows).max(axis=2)


def _reach_through(pair: Pair, time: float, shape: FloatArray, corners: IndexArray) -> FloatArray:
    """Return the reach (2, k) of the body beyond k points of a facet, along ± its normal.

    Where the body has no wall on that side it is two sizes of the body.
    """
    points, X_WB = pair.placement(time)
    facet = to_body(X_WB, points[corners])
    normal = np.cross(facet[1] - facet[0], facet[2] - facet[0])
    ray = 2.0 * pair.body.size * normal / np.sqrt(normal @ normal)
    p_B, reaches = np.ascontiguousarray(shape @ facet), []
    rows = np.arange(len(p_B), dtype=np.int32)
    for offset in (ray, -ray):
        hit, sense = pair.body.surface.last_crossings(p_B + offset, p_B, rows)
        reaches.append(length(ray) * np.where(sense != 0, 1.0 - hit.fraction, 1.0))
    return np.array(reaches)
