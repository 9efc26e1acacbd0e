"""Force laws: from penetration, rate and area to the force on each point in contact.

A law takes a `LawInput` and answers with a `LawOutput`: the magnitude of the force along the
master's normal, how stiff it is, and the energy it has stored. No law ever pulls: a force is zero
where its formula would be negative.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Protocol

import numpy as np

from contiga.errors import InputError
from contiga.laws.characteristic import Characteristic, CurveLike
from contiga.laws.share import share
from contiga.records import FloatArray, LawInput, LawOutput


class Law(Protocol):
    """What a contact asks of a law."""

    @property
    def needs_mass(self) -> bool:
        """Whether the slave must have nodal masses."""

    @property
    def needs_thickness(self) -> bool:
        """Whether the slave must have nodal thicknesses."""

    @property
    def n_memory(self) -> int:
        """Numbers a point that the law keeps from one step to the next."""

    def respond(self, inp: LawInput) -> LawOutput:
        """Forces, stiffnesses, stored energies and memory of the points in contact."""


def no_memory(force: FloatArray, stiffness: FloatArray, stored: FloatArray) -> LawOutput:
    """The answer of a law that remembers nothing."""
    return LawOutput(force, stiffness, stored, np.zeros((len(force), 0)))


@dataclass(frozen=True, init=False, eq=False)
class ForceLaw:
    """Total force from the greatest penetration (thesis, Eq. 3.1–3.3).

    F = Γ(λ_max), shared as F_i = F λ_i A_i / Σ λ_j A_j. The total depends neither on the number
    of points in contact nor on their area.

    Parameters
    ----------
    curve : Γ, force over penetration: a number, a table, a callable or a `Characteristic`

    Notes
    -----
    No points in contact: no forces. Points that only touch (all λ = 0): Γ(0), which is zero for
    most curves, shared by area; see `share` for what happens without areas.

    >>> depth, area = np.array([0.2, 0.4]), np.array([0.1, 0.1])
    >>> ForceLaw(0.6).respond(LawInput(depth, np.zeros(2), area, None, None, 0.0)).force.round(12)
    array([0.08, 0.16])

    Stiffness and energy are those of the whole, shared as the force is.
    """

    curve: Characteristic

    def __init__(self, curve: CurveLike) -> None:
        object.__setattr__(self, "curve", _as_curve(curve, "curve"))

    needs_mass = False
    needs_thickness = False
    n_memory = 0

    def respond(self, inp: LawInput) -> LawOutput:
        """Forces whose sum is Γ(λ_max) to rounding."""
        if inp.penetration.size == 0:
            return no_memory(np.zeros(0), np.zeros(0), np.zeros(0))
        deepest = inp.penetration.max(keepdims=True)
        total = float(self.curve(deepest)[0])
        slope = float(self.curve.slope(deepest)[0]) if total >= 0.0 else 0.0
        energy = float(self.curve.energy(deepest)[0])
        force, stiffness, stored = (
            share(whole, inp.penetration, inp.area) for whole in (max(total, 0.0), slope, energy)
        )
        return no_memory(force, stiffness, stored)


@dataclass(frozen=True, init=False, eq=False)
class StressLaw:
    """Force from a contact stress, elastic and damped (thesis, Eq. 3.4).

    F_i = A_i [σ_e(λ_i/t_i) + (C_d λ̇_i/t_i + σ_d(λ̇_i/t_i)) f_d(σ_e)]

    Parameters
    ----------
    elastic : σ_e, stress over relative penetration λ/t; a number is a modulus
    thickness : t > 0 of the deformed side, one value for all; None takes each slave node's own
    damping : C_d ≥ 0, stress × time
    damping_curve : σ_d, stress over relative rate λ̇/t (negative while a contact opens)
    amplification : f_d, a factor over the elastic stress; 1 if None

    Notes
    -----
    Contact does not pull: σ_e below zero counts as zero, and so does a negative F_i, which
    damping would give while a contact opens fast.

    Raises
    ------
    InputError
        Thickness not above zero, negative damping, a curve that is wrong; at `respond`, no
        thickness given and none in the input.

    Examples
    --------
    >>> one = np.ones(1)
    >>> pressed = LawInput(0.2 * one, 0.0 * one, 4.0 * one, None, None, 0.0)
    >>> StressLaw(10.0, thickness=0.5).respond(pressed).force.tolist()  # 4 · 10 · 0.2 / 0.5
    [16.0]
    """

    elastic: Characteristic
    thickness: float | None
    damping: float
    damping_curve: Characteristic | None
    amplification: Characteristic | None

    def __init__(
        self,
        elastic: CurveLike,
        thickness: float | None = None,
        *,
        damping: float = 0.0,
        damping_curve: CurveLike | None = None,
        amplification: CurveLike | None = None,
    ) -> None:
        put = object.__setattr__
        put(self, "elastic", _as_curve(elastic, "elastic"))
        put(self, "thickness", None if thickness is None else _positive(thickness, "thickness"))
        put(self, "damping", _not_negative(damping, "damping"))
        for name, curve in (("damping_curve", damping_curve), ("amplification", amplification)):
            put(self, name, None if curve is None else _as_curve(curve, name))

    needs_mass = False
    n_memory = 0

    @property
    def needs_thickness(self) -> bool:
        """True where no thickness was given: the slave's nodes must have one."""
        return self.thickness is None

    def thickness_of(self, inp: LawInput) -> FloatArray:
        """Thickness of each point (n_c,): the law's own or the slave's."""
        if self.thickness is not None:
            return np.full(inp.penetration.shape, self.thickness)
        if inp.thickness is None:
            raise InputError(
                "the stress law has no thickness and neither has the slave",
                where="thickness",
                remedy="Give StressLaw a thickness, or the slave one a node",
            )
        if not (inp.thickness > 0.0).all():
            bad = inp.thickness[~(inp.thickness > 0.0)]
            raise InputError(
                f"{bad.size} points in contact have no thickness",
                where="thickness",
                found=float(bad[0]),
                allowed="above zero",
            )
        return inp.thickness

    def elastic_stress(self, strain: FloatArray) -> FloatArray:
        """σ_e(λ/t), not below zero."""
        return np.maximum(self.elastic(strain), 0.0)

    def elastic_slope(self, strain: FloatArray) -> FloatArray:
        """dσ_e/d(λ/t), zero where σ_e is below zero."""
        return np.where(self.elastic(strain) >= 0.0, self.elastic.slope(strain), 0.0)

    def damping_stress(self, strain_rate: FloatArray, elastic_stress: FloatArray) -> FloatArray:
        """(C_d λ̇/t + σ_d(λ̇/t)) f_d(σ_e), of either sign."""
        stress = self.damping * strain_rate
        if self.damping_curve is not None:
            stress = stress + self.damping_curve(strain_rate)
        if self.amplification is not None:
            stress = stress * self.amplification(elastic_stress)
        return stress

    def respond(self, inp: LawInput) -> LawOutput:
        """Forces of Eq. 3.4; the energy is that of the elastic stress."""
        thickness = self.thickness_of(inp)
        strain = inp.penetration / thickness
        carried = self.elastic_stress(strain)
        stress = carried + self.damping_stress(inp.rate / thickness, carried)
        return no_memory(
            inp.area * np.maximum(stress, 0.0),
            inp.area * self.elastic_slope(strain) / thickness,
            inp.area * thickness * self.elastic.energy(strain),
        )


