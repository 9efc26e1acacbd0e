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
    found: Detected,
    options: Options,
) -> None:
    """Fill `found` for the points that were in contact and the free ones that are near.

    `rows` is (in contact, near), `tracked` the feet of the first.
    """
    touching, near = rows
    keep = tracked.keep
    slid_off = tracked.at_border & (not options.hold)
    gone = np.where(slid_off, ContactStatus.SLID_OFF, ContactStatus.RELEASED)
    status = np.where(keep, continued(tracked.feet), gone)
    found.status[touching] = np.where(tracked.solved, status, ContactStatus.LOST)
    found.safe_distance[touching] = 0.0
    take(found.feet, touching, tracked.feet, keep)
    if options.penetration:
        detect_inside(surface, step.now, near, found, options)
        return
    # A point that left one sheet may have come through another one since.
    left = touching[found.status[touching] == ContactStatus.RELEASED]
    _sweep(surface, step, np.concatenate((left, near)), found, options)
    rest = near[found.feet.patch[near] < 0]
    surface.safe_distance(step.now, rest, found.safe_distance)


def _sweep(surface: Surface, step: Step, rows: IntArray, found: Detected, options: Options) -> None:
    """New contacts (type a): points whose last crossing is an entry, feet started there."""
    hits, sense = surface.last_crossings(step.before, step.now, rows)
    given_up = hits.status == Status.BUDGET
    found.status[rows[given_up]] = ContactStatus.LOST
    entered = np.flatnonzero(sense > 0)
    if len(entered) == 0:
        return
    rows = rows[entered]
    way = hits.point[entered], step.now[rows]
    tracked = track(surface, way, (hits.patch[entered], hits.uv[entered]), options)
    give_way(surface, tracked, way, np.zeros(len(rows)), options)
    keep = tracked.keep
    new = np.where(tracked.at_border, ContactStatus.HELD, ContactStatus.NEW)
    found.status[rows[keep]] = new[keep]
    found.status[rows[~tracked.solved]] = ContactStatus.LOST
    take(found.feet, rows, tracked.feet, keep)
