"""`python -m benchmarks [PART …]`: the goals and what was measured, one table.

Parts named are run alone, and the file keeps what it says of the others. "first", which compiles
everything anew, is left out unless it is named or ``--all`` is given. Other tables are run by name:
area, area_errors, faceted, gpu, matter, matter_steps, mesher, runs, shells.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from benchmarks import (
    area,
    area_errors,
    faceted,
    gpu,
    machine,
    matter,
    matter_steps,
    mesher,
    runs,
    scaling,
    shells,
    startup,
    stepping,
    tangents,
    tracking,
)
from benchmarks.sizes import FULL, SMALL, Sizes
from benchmarks.table import Row, lines_of

PARTS: dict[str, Callable[[Sizes], Iterator[Row]]] = {
    "first": startup.first,
    "second": startup.second,
    "tracked": tracking.rows,
    "steps": stepping.rows,
    "free": stepping.free,
    "cold": tracking.cold,
    "swept": tracking.swept,
    "open": stepping.open_body,
    "deep": stepping.deep,
    "small": stepping.small,
    "tangents": tangents.rows,
    "threads": tracking.threads,
    "scaling": scaling.rows,
}
GOALS = (
    *(startup.FIRST, startup.COMPILE, startup.SECOND, startup.INFO),
    *(tracking.BESIDE_SPLINEPY, tracking.BESIDE_FCPW, stepping.PART, stepping.SPHERE),
    *(stepping.FREE, tracking.COLD, tracking.SWEPT, stepping.OPEN, stepping.SMALL),
    *(stepping.DEEP, stepping.DEEP_COPIES, stepping.DEEP_FORM),
    *(tangents.NODES, tangents.SPLINES, tangents.GRIPPED, tangents.BETWEEN),
    *(tracking.THREADS, scaling.FACES, scaling.POINTS),
)
"""In the order of the table."""
SLOW = ("first",)
TABLES = {
    "area": area,
    "area_errors": area_errors,
    "faceted": faceted,
    "gpu": gpu,
    "matter": matter,
    "matter_steps": matter_steps,
    "mesher": mesher,
    "runs": runs,
    "shells": shells,
}


def main(arguments: list[str] | None = None) -> None:
    """Measure, print the table, write the file."""
    options = _parsed(arguments)
    size = SMALL if options.small else FULL
    parts = [n for n in options.parts if n in PARTS]
    if not options.parts:
        parts = [name for name in PARTS if options.all or name not in SLOW]
    rows: list[Row] = []
    for name in parts:
        for row in PARTS[name](size):
            rows.append(row)
            print(*lines_of([row])[1:], flush=True)
    if rows:
        print("", *lines_of(rows), sep="\n")
        _write(options, rows, size)
        print(f"{sum(row.passed is True for row in rows)} of {len(rows)} goals; {options.out}")
    for name in options.parts:
        if name in TABLES:
            print(f"\n{name}", *(f"  {line}" for line in TABLES[name].run()), sep="\n")


def _write(options: argparse.Namespace, rows: list[Row], size: Sizes) -> None:
    """Write all rows of a full run; of a run of some parts, update their rows."""
    path, machine_facts = options.out, machine.described()
    content: dict[str, Any] = {"machine": machine_facts, "limits": {}, "rows": []}
    if options.parts and path.is_file():
        content |= json.loads(path.read_text(encoding="utf-8")) | {"machine": machine_facts}
    earlier = {row["work"]: row for row in content["rows"]}
    by_work = earlier | {row.work: row.as_json() | {"load": machine_facts["load"]} for row in rows}
    order = [row.work for row in GOALS if row.work in by_work]
    content["rows"] = [by_work[work] for work in order]
    content["limits"] = content["limits"] or machine.limits(size)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def _parsed(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    names = [*PARTS, *TABLES]
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(names))
    parser.add_argument("--all", action="store_true", help="the first run, too")
    parser.add_argument("--small", action="store_true", help="few points: does it run at all")
    parser.add_argument("-o", "--out", type=Path, default=Path("out/bench.json"))
    options = parser.parse_args(arguments)
    unknown = [name for name in options.parts if name not in names]
    if unknown:
        parser.error(f"no part is called {unknown[0]!r}; allowed: {', '.join(names)}")
    return options


if __name__ == "__main__":
    main()
