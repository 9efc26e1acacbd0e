"""Joints by their kernels: what each kind holds and leaves free, coordinates, misfits, rank."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contiga.dynamics.free import Free
from contiga.dynamics.joint_laws import JointLaw
from contiga.dynamics.joint_records import work_for
from contiga.dynamics.joints import KINDS, Joint
from contiga.dynamics.kernels import joints_nb
from contiga.dynamics.linkage import Linkage, check_fit
from contiga.dynamics.rigid_bodies import (
    Placed,
    bodies_at_start,
    drift_bodies,
    fixed_of,
    kick_bodies,
    row_of,
)
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid import rigid_lanes as lanes

pytestmark = pytest.mark.interpreted

TENSOR = np.array([[1.0, 0.1, 0.05], [0.1, 1.4, 0.2], [0.05, 0.2, 1.9]])
CENTRES = ([0.0, 0.0, 0.0], [2.0, 0.5, 0.0])
AT = [1.0, 0.2, 0.1]
ALONG = np.array([0.6, 0.0, 0.8])
AXIS: dict[str, Any] = {
    "universal": [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0]],
    "spherical": ALONG,
    "weld": None,
}


def linkage_of(joints: list[Joint], **given: Any) -> tuple[Linkage, FloatArray, FloatArray]:
    """Two free bodies "a" and "b" and joints between them or to the ground, with their rows."""
    spins = ([0.3, -0.2, 0.5], [-0.1, 0.4, 0.2])
    motions = [
        Free(
            1.0 + k,
            inertia=TENSOR * (1.0 + k),
            centre=centre,
            spin=spin,
            velocity=[0.1, k, 0.2],
            **given,
        )
        for k, (centre, spin) in enumerate(zip(CENTRES, spins, strict=True))
    ]
    fixed = np.array([fixed_of("x", motion) for motion in motions])
    rows = np.array([row_of(motion, one) for motion, one in zip(motions, fixed, strict=True)])
    numbers = {"a": 0, "b": 1, "ground": -1}
    ends = np.array([[numbers[name] for name in joint.between] for joint in joints], np.int32)
    origins = np.array([np.eye(4)] * 2)
    linkage = Linkage({joint.name: joint for joint in joints}, ends, ends, origins, fixed)
    return linkage, rows, origins


def moved(linkage: Linkage, rows: FloatArray, poses: FloatArray, step: float, count: int) -> Placed:
    """Bodies that fly for some steps without forces but those of their joints."""
    fixed, still = linkage.fixed, np.zeros((2, 6))
    placed = bodies_at_start(rows, fixed)
    kick_bodies(placed, fixed, still, 0.0)
    linkage.react(placed, poses, still, still)
    for _ in range(count):
        last = placed.rows
        placed = drift_bodies(last, fixed, step)
        assert linkage.close(last, poses, placed, poses, step) <= 1e-12
        kick_bodies(placed, fixed, still, step)
        linkage.react(placed, poses, still, still)
    return placed


def relative(placed: Placed) -> tuple[FloatArray, FloatArray]:
    """Place of b's point against a's, and b's turn against a's, both in a's axes."""
    (Xa, Xb), at = placed.poses, np.array([*AT, 1.0])
    Ra = Xa[:3, :3]
    return Ra.T @ (Xb @ at - Xa @ at)[:3], Ra.T @ Xb[:3, :3]


@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_holds_what_it_holds_and_leaves_the_rest_free(kind: str) -> None:
    linkage, rows, poses = linkage_of([Joint(kind, "a", "b", at=AT, axis=AXIS.get(kind, ALONG))])
    placed = moved(linkage, rows, poses, 0.05, 20)
    offset, turn = relative(placed)
    vector = Rotation.from_matrix(turn).as_rotvec()
    turned = float(np.abs(vector).max())
    along = float(offset @ ALONG)
    if kind in ("translational", "cylindrical"):
        assert abs(along) > 0.1
        np.testing.assert_allclose(offset, along * ALONG, atol=1e-12)
    else:
        np.testing.assert_allclose(offset, 0.0, atol=1e-12)
    if kind in ("weld", "translational"):
        np.testing.assert_allclose(turn, np.eye(3), atol=1e-12)
    else:
        assert turned > 0.1
    if kind in ("revolute", "cylindrical"):
        np.testing.assert_allclose(np.cross(vector, ALONG), 0.0, atol=1e-12)
    if kind == "universal":
        assert abs(ALONG @ turn @ [0.0, 1.0, 0.0]) <= 1e-12
        assert float(np.abs(np.cross(vector, ALONG)).max()) > 0.1
    # Coordinates are those of the turn.
    now = linkage.measured(None, placed.poses, placed.twists)
    told = {name: value for (_, name), value in zip(linkage.coordinates, now.values, strict=True)}
    if "angle" in told:
        assert told["angle"] == pytest.approx(float(vector @ ALONG), abs=1e-12)
    if "travel" in told:
        assert told["travel"] == pytest.approx(along, abs=1e-12)
    if kind == "universal":
        both = Rotation.from_rotvec(told["angle_1"] * ALONG) * Rotation.from_rotvec(
            [0.0, told["angle_2"], 0.0]
        )
        np.testing.assert_allclose(both.as_matrix(), turn, atol=1e-12)
    if kind == "spherical":
        swing = turn @ Rotation.from_rotvec(-told["twist"] * ALONG).as_matrix()
        tilt = Rotation.from_matrix(swing).as_rotvec()
        assert abs(tilt @ ALONG) <= 1e-12
        assert np.sqrt(tilt @ tilt) == pytest.approx(told["cone"], abs=1e-12)


