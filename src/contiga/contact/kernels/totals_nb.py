"""Sums over the points that carry forces."""

from __future__ import annotations

import numpy as np

from contiga.num.jit import kernel


@kernel()
def wrench_of(rows, force, points, about, pose):
    """(6,) sum of forces (k, 3), world axes, and their moment about `about` (3,), body axes.

    They act at points[rows], body axes; `pose` (4, 4) is that of the body.
    """
    total = np.zeros(6)
    arm = np.empty(3)
    for i in range(rows.shape[0]):
        k = rows[i]
        x, y, z = points[k, 0] - about[0], points[k, 1] - about[1], points[k, 2] - about[2]
        for c in range(3):
            arm[c] = pose[c, 0] * x + pose[c, 1] * y + pose[c, 2] * z
        f = (force[i, 0], force[i, 1], force[i, 2])
        total[0] += f[0]
        total[1] += f[1]
        total[2] += f[2]
        total[3] += arm[1] * f[2] - arm[2] * f[1]
        total[4] += arm[2] * f[0] - arm[0] * f[2]
        total[5] += arm[0] * f[1] - arm[1] * f[0]
    return total
