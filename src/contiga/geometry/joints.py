"""Which faces of a body meet along its edges, whether they agree on the free side, where none is.

Every face goes round its edges with itself on the left. Two faces that meet and agree go along
their edge in opposite senses; an edge that faces go along as far one way as the other is closed.
"""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.edge_gaps import image_length
from contiga.geometry.edges import UNTRIMMED, EdgeUse
from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga.records import FloatArray

if TYPE_CHECKING:
    from contiga.geometry.faces import Faces

MAX_CURVES = 24
"""P-curves of a loop beside which it is looked at most."""
SHARES = np.array([0.29, 0.5, 0.71])
"""Places of a p-curve beside which it is looked, shares of its interval."""
STEP = 1e-4
"""Half the step of the difference that gives a p-curve's direction, share of its interval."""
BESIDE = 1e-6
"""How far beside a p-curve it is looked, share of the p-curve's extent."""
UNEVEN = 0.02
"""Share of an edge by which the faces on its two sides may differ in length, as chords have it."""


class Joint(NamedTuple):
    """Two patches that meet, and whether they call the same side free."""

    a: int
    b: int
    agree: bool


class Joints(NamedTuple):
    """How the faces of a body meet along its edges."""

    joints: list[Joint]
    open: NDArray[np.bool_]
    """(edges,) where one face ends and no other goes on."""
    crowded: NDArray[np.bool_]
    """(edges,) where more than two faces meet, not in pairs."""


def joints_of(body: Faces) -> Joints:
    """The joints along the edges the body names, from how often and which way each is used."""
    edges = body.edges
    left = [_loops_left(body, patch) for patch in range(len(body.patches))]
    joints: list[Joint] = []
    is_open = np.zeros(len(edges), dtype=bool)
    crowded = np.zeros(len(edges), dtype=bool)
    for k, edge in enumerate(edges):
        uses = edge.uses
        sense = [_sense(use, left[use.patch]) for use in uses]
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
    return Joints(joints, is_open, crowded)


def _opposite(length: FloatArray) -> list[tuple[int, int]]:
    """Uses that lie opposite each other on an edge: one face may meet several one by one."""
    longest = int(length.argmax())
    others = [i for i in range(len(length)) if i != longest]
    if abs(float(length[others].sum()) - length[longest]) <= UNEVEN * length[longest]:
        return [(longest, i) for i in others]
    return []


def _sense(use: EdgeUse, left: list[bool]) -> bool:
    """Whether a face goes along the edge's curve with itself on the left."""
    if use.loop == UNTRIMMED:
        # Round a rectangle with it on the left: v0 and u1 upward, v1 and u0 downward.
        return (use.index in (1, 2)) != use.reversed
    return left[use.loop] != use.reversed


def _loops_left(body: Faces, patch: int) -> list[bool]:
    """Whether the face of `patch` lies to the left of each of its loops.

    Looked at just beside some places of each loop, on both sides: that decides for loops that
    touch themselves or others, too, and whatever is left of a loop that its orientation hides.
    """
    loops = body.trims[patch]
    if loops is None:
        return []
    low, high = np.array(body.patches[patch].domain).T
    places, asides, owner = [], [], []
    for number, loop in enumerate(loops):
        for curve in loop[:: -(-len(loop) // MAX_CURVES)]:
            (a, b), extent = curve.domain, np.ptp(curve.control_points[:, :2], axis=0)
            t = a + (b - a) * SHARES[:, None] + (b - a) * np.array([-STEP, 0.0, STEP])
            before, at, after = curve.evaluate(t.T.ravel())[:, :2].reshape(3, -1, 2)
            way = (after - before) / (high - low)
            left = np.stack([-way[:, 1], way[:, 0]], axis=1)
            left /= np.maximum(np.linalg.norm(left, axis=1), 1e-300)[:, None]
            places.append(at)
            asides.append(BESIDE * (extent / (high - low)).max() * left * (high - low))
            owner += [number] * len(at)
    place, aside = np.concatenate(places), np.concatenate(asides)
    votes = np.zeros(len(loops))
    for sign in (1.0, -1.0):
        uv = np.ascontiguousarray(place + sign * aside)
        inside = ((low <= uv) & (uv <= high)).all(axis=1)
        inside &= points_in_trim(body.trim_tables, patch, uv)
        np.add.at(votes, owner, sign * inside)
    return [bool(vote > 0.0) for vote in votes]


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
