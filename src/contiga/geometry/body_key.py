"""Key of a body in the disk caches of results computed from it."""

from __future__ import annotations

from contiga.arrays.digest import Digest
from contiga.arrays.once import once
from contiga.geometry.faces_like import FacesLike

MIN_PATCHES, MIN_POINTS = 8, 1_000
"""Numbers of patches and of control points from which the disk cache is faster than to compute."""


def key_of(body: FacesLike) -> str | None:
    """Return a digest of the data that results depend on; None for a small body: it is not cached.

    A body is small below both `MIN_PATCHES` patches and `MIN_POINTS` control points.
    """
    points = sum(patch.control_points[..., 0].size for patch in body.patches)
    return None if len(body.patches) < MIN_PATCHES and points < MIN_POINTS else _digest_of(body)


@once
def _digest_of(body: FacesLike) -> str:
    """Return the digest of geometry, unit, `pieces_apart` and gaps of edges; computed once."""
    digest = Digest()
    body.digest(digest)
    digest.text(repr((body.unit, body.pieces_apart, [edge.gap for edge in body.edges])))
    return digest.hexdigest()
