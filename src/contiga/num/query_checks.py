"""What every search asks of its arguments, on exact bodies and on triangles alike."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from contiga.errors import InputError
from contiga.num.arrays import as_points
from contiga.records import FloatArray, IntArray, Projection


def checked_mode(mode: str) -> bool:
    """Whether the mode of a projection is "global", and not "track".

    Raises
    ------
    InputError
        It is neither.
    """
    if mode not in ("global", "track"):
        raise InputError(
            "unknown mode of projection", where="mode", found=mode, allowed='"global", "track"'
        )
    return mode == "global"


def _checked_start(start: Projection | None) -> Projection:
    if start is None:
        raise InputError(
            'mode "track" continues a projection',
            where="start",
            found=None,
            allowed="the Projection of the same points one step ago",
        )
    if not isinstance(start, Projection):
        raise InputError("start must be a Projection", where="start", found=type(start).__name__)
    return start


def checked_patches(start: Projection | None, n: int, count: int, what: str) -> IntArray:
    """(n,) the patches that n points start from; there are `count`, each called `what`.

    Raises
    ------
    InputError
        No start or something else, other than n rows, a patch that is not there.
    """
    patch = np.ascontiguousarray(_checked_start(start).patch, dtype=np.int32)
    if patch.shape != (n,):
        raise InputError(
            "start must have one row a point",
            where="start",
            found=patch.shape,
            allowed=f"patch ({n},)",
        )
    if n and int(patch.max()) >= count:
        raise InputError(
            f"start names a {what} that is not there",
            where="start.patch",
            found=int(patch.max()),
            allowed=f"-1 … {count - 1}",
        )
    return patch


def checked_segments(p0: ArrayLike, p1: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """(n, 3) starts and ends of segments.

    Raises
    ------
    InputError
        Arrays that are not (n, 3) or differ in n.
    """
    a, b = as_points(p0, "p0"), as_points(p1, "p1")
    if a.shape != b.shape:
        raise InputError(
            "segments need as many ends as starts", where="p1", found=b.shape, allowed=str(a.shape)
        )
    return a, b
