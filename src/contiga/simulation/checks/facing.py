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

# Shares of the force, at the peak, on facets that face away: in between both sides are in contact.
_MIN_SHARE = 0.1
_MAX_SHARE = 0.9


def check_facing(scene: Scene) -> Iterator[Finding]:
    """Report skins of solids that are first touched from inside.

    More than `_MAX_SHARE` of the nodes in the first contact must lie on facets that face away.
    """
    for pair in scene.pairs:
        if not any(kind in SOLIDS for kind in pair.slave.cells):
            continue
        for time, result in zip(pair.shown_times.tolist(), pair.dry_runs, strict=False):
            rows = result.rows < len(pair.slave)
            if not rows.any() or pair.slave.facets is None:
                continue
            points, X_WB = pair.placement(time)
            outward = _normals(pair.slave, to_body(X_WB, points), result.rows[rows])
            faces_away = (outward * result.normal_B[rows]).sum(axis=1) > 0.0
            if faces_away.mean() > _MAX_SHARE:
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
    """Report slaves with both sides in contact, each with more than `_MIN_SHARE` of the force.

    The two sides must face in opposite directions; contacts with points other than nodes are
    not examined.
    """
    slave, rows = pair.slave, np.flatnonzero(state.in_contact[: len(pair.slave)])
    if slave.facets is None or len(rows) == 0 or pair.contact.quadrature != "nodes":
        return
    outward = _normals(slave, state.points_B, rows)
    faces_away = (outward * state.kept.normal_B.at(rows)).sum(axis=1) > 0.0
    forces = state.normal_force[rows]
    share_away = float(forces[faces_away].sum()) / max(
        float(forces.sum()), np.finfo(np.float64).tiny
    )
    # The two groups must face in opposite directions: one layer may touch two sides of a body.
    alignment = outward[faces_away].sum(axis=0) @ outward[~faces_away].sum(axis=0)
    if alignment < 0.0 and _MIN_SHARE < share_away < _MAX_SHARE:
        minority = min(share_away, 1.0 - share_away)
        yield Finding(
            "layers",
            pair.where,
            f"both sides of {pair.part.slave} are in contact: {100.0 * minority:.3g} % of the "
            "force is on facets that face the other way than the rest",
            "Choose the side that is to touch (parts, sets or a box of the slave), or make sure "
            "that the layer behind belongs to it",
        )


def _normals(slave: Slave, points: FloatArray, rows: IndexArray) -> FloatArray:
    """Return unit normals (len(rows), 3) of the slave's own facets at its nodes `rows`."""
    assert slave.facets is not None
    touched = slave.facets[np.isin(slave.facets, rows).any(axis=1)]
    corners = points[touched]
    return vertex_normals(corners, touched, unit_normals(corners), len(slave))[rows]
