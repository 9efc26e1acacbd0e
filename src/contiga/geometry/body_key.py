"""Identify a body on the disk, where what was computed from it is kept."""

from __future__ import annotations

from contiga.arrays.digest import Digest
from contiga.arrays.once import once
from contiga.geometry.faces_like import FacesLike

PATCHES, POINTS = 8, 1_000
"""Patches, or control points of all, from which on to read what was kept takes less time than to
work it out anew."""


def key_of(body: FacesLike) -> str | None:
    """Digest of all that a body is made of; None of a small one, of which nothing is kept."""
    points = sum(patch.control_points[..., 0].size for patch in body.patches)
    return None if len(body.patches) < PATCHES and points < POINTS else _digest_of(body)


@once
def _digest_of(body: FacesLike) -> str:
    digest = Digest()
    body.digest(digest)
    digest.text(repr((body.unit, body.pieces_apart, [edge.gap for edge in body.edges])))
    return digest.hexdigest()
