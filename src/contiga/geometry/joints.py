"""Find which faces of a body meet along its edges, and whether they agree on the free side.

Every face goes round its edges with itself on the left. Two faces that meet and agree go along
their edge in opposite senses; an edge that faces go along as far one way as the other is closed.
"""

from __future__ import annotations

from collections import defaultdict
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.curve_foot import CurveFeet
from contiga.geometry.edge_gaps import image_length
from contiga.geometry.edges import UNTRIMMED, EdgeUse
from contiga.geometry.kernels.trim_area_nb import side_of_loop
from contiga.geometry.slits import reach_of_points
from contiga.geometry.trim import loop_pieces
from contiga.records import FloatArray

if TYPE_CHECKING:
    from contiga.geometry.faces import Faces

N_SAMPLES = 9
"""Points of an edge that are compared with another edge."""
UNEVEN = 0.02
"""Share of an edge by which the faces on its two sides may differ in length, as chords have it."""


class Joint(NamedTuple):
    """Two patches that meet, and whether they call the same side free."""

    a: int
    b: int
    agree: bool


class Joints(NamedTuple):
    """The joints between faces of a body along its edges."""

    joints: list[Joint]
    open: NDArray[np.bool_]
    """(edges,) where one face ends and no other goes on."""
    crowded: NDArray[np.bool_]
    """(edges,) where more than two faces meet, not in pairs."""


def joints_of(body: Faces) -> Joints:
    """The joints along the edges the body names, from how often and which way each is used."""
    edges = body.edges
    trimmed = [k for k, loops in enumerate(body.trims) if loops is not None]
    left = {patch: _loops_left(body, patch) for patch in trimmed}
    senses = [[_sense(use, left.get(use.patch, [])) for use in edge.uses] for edge in edges]
    mispaired = _mispaired(body, senses)
    joints: list[Joint] = []
    is_open = np.zeros(len(edges), dtype=bool)
    crowded = np.zeros(len(edges), dtype=bool)
    for k, (edge, sense) in enumerate(zip(edges, senses, strict=True)):
        uses = edge.uses
        if k in mispaired:
            continue
        if len(uses) == 2:
            joints.append(Joint(uses[0].patch, uses[1].patch, sense[0] != sense[1]))
        elif len(uses) < 2:
            is_open[k] = True
        else:
            length = np.array(
                [image_length(edge, i, body.patches, body.trims) for i in range(len(uses))]
            )
            opposite = _opposite(length)
            joints += [
                Joint(uses[i].patch, uses[j].patch, sense[i] != sense[j]) for i, j in opposite
            ]
            round_trip = float(np.where(sense, length, -length).sum())
            crowded[k] = not opposite and abs(round_trip) > UNEVEN * length.max()
    _close_points(body, is_open)
    return Joints(joints, is_open, crowded)


def _mispaired(body: Faces, senses: list[list[bool]]) -> set[int]:
    """Coincident edges, each used by two faces in one sense, the two edges in opposite senses.

    Four faces meet there, in pairs that a reader has mixed up: as where a hole touches a wall in
    a line. Which of them belong together is not known, but the surface ends nowhere.
    """
    one_way = [k for k, sense in enumerate(senses) if len(sense) == 2 and sense[0] == sense[1]]
    reach = reach_of_points(body) if len(one_way) > 1 else 0.0
    mispaired: set[int] = set()
    for i, j in combinations(one_way, 2):
        if mispaired.isdisjoint((i, j)):
            same_way = _coincide(body.edges[i].curve, body.edges[j].curve, reach)
            if same_way is not None and (senses[i][0] == senses[j][0]) != same_way:
                mispaired |= {i, j}
    return mispaired


def _coincide(first: NurbsCurve, second: NurbsCurve, reach: float) -> bool | None:
    """Return whether two curves run the same way, if they lie within `reach`; else None."""
    if np.abs(first.bounds() - second.bounds()).max() > reach:
        return None
    low, high = second.domain
    t = low + (high - low) * np.linspace(0.0, 1.0, N_SAMPLES)
    there, off = CurveFeet(first)(second.evaluate(t))
    if off.max() > reach:
        return None
    middle = N_SAMPLES // 2
    ways = [first.derivatives(there[[middle]], 1)[0, 1], second.derivatives(t[[middle]], 1)[0, 1]]
    return bool(ways[0] @ ways[1] > 0.0)


def _close_points(body: Faces, is_open: NDArray[np.bool_]) -> None:
    """Take for closed what the open edges of a loop leave open within the body's tolerance.

    Such edges are a point: a reader has joined what they bound, as at the tip of a cone that is
    cut off where the tolerance does not tell.
    """
    reach = reach_of_points(body)
    of_loop: defaultdict[tuple[int, int], list[int]] = defaultdict(list)
    for k in np.flatnonzero(is_open).tolist():
        for use in body.edges[k].uses:
            of_loop[use.patch, use.loop].append(k)
    for some in of_loop.values():
        ends = np.concatenate([body.edges[k].curve.bounds() for k in some])
        if np.ptp(ends, axis=0).max() <= reach:
            is_open[some] = False


def _opposite(length: FloatArray) -> list[tuple[int, int]]:
    """Uses that lie opposite each other on an edge: one face may meet several one by one."""
    longest = int(length.argmax())
    others = [i for i in range(len(length)) if i != longest]
    if abs(float(length[others].sum()) - length[longest]) <= UNEVEN * length[longest]:
        return [(longest, i) for i in others]
    return []


def _sense(use: EdgeUse, left: list[bool]) -> bool:
    """Return whether a face goes along the edge's curve with itself on the left."""
    if use.loop == UNTRIMMED:
        # Round a rectangle with it on the left: v0 and u1 upward, v1 and u0 downward.
        return (use.index in (1, 2)) != use.reversed
    return left[use.loop] != use.reversed


def _loops_left(body: Faces, patch: int) -> list[bool]:
    """Return whether the face of a patch lies to the left of each of its loops."""
    tables = body.trim_tables
    return [side_of_loop(tables, pieces) > 0 for pieces in loop_pieces(tables, patch)]


def turned_faces(n: int, joints: list[Joint]) -> tuple[tuple[int, ...], int]:
    """Faces that call the other side free than the most they are joined to, and joints at odds.

    A flood over the joints of `n` patches gives each piece of the body one orientation; joints
    that contradict it (as on a Moebius strip) are counted.
    """
    links: dict[int, list[tuple[int, bool]]] = defaultdict(list)
    for joint in joints:
        links[joint.a].append((joint.b, joint.agree))
        links[joint.b].append((joint.a, joint.agree))
    way: dict[int, bool] = {}
    turned: list[int] = []
    for first in range(n):
        if first in way:
            continue
        way[first] = True
        piece = [first]
        for patch in piece:
            for other, agree in links[patch]:
                if other not in way:
                    way[other] = way[patch] == agree
                    piece.append(other)
        odd = [patch for patch in piece if not way[patch]]
        turned += odd if 2 * len(odd) <= len(piece) else [p for p in piece if way[p]]
    at_odds = sum((way[j.a] == way[j.b]) != j.agree for j in joints)
    return tuple(sorted(turned)), at_odds
