"""Steps of the slider: which, how much of them, and where everything is in them."""

from __future__ import annotations

from base64 import b64decode
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contiga.io.out.vtkhdf import read_fields
from contiga.report.frames import MAX_FRAMES, chosen_steps, frames_of, packed, within
from contiga.report.peak import at_frame, stacked
from contiga.report.places import place_of
from contiga.report.run_folder import Units

from .conftest import DEPTHS, write_fields

UNITS = Units("mm", "g", "ms", "mm²", "N", "N·mm", "MPa")


def floats(text: str) -> np.ndarray:
    return np.frombuffer(b64decode(text), "<f4")


def put(base: np.ndarray, place: Any) -> np.ndarray:
    """What the page's script does with a part."""
    if isinstance(place, str):
        return floats(place).reshape(-1, 3)
    R, t = np.reshape(place[:9], (3, 3)), np.array(place[9:])
    return base @ R.T + t


@pytest.mark.parametrize("n", [1, 2, 40, 41, 1000])
@pytest.mark.parametrize("where", [0.0, 0.013, 0.5, 1.0])
def test_first_last_and_peak_are_among_the_steps(n: int, where: float) -> None:
    shown = round(where * (n - 1))
    chosen = chosen_steps(np.arange(n) ** 1.5, shown, MAX_FRAMES)
    assert len(chosen) <= MAX_FRAMES
    assert (np.diff(chosen) > 0).all()
    assert {0, shown, n - 1} <= set(chosen.tolist())
    if n > 2 * MAX_FRAMES:
        assert len(chosen) > MAX_FRAMES // 2


def test_short_steps_are_not_missed_in_a_long_run() -> None:
    # Flight of 1000 in long steps, an impact of 1 in 500 short ones, flight again.
    times = np.concatenate(
        [np.linspace(0, 999, 50), 999 + np.linspace(0.002, 1, 500), np.linspace(1020, 2000, 50)]
    )
    taken = times[chosen_steps(times, 0, MAX_FRAMES)]
    assert ((taken > 999) & (taken <= 1000)).sum() >= 12
    assert (taken <= 999).sum() >= 6
    assert (taken > 1000).sum() >= 6


def test_too_much_for_a_page_is_thinned_and_the_peak_kept() -> None:
    times = np.arange(40.0)
    kept = within(times, np.full(40, 10), 17, budget=150)
    assert 10 <= len(kept) <= 15
    assert {0, 17, 39} <= set(kept.tolist())
    np.testing.assert_array_equal(within(times, np.full(40, 10), 17, budget=400), np.arange(40))
    assert within(times, np.full(40, 10), 17, budget=20).tolist() == [17]


def test_a_rigid_motion_is_told_by_twelve_numbers() -> None:
    rng = np.random.default_rng(5)
    base = rng.normal((100.0, -30.0, 2.0), size=(40, 3))
    for flat in (False, True):
        given = base * [1.0, 1.0, 0.0] if flat else base
        R, t = Rotation.random(random_state=7).as_matrix(), np.array([3.0, -500.0, 12.0])
        place = place_of(given, given @ R.T + t)
        assert place.shape == (12,)
        np.testing.assert_allclose(put(given, place.tolist()), given @ R.T + t, atol=1e-10)
        assert np.linalg.det(place[:9].reshape(3, 3)) == pytest.approx(1.0)


def test_what_is_not_rigid_is_told_by_its_points() -> None:
    rng = np.random.default_rng(5)
    base = rng.normal(size=(40, 3))
    for points in (base * [1.0, 1.0, 1.001], base * [-1.0, 1.0, 1.0]):
        place = place_of(base, points)
        assert place.dtype == np.float32
        np.testing.assert_array_equal(place, points.astype(np.float32))
    lost = np.where(np.arange(40)[:, None] == 3, np.nan, base)
    np.testing.assert_array_equal(place_of(base, lost), lost.astype(np.float32))


@pytest.mark.parametrize("cloud", [False, True])
def test_every_step_comes_back_from_the_page(tmp_path: Path, cloud: bool) -> None:
    write_fields(tmp_path / "fields.vtkhdf", cloud=cloud)
    series = read_fields(tmp_path / "fields.vtkhdf")
    peak = at_frame(series, 2)
    frames = frames_of(series, None, 2, peak, UNITS)
    data = packed(frames, peak, UNITS)
    assert frames.first == 2
    assert frames.tops["penetration"] == max(DEPTHS)
    base = [floats(data[kind]).reshape(-1, 3) for kind in ("body", "slave")]
    for k, frame in enumerate(data["frames"]):
        scene = at_frame(series, k)
        assert not any(isinstance(place, str) for place in frame["places"]), "all is rigid"
        for kind, given, place in zip(("body", "slave"), base, frame["places"], strict=True):
            there = stacked(series, k, kind)[0]
            np.testing.assert_allclose(put(given, place), there, atol=1e-5)
        rows = np.frombuffer(b64decode(frame["rows"]), "<i4")
        np.testing.assert_array_equal(rows, np.flatnonzero(scene.in_contact))
        np.testing.assert_array_equal(
            floats(frame["values"]["penetration"]), scene.penetration[rows].astype(np.float32)
        )


def test_colours_end_where_the_greatest_of_all_steps_is(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf")
    series = read_fields(tmp_path / "fields.vtkhdf")
    frames = frames_of(series, None, 1, at_frame(series, 1), UNITS)
    assert frames.tops["penetration"] == max(DEPTHS) > DEPTHS[1]
