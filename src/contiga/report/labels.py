"""Texts of a picture moved apart, so that none lies on another."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray


def spread(places: FloatArray, sizes: FloatArray, room: FloatArray) -> FloatArray:
    """Return centres of texts near their `places`, inside the picture and off each other.

    The higher ones are set first; each goes down until it is free, then up if it must.

    Parameters
    ----------
    places : (n, 2) columns and rows, pixels, wanted middles
    sizes : (n, 2) widths and heights
    room : (2,) width and height of the picture

    >>> wanted, sizes = np.array([[50.0, 50.0], [52.0, 50.0]]), np.full((2, 2), 20.0)
    >>> spread(wanted, sizes, room=np.array([99.0, 99.0]))
    array([[50., 50.],
           [52., 71.]])
    """
    middles = np.clip(places, 0.5 * sizes, np.maximum(room - 0.5 * sizes, 0.5 * sizes))
    done: list[int] = []
    for k in np.argsort(places[:, 1], kind="stable"):
        for way in (1.0, -1.0):
            at = middles[k].copy()
            while (other := _under(at, sizes[k], middles[done], sizes[done])) is not None:
                at[1] = other[0] + way * (other[1] + 0.5 * sizes[k, 1] + 1.0)
            if 0.5 * sizes[k, 1] <= at[1] <= room[1] - 0.5 * sizes[k, 1]:
                break
        middles[k] = at
        done.append(int(k))
    return middles


def _under(
    at: FloatArray, size: FloatArray, middles: FloatArray, sizes: FloatArray
) -> tuple[float, float] | None:
    """Return row and half height of a text that a text at `at` would overlap."""
    if len(middles) == 0:
        return None
    meet = (np.abs(middles - at) < 0.5 * (sizes + size)).all(axis=1)
    if not meet.any():
        return None
    k = int(meet.argmax())
    return float(middles[k, 1]), float(0.5 * sizes[k, 1])
