"""Friction of points that carry as one: a contact whose law gives one force for all of them.

The point that carries passes from node to node as bodies slide and roll; what friction holds must
not stay behind with the nodes. It is that of one point: with the sum of the normal forces, their
mean normal, and the mean way of the points, weighted by their shares at both ends of the step, so
that its work is that of its forces on the points, to second order.
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.ordered import length, product
from contiga.contact.sparse import Sparse
from contiga.contact.state_rows import kept_of
from contiga.contact.touching import ContactRows, PreviousStep
from contiga.laws.friction import Friction, FrictionInput, FrictionOutput
from contiga.records import FloatArray


def grip_as_one(
    friction: Friction, points: ContactRows, inp: FrictionInput, past: PreviousStep | None
) -> FrictionOutput:
    """What friction answers for the whole, `inp` being what it would see of each point."""
    shares = _shares(inp.force)
    before, memory, ways = np.zeros((1, 3)), np.zeros((1, friction.n_memory)), shares
    if past is not None and points.old.any():
        (rows, force), normals, *_ = kept_of(past.state).carried
        before = _unit(product(_shares(force), Sparse(0, *normals).at(rows)))
        memory[0] = inp.memory[np.argmax(points.old)]  # all that were in contact have the same
        kept = Sparse(0, rows, force).at(points.rows)
        if kept.any():  # else all that carried have left
            ways = _shares(shares + _shares(kept))
    whole = friction.respond(
        FrictionInput(
            normal=_unit(product(shares, inp.normal)),
            normal_before=before,
            force=inp.force.sum(keepdims=True),
            stiffness=inp.stiffness.sum(keepdims=True),
            area=inp.area.sum(keepdims=True),
            path=product(ways, inp.path)[None],
            velocity=product(shares, inp.velocity)[None],
            dt=inp.dt,
            memory=memory,
        )
    )
    column = shares[:, None]
    return FrictionOutput(
        column * whole.force,
        shares * whole.stiffness,
        shares * whole.stored,
        shares * whole.lost,
        np.repeat(whole.memory, len(shares), axis=0),
    )


def _shares(force: FloatArray) -> FloatArray:
    """Shares (k,) of a sum, alike where there is none."""
    whole = force.sum()
    return force / whole if whole > 0.0 else np.full(len(force), 1.0 / max(len(force), 1))


def _unit(vector: FloatArray) -> FloatArray:
    """(1, 3) of length one; zero stays."""
    size = length(vector)
    return (vector / size if size > 0.0 else vector)[None]
