"""Methods to move objects by affine maps: translation, rotation, scaling."""

from __future__ import annotations

from typing import Self

from numpy.typing import ArrayLike

from contiga.records import FloatArray
from contiga.rigid import transform


class Movable:
    """Base class with methods that move an object; a subclass defines `_moved`."""

    __slots__ = ()

    def _moved(self, matrix: FloatArray) -> Self:
        """Return the object moved by a regular affine (4, 4) matrix."""
        raise NotImplementedError

    def transformed(self, matrix: transform.PoseLike) -> Self:
        """Return a copy moved by a regular affine (4, 4) matrix, scipy `Rotation` or pair (R, t).

        The image of a point on the free side is on the free side of the image. A reflecting matrix
        alone would swap the sides, so that sides are flipped as well: u of patches, and the order
        of the corners of triangles, are reversed.

        Raises
        ------
        GeometryError
            Not a finite (4, 4) matrix whose last row is 0, 0, 0, 1, or a singular one.
        InputError
            A pair (R, t) whose R is not (3, 3), or several rotations.
        """
        return self._moved(transform.affine(matrix))

    def translated(self, d: ArrayLike) -> Self:
        """Return a copy moved by the vector `d` (3,), length.

        Raises
        ------
        GeometryError
            Not three finite numbers.
        """
        return self._moved(transform.translation(d))

    def rotated(
        self, axis: transform.Axis, angle: float, origin: ArrayLike = (0.0, 0.0, 0.0)
    ) -> Self:
        """Return a copy turned by `angle` (radians) about `axis` ("x", "y", "z" or a vector).

        The axis passes through `origin`.

        Raises
        ------
        GeometryError
            No axis, an angle or a point `origin` (3,), length, that is not finite.
        """
        return self._moved(transform.rotation(axis, angle, origin))

    def scaled(self, s: float | ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0)) -> Self:
        """Return a copy scaled by `s` > 0 about `origin` (3,), one number or one for each axis.

        Raises
        ------
        GeometryError
            A factor that is not positive, or an `origin` that is not finite.
        """
        return self._moved(transform.scaling(s, origin))
