"""The frame of the pictures: the parts that touch, without distant ones."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.records import FloatArray

_MAX_SIZE_RATIO = 4.0
"""Relative size, to the smallest touching part, above which only a piece of a part is shown."""
_PIECE_REACH = 1.5
"""Smallest reach of such a piece around the contact, over the size of the contact."""


class Focus(NamedTuple):
    """The frame of the pictures."""

    parts: tuple[int, ...]
    """Numbers of the parts that are shown whole."""
    corners: FloatArray
    """(k, 3) corners of the pieces of larger parts."""

    def points(self, parts: list[FloatArray]) -> FloatArray:
        """Return the framed points (n, 3): those (n_k, 3) of whole `parts`, then the corners."""
        return np.concatenate([*(parts[k] for k in self.parts), self.corners])


def focus_of(parts: list[FloatArray], patch: FloatArray, depth: float) -> Focus | None:
    """Return the parts and corners that a picture of the contact frames; None without a contact.

    Parts whose bounding boxes reach the box of the contact touch it. They are shown whole, unless
    they are more than four times as large as the smallest: then only the piece of their box around
    the contact is framed.

    Parameters
    ----------
    parts : points (n, 3) of each part that can be seen
    patch : (k, 3) points in contact
    depth : the greatest penetration: how far a point in contact may be from the part it touches
    """
    if len(patch) == 0:
        return None
    low, high = patch.min(axis=0), patch.max(axis=0)
    tol = 1.01 * depth + 1e-9 * float(np.abs(patch).max())
    touching = {}
    for k, points in enumerate(parts):
        finite = points[np.isfinite(points).all(axis=1)]
        if len(finite):
            box = np.array([finite.min(axis=0), finite.max(axis=0)])
            if (box[0] <= high + tol).all() and (box[1] >= low - tol).all():
                touching[k] = box
    sizes = {k: float(np.linalg.norm(np.ptp(box, axis=0))) for k, box in touching.items()}
    smallest = min((size for size in sizes.values() if size > 0.0), default=0.0)
    reach = max(_PIECE_REACH * float(np.linalg.norm(high - low)), smallest)
    middle = 0.5 * (low + high)
    corners = [np.zeros((0, 3))]
    for k, box in touching.items():
        if sizes[k] > _MAX_SIZE_RATIO * smallest:
            piece = np.clip(box, middle - reach, middle + reach)
            corners.append(np.stack(np.meshgrid(*piece.T), axis=-1).reshape(-1, 3))
    small_parts = tuple(k for k in touching if sizes[k] <= _MAX_SIZE_RATIO * smallest)
    return Focus(small_parts, np.concatenate(corners))
