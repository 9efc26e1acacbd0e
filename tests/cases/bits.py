"""Hashes of a little of everything the search and a contact give: ``bits.py SEED`` prints them.

SEED 0 takes the points as they are, any other in an order of its own; hashes are of the results in
the order as they are.
"""

from __future__ import annotations

import hashlib
import json
import sys

import numpy as np

import contiga as cg

TRACKED, SOUGHT, STEPS, SIDE = 20_000, 700, 4, 25


def main(seed: int) -> None:
    """Print the hashes by name."""
    values = {}
    for name, patch in (("polynomial", cg.shapes.bumpy_plate()), ("rational", cg.shapes.torus())):
        body = cg.Body([patch])
        p, q = _pairs(patch)
        order = _order(len(p), seed)
        near = body.project(p[order[:SOUGHT]])
        tracked = body.project(q[order], start=_starts(patch, order), mode="track")
        hits = body.first_hit(*_segments(p, q, order))
        values |= {
            f"{name} closest": _hash(near, order[:SOUGHT]),
            f"{name} tracked": _hash(tracked, order),
            f"{name} hits": _hash(hits, order[:SOUGHT]),
        }
    print(json.dumps(values | _contact(seed)))


def _pairs(patch: cg.NurbsSurface) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(7)
    uv = _parameters(patch)
    p = patch.evaluate(uv) + 0.03 * rng.normal(size=(TRACKED, 3))
    return p, p + 0.004 * rng.normal(size=p.shape)


def _parameters(patch: cg.NurbsSurface) -> np.ndarray:
    low, high = np.array(patch.domain).T
    return low + np.random.default_rng(6).random((TRACKED, 2)) * (high - low)


def _starts(patch: cg.NurbsSurface, order: np.ndarray) -> cg.Projection:
    uv = _parameters(patch)[order]
    n = len(uv)
    nothing, none = np.zeros((n, 3)), np.zeros(n, np.int8)
    return cg.Projection(
        np.zeros(n, np.int32), uv, nothing, nothing, np.zeros(n), none, none, np.zeros(n, bool)
    )


def _segments(p: np.ndarray, q: np.ndarray, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rows = order[:SOUGHT]
    return p[rows], p[rows] + 20.0 * (q[rows] - p[rows])


def _contact(seed: int) -> dict[str, str]:
    """A sphere rolled into a sheet of facets."""
    ball = cg.Body([cg.shapes.sphere(radius=0.5)])
    points = cg.clouds.sample(cg.shapes.plane(width=1.6, length=1.6), SIDE, SIDE)
    index = np.arange(SIDE**2).reshape(SIDE, SIDE)
    corners = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    facets = np.stack([c.ravel() for c in corners], axis=1)
    order = _order(len(points), seed)
    contact = cg.Contact(
        ball,
        cg.Slave(points[order], np.argsort(order)[facets], thickness=np.full(SIDE**2, 0.1)),
        law=cg.StressLaw([[0, 0], [0.2, 1.0], [1.0, 3.0]], damping=0.2),
        area=cg.FacetArea(on="master"),
    )
    state, own, sums = None, hashlib.sha256(), hashlib.sha256()
    for k in range(STEPS):
        pose = cg.motion.Rotate([[0, 0], [1, 10]], axis="y").pose(float(k))
        pose[2, 3] = 0.55 - 0.05 * k
        p_W = points[order]
        state = contact.start(p_W, pose) if state is None else contact.step(state, p_W, pose, 0.1)
        back = np.argsort(order)
        for values in (state.status, state.penetration, state.normal, state.foot, state.uv):
            own.update(np.ascontiguousarray(values[back]).tobytes())
        for values in (state.area, state.force, state.wrench, state.centre_of_pressure):
            sums.update(np.ascontiguousarray(values).tobytes())
    assert state.n_contact > 40
    return {"contact": own.hexdigest(), "sums over points": sums.hexdigest()}


def _order(n: int, seed: int) -> np.ndarray:
    # The first of them are searched for: they stay the first.
    rng = np.random.default_rng(seed)
    few = min(n, SOUGHT)
    if seed == 0:
        return np.arange(n)
    return np.concatenate((rng.permutation(few), few + rng.permutation(n - few)))


def _hash(found: cg.Projection | cg.Hit, order: np.ndarray) -> str:
    whole, back = hashlib.sha256(), np.argsort(order)
    for values in found:
        whole.update(np.ascontiguousarray(values[back]).tobytes())
    return whole.hexdigest()


if __name__ == "__main__":
    main(int(sys.argv[1]))
