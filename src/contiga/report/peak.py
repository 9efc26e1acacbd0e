"""The moment of largest force, as points and triangles ready to be drawn."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.records import IN_CONTACT, FloatArray, IndexArray, IntArray
from contiga.report.focus import Focus, focus_of
from contiga.report.places import Ties, ties_at

if TYPE_CHECKING:
    from contiga.io.out.outlines import OutlineSeries
    from contiga.report.fields import RecordedFields


INSIDE = ("von_mises", "principal_strain", "energy_density")
"""Fields of the inside of deforming slaves, one number per node."""
_EMPTY_TIES = np.zeros((0, 2, 3))


class Outline(NamedTuple):
    """A closed line around a region of contact."""

    points: FloatArray
    """(k, 3), the first not repeated at the end."""
    cluster: int
    """Number of the region in its contact, from 0."""
    contact: int
    """Number of the contact."""


class Peak(NamedTuple):
    """Bodies and slaves at one recorded time, several of a kind stacked."""

    time: float
    body_points: FloatArray
    """(n_b, 3)."""
    body_triangles: IntArray
    """(m_b, 3)."""
    slave_points: FloatArray
    """(n_s, 3), those in contact inside the body."""
    slave_triangles: IntArray
    """(m_s, 3), no rows for a bare cloud."""
    in_contact: NDArray[np.bool_]
    """(n_s,)."""
    penetration: FloatArray
    """(n_s,) zero outside the contact."""
    direction: FloatArray
    """(3,) mean normal of the contact, to the free side; zero without a contact."""
    pressure: FloatArray | None = None
    """(n_s,) zero outside the contact; None where the run recorded none."""
    cluster: IntArray | None = None
    """(n_s,) number of the region of contact, −1 outside; None if the run recorded none."""
    inside: Mapping[str, FloatArray] = MappingProxyType({})
    """(n_s,) fields of deforming slaves, by name, zero for others; see `INSIDE`."""
    outlines: tuple[Outline, ...] = ()
    """Lines around the regions of contact."""
    active: NDArray[np.bool_] | None = None
    """(n_s,) whether points take part in contact; None if all do."""
    focus: Focus | None = None
    """Frame of the pictures; None for the whole scene."""
    framed: FloatArray | None = None
    """(k, 3) points of the frame; None for the whole scene."""
    ties: FloatArray = _EMPTY_TIES
    """(k, 2, 3) ends of springs and of lines of joints."""
    tie_kinds: tuple[str, ...] = ()
    """(k,) "spring" or "joint"."""

    @property
    def seen(self) -> FloatArray:
        """The points (k, 3) that a picture of the scene must contain."""
        if self.framed is not None:
            return self.framed
        active = slice(None) if self.active is None else self.active
        points = np.vstack([self.body_points, self.slave_points[active]])
        return np.asarray(points[np.isfinite(points).all(axis=1)])


class RecordedContact(NamedTuple):
    """Contact at a recorded time, by the slave points (n_s,); see `Peak`."""

    status: IntArray
    in_contact: NDArray[np.bool_]
    penetration: FloatArray
    pressure: FloatArray | None
    cluster: IntArray | None
    inside: Mapping[str, FloatArray]
    """(n_s,) fields of deforming slaves, by name, zero for others; see `INSIDE`."""


def stacked(series: RecordedFields, frame: int, kind: str) -> tuple[FloatArray, IntArray, IntArray]:
    """Return points, triangles and rows of all parts of one `kind`, "body" or "slave", stacked.

    These are points (n, 3), triangles (m, 3) of rows of these points, without those of bare clouds,
    and the rows (n,) among the points of all parts.
    """
    points = np.asarray(series.points(frame), dtype=np.float64)
    triangles, count = [np.zeros((0, 3), dtype=np.int32)], 0
    for part in series.parts:
        if part.kind == kind:
            if part.triangles is not None and len(part.triangles):
                triangles.append(np.asarray(part.triangles, dtype=np.int32) + np.int32(count))
            count += part.n_points
    rows = _rows_of_kind(series, kind)
    return points[rows], np.concatenate(triangles), rows.astype(np.int32)


def _rows_of_kind(series: RecordedFields, kind: str) -> IndexArray:
    """Return the rows (n,), among the stacked points, of all parts of one `kind`."""
    rows = [np.arange(part.start, part.stop) for part in rows_of(series, kind)]
    return np.concatenate([np.zeros(0, dtype=np.int64), *rows])


def rows_of(series: RecordedFields, kind: str) -> list[slice]:
    """Return a slice of the stacked points for each part of one `kind`."""
    return [series.rows(part.name) for part in series.parts if part.kind == kind]


def peak_frame(series: RecordedFields, times: FloatArray, force: FloatArray) -> int:
    """Return the index of the frame of largest force; without any force, of the deepest point.

    The first of equal frames is returned. `times` and `force` (n_steps,) come from the history,
    which has every step; a frame has the force of the row whose time is nearest to its own.
    """
    frames = np.asarray(series.times, dtype=np.float64)
    if len(times) and np.any(force > 0.0):
        rows = np.rint(np.interp(frames, times, np.arange(len(times)))).astype(np.intp)
        return int(np.argmax(force[rows]))
    depth = [float(np.max(series.data(i, "penetration"), initial=0.0)) for i in range(len(frames))]
    return int(np.argmax(depth))


def contact_at(series: RecordedFields, frame: int) -> RecordedContact:
    """Return the contact of the slaves at one recorded frame.

    Points that are not in contact have zeros, and −1 as cluster. Fields of the inside (`INSIDE`)
    have values at all points, zero in place of NaN. Pressure or cluster is None if not recorded.
    """
    rows = _rows_of_kind(series, "slave")
    status = np.asarray(series.data(frame, "contact_status"))[rows]
    in_contact = np.isin(status, [int(member) for member in IN_CONTACT])
    penetration = np.where(in_contact, np.asarray(series.data(frame, "penetration"))[rows], 0.0)
    pressure = cluster = None
    if "pressure" in series.names:
        pressure = np.where(in_contact, np.asarray(series.data(frame, "pressure"))[rows], 0.0)
    if "cluster" in series.names:
        cluster = np.where(in_contact, np.asarray(series.data(frame, "cluster"))[rows], -1)
    inside = {
        name: np.nan_to_num(np.asarray(series.data(frame, name), np.float64)[rows])
        for name in INSIDE
        if name in series.names
    }
    return RecordedContact(status, in_contact, penetration, pressure, cluster, inside)


def at_frame(
    series: RecordedFields, frame: int, outlines: OutlineSeries | None = None, ties: Ties = ()
) -> Peak:
    """Return the scene of one recorded frame; `outlines` has the same frames as `series`.

    Facets of slaves with an inactive node are left out.
    """
    body_points, body_triangles, _ = stacked(series, frame, "body")
    slave_points, slave_triangles, rows = stacked(series, frame, "slave")
    record = contact_at(series, frame)
    in_contact, penetration = record.in_contact, record.penetration
    active = record.status >= 0  # bodies and inactive nodes have none
    normal = np.asarray(series.data(frame, "normal"), dtype=np.float64)[rows]
    normal = np.where(in_contact[:, None], np.nan_to_num(normal), 0.0)
    mean = normal.sum(axis=0)
    length = float(np.linalg.norm(mean))
    parts, framed = seen_parts(series, frame), None
    focus = focus_of(parts, slave_points[in_contact], float(penetration.max(initial=0.0)))
    if focus is not None:
        framed = focus.points(parts)
        framed = framed[np.isfinite(framed).all(axis=1)]
    return Peak(
        time=float(series.times[frame]),
        body_points=body_points,
        body_triangles=body_triangles,
        slave_points=slave_points,
        slave_triangles=slave_triangles[active[slave_triangles].all(axis=1)],
        in_contact=in_contact,
        penetration=penetration,
        direction=mean / length if length > 0.0 else mean,
        pressure=record.pressure,
        cluster=record.cluster,
        inside=record.inside,
        outlines=lines_at(outlines, frame),
        active=None if active.all() else active,
        focus=focus,
        framed=framed,
        ties=ties_at(series, frame, ties),
        tie_kinds=tuple(tie.kind for tie in ties),
    )


def seen_parts(series: RecordedFields, frame: int) -> list[FloatArray]:
    """Return the points (n, 3) of each part at a recorded time; of slaves, only active points."""
    points = np.asarray(series.points(frame), dtype=np.float64)
    status = np.asarray(series.data(frame, "contact_status"))
    parts = []
    for part in series.parts:
        rows = series.rows(part.name)
        parts.append(points[rows] if part.kind == "body" else points[rows][status[rows] >= 0])
    return parts


def lines_at(outlines: OutlineSeries | None, frame: int) -> tuple[Outline, ...]:
    """Return the lines around the regions of contact at a recorded frame; empty if it has none."""
    if outlines is None or frame >= len(outlines.times):
        return ()
    points, first, cluster, contact = outlines.loops(frame)
    return tuple(
        Outline(points[a:b], int(k), int(c))
        for a, b, k, c in zip(first, first[1:], cluster, contact, strict=False)
    )