def momentum_of(placed: Placed) -> FloatArray:
    """(6,) linear and angular about the origin, of both bodies."""
    total = np.zeros(6)
    for k, row in enumerate(placed.rows):
        linear = (1.0 + k) * row[lanes.VELOCITY : lanes.VELOCITY + 3]
        total[:3] += linear
        total[3:] += np.cross(row[lanes.CENTRE : lanes.CENTRE + 3], linear)
        total[3:] += row[lanes.MOMENTUM : lanes.MOMENTUM + 3]
    return total


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_joint_does_to_one_body_it_does_against_the_other(kind: str) -> None:
    linkage, rows, poses = linkage_of([Joint(kind, "a", "b", at=AT, axis=AXIS.get(kind, ALONG))])
    before, after = (moved(linkage, rows, poses, 0.05, count) for count in (0, 20))
    np.testing.assert_allclose(momentum_of(after), momentum_of(before), atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_with_its_reactions_a_joint_opens_by_the_third_power_of_a_step(kind: str) -> None:
    """Accelerations fulfil G v' + G' v = 0: what is missing to second order would open by h²."""
    linkage, rows, poses = linkage_of([Joint(kind, "a", "b", at=AT, axis=AXIS.get(kind, ALONG))])
    placed = moved(linkage, rows, poses, 0.05, 10)
    work, open_by = work_for(linkage.table, 2), []
    for step in (0.02, 0.01):
        gone = drift_bodies(placed.rows, linkage.fixed, step).rows
        open_by.append(joints_nb.misfits(gone, poses, linkage.fixed, linkage.table, work))
    assert open_by[1] > 1e-9
    assert np.log2(open_by[0] / open_by[1]) == pytest.approx(3.0, abs=0.3)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "weld"])
def test_rates_are_those_of_the_values_and_ways_those_of_their_power(kind: str) -> None:
    linkage, rows, poses = linkage_of([Joint(kind, "a", "b", at=AT, axis=AXIS.get(kind, ALONG))])
    placed = moved(linkage, rows, poses, 0.05, 10)
    h = 1e-5
    now = linkage.measured(None, placed.poses, placed.twists)
    later = []
    for sign in (-1.0, 1.0):
        X = placed.poses.copy()
        for k in range(2):
            spin = placed.twists[k, 3:] * sign * h
            turn = Rotation.from_rotvec(spin).as_matrix()
            X[k, :3, :3] = turn @ X[k, :3, :3]
            X[k, :3, 3] += sign * h * placed.twists[k, :3]
        later.append(linkage.measured(now, X, placed.twists).values)
    np.testing.assert_allclose((later[1] - later[0]) / (2.0 * h), now.rates, rtol=1e-6, atol=1e-7)
    # The power of a unit force of a coordinate on both bodies is its rate.
    for c, way in enumerate(now.ways):
        total = np.zeros((2, 6))
        wrench = np.array([way])
        joints_nb.add_wrenches(linkage.table, now.points, wrench, placed.poses, total)
        assert float((total * placed.twists).sum()) == pytest.approx(now.rates[c], abs=1e-12)
        np.testing.assert_allclose(total[:, :3].sum(axis=0), 0.0, atol=1e-14)


def test_turns_are_counted() -> None:
    joint = Joint(
        "revolute", "ground", "a", at=[0, 0, 0], axis=[0, 0, 1], angle=JointLaw(1.0, start=0.5)
    )
    linkage, _, _ = linkage_of([joint])
    states, twists = None, np.zeros((2, 6))
    for angle in np.arange(0.0, 15.0, 0.7):
        poses = np.array([np.eye(4)] * 2)
        poses[0, :3, :3] = Rotation.from_rotvec([0, 0, angle]).as_matrix()
        states = linkage.measured(states, poses, twists)
        assert states.values[0] == pytest.approx(0.5 + angle, abs=1e-12)


