"""Outlines of contact regions: from a state, and of all contacts of a run on disk."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from contiga.area.base import AreaInput, AreaMethod, Outlines, outlines_of
from contiga.contact.state import State
from contiga.io.out.outlines import Loops, OutlinesWriter
from contiga.masters.protocol import Master
from contiga.num.rigid import to_body, to_world
from contiga.records import FloatArray, Projection, Status


def outlines_of_state(
    state: State, X_WB: FloatArray, body: Master, area: AreaMethod, side: str, prepared: Any
) -> Outlines | None:
    """Where contact ends, world axes; None for area methods that do not say.

    Parameters
    ----------
    X_WB : (4, 4) pose of the master the state is of
    side : whose area the contact asks for, "slave" or "master"
    prepared : what `area` keeps about the slave
    """
    rows = np.flatnonzero(state.patch >= 0).astype(np.int32)
    turn = np.eye(4)
    turn[:3, :3] = X_WB[:3, :3]
    feet = Projection(
        state.patch[rows],
        state.uv[rows],
        to_body(X_WB, state.foot[rows]),
        to_body(turn, state.normal[rows]),
        -state.penetration[rows],
        state.feature[rows],
        np.full(len(rows), Status.OK, np.int8),
        np.zeros(len(rows), np.int8),
    )
    inp = AreaInput(body, rows, state.points_B, feet, None, side, prepared)
    found = outlines_of(area, inp)
    return None if found is None else found._replace(points=to_world(X_WB, found.points))


class OutlinesFile:
    """Writes the outlines of all contacts of a run, step by step.

    Parameters
    ----------
    path : of the file
    written : steps already in it, which are kept; None starts a new file
    """

    def __init__(self, path: Path, written: int | None) -> None:
        self._writer = (
            OutlinesWriter(path) if written is None else OutlinesWriter.reopen(path, written)
        )

    def append(self, time: float, found: list[Outlines | None]) -> None:
        """Write one step: the outlines of each contact, None of those that have none."""
        points, counts = [np.zeros((0, 3))], [np.zeros(0, np.int64)]
        clusters, contacts = [np.zeros(0, np.int32)], [np.zeros(0, np.int32)]
        for k, lines in enumerate(found):
            if lines is not None:
                points.append(lines.points)
                counts.append(np.diff(lines.first))
                clusters.append(lines.clusters)
                contacts.append(np.full(len(lines.clusters), k, np.int32))
        first = np.concatenate(([0], np.cumsum(np.concatenate(counts)))).astype(np.int64)
        loops = Loops(
            np.concatenate(points), first, np.concatenate(clusters), np.concatenate(contacts)
        )
        self._writer.append(time, loops)
