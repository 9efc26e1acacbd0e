"""Inertia tensors: principal moments, and what no solid can have."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.errors import InputError
from contiga.rigid.inertia import check_inertia, principal_moments


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e9])
def test_principal_moments_are_the_eigenvalues(seed, scale):
    half = np.random.default_rng(seed).normal(size=(3, 3)) * scale
    tensor = half + half.T
    expected = np.linalg.eigvalsh(tensor)
    assert np.abs(principal_moments(tensor) - expected).max() < 1e-14 * np.abs(expected).max()


@pytest.mark.parametrize("moments", [(1.0, -1.0, 0.0), (2.0, 2.0, -2.0), (0.0, 0.0, 0.0)])
def test_signs_of_equal_sizes_are_told_apart(moments):
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    tensor = turn @ np.diag(moments) @ turn.T
    assert np.abs(principal_moments(tensor) - np.sort(moments)).max() < 1e-14


def turned(*moments: float) -> np.ndarray:
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    return turn @ np.diag(moments) @ turn.T


@pytest.mark.parametrize(
    "moments", [(1, 1, 1), (1, 1, 2), (1, 2, 2.5), (1e-6, 1, 1), (1, 2, 3.000001)]
)
def test_what_a_solid_can_have_passes(moments):
    tensor = turned(*moments)
    found = check_inertia(tensor, "inertia")
    assert np.abs(found - tensor).max() < 1e-15 * max(moments)
    assert np.array_equal(found, found.T)


def test_lists_pass():
    assert check_inertia([[1, 0, 0], [0, 1, 0], [0, 0, 1]], "here").dtype == np.float64


@pytest.mark.parametrize(
    ("tensor", "pieces"),
    [
        (turned(1, 2, 3.1), ("head.inertia: ", "(1.0, 2.0, 3.1)", "the largest at most 3")),
        (turned(1, 2, 3.0001), ("larger than the sum",)),
        (turned(-1, 2, 2), ("positive about every axis", "(-1.0, 2.0, 2.0)", "-∫ x y dm")),
        (turned(0, 1, 1), ("positive about every axis",)),
        (np.zeros((3, 3)), ("positive about every axis",)),
        ([[1, 0.5, 0], [0, 1, 0], [0, 0, 1]], ("must be symmetric", "0.5")),
        (np.diag([1.0, 1.0, np.nan]), ("finite",)),
        (np.diag([1.0, 1.0, np.inf]), ("finite",)),
        (np.ones(6), ("(3, 3)", "found (6,)")),
        ("round", ("must be numbers", "'round'")),
        ([[1, 0], [0]], ("must be numbers",)),
    ],
    ids=range(11),
)
def test_what_no_solid_has_is_refused(tensor, pieces):
    with pytest.raises(InputError) as caught:
        check_inertia(tensor, "head.inertia")
    for piece in pieces:
        assert piece in str(caught.value)