def test_starts_of_all_coordinates_are_where_they_are_said_to_be() -> None:
    laws: dict[str, Any] = {
        "revolute": {"angle": 0.3},
        "cylindrical": {"angle": -0.4, "travel": 0.7},
        "translational": {"travel": -0.2},
        "universal": {"angle_1": 0.5, "angle_2": -0.9},
        "spherical": {"twist": 1.2},
    }
    for kind, starts in laws.items():
        given = {name: JointLaw(1.0, start=value) for name, value in starts.items()}
        joint = Joint(kind, "a", "b", at=AT, axis=AXIS.get(kind, ALONG), **given)
        linkage, rows, poses = linkage_of([joint])
        now = linkage.measured(None, poses, np.zeros((2, 6)))
        told = {
            name: value for (_, name), value in zip(linkage.coordinates, now.values, strict=True)
        }
        for name, value in starts.items():
            assert told[name] == pytest.approx(value, abs=1e-15), (kind, name)
        assert linkage.fit(rows, poses).misfit <= 1e-15


def test_velocities_are_those_of_gauss_least_change() -> None:
    """Against NumPy: v − M⁻¹ Gᵀ (G M⁻¹ Gᵀ)⁺ G v."""
    joints = [
        Joint("revolute", "a", "b", at=AT, axis=ALONG),
        Joint("spherical", "ground", "a", at=[0, 1, 0]),
    ]
    linkage, rows, poses = linkage_of(joints)
    placed, still = bodies_at_start(rows, linkage.fixed), np.zeros((2, 6))
    work = work_for(linkage.table, 2)
    joints_nb.misfits(rows, poses, linkage.fixed, linkage.table, work)
    joints_nb.derive(rows, linkage.fixed, linkage.table, work)
    G, M = np.zeros((len(work.right), 12)), np.zeros((12, 12))
    for m, (g, *_) in enumerate(linkage.table.constraints):
        for side in range(2):
            if (row := linkage.table.rows[g, side]) >= 0:
                G[m, 6 * row : 6 * row + 6] += work.jacobian[m, side]
    velocities = np.zeros(12)
    for k in range(2):
        M[6 * k : 6 * k + 3, 6 * k : 6 * k + 3] = (1.0 + k) * np.eye(3)
        M[6 * k + 3 : 6 * k + 6, 6 * k + 3 : 6 * k + 6] = (1.0 + k) * TENSOR
        velocities[6 * k : 6 * k + 3] = rows[k, lanes.VELOCITY : lanes.VELOCITY + 3]
        velocities[6 * k + 3 : 6 * k + 6] = placed.twists[k, 3:]
    W = np.linalg.inv(M)
    expected = velocities - W @ G.T @ np.linalg.pinv(G @ W @ G.T) @ G @ velocities
    kick_bodies(placed, linkage.fixed, still, 0.0)
    kinetic, _ = linkage.react(placed, poses, still, still)
    for k in range(2):
        own = placed.rows[k, lanes.VELOCITY : lanes.VELOCITY + 3]
        np.testing.assert_allclose(own, expected[6 * k : 6 * k + 3], atol=1e-13)
        np.testing.assert_allclose(
            placed.twists[k, 3:], expected[6 * k + 3 : 6 * k + 6], atol=1e-13
        )
    assert kinetic == pytest.approx(0.5 * expected @ M @ expected, rel=1e-13)


def test_reactions_of_redundant_joints_are_the_least_and_the_motion_is_the_same() -> None:
    """Two welds between the same bodies at two points share the load."""
    one = Joint("weld", "a", "b", at=AT, name="one")
    two = Joint("weld", "a", "b", at=AT, name="two")
    single, rows, poses = linkage_of([one])
    double, _, _ = linkage_of([one, two])
    ends = [moved(linkage, rows, poses, 0.05, 10).rows for linkage in (single, double)]
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-11)
    still, told = np.zeros((2, 6)), []
    for linkage in (single, double):
        placed = bodies_at_start(rows, linkage.fixed)
        kick_bodies(placed, linkage.fixed, np.ones((2, 6)), 0.0)
        told.append(linkage.react(placed, poses, still, still)[1])
    np.testing.assert_allclose(told[1], np.repeat(0.5 * told[0], 2, axis=0), atol=1e-12)
    fit = double.fit(rows, poses)
    assert (fit.redundant, fit.dependent) == (6, ("one", "two"))
    assert single.fit(rows, poses).redundant == 0


