"""Define sensors of bodies: motion of a point and forces, in the world or relative to a body."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_numbers, check_types, checked_choice, read_only
from contiga.arrays.ordered import product
from contiga.criteria.bands import Bands
from contiga.criteria.dummies import DUMMIES
from contiga.criteria.filters import NAMES as FILTERS
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid.frames import cross
from contiga.rigid.transform import vector
from contiga.simulation.trigger import Trigger

MEASURES = ("acceleration", "velocity", "displacement", "force", "moment", "spin")
RELATIVE_MEASURES = ("distance", "displacement", "angle")
"""Default measures of a sensor between two bodies."""
RATES = ("velocity", "acceleration")
"""Further measures: the motion of the second point as seen from the first body."""
SPRING_MEASURES = ("force", "moment")
"""Further measures: those of the springs between the two bodies."""
SENSOR_COLUMNS = {
    "acceleration": ("ax", "ay", "az", "a"),
    "velocity": ("vx", "vy", "vz", "v"),
    "displacement": ("x", "y", "z"),
    "force": ("fx", "fy", "fz", "f"),
    "moment": ("mx", "my", "mz"),
    "spin": ("wx", "wy", "wz"),
}
"""Columns of the measures of a `Sensor`."""
RELATIVE_COLUMNS = {
    "distance": ("distance", "rate"),
    "displacement": ("x", "y", "z"),
    "angle": ("angle", "angle_x", "angle_y", "angle_z"),
    **{measure: SENSOR_COLUMNS[measure] for measure in (*RATES, *SPRING_MEASURES)},
}
"""Columns of the measures of a `RelativeSensor`."""


class Criterion(NamedTuple):
    """Requirements of a criterion; the default is a criterion of the resultant acceleration."""

    measures: tuple[str, ...] = ("acceleration",)
    """Measures that the sensor must have."""
    columns: tuple[str, ...] = ()
    """Columns of the sensor that it is computed from, each filtered by `filter`."""
    filter: str | None = None
    """Filter class that its source specifies, which `OF_SIGNALS` then evaluates by its name; None
    for the sensor's own filter and `OF_ACCELERATION`."""
    unit: str = ""
    in_body_axes: bool = False
    """Whether its components are in axes that turn with a body."""


CRITERIA = {
    "HIC15": Criterion(),
    "HIC36": Criterion(),
    "HICd": Criterion(),
    "3ms": Criterion(unit="g"),
    "chest3ms": Criterion(unit="g"),
    "BrIC": Criterion(("spin",), ("wx", "wy", "wz"), "CFC60", in_body_axes=True),
}
"""The criteria of a `Sensor`, by name."""
RELATIVE_CRITERIA = {
    "VC": Criterion(("distance",), ("distance",), "CFC180", unit="m/s"),
    "Nij": Criterion(SPRING_MEASURES, ("fz", "my"), "CFC600", in_body_axes=True),
    "femur": Criterion(("force",), ("fx", "fy", "fz"), "CFC600", in_body_axes=True),
}
"""The criteria of a `RelativeSensor`, by name."""
ALL_CRITERIA = {**CRITERIA, **RELATIVE_CRITERIA}
_AXES_TOL = 1e-6
"""Tolerance of axes from unit vectors at right angles."""
_CODE = re.compile(r"[A-Z0-9?]{12}")


