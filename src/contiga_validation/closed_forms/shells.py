"""Shells of splines at rest: the obstacle course, large displacements, Hencky's membrane.

Newton's method on the control points, with the shell's own tangent. Expected numbers are the limits
of Kirchhoff-Love theory (Belytschko et al., CMAME 51, 1985, for the roof, the
cylinder and the hemisphere; Sze, Liu and Lo, Finite Elem. Anal. Des. 40, 2004, for large
displacements).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from math import comb

import numpy as np
from scipy.integrate import solve_bvp
from scipy.sparse.linalg import splu

import contiga as cg
from contiga.matter.iga import Shell, Symmetry, assemble_shell
from contiga_validation.closed_forms.at_rest import HENCKY, resting
from contiga_validation.closed_forms.case import (
    Answer,
    Cases,
    Order,
    order_of,
    relative,
    zero,
)
from contiga_validation.closed_forms.membranes import (
    BAG_THICKNESS,
    CORNER,
    HALF,
    POISSON,
    PRESSURE,
    RISE,
    SIDE,
    YOUNG,
)
from contiga_validation.closed_forms.pictures import Drawing, comparison
from contiga_validation.engine.arrays import FloatArray, IntArray

GROUP = "Shells of splines"
CASES = Cases(GROUP)

STIFF_SLOPES = 1e4
"""Relative stiffness of the springs that keep slopes: their compliance is below solver accuracy."""
BENCHMARK = 1e-3
"""Relative error allowed of the benchmarks."""

ROOF, CYLINDER, HEMISPHERE = 0.300588, 1.8249e-5, 0.092404
"""Deflections of the obstacle course, in the units of each problem."""
INNER_LIFT, OUTER_LIFT = 13.891, 17.528
"""Deflection of the slit annulus' loaded end at inner and outer radius (Sze, Liu and Lo)."""

Counts = tuple[int, int]


def refined(surface: cg.NurbsSurface, degree: int, counts: Counts) -> cg.NurbsSurface:
    """Return the surface refined to a degree in u and v and to `counts` elements."""
    inner = [
        low + (high - low) * np.arange(1, n) / n
        for (low, high), n in zip(surface.domain, counts, strict=True)
    ]
    p, q = surface.degrees
    return surface.k_refined((degree - p, degree - q), *inner)


def plate(degree: int, counts: Counts, size: tuple[float, float]) -> cg.NurbsSurface:
    """Return a rectangle from 0 to `size` in x and y."""
    width, length = size
    middle = (0.5 * width, 0.5 * length, 0.0)
    return refined(cg.shapes.plane(width=width, length=length, centre=middle), degree, counts)


def tube(
    radius: float, length: float, angles: tuple[float, float], degree: int, counts: Counts
) -> cg.NurbsSurface:
    """Return a part of a cylinder about y: u between the angles from z towards x, v along y."""
    start, end = angles
    arc = cg.shapes.arc(radius=radius, start=start, end=end, axis="y")
    return refined(cg.shapes.extruded(arc, (0.0, length, 0.0)), degree, counts)


def free_dofs(shell: Shell, *held: tuple[IntArray, str]) -> IntArray:
    """Return the numbers of the free degrees of freedom, given held control points and axes."""
    free = np.ones(shell.nodes.shape, np.bool_)
    for rows, axes in held:
        for axis in axes:
            free[rows, "xyz".index(axis)] = False
    return np.flatnonzero(free.ravel()).astype(np.int32)


def row_at(points: FloatArray, place: Sequence[float]) -> int:
    """Return the row of the point at a place, within 1e-9 of the largest coordinate.

    Raises
    ------
    ValueError
        No point is there.
    """
    distances = np.abs(points - place).sum(axis=1)
    row = int(np.argmin(distances))
    if distances[row] > 1e-9 * np.abs(points).max():
        raise ValueError(f"no point at {place}")
    return row