@dataclass(frozen=True)
class PenaltyLaw:
    """A spring and a damper on every point: F_i = k λ_i + c λ̇_i.

    Parameters
    ----------
    stiffness : k > 0, force a length; with `per_area` a pressure a length, times A_i
    per_area : whether stiffness and damping are those of a unit area
    damping : c ≥ 0, force × time a length (a unit of area)

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

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffness", _positive(self.stiffness, "stiffness"))
        object.__setattr__(self, "damping", _not_negative(self.damping, "damping"))

    needs_mass = False
    needs_thickness = False
    n_memory = 0

    def respond(self, inp: LawInput) -> LawOutput:
        """Forces k λ + c λ̇ and energies k λ²/2."""
        force = np.maximum(self.stiffness * inp.penetration + self.damping * inp.rate, 0.0)
        stiffness = np.full(force.shape, self.stiffness)
        stored = 0.5 * self.stiffness * inp.penetration**2
        if self.per_area:
            return no_memory(force * inp.area, stiffness * inp.area, stored * inp.area)
        return no_memory(force, stiffness, stored)


@dataclass(frozen=True)
class AdaptiveLaw:
    """Penalty whose stiffness follows from nodal mass and step: F_i = s (m_i/Δt²) λ_i.

    The thesis names adaptive contact and gives no formula. This is the soft constraint of
    explicit codes: the spring's frequency stays a fixed part of what the step can carry, whatever
    the materials are (a node-on-rigid spring is stable up to s = 4).

    Parameters
    ----------
    scale : s > 0, 0.1 by custom

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

    def __post_init__(self) -> None:
        object.__setattr__(self, "scale", _positive(self.scale, "scale"))

    needs_mass = True
    needs_thickness = False
    n_memory = 0

    def respond(self, inp: LawInput) -> LawOutput:
        """Forces s (m/Δt²) λ. The stiffness goes with the step, and with it the energy.

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
            none = np.zeros(inp.penetration.shape)
            return no_memory(none, none, none)
        stiffness = self.scale * inp.mass / inp.dt**2
        force = stiffness * inp.penetration
        return no_memory(force, stiffness, 0.5 * force * inp.penetration)


def _as_curve(curve: CurveLike, name: str) -> Characteristic:
    return curve if isinstance(curve, Characteristic) else Characteristic(curve, name=name)


def _positive(value: float, name: str) -> float:
    number = _number(value, name, "a number above zero")
    if number <= 0.0:
        raise InputError(
            "must be above zero", where=name, found=value, allowed="a number above zero"
        )
    return number


def _not_negative(value: float, name: str) -> float:
    number = _number(value, name, "zero or above")
    if number < 0.0:
        raise InputError("must not be negative", where=name, found=value, allowed="zero or above")
    return number


def _number(value: float, name: str, allowed: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise InputError("must be a number", where=name, found=value, allowed=allowed) from error
    if not np.isfinite(number):
        raise InputError("must be finite", where=name, found=value, allowed=allowed)
    return number