@dataclass(frozen=True, init=False, eq=False)
class Sensor:
    """A sensor of the motion of a point of a body, and of the force on the body.

    Parameters
    ----------
    name : prefix of its columns
    body : name of the body
    at : (3,) the point, where it is at the start, world coordinates; the centre of mass of a free
        body, the origin of the geometry of another, if omitted
    axes : "world", those of the "body", or (3, 3) unit axes at the start, one a row, that turn with
        the body
    measures : of "acceleration", "velocity", "displacement", "force" and "moment" (of all that acts
        on the body, its weight too, the moment about the point) and "spin"
    filter : "CFC60", "CFC180", "CFC600" or "CFC1000" (SAE J211) for the acceleration; none if
        omitted
    criteria : of "HIC15", "HIC36", "HICd", "3ms" (in one stretch) and "chest3ms" (in all stretches
        together), from the resultant acceleration as filtered, and "BrIC", from the spin about the
        axes of the body, which is filtered by CFC60
    bands : of the values of criteria, by their names: `contiga.criteria.Bands`
    code : the first 12 characters of its channels' codes in ISO-MME files; made of the name if
        omitted
    trigger : `Trigger`: a threshold of one of its columns, which fires what waits for this sensor

    Raises
    ------
    InputError
        Unknown measures, filters or criteria, criteria without acceleration, bands of a criterion
        that is not asked for, a code of other than 12 capital letters and digits, a trigger by a
        column that it does not have.

    Examples
    --------
    >>> import contiga as cg
    >>> sensor = cg.Sensor("head_cg", "head", filter="CFC1000", criteria=["HIC15", "3ms"])
    >>> sensor.criteria, sensor.measures
    (('HIC15', '3ms'), ('acceleration', 'velocity', 'displacement'))
    """

    name: str
    body: str
    at: FloatArray | None
    axes: str | FloatArray
    measures: tuple[str, ...]
    filter: str | None
    criteria: tuple[str, ...]
    bands: Mapping[str, Bands]
    code: str | None
    trigger: Trigger | None

    def __init__(
        self,
        name: str,
        body: str,
        *,
        at: ArrayLike | None = None,
        axes: str | ArrayLike = "world",
        measures: Iterable[str] = ("acceleration", "velocity", "displacement"),
        filter: str | None = None,
        criteria: Iterable[str] = (),
        bands: Mapping[str, Bands] | None = None,
        code: str | None = None,
        trigger: Trigger | None = None,
    ) -> None:
        put = object.__setattr__
        put(self, "name", name)
        put(self, "body", body)
        put(self, "at", None if at is None else read_only(vector(at, "at")))
        put(self, "axes", _checked_axes(axes))
        put(self, "measures", _checked_names("measures", measures, MEASURES))
        put(self, "filter", None if filter is None else checked_choice("filter", filter, FILTERS))
        put(self, "criteria", _checked_names("criteria", criteria, tuple(CRITERIA)))
        put(self, "bands", dict(bands or {}))
        put(self, "code", _checked_code(code))
        put(self, "trigger", trigger)
        _check_measured(self, "filter", () if self.filter is None else ("acceleration",))
        _check_criteria(self)
        _check_trigger(self)

    @property
    def turns(self) -> bool:
        """Whether its axes turn with the body."""
        return not (isinstance(self.axes, str) and self.axes == "world")


@dataclass(frozen=True, init=False, eq=False)
class RelativeSensor:
    """A sensor of a point of one body relative to a point of another.

    Parameters
    ----------
    name : prefix of its columns
    between : names of two bodies; the first is where it is seen from
    at : (2, 3) the points, where they are at the start, world coordinates; as of a `Sensor` if
        omitted
    axes : of displacement, velocity, acceleration, force and moment: those of the first "body",
        "world", or (3, 3) as of a `Sensor`, which turn with the first body
    code : as of a `Sensor`
    measures : of "distance" (and its `rate`), "displacement" (how the second point has moved from
        where it was, seen from the first) and "angle" (by which the second body has turned against
        the first since the start, 0 to π, and that turn about the axes of the first body);
        "velocity" and "acceleration", the rates of that displacement: in the axes of the first body
        as one on it sees it, who turns with it, in those of the world the difference of the two
        points; the other way round in `between` they are in the axes of the other body; "force"
        and "moment" of all springs between the two on the first body, about the first point
    criteria : of "VC" (the distance is that of breastbone and spine; CFC180), "Nij" (F_z and M_y
        with z up, x forward, the first body below, and the first point the occipital condyle;
        CFC600) and "femur" (the force along the line of the two points; CFC600)
    bands : as of a `Sensor`
    dummy : "HIII-50", "HIII-5" or "EuroSID", for "VC" and "Nij"
    trigger : as of a `Sensor`

    Raises
    ------
    InputError
        Not two bodies, not two points, unknown measures or criteria, criteria without what they
        are about.

    Examples
    --------
    >>> import contiga as cg
    >>> sensor = cg.RelativeSensor("neck", ["torso", "head"], measures=["angle"])
    >>> sensor.between, sensor.measures
    (('torso', 'head'), ('angle',))
    """

    name: str
    between: tuple[str, str]
    at: FloatArray | None
    axes: str | FloatArray
    measures: tuple[str, ...]
    criteria: tuple[str, ...]
    bands: Mapping[str, Bands]
    dummy: str
    code: str | None
    trigger: Trigger | None

    def __init__(
        self,
        name: str,
        between: Sequence[str],
        *,
        at: ArrayLike | None = None,
        axes: str | ArrayLike = "body",
        measures: Iterable[str] = RELATIVE_MEASURES,
        criteria: Iterable[str] = (),
        bands: Mapping[str, Bands] | None = None,
        dummy: str = "HIII-50",
        code: str | None = None,
        trigger: Trigger | None = None,
    ) -> None:
        pair = () if isinstance(between, str) else tuple(between)
        if len(pair) != 2 or pair[0] == pair[1] or not all(isinstance(n, str) for n in pair):
            raise InputError(
                "must be two bodies", where="between", found=between, allowed="two names"
            )
        put = object.__setattr__
        put(self, "name", name)
        put(self, "between", pair)
        put(self, "at", None if at is None else _two_points(at))
        put(self, "axes", _checked_axes(axes))
        put(
            self,
            "measures",
            _checked_names("measures", measures, (*RELATIVE_MEASURES, *RATES, *SPRING_MEASURES)),
        )
        put(self, "criteria", _checked_names("criteria", criteria, tuple(RELATIVE_CRITERIA)))
        put(self, "bands", dict(bands or {}))
        put(self, "dummy", checked_choice("dummy", dummy, tuple(DUMMIES)))
        put(self, "code", _checked_code(code))
        put(self, "trigger", trigger)
        _check_criteria(self)
        _check_trigger(self)
        if "Nij" in self.criteria and DUMMIES[dummy].neck is None:
            raise InputError("has no neck for Nij", where=f"sensor {name!r}: dummy", found=dummy)
        if "femur" in self.criteria and (self.at is None or not (self.at[0] != self.at[1]).any()):
            raise InputError(
                "a femur's force is along the line of its two points",
                where=f"sensor {name!r}: at",
                found=None if self.at is None else self.at.tolist(),
                allowed="two points apart, hip and knee",
            )

    @property
    def turns(self) -> bool:
        """Whether its axes turn with the first body."""
        return not (isinstance(self.axes, str) and self.axes == "world")


