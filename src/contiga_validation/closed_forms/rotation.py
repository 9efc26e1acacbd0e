"""Bodies that turn freely: tops, and their conserved quantities."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import quad
from scipy.special import ellipj, ellipk

import contiga as cg
from contiga_validation.closed_forms.case import (
    ROUNDING,
    TOLERANCE,
    Answer,
    Cases,
    order_of,
    relative,
    zero,
)
from contiga_validation.closed_forms.pictures import comparison, errors_over
from contiga_validation.closed_forms.scenes import crossing_time, free_body, rotations, spins
from contiga_validation.engine.arrays import FloatArray

CASES = Cases("Free rotation")
MOMENTS = np.array([1.0, 2.0, 3.0])
MANY_STEPS = 100_000


def top(moments: FloatArray, spin: FloatArray) -> cg.motion.Free:
    """Return the motion of a free body of mass 1 with principal moments, and a spin (3,)."""
    return cg.motion.Free(1.0, inertia=np.diag(moments), spin=spin)


def about(axis: FloatArray, angle: FloatArray) -> FloatArray:
    """Return rotation matrices (n, 3, 3) by angles (n,), rad, about a unit axis (Rodrigues)."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.asarray(np.eye(3) + s * K + (1.0 - c) * (K @ K))


# ---------------------------------------------------------------- symmetric top


@CASES.add(
    "top-symmetric",
    "Symmetric top",
    "R(t) = exp(L t/A) exp(e₃ L₃ (1/C − 1/A) t): precession |L|/A about L at a fixed tilt",
    'Moments 2, 2, 3; step "auto". The integrator is exact for two equal moments.',
)
def _symmetric() -> Answer:
    A, C, spin = 2.0, 3.0, np.array([0.4, 0.0, 2.0])
    history = free_body(top(np.array([A, A, C]), spin), end=20.0, step="auto").run().history
    t, orientation = history["time"], rotations(history)
    L = np.array([A, A, C]) * spin
    size = float(np.linalg.norm(L))
    # An even turn about L, after an even turn about the body's own axis.
    spin_rotation = about(np.array([0.0, 0.0, 1.0]), (1.0 / C - 1.0 / A) * L[2] * t)
    exact = about(L / size, size / A * t) @ spin_rotation
    tilt = np.degrees(np.arccos(np.clip(orientation[:, :, 2] @ L / size, -1.0, 1.0)))
    checks = (
        zero("orientation, all entries, all times", np.abs(orientation - exact).max(), 1e-10),
        relative("tilt of the axis to L, degrees", tilt[-1], tilt[0], 1e-9),
    )
    draw = comparison(
        ("t", "axis of the body"),
        [(f"{axis}, formula", t, exact[:, k, 2]) for k, axis in enumerate("xy")],
        [(f"{axis}, run", t, orientation[:, k, 2]) for k, axis in enumerate("xy")],
    )
    return Answer(checks, draw)


# ---------------------------------------------------------------- asymmetric top


class Euler:
    """Euler's top by Jacobi's functions (Landau & Lifshitz, Mechanics, § 37).

    Parameters
    ----------
    spin : (3,) angular velocity in body axes at any time, above the separatrix: L² > 2 E I₂
    """

    def __init__(self, spin: FloatArray) -> None:
        I1, I2, I3 = MOMENTS
        twice, square = float((MOMENTS * spin**2).sum()), float(((MOMENTS * spin) ** 2).sum())
        high, low = twice * I3 - square, square - twice * I1
        self.rate = math.sqrt((I3 - I2) * low / (I1 * I2 * I3))
        self.m = (I2 - I1) * high / ((I3 - I2) * low)
        self.sizes = np.sqrt(
            [high / (I1 * (I3 - I1)), high / (I2 * (I3 - I2)), low / (I3 * (I3 - I1))]
        )
        self.momentum = math.sqrt(square)
        self.quarter = float(ellipk(self.m)) / self.rate
        """Time from ω₂ = 0 to its largest value, a quarter of a period."""

    def spin(self, t: FloatArray | float) -> FloatArray:
        """Return angular velocities (n, 3) in body axes; ω₂ = 0 and rises at t = 0."""
        sn, cn, dn, _ = ellipj(self.rate * np.asarray(t), self.m)
        return np.asarray(self.sizes * np.stack([cn, sn, dn], axis=-1))

    def precession(self, t: float) -> float:
        """Return the angle, rad, by which the body's third axis precesses about L until `t`."""

        def rate(s: float) -> float:
            w = self.spin(s)
            transverse = (MOMENTS * w)[:2]
            return float(self.momentum * (transverse * w[:2]).sum() / (transverse**2).sum())

        return float(quad(rate, 0.0, t, epsabs=1e-12, epsrel=1e-12, limit=200)[0])


def _own_spins(history: cg.Result | dict[str, FloatArray]) -> FloatArray:
    """Return angular velocities (n, 3) in body axes."""
    return np.einsum("nji,nj->ni", rotations(history), spins(history))  # type: ignore[arg-type]


def _asymmetric_run(start: FloatArray, end: float, step: float | str) -> dict[str, FloatArray]:
    return free_body(top(MOMENTS, start), end=end, step=step).run().history


