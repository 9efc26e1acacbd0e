"""Operations of a tracked point on a rational bicubic patch, counted from the kernels.

Their own text is run with numbers that count what is done to them, which needs no compiler:
``NUMBA_DISABLE_JIT=1 python -m benchmarks.operations`` prints the counts. `counted` does that.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
READ = {"point": 24, "last foot, normal, gap and status": 57, "patch": 4, "uv": 16}
WRITTEN = {"patch": 4, "uv": 16, "point": 24, "normal": 24, "gap": 8, "codes": 3}
"""Bytes of a point; what is read and written more than once counts once."""


class Counter:
    """How many operations there were: a sum, product, quotient or root is one, an fma two."""

    done = 0


class Number(float):
    """A float that counts."""

    def _new(self, value: float, cost: int = 1) -> Number:
        Counter.done += cost
        return Number(value)

    def __add__(self, other: float) -> Number:
        return self._new(float(self) + float(other))

    def __sub__(self, other: float) -> Number:
        return self._new(float(self) - float(other))

    def __rsub__(self, other: float) -> Number:
        return self._new(float(other) - float(self))

    def __mul__(self, other: float) -> Number:
        return self._new(float(self) * float(other))

    def __truediv__(self, other: float) -> Number:
        return self._new(float(self) / float(other))

    def __rtruediv__(self, other: float) -> Number:
        return self._new(float(other) / float(self))

    def __neg__(self) -> Number:
        return Number(-float(self))

    __radd__, __rmul__ = __add__, __mul__


def _fma(x: float, y: float, z: float) -> Number:
    Counter.done += 2
    return Number(float(x) * float(y) + float(z))


def _sqrt(x: float) -> Number:
    Counter.done += 1
    return Number(float(x) ** 0.5)


def counted() -> dict[str, float]:
    """Operations a point of a "round" of Newton, of the "record", and of the "proof"."""
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.operations"],
        env=dict(os.environ) | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    found: dict[str, float] = json.loads(done.stdout)
    return found


def _count(work: Any, *arguments: Any) -> int:
    Counter.done = 0
    work(*arguments)
    return Counter.done


def _named(module: Any, name: str) -> Any:
    """A kernel that only kernels call, as plain Python, which it is without the compiler."""
    assert os.environ.get("NUMBA_DISABLE_JIT") == "1", "compiled it would crash"
    return getattr(module, name)


def main() -> None:
    """Print the counts."""
    from contiga.elements.kernels import element_nb
    from contiga.search.certify.certify_records import Motion
    from contiga.search.certify.kernels import branch_nb
    from contiga.search.closest.kernels import newton_nb
    from contiga.search.track.kernels import lanes_nb

    for module in (element_nb, newton_nb):
        vars(module)["fma"] = _fma
    for module in (newton_nb, branch_nb):
        vars(module)["math"] = SimpleNamespace(sqrt=_sqrt, inf=math.inf)
    rng = np.random.default_rng(0)
    net = np.concatenate([rng.normal(size=48), [2.0], rng.uniform(0.0, 0.01, 15)])
    element = [Number(x) for x in (*net, *np.ones(lanes_nb.ELEMENT_SIZE - 64))]
    banks = lanes_nb.BANKS, lanes_nb.ROWS * lanes_nb.BANK_WIDTH
    lanes = [[Number(x) for x in bank] for bank in 0.1 * rng.random(banks)]
    vars(lanes_nb)["scratch"] = lambda n: [0.0] * n
    of_lanes = lanes, lanes_nb.BANKS, element
    three = [tuple(Number(x) for x in rng.normal(size=3)) for _ in range(4)]
    one = Number(1.0)
    ring = {
        "block": (-2.0, 2.0, -2.0, 2.0), "speed": (one, one), "pole": -1,
        "curvature": (Number(1e-3), Number(1e-3)), "room": Number(1e9), "ends": (0, 0, 0, 0),
        "width": (one, one),
    }  # fmt: skip
    uv = (Number(0.1), Number(0.2))
    motion = Motion((Number(0.1), Number(0.1)), Number(0.1), Number(0.1))
    proof = _count(_named(branch_nb, "motion_from"), *three, one)
    box = (-1.0, 1.0, -1.0, 1.0)
    proof += _count(_named(branch_nb, "path_within"), ring, box, uv, uv)
    proof += _count(_named(branch_nb, "ball_by_neighbourhood"), ring, box, uv, one, motion, one)
    counts = {
        "round": _count(_named(lanes_nb, "newton_rational"), *of_lanes) / lanes_nb.N_LANES,
        "record": _count(_named(lanes_nb, "finish_rational"), *of_lanes) / lanes_nb.N_LANES,
        "proof": proof,
    }
    print(json.dumps(counts))


def rounds(patch: Any, points: np.ndarray, uv: np.ndarray) -> float:
    """Mean rounds that sixteen points together take from their feet before, `uv`.

    By the rule of the kernel, worked out again: a step shorter than 1e-7 of the size is the last.
    """
    least = 1e-7 * np.linalg.norm(np.ptp(points, axis=0))
    needed = np.zeros(len(points), int)
    going = np.ones(len(points), bool)
    while going.any():
        d = patch.derivatives(np.clip(uv, 0.0, 1.0), 2)
        r = d[:, 0, 0] - points
        s, t = d[:, 1, 0], d[:, 0, 1]
        h = np.empty((len(points), 2, 2))
        h[:, 0, 0] = (s * s + r * d[:, 2, 0]).sum(1)
        h[:, 0, 1] = h[:, 1, 0] = (s * t + r * d[:, 1, 1]).sum(1)
        h[:, 1, 1] = (t * t + r * d[:, 0, 2]).sum(1)
        g = np.stack([(r * s).sum(1), (r * t).sum(1)], axis=1)
        step = -np.linalg.solve(h, g[..., None])[..., 0]
        length = np.hypot(*(step * np.stack([np.hypot.reduce(s.T), np.hypot.reduce(t.T)], 1)).T)
        needed[going] += 1
        uv = uv + np.where(going[:, None], step, 0.0)
        going &= (length > least) & (needed < 20)
    whole = needed[: len(needed) // 16 * 16]
    return float(whole.reshape(-1, 16).max(axis=1).mean())


if __name__ == "__main__":
    main()
