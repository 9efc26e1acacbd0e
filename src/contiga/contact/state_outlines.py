"""Outlines of the regions of contact of a state."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.area.method import AreaInput, AreaMethod, Outlines, outlines_of
from contiga.contact.state import State
from contiga.masters.protocol import Master
from contiga.num.rigid import to_body, to_world
from contiga.records import FloatArray, Projection
from contiga.statuses import Status


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
