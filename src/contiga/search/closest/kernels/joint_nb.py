"""How far the surface turns where two faces meet along trimming pieces, measured at samples."""

from __future__ import annotations

import math

from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import kernel
from contiga.jit.scratch import scratch
from contiga.search.closest.kernels.global_among_nb import on_patch
from contiga.search.closest.kernels.global_nb import closest
from contiga.search.closest.kernels.pseudo_normal_nb import JOIN
from contiga.search.hierarchy.kernels.curve_nb import curve_point, surface_foot


@kernel(error_model="numpy")
def measure_pieces(tables, across, samples, measured, start, stop):
    """Into measured[piece] the largest angle between the normals along pieces start … stop,
    radians; infinite where they do not meet.

    `across` (pieces,) is the patch beyond each, −1 none; `samples` of each are taken.
    """
    h = scratch(4, 6)
    d = scratch(3, 3)
    nearest = scratch(4)
    elements = tables.elements
    for k in range(start, stop):
        measured[k] = math.inf
        if across[k] < 0 or not tables.piece_width[k] > 0.0:
            continue
        turn = 0.0
        for i in range(samples[k]):
            e, s, t = curve_point(
                elements, tables.grid, tables.trims, k, (i + 0.5) / samples[k], h, d
            )
            origin = elements.table[e]["origin"]
            point = (d[0, 0] + origin[0], d[0, 1] + origin[1], d[0, 2] + origin[2])
            n = normal_at(elements, e, s, t, h)
            reach = max(tables.piece_width[k], JOIN * tables.scale[0])
            if not math.isfinite(closest(tables, point, on_patch(across[k]), reach, nearest, h)):
                turn = math.inf
                break
            e, s, t = surface_foot(tables, nearest, h)
            m = normal_at(elements, e, s, t, h)
            sine = 0.0
            for c in range(3):
                a, b = (c + 1) % 3, (c + 2) % 3
                sine += (n[a] * m[b] - n[b] * m[a]) ** 2
            cosine = n[0] * m[0] + n[1] * m[1] + n[2] * m[2]
            turn = max(turn, math.atan2(math.sqrt(sine), cosine))
        measured[k] = turn
