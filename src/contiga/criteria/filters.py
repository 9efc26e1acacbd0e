"""Channel frequency classes: the phaseless low-pass filters of SAE J211-1 and ISO 6487."""

from __future__ import annotations

import math
import warnings

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import positive
from contiga.criteria.kernels import two_poles_nb
from contiga.criteria.samples import finite_rows, numbers
from contiga.errors import ContigaWarning, InputError
from contiga.records import FloatArray

CLASSES = (60, 180, 600, 1000)
NAMES = tuple(f"CFC{number}" for number in CLASSES)
MIN_RATE = 10
"""Smallest sample rate for each Hz of the class, 1/s; lower ones leave the corridor of gains."""
SETTLING = 0.75
"""Settling time of a step to 1e-3, seconds times the class: poles decay by 9.23 · class a second.
The ends of shorter signals have errors of up to a fifth of their size, of longer ones 2e-3."""
_PAD_TIME, _PAD_SAMPLES = 0.01, 100
"""Smallest length of the images at both ends, seconds and samples."""


def cfc(signal: ArrayLike, dt: float, cls: int | str) -> FloatArray:
    """Return `signal` filtered by a channel frequency class, without a shift in time.

    The digital filter of SAE J211-1 (appendix C; ISO 6487, annex A): a Butterworth filter of two
    poles that runs forward and backward, so four poles without phase. Its gain is 1/√2 (−3 dB) at
    class / 0.6.

    At both ends the signal continues as its image turned by half a turn about the end sample, for
    10 ms and 100 samples at least, or for its own length if that is less, as in ISO 6487; the
    filter starts settled on the first value there. So a constant does not change, and a signal that
    starts at a value or with a slope does not ring.

    Parameters
    ----------
    signal : (n,) or (n, k), a channel in each column
    dt : time between samples, seconds
    cls : 60, 180, 600 or 1000, or "CFC60" …

    Returns
    -------
    array
        shape of `signal`

    Raises
    ------
    InputError
        An unknown class, a signal that is empty or not finite, fewer than 10 samples a second for
        each Hz of the class.

    Warns
    -----
    ContigaWarning
        The signal is shorter than the filter's settling time, 0.75 s / class (12.5 ms for CFC60),
        and not constant: the result depends on its images at the ends, by up to a fifth of its
        size.

    >>> cfc([5.0, 5.0, 5.0], 1e-4, "CFC1000").tolist()
    [5.0, 5.0, 5.0]
    """
    values = numbers(signal, "cfc, signal")
    if values.ndim not in (1, 2) or values.size == 0:
        raise InputError(
            "a signal must have samples",
            where="cfc, signal",
            found=values.shape,
            allowed="shape (n,) or (n, k)",
        )
    finite_rows(values, "cfc, signal")
    text = str(cls).upper().removeprefix("CFC").strip()
    number = next((k for k in CLASSES if text in (str(k), f"{k}.0")), None)
    if number is None or isinstance(cls, bool):
        raise InputError(
            "an unknown channel frequency class",
            where="cfc, cls",
            found=cls,
            allowed="60, 180, 600, 1000, or CFC60 and so on",
        )
    step = positive(dt, "cfc, dt")
    if step * MIN_RATE * number > 1.0 + 1e-9:
        raise InputError(
            f"too few samples for CFC{number}",
            where="cfc, dt",
            found=step,
            allowed=f"at most {1.0 / (MIN_RATE * number):.6g} s",
            remedy="dt is in seconds",
        )
    if is_short(len(values), step, number) and np.ptp(values, axis=0).any():
        warnings.warn(
            f"the signal is shorter than the memory of CFC{number}, {settling_time(number):.3g} s: "
            "its ends may be off by a fifth of its size",
            ContigaWarning,
            stacklevel=2,
        )
    a, b = coefficients(number, step)
    pad = min(max(math.ceil(_PAD_TIME / step), _PAD_SAMPLES), len(values) - 1)
    before = 2.0 * values[:1] - values[pad:0:-1]
    after = 2.0 * values[-1:] - values[-2 : -2 - pad : -1]
    padded = np.ascontiguousarray(np.concatenate([before, values, after]))
    two_poles_nb.forward_and_back(padded.reshape(len(padded), -1), a, b)
    return np.ascontiguousarray(padded[pad : pad + len(values)])


def settling_time(cls: int) -> float:
    """Return the settling time of the filter of a class, seconds."""
    return SETTLING / cls


def is_short(samples: int, dt: float, cls: int) -> bool:
    """Return whether a signal of `samples` values is shorter than the settling time of a filter."""
    return (samples - 1) * dt < settling_time(cls)


def coefficients(cls: int, dt: float) -> tuple[FloatArray, FloatArray]:
    """Return the coefficients (a0, a1, a2) and (b1, b2) of the filter of a class.

    It is Y_k = a0 X_k + a1 X_k−1 + a2 X_k−2 + b1 Y_k−1 + b2 Y_k−2 (SAE J211-1, appendix C): the
    bilinear transform of a Butterworth filter, −3 dB at 2.0775 · class Hz in one pass.
    """
    w = math.tan(0.5 * dt * 2.0 * math.pi * cls * 2.0775)
    denominator = 1.0 + math.sqrt(2.0) * w + w * w
    a0 = w * w / denominator
    b1 = -2.0 * (w * w - 1.0) / denominator
    b2 = (-1.0 + math.sqrt(2.0) * w - w * w) / denominator
    return np.array([a0, 2.0 * a0, a0]), np.array([b1, b2])
