"""Find the bodies of a MuJoCo model that carry masters and slaves, with their poses and motions.

Fields of a model and its data have MuJoCo's own names; bodies are given by number.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.ordered import product
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid.twist import Twist

_FAULTY_VERSIONS = {"4.0.0": "has a wrong Hessian in its constraint solver"}
"""Versions of MuJoCo with wrong motions of bodies, and the reasons."""


class Carrier(NamedTuple):
    """A body of MuJoCo with the master or slave that it carries."""

    body: int
    """Number of the body; 0 is the world."""
    carried: Any
    """A master or a slave, in the axes of the body's frame."""


class Frame(NamedTuple):
    """The pose and the motion of a body."""

    pose: FloatArray
    """(4, 4) X_WB."""
    twist: Twist


def check_model(model: Any, data: Any) -> None:
    """Check that a model with its data can be coupled.

    Raises
    ------
    InputError
        No model, data of another model, an integrator without a step in two halves; a version of
        MuJoCo with wrong forces.
    """
    import mujoco

    version = mujoco.mj_versionString()
    if version in _FAULTY_VERSIONS:
        raise InputError(
            f"this version of MuJoCo {_FAULTY_VERSIONS[version]}",
            where="mujoco",
            found=version,
            allowed="another version",
            remedy=f'Install another: pip install "mujoco!={version}"',
        )
    if not isinstance(model, mujoco.MjModel):
        raise InputError(
            "must be a compiled model",
            where="model",
            found=type(model).__name__,
            allowed="a mujoco.MjModel, as MjModel.from_xml_path gives it",
        )
    if not isinstance(data, mujoco.MjData):
        raise InputError(
            "must be MuJoCo's data",
            where="data",
            found=type(data).__name__,
            allowed="mujoco.MjData(model)",
        )
    if data.model is not model:
        raise InputError(
            "the data are those of another model", where="data", allowed="mujoco.MjData(model)"
        )
    check_integrator(model)


def check_integrator(model: Any) -> None:
    """Raise `InputError` for an integrator that evaluates forces several times in a step."""
    import mujoco

    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        raise InputError(
            "this integrator asks for forces in the middle of a step: contacts, which remember "
            "their last step, cannot be asked there",
            where="model.opt.integrator",
            found="RK4",
            allowed="Euler, implicitfast or implicit",
            remedy='Write <option integrator="implicitfast"/>',
        )


def carriers(model: Any, where: str, things: Mapping[str, Any]) -> dict[str, Carrier]:
    """Return masters or slaves with their bodies, from ``name: thing`` or ``name: (thing, body)``.

    In the first form the body has the same name. `where` begins messages.

    Raises
    ------
    InputError
        The model has no such body, or its motion has no velocity (mocap).
    """
    by_name = {}
    for name, thing in things.items():
        pair = thing if isinstance(thing, tuple) and len(thing) == 2 else (thing, name)
        by_name[name] = Carrier(_body_number(model, f"{where}[{name!r}]", pair[1]), pair[0])
    return by_name


def _body_number(model: Any, where: str, name: Any) -> int:
    """Return the number of a body; raise `InputError` without one, or on a mocap body."""
    import mujoco

    kind = mujoco.mjtObj.mjOBJ_BODY
    body = mujoco.mj_name2id(model, kind, name) if isinstance(name, str) else -1
    if body < 0:
        names = [mujoco.mj_id2name(model, kind, i) for i in range(model.nbody)]
        raise InputError(
            "the MuJoCo model has no body of this name",
            where=where,
            found=name,
            allowed=", ".join(repr(body_name) for body_name in names if body_name),
        )
    if model.body_mocapid[model.body_rootid[body]] >= 0:
        raise InputError(
            "it stands on a mocap body, which is put in places and has no velocity",
            where=where,
            found=name,
            remedy="Weld a body with a free joint to the mocap body, and name that one",
        )
    return body


def moving_bodies(model: Any, bodies: Iterable[int]) -> dict[str, int]:
    """Return the numbers of the `bodies` that are not welded to the world, by name, each once."""
    numbers = dict.fromkeys(body for body in bodies if model.body_weldid[body] != 0)
    return {model.body(body).name: body for body in numbers}


def frame_of(model: Any, data: Any, body: int, speed: FloatArray) -> Frame:
    """Return the pose of a body's frame, and its twist at the joint velocities `speed` (nv,)."""
    import mujoco

    pose = np.eye(4)
    pose[:3, :3] = data.xmat[body].reshape(3, 3)
    pose[:3, 3] = data.xpos[body]
    linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, linear, angular, pose[:3, 3], body)
    return Frame(pose, Twist(product(linear, speed), product(angular, speed)))


def motion_of(
    model: Any, data: Any, body: int, speed: FloatArray, acceleration: FloatArray
) -> tuple[float, ...]:
    """Return centre of mass, its velocity and acceleration, orientation and spin: 16 numbers.

    All are in world axes, the orientation of the frame as (w, x, y, z). `speed` and `acceleration`
    (nv,) are those of the joints.
    """
    centre = data.xipos[body]
    velocity, rate = point_rates(model, data, body, centre, speed, acceleration)
    spin = frame_of(model, data, body, speed).twist[1]
    return (*centre, *velocity, *rate, *data.xquat[body], *spin)


def point_rates(
    model: Any,
    data: Any,
    body: int,
    point: FloatArray,
    speed: FloatArray,
    acceleration: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return velocity and acceleration (3,) of a point of a body, world axes; see `motion_of`."""
    import mujoco

    linear, angular, linear_rate, angular_rate = (np.zeros((3, model.nv)) for _ in range(4))
    mujoco.mj_jac(model, data, linear, angular, point, body)
    mujoco.mj_jacDot(model, data, linear_rate, angular_rate, point, body)
    return product(linear, speed), product(linear, acceleration) + product(linear_rate, speed)
