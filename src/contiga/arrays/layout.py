"""Arrays of public calls: shape and dtype are checked once here, kernels trust them."""

from __future__ import annotations

from collections.abc import Iterable
from types import UnionType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from contiga.errors import InputError
from contiga.records import FloatArray

_PLAIN_TYPES = {float, int}

AnyArray = TypeVar("AnyArray", bound=NDArray[Any])


def real(values: Any, where: str | None = None) -> Any:
    """Return `values` unchanged; raise InputError for complex numbers or masked entries.

    NumPy would drop imaginary parts with a warning, and masks silently. Lists are searched at all
    levels; values that are no numbers pass.
    """
    if type(values) is np.ndarray and values.dtype.kind == "f":  # the usual case
        return values
    if fault := _why_not_real(values):
        raise InputError(f"{fault} in place of real numbers", where=where)
    return values


def _why_not_real(values: Any) -> str | None:
    """Return why `values` are not real numbers; None if they are, or are no numbers at all."""
    if isinstance(values, list | tuple):
        if _PLAIN_TYPES.issuperset(map(type, values)):  # twice as fast as a check of each
            return None
        return next(filter(None, map(_why_not_real, values)), None)
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        return "masked entries"
    if isinstance(values, complex) or getattr(getattr(values, "dtype", None), "kind", "") == "c":
        return "complex numbers"
    return None


def as_contiguous(values: ArrayLike, dtype: DTypeLike) -> NDArray[Any]:
    """Return `values` as an array for kernels: C-contiguous, aligned and writeable.

    Such arrays of the type are not copied. For kernels a read-only array has another type, for
    which they would be compiled again. Raises InputError for complex or masked values, and
    TypeError or ValueError if they are not numbers.
    """
    if type(values) is np.ndarray and values.dtype == dtype and values.flags.carray:
        return values
    return np.require(real(values), dtype, ("C", "A", "W", "E"))


def as_points(values: ArrayLike, name: str = "points") -> FloatArray:
    """Return `values` as a C-contiguous (n, 3) float64 array, without a copy if it is one.

    A single point ``(3,)`` becomes one row. Entries that are not finite are allowed: results mark
    them row by row. Raises InputError for other shapes, and for values that are not real numbers.
    """
    if (
        type(values) is np.ndarray
        and values.shape[1:] == (3,)
        and values.dtype == np.float64
        and values.flags.carray
    ):
        return values  # the usual case
    return _as_rows(values, name, 3, "(n, 3)")


def as_parameters(values: ArrayLike) -> FloatArray:
    """Return `values` as a C-contiguous (k, 2) float64 array; a single pair becomes one row.

    Raises InputError for other shapes, and for values that are not real numbers.
    """
    return _as_rows(values, "uv", 2, "(k, 2)")


def _as_rows(values: ArrayLike, name: str, columns: int, shape: str) -> FloatArray:
    """Return `values` as a C-contiguous (n, columns) array; InputError calls them `name`."""
    real(values, name)
    try:
        rows = as_contiguous(values, np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} must be an array of numbers", allowed=f"shape {shape}") from error
    if rows.shape == (columns,):
        rows = rows[None, :]
    if rows.ndim != 2 or rows.shape[1] != columns:
        raise InputError(f"{name} must have shape {shape}", found=rows.shape, allowed=shape)
    return rows


def as_numbers(
    values: object, where: str, what: str = "must be numbers", allowed: str | None = None
) -> FloatArray:
    """Return a C-contiguous float64 copy of `values`, of any shape.

    Raises InputError if they are not real numbers; `what` is its message.
    """
    real(values, where)
    try:
        return np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise InputError(what, where=where, found=values, allowed=allowed) from error


def read_only(array: FloatArray) -> FloatArray:
    """Return a C-contiguous float64 copy of `array` that is read-only.

    Raises InputError for complex numbers or masked entries.
    """
    copy = np.array(real(array), dtype=np.float64, order="C")
    copy.flags.writeable = False
    return copy


def locked(values: AnyArray) -> AnyArray:
    """Return a read-only view of an array.

    For numba a read-only array has another type than a writeable one: kernels that read a user's
    arrays, which may be either, get this view and need one version only.
    """
    view = values.view()
    view.setflags(write=False)  # half the time of view.flags.writeable = False
    return view


def positive(value: object, name: str, *, finite: bool = True) -> float:
    """Return `value` as a float > 0, finite unless `finite` is False.

    Raises InputError for another value, which the message calls `name`.
    """
    allowed = "a finite number > 0" if finite else "a number > 0"
    try:
        number = value if type(value) is float else float(real(value))
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError("must be a number", where=name, found=value, allowed=allowed) from error
    if not number > 0.0 or (finite and number == np.inf):
        raise InputError("must be positive", where=name, found=value, allowed=allowed)
    return number


def not_negative(value: object, name: str) -> float:
    """Return `value` as a finite float ≥ 0; raise InputError, which calls it `name`, otherwise."""
    allowed = "a finite number >= 0"
    try:
        number = float(real(value))
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError("must be a number", where=name, found=value, allowed=allowed) from error
    if not np.isfinite(number):
        raise InputError("must be finite", where=name, found=value, allowed=allowed)
    if number < 0.0:
        raise InputError("must not be negative", where=name, found=value, allowed=allowed)
    return number


def checked_choice(where: str, value: object, allowed: tuple[str, ...]) -> str:
    """Return `value` if it is one of the words `allowed`; raise InputError otherwise."""
    if not isinstance(value, str) or value not in allowed:
        raise InputError(
            "is not known", where=where, found=value, allowed=", ".join(map(repr, allowed))
        )
    return value


def check_types(
    kinds: type | tuple[type, ...] | UnionType,
    values: Iterable[object],
    where: str,
    what: str,
    allowed: str,
) -> None:
    """Raise InputError for the first of `values` that is not of `kinds`; `what` is the message."""
    for k, value in enumerate(values):
        if not isinstance(value, kinds):
            raise InputError(
                what, where=f"{where}[{k}]", found=type(value).__name__, allowed=allowed
            )


def bytes_of(value: object) -> int:
    """Return the memory of all arrays in nested tuples, bytes; other values count as zero.

    >>> bytes_of((np.zeros(3), (np.zeros(2, np.int32), "text")))
    32
    """
    if isinstance(value, np.ndarray):
        return value.nbytes
    if isinstance(value, tuple):
        return sum(bytes_of(entry) for entry in value)
    return 0