def _check_criteria(sensor: Sensor | RelativeSensor) -> None:
    """Raise `InputError` for bands of other criteria, criteria without their measures or axes."""
    for name in sensor.bands:
        checked_choice("bands", name, sensor.criteria)
    for criterion in sensor.criteria:
        _check_measured(sensor, "criteria", ALL_CRITERIA[criterion].measures)
        if ALL_CRITERIA[criterion].in_body_axes and not sensor.turns:
            raise InputError(
                f"{criterion} is of components in the axes of a body",
                where=f"sensor {sensor.name!r}: axes",
                found="world",
                allowed='"body", or three axes',
            )


def channel_of(sensor: Sensor | RelativeSensor) -> str:
    """Return the column of a sensor that its trigger reads, by default "a" or "distance"."""
    channel = None if sensor.trigger is None else sensor.trigger.channel
    return channel or ("a" if isinstance(sensor, Sensor) else "distance")


def _check_trigger(sensor: Sensor | RelativeSensor) -> None:
    """Raise `InputError` for an object that is no trigger, or a channel that is not measured."""
    if sensor.trigger is None:
        return
    where = f"sensor {sensor.name!r}: trigger"
    check_types(Trigger, (sensor.trigger,), where, "must be a trigger", "contiga.Trigger")
    columns_of = SENSOR_COLUMNS if isinstance(sensor, Sensor) else RELATIVE_COLUMNS
    columns = [column for measure in sensor.measures for column in columns_of[measure]]
    if channel_of(sensor) not in columns:
        raise InputError(
            "the sensor has no such column",
            where=f"{where}: channel",
            found=channel_of(sensor),
            allowed=", ".join(map(repr, columns)),
        )


def _check_measured(sensor: Sensor | RelativeSensor, where: str, needed: tuple[str, ...]) -> None:
    for measure in needed:
        if measure not in sensor.measures:
            raise InputError(
                f"is about the {measure}, which the sensor does not measure",
                where=f"sensor {sensor.name!r}: {where}",
                found=", ".join(sensor.measures) or "no measures",
                remedy=f'Add "{measure}" to its measures',
            )


def _checked_code(code: str | None) -> str | None:
    if code is not None and not (isinstance(code, str) and _CODE.fullmatch(code)):
        raise InputError(
            "is not the start of a channel's code",
            where="code",
            found=code,
            allowed="12 capital letters and digits, such as 11HEAD0000H3",
        )
    return code


def _checked_axes(axes: str | ArrayLike) -> str | FloatArray:
    """Return "world", "body", or three right-handed unit vectors (3, 3), a read-only copy."""
    if isinstance(axes, str):
        return checked_choice("axes", axes, ("world", "body"))
    rows = as_numbers(axes, "axes", "must be three unit vectors", "(3, 3), one a row")
    square = rows.shape == (3, 3) and np.isfinite(rows).all()
    if not square or np.abs(product(rows, rows.T) - np.eye(3)).max() > _AXES_TOL:
        raise InputError(
            "must be three unit vectors at right angles",
            where="axes",
            found=np.asarray(axes).tolist(),
            allowed='"world", "body" or (3, 3) right-handed axes at the start, one a row',
        )
    if product(rows[0], cross(rows[1], rows[2])) < 0.0:
        raise InputError("must be right-handed", where="axes", found=rows.tolist())
    return read_only(rows.copy())


def _two_points(at: ArrayLike, where: str = "at") -> FloatArray:
    points = list(at) if isinstance(at, Sequence | np.ndarray) else []
    if len(points) != 2:
        raise InputError("must be two points", where=where, found=at, allowed="(2, 3)")
    return read_only(np.array([vector(point, where) for point in points]))


def _checked_names(where: str, values: Iterable[str], allowed: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names in the order of `allowed`, each once; one name may stand alone."""
    names = (values,) if isinstance(values, str) else tuple(values)
    chosen = [checked_choice(where, name, allowed) for name in names]
    return tuple(name for name in allowed if name in chosen)
