"""The force law: one total from the greatest penetration, shared by the points in contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from contiga.curves.characteristic import Characteristic, CurveLike, as_curve
from contiga.curves.hysteresis import Hysteresis, elastic_move, hysteresis_of
from contiga.errors import InputError
from contiga.laws.deepest import Deepest, deepest
from contiga.laws.law import remembered
from contiga.laws.share import share
from contiga.records import DepthSlopes, FloatArray, LawInput, LawOutput, LawTangent

Share = Literal["deepest", "penetration"]


@dataclass(frozen=True, init=False, eq=False)
class ForceLaw:
    """Total force from the greatest penetration (thesis, Eq. 3.1–3.3).

    F = Γ(λ_max), whatever the number of points in contact and their area. It is the gradient of the
    energy ∫Γ dλ_max and acts at the deepest point, along the normal there: the total force on a
    body follows the curve. Points within 0.5 % of the greatest depth share the force, so that it
    moves smoothly from one to the next; this raises λ_max by 0.5 % at most, and the sum of the
    forces by twice as much with a straight curve.

    Parameters
    ----------
    curve : Γ, force over penetration: a number, a table, a callable or a `Characteristic`
    unloading : Γ_u ≤ Γ, force on unloading; as `curve` if None
    hysteresis_slope : K, slope of the lines between the two curves, force over penetration; needed
        with `unloading`, and not below the steepest slope of either
    share : ``"deepest"`` (default) as above, or ``"penetration"``: F_i = F λ_i A_i / Σ λ_j A_j, as
        in the thesis. The sum of the magnitudes is F, the sum of the vectors less if the normals
        differ. These forces are not a gradient: points that move relative to each other gain or
        lose energy that no account contains

    Notes
    -----
    Without points in contact there are no forces. If all λ = 0, Γ(0) is shared equally, or by
    area; it is zero for most curves. See `share` for the case without areas.

    >>> depth, area = np.array([0.2, 0.4]), np.array([0.1, 0.1])
    >>> pressed = LawInput(depth, np.zeros(2), area, None, None, 0.0)
    >>> ForceLaw(0.6).respond(pressed).force.round(12)
    array([0.  , 0.24])
    >>> ForceLaw(0.6, share="penetration").respond(pressed).force.round(12)
    array([0.08, 0.16])

    Stiffness and energies of the total are shared like the force. So is friction with
    ``share="deepest"``: all loaded points stick and slip together, by their mean path. If points
    move relative to each other, the force moves from one to the other over 0.5 % of λ_max. This is
    stiffer than the curve, and limits the critical step by `LawOutput.stiffness_bound`.

    With `unloading` the total moves along lines of slope K between the curves: see
    `contiga.curves.hysteresis`. Each point remembers the last λ_max and F, which are not lost while
    one of the points stays in contact.

    Raises
    ------
    InputError
        An invalid curve, unloading above loading or below zero, K missing or too small, an unknown
        share.
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
        share: Share = "deepest",
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
    def acts_as_one(self) -> bool:
        """True if the loaded points stick and slip together, as one contact."""
        return self.share == "deepest"

    @property
    def n_memory(self) -> int:
        """Number of values by point: λ_max and F of the last step, only with hysteresis."""
        return 0 if self.hysteresis is None else 2

    def respond(self, inp: LawInput) -> LawOutput:
        """Return forces whose sum is Γ(λ_max), or lower on unloading with hysteresis.

        Shared by penetration the sum is exact to rounding; else λ_max is greater by up to 0.5 %,
        and the sum of the weights as well: up to 1 % together for a straight curve. The past of a
        hysteresis is the largest remembered λ_max and F. Shared by the deepest the output has a
        `stiffness_bound`.
        """
        n = inp.penetration.size
        if n == 0:
            none = np.zeros(0)
            return LawOutput(none, none, none, np.zeros((0, self.n_memory)), none, none)
        if self.share == "penetration":
            shares = share(1.0, inp.penetration, inp.area)
            weighted = Deepest(float(inp.penetration.max()), shares, 0.0, 0.0)
        else:
            weighted = deepest(inp.penetration)
        shares, depth = weighted.weight, np.array([weighted.depth])
        if self.hysteresis is None:
            response = elastic_move(self.curve, depth)
            memory = np.zeros((n, 0))
        else:
            past = remembered(inp, self.n_memory).max(axis=0)
            response = self.hysteresis.move(past[:1], past[1:], depth)
            memory = np.tile([depth[0], response.force[0]], (n, 1))
        force, stiffness, stored, lost = (float(column[0]) for column in response)
        fractions = shares / shares.sum()
        bound = tangent = None
        if self.acts_as_one:  # w wᵀ is bounded by the diagonal matrix w Σw
            curvature = force * weighted.curvature * (shares > 0.0)
            bound = stiffness * shares * shares.sum() + curvature
        if inp.wants_tangent:
            bend = self.curve.carried_bend(depth)
            if self.hysteresis is not None:
                bend = self.hysteresis.bend(depth, response.force)
            tangent = LawTangent(
                self._slopes(inp, weighted, force, stiffness),
                stiffness=self._slopes(inp, weighted, stiffness, float(bend[0])),
            )
        return LawOutput(
            force * shares,
            stiffness * shares,
            stored * fractions,
            memory,
            lost * fractions,
            np.zeros(n),
            bound,
            tangent,
        )

    def _slopes(self, inp: LawInput, weighted: Deepest, value: float, slope: float) -> DepthSlopes:
        """Return the derivatives of the points' shares of `value` with respect to their depths.

        `slope` is the derivative of `value` with respect to the greatest depth. The result is a
        diagonal and, unless one point carries all, products of two (share "deepest") or one (share
        "penetration") column pairs.
        """
        shares, depth = weighted.weight, inp.penetration
        if self.share == "penetration":
            area, of_deepest = inp.area, np.zeros(len(shares))
            if not (depth * area).any():  # then `share` uses depths alone
                area = np.ones(len(shares))
            total = float((depth * area).sum())
            own: FloatArray = value * area / total if total > 0.0 else np.zeros(len(shares))
            of_deepest[np.argmax(depth)] = slope
            return DepthSlopes(own, shares[:, None], (of_deepest - own)[:, None])
        is_loaded = shares > 0.0
        if weighted.layer == 0.0:  # one point carries all, and only its depth counts
            return DepthSlopes(slope * shares * is_loaded)
        # w wᵀ times the slope, and the second derivative of m times the value.
        y: FloatArray = np.where(is_loaded, depth, 0.0) / weighted.depth
        curvature = value / weighted.layer
        right = slope * shares + curvature * ((y * y).sum() * shares - y)
        sides = np.stack([shares, y], axis=1), np.stack([right, -curvature * shares], axis=1)
        return DepthSlopes(np.where(is_loaded, curvature, 0.0), *sides)
