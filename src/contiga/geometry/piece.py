"""Some faces of a body as a body of their own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from contiga.geometry.faces import Faces

SomeFaces = TypeVar("SomeFaces", bound=Faces)


def piece_of(body: SomeFaces, patches: Sequence[int]) -> SomeFaces:
    """Return the faces `patches` of `body` as a body, with the edges that only they use.

    Name and unit stay; the reference point is the origin.

    >>> from contiga.geometry import shapes
    >>> two = Faces([shapes.sphere(), shapes.plane()])
    >>> piece_of(two, [1]).bounds()[1].tolist()
    [0.5, 0.5, 0.0]
    """
    new_numbers = {patch: k for k, patch in enumerate(patches)}
    edges = []
    for edge in body.edges:
        if all(use.patch in new_numbers for use in edge.uses):
            uses = tuple(use._replace(patch=new_numbers[use.patch]) for use in edge.uses)
            edges.append(edge._replace(uses=uses))
    return type(body)(
        [body.patches[k] for k in patches],
        name=body.name,
        trims=[body.trims[k] for k in patches],
        edges=edges,
        unit=body.unit,
    )
