"""Arrays at the public door: shape and dtype are checked once here, kernels trust them."""

from __future__ import annotations

from collections.abc import Iterable
from types import UnionType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from contiga.errors import InputError
from contiga.records import FloatArray

_PLAIN = {float, int}

AnyArray = TypeVar("AnyArray", bound=NDArray[Any])


def real(values: Any, where: str | None = None) -> Any:
    """`values`, refused where they are complex or have masked entries.

    NumPy drops imaginary parts with a warning, and masks in silence.
    """
    if type(values) is np.ndarray and values.dtype.kind == "f":  # most of what comes
        return values
    if what := _unreal(values):
        raise InputError(f"{what} in place of real numbers", where=where)
    return values


def _unreal(values: Any) -> str | None:
    """Name why `values` are not real numbers; None if they are, or are no numbers at all."""
    if isinstance(values, list | tuple):
        if _PLAIN.issuperset(map(type, values)):  # twice as fast as one by one
            return None
        return next(filter(None, map(_unreal, values)), None)
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        return "masked entries"
    if isinstance(values, complex) or getattr(getattr(values, "dtype", None), "kind", "") == "c":
        return "complex numbers"
    return None


def as_contiguous(values: ArrayLike, dtype: DTypeLike) -> NDArray[Any]:
    """`values` as kernels take arrays: C-contiguous, aligned, and that may be written to.

    Arrays that are so already are not copied. To kernels one that is read-only is of another type,
    for which they would be compiled anew. Raises what NumPy does where there are no numbers.
    """
    if type(values) is np.ndarray and values.dtype == dtype and values.flags.carray:
        return values
    return np.require(real(values), dtype, ("C", "A", "W", "E"))


def as_points(values: ArrayLike, name: str = "points") -> FloatArray:
    """`values` as a C-contiguous (n, 3) float64 array (a view where it is one already).

    A single point ``(3,)`` becomes one row. Not-finite entries pass: they are marked row by row.
    """
    if (
        type(values) is np.ndarray
        and values.shape[1:] == (3,)
        and values.dtype == np.float64
        and values.flags.carray
    ):
        return values  # most of what comes
    return _as_rows(values, name, 3, "(n, 3)")


def as_parameters(values: ArrayLike) -> FloatArray:
    """`values` as a C-contiguous (k, 2) float64 array; a single pair becomes one row."""
    return _as_rows(values, "uv", 2, "(k, 2)")


def _as_rows(values: ArrayLike, name: str, columns: int, shape: str) -> FloatArray:
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
    """A C-contiguous float64 copy of `values`; `what` they must be says the error."""
    real(values, where)
    try:
        return np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise InputError(what, where=where, found=values, allowed=allowed) from error


def read_only(array: FloatArray) -> FloatArray:
    """A C-contiguous copy of `array` that cannot be written to."""
    copy = np.array(real(array), dtype=np.float64, order="C")
    copy.flags.writeable = False
    return copy


def locked(values: AnyArray) -> AnyArray:
    """A view of what may be read and not changed.

    To numba that is another type than an array that may: kernels that read what users hand over,
    which may be either, are handed this, and have one version.
    """
    view = values.view()
    view.setflags(write=False)  # half the time of view.flags.writeable = False
    return view


def positive(value: object, name: str, *, finite: bool = True) -> float:
    """`value` as a number above zero, a finite one where not said otherwise."""
    allowed = "a finite number > 0" if finite else "a number > 0"
    try:
        number = value if type(value) is float else float(real(value))
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError("must be a number", where=name, found=value, allowed=allowed) from error
    if not number > 0.0 or (finite and number == np.inf):
        raise InputError("must be positive", where=name, found=value, allowed=allowed)
    return number


def not_negative(value: object, name: str) -> float:
    """Return `value` as a finite number ≥ 0, which errors call `name`."""
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


def one_of(where: str, value: object, allowed: tuple[str, ...]) -> str:
    """`value` as one of the words `allowed`."""
    if not isinstance(value, str) or value not in allowed:
        raise InputError(
            "is not known", where=where, found=value, allowed=", ".join(map(repr, allowed))
        )
    return value


def all_of(
    kinds: type | tuple[type, ...] | UnionType,
    given: Iterable[object],
    where: str,
    what: str,
    allowed: str,
) -> None:
    """Refuse the first of several that is of another kind: `what` they must be."""
    for k, one in enumerate(given):
        if not isinstance(one, kinds):
            raise InputError(what, where=f"{where}[{k}]", found=type(one).__name__, allowed=allowed)


def bytes_of(value: object) -> int:
    """Memory of all arrays in a record, and in the records it holds.

    >>> bytes_of((np.zeros(3), (np.zeros(2, np.int32), "text")))
    32
    """
    if isinstance(value, np.ndarray):
        return value.nbytes
    if isinstance(value, tuple):
        return sum(bytes_of(entry) for entry in value)
    return 0
