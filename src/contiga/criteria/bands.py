"""Bands of a rating protocol: from the value of a criterion to a word such as "green"."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from contiga.criteria.samples import numbers
from contiga.errors import InputError


@dataclass(frozen=True, init=False)
class Bands:
    """Values up to the first limit, from there to the second, and so on.

    Protocols differ from year to year: none is built in.

    Parameters
    ----------
    limits : (n,) rising; a value that is a limit belongs to the band above it
    names : n + 1 names, from the lowest band to the highest

    Raises
    ------
    InputError
        Limits that do not rise or are not finite, another number of names.

    >>> head = Bands([650, 1000, 1350, 1700], ["green", "yellow", "orange", "brown", "red"])
    >>> head.of(649.9), head.of(650), head.of(2000)
    ('green', 'yellow', 'red')
    """

    limits: tuple[float, ...]
    names: tuple[str, ...]

    def __init__(self, limits: Iterable[float], names: Iterable[str]) -> None:
        rising, words = numbers(list(limits), "bands, limits"), tuple(names)
        finite = rising.ndim == 1 and len(rising) > 0 and bool(np.isfinite(rising).all())
        if not finite or not (np.diff(rising) > 0.0).all():
            raise InputError(
                "must rise", where="limits", found=rising.tolist(), allowed="finite numbers"
            )
        if len(words) != len(rising) + 1 or not all(isinstance(w, str) and w for w in words):
            raise InputError(
                "expected one name more than limits",
                where="names",
                found=words,
                allowed=f"{len(rising) + 1} words",
            )
        object.__setattr__(self, "limits", tuple(rising.tolist()))
        object.__setattr__(self, "names", words)

    def of(self, value: float) -> str:
        """The name of the band that a value is in.

        Raises
        ------
        InputError
            It is NaN, which is in none, or not a number.
        """
        number = numbers(value, "bands, value")
        if number.shape != () or np.isnan(number):
            raise InputError("is in no band", where="bands, value", found=value, allowed="a number")
        return self.names[int(np.searchsorted(self.limits, number, side="right"))]
