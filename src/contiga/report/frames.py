"""The scene over time, small enough for a page: rigid parts are stored once, with their poses."""

from __future__ import annotations

from base64 import b64encode
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.records import FloatArray, IndexArray
from contiga.rendering.shading import sharp_mesh
from contiga.report.coloured import MIN_NODES, fields_of, region_colours
from contiga.report.peak import Outline, Peak, contact_at, lines_at, rows_of, seen_parts
from contiga.report.places import Ties, place_of, tie_ends
from contiga.report.run_folder import Units
from contiga.report.style import number

if TYPE_CHECKING:
    from contiga.io.out.outlines import OutlineSeries
    from contiga.report.fields import RecordedFields

MAX_FRAMES = 40
"""Largest number of steps that a page shows."""
BUDGET = 5_000_000
"""Largest size of them, bytes, before base64."""


class Frame(NamedTuple):
    """One recorded step."""

    time: float
    places: tuple[FloatArray, ...]
    """Places of the parts, bodies first.

    A place is a rotation by rows and a translation (12,) from its place at the peak, or the points
    (n, 3) in single precision.
    """
    rows: NDArray[np.int32]
    """(k,) slave points in contact, all slaves stacked."""
    values: dict[str, NDArray[np.float32]]
    """(k,) values of those points, by field; (n_s,) of all slave points if all have it."""
    outlines: tuple[Outline, ...]
    ties: FloatArray
    """(k, 2, 3) ends of springs and joints."""

    @property
    def size(self) -> int:
        """Size of its data for a page, bytes, without base64."""
        lines = sum(line.points.size * 4 for line in self.outlines)
        values = sum(v.nbytes for v in self.values.values())
        return sum(p.nbytes for p in self.places) + self.rows.nbytes + values + lines


class Frames(NamedTuple):
    """Recorded steps in the order of time."""

    frames: tuple[Frame, ...]
    first: int
    """Index of the step that is shown first, the peak."""
    recorded: int
    """Number of recorded steps."""
    sizes: tuple[list[int], list[int]]
    """Numbers of points of each body and of each slave."""
    tops: dict[str, float]
    """Values at which the colours of each field end, for all steps alike."""
    spans: list[list[float]]
    """Smallest and largest x, y and z of all visible points, over all steps."""
    touching_spans: list[list[float]]
    """Smallest and largest x, y and z of the touching parts at the peak."""

    @property
    def regions(self) -> tuple[Outline, ...]:
        """The lines around all regions of all steps."""
        return tuple(line for frame in self.frames for line in frame.outlines)

    @property
    def n_clusters(self) -> int:
        """The largest number of regions of one contact at any step."""
        numbers = (frame.values.get("cluster") for frame in self.frames)
        return 1 + int(max((v.max(initial=-1.0) for v in numbers if v is not None), default=-1))


def frames_of(
    series: RecordedFields,
    outlines: OutlineSeries | None,
    shown: int,
    peak: Peak,
    units: Units,
    ties: Ties = (),
) -> Frames:
    """Return recorded steps of a run: at most `MAX_FRAMES`, within `BUDGET`, `shown` among them.

    The steps are those of `chosen_steps`, thinned by `within`. Colours and axes are those of all
    chosen steps, also of those that are then left out. Steps other than `shown` with fewer than
    `MIN_NODES` points in contact do not raise the end of the colours of a contact.

    Parameters
    ----------
    series : fields of the run
    outlines : outlines of the regions of contact; None without them
    shown : index of the step that is shown first
    peak : the scene at that step
    units : units of the run
    ties : between bodies, drawn as lines
    """
    steps = chosen_steps(series.times, shown, MAX_FRAMES)
    kinds = [rows_of(series, kind) for kind in ("body", "slave")]
    parts = [rows for kind in kinds for rows in kind]
    start = series.points(0) if ties else np.zeros((0, 3))
    base = series.points(shown)
    tops = {name: field.top for name, field in fields_of(peak, units).items()}
    names = (*tops, *(() if peak.cluster is None else ("cluster",)))
    frames: list[Frame] = []
    extremes: list[FloatArray] = []
    touching_extremes: list[FloatArray] = []
    for step in steps.tolist():
        record = contact_at(series, step)
        points = series.points(step)
        rows = np.flatnonzero(record.in_contact).astype(np.int32)
        fields = record._asdict()
        values = {
            name: np.asarray(fields[name][rows], np.float32)
            for name in names
            if fields.get(name) is not None
        }
        # fields that all points have
        values |= {name: field.astype(np.float32) for name, field in record.inside.items()}
        frames.append(
            Frame(
                time=float(series.times[step]),
                places=tuple(place_of(base[part], points[part]) for part in parts),
                rows=rows,
                values=values,
                outlines=lines_at(outlines, step),
                ties=tie_ends(series, start, points, ties),
            )
        )
        seen = seen_parts(series, step)
        extremes += _extremes(np.concatenate([*seen, frames[-1].ties.reshape(-1, 3)]))
        touching = np.concatenate(seen) if peak.focus is None else peak.focus.points(seen)
        touching_extremes += _extremes(touching)
        # a few nodes at a rim do not represent the rest, as in a picture of one step
        for name, field in fields_of(record, units).items():
            if field.everywhere or len(rows) >= MIN_NODES:
                tops[name] = max(tops.get(name, 0.0), field.top)
    sizes = np.array([frame.size for frame in frames])
    rows_within = within(series.times[steps], sizes, int(np.searchsorted(steps, shown)))
    bodies, slaves = ([rows.stop - rows.start for rows in kind] for kind in kinds)
    return Frames(
        frames=tuple(frames[k] for k in rows_within),
        first=int(np.searchsorted(steps[rows_within], shown)),
        recorded=len(series.times),
        sizes=(bodies, slaves),
        tops=tops,
        spans=spans(np.array(extremes)),
        touching_spans=spans(np.array(touching_extremes)),
    )


