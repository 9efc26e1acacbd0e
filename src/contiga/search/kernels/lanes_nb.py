"""Newton's method on many points of one element at once: the fast lane of tracking.

Elements of degree up to three in each direction are kept as bicubics. Points are binned by
element and taken sixteen at a time: the coefficients are the same for all lanes, the lanes' data
lie one after the other in one work array, and the body of the lane loop has no branches, so the
compiler turns it into vector code without gathers: as long as these kernels are compiled by
themselves, and not within their callers. Lanes that want to leave the element go on from
there by themselves; those that meet an indefinite Hessian or do not descend are handed back, and
the careful walk takes them.
"""

from __future__ import annotations

from numba import types

from contiga.num.jit import inlined, lazy
from contiga.search.kernels.newton_nb import foot_record, newton_step, polynomial_at, rational_at

LANES = 16
# Rows of the work array, each LANES long.
ROW_S, ROW_T, ROW_X, ROW_Y, ROW_Z, ROW_F, ROW_STATE = 0, 1, 2, 3, 4, 5, 6
ROW_FOOT, ROW_NORMAL, ROW_GAP = 7, 10, 13
ROWS = 14


@inlined()
def _point(lanes, l):
    n = LANES
    return lanes[ROW_X * n + l], lanes[ROW_Y * n + l], lanes[ROW_Z * n + l]


@inlined()
def _round(lanes, l, x, y, z, tolerance):
    """One Newton round of lane l, from the derivatives x, y, z of the surface's coordinates."""
    n = LANES
    place = (lanes[l], lanes[n + l])
    so_far = (lanes[ROW_F * n + l], lanes[ROW_STATE * n + l])
    s, t, best, state = newton_step(place, so_far, _point(lanes, l), x, y, z, tolerance)
    lanes[l] = s
    lanes[n + l] = t
    lanes[ROW_F * n + l] = best
    lanes[ROW_STATE * n + l] = state


@inlined()
def _finish(lanes, l, x, y, z, tolerance):
    """Foot, normal and gap of lane l; it is given back if it misses by more than tolerated."""
    n = LANES
    state = lanes[ROW_STATE * n + l]
    n_x, n_y, n_z, gap, now = foot_record(_point(lanes, l), state, x, y, z, tolerance)
    lanes[ROW_STATE * n + l] = now
    lanes[ROW_FOOT * n + l] = x[0]
    lanes[(ROW_FOOT + 1) * n + l] = y[0]
    lanes[(ROW_FOOT + 2) * n + l] = z[0]
    lanes[ROW_NORMAL * n + l] = n_x
    lanes[(ROW_NORMAL + 1) * n + l] = n_y
    lanes[(ROW_NORMAL + 2) * n + l] = n_z
    lanes[ROW_GAP * n + l] = gap


@lazy(types.void)
def newton_rational(lanes, fours, k, tolerance):
    """One round on so many fours of lanes; k holds the coefficients of x, y, z, w, sixteen each.

    `tolerance` is the square of the accepted tangential miss.
    """
    for l in range(4 * fours):
        x, y, z = rational_at(k, lanes[l], lanes[LANES + l])
        _round(lanes, l, x, y, z, tolerance)


@lazy(types.void)
def newton_polynomial(lanes, fours, k, tolerance):
    """As `newton_rational`, for elements whose weight is one."""
    for l in range(4 * fours):
        x, y, z = polynomial_at(k, lanes[l], lanes[LANES + l])
        _round(lanes, l, x, y, z, tolerance)


@lazy(types.void)
def finish_rational(lanes, fours, k, tolerance):
    """The records of these lanes where they have come to; arguments as of `newton_rational`."""
    for l in range(4 * fours):
        x, y, z = rational_at(k, lanes[l], lanes[LANES + l])
        _finish(lanes, l, x, y, z, tolerance)


@lazy(types.void)
def finish_polynomial(lanes, fours, k, tolerance):
    """As `finish_rational`, for elements whose weight is one."""
    for l in range(4 * fours):
        x, y, z = polynomial_at(k, lanes[l], lanes[LANES + l])
        _finish(lanes, l, x, y, z, tolerance)