def linear_displacements(shell: Shell, free: IntArray, load: FloatArray) -> FloatArray:
    """Return displacements (m, 3) of control points by linear theory, from the undeformed shell.

    `free` numbers the free degrees of freedom; `load` (m, 3) are forces on control points.
    """
    stiffness = shell.tangent(shell.start())[free][:, free].tocsc()
    displacements = np.zeros(load.size)
    displacements[free] = splu(stiffness).solve(load.ravel()[free])
    return displacements.reshape(load.shape)


def newton_equilibrium(
    shell: Shell,
    free: IntArray,
    load: FloatArray,
    shares: Sequence[float],
    q: FloatArray | None = None,
) -> FloatArray:
    """Return control points (m, 3) at rest under the last share of a load, by Newton's method.

    Each share of `load` (m, 3) starts from the result of the one before, the first from `q` or the
    undeformed shell. Residuals are below 1e-7 of the largest load on a control point.

    Raises
    ------
    ArithmeticError
        A share does not converge in 40 iterations.
    """
    q = shell.nodes.copy() if q is None else q.copy()
    start, still = shell.start(), np.zeros_like(q)
    for share in shares:
        for _ in range(40):
            force = shell.forces(start, q, still, 0.0).force + share * load
            residual = force.ravel()[free]
            if np.abs(residual).max() < 1e-7 * np.abs(load).max():
                break
            stiffness = shell.tangent(start._replace(points=q))[free][:, free].tocsc()
            q.ravel()[free] += splu(stiffness).solve(residual)
        else:
            raise ArithmeticError("does not come to rest")
    return q


def in_elements(
    what: str, at: Callable[[int], float], exact: float, counts: Sequence[int], least: float
) -> tuple[Order, dict[int, float]]:
    """Return the order in 1/n of the error of `at(n)`, and these numbers by n.

    `counts` are numbers n of elements along a side, each twice the one before.
    """
    values = {n: at(n) for n in counts}
    order = order_of(
        what,
        1.0 / counts[0],
        lambda width: abs(values[round(1.0 / width)] / exact - 1.0),
        len(counts),
        least=least,
    )
    return order, values


def _over_elements(what: str, numbers: dict[int, float], exact: float) -> Drawing:
    """Return a drawing of a number over the elements along a side, with the exact one as a line."""
    counts = np.array(list(numbers), np.float64)
    ends = np.array([0.0, 1.1 * counts[-1]])
    return comparison(
        ("elements a side", what),
        [("converged", ends, np.full(2, exact))],
        [("run", counts, np.array(list(numbers.values())))],
    )


def roof(degree: int, count: int, rule: int | None = None) -> float:
    """Return the deflection of the middle of a free edge of Scordelis and Lo's roof."""
    half = math.radians(40.0)
    arch = tube(25.0, 50.0, (-half, half), degree, (count, count))
    shell = assemble_shell(
        [arch],
        material=cg.materials.Elastic(young=4.32e8),
        density=1.0,
        thickness=0.25,
        rule=rule,
    )
    edge = shell.net.edge
    free = free_dofs(shell, (edge("v0"), "xz"), (edge("v1"), "xz"), (edge("v0")[:1], "y"))
    weight = shell.spread(shell.contact.weight[:, None] * np.array([0.0, 0.0, -90.0]))
    displacements = linear_displacements(shell, free, weight)
    sample = shell.drawn(2)
    place = [25.0 * math.sin(half), 25.0, 25.0 * math.cos(half)]
    return -float(sample.points(displacements)[row_at(sample.points(shell.nodes), place), 2])


@CASES.add(
    "shell-roof",
    "Scordelis and Lo's roof",
    "w = 0.300588",
    "Linear theory; a patch of degree 3, up to 16 × 16 elements, between two diaphragms.",
)
def _roof() -> Answer:
    order, deflections = in_elements("way", lambda n: roof(3, n), ROOF, (4, 8, 16), 3.9)
    checks = (
        relative("middle of a free edge, 16 × 16 of degree 3", deflections[16], ROOF),
        relative("8 × 8 of degree 4", roof(4, 8), ROOF),
    )
    return Answer(checks, _over_elements("way down", deflections, ROOF), order)


