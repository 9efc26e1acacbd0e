"""Two shells of splines, each master and slave of the other: the patch test on curved patches.

A sphere presses from within on another one that is larger by where their contact begins. Both are
an eighth of a sphere of three patches, of other elements. The solution is even: both grow, and the
pressure between them is the same everywhere. Nothing but rules of quadrature is inexact then.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import block_diag, csr_array, hstack, kron
from scipy.sparse.linalg import splu

import contiga as cg
from contiga.matter.iga import Shell, Symmetry, assemble_shell
from contiga.patches.basis import VALUE
from contiga.patches.net import on_net
from contiga_validation.closed_forms.shells import octant, refined

STIFF, REACH, THICK, PRESSURE = 2.0, 0.05, 0.05, 0.02
MIDDLES = {"u0": (0.0, 0.5), "u1": (1.0, 0.5), "v0": (0.5, 0.0), "v1": (0.5, 1.0)}


class Side(NamedTuple):
    """A shell in its planes of symmetry, and the body of its patches."""

    shell: Shell
    body: cg.Body
    free: np.ndarray
    """(m, 3) ways of control points."""


class Even(NamedTuple):
    """Two shells at rest."""

    unevenness: float
    """Mean square of the penetrations about their mean, over that, the root of it."""
    force: float
    moment: float
    """Largest components of the sums of all forces and moments of the contacts on both shells, over
    the sum of the sizes of forces."""


def side(radius: float, elements: int, *, inward: bool) -> Side:
    """An eighth of a sphere with its normals to the contact."""
    patches = [refined(patch, 4, (elements, elements)) for patch in octant(radius)]
    patches = [patch.flipped() for patch in patches] if inward else patches
    planes = []
    for k, patch in enumerate(patches):
        (u0, u1), (v0, v1) = patch.domain
        for edge, (u, v) in MIDDLES.items():
            middle = patch.evaluate([[u0 + u * (u1 - u0), v0 + v * (v1 - v0)]])[0]
            planes += [(edge, a, k) for a in np.flatnonzero(np.abs(middle) < 1e-9 * radius)]
    shell = assemble_shell(
        patches,
        material=cg.materials.Elastic(young=1.0 / THICK, poisson=0.3),
        density=1.0,
        thickness=THICK,
        symmetry=[Symmetry(edge, np.eye(3)[a], k) for edge, a, k in planes],
        slope_stiffness=1e5,
    )
    free = np.ones(shell.nodes.shape, bool)
    for edge, a, k in planes:
        free[shell.net.edge(edge, k), a] = False
    return Side(shell, cg.Body(patches), free)


def feet(state: cg.State, shell: Shell) -> csr_array:
    """(n, m) basis functions of a shell at the feet of points on it."""
    entries = []
    for k, piece in enumerate(shell.net.pieces):
        rows = np.flatnonzero(state.patch == k)
        at = on_net(piece, state.uv[rows])
        entries.append((at.values[:, VALUE], np.repeat(rows, at.control.shape[1]), at.control))
    values, rows, columns = (
        np.concatenate([part.ravel() for part in parts]) for parts in zip(*entries, strict=True)
    )
    return csr_array((values, (rows, columns)), shape=(len(state.patch), len(shell.mass)))


def springs(shell: Shell, q: np.ndarray) -> csr_array:
    """(3 n, 3 n) stiffness of the points of a shell along their radius, by half of the law."""
    x = shell.points(q)
    along = x / np.linalg.norm(x, axis=1)[:, None]
    stiff = 0.5 * STIFF * shell.contact.weight[:, None, None]
    return block_diag(stiff * along[:, :, None] * along[:, None, :], format="csr")


def pressed(elements: tuple[int, int]) -> Even:
    """Two spheres under a pressure from within, by Newton's method with fixed feet."""
    sides = side(1.0, elements[0], inward=False), side(1.0 + REACH, elements[1], inward=True)
    shells = [one.shell for one in sides]
    law, q = cg.PenaltyLaw(0.5 * STIFF, per_area=True), [shell.nodes for shell in shells]
    q[0] = 1.002 * q[0]
    contacts = [
        cg.Contact(
            sides[1 - i].body,
            cg.Slave.of(shells[i]),
            law=law,
            shell_thickness=2.0 * REACH,
            on_edge="hold",
            search="penetration",
        )
        for i in (0, 1)
    ]
    free = np.flatnonzero(np.concatenate([one.free for one in sides]).ravel())
    for _ in range(5):
        states = [
            contact.start(shells[i].points(q[i]), control_points=q[1 - i])
            for i, contact in enumerate(contacts)
        ]
        touch = [shells[i].spread(states[i].force) + states[1 - i].control_force for i in (0, 1)]
        force, stiffness = [], []
        for shell, where, push in zip(shells, q, touch, strict=True):
            force.append(shell.forces(shell.start(), where, 0.0 * where, 0.0).force + push)
            stiffness.append(shell.tangent(shell.start()._replace(points=where)))
        force[0] = force[0] + PRESSURE * shells[0].pressure(q[0])
        K = block_diag(stiffness, format="csr")
        for i in (0, 1):
            own = shells[i].contact.rows.matrix(len(shells[i].mass))
            other = -feet(states[i], shells[1 - i])
            gap = kron(hstack([own, other] if i == 0 else [other, own]), np.eye(3)).tocsr()
            K = K + gap.T @ springs(shells[i], q[i]) @ gap
        missed = np.concatenate(force).ravel()[free]
        step = np.zeros(K.shape[0])
        step[free] = splu(K[free][:, free].tocsc()).solve(missed)
        pushed = q  # the forces are those at these places, not after the step that follows
        q = [q[0] + step[: q[0].size].reshape(-1, 3), q[1] + step[q[0].size :].reshape(-1, 3)]
    assert np.abs(missed).max() < 1e-9 * PRESSURE
    depth = np.concatenate([state.penetration for state in states])
    size = sum(np.linalg.norm(push, axis=1).sum() for push in touch)
    moment = sum(
        np.cross(where, push).sum(axis=0) for where, push in zip(pushed, touch, strict=True)
    )
    return Even(
        float(depth.std() / depth.mean()),
        float(np.abs(touch[0].sum(axis=0) + touch[1].sum(axis=0)).max() / size),
        float(np.abs(moment).max() / size),
    )


def test_the_pressure_between_two_spheres_is_even_and_all_forces_balance() -> None:
    """2 elements a side of a patch within against 3 without, and so on."""
    found = [pressed(elements) for elements in ((1, 1), (2, 3), (4, 6))]
    errors = [one.unevenness for one in found]
    assert errors[2] < 1e-6
    assert errors[0] > 4.0 * errors[1] > 16.0 * errors[2]
    assert max(one.force for one in found) < 1e-13
    assert max(one.moment for one in found) < 1e-13
