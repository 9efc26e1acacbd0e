"""From faces of CAD, or shapes, to the patches of a slave of splines: untrimmed ones, refined."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from contiga.errors import GeometryError, InputError
from contiga.geometry.faces import Faces
from contiga.geometry.surface import NurbsSurface
from contiga.patches.net import join
from contiga.records import FloatArray

SAMPLES = 5
"""Lines across a patch, and points in an element along them, by which its elements are measured."""
OF_ITSELF = 0.1
"""Share of the size of all patches that an element is long at most, where nothing is said."""
MAX_ELEMENTS = 100_000
SAME = 1e-9
"""Part of the parameters of a patch within which a line and a knot are the same."""


class Refinement(NamedTuple):
    """The refinement of patches to the elements of a shell."""

    degree: int = 2
    """Lower ones are raised to it, in u and in v."""
    elements: tuple[int, int] | None = None
    """Equal parts of the parameters of each patch in u and in v, beside the lines that it has."""
    size: float | None = None
    """Length of an element at most; without `elements` a tenth of the size of all patches."""


def patches_of(faces: Faces) -> tuple[NurbsSurface, ...]:
    """The patches of faces none of which is trimmed.

    Raises
    ------
    GeometryError
        A face that is trimmed.
    """
    trimmed = [k + 1 for k, loops in enumerate(faces.trims) if loops is not None]
    if trimmed:
        named = ", ".join(map(str, trimmed[:8])) + (" …" if len(trimmed) > 8 else "")
        raise GeometryError(
            f"{len(trimmed)} of {len(faces.trims)} faces are trimmed, and shells of splines are "
            "made of whole patches",
            found=f"{'face' if len(trimmed) == 1 else 'faces'} {named}",
            allowed="faces that are all of their patch",
            remedy="Choose others by `parts` or `faces`, or have triangles made: mesh = { size }",
        )
    return faces.patches


def refined(patches: Sequence[NurbsSurface], how: Refinement) -> list[NurbsSurface]:
    """Patches with their degrees raised and their elements cut.

    With a size all elements of a row of patches that hang together by their joints are cut into as
    many parts as the longest needs, so that neighbours still have the same control points.

    Raises
    ------
    InputError
        What `join` refuses of patches that are to be cut alike; more than 100,000 elements.
    """
    raised = [patch.elevate(*(max(how.degree - p, 0) for p in patch.degrees)) for patch in patches]
    if how.elements is not None:
        lines = [
            [np.linspace(*ends, n + 1) for ends, n in zip(one.domain, how.elements, strict=True)]
            for one in raised
        ]
    else:
        points = np.concatenate([one.control_points.reshape(-1, 3) for one in raised])
        whole = float(np.sqrt(np.square(np.ptp(points, axis=0)).sum()))
        parts = _parts(raised, OF_ITSELF * whole if how.size is None else how.size)
        lines = [
            [_between(np.unique(knots), n) for knots, n in zip(one.knots, counts, strict=True)]
            for one, counts in zip(raised, parts, strict=True)
        ]
    cuts = [
        [_new(line, knots) for line, knots in zip(each, one.knots, strict=True)]
        for one, each in zip(raised, lines, strict=True)
    ]
    count = sum(
        math.prod(
            len(np.unique(knots)) - 1 + len(cut) for knots, cut in zip(one.knots, each, strict=True)
        )
        for one, each in zip(raised, cuts, strict=True)
    )
    if count > MAX_ELEMENTS:
        raise InputError(
            "are more elements than a run can be waited for",
            where="elements" if how.elements is not None else "size",
            found=count,
            allowed=f"up to {MAX_ELEMENTS}",
        )
    return [one.insert_knots(*each) for one, each in zip(raised, cuts, strict=True)]


def _new(lines: FloatArray, knots: FloatArray) -> FloatArray:
    """Those of the parameters that are no knots already."""
    apart = np.abs(lines[:, None] - knots).min(axis=1)
    return lines[apart > SAME * (knots[-1] - knots[0])]


def _parts(patches: Sequence[NurbsSurface], size: float) -> list[list[int]]:
    """Parts of each element in u and in v of each patch, the same along rows of patches."""
    parts = [[max(1, math.ceil(_longest(one, axis) / size)) for axis in (0, 1)] for one in patches]
    net = join(patches)
    while True:
        before = [list(row) for row in parts]
        for joint in net.joints:
            # An edge u0 or u1 runs along v.
            sides = [
                (net.pieces[piece].patch, 1 if edge[0] == "u" else 0)
                for piece, edge in zip(joint.pieces, joint.edges, strict=True)
            ]
            most = max(parts[patch][axis] for patch, axis in sides)
            for patch, axis in sides:
                parts[patch][axis] = most
        if parts == before:
            return parts


def _longest(patch: NurbsSurface, axis: int) -> float:
    """Length of the longest element of a patch along u or v."""
    breaks = np.unique(patch.knots[axis])
    along = np.concatenate([[breaks[0]], _between(breaks, SAMPLES - 1, ends=True)])
    across = np.linspace(*patch.domain[1 - axis], SAMPLES)
    uv = np.empty((len(across), len(along), 2))
    uv[..., axis], uv[..., 1 - axis] = along, across[:, None]
    points = patch.evaluate(uv.reshape(-1, 2)).reshape(len(across), len(along), 3)
    steps = np.sqrt(np.square(np.diff(points, axis=1)).sum(axis=2))
    return float(steps.reshape(len(across), -1, SAMPLES - 1).sum(axis=2).max())


def _between(breaks: FloatArray, parts: int, *, ends: bool = False) -> FloatArray:
    """Parameters that cut each interval into equal parts; with their ends, if asked for."""
    shares = np.arange(1, parts + (1 if ends else 0)) / parts
    return np.asarray((breaks[:-1, None] + np.diff(breaks)[:, None] * shares).ravel())
