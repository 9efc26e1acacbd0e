"""Two runs beside each other: other settings, and how far their histories differ."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import trapezoid

from contiga.display import Displayed, Facts
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.report.run_folder import Run, read_run

Pair = tuple[Any, Any]
"""The same of the first and of the second run, None where one has none."""


class Difference(NamedTuple):
    """How far a column of one history is from that of the other."""

    peaks: tuple[float, float]
    """The value of greatest magnitude in each run."""
    peak_times: tuple[float, float]
    """When it is reached."""
    largest: float
    """Greatest magnitude of second − first, over the times they have in common."""
    at: float
    """When it is reached."""
    rms: float
    """Root mean square of second − first over that time."""

    @property
    def relative(self) -> float:
        """The largest difference as a share of the greatest magnitude of either; 0 of zeros."""
        whole = max(map(abs, self.peaks))
        return self.largest / whole if whole > 0.0 else 0.0


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Displayed):
    """A comparison of two runs. See `compare`."""

    runs: tuple[Run, Run]
    """The output folders as read."""
    span: tuple[float, float]
    """The time the runs have in common."""
    differences: dict[str, Difference]
    """Of columns that both have, by ``<owner>.<name>``."""
    only: tuple[tuple[str, ...], tuple[str, ...]]
    """Columns that one run alone has."""
    settings: dict[str, Pair]
    """What the cases say otherwise, by the key that ``--set`` takes."""
    criteria: dict[str, Pair]
    """Values of criteria, by ``<sensor>: <criterion>``."""
    energies: dict[str, Pair]
    """Energy balance error: its share of the largest energy, and that energy."""
    timings: dict[str, Pair]
    """Seconds by stage, and steps."""

    @property
    def folders(self) -> tuple[Path, Path]:
        """The two output folders."""
        return self.runs[0].folder, self.runs[1].folder

    @property
    def same(self) -> bool:
        """Whether all quantities that both runs have are equal."""
        return not any(self.only) and all(d.largest == 0.0 for d in self.differences.values())

    def _facts(self) -> Facts:
        worst = max(self.differences.items(), key=lambda item: item[1].relative, default=None)
        return [
            ("settings that differ", len(self.settings)),
            ("columns", len(self.differences)),
            ("largest difference", "none" if worst is None else f"{worst[1].relative:.3g}"),
            ("of", "none" if worst is None else worst[0]),
        ]


def compare(a: str | Path, b: str | Path) -> Comparison:
    """Compare two runs by the files of their output folders.

    Histories are interpolated linearly to the times of both, as far as both go.

    Parameters
    ----------
    a, b : output folders of runs

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
        The runs are in other units, or have no time in common.

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
    one, two = read_run(Path(a)), read_run(Path(b))
    if one.units != two.units:
        raise InputError(
            "the runs are in other units",
            where=str(two.folder),
            found=", ".join(filter(None, two.units[:3])) or "none",
            allowed=", ".join(filter(None, one.units[:3])) or "none",
        )
    return _beside(one, two)


def _beside(one: Run, two: Run) -> Comparison:
    """Two runs in the same units beside each other."""
    times = _common_times(one, two)
    columns = columns_of(one), columns_of(two)
    both = [name for name in columns[0] if name in columns[1]]
    return Comparison(
        runs=(one, two),
        span=(float(times[0]), float(times[-1])),
        differences={
            name: _difference((one.times, columns[0][name]), (two.times, columns[1][name]), times)
            for name in both
        },
        only=(
            tuple(name for name in columns[0] if name not in columns[1]),
            tuple(name for name in columns[1] if name not in columns[0]),
        ),
        settings=_other_settings(one, two),
        criteria=_pairs(*(_criteria(run) for run in (one, two))),
        energies=_pairs(*(_energies(run) for run in (one, two))),
        timings=_pairs(*(_timings(run) for run in (one, two))),
    )


