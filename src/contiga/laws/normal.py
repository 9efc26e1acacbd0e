"""Laws of normal force: from penetration, rate and area to the force on each point in contact.

A law takes a `LawInput` and returns a `LawOutput`: the magnitude of the force along the master's
normal, its stiffness, the stored energy and the losses. No law pulls: a force is zero if its
formula is negative.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

import numpy as np

from contiga.arrays.layout import not_negative, positive
from contiga.errors import InputError
from contiga.laws.force import ForceLaw as ForceLaw
from contiga.laws.law import Law as Law
from contiga.laws.law import critical_damping, no_memory
from contiga.laws.stress import StressLaw as StressLaw
from contiga.records import DepthSlopes, LawInput, LawOutput, LawTangent


@dataclass(frozen=True)
class PenaltyLaw:
    """A spring and a damper on every point: F_i = k λ_i + c λ̇_i.

    Parameters
    ----------
    stiffness : k > 0, force / length; with `per_area` pressure / length, multiplied by A_i
    per_area : whether stiffness and damping are by unit area
    damping : c ≥ 0, force × time / length (by unit area)
    damping_ratio : ζ ≥ 0, over the critical damping of each point: adds 2 ζ √(k_i m_i) to c

    Examples
    --------
    >>> one = np.ones(1)
    >>> pressed = LawInput(0.2 * one, 0.5 * one, one, None, None, 0.0)
    >>> PenaltyLaw(10.0, damping=2.0).respond(pressed).force.tolist()  # 10 · 0.2 + 2 · 0.5
    [3.0]
    """

    stiffness: float
    _: KW_ONLY
    per_area: bool = False
    damping: float = 0.0
    damping_ratio: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffness", positive(self.stiffness, "stiffness"))
        for name in ("damping", "damping_ratio"):
            object.__setattr__(self, name, not_negative(getattr(self, name), name))

    @property
    def needs_mass(self) -> bool:
        """True with a damping ratio: critical damping depends on the mass."""
        return self.damping_ratio > 0.0

    @property
    def has_rate(self) -> bool:
        """True if the force depends on the rate: the law is damped."""
        return self.damping > 0.0 or self.damping_ratio > 0.0

    needs_thickness = False

    @property
    def needs_area(self) -> bool:
        """True if stiffness and damping are by unit area."""
        return self.per_area

    n_memory = 0

    def respond(self, inp: LawInput) -> LawOutput:
        """Return forces k λ + c λ̇, zero where they would pull, and energies k λ²/2.

        With `per_area` k and c are multiplied by the area of each point. With a damping ratio its
        share of the critical damping of each point is added to c, and an `InputError` is raised
        without masses. The output also has the stiffness k, the part of the force due to the rate
        and, if the input wants it, the derivatives of the force.
        """
        force = elastic = self.stiffness * inp.penetration
        stiffness = np.empty(elastic.shape)
        stiffness.fill(self.stiffness)
        stored = 0.5 * self.stiffness * inp.penetration**2
        has_rate, none = self.has_rate, np.zeros(elastic.shape)
        if has_rate:
            force = elastic + self.damping * inp.rate
        if self.per_area:
            elastic, force = elastic * inp.area, force * inp.area
            stiffness, stored = stiffness * inp.area, stored * inp.area
        critical = None
        if self.damping_ratio > 0.0:
            critical = critical_damping(self.damping_ratio, stiffness, inp.mass)
            force = force + critical * inp.rate
        if has_rate:
            force = np.maximum(force, 0.0)
        damping, memory = force - elastic if has_rate else none, np.zeros((len(force), 0))
        tangent = LawTangent(DepthSlopes(stiffness)) if inp.wants_tangent else None
        if inp.wants_tangent and has_rate:
            viscosity = self.damping * (inp.area if self.per_area else np.ones(len(force)))
            viscosity = viscosity if critical is None else viscosity + critical
            is_pushing = force > 0.0
            tangent = LawTangent(DepthSlopes(stiffness * is_pushing), viscosity * is_pushing)
        return LawOutput(force, stiffness, stored, memory, none, damping, tangent=tangent)


@dataclass(frozen=True)
class AdaptiveLaw:
    """Penalty whose stiffness follows from nodal mass and step: F_i = s (m_i/Δt²) λ_i.

    The thesis names adaptive contact without a formula. This is the soft constraint of explicit
    codes: the frequency of the spring is a fixed fraction of the limit of the step, whatever the
    materials are (a spring between a node and a rigid body is stable up to s = 4).

    Parameters
    ----------
    scale : s > 0, usually 0.1

    Notes
    -----
    At the start of a run Δt = 0 and there is no stiffness yet: the forces are zero.

    Examples
    --------
    >>> one = np.ones(1)
    >>> pressed = LawInput(0.25 * one, 0.0 * one, one, None, 2.0 * one, 0.5)
    >>> AdaptiveLaw(scale=0.5).respond(pressed).force.tolist()  # 0.5 · 2 / 0.5² · 0.25
    [1.0]
    """

    scale: float = 0.1

    has_energy = False
    """Its stored energy is no measure of the accuracy of a step."""
    stiffness_follows_step = True
    """It has no critical step: a shorter step makes it stiffer."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "scale", positive(self.scale, "scale"))

    needs_mass = True
    needs_area = False
    needs_thickness = False
    n_memory = 0

    def respond(self, inp: LawInput) -> LawOutput:
        """Return forces s (m/Δt²) λ, whose stiffness and energy depend on the step; 0 at Δt = 0.

        Raises
        ------
        InputError
            The slave has no masses.
        """
        if inp.mass is None:
            raise InputError(
                "the adaptive law needs nodal masses and the slave has none",
                where="mass",
                remedy="Give the slave a mass, or use the penalty law",
            )
        if inp.dt == 0.0:
            force, stiffness, stored = np.zeros((3, len(inp.penetration)))
            tangent = LawTangent(DepthSlopes(stiffness))
            return no_memory(force, stiffness, stored, tangent=tangent)
        stiffness = self.scale * inp.mass / inp.dt**2
        force = stiffness * inp.penetration
        stored = 0.5 * force * inp.penetration
        return no_memory(force, stiffness, stored, tangent=LawTangent(DepthSlopes(stiffness)))
