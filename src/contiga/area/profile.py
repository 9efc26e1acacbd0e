"""Bodies of plane problems."""

from __future__ import annotations

import numpy as np

from contiga.geometry.body import Body
from contiga.triangles.trimesh import TriMesh


def profile_depth(body: Body | TriMesh) -> float | None:
    """Depth of a body made by `Body.from_profile`, None for any other."""
    if isinstance(body, TriMesh) or len(body.patches) != 1 or body.trims[0] is not None:
        return None
    patch = body.patches[0]
    net = patch.control_points
    if patch.degrees[1] != 1 or net.shape[1] != 2:
        return None
    v0, v1 = patch.domain[1]
    step = net[:, 1] - net[:, 0]
    same = np.abs(step - (0.0, 0.0, v1 - v0)).max() <= 1e-12 * (v1 - v0)
    about = v0 == -v1 and np.abs(net[:, 0, 2] - v0).max() <= 1e-12 * (v1 - v0)
    return float(v1 - v0) if same and about else None
