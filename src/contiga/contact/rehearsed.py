"""A motion gone through by the search alone: who comes in, how deep, who is inside at the start."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from contiga.contact.curved import detect_on_curves
from contiga.contact.detect import detect_at_start
from contiga.contact.tracked import BoolArray, Last, Options, closest
from contiga.masters.protocol import Surface
from contiga.num.rigid import to_body
from contiga.records import FloatArray, IntArray, rows_of
from contiga.statuses import Status

# Share of the body's size below which a point lies on the surface, as people build models.
ON_IT = 1e-6


class Rehearsed(NamedTuple):
    """What the search finds where the points of contact and the master stand."""

    points_B: FloatArray
    """(m, 3) points of contact, body axes."""
    pose: FloatArray
    """(4, 4) X_WB of the master."""
    rows: IntArray
    """(k,) points in contact."""
    penetration: FloatArray
    """(k,) of them."""
    normal_B: FloatArray
    """(k, 3) master's normals there, body axes."""
    inside: IntArray
    """(j,) points that lie on the contact side and are not taken, as they never came in; told of
    the start only."""
    depth: FloatArray
    """(j,) how deep they lie."""


def _thinned(active: BoolArray, most: int | None) -> BoolArray:
    """At most `most` of the active points, spread evenly over them."""
    rows = np.flatnonzero(active)
    if most is None or len(rows) <= most:
        return active
    kept = np.zeros_like(active)
    kept[rows[np.linspace(0, len(rows) - 1, most).astype(np.intp)]] = True
    return kept


def rehearsed(
    surface: Surface,
    standing: Iterable[tuple[FloatArray, FloatArray]],
    taking_part: tuple[BoolArray, int | None],
    options: Options,
) -> Iterator[Rehearsed]:
    """The search from one of `standing`, points (m, 3) and pose, to the next; the first the start.

    `taking_part` are the active points, and how many of them are followed at most. Inside an open
    body are points behind the inner of a face, no deeper than contact reaches.
    """
    active, most = taking_part
    options = options._replace(balls=False)
    last, pose = None, np.eye(4)
    for p_W, X_WB in standing:
        p_B = to_body(X_WB, p_W)
        inside, depth = np.zeros(0, np.int32), np.zeros(0)
        if last is None:
            found = detect_at_start(surface, p_B, active, options)
            if not options.penetration:
                inside, depth = _inside(surface, p_B, active, options)
            active = _thinned(active, most)
        else:
            found = detect_on_curves(surface, p_B, last, active, options, (pose, X_WB))
        rows = np.flatnonzero(found.feet.patch >= 0).astype(np.int32)
        feet = rows_of(found.feet, rows)
        yield Rehearsed(p_B, X_WB, rows, np.maximum(-feet.gap, 0.0), feet.normal, inside, depth)
        last = Last(p_B, found.feet.patch, found.uv, found.near, found.safe_distance)
        pose = X_WB


def _inside(
    surface: Surface, p_B: FloatArray, active: BoolArray, options: Options
) -> tuple[IntArray, FloatArray]:
    """Points on the contact side, and how deep."""
    rows = np.flatnonzero(active & np.isfinite(p_B).all(axis=1)).astype(np.int32)
    if options.closed:
        side, _ = surface.sides(p_B, rows)
        rows = rows[side <= 0]
    feet = closest(surface, p_B, rows)
    behind = (feet.gap < -ON_IT * options.size) & (feet.status == Status.OK)
    if not options.closed:
        behind &= feet.gap > -options.depth
    return rows[behind], -feet.gap[behind]
