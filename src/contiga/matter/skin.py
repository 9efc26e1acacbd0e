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
    """Return the outer triangles (f, 3) of elements, given by kind and corners (n, k).

    Faces of solids that occur once are outside; those of four corners are divided from their first
    corner. All membranes are part of the skin, first; bars are not.
    """
    solid_faces: list[IntArray] = []
    triangles: list[IntArray] = [np.zeros((0, 3), np.int32)]
    for kind, elements in parts:
        faces = FACES.get(kind, ())
        if kind == "tri3":
            triangles.append(elements)
        else:
            for width in sorted({len(face) for face in faces}):
                columns = np.array([face for face in faces if len(face) == width])
                solid_faces.append(elements[:, columns].reshape(-1, width))
    for width in sorted({faces.shape[1] for faces in solid_faces}):
        of_width = np.concatenate([faces for faces in solid_faces if faces.shape[1] == width])
        _, index, counts = np.unique(
            np.sort(of_width, axis=1), axis=0, return_index=True, return_counts=True
        )
        outer = of_width[np.sort(index[counts == 1])]
        triangles += [outer[:, [0, k, k + 1]] for k in range(1, width - 1)]
    return np.ascontiguousarray(np.concatenate(triangles), dtype=np.int32)
