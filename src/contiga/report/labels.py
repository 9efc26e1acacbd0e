"""Texts of a picture moved apart, so that none lies on another."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray


def spread(places: FloatArray, sizes: FloatArray, picture_size: FloatArray) -> FloatArray:
    """Return centres (n, 2) of texts near their `places`, inside the picture and off each other.

    Texts are set from the highest place to the lowest. Each goes down in its column until it is
    free; if that takes it out of the picture, it goes up instead, even past the upper border.

    Parameters
    ----------
    places : (n, 2) preferred centres, columns and rows, pixels
    sizes : (n, 2) widths and heights
    picture_size : (2,) width and height of the picture

    >>> places, sizes = np.array([[50.0, 50.0], [52.0, 50.0]]), np.full((2, 2), 20.0)
    >>> spread(places, sizes, picture_size=np.array([99.0, 99.0]))
    array([[50., 50.],
           [52., 71.]])
    """
    centres = np.clip(places, 0.5 * sizes, np.maximum(picture_size - 0.5 * sizes, 0.5 * sizes))
    order = np.argsort(places[:, 1], kind="stable")
    for i, k in enumerate(order):
        set_texts = order[:i]
        for direction in (1.0, -1.0):
            at = centres[k].copy()
            while True:
                reach = 0.5 * (sizes[set_texts] + sizes[k])
                overlaps = (np.abs(centres[set_texts] - at) < reach).all(axis=1)
                if not overlaps.any():
                    break
                other = set_texts[overlaps.argmax()]
                step = float(0.5 * sizes[other, 1]) + 0.5 * sizes[k, 1] + 1.0
                at[1] = float(centres[other, 1]) + direction * step
            if 0.5 * sizes[k, 1] <= at[1] <= picture_size[1] - 0.5 * sizes[k, 1]:
                break
        centres[k] = at
    return centres
