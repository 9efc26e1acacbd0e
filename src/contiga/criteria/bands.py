"""Bands of a rating protocol: from the value of a criterion to a word such as "green"."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from contiga.criteria.samples import numbers
from contiga.errors import InputError


@dataclass(frozen=True, init=False)
class Bands:
    """Bands of values between limits, with a name each.

    Protocols differ from year to year: none is built in.

    Parameters
    ----------
    limits : (n,) rising; a value that is a limit belongs to the band above it
    names : names of the n + 1 bands, from the lowest to the highest

    Raises
    ------
    InputError
        Limits that do not rise, are not finite or none; another number of names, an empty name.

    >>> head = Bands([650, 1000, 1350, 1700], ["green", "yellow", "orange", "brown", "red"])
    >>> head.of(649.9), head.of(650), head.of(2000)
    ('green', 'yellow', 'red')
    """

    limits: tuple[float, ...]
    names: tuple[str, ...]

    def __init__(self, limits: Iterable[float], names: Iterable[str]) -> None:
        values, words = numbers(list(limits), "bands, limits"), tuple(names)
        is_finite = values.ndim == 1 and len(values) > 0 and bool(np.isfinite(values).all())
        if not is_finite or not (np.diff(values) > 0.0).all():
            raise InputError(
                "must rise", where="limits", found=values.tolist(), allowed="finite numbers"
            )
        if len(words) != len(values) + 1 or not all(isinstance(w, str) and w for w in words):
            raise InputError(
                "expected one name more than limits",
                where="names",
                found=words,
                allowed=f"{len(values) + 1} words",
            )
        object.__setattr__(self, "limits", tuple(values.tolist()))
        object.__setattr__(self, "names", words)

    def of(self, value: float) -> str:
        """Return the name of the band of a value, which may be infinite.

        Raises
        ------
        InputError
            The value is NaN or not a number.
        """
        number = numbers(value, "bands, value")
        if number.shape != () or np.isnan(number):
            raise InputError("is in no band", where="bands, value", found=value, allowed="a number")
        return self.names[int(np.searchsorted(self.limits, number, side="right"))]
