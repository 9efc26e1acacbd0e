"""Bodies of a MuJoCo model that carry masters and slaves, and how they stand and move.

What is asked of a model or its data has MuJoCo's own names; a body is named by its number.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.ordered import product
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid.twist import Twist

_WRONG = {"4.0.0": "has a wrong Hessian in its constraint solver"}
"""Versions of MuJoCo that move bodies wrongly, and why."""


class Carrier(NamedTuple):
    """A body of MuJoCo with what it carries."""

    body: int
    """Its number; 0 is the world."""
    carried: Any
    """A master or a slave, in the axes of the body's frame."""


class Frame(NamedTuple):
    """The position and the motion of a body."""

    pose: FloatArray
    """(4, 4) X_WB."""
    twist: Twist


def check_model(model: Any, data: Any) -> None:
    """Refuse what cannot be coupled.

    Raises
    ------
    InputError
        No model, data of another model, an integrator that has no step in two halves; a version of
        MuJoCo whose forces are wrong.
    """
    import mujoco

    version = mujoco.mj_versionString()
    if version in _WRONG:
        raise InputError(
            f"this version of MuJoCo {_WRONG[version]}",
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
    """Refuse an integrator that asks for forces several times a step."""
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


def carriers(model: Any, where: str, given: Mapping[str, Any]) -> dict[str, Carrier]:
    """Return which things stand on which body, given as ``name: thing`` or ``(thing, body)``.

    In the first form the body has that name.

    Raises
    ------
    InputError
        MuJoCo knows no such body, or its motion has no velocity (mocap).
    """
    by_slave = {}
    for name, one in given.items():
        pair = one if isinstance(one, tuple) and len(one) == 2 else (one, name)
        by_slave[name] = Carrier(_body(model, f"{where}[{name!r}]", pair[1]), pair[0])
    return by_slave


def _body(model: Any, where: str, name: Any) -> int:
    """The number of a body."""
    import mujoco

    kind = mujoco.mjtObj.mjOBJ_BODY
    body = mujoco.mj_name2id(model, kind, name) if isinstance(name, str) else -1
    if body < 0:
        known = [mujoco.mj_id2name(model, kind, i) for i in range(model.nbody)]
        raise InputError(
            "the MuJoCo model has no body of this name",
            where=where,
            found=name,
            allowed=", ".join(repr(one) for one in known if one),
        )
    if model.body_mocapid[model.body_rootid[body]] >= 0:
        raise InputError(
            "it stands on a mocap body, which is put in places and has no velocity",
            where=where,
            found=name,
            remedy="Weld a body with a free joint to the mocap body, and name that one",
        )
    return body


def moving(model: Any, bodies: Iterable[int]) -> dict[str, int]:
    """Those of `bodies` that can move, by their names."""
    numbers = dict.fromkeys(body for body in bodies if model.body_weldid[body] != 0)
    return {model.body(body).name: body for body in numbers}


def frame_of(model: Any, data: Any, body: int, speed: FloatArray) -> Frame:
    """Return where a body stands, and how it moves at the joint velocities `speed` (nv,)."""
    import mujoco

    pose = np.eye(4)
    pose[:3, :3] = data.xmat[body].reshape(3, 3)
    pose[:3, 3] = data.xpos[body]
    along, about = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, along, about, pose[:3, 3], body)
    return Frame(pose, Twist(product(along, speed), product(about, speed)))


def motion_of(
    model: Any, data: Any, body: int, speed: FloatArray, acceleration: FloatArray
) -> tuple[float, ...]:
    """Centre of mass, its velocity and acceleration, orientation and spin: 16 numbers.

    `speed` and `acceleration` (nv,) are those of the joints.
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
    """Velocity and acceleration (3,) of a point of a body, world axes; the rest as `motion_of`."""
    import mujoco

    along, about, along_rate, about_rate = (np.zeros((3, model.nv)) for _ in range(4))
    mujoco.mj_jac(model, data, along, about, point, body)
    mujoco.mj_jacDot(model, data, along_rate, about_rate, point, body)
    return product(along, speed), product(along, acceleration) + product(along_rate, speed)
