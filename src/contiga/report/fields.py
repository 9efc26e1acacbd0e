"""Fields over time in the form that the report reads."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any, Protocol

from numpy.typing import NDArray

from contiga.io.out.vtkhdf_layout import Part
from contiga.records import FloatArray


class RecordedFields(Protocol):
    """Fields at each recorded step: a `FieldSeries`, or one that caches its reads."""

    @property
    def times(self) -> FloatArray:
        """The times (n,) of the steps."""

    @property
    def parts(self) -> tuple[Part, ...]:
        """Bodies and slaves in the order in which their points are stacked."""

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the point data."""

    def held(self) -> AbstractContextManager[None]:
        """Hold the file open for many reads."""

    def points(self, i: int) -> FloatArray:
        """Return the points (N, 3) of all parts at step `i`."""

    def data(self, i: int, name: str) -> NDArray[Any]:
        """Return the point data (N,) or (N, k) at step `i`."""

    def rows(self, part: str) -> slice:
        """Return the rows of a part among the stacked points."""


class ReadOnce:
    """Fields that keep the arrays read at the last step, for repeated reads of it.

    A read at another step drops them. A step of a scene asks five times for the points and three
    times for the statuses, which took two fifths of its time. The arrays returned are shared, and
    cannot be written to.
    """

    def __init__(self, series: RecordedFields) -> None:
        self._series = series
        self._step = -1
        self._arrays: dict[str, NDArray[Any]] = {}
        self.times, self.parts, self.names = series.times, series.parts, series.names
        self.rows, self.held = series.rows, series.held

    def points(self, i: int) -> FloatArray:
        """Return the points (N, 3) of all parts at step `i`."""
        return self._once(i, "", lambda: self._series.points(i))

    def data(self, i: int, name: str) -> NDArray[Any]:
        """Return the point data (N,) or (N, k) at step `i`."""
        return self._once(i, name, lambda: self._series.data(i, name))

    def _once(self, i: int, name: str, read: Callable[[], NDArray[Any]]) -> NDArray[Any]:
        if i != self._step:
            self._step, self._arrays = i, {}
        if name not in self._arrays:
            self._arrays[name] = read()
            self._arrays[name].flags.writeable = False
        return self._arrays[name]
