"""The brain injury criterion of a head's angular velocity."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.criteria.samples import finite_rows, numbers
from contiga.errors import InputError
from contiga.records import FloatArray

CRITICAL_VELOCITIES = (66.25, 56.45, 42.87)
"""Critical angular velocities about x, y and z of the head, rad/s (Takhounts et al. 2013)."""


class BrIC(NamedTuple):
    """The criterion and its parts."""

    value: float
    """Criterion, without a unit."""
    greatest: FloatArray
    """(3,) largest magnitudes of the angular velocity about x, y and z, rad/s."""


def bric(w: ArrayLike, critical: ArrayLike = CRITICAL_VELOCITIES) -> BrIC:
    """Return √ Σ (max abs ω / ω_C)² over the axes of the head, and the maxima, at any times.

    Takhounts, Craig, Moorhouse, McFadden and Hasija, Development of Brain Injury Criteria (BrIC),
    Stapp Car Crash Journal 57 (2013), 243-266; critical values for the mean of CSDM and MPS.

    Parameters
    ----------
    w : (n, 3) angular velocity in the axes of the head, rad/s, filtered by CFC60
    critical : (3,) critical angular velocities, rad/s

    Raises
    ------
    InputError
        Another shape, entries that are not finite, critical values that are not positive.

    >>> round(bric([[0.0, 0.0, 0.0], [66.25, 0.0, 0.0], [0.0, -56.45, 0.0]]).value, 6)
    1.414214
    """
    values, limits = numbers(w, "bric, w"), numbers(critical, "bric, critical")
    if values.ndim != 2 or values.shape[1] != 3 or len(values) == 0:
        raise InputError(
            "must have a row of three a sample",
            where="bric, w",
            found=values.shape,
            allowed="shape (n, 3)",
        )
    finite_rows(values, "bric, w")
    if limits.shape != (3,) or not (limits > 0.0).all():
        raise InputError(
            "must be positive", where="bric, critical", found=critical, allowed="three numbers > 0"
        )
    greatest = np.abs(values).max(axis=0)
    return BrIC(math.hypot(*(greatest / limits)), greatest)
