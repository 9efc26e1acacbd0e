"""Complex numbers and masked entries are refused wherever numbers come in."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError

BALL = cg.Body([cg.shapes.sphere(radius=1.0)])
CUBE = cg.TriMesh(
    [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
)
POINTS = np.array([[0.0, 0.0, 1.5], [0.1, 0.0, 1.4], [0.0, 0.1, 1.3]])
PAD = cg.Slave(POINTS, area=[1.0, 1.0, 1.0])
CONTACT = cg.Contact(BALL, PAD, law=cg.PenaltyLaw(1.0))
POSE, UP = np.eye(4), np.array([0.0, 0.0, 1.0])
TABLE = np.array([[0.0, 0.0], [1.0, 2.0]])
ROWS = np.array([[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 1.0]])
WEIGHED = np.array([1.0, 2.0, 3.0])
SPHERE = BALL.patches[0]
LINE = cg.shapes.line([0, 0, 0], [1, 0, 0])
SIGNAL = np.linspace(0.0, 1.0, 3000)
SPRING = cg.Spring(("a", "ground"), at=ROWS[:, 1:], curve=1.0)
REST = SPRING.start(ROWS[:, 1:], np.zeros((2, 3)))
POSES = np.stack([POSE, POSE])


@cache
def state() -> cg.State:
    return CONTACT.start(POINTS)


def moved(**more: Any) -> cg.Simulation:
    free = cg.motion.Free(mass=1.0, inertia=np.eye(3), centre=[0.0, 0.0, 0.0])
    how = {"end": 1.0, "step": 0.5} if "times" not in more else {}
    bodies, slaves = {"ball": (BALL, free)}, {"pad": PAD}
    return cg.Simulation(bodies=bodies, slaves=slaves, contacts=[CONTACT], **how, **more)


def free(**more: Any) -> cg.motion.Free:
    return cg.motion.Free(**{"mass": 1.0, "inertia": np.eye(3), "centre": np.zeros(3), **more})


DOORS: dict[str, tuple[Callable[[Any], object], np.ndarray]] = {
    "Body.project": (BALL.project, POINTS),
    "Body.contains": (BALL.contains, POINTS),
    "Body.signed_distance": (BALL.signed_distance, POINTS),
    "Body.first_hit": (lambda x: BALL.first_hit(x, POINTS * 0.1), POINTS),
    "Body.first_hit to": (lambda x: BALL.first_hit(POINTS, x), POINTS * 0.1),
    "Body.ray": (lambda x: BALL.ray(POINTS, x), -POINTS),
    "Body.track": (lambda x: BALL.track(x, BALL.project(POINTS)), POINTS),
    "Body.transformed": (BALL.transformed, POSE),
    "Body.translated": (BALL.translated, UP),
    "Body.rotated": (lambda x: BALL.rotated(x, 0.1), UP),
    "Body.scaled": (lambda x: BALL.scaled(x), np.array([2.0, 2.0, 2.0])),
    "Body.with_reference_point": (BALL.with_reference_point, UP),
    "TriMesh": (lambda x: cg.TriMesh(x, CUBE.triangles), CUBE.vertices),
    "TriMesh triangles": (lambda x: cg.TriMesh(CUBE.vertices, x), CUBE.triangles),
    "TriMesh.project": (CUBE.project, POINTS),
    "TriMesh.ray": (lambda x: CUBE.ray(x, -POINTS), POINTS),
    "TriMesh.contains": (CUBE.contains, POINTS),
    "TriMesh.signed_distance": (CUBE.signed_distance, POINTS),
    "TriMesh.transformed": (CUBE.transformed, POSE),
    "NurbsSurface.evaluate": (SPHERE.evaluate, np.array([[0.5, 0.5], [0.2, 0.2]])),
    "NurbsSurface points": (
        lambda x: cg.NurbsSurface((1, 1), ([0, 0, 1, 1], [0, 0, 1, 1]), x),
        np.arange(12.0).reshape(2, 2, 3),
    ),
    "NurbsSurface weights": (
        lambda x: cg.NurbsSurface(
            (1, 1), ([0, 0, 1, 1], [0, 0, 1, 1]), np.arange(12.0).reshape(2, 2, 3), x
        ),
        np.array([[1.0, 2.0], [1.0, 2.0]]),
    ),
    "NurbsCurve knots": (
        lambda x: cg.NurbsCurve(1, x, [[0, 0, 0], [1, 0, 0]]),
        np.array([0.0, 0.0, 1.0, 1.0]),
    ),
    "NurbsCurve.evaluate": (LINE.evaluate, np.array([0.2, 0.4])),
    "NurbsCurve.insert_knots": (LINE.insert_knots, np.array([0.2, 0.4])),
    "knots.basis": (lambda x: cg.knots.basis(np.array([0.0, 0, 1, 1]), 1, x), np.array([0.1, 0.2])),
    "shapes centre": (lambda x: cg.shapes.sphere(radius=1.0, centre=x), UP),
    "shapes axes": (lambda x: cg.shapes.ellipsoid(axes=x), WEIGHED),
    "shapes.line": (lambda x: cg.shapes.line([0, 0, 0], x), UP),
    "Slave": (cg.Slave, POINTS),
    "Slave area": (lambda x: cg.Slave(POINTS, area=x), WEIGHED),
    "Slave thickness": (lambda x: cg.Slave(POINTS, thickness=x), WEIGHED),
    "Slave mass": (lambda x: cg.Slave(POINTS, mass=x), WEIGHED),
    "Slave facets": (lambda x: cg.Slave(POINTS, x), np.array([[0, 1, 2]])),
    "Slave active": (lambda x: cg.Slave(POINTS, active=x), np.array([True, True, False])),
    "Slave.transformed": (PAD.transformed, POSE),
    "Slave.selected nodes": (lambda x: PAD.selected(nodes=x), np.array([0, 1])),
    "Slave.selected box": (lambda x: PAD.selected(box=x), np.array([[-9.0] * 3, [9.0] * 3])),
    "Contact.start": (CONTACT.start, POINTS),
    "Contact.start pose": (lambda x: CONTACT.start(POINTS, x), POSE),
    "Contact.step": (lambda x: CONTACT.step(state(), x), POINTS),
    "Contact.step pose": (lambda x: CONTACT.step(state(), POINTS, x), POSE),
    "Contact.step velocity": (lambda x: CONTACT.step(state(), POINTS, velocity=x), POINTS),
    "Contact.step twist": (
        lambda x: CONTACT.step(state(), POINTS, velocity=POINTS, twist=(x, UP)),
        UP,
    ),
    "ForceLaw": (cg.ForceLaw, TABLE),
    "StressLaw": (lambda x: cg.StressLaw(x, 1.0), TABLE),
    "Characteristic": (cg.Characteristic, TABLE),
    "Characteristic at": (cg.Characteristic(TABLE), np.array([0.1, 0.2])),
    "NodalArea": (cg.NodalArea, WEIGHED),
    "clusters_of": (cg.clusters_of, POINTS),
    "Load force": (lambda x: cg.Load("a", force=x), ROWS),
    "Load at": (lambda x: cg.Load("a", force=[0, 0, 1], at=x), UP),
    "Spring at": (lambda x: cg.Spring(("a", "b"), at=x, curve=1.0), ROWS[:, 1:]),
    "Spring curve": (lambda x: cg.Spring(("a", "b"), at=ROWS[:, 1:], curve=x), TABLE),
    "Spring.step": (lambda x: SPRING.step(REST, x, np.zeros((2, 3))), ROWS[:, 1:]),
    "Spring.step velocity": (lambda x: SPRING.step(REST, ROWS[:, 1:], x), ROWS[:, 1:]),
    "Free mass": (lambda x: free(mass=x), np.float64(2.0)),
    "Free inertia": (lambda x: free(inertia=x), np.eye(3)),
    "Free velocity": (lambda x: free(velocity=x), UP),
    "Free spin": (lambda x: free(spin=x), UP),
    "Translate": (cg.motion.Translate, ROWS),
    "Rotate": (cg.motion.Rotate, TABLE),
    "Rotate axis": (lambda x: cg.motion.Rotate(TABLE, x), UP),
    "Velocity": (lambda x: cg.motion.Velocity(x, direction="x"), TABLE),
    "Accelerated": (cg.motion.Accelerated, ROWS),
    "Poses": (lambda x: cg.motion.Poses([0.0, 1.0], x), POSES),
    "Poses times": (lambda x: cg.motion.Poses(x, POSES), np.array([0.0, 1.0])),
    "Moved": (lambda x: cg.motion.Moved(x, cg.motion.Fixed()), POINTS),
    "pose.from_quaternion": (cg.motion.pose.from_quaternion, np.array([1.0, 0.0, 0.0, 0.0])),
    "pose.from_euler": (cg.motion.pose.from_euler, WEIGHED),
    "pose.apply": (lambda x: cg.motion.pose.apply(POSE, x), POINTS),
    "pose.as_pose": (cg.motion.pose.as_pose, POSE),
    "Simulation gravity": (lambda x: moved(gravity=x), UP),
    "Simulation times": (lambda x: moved(times=x), np.array([0.0, 1.0])),
    "cfc": (lambda x: cg.criteria.cfc(x, 1e-4, 180), SIGNAL),
    "hic": (lambda x: cg.criteria.hic(x, np.arange(3000) * 1e-4), SIGNAL),
    "hic times": (lambda x: cg.criteria.hic(SIGNAL, x), np.arange(3000) * 1e-4),
    "clip": (lambda x: cg.criteria.clip(x, np.arange(3000) * 1e-4), SIGNAL),
    "nij": (lambda x: cg.criteria.nij(x, SIGNAL), SIGNAL),
    "bric": (cg.criteria.bric, POINTS),
    "vc": (lambda x: cg.criteria.vc(x, 1e-4), SIGNAL * 0.1),
    "femur_force": (lambda x: cg.criteria.femur_force(x, np.arange(3000) * 1e-4), SIGNAL),
    "Bands": (lambda x: cg.criteria.Bands(x, "abc"), np.array([1.0, 2.0])),
    "Foam": (lambda x: cg.materials.Foam(loading=x), TABLE),
}


def masked(values: np.ndarray) -> np.ma.MaskedArray:
    """Its last entry is not known: NumPy takes what stands there all the same."""
    mask = np.zeros(np.shape(values), bool)
    mask[(*(-1 for _ in np.shape(values)),)] = True
    return np.ma.array(values, mask=mask)


@pytest.mark.parametrize("door", DOORS)
def test_complex_numbers_and_masked_entries_are_refused(door: str) -> None:
    take, good = DOORS[door]
    take(good)
    take(np.ma.array(good))  # nothing masked
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for bad in (good.astype(complex), list(np.atleast_1d(good).astype(complex))):
            with pytest.raises(InputError):
                take(bad)
        with pytest.raises(InputError, match="masked"):
            take(masked(good))
        if good.ndim > 1:
            with pytest.raises(InputError, match="masked"):
                take(list(masked(good)))


@pytest.mark.parametrize("value", [np.complex128(1.0), 1j, np.ma.masked, np.array([1.0 + 0j])[0]])
def test_numbers_alone_are_held_to_the_same(value: Any) -> None:
    for take in (
        cg.PenaltyLaw,
        lambda x: cg.PenaltyLaw(1.0, damping=x),
        lambda x: cg.shapes.sphere(radius=x),
        lambda x: cg.criteria.cfc(SIGNAL, x, 180),
        lambda x: cg.materials.Elastic(young=x, poisson=0.3),
        lambda x: cg.materials.Elastic(young=1.0, poisson=x),
        lambda x: moved(times=[0.0, x]),
    ):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with pytest.raises(InputError):
                take(value)
