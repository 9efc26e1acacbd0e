"""Foretell the size of a mesh of a body: a tolerance that is far off takes minutes."""

from __future__ import annotations

import math
import sys

from contiga.errors import InputError
from contiga.geometry.tessellate import MAX_CELLS
from contiga.masters.body import Body

COARSE = 1e-4
"""Of the size of a body: a tolerance that takes less than a second, and tells of finer ones."""
MANY = 2e6
"""Triangles from which on it is told how many there will be."""
MAX_TRIANGLES = 2.0 * MAX_CELLS
"""Largest number of triangles of a mesh."""


def foretell(body: Body, tol: float) -> None:
    """Say how many triangles a mesh by chord height takes, where they are many.

    Their number goes with a power of 1/`tol`: 1 where faces are curved two ways, ½ where one way, 0
    where they are flat. Two coarse meshes say which.

    Raises
    ------
    InputError
        More of them than a mesh has.
    """
    coarse = COARSE * body.size
    if tol >= 0.1 * coarse:
        return
    many, few = (len(body.tessellate(factor * coarse).triangles) for factor in (1.0, 4.0))
    power = min(max(math.log(many / few) / math.log(4.0), 0.0), 1.0)
    count = many * (coarse / tol) ** power
    if count <= MANY or power < 0.05:  # flat: of no tolerance many
        return

    def takes(most: float) -> float:
        """The tolerance at which there are so many."""
        return coarse * (many / most) ** (1.0 / power)

    if count > MAX_TRIANGLES:
        raise InputError(
            f"about {count:.2g} triangles would be as near to {body.name}, which is "
            f"{body.size:.3g} large",
            where="--tol",
            found=tol,
            allowed=f"about {takes(MAX_TRIANGLES):.1g} or more, "
            f"which makes {MAX_TRIANGLES:.2g} triangles",
            remedy="Look at its unit: that of the mesh",
        )
    print(
        f"contiga: about {count:.2g} triangles, which takes minutes; --tol {takes(MANY):.1g} takes "
        f"{MANY:.2g}",
        file=sys.stderr,
        flush=True,
    )