def test_held_ways_stay_held() -> None:
    joint = Joint("spherical", "a", "b", at=AT)
    linkage, rows, poses = linkage_of([joint])
    linkage.fixed[0, [lanes.FREE_DIRECTIONS, lanes.FREE_ROTATIONS + 2]] = 0.0
    rows[0, lanes.VELOCITY] = 0.0
    placed = moved(linkage, rows, poses, 0.02, 20)
    assert placed.rows[0, lanes.CENTRE] == 0.0
    assert placed.twists[0, 5] == 0.0
    np.testing.assert_allclose(relative(placed)[0], 0.0, atol=1e-12)


def test_bodies_are_moved_least_by_their_masses_to_close_a_joint() -> None:
    """The gap is shared as the masses, 1 and 2, have it."""
    joint = Joint("spherical", "a", "b", at=[[0.0, 0.0, 0.0], [0.0, 0.0, 0.3]])
    linkage, rows, poses = linkage_of([joint])
    linkage.fixed[:, lanes.FREE_ROTATIONS : lanes.FREE_ROTATIONS + 3] = 0.0
    rows[:, lanes.MOMENTUM : lanes.MOMENTUM + 3] = 0.0
    fit = linkage.fit(rows, poses)
    assert fit.misfit <= 1e-15
    np.testing.assert_allclose(fit.moved, [0.2, 0.1], rtol=1e-12)
    assert not fit.gaps


def test_axes_are_turned_to_meet() -> None:
    joint = Joint("revolute", "ground", "a", at=[0, 0, 0], axis=[[0, 0, 1], [0, 0.1, 1]])
    linkage, rows, poses = linkage_of([joint])
    before = bodies_at_start(rows, linkage.fixed).twists[0, 3:]
    fit = linkage.fit(rows, poses)
    assert fit.misfit <= 1e-15
    assert fit.turned[0] == pytest.approx(np.arctan(0.1), rel=0.1)
    after = bodies_at_start(fit.rows, linkage.fixed).twists[0, 3:]
    np.testing.assert_allclose(after, before, atol=1e-13)  # the spin given is that of the body


def test_two_welds_that_contradict_each_other_are_named_and_how_far_apart() -> None:
    one = Joint("weld", "a", "b", at=AT, name="one")
    two = Joint("weld", "a", "b", at=[AT, [1.0, 0.2, 0.5]], name="two")
    linkage, rows, poses = linkage_of([one, two])
    with pytest.raises(InputError, match=r"'one', 'two' contradict each other: .*misfit of 0\.2 "):
        check_fit(linkage, linkage.fit(rows, poses))


@pytest.mark.parametrize(
    ("arguments", "options", "where", "what"),
    [
        (("hinge", "a", "b"), {}, "kind", "revolute"),
        (("weld", "a", "a"), {}, "second", "both ends are of one body"),
        (("weld", "a", ""), {}, "second", "name of a body"),
        (("weld", "a", "b"), {"at": [0, 0]}, "at", "three"),
        (("weld", "a", "b"), {"at": [0, 0, np.nan]}, "at", "finite"),
        (("revolute", "a", "b"), {}, "axis", "is missing"),
        (("revolute", "a", "b"), {"axis": [0, 0, 0]}, "axis", "has no length"),
        (("revolute", "a", "b"), {"axis": [[0, 0, 1], [0, 0, -1]]}, "axis", "180° apart"),
        (("universal", "a", "b"), {"axis": [0, 0, 1]}, "axis", "two axes"),
        (
            ("revolute", "a", "b"),
            {"axis": [0, 0, 1], "cone": JointLaw(1.0)},
            "cone",
            "does not have",
        ),
        (("revolute", "a", "b"), {"axis": [0, 0, 1], "angle": 1.0}, "angle", "JointLaw"),
        (("spherical", "a", "b"), {"cone": JointLaw(1.0, start=0.1)}, "cone: start", "axes"),
    ],
)
def test_joints_that_are_none_are_refused(
    arguments: tuple[str, str, str], options: dict[str, Any], where: str, what: str
) -> None:
    with pytest.raises(InputError, match=what) as told:
        Joint(*arguments, **({"at": [0, 0, 0]} | options))
    assert told.value.where == where


@pytest.mark.parametrize("broken", [0, 1])
def test_a_misfit_that_is_not_a_number_is_the_largest(broken: int) -> None:
    """Also if the joints after it are closed."""
    joints = [Joint("spherical", "ground", body, at=AT) for body in ("a", "b")]
    linkage, rows, poses = linkage_of(joints)
    work = work_for(linkage.table, 2)
    assert joints_nb.misfits(rows, poses, linkage.fixed, linkage.table, work) <= 1e-15
    rows[broken, lanes.CENTRE] = np.nan
    assert np.isnan(joints_nb.misfits(rows, poses, linkage.fixed, linkage.table, work))