def _extremes(points: FloatArray) -> list[FloatArray]:
    """Return the smallest and the largest finite x, y and z; empty without finite ones."""
    finite = points[np.isfinite(points).all(axis=1)]
    return [finite.min(axis=0), finite.max(axis=0)] if len(finite) else []


def spans(points: FloatArray) -> list[list[float]]:
    """Return the ranges [low, high] of x, y and z of points (n, 3), with a margin.

    It is 2 % of the range, and at least 1 % of the largest one.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    margin = np.maximum(0.02 * (high - low), 0.01 * float((high - low).max()))
    ranges: list[list[float]] = np.stack([low - margin, high + margin], axis=1).tolist()
    return ranges


def chosen_steps(times: FloatArray, shown: int, count: int) -> IndexArray:
    """Return at most `count` ascending steps, with the first, the last and `shown` among them.

    They are equally spaced in the sum of the fractions of time and of the number of steps passed,
    because steps are short where much happens. `shown` replaces the nearest inner step.

    Parameters
    ----------
    times : (n,) times of all steps
    shown : number of a step
    count : 3 or more
    """
    n = len(times)
    if n <= count:
        return np.arange(n)
    span = max(float(times[-1] - times[0]), 1e-300)
    progress = (times - times[0]) / span + np.arange(n) / (n - 1)
    targets = np.linspace(0.0, progress[-1], count)
    steps = np.unique(np.rint(np.interp(targets, progress, np.arange(n))).astype(np.intp))
    if shown not in steps:
        steps[1 + int(np.abs(steps[1:-1] - shown).argmin())] = shown
    return steps


def within(times: FloatArray, sizes: IndexArray, shown: int, budget: int = BUDGET) -> IndexArray:
    """Return the steps whose sizes (n,), bytes, fit into `budget`; `shown` is among them.

    A quarter of the steps is left out at a time, down to three (`chosen_steps`). If these are too
    large, `shown` alone is returned, whatever its size.
    """
    count = len(sizes)
    steps: IndexArray = np.arange(count)
    while count > 3 and sizes[steps].sum() > budget:
        count = max(3, count * 3 // 4)
        steps = chosen_steps(times, shown, count)
    return steps if sizes[steps].sum() <= budget else np.array([shown])


def packed(frames: Frames, peak: Peak, units: Units) -> dict[str, Any]:
    """Return the data of the frames for the script of the page, in single precision.

    Arrays are base64; poses are lists of nine digits. Outlines are stacked by the number of their
    region in `region_colours`.
    """
    keys = list(region_colours(frames.regions))
    packed_frames = []
    for frame in frames.frames:
        lines: dict[int, list[FloatArray]] = {}
        for line in frame.outlines:
            region = keys.index((line.contact, line.cluster))
            lines.setdefault(region, []).append(closed(line.points))
        packed_frames.append(
            {
                "places": [
                    base64(place) if place.ndim == 2 else [float(f"{x:.9g}") for x in place]
                    for place in frame.places
                ],
                "rows": base64(frame.rows, np.int32),
                "values": {name: base64(values) for name, values in frame.values.items()},
                "ties": base64(parted(frame.ties)),
                "lines": {str(k): base64(np.concatenate(points)) for k, points in lines.items()},
            }
        )
    return {
        "first": frames.first,
        "times": [frame.time for frame in frames.frames],
        "labels": [f"t = {number(frame.time)} {units.time}".strip() for frame in frames.frames],
        "sizes": {"body": frames.sizes[0], "slave": frames.sizes[1]},
        "body": base64(peak.body_points),
        "slave": base64(peak.slave_points),
        "facets": base64(peak.slave_triangles, np.int32),
        "drawn": {
            "body": base64(sharp_mesh(peak.body_points, peak.body_triangles).rows, np.int32),
            "slave": base64(sharp_mesh(peak.slave_points, peak.slave_triangles).rows, np.int32),
        },
        "idle": [] if peak.active is None else np.flatnonzero(~peak.active).tolist(),
        "frames": packed_frames,
    }


def closed(points: FloatArray) -> FloatArray:
    """Return a closed line and the gap to the next: its first point again, and NaN."""
    return np.concatenate([points, points[:1], np.full((1, 3), np.nan)])


def parted(lines: FloatArray) -> FloatArray:
    """Return the points (3 k, 3) of lines (k, 2, 3), each followed by NaN."""
    gaps = np.full((len(lines), 1, 3), np.nan)
    return np.concatenate([lines, gaps], axis=1).reshape(-1, 3)


def base64(values: NDArray[Any], dtype: Any = np.float32) -> str:
    """Return an array as `dtype`, little-endian, in base64 text."""
    return b64encode(np.asarray(values, np.dtype(dtype).newbyteorder("<")).tobytes()).decode()
