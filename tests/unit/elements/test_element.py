"""A Bézier element is the surface over its part of the patch, in every form."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.elements.extraction import elements_of
from contiga.elements.kernels import element_nb


def patch_of(seed, p, q, weights=2.0):
    rng = np.random.default_rng(seed)
    net = rng.normal(size=(p + 1, q + 1, 3))
    w = 10 ** rng.uniform(-weights / 2, weights / 2, (p + 1, q + 1))
    U, V = (np.repeat([0.0, 1.0], d + 1) for d in (p, q))
    return cg.NurbsSurface((p, q), (U, V), net, w)


@pytest.mark.interpreted
@pytest.mark.parametrize("degree", [(1, 1), (3, 3), (4, 5), (6, 3), (15, 2)])
def test_elements_evaluate_as_their_surface_in_every_form(degree):
    patch = patch_of(sum(degree), *degree, weights=1.0)
    body = cg.Body([patch])
    elements = elements_of(body, body.trim_tables)[0]
    h = np.empty((4, 6))
    for u, v in [(0.0, 0.0), (0.3, 0.8), (1.0, 0.5)]:
        element_nb.evaluate(elements, 0, u - 0.5, v - 0.5, h)
        D = patch.derivatives([[u, v]], order=2)[0]
        expected = np.stack([D[0, 0], D[1, 0], D[0, 1], D[2, 0], D[1, 1], D[0, 2]], axis=1)
        expected[:, 0] -= elements.table[0]["origin"]
        scale = 1.0 + np.abs(expected).max()
        np.testing.assert_allclose(h[:3], expected, rtol=0, atol=1e-10 * scale)


def spindle(off_axis=0.0):
    """A closed surface about z of one span from tip to tip, its tips off the axis by so much."""
    ball = cg.shapes.sphere()
    net = np.stack(
        [
            ball.control_points[:, 2] * [r, r, 0.0] + [0.0, 0.0, z]
            for r, z in ((off_axis, -1.0), (1.0, -1.0), (0.5, 1.0), (off_axis, 1.0))
        ],
        axis=1,
    )
    weights = np.repeat(ball.weights[:, 2:3] / ball.weights[0, 2], 4, axis=1)
    return cg.NurbsSurface((2, 3), (ball.knots[0], np.repeat([0.0, 1.0], 4)), net, weights)


@pytest.mark.interpreted
def test_beside_a_pole_a_tangent_keeps_its_digits_however_short_it_is():
    for patch in (cg.shapes.sphere(radius=3.0, centre=(10.0, -4.0, 7.0)), spindle()):
        body = cg.Body([patch])
        elements = elements_of(body, body.trim_tables)[0]
        assert (np.abs(elements.table["about"]).max(axis=1) == 0.5).all()
        h, far = np.empty((4, 6)), np.empty((4, 6))
        for e, row in enumerate(elements.table):
            side = row["about"][1]
            for tau in (1e-3, 1e-9, 1e-15):
                element_nb.evaluate(elements, e, 0.2, side * (1.0 - 2.0 * tau), h)
                tau = 0.5 - abs(side * (1.0 - 2.0 * tau))  # what is left of it in 64 bits
                # about the axis S_s is across it and across the way from the pole, and grows as τ
                element_nb.evaluate(elements, e, 0.2, side * (1.0 - 2.0 * 1e-6), far)
                length = np.linalg.norm(h[:3, 1])
                assert length / tau == pytest.approx(np.linalg.norm(far[:3, 1]) / 1e-6, rel=1e-2)
                assert abs(h[2, 1]) <= 1e-15 * length
                assert abs(h[:2, 1] @ h[:2, 2]) <= 1e-14 * length * np.linalg.norm(h[:3, 2])


@pytest.mark.interpreted
def test_an_element_between_two_poles_is_halved_and_one_with_short_sides_is_not():
    counts = []
    for off_axis in (1e-13, 1e-9):
        body = cg.Body([spindle(off_axis)])
        elements = elements_of(body, body.trim_tables)[0]
        counts.append((len(elements.table), set(elements.table["about"][:, 1].tolist())))
        h = np.empty((4, 6))
        for e, row in enumerate(elements.table):
            u, v = row["box"].reshape(2, 2) @ [0.3, 0.7]
            element_nb.evaluate(elements, e, 0.2, 0.2, h)
            there = body.patches[0].evaluate([[u, v]])[0] - row["origin"]
            np.testing.assert_allclose(h[:3, 0], there, atol=2e-13)
    assert counts == [(8, {-0.5, 0.5}), (4, {0.0})]


def test_elements_of_patches_of_any_degrees_are_those_of_each_alone():
    """Degrees that come and go, one spindle that is halved, several elements a patch."""
    degrees = [(1, 1), (3, 3), (6, 3), (3, 3), (1, 1), (2, 1)]
    patches = [patch_of(k, *each) for k, each in enumerate(degrees)]
    patches[3] = patches[3].insert_knots(u=[0.5], v=[0.25, 0.75])
    patches[5] = spindle()
    body = cg.Body(patches)
    elements, grid = elements_of(body, body.trim_tables)
    first = 0
    for k, patch in enumerate(patches):
        alone = cg.Body([patch])
        own, own_grid = elements_of(alone, alone.trim_tables)
        rows = elements.table[first : first + len(own.table)]
        assert grid.patches["first"][k] == first
        assert (rows["patch"] == k).all()
        for name in ("degree", "components", "form", "trim", "box", "origin", "about", "noise"):
            np.testing.assert_array_equal(rows[name], own.table[name])
        np.testing.assert_array_equal(rows["cubic"], own.table["cubic"])
        size = 4 * np.prod(rows[0]["degree"] + 1)
        for row, known in zip(rows, own.table, strict=True):
            for place in ("bernstein", "monomial"):
                assert (row[place] < 0) == (known[place] < 0)
                if known[place] >= 0:
                    here, there = elements.coefs[row[place] :], own.coefs[known[place] :]
                    np.testing.assert_array_equal(here[:size], there[:size])
        for axis in ("u", "v"):
            here, there = grid.patches[axis][k], own_grid.patches[axis][0]
            np.testing.assert_array_equal(grid.breaks[slice(*here)], own_grid.breaks[slice(*there)])
        first += len(own.table)
    assert first == len(elements.table)
