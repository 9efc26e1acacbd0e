"""The step on an open body: it has sides, but no inside."""

from __future__ import annotations

import numpy as np

from contiga.contact.tracked import (
    Detected,
    Options,
    Step,
    Tracked,
    continued,
    detect_inside,
    take,
    track,
)
from contiga.contact.walls import give_way
from contiga.masters.protocol import Surface
from contiga.records import ContactStatus, IntArray
from contiga.statuses import Status


def detect(
    surface: Surface,
    step: Step,
    rows: tuple[IntArray, IntArray],
    tracked: Tracked,
    detected: Detected,
    options: Options,
) -> None:
    """Fill `detected` for the points that were in contact and the free ones that are near.

    `rows` is (in contact, near), `tracked` the feet of the first.
    """
    touching, near = rows
    keep = tracked.keep
    slid_off = tracked.at_border & (not options.hold)
    gone = np.where(slid_off, ContactStatus.SLID_OFF, ContactStatus.RELEASED)
    status = np.where(keep, continued(tracked.feet), gone)
    detected.status[touching] = np.where(tracked.solved, status, ContactStatus.LOST)
    detected.safe_distance[touching] = 0.0
    take(detected.feet, touching, tracked.feet, keep)
    if options.penetration:
        detect_inside(surface, step.now, near, detected, options)
        return
    # A point that left one sheet may have come through another one since.
    left = touching[detected.status[touching] == ContactStatus.RELEASED]
    _sweep(surface, step, np.concatenate((left, near)), detected, options)
    rest = near[detected.feet.patch[near] < 0]
    surface.safe_distance(step.now, rest, detected.safe_distance)


def _sweep(
    surface: Surface, step: Step, rows: IntArray, detected: Detected, options: Options
) -> None:
    """New contacts (type a): points whose last crossing is an entry, feet started there."""
    hits, sense = surface.last_crossings(step.before, step.now, rows)
    given_up = hits.status == Status.BUDGET
    detected.status[rows[given_up]] = ContactStatus.LOST
    entered = np.flatnonzero(sense > 0)
    if len(entered) == 0:
        return
    rows = rows[entered]
    way = hits.point[entered], step.now[rows]
    tracked = track(surface, way, (hits.patch[entered], hits.uv[entered]), options)
    give_way(surface, tracked, way, np.zeros(len(rows)), options)
    keep = tracked.keep
    new = np.where(tracked.at_border, ContactStatus.HELD, ContactStatus.NEW)
    detected.status[rows[keep]] = new[keep]
    detected.status[rows[~tracked.solved]] = ContactStatus.LOST
    take(detected.feet, rows, tracked.feet, keep)