def columns_of(run: Run) -> dict[str, FloatArray]:
    """Columns (n,) of a history by ``<owner>.<name>``; those of a contact have its name always."""
    owners = [
        *run.contacts.items(),
        *run.bodies.items(),
        *run.sensors.items(),
        *run.springs.items(),
        *run.gas.items(),
    ]
    owners += [("energy", run.energy)] if run.energy else []
    return {f"{owner}.{name}": column for owner, of in owners for name, column in of.items()}


def _common_times(one: Run, two: Run) -> FloatArray:
    """Times of both runs, as far as both go."""
    if not (len(one.times) and len(two.times)):
        empty = one if not len(one.times) else two
        raise InputError("the history has no rows", where=str(empty.folder))
    first, last = max(one.times[0], two.times[0]), min(one.times[-1], two.times[-1])
    if first > last:
        raise InputError(
            "the runs have no time in common",
            where=str(two.folder),
            found=f"{two.times[0]:g} to {two.times[-1]:g}",
            allowed=f"{one.times[0]:g} to {one.times[-1]:g}",
        )
    times = np.union1d(one.times, two.times)
    return np.asarray(times[(times >= first) & (times <= last)])


def _difference(
    one: tuple[FloatArray, FloatArray], two: tuple[FloatArray, FloatArray], times: FloatArray
) -> Difference:
    peaks, whens, there = [], [], []
    for own, values in (one, two):
        known = np.isfinite(values)
        k = int(np.argmax(np.abs(np.where(known, values, 0.0))))
        peaks.append(float(values[k]) if known[k] else 0.0)
        whens.append(float(own[k]))
        there.append(
            np.interp(times, own[known], values[known]) if known.any() else np.zeros(len(times))
        )
    apart = np.abs(there[1] - there[0])
    k = int(np.argmax(apart))
    return Difference(
        (peaks[0], peaks[1]),
        (whens[0], whens[1]),
        float(apart[k]),
        float(times[k]),
        _root_mean_square(times, apart),
    )


def _root_mean_square(times: FloatArray, values: FloatArray) -> float:
    span = float(times[-1] - times[0])
    square = values * values
    return float(np.sqrt(trapezoid(square, times) / span if span > 0.0 else square.mean()))


def _other_settings(one: Run, two: Run) -> dict[str, Pair]:
    pairs = _pairs(_flat(_case(one)), _flat(_case(two)))
    return {key: pair for key, pair in pairs.items() if pair[0] != pair[1]}


def _case(run: Run) -> dict[str, Any]:
    try:
        return tomllib.loads(run.case_text)
    except ValueError:  # a run from Python may leave any text
        return {}


def _flat(value: Any, key: str = "") -> dict[str, Any]:
    """Values by dotted key; tables in a list by their name, or by their place."""
    if isinstance(value, dict):
        inner = {f"{key}.{name}" if key else name: one for name, one in value.items()}
    elif isinstance(value, list) and value and all(isinstance(one, dict) for one in value):
        inner = {
            f"{key}.{one['name']}" if isinstance(one.get("name"), str) else f"{key}[{k}]": one
            for k, one in enumerate(value)
        }
    else:
        return {key: value}
    return {name: one for k, v in inner.items() for name, one in _flat(v, k).items()}


def _criteria(run: Run) -> dict[str, float]:
    return {
        f"{sensor}: {name}": float(values["value"])
        for sensor, facts in run.told("sensors").items()
        for name, values in facts["criteria"].items()
    }


def _energies(run: Run) -> dict[str, float]:
    energy = run.told("energy")
    return {key: float(energy[key]) for key in ("relative", "most") if key in energy}


def _timings(run: Run) -> dict[str, float]:
    timings = {k: float(v) for k, v in run.told("timings").items()}
    return {"steps": float(run.summary.get("steps") or len(run.times) - 1), **timings}


def _pairs(one: Mapping[str, Any], two: Mapping[str, Any]) -> dict[str, Pair]:
    return {key: (one.get(key), two.get(key)) for key in (*one, *(k for k in two if k not in one))}
