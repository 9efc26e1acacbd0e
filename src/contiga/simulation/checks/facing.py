"""Find slaves that touch with the wrong side: the back, or front and back at once."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.contact.state import State
from contiga.records import FloatArray, IndexArray
from contiga.rigid.frames import to_body
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Pair, Scene
from contiga.slaves.cells import SOLIDS
from contiga.slaves.slave import Slave
from contiga.triangles.facet_tables import unit_normals, vertex_normals

# Of the force at a contact's greatest one: what points whose own side faces away may carry.
_OTHER_SIDE = 0.1
_SAME_SIDE = 0.9


def check_facing(scene: Scene) -> Iterator[Finding]:
    """Report skins of solids that are first touched from within."""
    for pair in scene.pairs:
        if not any(kind in SOLIDS for kind in pair.slave.cells):
            continue
        for time, seen in zip(pair.shown_times.tolist(), pair.dry_runs, strict=False):
            rows = seen.rows < len(pair.slave)
            if not rows.any() or pair.slave.facets is None:
                continue
            points, X_WB = pair.standing(time)
            outward = _normals(pair.slave, to_body(X_WB, points), seen.rows[rows])
            away = (outward * seen.normal_B[rows]).sum(axis=1) > 0.0
            if away.mean() > _SAME_SIDE:
                yield Finding(
                    "side",
                    pair.where,
                    f"the points of {pair.part.slave} that touch first lie on facets that face "
                    f"away from {pair.part.master}: it comes from within the solid that they are "
                    "the skin of",
                    "Choose the other side of it (sets, side or a box of the slave), or look at "
                    "where it stands",
                )
            break


def two_layers(pair: Pair, state: State) -> Iterator[Finding]:
    """Report slaves both of whose sides are in contact."""
    slave, rows = pair.slave, np.flatnonzero(state.in_contact[: len(pair.slave)])
    if slave.facets is None or len(rows) == 0 or pair.contact.quadrature != "nodes":
        return
    outward = _normals(slave, state.points_B, rows)
    faced = (outward * state.kept.normal_B.at(rows)).sum(axis=1) > 0.0
    carried = state.normal_force[rows]
    away = float(carried[faced].sum()) / max(float(carried.sum()), np.finfo(np.float64).tiny)
    # Both ways along the slave itself: points of one layer may lie on two sides of a body.
    turned = outward[faced].sum(axis=0) @ outward[~faced].sum(axis=0)
    if turned < 0.0 and _OTHER_SIDE < away < _SAME_SIDE:
        less = min(away, 1.0 - away)
        yield Finding(
            "layers",
            pair.where,
            f"both sides of {pair.part.slave} are in contact: {100.0 * less:.3g} % of the force is "
            "on facets that face the other way than the rest",
            "Choose the side that is to touch (parts, sets or a box of the slave), or make sure "
            "that the layer behind belongs to it",
        )


def _normals(slave: Slave, points: FloatArray, rows: IndexArray) -> FloatArray:
    """Return unit normals (len(rows), 3) of the slave's own facets at its nodes `rows`."""
    assert slave.facets is not None
    touched = slave.facets[np.isin(slave.facets, rows).any(axis=1)]
    corners = points[touched]
    return vertex_normals(corners, touched, unit_normals(corners), len(slave))[rows]
