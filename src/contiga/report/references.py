"""Curves of tests beside a run: their places, corridors and ratings."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np

from contiga.criteria.rating import Rating, iso18571
from contiga.errors import InputError, MissingPackageError
from contiga.io.channels import channel_names, channel_of, shown
from contiga.io.column_units import column_factor
from contiga.io.units import base_factor
from contiga.records import FloatArray
from contiga.report.html_tables import named_row, named_table
from contiga.report.run_folder import Run
from contiga.report.style import number

_ONSET_SHARE = 0.05
"""Fraction of its greatest magnitude at which a signal begins."""


class Reference(NamedTuple):
    """The curve of a test, in the units in which the channels of a run are shown."""

    channel: str
    """Channel of the run that was measured, by its full name."""
    x: str
    """Channel of the abscissa, by its full name."""
    name: str
    """Name of the test."""
    points: FloatArray
    """(n, 2) abscissa and value."""
    band: FloatArray
    """(k, 3) abscissa, lower and upper value of its corridor; k = 0 without one."""
    shift: float | None
    """Shift of the abscissa; None moves the onset of the test to that of the run."""

    def moved(self, run: Run) -> Reference:
        """Return a copy of the curve and its corridor, shifted to where it is drawn beside a run.

        A shift of None becomes the difference of their onsets.

        Raises
        ------
        InputError
            The shift is None and the run lacks the channel.
        """
        shift = self.shift
        if shift is None:
            channel = channel_of(run.history, run.summary, self.channel)
            shift = onset(run.times, channel.values) - onset(*self.points.T)
        points, band = self.points.copy(), self.band.copy()
        points[:, 0] += shift
        band[:, 0] += shift
        return self._replace(points=points, band=band, shift=shift)


def onset(times: FloatArray, values: FloatArray) -> float:
    """Return the time at which a signal first reaches 5 % of its greatest magnitude.

    The time is linear between two rows. It is the first time if the first row is at that level
    already, which includes a signal of zeros, and 0 without finite rows.

    Parameters
    ----------
    times, values : (n,); rows with a value that is not finite are left out

    >>> onset(np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.0, -40.0]))
    1.05
    """
    is_finite = np.isfinite(values)
    times, sizes = times[is_finite], np.abs(values[is_finite])
    level = _ONSET_SHARE * sizes.max(initial=0.0)
    k = int(np.argmax(sizes >= level)) if len(sizes) else 0
    if k == 0:
        return float(times[0]) if len(times) else 0.0
    share = (level - sizes[k - 1]) / (sizes[k] - sizes[k - 1])
    return float(times[k - 1] + share * (times[k] - times[k - 1]))


def whole_name(run: Run, name: str) -> str:
    """Return the name of a channel with its contact, which may be omitted if there is only one.

    Other names, with a dot or ``time``, stay as they are.
    """
    contacts = list(run.summary_part("statuses"))
    bare = name != "time" and "." not in name and len(contacts) == 1
    return f"{contacts[0]}.{name}" if bare else name


def references_of(run: Run) -> list[Reference]:
    """Return the tests that the case of a run names and for which the run has the channels.

    A run has filtered channels once it has ended. Tables that are not those of a checked case are
    left out: a run from Python may have any text as its case.
    """
    references = [
        _reference(run, table)
        for table in run.case.get("reference") or []
        if isinstance(table, dict) and {"channel", "points", "name"} <= table.keys()
    ]
    return [reference for reference in references if has_channels(run, reference)]


def has_channels(run: Run, reference: Reference) -> bool:
    """Return whether a run has both channels of a test, abscissa and value."""
    names = channel_names(run.history, run.summary_part("statuses"), run.summary_part("layers"))
    return {reference.channel, reference.x} <= names


def _reference(run: Run, table: dict[str, Any]) -> Reference:
    """Return the test of a `[[reference]]` table, in the units in which channels are shown.

    A corridor given as a number is that fraction of the greatest magnitude of the test, up and
    down.
    """
    x, channel = table.get("x", "time"), table["channel"]
    to = (run.units.length, run.units.mass, run.units.time)
    length = column_factor(x, run.own_units, to) if all(to) else 1.0
    value = column_factor(channel, run.own_units, to) if all(to) else 1.0

    def as_shown(rows: FloatArray) -> FloatArray:
        units = run.summary.get("units") or {}
        columns = [shown(x, length * rows[:, 0], units).values]
        columns += [shown(channel, value * column, units).values for column in rows.T[1:]]
        return np.column_stack(columns)

    points = as_shown(np.array(table["points"], np.float64))
    corridor, shift = table.get("corridor"), table.get("shift", 0.0)
    if isinstance(corridor, list):
        band = as_shown(np.array(corridor, np.float64))
    elif corridor is not None:
        half = float(corridor) * np.abs(points[:, 1]).max()
        band = np.column_stack([points[:, 0], points[:, 1] - half, points[:, 1] + half])
    else:
        band = np.zeros((0, 3))
    return Reference(
        whole_name(run, channel),
        whole_name(run, x),
        str(table["name"]),
        points,
        band,
        None if shift == "onset" else length * float(shift),
    )


class Rated(NamedTuple):
    """The rating of a run beside a test."""

    reference: Reference
    """The test, shifted to where it is drawn."""
    run: str
    """Name of the run; empty where there is only one."""
    rating: Rating | None
    why: str
    """Reason for a missing rating; empty with one."""


def rated(run: Run, reference: Reference, name: str = "") -> Rated:
    """Rate the agreement of a run with a test by ISO/TS 18571.

    The test is returned as it is drawn beside the run, with `name`, that of the run. A rating that
    is not possible is None, with the reason: the abscissa is not time, the run has no unit of time,
    `iso18571` refuses the signals, or a package is missing.

    Raises
    ------
    InputError
        The run lacks the channel of the test.
    """
    moved = reference.moved(run)
    if reference.x != "time" or not run.units.time:
        why = "ISO/TS 18571 rates signals over time"
        why += "" if reference.x != "time" else ", and the run does not name its unit of time"
        return Rated(moved, name, None, why)
    second = base_factor(run.units.time, "time")
    values = channel_of(run.history, run.summary, reference.channel).values
    is_finite = np.isfinite(values)
    try:
        rating = iso18571(
            moved.points[:, 1],
            values[is_finite],
            second * run.times[is_finite],
            second * moved.points[:, 0],
        )
    except (InputError, MissingPackageError) as error:
        return Rated(moved, name, None, str(error))
    return Rated(moved, name, rating, "")


def ratings_table(ratings: Sequence[Rated], unit: str) -> str:
    """Return the table of ratings, with the shift of each test; empty without ratings.

    A line follows for each reason for which ratings are missing, and names these.
    """
    rows = []
    for reference, run, rating, _ in ratings:
        if rating is not None:
            scores = [number(score, 3) for score in rating]
            shift = f"{number(reference.shift or 0.0)} {unit}"
            channel = f"{run}: {reference.channel}" if run else reference.channel
            rows.append(named_row(channel, reference.name, [escape(shift), *scores, rating.grade]))
    heads = ("Channel", "Test", "Shifted by", "Corridor", "Phase", "Magnitude", "Slope", "Overall")
    parts = []
    if rows:
        table = named_table((*heads, "Grade"), rows)
        caption = "Ratings by ISO/TS 18571, from 0 to 1, over the common time of run and test."
        parts.append(f'<h3>Comparison with tests</h3><div class="wide">{table}</div>')
        parts.append(f'<p class="caption">{caption}</p>')
    for why in dict.fromkeys(rating.why for rating in ratings if rating.why):
        tests = (rating.reference for rating in ratings if rating.why == why)
        names = dict.fromkeys(f"{test.channel} over {test.x} beside {test.name}" for test in tests)
        note = f"No rating of {', '.join(names)}: {why}."
        parts.append(f'<p class="caption">{escape(note)}</p>')
    return "".join(parts)
