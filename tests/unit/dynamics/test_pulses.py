"""Pulses: closed forms, ends of tables, files with units."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.dynamics import Accelerated, Translate, Velocity, check_covers, read_pulse
from contiga.errors import FileError, InputError, UnitError

TIMES = np.linspace(-1.0, 6.0, 57)


def test_a_constant_velocity_goes_evenly_before_within_and_after() -> None:
    motion = Velocity([[1.0, 3.0], [4.0, 3.0]], direction=[0, 0, -2])
    for t in TIMES:
        np.testing.assert_allclose(motion.pose(t)[:3, 3], [0, 0, -3.0 * (t - 1.0)], atol=1e-14)
        np.testing.assert_array_equal(motion.twist(t).velocity, [0, 0, -3])
        np.testing.assert_array_equal(motion.acceleration(t), np.zeros(3))
        assert not motion.twist(t).spin.any()
        np.testing.assert_array_equal(motion.pose(t)[:3, :3], np.eye(3))


def test_a_linear_velocity_is_a_parabola() -> None:
    motion = Velocity([[0.0, 1.0, 0.0, 0.0], [4.0, 1.0, 8.0, 0.0]])
    for t in np.linspace(0.0, 4.0, 33):
        np.testing.assert_allclose(motion.displacement(t), [t, t * t, 0.0], rtol=1e-15)
        np.testing.assert_array_equal(motion.acceleration(t), [0.0, 2.0, 0.0])


def test_a_linear_acceleration_is_a_cubic_with_the_velocity_it_starts_with() -> None:
    motion = Accelerated([[0.0, 0.0], [3.0, 6.0]], direction="y", velocity=[1.0, -2.0, 0.0])
    for t in np.linspace(0.0, 3.0, 25):
        np.testing.assert_allclose(motion.acceleration(t), [0.0, 2.0 * t, 0.0], rtol=1e-15)
        np.testing.assert_allclose(motion.velocity(t), [1.0, t * t - 2.0, 0.0], atol=1e-14)
        way = [t, t**3 / 3.0 - 2.0 * t, 0.0]
        np.testing.assert_allclose(motion.displacement(t), way, atol=1e-14)


def test_outside_its_rows_an_accelerated_body_goes_on_evenly() -> None:
    motion = Accelerated([[1.0, 4.0], [3.0, 4.0]], direction="x", velocity=[2.0, 0.0, 0.0])
    assert motion.span == (1.0, 3.0)
    for t, x, v, a in ((0.0, -2.0, 2.0, 0.0), (1.0, 0.0, 2.0, 4.0), (3.0, 12.0, 10.0, 4.0)):
        assert (motion.displacement(t)[0], motion.velocity(t)[0]) == (x, v)
        assert motion.acceleration(t)[0] == a
    assert (motion.displacement(5.0)[0], motion.velocity(5.0)[0]) == (32.0, 10.0)
    assert motion.acceleration(5.0)[0] == 0.0


@pytest.mark.parametrize(("smooth", "order"), [(False, 1.95), (True, 1.8)])
def test_a_sine_is_met_the_better_the_more_rows_there_are(smooth, order) -> None:
    """Half a sine of deceleration (a sled): velocity 1 − cos, and its integral."""
    errors = []
    for n in (17, 33):
        t = np.linspace(0.0, np.pi, n)
        motion = Accelerated(np.column_stack([t, np.sin(t)]), direction="z", smooth=smooth)
        at = np.linspace(0.0, np.pi, 101)
        v = np.array([motion.velocity(s)[2] for s in at])
        d = np.array([motion.displacement(s)[2] for s in at])
        errors.append([abs(v - 1.0 + np.cos(at)).max(), abs(d - at + np.sin(at)).max()])
    coarse, fine = np.array(errors)
    assert coarse.max() < 0.02
    assert np.log2(coarse / fine).min() > order


def test_monotone_cubics_pass_their_rows_and_never_overshoot() -> None:
    rows = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 10.0], [3.0, 10.0], [4.0, 3.0]])
    motion = Accelerated(rows, direction="x", smooth=True)
    for t, a in rows:
        assert abs(motion.acceleration(t)[0] - a) <= 1e-14
    values = np.array([motion.acceleration(t)[0] for t in np.linspace(0.0, 4.0, 401)])
    assert values.min() >= -1e-14
    assert values.max() <= 10.0 + 1e-13
    assert not values[:101].any()
    assert 0.0 < motion.acceleration(1.2)[0] < 2.0  # below the straight line


def test_cubics_integrate_as_scipy_does() -> None:
    from scipy.interpolate import PchipInterpolator

    rng = np.random.default_rng(4)
    times = np.cumsum(rng.uniform(0.1, 1.0, 9))
    rows = rng.normal(size=(9, 3))
    motion = Velocity(np.column_stack([times, rows]), smooth=True)
    whole = PchipInterpolator(times, rows).antiderivative()
    for t in rng.uniform(times[0], times[-1], 30):
        np.testing.assert_allclose(motion.displacement(t), whole(t) - whole(times[0]), atol=1e-14)


def test_pulses_are_public_and_are_combined_like_all_motions() -> None:
    pulse = cg.motion.Velocity([[0.0, 1.0], [2.0, 1.0]], direction="x")
    assert isinstance(pulse, Velocity)
    lift = Translate([[0, 0, 0, 0], [2, 0, 0, 4]])
    both = cg.motion.Combine([pulse, lift])
    np.testing.assert_array_equal(both.pose(1.0)[:3, 3], [1, 0, 2])
    np.testing.assert_array_equal(both.twist(1.0).velocity, [1, 0, 2])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Velocity([[0, 1], [1, 1]]), "direction: .*need a direction.*vx, vy, vz"),
        (lambda: Accelerated([[0, 1], [1, 1]]), "ax, ay, az"),
        (
            lambda: Velocity([[0, 1, 0, 0], [1, 1, 0, 0]], direction="x"),
            "direction: .*have their direction in them; found 'x'",
        ),
        (lambda: Velocity([[0, 1, 0], [1, 1, 0]]), "table: .*must have 4 columns"),
        (lambda: Velocity([[0, 1, 0], [1, 1, 0]], direction="x"), "table: .*must have 2 columns"),
        (lambda: Velocity([[0, 1]], direction="x"), "2 columns and at least 2 rows"),
        (lambda: Velocity([], direction="x"), "2 columns and at least 2 rows"),
        (lambda: Velocity([[0, 1], [0, 2]], direction="x"), "go back or repeat at row 1"),
        (lambda: Velocity([[0, 1], [1, np.nan]], direction="x"), "row 1 is not finite"),
        (lambda: Velocity([[0, 1], [1]], direction="x"), "all of the same length"),
        (lambda: Velocity("fast", direction="x"), "must be rows of numbers"),
        (lambda: Velocity([[0, 1], [1, 1]], direction="w"), "direction: not an axis"),
        (lambda: Velocity([[0, 1], [1, 1]], direction=[0, 0, 0]), "direction: .*zero vector"),
        (
            lambda: Accelerated([[0, 1], [1, 1]], direction="x", velocity=[1, 2]),
            "velocity: must be three finite numbers",
        ),
    ],
)
def test_a_wrong_pulse_is_refused_with_its_rule(make, message) -> None:
    with pytest.raises(InputError, match=message):
        make()


def test_a_pulse_that_lasts_as_long_as_the_run_passes() -> None:
    check_covers(None, 0.0, 1e9, "load[0]")
    check_covers((0.0, 0.1), 0.0, 0.1, "body[0].motion")
    check_covers((-1.0, 2.0), 0.0, 0.1, "body[0].motion")
    check_covers((0.0, 100 * 0.001 * (1 - 1e-15)), 0.0, 0.1, "body[0].motion")


@pytest.mark.parametrize(
    ("span", "message"),
    [
        (
            (0.0, 80.0),
            r"body\[0\]\.motion: stops at 80, and the run needs it up to 120; found 80\.0; "
            r"allowed: a last row at 120 or later\. "
            r"Add a last row \[120, 0\], or end the run at 80",
        ),
        ((0.0, 120.0 * (1.0 - 1e-7)), "stops at 119.999988"),
        ((5.0, 200.0), r"begins at 5, .* from 0 on.*Add a first row \[0, 0\], or start the run"),
    ],
)
def test_a_pulse_that_stops_early_or_begins_late_is_refused(span, message) -> None:
    with pytest.raises(InputError, match=message):
        check_covers(span, 0.0, 120.0, "body[0].motion")


def write(folder: Path, text: str) -> Path:
    path = folder / "pulse.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "given", "expected"),
    [
        ("t [ms], a [g]\n0, 0\n50, -20\n", {}, [[0, 0], [50, -20 * 9.80665e-3]]),
        ("time (s), acc (m/s^2)\n0, 0\n0.05, -200\n", {}, [[0, 0], [50, -0.2]]),
        ("time (s);acc (m/(s²))\n0;0\n0.05;-200\n", {}, [[0, 0], [50, -0.2]]),
        ("t\ta\n0\t1\n\n5\t2\n", {}, [[0, 1], [5, 2]]),
        ("t,a\n0,1\n1,2\n", {"time_unit": "s", "unit": "g"}, [[0, 9.80665e-3], [1e3, 19.6133e-3]]),
        ("t [s],a\n0,1\n1,2\n", {"unit": "m/s/s"}, [[0, 1e-3], [1e3, 2e-3]]),
        ("t [s],v [km/h]\n0,36\n1,0\n", {"quantity": "velocity"}, [[0, 10], [1e3, 0]]),
        (
            "t [ms],x [g],y [m/s^2],z\n0,1,1,1\n1,2,2,2\n",
            {},
            [[0, 9.80665e-3, 1e-3, 1], [1, 19.6133e-3, 2e-3, 2]],
        ),
        (
            "n,Head X [g],Head Y [g],time [s]\n1,3,4,0\n2,5,6,1\n",
            {"columns": ["time", "Head Y"]},
            [[0, 4 * 9.80665e-3], [1e3, 6 * 9.80665e-3]],
        ),
        (
            "t,a [g],a [m/s^2]\n0,1,9.80665\n1,2,19.6133\n",
            {"columns": ["t", "a [m/s^2]"]},
            [[0, 9.80665e-3], [1, 19.6133e-3]],
        ),
    ],
)
def test_a_file_says_its_units(tmp_path: Path, text, given, expected) -> None:
    table = read_pulse(write(tmp_path, text), units=("mm", "ms"), **given)
    np.testing.assert_allclose(table, expected, rtol=1e-15, atol=0.0)


@pytest.mark.parametrize(
    ("text", "given", "kind", "message"),
    [
        ("0,0\n1,2\n", {}, FileError, r"csv:1: the first line must name the columns; found '0,0'"),
        ("", {}, FileError, "first line must name the columns"),
        ("t,a,b\n0,1,2\n", {}, FileError, r"csv:1: which columns are meant.*as columns"),
        (
            "t,a\n0,1\n",
            {"columns": ["t", "c"]},
            FileError,
            "the column 'c' is missing; found 't, a'",
        ),
        ("t,a\n0,1\n", {"columns": ["t"]}, InputError, "columns: must name a time"),
        ("t,a [g],a [V]\n0,1,1\n", {"columns": ["t", "a"]}, FileError, "'a' is there 2 times"),
        ("\nt,a\n0,1\n\n1,one\n", {}, FileError, r"csv:5: a row does not have a number"),
        ("t,a\n0,1\n1\n", {}, FileError, r"csv:3: a row does not have a number"),
        ("t,a\n0,1\n\n0,2\n", {}, FileError, r"csv:4: the times must increase"),
        ("t,a\n0,1\n1,nan\n", {}, FileError, r"csv:3: a number is not finite"),
        ("t,a\n0,1\n0,5,1,5\n", {}, FileError, r"csv:3: a row has 4 cells under a header of 2"),
        ("t;a\n0;1;2\n", {}, FileError, r"csv:2: a row has 3 cells.*parted by ';'"),
        ("t,a\n", {}, FileError, "no rows under the header"),
        (
            "t [ms],a [g]\n0,1\n",
            {"unit": "m/s^2"},
            FileError,
            "csv:1: the header says another unit",
        ),
        ("t [kg],a\n0,1\n", {}, UnitError, r"csv:1: t \[kg\]: not a unit of time; found 'kg'"),
        (
            "t,a [m/s]\n0,1\n",
            {},
            UnitError,
            r"csv:1: a \[m/s\]: not a unit of acc.* It is a unit of velocity",
        ),
        (
            "t,a []\n0,1\n",
            {},
            UnitError,
            r"csv:1: a \[\]: not a known unit of acceleration; found ''",
        ),
        (
            "t,v [g]\n0,1\n",
            {"quantity": "velocity"},
            UnitError,
            "It is a unit of mass or acceleration",
        ),
    ],
)
def test_a_wrong_file_is_refused_with_its_place(tmp_path, text, given, kind, message) -> None:
    with pytest.raises(kind, match=message):
        read_pulse(write(tmp_path, text), units=("mm", "ms"), **given)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"none\.csv: the file cannot be read"):
        read_pulse(tmp_path / "none.csv", units=("mm", "ms"))
