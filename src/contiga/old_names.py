"""Names that were others a version ago: they still answer, and a warning names the new one."""

from __future__ import annotations

import warnings
from typing import Any


class OldName:
    """An attribute's old name, for one version.

    Examples
    --------
    >>> class Body:
    ...     size = 2.0
    ...     extent = OldName("size")
    >>> import warnings
    >>> with warnings.catch_warnings(record=True) as heard:
    ...     warnings.simplefilter("always")
    ...     Body().extent
    2.0
    >>> str(heard[0].message)
    'Body.extent is called Body.size now'
    """

    def __init__(self, new: str) -> None:
        self._new = new
        self.__doc__ = f"The old name of `{new}`, for one version."
        self._old = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self._old = name

    def __get__(self, instance: object, owner: type) -> Any:
        warnings.warn(
            f"{owner.__name__}.{self._old} is called {owner.__name__}.{self._new} now",
            DeprecationWarning,
            stacklevel=2,
        )
        return getattr(owner if instance is None else instance, self._new)