def _pinched_cylinder(count: int) -> float:
    """Return the deflection under two unit loads on a cylinder between diaphragms, by an eighth."""
    part = tube(300.0, 300.0, (0.0, 0.5 * math.pi), 3, (count, count))
    x, y, z = np.eye(3)
    shell = assemble_shell(
        [part],
        material=cg.materials.Elastic(young=3e6, poisson=0.3),
        density=1.0,
        thickness=3.0,
        symmetry=[Symmetry("u0", x), Symmetry("u1", z), Symmetry("v1", y)],
        slope_stiffness=STIFF_SLOPES,
    )
    edge = shell.net.edge
    held = (edge("v0"), "xz"), (edge("v1"), "y"), (edge("u0"), "x"), (edge("u1"), "z")
    top = row_at(shell.nodes, (0.0, 300.0, 300.0))
    load = np.zeros_like(shell.nodes)
    load[top, 2] = -0.25
    return -float(linear_displacements(shell, free_dofs(shell, *held), load)[top, 2])


@CASES.add(
    "shell-cylinder",
    "A pinched cylinder between diaphragms",
    "w = 1.8249e-5",
    "Linear theory; an eighth of it, degree 3, up to 32 × 32 elements, whose planes of symmetry "
    "are kept by springs. Under a point load the order is that of the load, 2, at any degree.",
)
def _cylinder() -> Answer:
    order, deflections = in_elements("way", _pinched_cylinder, CYLINDER, (8, 16, 32), 1.9)
    checks = (relative("under the load, 32 × 32", deflections[32], CYLINDER, BENCHMARK),)
    return Answer(checks, _over_elements("way in", deflections, CYLINDER), order)


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the Bernstein coefficients of the product of two polynomials in u and v."""
    (m, n), (k, l) = (np.array(each.shape) - 1 for each in (a, b))
    out = np.zeros((m + k + 1, n + l + 1))
    for i, j, r, s in np.ndindex(m + 1, n + 1, k + 1, l + 1):
        share = comb(m, i) * comb(k, r) / comb(m + k, i + r)
        share *= comb(n, j) * comb(l, s) / comb(n + l, j + s)
        out[i + r, j + s] += share * a[i, j] * b[r, s]
    return out


def octant(radius: float) -> list[cg.NurbsSurface]:
    """Return an eighth of a sphere about the origin, x, y, z ≥ 0, by three patches without a pole.

    They are the stereographic projection of three patches of a quarter of a disc, of degree 2 or 4.
    """
    c, t = math.cos(math.pi / 8.0), math.tan(math.pi / 8.0)
    centre, middle, rim = [0.42, 0.42], [math.sqrt(0.5)] * 2, np.array([[1.0, 1.0], [c, c], [1, 1]])
    halves = [0.5 * (0.45 + 0.42), 0.5 * 0.42]
    flat = [
        (np.array([[[0, 0], [0, 0.45]], [[0.45, 0], centre]]), np.ones((2, 2))),
        (np.array([[[0.45, 0], halves, centre], [[1, 0], [1, t], middle]]), rim[:, ::-1].T),
        (np.array([[centre, halves[::-1], [0, 0.45]], [middle, [t, 1], [0, 1]]]), rim.T),
    ]
    patches = []
    for points, patch_weights in flat:
        weights = np.array(patch_weights)
        if weights.shape[1] == 3:
            weights[0] = 1.0
        x, y = points[:, :, 0] * weights, points[:, :, 1] * weights
        xx, yy, ww = _product(x, x), _product(y, y), _product(weights, weights)
        denominator = ww + xx + yy
        net = np.stack([2.0 * _product(x, weights), 2.0 * _product(y, weights), ww - xx - yy], 2)
        degrees = denominator.shape[0] - 1, denominator.shape[1] - 1
        u, v = ([0.0] * (p + 1) + [1.0] * (p + 1) for p in degrees)
        patches.append(
            cg.NurbsSurface(degrees, (u, v), radius * net / denominator[:, :, None], denominator)
        )
    return patches


def _pinched_hemisphere(count: int) -> float:
    """Return the deflection under two pairs of loads on a hemisphere's equator, by a quarter."""
    patches = [refined(patch, 4, (count, count)) for patch in octant(10.0)]
    x, y, _ = np.eye(3)
    planes = [("v0", y, 0), ("u0", x, 0), ("v0", y, 1), ("v1", x, 2)]
    shell = assemble_shell(
        patches,
        material=cg.materials.Elastic(young=6.825e7, poisson=0.3),
        density=1.0,
        thickness=0.04,
        symmetry=[Symmetry(*plane) for plane in planes],
        slope_stiffness=STIFF_SLOPES,
    )
    held = [(shell.net.edge(edge, k), "xyz"[int(np.argmax(n))]) for edge, n, k in planes]
    held.append((np.array([row_at(shell.nodes, (0.0, 0.0, 10.0))]), "z"))
    load = np.zeros_like(shell.nodes)
    pulled = row_at(shell.nodes, (10.0, 0.0, 0.0))
    load[pulled, 0], load[row_at(shell.nodes, (0.0, 10.0, 0.0)), 1] = 1.0, -1.0
    return float(linear_displacements(shell, free_dofs(shell, *held), load)[pulled, 0])


