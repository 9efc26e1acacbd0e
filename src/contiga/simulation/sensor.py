"""A sensor: what of a body's motion a run tells."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from numpy.typing import ArrayLike

from contiga.criteria.filters import NAMES as FILTERS
from contiga.errors import InputError
from contiga.num.arrays import read_only
from contiga.num.transform import vector
from contiga.records import FloatArray

MEASURES = ("acceleration", "velocity", "displacement", "force", "moment")
CRITERIA = ("HIC15", "HIC36", "HICd", "3ms")


@dataclass(frozen=True, init=False, eq=False)
class Sensor:
    """Follows a point of a body, and what acts on the body.

    Parameters
    ----------
    name : what its columns are called
    body : name of the body
    at : (3,) the point, where it is at the start, world coordinates; the centre of mass of a free
        body, the origin of the geometry of another, if omitted
    axes : "world", or those of the "body"
    measures : of "acceleration", "velocity", "displacement", "force" and "moment" (of all that acts
        on the body, its weight too, the moment about the point)
    filter : "CFC60", "CFC180", "CFC600" or "CFC1000" (SAE J211) for the acceleration; none if
        omitted
    criteria : of "HIC15", "HIC36", "HICd" and "3ms", from the resultant acceleration as filtered

    Raises
    ------
    InputError
        Unknown measures, filters or criteria, criteria without acceleration.

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
    axes: str
    measures: tuple[str, ...]
    filter: str | None
    criteria: tuple[str, ...]

    def __init__(
        self,
        name: str,
        body: str,
        *,
        at: ArrayLike | None = None,
        axes: str = "world",
        measures: Iterable[str] = ("acceleration", "velocity", "displacement"),
        filter: str | None = None,
        criteria: Iterable[str] = (),
    ) -> None:
        put = object.__setattr__
        put(self, "name", name)
        put(self, "body", body)
        put(self, "at", None if at is None else read_only(vector(at, "at")))
        put(self, "axes", _one_of("axes", axes, ("world", "body")))
        put(self, "measures", _several("measures", measures, MEASURES))
        put(self, "filter", None if filter is None else _one_of("filter", filter, FILTERS))
        put(self, "criteria", _several("criteria", criteria, CRITERIA))
        for where in ("filter", "criteria"):
            if getattr(self, where) and "acceleration" not in self.measures:
                raise InputError(
                    "is about the acceleration, which the sensor does not measure",
                    where=f"sensor {name!r}: {where}",
                    found=", ".join(self.measures) or "no measures",
                    remedy='Add "acceleration" to its measures',
                )


def _one_of(where: str, value: object, allowed: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in allowed:
        raise InputError(
            "is not known", where=where, found=value, allowed=", ".join(map(repr, allowed))
        )
    return value


def _several(where: str, values: Iterable[str], allowed: tuple[str, ...]) -> tuple[str, ...]:
    given = (values,) if isinstance(values, str) else tuple(values)
    chosen = [_one_of(where, value, allowed) for value in given]
    return tuple(name for name in allowed if name in chosen)
