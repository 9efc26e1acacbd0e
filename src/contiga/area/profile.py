"""Bodies of plane problems."""

from __future__ import annotations

import numpy as np

from contiga.geometry.faces import Faces


def profile_depth(faces: Faces | None) -> float | None:
    """Return the depth of faces as `Body.from_profile` makes them, length; None for any others.

    Such faces are one untrimmed patch, linear in v along z, whose v is z, centred at z = 0.
    """
    if faces is None or len(faces.patches) != 1 or faces.trims[0] is not None:
        return None
    patch = faces.patches[0]
    net = patch.control_points
    if patch.degrees[1] != 1 or net.shape[1] != 2:
        return None
    v0, v1 = patch.domain[1]
    step = net[:, 1] - net[:, 0]
    is_extruded = np.abs(step - (0.0, 0.0, v1 - v0)).max() <= 1e-12 * (v1 - v0)
    is_centred = v0 == -v1 and np.abs(net[:, 0, 2] - v0).max() <= 1e-12 * (v1 - v0)
    return float(v1 - v0) if is_extruded and is_centred else None
