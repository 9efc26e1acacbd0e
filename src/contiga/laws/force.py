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
    energy ∫Γ dλ_max and acts at the deepest point, along the normal there: a body pressed into
    another feels what the curve says. Points within 0.5 % of the greatest depth share it, so that
    it passes smoothly from one to the next; λ_max is greater by that much at most, and the sum of
    the forces by twice as much with a straight curve.

    Parameters
    ----------
    curve : Γ, force over penetration: a number, a table, a callable or a `Characteristic`
    unloading : Γ_u ≤ Γ, the force of an unloading; as `curve` if None
    hysteresis_slope : K, force over penetration between the two curves; goes with `unloading`, and
        is not below the steepest slope of either
    share : ``"deepest"`` (default) as above, or ``"penetration"``: F_i = F λ_i A_i / Σ λ_j A_j, as
        in the thesis. Those add up to F as numbers and not as vectors, to less where normals
        differ, and are no gradient: points that move against each other gain or lose energy that
        nothing accounts for

    Notes
    -----
    No points in contact: no forces. Points that only touch (all λ = 0): Γ(0), which is zero for
    most curves, shared alike, or by area; see `share` for what happens without areas.

    >>> depth, area = np.array([0.2, 0.4]), np.array([0.1, 0.1])
    >>> pressed = LawInput(depth, np.zeros(2), area, None, None, 0.0)
    >>> ForceLaw(0.6).respond(pressed).force.round(12)
    array([0.  , 0.24])
    >>> ForceLaw(0.6, share="penetration").respond(pressed).force.round(12)
    array([0.08, 0.16])

    Stiffness and energies are those of the whole, shared as the force is. So is friction with
    ``share="deepest"``: it sticks and slips as one, on the mean way of the points that carry. What
    shares the force passes it on over a way of 0.5 % of λ_max where points move against each other:
    that is stiffer than the curve, and part of the critical step, as `LawOutput.stiffness_bound`.

    With `unloading` the total moves along lines of slope K between the curves: see
    `contiga.curves.hysteresis`. The last λ_max and F stand in the memory of every point, so that
    they last while any point that was in contact then still is.

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
        """True if the loaded points are one contact, which sticks and slips as a whole."""
        return self.share == "deepest"

    @property
    def n_memory(self) -> int:
        """λ_max and F of the last step, with hysteresis; else nothing."""
        return 0 if self.hysteresis is None else 2

    def respond(self, inp: LawInput) -> LawOutput:
        """Forces whose sum is Γ(λ_max), lower on unloading with hysteresis.

        To rounding shared by penetration; else λ_max is greater by up to 0.5 %, and their sum by as
        much again: up to 1 % in all of a straight curve.
        """
        n = inp.penetration.size
        if n == 0:
            none = np.zeros(0)
            return LawOutput(none, none, none, np.zeros((0, self.n_memory)), none, none)
        most, shares, curvature, _ = found = self._shares(inp)
        depth = np.array([most])
        if self.hysteresis is None:
            moved = elastic_move(self.curve, depth)
            memory = np.zeros((n, 0))
        else:
            past = remembered(inp, self.n_memory).max(axis=0)
            moved = self.hysteresis.move(past[:1], past[1:], depth)
            memory = np.tile([depth[0], moved.force[0]], (n, 1))
        force, stiffness, stored, lost = (float(whole[0]) for whole in moved)
        part = shares / shares.sum()
        bound = tangent = None
        if self.acts_as_one:  # w wᵀ is no more than the diagonal of w Σw
            bound = stiffness * shares * shares.sum() + force * curvature * (shares > 0.0)
        if inp.wants_tangent:
            bend = self.curve.carried_bend(depth)
            if self.hysteresis is not None:
                bend = self.hysteresis.bend(depth, moved.force)
            tangent = LawTangent(
                self._slopes(inp, found, force, stiffness),
                stiffness=self._slopes(inp, found, stiffness, float(bend[0])),
            )
        return LawOutput(
            force * shares,
            stiffness * shares,
            stored * part,
            memory,
            lost * part,
            np.zeros(n),
            bound,
            tangent,
        )

    def _slopes(self, inp: LawInput, found: Deepest, value: float, slope: float) -> DepthSlopes:
        """Return the slopes of a shared total `value` with its `slope` over the greatest depth."""
        shares, depth = found.weight, inp.penetration
        if self.share == "penetration":
            extent, deepest_one = inp.area, np.zeros(len(shares))
            if not (depth * extent).any():  # then depths alone share, as `share` says
                extent = np.ones(len(shares))
            whole = float((depth * extent).sum())
            own: FloatArray = value * extent / whole if whole > 0.0 else np.zeros(len(shares))
            deepest_one[np.argmax(depth)] = slope
            return DepthSlopes(own, shares[:, None], (deepest_one - own)[:, None])
        on = shares > 0.0
        if found.layer == 0.0:  # one point carries all, and only its depth counts
            return DepthSlopes(slope * shares * on)
        # w wᵀ times the slope, and the second derivative of m times the value.
        y: FloatArray = np.where(on, depth, 0.0) / found.depth
        bent = value / found.layer
        right = slope * shares + bent * ((y * y).sum() * shares - y)
        sides = np.stack([shares, y], axis=1), np.stack([right, -bent * shares], axis=1)
        return DepthSlopes(np.where(on, bent, 0.0), *sides)

    def _shares(self, inp: LawInput) -> Deepest:
        """The greatest penetration (1,), what each point has of the force, and how that bends."""
        if self.share == "penetration":
            shares = share(1.0, inp.penetration, inp.area)
            return Deepest(float(inp.penetration.max()), shares, 0.0, 0.0)
        return deepest(inp.penetration)
