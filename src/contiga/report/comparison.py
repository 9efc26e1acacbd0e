"""A comparison of runs: settings that differ, and the differences of their histories."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import trapezoid

from contiga.display import Displayed, Facts
from contiga.errors import InputError
from contiga.io.column_units import column_kind
from contiga.records import FloatArray
from contiga.report.lines import largest
from contiga.report.run_folder import Run
from contiga.report.runs import SEPARATOR, Named, read_runs

MAX_RUNS = 20
"""Largest number of runs in one comparison."""
NOISE = 1e-9
"""Magnitude up to which a column is rounding, as a fraction of the largest of its quantity."""
Values = tuple[Any, ...]
"""One value for each run; None where a run has none."""


class Difference(NamedTuple):
    """Largest difference of a column from that of the first run, over all other runs."""

    peaks: tuple[float, ...]
    """Value of greatest magnitude in each run."""
    peak_times: tuple[float, ...]
    """Time of the peak in each run."""
    largest: float
    """Greatest magnitude of a difference from the first run, over their common time."""
    at: float
    """Time of that difference."""
    rms: float
    """Greatest root mean square of a difference from the first run, over their common time."""

    @property
    def relative(self) -> float:
        """Largest difference as a fraction of the greatest peak; 0 if all peaks are zero."""
        peak = max(map(abs, self.peaks))
        return self.largest / peak if peak > 0.0 else 0.0


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Displayed):
    """A comparison of runs, all in the units of the first. See `compare`."""

    runs: tuple[Run, ...]
    """The output folders as read."""
    names: tuple[str, ...]
    """Name of each run."""
    span: tuple[float, float]
    """Start and end of the common time of the runs."""
    differences: dict[str, Difference]
    """Differences of the columns that all runs have, by ``<owner>.<name>``."""
    noise: frozenset[str]
    """Columns among these that are rounding in every run."""
    only: tuple[tuple[str, ...], ...]
    """Columns of each run that some other run lacks."""
    settings: dict[str, Values]
    """Settings that differ, each in the units of its case, by the key that ``--set`` takes."""
    criteria: dict[str, Values]
    """Values of criteria, by ``<sensor>: <criterion>``."""
    energies: dict[str, Values]
    """Energy balance error as a fraction of the largest energy (relative), and that energy (most).
    """
    timings: dict[str, Values]
    """Seconds by stage, and steps."""

    @property
    def folders(self) -> tuple[Path, ...]:
        """The output folders."""
        return tuple(run.folder for run in self.runs)

    @property
    def named(self) -> list[Named]:
        """The runs with their names."""
        return [Named(run, name) for run, name in zip(self.runs, self.names, strict=True)]

    @property
    def short_names(self) -> tuple[str, ...]:
        """The names of runs, without the values of cases of a study."""
        return tuple(name.partition(SEPARATOR)[0] for name in self.names)

    @property
    def same(self) -> bool:
        """Whether all quantities that the runs have are equal.

        They are if all runs have the same columns, which are equal at all times.
        """
        return not any(self.only) and all(d.largest == 0.0 for d in self.differences.values())

    def _facts(self) -> Facts:
        signals = {name: d for name, d in self.differences.items() if name not in self.noise}
        worst = max(signals.items(), key=lambda item: item[1].relative, default=None)
        return [
            ("runs", len(self.runs)),
            ("settings that differ", len(self.settings)),
            ("columns", len(self.differences)),
            ("largest difference", "none" if worst is None else f"{worst[1].relative:.3g}"),
            ("of", "none" if worst is None else worst[0]),
        ]


def compare(a: str | Path, b: str | Path, *more: str | Path) -> Comparison:
    """Compare runs with the first of them, by the files of their output folders.

    Runs in other units are converted to those of the first. Histories are interpolated linearly to
    the times of all runs within their common time.

    Parameters
    ----------
    a, b, more : output folders of 2 to 20 runs

    Returns
    -------
    Comparison
        ``differences`` of columns, ``settings`` that differ, ``criteria``, ``energies``,
        ``timings``.

    Raises
    ------
    FileError
        A folder is not that of a run.
    InputError
        More than 20 runs, only some of them have units, or they have no time in common.

    Examples
    --------
    >>> import contiga as cg
    >>> for speed in (-0.5, -1.0):
    ...     motion = {"kind": "translate", "table": [[0, 0, 0, 0], [4, 0, 0, 4 * speed]]}
    ...     changes = {"body.head.motion": motion, "sensor": [], "output.report": False}
    ...     case = cg.load_case("case.toml", set={"time.end": 4, "time.step": 1, **changes})
    ...     result = cg.run(case, f"out_{abs(speed)}")
    >>> found = cg.compare("out_0.5", "out_1.0")
    >>> list(found.settings)
    ['body.head.motion.table']
    >>> [round(peak, 9) for peak in found.differences["head-pad.max_penetration"].peaks]
    [0.5, 2.5]
    """
    folders = (a, b, *more)
    if len(folders) > MAX_RUNS:
        raise InputError(
            "too many runs for one comparison", found=len(folders), allowed=f"2 to {MAX_RUNS}"
        )
    named = read_runs(folders)
    runs = tuple(run for run, _ in named)
    times = _common_times(runs)
    columns = [columns_of(run) for run in runs]
    pairs = list(zip(runs, columns, strict=True))
    shared = [name for name in columns[0] if all(name in run for run in columns)]
    settings = _values_by_key([_flat(run.case) for run in runs])
    criteria = [
        {
            f"{sensor}: {name}": float(result["value"])
            for sensor, facts in run.summary_part("sensors").items()
            for name, result in facts["criteria"].items()
        }
        for run in runs
    ]
    energies: list[dict[str, float]] = [
        {key: float(energy[key]) for key in ("relative", "most") if key in energy}
        for energy in (run.summary_part("energy") for run in runs)
    ]
    timings = [
        {"steps": float(run.summary.get("steps") or len(run.times) - 1)}
        | {stage: float(seconds) for stage, seconds in run.summary_part("timings").items()}
        for run in runs
    ]
    return Comparison(
        runs=runs,
        names=tuple(name for _, name in named),
        span=(float(times[0]), float(times[-1])),
        differences={
            name: _difference([(run.times, values[name]) for run, values in pairs], times)
            for name in shared
        },
        noise=frozenset.intersection(
            *(_noise_columns(run, values, shared) for run, values in pairs)
        ),
        only=tuple(tuple(name for name in run if name not in set(shared)) for run in columns),
        settings={
            key: values
            for key, values in settings.items()
            if any(value != values[0] for value in values)
        },
        criteria=_values_by_key(criteria),
        energies=_values_by_key(energies),
        timings=_values_by_key(timings),
    )


def _noise_columns(
    run: Run, columns: Mapping[str, FloatArray], names: Sequence[str]
) -> frozenset[str]:
    """Return those of `names` whose columns are up to `NOISE` of the largest of their quantity.

    A moment is compared with the largest force times the largest length, too, and an angular
    velocity with one radian over the duration of the run.
    """
    sizes = {name: largest(columns[name]) for name in names}
    scales: dict[str, float] = defaultdict(float)
    for name, size in sizes.items():
        kind = column_kind(name)
        scales[kind] = max(scales[kind], size)
    scales["moment"] = max(scales["moment"], scales["force"] * scales["length"])
    if (span := float(np.ptp(run.times))) > 0.0:
        scales["spin"] = max(scales["spin"], 1.0 / span)
    return frozenset(n for n, size in sizes.items() if size <= NOISE * scales[column_kind(n)])


def columns_of(run: Run) -> dict[str, FloatArray]:
    """Return columns (n,) of a history by ``<owner>.<name>``, also those of an only contact.

    Those of slip rings, joints and steps are left out.
    """
    owners = [
        *run.contacts.items(),
        *run.bodies.items(),
        *run.sensors.items(),
        *run.springs.items(),
        *run.gas.items(),
    ]
    owners += [("energy", run.energy)] if run.energy else []
    return {
        f"{owner}.{name}": column for owner, columns in owners for name, column in columns.items()
    }


def _common_times(runs: Sequence[Run]) -> FloatArray:
    """Return the times of all runs within their common time, sorted, each once.

    Raises
    ------
    InputError
        A history has no rows, or the runs have no time in common.
    """
    for run in runs:
        if not len(run.times):
            raise InputError("the history has no rows", where=str(run.folder))
    start, end = max(run.times[0] for run in runs), min(run.times[-1] for run in runs)
    if start > end:
        late = max(runs, key=lambda run: float(run.times[0]))
        second_start = max(run.times[0] for run in runs if run is not late)
        raise InputError(
            "the runs have no time in common",
            where=str(late.folder),
            found=f"{late.times[0]:g} to {late.times[-1]:g}",
            allowed=f"{second_start:g} to {end:g}",
        )
    times = np.unique(np.concatenate([run.times for run in runs]))
    return np.asarray(times[(times >= start) & (times <= end)])


def _difference(signals: Sequence[tuple[FloatArray, FloatArray]], times: FloatArray) -> Difference:
    """Return the differences of signals, pairs of times and values, from the first at `times`.

    Signals are interpolated linearly between their finite values, constant beyond these; one
    without any is zero. Peaks and their times are of whole signals, not only within `times`.
    """
    peaks, peak_times, resampled = [], [], []
    for signal_times, values in signals:
        finite = np.isfinite(values)
        k = int(np.argmax(np.abs(np.where(finite, values, 0.0))))
        peaks.append(float(values[k]) if finite[k] else 0.0)
        peak_times.append(float(signal_times[k]))
        resampled.append(
            np.interp(times, signal_times[finite], values[finite])
            if finite.any()
            else np.zeros(len(times))
        )
    differences = np.abs(np.array(resampled[1:]) - resampled[0])
    k = int(np.argmax(differences.max(axis=0)))
    span = float(times[-1] - times[0])
    mean_squares = (
        trapezoid(d * d, times) / span if span > 0.0 else (d * d).mean() for d in differences
    )
    return Difference(
        tuple(peaks),
        tuple(peak_times),
        float(differences[:, k].max()),
        float(times[k]),
        max(float(np.sqrt(mean_square)) for mean_square in mean_squares),
    )


def _flat(value: Any, key: str = "") -> dict[str, Any]:
    """Return the leaves of nested tables by dotted key, below `key`.

    Tables in a list are keyed by their name, or by their index without one. Empty tables have no
    leaves.
    """
    if isinstance(value, dict):
        parts = {f"{key}.{name}" if key else name: part for name, part in value.items()}
    elif isinstance(value, list) and value and all(isinstance(table, dict) for table in value):
        parts = {
            f"{key}.{table['name']}" if isinstance(table.get("name"), str) else f"{key}[{k}]": table
            for k, table in enumerate(value)
        }
    else:
        return {key: value}
    return {name: leaf for k, part in parts.items() for name, leaf in _flat(part, k).items()}


def _values_by_key(runs: Sequence[Mapping[str, Any]]) -> dict[str, Values]:
    """Return the values of all runs by key, None where a run has none, in order of appearance."""
    keys = dict.fromkeys(key for run in runs for key in run)
    return {key: tuple(run.get(key) for run in runs) for key in keys}
