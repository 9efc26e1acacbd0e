"""Sums over the points that carry forces."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.contact.kernels import totals_nb


@pytest.mark.interpreted
def test_the_wrench_is_the_sum_of_forces_and_of_their_moments() -> None:
    rng = np.random.default_rng(2)
    points, force, about = rng.normal(size=(9, 3)), rng.normal(size=(4, 3)), rng.normal(size=3)
    pose = cg.motion.pose.rotation([1.0, 2.0, 3.0], 0.7, centre=(0.1, 0.2, 0.3))
    rows = np.array([0, 3, 4, 8], np.int32)
    total = totals_nb.wrench_of(rows, force, points, about, pose)
    arm = (points[rows] - about) @ pose[:3, :3].T
    np.testing.assert_allclose(total[:3], force.sum(axis=0), rtol=1e-14)
    np.testing.assert_allclose(total[3:], np.cross(arm, force).sum(axis=0), rtol=1e-13)
