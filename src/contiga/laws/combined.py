"""Contact of two deformable sides: the intermediate surface between slave and master.

The penetration is split, λ = λ_s + λ_m, so that both sides' elastic stresses agree,
σ_s(λ_s/t_s) = σ_m(λ_m/t_m): two springs in series (contact type *combined*, thesis, 3.2).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.curves.characteristic import Characteristic, Extrapolation
from contiga.errors import InputError
from contiga.laws.force import ForceLaw
from contiga.laws.law import no_memory
from contiga.laws.stress import StressLaw
from contiga.laws.stress_path import StressPath, stress_path
from contiga.records import DepthSlopes, FloatArray, LawInput, LawOutput, LawTangent

_N_SAMPLES = 65
_STRESS_TOL = 1e-9
"""Relative difference of stresses that counts as equal."""


class Split(NamedTuple):
    """Parts of the penetration of n_c points that the two sides take, and their stress."""

    slave: FloatArray
    """(n_c,) λ_s, length."""
    master: FloatArray
    """(n_c,) λ_m, length."""
    stress: FloatArray
    """(n_c,) elastic stress of both sides."""


@dataclass(frozen=True, init=False, eq=False)
class CombinedLaw:
    """Stress law of a deformable slave in contact with a deformable master.

    Parameters
    ----------
    slave : law of the slave side; its thickness, or the slave's nodal one if it has none
    master : law of the master side, with a thickness

    Notes
    -----
    Tables are solved exactly, including plateaus: two plateaus of equal stress share the
    penetration in proportion to their lengths. Callables are solved by Chandrupatla's bracketing
    method (Advances in Engineering Software 28, 1997) to rounding.

    If the stress of one side at zero strain is above all that the other can carry, that side does
    not deform and the other takes all of the penetration.

    Damping: the rate is shared like the penetration, λ̇_s = λ̇ λ_s/λ (equally for λ = 0), and the
    surface carries the damping stress of equal power, σ_d λ̇ = σ_d,s λ̇_s + σ_d,m λ̇_m.

    Raises
    ------
    InputError
        A law that is not a `StressLaw` (the force model has no stress to balance), a master
        without thickness, characteristics that decrease, a side with unloading or a damping ratio.
    """

    slave: StressLaw
    master: StressLaw
    path: StressPath | None
    """Polyline of equal stress of two tables; None if a side is a callable."""

    def __init__(self, slave: StressLaw, master: StressLaw) -> None:
        for side, law in (("law", slave), ("master_law", master)):
            if not isinstance(law, StressLaw):
                raise InputError(
                    "combined contact balances the stresses of two sides",
                    where=side,
                    found=type(law).__name__,
                    allowed="StressLaw",
                    remedy="Others work with type slave or master, force laws also in series",
                )
            if law.hysteresis is not None:
                raise InputError(
                    "combined contact balances elastic stresses; with unloading the split of a "
                    "penetration is not unique, as it goes with the past of both sides",
                    where=f"{side}.unloading",
                    remedy='Remove unloading and hysteresis_slope, or use type "slave" or "master"',
                )
            if law.damping_ratio > 0.0:
                raise InputError(
                    "a share of critical damping is that of a mass on one spring, not on two in "
                    "series",
                    where=f"{side}.damping_ratio",
                    found=law.damping_ratio,
                    remedy="Use an absolute damping",
                )
        if master.thickness is None:
            raise InputError("the master's stress law needs a thickness", where="master_law")
        has_tables = slave.elastic.is_table and master.elastic.is_table
        object.__setattr__(self, "slave", slave)
        object.__setattr__(self, "master", master)
        path = stress_path(slave.elastic, master.elastic) if has_tables else None
        object.__setattr__(self, "path", path)

    needs_mass = False
    n_memory = 0

    @property
    def has_rate(self) -> bool:
        """True if the force depends on the rate: a side is damped."""
        return self.slave.has_rate or self.master.has_rate

    @property
    def needs_thickness(self) -> bool:
        """True if the slave's law has no thickness: the slave's nodes must have one."""
        return self.slave.needs_thickness

    def split(self, inp: LawInput) -> Split:
        """Return the parts λ_s and λ_m of the penetration, and the elastic stress of both sides."""
        t_s, t_m = self.slave.thickness_of(inp), self.master.thickness_of(inp)
        if self.path is not None:
            return Split(*self.path.solve(inp.penetration, t_s, t_m))
        return _balance(self.slave, self.master, inp.penetration, t_s, t_m)

    def respond(self, inp: LawInput) -> LawOutput:
        """Return area times the stress of the intermediate surface, with energies of both sides.

        The force is zero where damping would pull. The stiffness is that of the two sides in
        series, zero on a plateau.
        """
        t_s, t_m = self.slave.thickness_of(inp), self.master.thickness_of(inp)
        split = self.split(inp)
        share_s = np.full(inp.penetration.shape, 0.5)
        np.divide(split.slave, inp.penetration, out=share_s, where=inp.penetration > 0.0)
        share_m = 1.0 - share_s
        damping = share_s * self.slave.damping_stress(inp.rate * share_s / t_s, split.stress)
        damping += share_m * self.master.damping_stress(inp.rate * share_m / t_m, split.stress)
        compliance = _compliance(self.slave, split.slave / t_s, split.stress) * t_s
        compliance += _compliance(self.master, split.master / t_m, split.stress) * t_m
        stored = t_s * self.slave.elastic.energy(split.slave / t_s)
        stored += t_m * self.master.elastic.energy(split.master / t_m)
        stiffness = np.zeros(compliance.shape)
        np.divide(1.0, compliance, out=stiffness, where=compliance > 0.0)
        force = inp.area * np.maximum(split.stress + damping, 0.0)
        tangent = None
        if inp.wants_tangent:
            tangent = self._tangent(inp, split, share_s, stiffness, force > 0.0)
        return no_memory(
            force, inp.area * stiffness, inp.area * stored, inp.area * split.stress, tangent
        )

    def _tangent(
        self,
        inp: LawInput,
        split: Split,
        share_s: FloatArray,
        stiffness: FloatArray,
        is_pushing: NDArray[np.bool_],
    ) -> LawTangent:
        """Return the derivatives of the forces, zero for a damped point that does not push.

        `share_s` is λ_s/λ, `stiffness` is by unit area. The stiffness of callables has derivatives
        too, by differences; that of tables is piecewise constant and has None.
        """
        t_s, t_m = self.slave.thickness_of(inp), self.master.thickness_of(inp)
        # Of an additional penetration the slave takes the share of its compliance.
        compliance = _compliance(self.slave, split.slave / t_s, split.stress) * t_s
        increment_share = np.where(stiffness > 0.0, compliance * stiffness, share_s)
        share_slope = np.zeros(len(share_s))
        np.divide(
            increment_share - share_s,
            inp.penetration,
            out=share_slope,
            where=inp.penetration > 0.0,
        )
        slope, viscosity = stiffness.copy(), np.zeros(len(share_s))
        if self.has_rate:
            for law, thickness, share, change in (
                (self.slave, t_s, share_s, share_slope),
                (self.master, t_m, 1.0 - share_s, -share_slope),
            ):
                rate = inp.rate * share / thickness
                by_stress, by_rate = law.damping_slopes(rate, split.stress)
                slope += change * law.damping_stress(rate, split.stress)
                slope += share * (by_stress * stiffness + by_rate * inp.rate * change / thickness)
                viscosity += share * by_rate * share / thickness
        scale = inp.area * is_pushing if self.has_rate else inp.area
        stiffening = None
        if self.path is None:
            stiffening = DepthSlopes(inp.area * self._bend(inp))
        return LawTangent(DepthSlopes(scale * slope), scale * viscosity, stiffening)

    def _bend(self, inp: LawInput) -> FloatArray:
        """Return the derivative (n_c,) of the stiffness by unit area, by central differences.

        They are of fourth order, with steps of a thousandth of the penetration; 0 without one.
        """
        step = 1e-3 * inp.penetration
        unit = inp._replace(area=np.ones(len(step)), wants_tangent=False)

        def stiffness(k: float) -> FloatArray:
            return self.respond(unit._replace(penetration=inp.penetration + k * step)).stiffness

        rise = 8.0 * (stiffness(1.0) - stiffness(-1.0)) - (stiffness(2.0) - stiffness(-2.0))
        bend: FloatArray = np.zeros(len(step))
        np.divide(rise, 12.0 * step, out=bend, where=step > 0.0)
        return bend


def forces_in_series(slave: ForceLaw, master: ForceLaw) -> ForceLaw:
    """Return one force law for two sides that carry the same force, λ = λ_s + λ_m.

    Its table has the knots of both; it ends, or goes on linearly, as the two together do.

    Raises
    ------
    InputError
        A side with unloading, for which the split depends on the past; curves that are not tables,
        decrease or do not include zero; shares that differ.
    """
    for side, law in (("law", slave), ("master_law", master)):
        if law.hysteresis is not None or not law.curve.is_table or law.share != slave.share:
            raise InputError(
                "two force laws in series have tables without unloading, and one share",
                where=side,
                remedy='Remove unloading and hysteresis_slope, or use type "slave" or "master"',
            )
    path = stress_path(slave.curve, master.curve)
    depth, force = path.slave + path.master, path.stress
    if path.ray is not None:  # one more point on the ray, for linear extrapolation
        step = float(depth[-1]) or 1.0
        depth = np.append(depth, depth[-1] + step * (path.ray[0] + path.ray[1]))
        force = np.append(force, force[-1] + step * path.ray[2])
    extrapolation: Extrapolation = "error" if path.ray is None else "linear"
    rows = np.column_stack([depth, force])
    return ForceLaw(Characteristic(rows, extrapolation=extrapolation), share=slave.share)


def _compliance(law: StressLaw, strain: FloatArray, stress: FloatArray) -> FloatArray:
    """Return the tangent compliance (n_c,), strain over stress; infinite on a plateau.

    It is zero where the curve of the law is above `stress`: the other side yields first.
    """
    slope = law.elastic.carried_slope(strain)
    deforms = law.elastic.carried(strain) <= stress * (1.0 + _STRESS_TOL)
    compliance = np.full(strain.shape, np.inf)
    np.divide(1.0, slope, out=compliance, where=slope > 0.0)
    return np.where(deforms, compliance, 0.0)


def _balance(
    slave: StressLaw, master: StressLaw, depth: FloatArray, t_s: FloatArray, t_m: FloatArray
) -> Split:
    """Return the split for callables, by bracketing λ_s in [0, λ].

    Without a sign change one side takes all: the master if its stress is then not above the
    slave's at zero, else the slave. An `InputError` is raised for a curve that falls between
    samples.
    """
    from scipy.optimize.elementwise import find_root

    if depth.size == 0:
        return Split(np.zeros(0), np.zeros(0), np.zeros(0))
    _check_rising(slave.elastic, float((depth / t_s).max()), "law")
    _check_rising(master.elastic, float((depth / t_m).max()), "master_law")

    def excess(
        share: FloatArray, depth: FloatArray, t_s: FloatArray, t_m: FloatArray
    ) -> FloatArray:
        return slave.elastic.carried(share * depth / t_s) - master.elastic.carried(
            (1.0 - share) * depth / t_m
        )

    low, high = np.zeros(depth.shape), np.ones(depth.shape)
    at_low, at_high = excess(low, depth, t_s, t_m), excess(high, depth, t_s, t_m)
    share = np.where(at_low >= 0.0, 0.0, 1.0)
    is_bracketed = (at_low < 0.0) & (at_high > 0.0)
    if is_bracketed.any():
        arguments = (depth[is_bracketed], t_s[is_bracketed], t_m[is_bracketed])
        roots = find_root(excess, (low[is_bracketed], high[is_bracketed]), args=arguments)
        share[is_bracketed] = roots.x
    lambda_s, lambda_m = share * depth, (1.0 - share) * depth
    # At an end of the bracket the stiffer side does not deform: the contact carries the stress of
    # the other one. Elsewhere both are equal to rounding.
    stress = np.minimum(
        slave.elastic.carried(lambda_s / t_s), master.elastic.carried(lambda_m / t_m)
    )
    return Split(lambda_s, lambda_m, stress)


def _check_rising(curve: Characteristic, upto: float, where: str) -> None:
    """Refuse a callable that falls between `_N_SAMPLES` samples up to a strain.

    An `InputError` is raised with the place. More cannot be proved of a callable.
    """
    strain = np.linspace(0.0, upto, _N_SAMPLES)
    falls = np.flatnonzero(np.diff(curve(strain)) < 0.0)
    if falls.size:
        raise InputError(
            "combined contact needs a characteristic that does not decrease; "
            f"it falls near {strain[falls[0]]:.6g}",
            where=f"{where}.{curve.name}",
        )
