"""Patches of a slave of splines: untrimmed faces of CAD, or shapes, refined."""

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

N_SAMPLES = 5
"""Number of lines across a patch, and of points in an element along them, that measure elements."""
DEFAULT_SIZE = 0.1
"""Largest length of an element over the size of all patches, by default."""
MAX_ELEMENTS = 100_000
KNOT_TOL = 1e-9
"""Distance over the parameter range of a patch within which a line and a knot are the same."""


class Refinement(NamedTuple):
    """The refinement of patches to the elements of a shell."""

    degree: int = 2
    """Smallest degree in u and in v; lower ones are raised."""
    elements: tuple[int, int] | None = None
    """Number of equal parts of each patch in u and in v, in addition to its knots."""
    size: float | None = None
    """Largest length of an element; without `elements` a tenth of the size of all patches."""


def patches_of(faces: Faces) -> tuple[NurbsSurface, ...]:
    """Return the patches of `faces`, none of which may be trimmed.

    Raises
    ------
    GeometryError
        A face is trimmed.
    """
    trimmed = [k + 1 for k, loops in enumerate(faces.trims) if loops is not None]
    if trimmed:
        numbers = ", ".join(map(str, trimmed[:8])) + (" …" if len(trimmed) > 8 else "")
        raise GeometryError(
            f"{len(trimmed)} of {len(faces.trims)} faces are trimmed, and shells of splines are "
            "made of whole patches",
            found=f"{'face' if len(trimmed) == 1 else 'faces'} {numbers}",
            allowed="faces that are all of their patch",
            remedy="Choose others by `parts` or `faces`, or have triangles made: mesh = { size }",
        )
    return faces.patches


def refined(patches: Sequence[NurbsSurface], how: Refinement) -> list[NurbsSurface]:
    """Return patches with their degrees raised and their elements cut, of the same shape.

    Degrees become at least `how.degree`. With `how.elements`, the range of each patch is cut into
    as many equal parts, besides its own knots. Otherwise all elements of a row of joined patches
    are cut into as many equal parts as the longest needs for `how.size`, so that neighbours still
    have the same control points.

    Raises
    ------
    InputError
        The errors of `join`, without `how.elements`; more than 100,000 elements.
    """
    raised = [patch.elevate(*(max(how.degree - p, 0) for p in patch.degrees)) for patch in patches]
    if how.elements is not None:
        lines = [
            [np.linspace(*ends, n + 1) for ends, n in zip(patch.domain, how.elements, strict=True)]
            for patch in raised
        ]
    else:
        points = np.concatenate([patch.control_points.reshape(-1, 3) for patch in raised])
        diagonal = float(np.sqrt(np.square(np.ptp(points, axis=0)).sum()))
        counts = _part_counts(raised, DEFAULT_SIZE * diagonal if how.size is None else how.size)
        lines = [
            [_cuts(np.unique(knots), n) for knots, n in zip(patch.knots, patch_counts, strict=True)]
            for patch, patch_counts in zip(raised, counts, strict=True)
        ]
    new_knots = []
    n_elements = 0
    for patch, patch_lines in zip(raised, lines, strict=True):
        cuts, n_spans = [], []
        for line, knots in zip(patch_lines, patch.knots, strict=True):
            dist = np.abs(line[:, None] - knots).min(axis=1)
            cuts.append(line[dist > KNOT_TOL * (knots[-1] - knots[0])])
            n_spans.append(len(np.unique(knots)) - 1 + len(cuts[-1]))
        new_knots.append(cuts)
        n_elements += math.prod(n_spans)
    if n_elements > MAX_ELEMENTS:
        raise InputError(
            "are more elements than a run can be waited for",
            where="elements" if how.elements is not None else "size",
            found=n_elements,
            allowed=f"up to {MAX_ELEMENTS}",
        )
    return [patch.insert_knots(*cuts) for patch, cuts in zip(raised, new_knots, strict=True)]


def _part_counts(patches: Sequence[NurbsSurface], size: float) -> list[list[int]]:
    """Return (u, v) for each patch: number of parts to cut each of its elements into.

    It is the length of the longest element over `size`, rounded up, and the largest number of the
    patches that joined edges connect across the direction. Raises the errors of `join`.
    """
    counts = [
        [max(1, math.ceil(_longest_element(patch, axis) / size)) for axis in (0, 1)]
        for patch in patches
    ]
    net = join(patches)
    while True:
        old_counts = [list(row) for row in counts]
        for joint in net.joints:
            # An edge u0 or u1 runs along v.
            sides = [
                (net.pieces[piece].patch, 1 if edge[0] == "u" else 0)
                for piece, edge in zip(joint.pieces, joint.edges, strict=True)
            ]
            largest = max(counts[patch][axis] for patch, axis in sides)
            for patch, axis in sides:
                counts[patch][axis] = largest
        if counts == old_counts:
            return counts


def _longest_element(patch: NurbsSurface, axis: int) -> float:
    """Return the length of the longest element of a patch along u (axis 0) or v (axis 1).

    By chords between `N_SAMPLES` points of an element, on as many lines across the patch.
    """
    breaks = np.unique(patch.knots[axis])
    line = np.concatenate([[breaks[0]], _cuts(breaks, N_SAMPLES - 1, ends=True)])
    across = np.linspace(*patch.domain[1 - axis], N_SAMPLES)
    uv = np.empty((len(across), len(line), 2))
    uv[..., axis], uv[..., 1 - axis] = line, across[:, None]
    points = patch.evaluate(uv.reshape(-1, 2)).reshape(len(across), len(line), 3)
    steps = np.sqrt(np.square(np.diff(points, axis=1)).sum(axis=2))
    return float(steps.reshape(len(across), -1, N_SAMPLES - 1).sum(axis=2).max())


def _cuts(breaks: FloatArray, count: int, *, ends: bool = False) -> FloatArray:
    """Return parameters that cut each interval of `breaks` into `count` equal parts, ascending.

    With `ends`, the end of each interval follows its cuts.
    """
    shares = np.arange(1, count + (1 if ends else 0)) / count
    return np.asarray((breaks[:-1, None] + np.diff(breaks)[:, None] * shares).ravel())
