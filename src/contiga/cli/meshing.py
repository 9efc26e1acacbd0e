"""Estimate the size of a mesh of a body: a tolerance that is much too small takes minutes."""

from __future__ import annotations

import math
import sys

from contiga.errors import InputError
from contiga.geometry.tessellate import MAX_CELLS
from contiga.masters.body import Body

COARSE_TOL = 1e-4
"""Tolerance of a coarse mesh, over the size of the body: it takes less than a second."""
LARGE_COUNT = 2e6
"""Number of triangles above which a message says how many there will be."""
MAX_TRIANGLES = 2.0 * MAX_CELLS
"""Largest number of triangles of a mesh."""


def foretell(body: Body, tol: float) -> None:
    """Print on the error stream how many triangles a mesh by chord height takes, above 2 million.

    Their number is proportional to a power of 1/`tol`: 1 for faces curved two ways, ½ for one way,
    0 for flat faces. Two coarse meshes give the power. Nothing is estimated for a `tol` of at least
    1e-5 of the size of the body.

    Raises
    ------
    InputError
        The mesh would have more than `MAX_TRIANGLES`.
    """
    coarse_tol = COARSE_TOL * body.size
    if tol >= 0.1 * coarse_tol:
        return
    fine, coarse = (len(body.tessellate(k * coarse_tol).triangles) for k in (1.0, 4.0))
    power = min(max(math.log(fine / coarse) / math.log(4.0), 0.0), 1.0)
    count = fine * (coarse_tol / tol) ** power
    if count <= LARGE_COUNT or power < 0.05:  # flat faces: few triangles at any tolerance
        return
    large_tol, max_tol = (
        coarse_tol * (fine / n) ** (1.0 / power) for n in (LARGE_COUNT, MAX_TRIANGLES)
    )
    if count > MAX_TRIANGLES:
        raise InputError(
            f"about {count:.2g} triangles would be as near to {body.name}, which is "
            f"{body.size:.3g} large",
            where="--tol",
            found=tol,
            allowed=f"about {max_tol:.1g} or more, which makes {MAX_TRIANGLES:.2g} triangles",
            remedy="Look at its unit: that of the mesh",
        )
    print(
        f"contiga: about {count:.2g} triangles, which takes minutes; --tol {large_tol:.1g} takes "
        f"{LARGE_COUNT:.2g}",
        file=sys.stderr,
        flush=True,
    )