@CASES.add(
    "shell-hemisphere",
    "A pinched hemisphere without a hole",
    "u = 0.092404",
    "Linear theory; a quarter of it by three patches of degree 4 without a pole, up to 8 × 8 "
    "elements each, that keep their slopes by springs.",
)
def _hemisphere() -> Answer:
    order, deflections = in_elements("way", _pinched_hemisphere, HEMISPHERE, (2, 4, 8), 1.9)
    checks = (relative("under a load, 3 × 8 × 8", deflections[8], HEMISPHERE, BENCHMARK),)
    return Answer(checks, _over_elements("way out", deflections, HEMISPHERE), order)


def _along_edge(shell: Shell, strip: cg.NurbsSurface, force: float) -> FloatArray:
    """Return forces (m, 3) of a load along z, `force` in all, uniform along edge u1 of the patch.

    ∫ N of a basis function is the distance of its last knot from its first over the degree plus 1.
    """
    knots, degree = strip.knots[1], strip.degrees[1]
    spans = knots[degree + 1 :] - knots[: -degree - 1]
    load = np.zeros_like(shell.nodes)
    load[shell.net.control[0][-1], 2] = force * spans / spans.sum()
    return load


LENGTH, FLEXURE, TENSION, PULL = 10.0, 100.0, 1.2e5, 4.0
"""Sze's cantilever: length, E I, E A, and the load at its end."""


def _elastica() -> FloatArray:
    """Return points (k, 2), along and up, of the elastica with the shell's energy, clamp to end.

    It is the exact solution for Sze's cantilever under `PULL`. With its angle θ(s) and stretch λ(s)
    the energy is E I (λ θ′)²/2 + E A ((λ² − 1)/2)²/2: M = E I λ² θ′, M′ = −P λ cos θ, and λ from
    P sin θ = E A λ (λ² − 1)/2 + E I λ θ′².
    """

    def stretch(angle: FloatArray, moment: FloatArray) -> FloatArray:
        ratio = np.ones_like(angle)
        for _ in range(8):
            along = 0.5 * TENSION * ratio * (ratio**2 - 1.0) + moment**2 / (FLEXURE * ratio**3)
            ratio -= (along - PULL * np.sin(angle)) / (TENSION * (1.5 * ratio**2 - 0.5))
        return ratio

    def rates(_: FloatArray, y: FloatArray) -> FloatArray:
        angle, moment = y[:2]
        ratio = stretch(angle, moment)
        along, up = np.cos(angle), np.sin(angle)
        turn = moment / (FLEXURE * ratio**3)
        return np.array([turn, -PULL * along, along, up]) * ratio

    def ends(clamp: FloatArray, end: FloatArray) -> FloatArray:
        return np.array([clamp[0], end[1], clamp[2], clamp[3]])

    s = np.linspace(0.0, LENGTH, 200)
    guess = np.stack([0.1 * s, 0.0 * s, s, 0.05 * s**2])
    return np.asarray(solve_bvp(rates, ends, s, guess, tol=1e-8, max_nodes=10**5).y[2:].T)


