"""The protocol of matter, which has mass and deforms: degrees of freedom and their forces.

Degrees of freedom are rows q (m, 3): nodes of finite elements, control points of splines, or what
another solver moves. The nodes of the slave, which contact sees, are x = N q; forces on them come
back as Nᵀ f.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from contiga.records import FloatArray


class MatterState(NamedTuple):
    """Matter at one time, as far as its next step needs it: arrays only."""

    points: FloatArray
    """(m, 3) degrees of freedom at the end of the last step."""
    memory: FloatArray
    """(h,) memory of its materials, in an order of the matter's own."""


class MatterEnergy(NamedTuple):
    """Energies of matter. Strain and hourglass are states; the others are of one step."""

    strain: float = 0.0
    """Stored in the material: what it would give back."""
    hourglass: float = 0.0
    """Stored in the springs of the hourglass modes."""
    viscosity: float = 0.0
    """Lost in the step to what resists a rate: bulk viscosity, rate tables, damping."""
    hysteresis: float = 0.0
    """Lost in the step to materials that unload by another curve than they load."""


class MatterForces(NamedTuple):
    """Forces and energies of matter at one place of its degrees of freedom."""

    force: FloatArray
    """(m, 3) on each degree of freedom: what is stored decreases along it."""
    energy: MatterEnergy
    state: MatterState
    """At the end of the step."""


class Matter(Protocol):
    """Matter as everything around it uses it."""

    @property
    def mass(self) -> FloatArray:
        """Lumped mass (m,) of each degree of freedom."""

    def points(self, q: FloatArray) -> FloatArray:
        """Return x = N q (n, 3), or velocities N v: `q` itself where N is the identity."""

    def spread(self, f: FloatArray) -> FloatArray:
        """Return forces f on the points (n, 3) as forces Nᵀ f (m, 3) on degrees of freedom."""

    def start(self) -> MatterState:
        """Return the state before any motion."""

    def forces(self, state: MatterState, q: FloatArray, v: FloatArray, dt: float) -> MatterForces:
        """Return the forces at the end of a step of length `dt` from `state` to q.

        Parameters
        ----------
        state : where the step begins; it is left as it is
        q, v : (m, 3) degrees of freedom at the end of the step, and their velocities, which what
            resists a rate is asked with; the state answered holds q itself, not a copy
        dt : length of the step; 0 where nothing has moved yet

        Raises
        ------
        ElementError
            An element has turned inside out.
        """

    def stiffness(self, state: MatterState) -> FloatArray:
        """Return row sums (m,) ``Σ_j |K_ij|``, the largest of the three directions of each row.

        By Gershgorin's theorem the critical step is at least ``min 2 √(m_i / Σ_j |K_ij|)``.
        """
