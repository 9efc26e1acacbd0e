"""The tangent of a contact against differences of its forces, and against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from tests.differences import jacobian
from tests.scenes import box
from tests.unit.search.holed import holed_plate

import contiga as cg
from contiga.contact import tangent
from contiga.contact.friction_tangent import InputChange
from contiga.contact.kernels import tangent_nb
from contiga.contact.respond import ContactRows
from contiga.errors import InputError

SAME = 1e-7
"""Relative difference: rounding of the differences."""


def misses(contact: cg.Contact, state: cg.State, points: np.ndarray, **how: object) -> float:
    """How far the tangent of the step from `state` to `points` is off differences, relative."""
    step = how.pop("step", 1e-5)
    actual = contact.tangent(contact.step(state, points, **how)).toarray()

    def forces(x: np.ndarray) -> np.ndarray:
        return contact.step(state, x, **how).force

    wanted = jacobian(forces, points, step)
    assert actual.any()
    return float(np.abs(actual - wanted).max() / np.abs(wanted).max())


def contact_of(master: object, n: int, **options: object) -> cg.Contact:
    given = {"law": cg.PenaltyLaw(7.0), "search": "penetration", **options}
    nodal = {"area": np.linspace(0.5, 1.0, n), "mass": np.full(n, 0.2)}
    slave = cg.Slave(np.zeros((n, 3)), thickness=np.linspace(0.5, 0.8, n), **nodal)
    return cg.Contact(master, slave, **given)


CYLINDER = cg.Body(
    [
        cg.shapes.cylinder(radius=1.0, height=2.0),
        cg.shapes.disc(radius=1.0, centre=(0.0, 0.0, 1.0)),
        cg.shapes.disc(radius=1.0, centre=(0.0, 0.0, -1.0), axis=(0.0, 0.0, -1.0)),
    ]
)
SHAFT = cg.Body(
    [
        cg.shapes.revolved(
            cg.NurbsCurve(
                1,
                [0, 0, 1, 2, 3, 4, 5, 5],
                [[0, 0, 0], [2, 0, 0], [2, 0, 1], [1, 0, 1], [1, 0, 3], [0, 0, 3]],
            )
        )
    ]
)
"""With a shoulder: an edge that points inside are near."""
EGG = cg.Body([cg.shapes.ellipsoid(axes=(1.0, 2.0, 3.0))])
BOX = box((0.0, 0.0, 0.0), (2.0, 1.0, 1.0))
FACE, EDGE, VERTEX = cg.Feature.FACE, cg.Feature.EDGE, cg.Feature.VERTEX


@pytest.mark.parametrize(
    ("master", "place", "feature", "options"),
    [
        (cg.Body([cg.shapes.torus(major=3.0, minor=1.0)]), (2.0, 1.2, 0.3), FACE, {}),
        (EGG, (0.5, 1.0, 1.2), FACE, {}),
        (EGG, (0.0, 0.0, 2.9), FACE, {}),
        (SHAFT, (0.8, 0.3, 0.7), EDGE, {}),
        (BOX, (0.4, 0.6, 0.9), FACE, {}),
        (BOX, (-0.05, 0.6, 1.08), EDGE, {"shell_thickness": 0.4}),
        (BOX, (-0.05, 1.02, 1.08), VERTEX, {"shell_thickness": 0.4}),
        (None, (0.4, 0.6, 0.9), FACE, {}),
        (None, (-0.05, 0.6, 1.08), EDGE, {"shell_thickness": 0.4}),
        (None, (-0.05, 1.02, 1.08), VERTEX, {"shell_thickness": 0.4}),
        (CYLINDER, (0.8, 0.68, 0.5), FACE, {"shell_thickness": 0.4}),
        (CYLINDER, (0.8, 0.65, 1.05), EDGE, {"shell_thickness": 0.4}),
        (holed_plate(), (0.15, 0.05, 0.1), EDGE, {"shell_thickness": 0.6, "on_edge": "hold"}),
    ],
    ids=lambda value: value.name if isinstance(value, cg.Feature) else None,
)
def test_the_normal_turns_with_the_point_as_at_its_foot(
    master: object, place: tuple[float, float, float], feature: cg.Feature, options: dict
) -> None:
    """Without a master it is the mesh of the box."""
    master = BOX.tessellate(0.1) if master is None else master
    contact, points = contact_of(master, 1, **options), np.array([place])
    state = contact.start(points)
    assert state.feature.tolist() == [feature]
    assert misses(contact, state, points) < SAME


def test_a_foot_held_on_a_border_keeps_the_normal_of_its_face() -> None:
    contact = contact_of(holed_plate(), 1, search="intersection", on_edge="hold")
    above, through = np.array([[0.25, 0.1, 0.5]]), np.array([[0.25, 0.1, -0.03]])
    state = contact.step(contact.start(above), through)
    beyond = np.array([[0.17, 0.06, -0.03]])
    after = contact.step(state, beyond)
    assert after.status.tolist() == [cg.ContactStatus.HELD]
    away = beyond - after.foot
    assert np.linalg.norm(np.cross(away, after.normal)) > 1e-3 * np.linalg.norm(away)
    assert misses(contact, state, beyond) < SAME


@pytest.mark.parametrize("kind", ["facet", "vertex"])
def test_normals_of_a_mesh_stay_or_are_interpolated(kind: str) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)]).tessellate(0.01)
    mesh = cg.TriMesh(ball.vertices, ball.triangles, normals=kind)
    contact, points = contact_of(mesh, 1), np.array([[0.5, 0.4, 0.5]])
    state = contact.start(points)
    K = contact.tangent(state).toarray()
    n = state.normal[0]
    assert np.allclose(K, -7.0 * np.outer(n, n), rtol=0.0, atol=1e-12) == (kind == "facet")
    assert misses(contact, state, points) < SAME


class Ball(cg.Master):
    """A user's own, of which only closest points are known."""

    def bounds(self) -> np.ndarray:
        return np.array([[-1.0] * 3, [1.0] * 3])

    @property
    def surface(self) -> object:
        return cg.closest_point_search(self.closest_points)

    def closest_points(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        normals = points / np.linalg.norm(points, axis=1)[:, None]
        return normals, normals


@pytest.mark.parametrize("away", [0.0, 1e-16, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3, 0.2])
@pytest.mark.parametrize("master", [cg.Body([cg.shapes.sphere(radius=1.0)]), Ball()])
def test_of_a_ball_by_its_formula_at_and_beside_its_pole(master: object, away: float) -> None:
    points = np.array([[away, away / 3.0, 0.9]])
    contact = contact_of(master, 1)
    d = np.linalg.norm(points)
    across = np.eye(3) - np.outer(points, points) / d**2
    wanted = 7.0 * ((1.0 / d - 1.0) * across - (np.eye(3) - across))
    actual = contact.tangent(contact.start(points)).toarray()
    np.testing.assert_allclose(actual, wanted, rtol=0.0, atol=1e-8)


def soft(x: np.ndarray) -> np.ndarray:
    return 10.0 * x + 30.0 * x**3


TABLE = [[0.0, 0.0], [0.15, 1.0], [0.3, 4.0]]
LAWS = [
    (cg.PenaltyLaw(7.0), {}),
    (cg.PenaltyLaw(7.0, damping=0.3, damping_ratio=0.1, per_area=True), {}),
    (cg.AdaptiveLaw(0.4), {}),
    (cg.ForceLaw(TABLE), {}),
    (cg.ForceLaw(soft), {}),
    (cg.ForceLaw(TABLE, unloading=[[0.0, 0.0], [0.3, 2.0]], hysteresis_slope=40.0), {}),
    (cg.ForceLaw(soft, share="penetration"), {}),
    (cg.StressLaw(soft, damping=0.2, damping_ratio=0.1), {}),
    (
        cg.StressLaw(
            TABLE, 0.7, damping=0.2, damping_curve=lambda r: r**3, amplification=lambda s: 1 + s**2
        ),
        {},
    ),
    (cg.StressLaw(soft, unloading=lambda x: 5.0 * x, hysteresis_slope=60.0), {}),
    (cg.StressLaw(TABLE, 0.7), {"contact_type": "master"}),
    (
        cg.StressLaw(soft, damping=0.1),
        {
            "contact_type": "combined",
            "master_law": cg.StressLaw(TABLE, 0.3, damping=0.2, amplification=lambda s: 1 + s),
        },
    ),
    (
        cg.StressLaw(TABLE, damping=0.1),
        {"contact_type": "combined", "master_law": cg.StressLaw(TABLE, 0.3)},
    ),
    (cg.ForceLaw(TABLE), {"contact_type": "combined", "master_law": cg.ForceLaw(20.0)}),
    (
        cg.StressLaw(TABLE, 0.7),
        {
            "contact_type": "combined",
            "master_law": cg.FaceLaws(
                cg.StressLaw(soft, 1.0, damping=0.1), {0: cg.StressLaw(9, 1)}
            ),
        },
    ),
]


def pressed(depths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points so deep in the egg, and the normals there."""
    places = np.random.default_rng(1).normal(size=(len(depths), 3)) * 0.2 + [1.0, 0.5, 0.7]
    feet = EGG.project(places)
    return feet.point - depths[:, None] * feet.normal, feet.normal


@pytest.mark.parametrize("way", [0.03, -0.02], ids=["loading", "unloading"])
@pytest.mark.parametrize(("law", "options"), LAWS)
def test_every_law_grows_as_it_says(law: object, options: dict, way: float) -> None:
    depths = np.array([0.11, 0.14, 0.17, 0.19])
    before, normals = pressed(depths)
    contact = contact_of(EGG, 4, law=law, **options)
    state = contact.step(contact.start(before), before, dt=0.1)
    now = before - way * normals + 0.01 * np.random.default_rng(2).normal(size=(4, 3))
    assert misses(contact, state, now, dt=0.1) < SAME


@pytest.mark.parametrize("law", [cg.ForceLaw(soft), cg.ForceLaw(TABLE)])
def test_points_that_share_a_force_are_coupled(law: object) -> None:
    points, _ = pressed(0.2 * (1.0 - 0.0008 * np.arange(4)))
    contact = contact_of(EGG, 4, law=law)
    state = contact.start(points)
    assert np.count_nonzero(state.normal_force) > 1
    assert abs(contact.tangent(state)[0, 3]) > 0.0
    assert misses(contact, state, points, step=1e-6) < SAME


def test_more_that_share_than_a_matrix_can_hold_are_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    points, _ = pressed(np.array([0.11, 0.14, 0.17, 0.19]))
    contact = contact_of(EGG, 4, law=cg.ForceLaw(TABLE, share="penetration"))
    state = contact.start(points)
    assert contact.tangent(state).nnz == 144
    monkeypatch.setattr(tangent, "MAX_NUMBERS", 143)
    with pytest.raises(InputError, match=r"full between points.*4 points, 1\.4e\+02 numbers"):
        contact.tangent(state)


def test_areas_that_are_measured_are_held() -> None:
    points = cg.clouds.sample(cg.shapes.plane(width=1.6, length=1.6), 5, 5)
    row = np.arange(25).reshape(5, 5)
    corners = row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]
    quads = np.stack(corners, axis=-1).reshape(-1, 4)
    points = points + np.array([0.0, 0.0, 2.6])
    law, search = cg.StressLaw(TABLE, 0.7), "penetration"
    measured = cg.Contact(EGG, cg.Slave(points, quads), law=law, weights="area", search=search)
    state = measured.start(points)
    assert 4 < state.n_contact < 25
    fixed = cg.Contact(EGG, cg.Slave(points, area=state.area), law=law, search=search)
    wanted = fixed.tangent(fixed.start(points)).toarray()
    np.testing.assert_allclose(measured.tangent(state).toarray(), wanted, rtol=1e-12, atol=1e-12)


def test_points_that_come_in_are_damped_by_their_approach() -> None:
    inside, normals = pressed(np.array([0.05, 0.08]))
    outside = inside + 0.3 * normals
    law = cg.PenaltyLaw(7.0, damping=0.3)
    contact = contact_of(EGG, 2, law=law, search="intersection")
    state = contact.start(outside)
    assert contact.step(state, inside, dt=0.1).status.tolist() == [cg.ContactStatus.NEW] * 2
    assert misses(contact, state, inside, dt=0.1) < SAME


def test_in_the_axes_of_the_world_wherever_the_master_is() -> None:
    turned = cg.motion.pose.translation([1.0, 2.0, 3.0]) @ cg.motion.pose.rotation([1, 2, 3], 0.7)
    points, _ = pressed(np.array([0.1, 0.2]))
    contact = contact_of(EGG, 2)
    points = points @ turned[:3, :3].T + turned[:3, 3]
    assert misses(contact, contact.start(points, turned), points, pose=turned) < SAME


@pytest.mark.parametrize("quadrature", [1, 3])
def test_points_between_nodes_are_their_mean(quadrature: int) -> None:
    mesh = cg.Body([cg.shapes.plane(width=1.2, length=1.2)]).tessellate(0.1, size=0.6)
    nodes = mesh.vertices + np.array([0.3, 0.2, 2.9])
    nodes[:, 2] -= 0.2 * np.random.default_rng(3).random(len(nodes))
    slave = cg.Slave(nodes, mesh.triangles)
    law = cg.StressLaw(TABLE, 0.7)
    contact = cg.Contact(EGG, slave, law=law, quadrature=quadrature, search="penetration")
    state = contact.start(nodes)
    assert 0 < state.n_contact < len(state.status)
    assert misses(contact, state, nodes) < SAME


def test_without_contact_it_is_empty() -> None:
    contact, points = contact_of(EGG, 3), np.full((3, 3), 9.0)
    matrix = contact.tangent(contact.start(points))
    assert matrix.shape == (9, 9)
    assert matrix.nnz == 0
    whole = contact.linearise(contact.start(points))
    assert not whole.force_by_pose.any()
    assert not whole.wrench_by_pose.any()
    assert whole.wrench_by_points.shape == (6, 9)


class Cubic:
    """A law of a user's own."""

    needs_mass = needs_thickness = False
    n_memory = 0
    slopes = True

    def respond(self, inp: cg.LawInput) -> cg.LawOutput:
        depth = inp.penetration
        tangent = 90.0 * depth**2 if self.slopes else None
        answer = 30.0 * depth**3, 90.0 * depth**2, 7.5 * depth**4, np.zeros((len(depth), 0))
        return cg.LawOutput(*answer, tangent=tangent)


def test_a_law_of_ones_own_answers_slopes_or_is_told_to() -> None:
    law, (points, _) = Cubic(), pressed(np.array([0.1, 0.2]))
    contact = contact_of(EGG, 2, law=law)
    state = contact.start(points)
    assert misses(contact, state, points) < SAME
    law.slopes = False
    with pytest.raises(InputError, match=r"no tangent.*Cubic.*tangent=slopes"):
        contact.tangent(state)


def test_slopes_of_another_shape_are_refused() -> None:
    class Short(Cubic):
        def respond(self, inp: cg.LawInput) -> cg.LawOutput:
            return super().respond(inp)._replace(tangent=np.ones(1))

    points, _ = pressed(np.array([0.1, 0.2]))
    contact = contact_of(EGG, 2, law=Short())
    with pytest.raises(InputError, match=r"tangent.*one row a point"):
        contact.tangent(contact.start(points))


@pytest.mark.parametrize(
    ("slopes", "where"),
    [
        (cg.LawTangent(cg.DepthSlopes(np.ones(2), np.ones((2, 1)), None)), "force.right"),
        (
            cg.LawTangent(cg.DepthSlopes(np.ones(2), np.ones((2, 1)), np.ones((2, 2)))),
            "force.right",
        ),
        (cg.LawTangent(cg.DepthSlopes(np.ones(2)), rate=np.ones(3)), "tangent.rate"),
        ("steep", "force.own"),
    ],
)
def test_a_tangent_that_is_none_is_told_where(slopes: object, where: str) -> None:
    class Wrong(Cubic):
        def respond(self, inp: cg.LawInput) -> cg.LawOutput:
            return super().respond(inp)._replace(tangent=slopes)

    points, _ = pressed(np.array([0.1, 0.2]))
    contact = contact_of(EGG, 2, law=Wrong())
    with pytest.raises(InputError, match=where):
        contact.tangent(contact.start(points))


def test_arrays_alone_are_slopes_over_the_points_own_depth() -> None:
    class Plain(Cubic):
        def respond(self, inp: cg.LawInput) -> cg.LawOutput:
            answer = super().respond(inp)
            return answer._replace(tangent=cg.LawTangent(answer.tangent))

    points, _ = pressed(np.array([0.1, 0.2]))
    contact = contact_of(EGG, 2, law=Plain())
    assert misses(contact, contact.start(points), points) < SAME


@pytest.mark.interpreted
def test_blocks_are_turned_into_the_axes_of_the_world() -> None:
    rng = np.random.default_rng(0)
    blocks, pose = rng.normal(size=(4, 3, 3)), cg.motion.pose.rotation([1, 2, 3], 0.7)
    turn, before = pose[:3, :3], blocks.copy()
    tangent_nb.to_world(blocks, pose, 1, 3)
    wanted = np.einsum("ab,kbc,dc->kad", turn, before, turn)
    np.testing.assert_allclose(blocks[1:3], wanted[1:3], rtol=0.0, atol=1e-14)
    np.testing.assert_array_equal(blocks[[0, 3]], before[[0, 3]])


@pytest.mark.interpreted
@pytest.mark.parametrize("alike", [False, True])
@pytest.mark.parametrize("known", [False, True])
def test_blocks_are_those_of_the_product_rule(known: bool, alike: bool) -> None:
    rng, n, m = np.random.default_rng(1), 6, 5
    points = ContactRows.of(np.arange(n, dtype=np.int32), rng.normal(size=(n if known else 0, 3)))
    points.normal[...], points.path[...] = rng.normal(size=(2, n, 3))
    points.old[...] = [True, False] * 3
    path, velocity = rng.normal(size=(2, 1 if alike else n, 3, m))
    change = InputChange(rng.normal(size=(n, m)), rng.normal(size=(n, 3, m)), path, velocity)
    force, own, rate = rng.random((3, n))
    rate[4:] = 0.0
    grown, blocks = np.empty((n, m)), np.empty((n, 3, m))
    given = tangent._NormalTangent(force, own, rate, 0.5, grown)
    tangent_nb.normal_blocks(points, change, given, blocks, 0, n)
    turned, normals = change.normal, points.normal[:, :, None]
    if known:
        speed = -(points.velocity[:, :, None] * turned + normals * velocity).sum(axis=1)
    else:
        approach = -(normals * path + points.path[:, :, None] * turned).sum(axis=1)
        speed = np.where(points.old[:, None], change.depth, approach) / 0.5
    wanted = own[:, None] * change.depth + rate[:, None] * speed
    np.testing.assert_allclose(grown, wanted, rtol=1e-13, atol=1e-14)
    wanted = normals * wanted[:, None] + force[:, None, None] * turned
    np.testing.assert_allclose(blocks, wanted, rtol=1e-13, atol=1e-14)


def test_a_state_made_by_hand_does_not_know_its_step() -> None:
    points, _ = pressed(np.array([0.1, 0.2]))
    contact = contact_of(EGG, 2)
    state = contact.start(points)
    again = cg.State(**state.arrays, of=contact)
    with pytest.raises(InputError, match="step that made it"):
        contact.tangent(again)
    wanted = contact.tangent(state).toarray()
    np.testing.assert_allclose(contact.tangent(contact.step(again, points)).toarray(), wanted)


def test_a_state_of_another_contact_is_refused() -> None:
    ball, pad = cg.Body([cg.shapes.sphere(radius=1.0)]), cg.Slave([[0.0, 0.0, -1.1]], area=[0.5])
    stiff, soft = (cg.Contact(ball, pad, law=cg.PenaltyLaw(k)) for k in (100.0, 1.0))
    state = stiff.step(stiff.start(pad.points), pad.points + np.array([0.0, 0.0, 0.2]))
    with pytest.raises(InputError, match="another contact has made the state"):
        soft.tangent(state)