def _cantilever(count: int) -> FloatArray:
    """Return one row (k, 3) of control points of Sze's cantilever under its load, clamp to end."""
    strip = plate(3, (count, 1), (LENGTH, 1.0))
    steel = cg.materials.Elastic(young=1.2e6)
    shell = assemble_shell([strip], material=steel, density=1.0, thickness=0.1)
    free = free_dofs(shell, (shell.net.edge("u0", rows=2), "xyz"))
    q = newton_equilibrium(
        shell, free, _along_edge(shell, strip, PULL), [k / 8 for k in range(1, 9)]
    )
    return np.asarray(q[shell.net.control[0][:, 0]])


@CASES.add(
    "shell-cantilever",
    "A cantilever that bends far",
    "E I (λ θ′)²/2 + E A ((λ² − 1)/2)²/2 − P z is least: 3.28954 back, 6.69989 up",
    "Sze's first case under P = 4, one row of up to 16 elements of degree 3, clamped by two rows "
    "of control points, beside the elastica of the same energy. Published are 3.286 and 6.698.",
)
def _bent_far() -> Answer:
    exact = _elastica()
    back, up = LENGTH - exact[-1, 0], exact[-1, 1]
    shapes = {n: _cantilever(n) for n in (4, 8, 16)}
    end_displacements = {n: np.array([LENGTH - q[-1, 0], q[-1, 2]]) for n, q in shapes.items()}
    order = order_of(
        "ways, by the length of elements",
        0.25,
        lambda width: float(np.abs(end_displacements[round(1.0 / width)] / [back, up] - 1.0).max()),
        least=3.9,
    )
    checks = (
        relative("way back, 16 elements", end_displacements[16][0], back),
        relative("way up, 16 elements", end_displacements[16][1], up),
    )
    draw = comparison(
        ("along", "up"),
        [("elastica", exact[:, 0], exact[:, 1])],
        [("16 elements", shapes[16][:, 0], shapes[16][:, 2])],
    )
    return Answer(checks, draw, order)


INNER_RADIUS, OUTER_RADIUS, SLIT = 6.0, 10.0, 1e-4
"""Radii of the annulus, and the angle of its slit, rad, too wide to be joined."""


def _annulus(around: int, across: int) -> cg.NurbsSurface:
    """Return a ring from angle 0 to 2π, less the slit, of cubic splines through points of circles.

    It has `around` elements in u, along the circles, and `across` ones in v, of degree 3.
    """
    knots = np.concatenate([np.zeros(3), np.linspace(0.0, 1.0, around + 1), np.ones(3)])
    at = cg.knots.greville(knots, 3)
    turns = (2.0 * math.pi - SLIT) * at
    circle = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    points = np.zeros((len(at), 2, 3))
    points[:, :, :2] = np.linalg.solve(cg.knots.basis(knots, 3, at)[:, 0], circle)[:, None]
    points *= np.array([INNER_RADIUS, OUTER_RADIUS])[:, None]
    ring = cg.NurbsSurface((3, 1), (knots, [0.0, 0.0, 1.0, 1.0]), points)
    return ring.k_refined((0, 2), [], np.arange(1, across) / across)


