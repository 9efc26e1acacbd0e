"""The viscous criterion of a chest's deflection."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import positive
from contiga.criteria.samples import finite_rows, numbers
from contiga.errors import InputError

MIN_SAMPLES = 5
"""Smallest number of samples: the velocity needs two on either side."""


class Viscous(NamedTuple):
    """The criterion, and its time."""

    value: float
    """Criterion, m/s."""
    time: float
    """Time from the first sample, seconds."""


def vc(deflection: ArrayLike, dt: float, *, scale: float = 1.3, depth: float = 0.229) -> Viscous:
    """Return the maximum of scale · dD/dt · D / depth (VC, V*C), and its time.

    Lau and Viano, The Viscous Criterion, SAE 861882 (1986); by UN R94, annex 4, 6, and SAE J1727
    dD/dt = (8 (D_k+1 − D_k−1) − (D_k+2 − D_k−2)) / (12 dt), which is exact for polynomials to the
    fourth degree. The two samples at either end, which have no such velocity, do not count. Of
    equal maxima the first gives the time, counted from the first sample.

    Parameters
    ----------
    deflection : (n,) deflection of the chest, compression positive, metres, filtered by CFC180
    dt : time between samples, seconds
    scale, depth : 1.3 and 0.229 m for the Hybrid III mid-size male; 1.0 and 0.140 m for the EuroSID

    Raises
    ------
    InputError
        Fewer than five samples, samples that are not finite, numbers that are not positive.

    >>> ramp = [0.0, 0.01, 0.02, 0.03, 0.04]
    >>> round(vc(ramp, 0.01, scale=1.0, depth=0.1).value, 12), vc(ramp, 0.01).time
    (0.2, 0.02)
    """
    D, step = numbers(deflection, "vc, deflection"), positive(dt, "vc, dt")
    factor = positive(scale, "vc, scale") / positive(depth, "vc, depth")
    if D.ndim != 1 or len(D) < MIN_SAMPLES:
        raise InputError(
            "five samples at least are needed, in one list",
            where="vc, deflection",
            found=D.shape,
            allowed="shape (n,)",
        )
    finite_rows(D, "vc, deflection")
    velocity = (8.0 * (D[3:-1] - D[1:-3]) - (D[4:] - D[:-4])) / (12.0 * step)
    product = factor * velocity * D[2:-2]
    k = int(np.argmax(product))
    return Viscous(float(product[k]), (k + 2) * step)
