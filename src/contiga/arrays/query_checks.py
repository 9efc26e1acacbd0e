"""Check the arguments of searches, on exact bodies and on triangles alike."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import combinations, product
from typing import Any

import numpy as np
from numba import typeof
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.kernels.query_nb import BAD_SHAPES, highest_patch
from contiga.arrays.layout import as_contiguous, as_points
from contiga.errors import InputError
from contiga.jit.dispatcher import KernelDispatcher
from contiga.records import FloatArray, Projection, empty_projection

NO_PROJECTION = empty_projection(0)
"""A projection without rows."""
EMPTY_ARRAYS: tuple[NDArray[Any], ...] = NO_PROJECTION
"""Its arrays, with the type and shape of each."""
OUT_RULE = "arrays of their own, or those of start: out=start"
"""Rule for `out` in messages."""
DTYPES = tuple(array.dtype for array in EMPTY_ARRAYS)
ROW_SHAPES = tuple(array.shape[1:] for array in EMPTY_ARRAYS)
"""The types of its arrays, and the shapes of their rows."""


def checked_mode(mode: str) -> bool:
    """Return whether the mode of a projection is "global", and not "track".

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


def checked_start(start: Projection | None, n: int, count: int, what: str) -> Projection:
    """Return `start` if its arrays are laid out for kernels, with n rows; else a copy that is.

    Its patches must be below `count`, the number of the body's patches, which messages call `what`.

    Raises
    ------
    InputError
        No start or no projection, arrays of other than n rows, or that are no numbers, a patch
        that does not exist.
    """
    if start is None:
        raise InputError(
            'mode "track" continues a projection',
            where="start",
            found=None,
            allowed="the Projection of the same points one step ago",
        )
    if not isinstance(start, Projection):
        raise InputError("start must be a Projection", where="start", found=type(start).__name__)
    highest = _highest_patch(start, n)
    if highest is None:
        start = _as_laid_out(start, n)
        highest = int(start.patch.max(initial=-1))
    if highest >= count:
        raise InputError(
            f"start names a {what} that is not there",
            where="start.patch",
            found=highest,
            allowed=f"-1 … {count - 1}",
        )
    return start


def _highest_patch(feet: Projection, n: int) -> int | None:
    """Return the highest patch of n feet, −1 if none has one; None unless laid out for kernels.

    A kernel checks that: eight arrays from Python, and the patches with NumPy, take three times as
    long, for 10⁴ feet a hundredth of the time to track them.
    """
    highest_patch = _feet_kernel()
    if highest_patch is None:
        return int(feet.patch.max(initial=-1)) if _is_laid_out(feet, n) else None
    try:
        highest = highest_patch(*feet)
    except TypeError:  # arrays of other types, or other things
        return None
    return None if highest == BAD_SHAPES or len(feet.patch) != n else int(highest)


@lru_cache(maxsize=1)
def _feet_kernel() -> Callable[..., int] | None:
    """Return `highest_patch`, compiled for the types of a Projection only; None if interpreted.

    A call with other types raises TypeError.
    """
    kernel: Any = highest_patch
    if not isinstance(kernel, KernelDispatcher):
        return None
    kernel.compile(tuple(map(typeof, EMPTY_ARRAYS)))
    kernel.disable_compile()
    return kernel


def _is_laid_out(feet: Projection, n: int) -> bool:
    """Return whether all arrays have n rows, the right types and C order, and are writeable.

    False also for subclasses of an array, and for types that are equal but not the same object.
    """
    arrays: tuple[Any, ...] = feet
    for array, dtype, row in zip(arrays, DTYPES, ROW_SHAPES, strict=True):
        # Equal types need not be identical; such arrays are then checked one by one.
        if type(array) is not np.ndarray or array.dtype is not dtype or array.shape != (n, *row):
            return False
        if not array.flags.carray:
            return False
    return True


def _as_laid_out(start: Projection, n: int) -> Projection:
    """Return a projection of n rows with arrays that are laid out for kernels, copied if needed.

    Raises the errors of `checked_start` on arrays.
    """
    columns = []
    arrays: tuple[Any, ...] = start
    for name, values, like in zip(Projection._fields, arrays, EMPTY_ARRAYS, strict=True):
        try:
            array = as_contiguous(values, like.dtype)
        except (TypeError, ValueError) as error:
            raise InputError(
                "start must be of arrays of numbers",
                where=f"start.{name}",
                found=type(values).__name__,
                allowed=f"{like.dtype} {(n, *like.shape[1:])}",
            ) from error
        if array.shape != (n, *like.shape[1:]):
            raise InputError(
                "start must have one row a point",
                where="start",
                found=array.shape,
                allowed=f"{name} {(n, *like.shape[1:])}",
            )
        columns.append(array)
    return Projection(*columns)


def checked_feet(
    start: Projection | None, out: Projection | None, points: FloatArray, count: int, what: str
) -> tuple[Projection, Projection]:
    """Return the projections to track from and to fill; both are the same if `out` is `start`.

    The errors are those of `checked_start` and `checked_out`.
    """
    last = checked_start(start, len(points), count, what)
    if out is None or out is not last:
        return last, checked_out(out, points, start)
    check_apart(out, [points], OUT_RULE)  # arrays that are laid out can be filled
    return last, out


def checked_out(out: Projection | None, points: FloatArray, start: Projection | None) -> Projection:
    """Return the projection to fill for `points`: `out`, or a new one, not initialised, without it.

    Raises
    ------
    InputError
        `out` is no projection of arrays that can be filled, or shares memory with the points, with
        another `start`, or between its arrays.
    """
    if out is None:
        return empty_projection(len(points))
    if not isinstance(out, Projection):
        raise InputError("out must be a Projection", where="out", found=type(out).__name__)
    arrays: tuple[NDArray[Any], ...] = out
    if not _is_laid_out(out, len(points)):
        for name, array, like in zip(Projection._fields, arrays, EMPTY_ARRAYS, strict=True):
            check_fillable(array, (len(points), *like.shape[1:]), like.dtype, f"out.{name}")
    read = [points] if start is None or start is out else [points, *start]
    check_apart(arrays, read, OUT_RULE)
    return out


def check_fillable(array: Any, shape: tuple[int, ...], dtype: Any, where: str) -> None:
    """Raise InputError unless `array` has the shape, type and C order, and is writeable."""
    fits = isinstance(array, np.ndarray) and array.shape == shape and array.dtype == dtype
    if not fits or not array.flags.carray:
        raise InputError(
            "out must have arrays of one row a point, that can be written to",
            where=where,
            found=getattr(array, "shape", type(array).__name__),
            allowed=f"{shape}, {np.dtype(dtype)}, C-contiguous, writeable",
        )


def check_apart(filled: Sequence[Any], read: Sequence[Any], allowed: str) -> None:
    """Raise InputError if arrays of `out` share memory with the input, or with each other.

    Arrays count as sharing if the ranges of their addresses overlap.
    """
    arrays = [*filled, *read]
    # Arrays that own their memory share none; testing all pairs takes ten times as long.
    if all(array.flags.owndata for array in arrays) and len(set(map(id, arrays))) == len(arrays):
        return
    pairs = [*product(filled, read), *combinations(filled, 2)]
    if any(np.may_share_memory(a, b) for a, b in pairs):
        raise InputError(
            "out shares memory with what is read, or its arrays with each other",
            where="out",
            allowed=allowed,
        )


def checked_segments(p0: ArrayLike, p1: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return starts and ends of segments (n, 3); a single point (3,) becomes one row.

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