def _lifted(around: int, across: int) -> tuple[FloatArray, FloatArray]:
    """Lift the slit annulus in 16 steps; return shares (16,) of the load and lifts (16, 2).

    Lifts are those of the loaded side of the slit, at the inner and the outer radius.
    """
    ring = _annulus(around, across)
    shell = assemble_shell(
        [ring], material=cg.materials.Elastic(young=21e6), density=1.0, thickness=0.03, rule=3
    )
    free = free_dofs(shell, (shell.net.edge("u0", rows=2), "xyz"))
    load, q, lifts = _along_edge(shell, ring, 0.8 * (OUTER_RADIUS - INNER_RADIUS)), None, []
    shares = (np.arange(1, 17) / 16.0) ** 1.5
    for share in shares:
        q = newton_equilibrium(shell, free, load, [share], q)
        lifts.append(q[shell.net.control[0][-1, [0, -1]], 2])
    return shares, np.array(lifts)


@CASES.add(
    "shell-annulus",
    "A slit annulus that is lifted far",
    "w = 13.891 within, 17.528 without",
    "Sze's second case, a load of 0.8 a length along one side of the slit, the other clamped. "
    "Published are numbers of 10 × 80 elements of reduced integration; 48 × 6 elements of degree 3 "
    "are 0.4 % below, and finer nets of degree 3 and 4 go to 13.843 and 17.481.",
)
def _slit() -> Answer:
    shares, lifts = _lifted(48, 6)
    inner_lift, outer_lift = lifts[-1]
    checks = (
        relative("way up within", inner_lift, INNER_LIFT, 6e-3),
        relative("way up without", outer_lift, OUTER_LIFT, 6e-3),
    )
    ends = np.array([0.0, 1.0])
    draw = comparison(
        ("load over the largest", "way up"),
        [
            ("published within", ends, np.full(2, INNER_LIFT)),
            ("without", ends, np.full(2, OUTER_LIFT)),
        ],
        [("within", shares, lifts[:, 0]), ("without", shares, lifts[:, 1])],
    )
    return Answer(checks, draw)


def disc(degree: int, count: int) -> cg.NurbsSurface:
    """Return a disc of radius 1 in z = 0 as one four-sided patch of `count` × `count` elements."""
    c = math.sqrt(0.5)
    points = np.zeros((3, 3, 3))
    points[:, :, :2] = [
        [(-c, -c), (-2.0 * c, 0.0), (-c, c)],
        [(0.0, -2.0 * c), (0.0, 0.0), (0.0, 2.0 * c)],
        [(c, -c), (2.0 * c, 0.0), (c, c)],
    ]
    weights = [[1.0, c, 1.0], [c, 1.0, c], [1.0, c, 1.0]]
    knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    return refined(cg.NurbsSurface((2, 2), (knots, knots), points, weights), degree, (count, count))


def rim(shell: Shell) -> IntArray:
    """Return the control points on all edges of the only patch of a shell, ascending."""
    return np.unique(np.concatenate([shell.net.edge(name) for name in ("u0", "u1", "v0", "v1")]))


SMALL_RISE = 5e-3
"""Rise w₀/a of Hencky's membrane, whose theory is of small rises."""


def _hencky(count: int) -> tuple[FloatArray, FloatArray]:
    """Return radii and rises over (q a/E h)^⅓, (k,), of points of a membrane under pressure."""
    thickness_value = 0.01
    rubber = cg.materials.Elastic(young=1.0 / thickness_value, poisson=0.3)
    shell = assemble_shell(
        [disc(3, count)], material=rubber, density=1.0, thickness=thickness_value, bending=0.0
    )
    scale = SMALL_RISE / HENCKY
    load = shell.spread(shell.contact.weight[:, None] * np.array([0.0, 0.0, scale**3]))
    guess = shell.nodes.copy()
    guess[:, 2] = SMALL_RISE * (1.0 - (shell.net.sites**2).sum(axis=1))
    q = newton_equilibrium(shell, free_dofs(shell, (rim(shell), "xyz")), load, [1.0], guess)
    sample = shell.drawn(2)
    radii = np.sqrt((sample.points(shell.nodes)[:, :2] ** 2).sum(axis=1))
    return radii, sample.points(q)[:, 2] / scale


