"""The protocol of matter, which has mass and deforms: degrees of freedom and their forces.

Degrees of freedom are rows q (m, 3): nodes of finite elements, control points of splines, or those
of another solver. The nodes of the slave, used by contacts, are x = N q; forces f on them become
Nᵀ f.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from contiga.records import FloatArray


class MatterState(NamedTuple):
    """State of matter that its next step needs: arrays only."""

    points: FloatArray
    """(m, 3) degrees of freedom at the end of the last step."""
    memory: FloatArray
    """(h,) history variables of its materials, in an order that the matter chooses."""


class MatterEnergy(NamedTuple):
    """Energies of matter: stored strain and hourglass energy, and the losses of one step."""

    strain: float = 0.0
    """Recoverable energy in the material."""
    hourglass: float = 0.0
    """Energy in the springs of the hourglass modes."""
    viscosity: float = 0.0
    """Loss in the step by rate effects: bulk viscosity, rate tables, damping."""
    hysteresis: float = 0.0
    """Loss in the step by hysteresis of materials."""


class MatterForces(NamedTuple):
    """Forces and energies of matter at given values of its degrees of freedom."""

    force: FloatArray
    """(m, 3) on each degree of freedom, in the direction of falling stored energy."""
    energy: MatterEnergy
    state: MatterState
    """State at the end of the step."""


class Matter(Protocol):
    """Matter of a slave that deforms."""

    @property
    def mass(self) -> FloatArray:
        """Lumped mass (m,) of each degree of freedom."""

    def points(self, q: FloatArray) -> FloatArray:
        """Return x = N q (n, 3), or velocities N v; `q` itself if N is the identity."""

    def spread(self, f: FloatArray) -> FloatArray:
        """Return forces f on the points (n, 3) as forces Nᵀ f (m, 3) on degrees of freedom."""

    def start(self) -> MatterState:
        """Return the state before any motion."""

    def forces(self, state: MatterState, q: FloatArray, v: FloatArray, dt: float) -> MatterForces:
        """Return the forces at the end of a step of length `dt` from `state` to q.

        Parameters
        ----------
        state : state at the start of the step, not changed
        q, v : (m, 3) degrees of freedom at the end of the step, and velocities for rate effects;
            the returned state contains q itself, not a copy
        dt : length of the step; 0 before any motion

        Raises
        ------
        ElementError
            An element has turned inside out.
        """

    def stiffness(self, state: MatterState) -> FloatArray:
        """Return row sums (m,) ``Σ_j |K_ij|``, the largest of the three directions of each row.

        By Gershgorin's theorem the critical step is at least ``min 2 √(m_i / Σ_j |K_ij|)``.
        """
