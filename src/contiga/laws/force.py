"""The force law: one total from the greatest penetration, shared by the points in contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from contiga.errors import InputError
from contiga.laws.characteristic import Characteristic, CurveLike
from contiga.laws.hysteresis import Hysteresis, elastic_move, hysteresis_of
from contiga.laws.law import as_curve, remembered
from contiga.laws.share import share
from contiga.records import FloatArray, LawInput, LawOutput

Share = Literal["penetration", "deepest"]


@dataclass(frozen=True, init=False, eq=False)
class ForceLaw:
    """Total force from the greatest penetration (thesis, Eq. 3.1–3.3).

    F = Γ(λ_max), shared as F_i = F λ_i A_i / Σ λ_j A_j. The total depends neither on the number
    of points in contact nor on their area. The total is what an energy ∫Γ dλ_max gives, the shares
    are not: points that move against each other gain or lose energy that nothing accounts for.
    ``share="deepest"`` gives all to the deepest point, which is the gradient of that energy.

    Parameters
    ----------
    curve : Γ, force over penetration: a number, a table, a callable or a `Characteristic`
    unloading : Γ_u ≤ Γ, the force of an unloading; as `curve` if None
    hysteresis_slope : K, force over penetration between the two curves; goes with `unloading`, and
        is not below the steepest slope of either
    share : ``"penetration"`` (default) as above, or ``"deepest"``: the first of the deepest points

    Notes
    -----
    No points in contact: no forces. Points that only touch (all λ = 0): Γ(0), which is zero for
    most curves, shared by area; see `share` for what happens without areas.

    >>> depth, area = np.array([0.2, 0.4]), np.array([0.1, 0.1])
    >>> ForceLaw(0.6).respond(LawInput(depth, np.zeros(2), area, None, None, 0.0)).force.round(12)
    array([0.08, 0.16])

    Stiffness and energies are those of the whole, shared as the force is.

    With `unloading` the total moves along lines of slope K between the curves: see
    `contiga.laws.hysteresis`. The last λ_max and F stand in the memory of every point, so that they
    last while any point that was in contact then still is.

    Raises
    ------
    InputError
        A curve that is wrong, unloading above loading or below zero, K missing or too small, a
        share that is not known.
    """

    curve: Characteristic
    hysteresis: Hysteresis | None
    share: Share

    def __init__(
        self,
        curve: CurveLike,
        *,
        unloading: CurveLike | None = None,
        hysteresis_slope: float | None = None,
        share: Share = "penetration",
    ) -> None:
        if share not in get_args(Share):
            raise InputError(
                "the share is not known",
                where="share",
                found=share,
                allowed=", ".join(map(repr, get_args(Share))),
            )
        put = object.__setattr__
        put(self, "curve", as_curve(curve, "curve"))
        put(self, "hysteresis", hysteresis_of(self.curve, unloading, hysteresis_slope))
        put(self, "share", share)

    needs_mass = False
    needs_area = False
    needs_thickness = False

    @property
    def n_memory(self) -> int:
        """λ_max and F of the last step, with hysteresis; else nothing."""
        return 0 if self.hysteresis is None else 2

    def respond(self, inp: LawInput) -> LawOutput:
        """Forces whose sum is Γ(λ_max) to rounding, or what hysteresis makes of it."""
        n = inp.penetration.size
        if n == 0:
            none = np.zeros(0)
            return LawOutput(none, none, none, np.zeros((0, self.n_memory)), none, none)
        deepest = inp.penetration.max(keepdims=True)
        if self.hysteresis is None:
            moved = elastic_move(self.curve, deepest)
            memory = np.zeros((n, 0))
        else:
            past = remembered(inp, self.n_memory).max(axis=0)
            moved = self.hysteresis.move(past[:1], past[1:], deepest)
            memory = np.tile([deepest[0], moved.force[0]], (n, 1))
        force, stiffness, stored, lost = (self._shared(float(whole[0]), inp) for whole in moved)
        return LawOutput(force, stiffness, stored, memory, lost, np.zeros(n))

    def _shared(self, whole: float, inp: LawInput) -> FloatArray:
        if self.share == "penetration":
            return share(whole, inp.penetration, inp.area)
        one = np.zeros(inp.penetration.size)
        one[np.argmax(inp.penetration)] = whole
        return one
