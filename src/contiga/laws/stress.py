"""The law of contact stress: independent points, elastic or with hysteresis, and damped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import not_negative, positive
from contiga.curves.characteristic import Characteristic, CurveLike, as_curve
from contiga.curves.hysteresis import Hysteresis, Responses, elastic_move, hysteresis_of
from contiga.errors import InputError
from contiga.laws.law import critical_damping, remembered
from contiga.records import DepthSlopes, FloatArray, LawInput, LawOutput, LawTangent

_STRESS_TOL = 1e-9
"""Relative size of a stress that counts as zero."""
_SAMPLE_RATES = np.array([1e-6, 1e-3, 1.0])
"""Rates at which a callable is checked before a run."""
_FAR_FACTOR = 1e3
"""Rate at which the extrapolation of a table is checked, over its largest rate."""


@dataclass(frozen=True, init=False, eq=False)
class StressLaw:
    """Force from a contact stress, elastic and damped (thesis, Eq. 3.4).

    F_i = A_i [σ_e(λ_i/t_i) + (C_d λ̇_i/t_i + σ_d(λ̇_i/t_i)) f_d(σ_e)]

    Parameters
    ----------
    elastic : σ_e, stress over relative penetration λ/t; a number is a modulus
    thickness : t > 0 of the deformed side, one value for all; if None that of each slave node
    damping : C_d ≥ 0, stress × time
    damping_ratio : ζ ≥ 0, damping over the critical damping of each point: adds the force
        2 ζ √(k_i m_i) λ̇_i with the current stiffness k_i and the mass m_i; not amplified
    damping_curve : σ_d, stress over relative rate λ̇/t, with the sign of the rate: positive while
        a contact closes, negative while it opens
    amplification : f_d, a factor over the elastic stress; 1 if None
    unloading : σ_u ≤ σ_e, stress over λ/t on unloading; as `elastic` if None
    hysteresis_slope : K, slope of the lines between the two curves, stress over λ/t; needed with
        `unloading`, and not below the steepest slope of either

    Notes
    -----
    With `unloading` the elastic stress moves along lines of slope K between the curves,
    σ = clip(σ_old + K Δ(λ/t), σ_u, σ_e), and each point remembers its last λ/t and σ: see
    `contiga.curves.hysteresis`. The energies are those of the area of this step.

    Contact does not pull: a negative σ_e counts as zero, and so does a negative F_i, by damping
    while a contact opens fast.

    Raises
    ------
    InputError
        Thickness not above zero, negative damping, an invalid curve, a damping curve that supplies
        energy, unloading above loading or below zero, K missing or too small; in `respond`, no
        thickness in law and input, a damping ratio without masses, a callable damping curve of the
        wrong sign.

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
    damping_ratio: float
    hysteresis: Hysteresis | None

    def __init__(
        self,
        elastic: CurveLike,
        thickness: float | None = None,
        *,
        damping: float = 0.0,
        damping_curve: CurveLike | None = None,
        amplification: CurveLike | None = None,
        damping_ratio: float = 0.0,
        unloading: CurveLike | None = None,
        hysteresis_slope: float | None = None,
    ) -> None:
        put = object.__setattr__
        put(self, "elastic", as_curve(elastic, "elastic"))
        put(self, "thickness", None if thickness is None else positive(thickness, "thickness"))
        put(self, "damping", not_negative(damping, "damping"))
        for name, given in (("damping_curve", damping_curve), ("amplification", amplification)):
            put(self, name, None if given is None else as_curve(given, name))
        if self.damping_curve is not None:
            curve = self.damping_curve
            rates = np.concatenate([-_SAMPLE_RATES[::-1], [0.0], _SAMPLE_RATES])
            if curve.is_table:  # between and beyond these rates it does not change its sign
                far_rate = _FAR_FACTOR * np.abs(curve.x).max()
                rates = np.concatenate([curve.x, [0.0, -far_rate, far_rate]])
                if curve.extrapolation == "error":
                    rates = rates[(rates >= curve.x[0]) & (rates <= curve.x[-1])]
            _check_damping(curve, rates, curve(rates))
        put(self, "damping_ratio", not_negative(damping_ratio, "damping_ratio"))
        put(self, "hysteresis", hysteresis_of(self.elastic, unloading, hysteresis_slope))

    @property
    def needs_mass(self) -> bool:
        """True with a damping ratio: critical damping depends on the mass."""
        return self.damping_ratio > 0.0

    @property
    def has_rate(self) -> bool:
        """True if the force depends on the rate: the law is damped."""
        return self.damping > 0.0 or self.damping_ratio > 0.0 or self.damping_curve is not None

    @property
    def n_memory(self) -> int:
        """Number of values by point: strain and stress of the last step, only with hysteresis."""
        return 0 if self.hysteresis is None else 2

    @property
    def needs_thickness(self) -> bool:
        """True if the law has no thickness: the slave's nodes must have one."""
        return self.thickness is None

    def thickness_of(self, inp: LawInput) -> FloatArray:
        """Return the thickness (n_c,) of each point, the law's or, if it has none, the slave's.

        Raises
        ------
        InputError
            Neither has one, or a point in contact has none above zero.
        """
        if self.thickness is not None:
            return np.full(inp.penetration.shape, self.thickness)
        if inp.thickness is None:
            raise InputError(
                "the stress law has no thickness and neither has the slave",
                where="thickness",
                remedy="Give StressLaw a thickness, or the slave one a node",
            )
        if not (inp.thickness > 0.0).all():
            invalid = inp.thickness[~(inp.thickness > 0.0)]
            raise InputError(
                f"{invalid.size} points in contact have no thickness",
                where="thickness",
                found=float(invalid[0]),
                allowed="above zero",
            )
        return inp.thickness

    def damping_stress(self, strain_rate: FloatArray, elastic_stress: FloatArray) -> FloatArray:
        """Return the damping stress (n,) (C_d λ̇/t + σ_d(λ̇/t)) f_d(σ_e), of either sign.

        An `InputError` is raised if a callable σ_d has the wrong sign at one of these rates.
        """
        stress = self.damping * strain_rate
        if self.damping_curve is not None:
            by_curve = self.damping_curve(strain_rate)
            if not self.damping_curve.is_table:
                _check_damping(self.damping_curve, strain_rate, by_curve)
            stress = stress + by_curve
        if self.amplification is not None:
            stress = stress * self.amplification(elastic_stress)
        return stress

    def damping_slopes(
        self, strain_rate: FloatArray, elastic_stress: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return derivatives (n,) of `damping_stress`, by elastic stress and by relative rate.

        A callable damping curve is not checked here.
        """
        by_rate = np.full(strain_rate.shape, self.damping)
        stress = self.damping * strain_rate
        if self.damping_curve is not None:
            by_rate = by_rate + self.damping_curve.slope(strain_rate)
            stress = stress + self.damping_curve(strain_rate)
        if self.amplification is None:
            return np.zeros(stress.shape), by_rate
        factor = self.amplification(elastic_stress)
        return stress * self.amplification.slope(elastic_stress), by_rate * factor

    def respond(self, inp: LawInput) -> LawOutput:
        """Return the forces of Eq. 3.4, zero where they would pull, with the elastic energy.

        Stiffness is that of the elastic stress alone. Points without an area get no force of the
        damping ratio.

        Raises
        ------
        InputError
            No thickness, a damping ratio without masses, a callable damping curve of the wrong
            sign.
        """
        thickness = self.thickness_of(inp)
        strain = inp.penetration / thickness
        # Response of the elastic stress, by unit of volume.
        if self.hysteresis is None:
            elastic, memory = elastic_move(self.elastic, strain), np.zeros((len(strain), 0))
        else:
            past = remembered(inp, self.n_memory)
            elastic = self.hysteresis.move(past[:, 0], past[:, 1], strain)
            memory = np.column_stack([strain, elastic.force])
        stress = elastic.force + self.damping_stress(inp.rate / thickness, elastic.force)
        stiffness = inp.area * elastic.stiffness / thickness
        if self.damping_ratio > 0.0:
            damping = critical_damping(self.damping_ratio, stiffness, inp.mass) * inp.rate
            stress += np.divide(damping, inp.area, out=np.zeros(len(damping)), where=inp.area > 0.0)
        force = inp.area * np.maximum(stress, 0.0)
        volume = inp.area * thickness
        tangent = None
        if inp.wants_tangent:
            tangent = self._tangent(inp, strain, thickness, elastic, force > 0.0)
        return LawOutput(
            force,
            stiffness,
            volume * elastic.stored,
            memory,
            volume * elastic.lost,
            force - inp.area * elastic.force,
            tangent=tangent,
        )

    def _tangent(
        self,
        inp: LawInput,
        strain: FloatArray,
        thickness: FloatArray,
        elastic: Responses,
        is_pushing: NDArray[np.bool_],
    ) -> LawTangent:
        """Return the derivatives of the forces, zero for a damped point that does not push.

        `strain` is λ/t, and `elastic` the response of the stress to it. The derivative of the
        stiffness is that of the elastic part.
        """
        bend = self.elastic.carried_bend(strain)
        if self.hysteresis is not None:
            bend = self.hysteresis.bend(strain, elastic.force)
        slope = inp.area * elastic.stiffness / thickness
        stiffening = DepthSlopes(inp.area * bend / thickness**2)
        if not self.has_rate:
            return LawTangent(DepthSlopes(slope), stiffness=stiffening)
        by_stress, by_rate = self.damping_slopes(inp.rate / thickness, elastic.force)
        damped_slope, viscosity = slope * (1.0 + by_stress), inp.area * by_rate / thickness
        if self.damping_ratio > 0.0:
            critical = critical_damping(self.damping_ratio, slope, inp.mass)
            viscosity = viscosity + critical
            # The relative change of 2 ζ √(k m) is half of that of k.
            share = np.divide(stiffening.own, slope, out=np.zeros(len(slope)), where=slope > 0.0)
            damped_slope = damped_slope + 0.5 * critical * share * inp.rate
        return LawTangent(
            DepthSlopes(damped_slope * is_pushing), viscosity * is_pushing, stiffening
        )


def _check_damping(curve: Characteristic, rates: FloatArray, stress: FloatArray) -> None:
    """Refuse stresses (k,) at rates (k,) that are not zero at rate zero, or of the other sign.

    Stresses up to `_STRESS_TOL` of the largest count as zero.

    Raises
    ------
    InputError
        Such a stress, which would supply energy.
    """
    tol = _STRESS_TOL * np.abs(stress).max(initial=0.0)
    wrong = np.flatnonzero((np.abs(stress) > tol) & (stress * np.sign(rates) <= 0.0))
    if wrong.size:
        rate, value = float(rates[wrong[0]]), float(stress[wrong[0]])
        allowed = "zero" if rate == 0.0 else f"zero or {'above' if rate > 0.0 else 'below'}"
        remedy = "It resists the rate: above zero while a contact closes, below while it opens"
        if curve.is_table and not curve.x[0] <= rate <= curve.x[-1]:
            remedy += f'; beyond its table it goes on by extrapolation = "{curve.extrapolation}"'
        raise InputError(
            f"the damping curve is {'below' if value < 0.0 else 'above'} zero at {rate:.6g}",
            where=curve.name,
            found=value,
            allowed=allowed,
            remedy=remedy,
        )
