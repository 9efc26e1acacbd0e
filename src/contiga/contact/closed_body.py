"""The step on a closed body: a point is inside or outside, whatever its foot.

In contact means inside and come in. Neither is left to the crossings that a search has seen: at
the end of every step each point's side is proved, by the cell it lies in (`Surface.sides`), by the
ball that touches the surface at its foot (`Surface.touching_ball`), by the way it can have gone
since its side was last known, or by its closest point. Crossings only tell where a point that lies
inside has come in (`judge`); they are not looked for on ways that are known to meet no surface.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact import usual
from contiga.contact.asked_records import Asked
from contiga.contact.judge import asked_of, free_distance, joined, judge, within_depth
from contiga.contact.kernels import settle_nb
from contiga.contact.loads import UNGUARDED, Guards
from contiga.contact.settle_records import AskedFeet, FootBalls, FreeRows, TouchingRows
from contiga.contact.tracked import (
    BoolArray,
    Detected,
    Options,
    Step,
    closest,
    continued,
    distances,
    follow,
    remember,
    take,
)
from contiga.contact.usual_records import limits_of
from contiga.jit import straight
from contiga.masters.protocol import Surface
from contiga.records import (
    ByteArray,
    ContactStatus,
    FloatArray,
    IndexArray,
    IntArray,
    KnownSides,
    Projection,
    SurfacePlaces,
    rows_of,
)


class SideEvidence(NamedTuple):
    """What is known of points in contact that are not outside, one row each."""

    rows: IntArray
    known: KnownSides
    now: FloatArray
    feet: Projection
    mark: ByteArray
    left: IntArray
    """Which of them are not settled."""


def detect_at_start(
    surface: Surface, p_B: FloatArray, rows: IntArray, detected: Detected, options: Options
) -> None:
    """The side of every point at the start.

    By intersection, points that lie inside are not in contact until they have been outside.
    """
    side, safe_distance = surface.sides(p_B, rows)
    detected.safe_distance[rows] = side * (safe_distance - options.band)
    if options.penetration:
        _take_inside(surface, p_B, rows[side <= 0], detected, options)
        return
    rows = rows[side == 0]
    out = closest(surface, p_B, rows)
    detected.safe_distance[rows] = free_distance(out, options)
    remember(detected, rows, out)


def _take_inside(
    surface: Surface, p_B: FloatArray, rows: IntArray, detected: Detected, options: Options
) -> None:
    """A start by penetration: points that lie inside, and no deeper than that reaches."""
    out = closest(surface, p_B, rows)
    detected.safe_distance[rows] = free_distance(out, options)
    remember(detected, rows, out)
    keep = within_depth(out, options)
    detected.status[rows[keep]] = ContactStatus.NEW
    detected.safe_distance[rows[keep]] = -out.gap[keep]
    take(detected.feet, rows, out, keep)


def detect(
    surface: Surface,
    step: Step,
    last: tuple[IntArray, FloatArray],
    rows: tuple[IntArray, IntArray],
    detected: Detected,
    options: Options,
) -> Guards:
    """Fill `detected` for the points that were in contact and the free ones that are near; returns
    those whose nearest wall is opposite to the one that pushes them.

    `last` is (patch, uv) of the feet of all points, `rows` (in contact, near).
    """
    touching, near = usual.left(surface, step, last, rows, detected, options)
    held = None
    if len(touching):
        evidence = _look_at_touching(surface, step, last, touching, detected, options)
        held = _left_of(evidence, step)
    free = _look_at_free(surface, step, near, detected, options)
    asked = joined(held, free) if held and free else held or free
    return UNGUARDED if asked is None else judge(surface, step, asked, detected, options)


def _look_at_touching(
    surface: Surface,
    step: Step,
    last: tuple[IntArray, FloatArray],
    rows: IntArray,
    detected: Detected,
    options: Options,
) -> SideEvidence:
    """Settle the points in contact whose sides and feet tell what becomes of them.

    What is outside needs no foot.
    """
    known, band = surface.sides(step.now, rows), options.band
    memory, stay = TouchingRows.of(len(rows)), straight(settle_nb.stay)
    n = stay(rows, known, step, SurfacePlaces(*last), detected, band, memory)
    rows, side, reach, patch, uv, before, now = memory.first(n)
    known, asked = KnownSides(side, reach), AskedFeet.of(n)
    ways, mark = np.empty(n, np.int32), np.empty(n, np.int8)
    if options.nearest:
        feet = follow(surface, (None, now), (patch, uv))
        face = straight(settle_nb.face)
        m = face(rows, feet, step.holds, step.way, band, mark, asked)
    else:
        feet = follow(surface, (before, now), (patch, uv))
        limits, safe = limits_of(options), detected.safe_distance
        n, m = settle_nb.look(rows, feet, side, safe, limits, mark, ways, asked)
        if n:
            clear = surface.clear_ways(step.before, step.now, rows[ways[:n]])
            mark[ways[:n][clear]] |= settle_nb.KEPT
    balls, settle = _balls(surface, feet, asked.first(m), options), straight(settle_nb.settle)
    n = settle(rows, feet, known, mark, balls, band, detected, ways)
    return SideEvidence(rows, known, now, feet, mark, ways[:n])


def _left_of(evidence: SideEvidence, step: Step) -> Asked | None:
    """Those points in contact that are not settled, if there are any."""
    left = evidence.left
    if len(left) == 0:
        return None
    rows, feet = evidence.rows[left], rows_of(evidence.feet, left)
    kept = (evidence.mark[left] & settle_nb.KEEP) > 0
    within = distances(feet, evidence.now[left])
    tracked = kept, continued(feet), step.holds.at(rows), feet
    return asked_of(rows, evidence.known.at(left), within, tracked)


def _balls(surface: Surface, feet: Projection, asked: AskedFeet, options: Options) -> FootBalls:
    """The balls that touch at the feet that are asked for."""
    index, sides = asked
    if len(index) == 0 or not options.balls:
        return FootBalls(index[:0], np.zeros(0))
    return FootBalls(index, surface.touching_ball(feet.patch, feet.uv, index, sides))


def _look_at_free(
    surface: Surface, step: Step, rows: IntArray, detected: Detected, options: Options
) -> Asked | None:
    """Settle the free points that are known to stay so; returns the others, if there are any."""
    if len(rows) == 0:
        return None
    known, within, left = _settle_free(surface, step, rows, detected, options)
    if len(left) == 0:
        return None
    return asked_of(rows[left], known.at(left), within[left])


def _settle_free(
    surface: Surface, step: Step, rows: IntArray, detected: Detected, options: Options
) -> tuple[KnownSides, FloatArray, IntArray]:
    """Settle the free points that stay so; sides of all, distances to a point of the surface, and
    which of them are not settled."""
    known, near = surface.places(step.now, rows)
    within, memory = np.full(len(rows), np.inf), FreeRows.of(len(rows))
    starts = straight(settle_nb.starts)
    n = starts(rows, known.side, near, step, detected.last_patch, options.far, memory)
    if n:
        index, patch, uv, now = memory.first(n)
        feet = follow(surface, (None, now), (patch, uv))
        remember(detected, rows[index], feet)
        tell(surface, (index, feet, now), known, within, options)
    held = _held(surface, step, rows, known.side, options)
    left, leave = np.empty(len(rows), np.int32), straight(settle_nb.leave)
    n = leave(rows, known, held, options.band, detected.safe_distance, left)
    return known, within, left[:n]


def tell(
    surface: Surface,
    followed: tuple[IndexArray, Projection, FloatArray],
    known: KnownSides,
    within: FloatArray,
    options: Options,
) -> None:
    """Fill in what feet tell: the sides that balls prove, and distances to the surface.

    `followed` is (rows, feet, points), `known` and `within` have the rows.
    """
    index, feet, points = followed
    asked = AskedFeet.of(len(index))
    m = straight(settle_nb.askable)(feet, len(index), options.band, asked)
    balls = _balls(surface, feet, asked.first(m), options)
    straight(settle_nb.tell)(index, feet, points, balls, options.band, known, within)


def _held(
    surface: Surface, step: Step, rows: IntArray, side: ByteArray, options: Options
) -> BoolArray:
    """Which points lie inside since the start and have not come in: their ways cross nothing.

    A search by penetration asks how deep they are.
    """
    held = np.zeros(len(rows), dtype=bool)
    inside = side < 0
    if options.penetration or not inside.any():
        return held
    unsure = np.flatnonzero(inside & step.ignored[rows] & np.isfinite(step.way[rows]))
    if len(unsure) == 0:
        return held
    held[unsure] = surface.clear_ways(step.before, step.now, rows[unsure])
    rest = unsure[~held[unsure]]
    _, sense = surface.last_crossings(step.before, step.now, rows[rest])
    held[rest] = sense == 0
    return held