@CASES.add(
    "top-asymmetric",
    "Asymmetric top",
    "ω = (a₁ cn τ, a₂ sn τ, a₃ dn τ); precession by quadrature of L (I₁ω₁² + I₂ω₂²)/L⊥²",
    'Moments 1, 2, 3, one period of Jacobi\'s functions; step "auto".',
)
def _asymmetric() -> Answer:
    truth = Euler(np.array([1.0, 0.0, 1.0]))
    start, end = truth.spin(0.0), 4.0 * truth.quarter
    history = _asymmetric_run(start, end, "auto")
    t, measured = history["time"], _own_spins(history)
    exact, size = truth.spin(t), float(np.linalg.norm(start))
    L = MOMENTS * start / truth.momentum
    # The axes of a plane across L, the first towards the body's third axis at the start.
    first = np.array([0.0, 0.0, 1.0]) - L[2] * L
    first /= np.linalg.norm(first)
    axis = rotations(history)[-1][:, 2]
    angle = math.atan2(float(axis @ np.cross(L, first)), float(axis @ first))
    precession = truth.precession(end)
    miss = (angle - precession + math.pi) % (2.0 * math.pi) - math.pi

    def error(step: float) -> float:
        run = _asymmetric_run(start, end, step)
        return float(np.abs(_own_spins(run)[-1] - truth.spin(end)).max()) / size

    checks = (
        zero(
            "spin, body axes, one period, by its size",
            float(np.abs(measured - exact).max()) / size,
            TOLERANCE,
        ),
        relative("precession about L in a period, rad", precession + miss, precession),
    )
    draw = comparison(
        ("t", "spin, axes of the body"),
        [(f"ω{k + 1}, Jacobi", t, exact[:, k]) for k in range(3)],
        [(f"ω{k + 1}, run", t, measured[:, k]) for k in range(3)],
    )
    return Answer(checks, draw, order_of("spin after a period", end / 100, error))


# ---------------------------------------------------------------- Dzhanibekov


def _flips(history: dict[str, FloatArray]) -> tuple[float, float]:
    """Return the first two times at which the spin about the middle axis changes its sign."""
    w, t = _own_spins(history), history["time"]
    rates = (MOMENTS[2] - MOMENTS[0]) * w[:, 2] * w[:, 0] / MOMENTS[1]
    first = crossing_time(t, w[:, 1], rates)
    return first, crossing_time(t, w[:, 1], rates, after=int(np.searchsorted(t, first)) + 1)


@CASES.add(
    "dzhanibekov",
    "Flips about the middle axis",
    "first flip after K(k)/p, then one every 2 K(k)/p, p² = (I₃−I₂)(L²−2EI₁)/(I₁I₂I₃)",
    "Spin of 1 about the middle axis and of 0.02 about the third (Dzhanibekov's effect).",
)
def _dzhanibekov() -> Answer:
    start = np.array([0.0, 1.0, 0.02])
    truth = Euler(start)
    end = 3.5 * truth.quarter
    history = _asymmetric_run(start, end, "auto")
    first, second = _flips(history)
    t, measured = history["time"], _own_spins(history)
    exact = truth.spin(t + truth.quarter)

    def error(step: float) -> float:
        return abs(_flips(_asymmetric_run(start, end, step))[1] / (3.0 * truth.quarter) - 1.0)

    draw = comparison(
        ("t", "spin, axes of the body"),
        # A quarter on, ω₁ comes from zero with the other sign than the run's.
        [("ω2, Jacobi", t, exact[:, 1]), ("ω3, Jacobi", t, exact[:, 2])],
        [("ω2, run", t, measured[:, 1]), ("ω3, run", t, measured[:, 2])],
    )
    return Answer(
        (
            relative("first flip", first, truth.quarter),
            relative("time from flip to flip", second - first, 2.0 * truth.quarter),
        ),
        draw,
        order_of("time of the second flip", end / 200, error),
    )


# ---------------------------------------------------------------- what is kept


@CASES.add(
    "top-kept",
    "Energy and angular momentum of a free top",
    "L constant, E constant",
    f"Moments 1, 2, 3; {MANY_STEPS} steps of the default length.",
)
def _kept() -> Answer:
    start = np.array([0.3, 1.0, 0.4])
    # The default step of this spin.
    step = 0.025 / float(np.linalg.norm(start))
    simulation = free_body(top(MOMENTS, start), end=1e9, step=1e3)
    state = simulation.start()
    begin = state.energy.kinetic
    rows = []
    for n in range(1, MANY_STEPS + 1):
        state = simulation.step(state, dt=step)
        if n % 20 == 0:
            pose, twist = state.bodies["body"]
            R = pose[:3, :3]
            rows.append(
                (n, state.energy.kinetic / begin - 1.0, *(R @ (MOMENTS * (twist.spin @ R))))
            )
    n, energy, *L = np.array(rows).T
    L0 = MOMENTS * start
    momentum = np.abs(np.array(L).T - L0).max(axis=1) / np.linalg.norm(L0)
    # Means that fade in and out, so that a part of a swing at their ends counts for nothing.
    half = len(n) // 2
    fade = np.hanning(half)
    early, late = (float((fade * e).sum() / fade.sum()) for e in (energy[:half], energy[half:]))
    checks = (
        zero(f"angular momentum, {MANY_STEPS} steps", momentum.max(), ROUNDING),
        zero("energy, largest swing", np.abs(energy).max(), TOLERANCE),
        zero("energy, mean of the second half less the first", late - early, 1e-10),
    )
    part = 150
    curves = [
        ("energy, first steps", n[:part], energy[:part]),
        (f"energy, {MANY_STEPS} steps less {int(n[-1] - n[-part])}", n[:part], energy[-part:]),
    ]
    return Answer(checks, errors_over(("step", "relative error"), curves))