@CASES.add(
    "shell-hencky",
    "A clamped membrane of splines under pressure",
    "w₀/a = 0.653443 (q a/E h)^⅓ at ν = 0.3",
    "Hencky's problem with a rise of a two-hundredth: a disc of one patch of degree 3 without "
    "bending, up to 8 × 8 elements.",
)
def _drumhead() -> Answer:
    profiles = {n: _hencky(n) for n in (2, 4, 8)}
    rises = {n: float(w[np.argmin(r)]) for n, (r, w) in profiles.items()}
    order = order_of(
        "rise, by the size of elements",
        0.5,
        lambda width: abs(rises[round(1.0 / width)] / HENCKY - 1.0),
    )
    checks = (relative("w₀/a over (q a/E h)^⅓, 8 × 8", rises[8], HENCKY),)
    return Answer(checks, _over_elements("w₀/a (E h/q a)^⅓", rises, HENCKY), order)


def _blown_up(count: int) -> tuple[FloatArray, FloatArray]:
    """Return flat nodes (k, 3) of a quarter of one airbag side, and their displacements (k, 3)."""
    slave = cg.Slave(surfaces=[plate(2, (count, count), (HALF, HALF))])
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=YOUNG, poisson=POISSON, compression=False),
        density=1e3,
        thickness=BAG_THICKNESS,
        bending=0.0,
        fixed=[
            {"edge": edge, "hold": [way]}
            for edge, way in (("u0", "x"), ("v0", "y"), ("u1", "z"), ("v1", "z"))
        ],
        loads=cg.motion.Pressure(-PRESSURE),
    )
    rest = resting(slave, motion, 1e-3).slaves["it"].points
    return slave.points, rest - slave.points


@CASES.add(
    "shell-airbag",
    "A square airbag of splines",
    "w = 0.2166 m, corner −0.0348 m, mid-side −0.122 m",
    "The airbag of triangles above as 8 × 8 and 16 × 16 elements of degree 2 without bending, "
    "which come to rest from flat. Fine folds make the ways of corners and sides differ from net "
    "to net, the rise of the middle by a thousandth.",
)
def _bag() -> Answer:
    (wide, coarse), (flat, fine) = _blown_up(8), _blown_up(16)

    def at(points: FloatArray, displacements: FloatArray, x: float, y: float) -> FloatArray:
        return np.asarray(displacements[row_at(points, (x * HALF, y * HALF, 0.0))])

    corner = at(flat, fine, 1.0, 1.0)
    checks = (
        relative("rise of the middle, 16 × 16", at(flat, fine, 0.0, 0.0)[2], RISE, 1e-3),
        relative("rise of the middle, 8 × 8", at(wide, coarse, 0.0, 0.0)[2], RISE, 3e-3),
        relative("way of a corner, along x, 16 × 16", corner[0], CORNER, 0.04),
        relative("way of the middle of a side, 16 × 16", at(flat, fine, 1.0, 0.0)[0], SIDE, 0.06),
        zero("how much a corner goes farther along y", corner[1] - corner[0], 1e-4),
    )
    rows = [np.flatnonzero(points[:, 1] == 0.0) for points in (flat, wide)]
    draw = comparison(
        ("x", "z"),
        [("published rise", np.array([0.0, HALF]), np.full(2, RISE))],
        [
            (name, (points + displacements)[row, 0], displacements[row, 2])
            for name, points, displacements, row in zip(
                ("16 × 16", "8 × 8"), (flat, wide), (fine, coarse), rows, strict=True
            )
        ],
    )
    return Answer(checks, draw)
