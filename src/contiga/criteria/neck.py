"""The neck injury criterion of force and moment in the upper neck."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import positive
from contiga.criteria.samples import finite_rows, numbers
from contiga.errors import InputError


class NeckLimits(NamedTuple):
    """Intercepts of a dummy: the force alone, or the moment alone, that gives the criterion 1."""

    tension: float
    """Force, N."""
    compression: float
    """Force, N."""
    flexion: float
    """Moment, N·m."""
    extension: float
    """Moment, N·m."""


HYBRID_III_50 = NeckLimits(6806.0, 6160.0, 310.0, 135.0)
"""Intercepts of the mid-size male, in position (FMVSS 208, S6.6)."""
HYBRID_III_5 = NeckLimits(4287.0, 3880.0, 155.0, 67.0)
"""Intercepts of the small female, in position (FMVSS 208, S15.3.6)."""
_MODES = ("NTF", "NTE", "NCF", "NCE")


class Nij(NamedTuple):
    """The criterion, its sample, and the load of the neck there."""

    value: float
    sample: int
    """Sample at which it is reached."""
    mode: str
    """"NTF", "NTE", "NCF" or "NCE": tension or compression with flexion or extension."""


def nij(
    force: ArrayLike, moment: ArrayLike, limits: NeckLimits | Sequence[float] = HYBRID_III_50
) -> Nij:
    """Return the maximum of F_z / F_int + M_y / M_int over time, with the sample and kind of load.

    Each sample has one kind of load; zero counts as tension and as flexion. Of equal maxima the
    first is returned.

    Eppinger et al., Development of Improved Injury Criteria for the Assessment of Advanced
    Automotive Restraint Systems II, NHTSA (1999); FMVSS 208, S6.6.

    Parameters
    ----------
    force : (n,) axial force, tension positive, N, filtered by CFC600
    moment : (n,) moment about y at the occipital condyle, flexion positive, N·m, filtered by CFC600
    limits : intercepts of tension, compression, flexion and extension, all positive

    Raises
    ------
    InputError
        Lists of different lengths, or not finite; intercepts that are not four, or not positive.

    >>> nij([0.0, 3403.0], [0.0, -67.5])
    Nij(value=1.0, sample=1, mode='NTE')
    """
    f, m = numbers(force, "nij, force"), numbers(moment, "nij, moment")
    if f.ndim != 1 or f.shape != m.shape or len(f) == 0:
        raise InputError(
            "force and moment must have the same length",
            where="nij",
            found=(f.shape, m.shape),
            allowed="shapes (n,) and (n,)",
        )
    finite_rows(f, "nij, force")
    finite_rows(m, "nij, moment")
    try:
        intercepts = NeckLimits(*limits)._asdict()
    except TypeError as error:
        raise InputError(
            "must be four intercepts",
            where="nij, limits",
            found=limits,
            allowed=", ".join(NeckLimits._fields),
        ) from error
    limits = NeckLimits(*(positive(x, f"nij, limits.{name}") for name, x in intercepts.items()))
    axial = np.where(f >= 0.0, f / limits.tension, -f / limits.compression)
    bending = np.where(m >= 0.0, m / limits.flexion, -m / limits.extension)
    k = int(np.argmax(axial + bending))
    mode = _MODES[2 * int(f[k] < 0.0) + int(m[k] < 0.0)]
    return Nij(float(axial[k] + bending[k]), k, mode)
