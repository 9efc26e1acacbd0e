"""What kernels are handed that work out forces and where the work went."""

from __future__ import annotations

from typing import NamedTuple

from contiga.records import FloatArray, IndexArray


class Column(NamedTuple):
    """Values of some points; of others they are zero."""

    rows: IndexArray
    """(k,) the points, ascending."""
    values: FloatArray
    """(k, …)."""


class Answer(NamedTuple):
    """What law and friction say of k points that carry; no rows of what is not told."""

    force: FloatArray
    """(k,) along the normals."""
    stored: FloatArray
    hysteresis: FloatArray
    damping: FloatArray
    """(k,) the part of `force` that is due to the rate."""
    friction: FloatArray
    """(k, 3) forces across the normals, with energies stored and lost by them."""
    held: FloatArray
    lost: FloatArray


class LastForces(NamedTuple):
    """What was at the last step."""

    force: Column
    normal: Column
    traction: Column
    damping: Column
    energies: FloatArray
    """(5,) as `ContactEnergy` has them."""
    points: FloatArray
    """(n, 3) where all points were, body axes."""
    none: Column
    """Forces of no points."""


class Frame(NamedTuple):
    """Of the body."""

    pose: FloatArray
    """(4, 4) X_WB."""
    reference_point: FloatArray
    """(3,) that moments are about, body axes."""


class Felt(NamedTuple):
    """To be filled: what k points that carry feel, and what that sums up to."""

    force: FloatArray
    """(k, 3) world axes."""
    viscosity: FloatArray
    """(k,) damping over the rate of penetration."""
    totals: FloatArray
    """The wrench on the body, and the energies with what the step adds."""
