"""Find which faces of a body meet along its edges, and whether they agree on the free side.

Every face runs round its edges with itself on the left. Two faces that meet and agree run along
their edge in opposite senses; an edge is closed if faces run along it as far in one sense as in
the other.
"""

from __future__ import annotations

from collections import defaultdict
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.geometry.curve_foot import CurveFeet
from contiga.geometry.edge_gaps import image_length
from contiga.geometry.edges import UNTRIMMED
from contiga.geometry.kernels.trim_area_nb import side_of_loop
from contiga.geometry.slits import reach_of_points
from contiga.geometry.trim import loop_pieces

if TYPE_CHECKING:
    from contiga.geometry.faces import Faces

N_SAMPLES = 9
"""Samples of an edge that are compared with another edge."""
LENGTH_TOL = 0.02
"""Share of an edge by which the lengths of the faces on its two sides may differ, by chords."""


class Joint(NamedTuple):
    """Two patches that meet, and whether they agree on the free side."""

    a: int
    """Number of a patch."""
    b: int
    """Number of the other patch; the same one at a seam."""
    agree: bool
    """Whether their free sides are on one side of the surface."""


class Joints(NamedTuple):
    """The joints between faces of a body along its edges."""

    joints: list[Joint]
    open: NDArray[np.bool_]
    """(edges,) where a face ends and no other continues."""
    crowded: NDArray[np.bool_]
    """(edges,) where more than two faces meet, not in pairs."""


def joints_of(body: Faces) -> Joints:
    """Return the joints along the named edges, from how often and in which sense each is used.

    Two uses are a joint; one or none is an open edge, unless it is a point within the tolerances.
    Of more uses the longest is joined with each other one if the lengths of these add up to its
    own, to `LENGTH_TOL`; else the edge is crowded, unless the faces run along it as far in one
    sense as in the other. Edges that a reader has mixed up (`_mispaired`) are none of these.
    """
    edges = body.edges
    is_left: dict[int, list[bool]] = {}
    """By trimmed patch, whether its face lies to the left of each of its loops."""
    for patch, loops in enumerate(body.trims):
        if loops is not None:
            pieces = loop_pieces(body.trim_tables, patch)
            is_left[patch] = [side_of_loop(body.trim_tables, loop) > 0 for loop in pieces]
    senses: list[list[bool]] = []
    """By edge and use, whether the face runs along the edge's curve with itself on the left."""
    for edge in edges:
        sense = []
        for use in edge.uses:
            if use.loop == UNTRIMMED:
                # Round a rectangle with it on the left: v0 and u1 upward, v1 and u0 downward.
                runs_left = use.index in (1, 2)
            else:
                runs_left = is_left[use.patch][use.loop]
            sense.append(runs_left != use.reversed)
        senses.append(sense)
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
            # A long face may meet several short ones, one after another.
            longest = int(length.argmax())
            shorter = [i for i in range(len(uses)) if i != longest]
            shortfall = abs(float(length[shorter].sum()) - length[longest])
            is_paired = shortfall <= LENGTH_TOL * length[longest]
            if is_paired:
                i = longest
                joints += [
                    Joint(uses[i].patch, uses[j].patch, sense[i] != sense[j]) for j in shorter
                ]
            round_trip = float(np.where(sense, length, -length).sum())
            crowded[k] = not is_paired and abs(round_trip) > LENGTH_TOL * length.max()
    _close_points(body, is_open)
    return Joints(joints, is_open, crowded)


def _mispaired(body: Faces, senses: list[list[bool]]) -> set[int]:
    """Return the numbers of coincident edges, each of which two faces use in one sense.

    The senses of the two edges of such a pair are opposite in space. Edges coincide if boxes and
    samples agree within the body's tolerances. Four faces meet there in pairs that a reader has
    mixed up, such as where a hole touches a wall in a line. The right pairs are not known, but the
    surface does not end there.
    """
    one_sense = [k for k, sense in enumerate(senses) if len(sense) == 2 and sense[0] == sense[1]]
    reach = reach_of_points(body) if len(one_sense) > 1 else 0.0
    mispaired: set[int] = set()
    for i, j in combinations(one_sense, 2):
        first, second = body.edges[i].curve, body.edges[j].curve
        if not mispaired.isdisjoint((i, j)):
            continue
        if np.abs(first.bounds() - second.bounds()).max() > reach:
            continue
        low, high = second.domain
        t = low + (high - low) * np.linspace(0.0, 1.0, N_SAMPLES)
        feet, distance = CurveFeet(first)(second.evaluate(t))
        if distance.max() > reach:
            continue
        middle = [N_SAMPLES // 2]
        tangents = [
            first.derivatives(feet[middle], 1)[0, 1],
            second.derivatives(t[middle], 1)[0, 1],
        ]
        same_direction = bool(tangents[0] @ tangents[1] > 0.0)
        if (senses[i][0] == senses[j][0]) != same_direction:
            mispaired |= {i, j}
    return mispaired


def _close_points(body: Faces, is_open: NDArray[np.bool_]) -> None:
    """Clear `is_open` at the open edges of a loop if together they are a point.

    A point is at most `reach_of_points` wide. A reader has joined the faces there, such as at the
    tip of a cone that is cut off within the tolerance.
    """
    reach = reach_of_points(body)
    edges_of_loop: defaultdict[tuple[int, int], list[int]] = defaultdict(list)
    for k in np.flatnonzero(is_open).tolist():
        for use in body.edges[k].uses:
            edges_of_loop[use.patch, use.loop].append(k)
    for edges in edges_of_loop.values():
        ends = np.concatenate([body.edges[k].curve.bounds() for k in edges])
        if np.ptp(ends, axis=0).max() <= reach:
            is_open[edges] = False


def turned_faces(n: int, joints: list[Joint]) -> tuple[tuple[int, ...], int]:
    """Return the faces with a free side opposite to most of their piece, and a count of conflicts.

    A flood over the joints of `n` patches gives each piece of the body one orientation; joints
    that contradict it (as on a Moebius strip) are conflicts. Of two equal halves of a piece the one
    without its first face is returned. Faces are ascending.
    """
    links: dict[int, list[tuple[int, bool]]] = defaultdict(list)
    for joint in joints:
        links[joint.a].append((joint.b, joint.agree))
        links[joint.b].append((joint.a, joint.agree))
    orientation: dict[int, bool] = {}
    turned: list[int] = []
    for first in range(n):
        if first in orientation:
            continue
        orientation[first] = True
        piece = [first]
        for patch in piece:
            for neighbour, agree in links[patch]:
                if neighbour not in orientation:
                    orientation[neighbour] = orientation[patch] == agree
                    piece.append(neighbour)
        opposite = [patch for patch in piece if not orientation[patch]]
        if 2 * len(opposite) > len(piece):
            opposite = [patch for patch in piece if orientation[patch]]
        turned += opposite
    n_conflicts = sum((orientation[j.a] == orientation[j.b]) != j.agree for j in joints)
    return tuple(sorted(turned)), n_conflicts
