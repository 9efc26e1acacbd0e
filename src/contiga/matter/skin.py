"""The outer faces of elements, as triangles whose normals point outward."""

from __future__ import annotations

import numpy as np

from contiga.records import IntArray

FACES = {
    "tet4": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    "hex8": (
        (0, 3, 2, 1),
        (4, 5, 6, 7),
        (0, 1, 5, 4),
        (1, 2, 6, 5),
        (2, 3, 7, 6),
        (3, 0, 4, 7),
    ),
    "tri3": ((0, 1, 2),),
}


def skin(parts: list[tuple[str, IntArray]]) -> IntArray:
    """Return the outer triangles (f, 3) of elements, given by kind and corners.

    Faces that two solids share are inside; membranes come as they are.
    """
    inside: list[IntArray] = []
    outside: list[IntArray] = []
    for kind, elements in parts:
        faces = FACES.get(kind, ())
        if kind == "tri3":
            outside.append(elements)
        elif faces:
            inside.append(elements[:, np.array(faces)].reshape(-1, len(faces[0])))
    for width in sorted({faces.shape[1] for faces in inside}):
        outside += _once(np.concatenate([faces for faces in inside if faces.shape[1] == width]))
    none = np.zeros((0, 3), np.int32)
    return np.ascontiguousarray(np.concatenate([none, *outside]), dtype=np.int32)


def _once(faces: IntArray) -> list[IntArray]:
    """Faces that occur once, cut into triangles."""
    _, index, counts = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    single = faces[np.sort(index[counts == 1])]
    return [single[:, [0, k, k + 1]] for k in range(1, single.shape[1] - 1)]
