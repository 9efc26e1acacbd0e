"""`python -m tests.stress [names] [--full] [--seed N]`: attack search, checkpoints and steps.

Prints a line for each part and body, writes them as JSON, and ends with 1 if anything was wrong and
not flagged.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from tests.stress import (
    auto,
    checkpoints,
    closed,
    deforming,
    motions,
    open_scenes,
    opened,
    pierced,
    segments,
    shaking,
    solids,
    subjects,
    tracking,
    unions,
    valid,
    wandering,
)
from tests.stress.tally import Clock, Tally, write

Part = Callable[[bool, int], Iterator[Tally]]


def shake(full: bool, seed: int) -> Iterator[Tally]:
    """Closed bodies shaken through clouds: 1e7 point-steps in full."""
    scales = np.geomspace(1e-6, 0.3, 24 if full else 6)
    n, steps = (600, 48) if full else (150, 8)
    for name in solids.names():
        yield shaking.shaken(solids.solid(name), scales, n, steps, seed)


def unite(full: bool, seed: int) -> Iterator[Tally]:
    """Files whose solids touch or overlap, shaken as their union: 1e6 point-steps in full."""
    scales = np.geomspace(1e-6, 0.3, 16 if full else 6)
    n, steps = (240, 24) if full else (100, 16)
    for name in unions.RECIPES:
        yield shaking.shaken(unions.solid(name), scales, n, steps, seed)


def shoot(full: bool, seed: int) -> Iterator[Tally]:
    """Segments of every length and angle: 1e7 in full."""
    for name in solids.names():
        yield segments.shot(solids.solid(name), 600_000 if full else 6_000, seed)


def track(full: bool, seed: int) -> Iterator[Tally]:
    """Tracked steps of every size: 1e7 in full."""
    for name in tracking.names():
        item = tracking.tracked(name)
        count = 480_000 if full else 1_600
        yield tracking.follow(item, count, seed, scales=16 if full else 8)


def refine(full: bool, _: int) -> Iterator[Tally]:
    """The same motions in n, 10 n and, in full, 100 n steps."""
    for name in motions.MOTIONS:
        yield motions.refine(name, finest=3 if full else 2)


def slide(full: bool, seed: int) -> Iterator[Tally]:
    """Points that travel round each solid with a closed form."""
    for name in solids.RECIPES:
        yield motions.slide(solids.solid(name), 40, 4000 if full else 400, seed)


def turn(full: bool, seed: int) -> Iterator[Tally]:
    """A blade and internal teeth against points on arcs."""
    for name in motions.TURNS:
        yield motions.turn(name, 2000 if full else 300, 2000 if full else 60, seed)


def pushed(full: bool, seed: int) -> Iterator[Tally]:
    """Points that wander through solids, pushed by the wall that the rule says: 1e6 in full."""
    scales = np.geomspace(1e-6, 0.3, 24 if full else 6)
    n, steps = (110, 16) if full else (60, 8)
    for name in subjects.names():
        yield wandering.wandered(subjects.subject(name), scales, n, steps, seed)


def held_by_open_walls(full: bool, seed: int) -> Iterator[Tally]:
    """Paths through open shells, meshes and closed bodies of closed form: 1e6 rows in full."""
    for name in open_scenes.ALL:
        yield opened.walked(name, 260 if full else 20, seed, many=4 if full else 0)


def change_shape(full: bool, seed: int) -> Iterator[Tally]:
    """Points about masters that breathe, twist and fold: 1e6 point-steps in full."""
    rates = np.geomspace(2e-3, 0.3, 8 if full else 4)
    n, steps = (260, 41) if full else (60, 6)
    for name in deforming.MASTERS:
        yield deforming.deformed(name, rates, n, steps, seed)


def kept(full: bool, seed: int) -> Iterator[Tally]:
    """Checkpoints damaged at random, 10⁴ in full, and 200 runs killed at random moments."""
    yield checkpoints.damage(10_000 if full else 300, seed)
    if hasattr(os, "fork"):
        yield checkpoints.kill(200 if full else 5, seed)


def chosen_steps(full: bool, seed: int) -> Iterator[Tally]:
    """Random scenes in steps that choose themselves, and in far shorter ones: 1,000 in full."""
    count, parts, least = (1_000, 10, 2_000) if full else (20, auto.PARTS, auto.LEAST)
    for first in range(0, count, 20):
        yield auto.agree(
            range(1_000 * (seed - 1) + first, 1_000 * (seed - 1) + first + 20), parts, least
        )


def faces(full: bool, _: int) -> Iterator[Tally]:
    """Every face of every CAD file against OpenCASCADE: the reference test, in full if asked."""
    command = [sys.executable, "-m", "pytest", "-q", "tests/reference/test_projection_cad.py"]
    environment = os.environ | ({"CONTIGA_FULL": "1"} if full else {})
    with Clock(Tally("faces against OpenCASCADE, files")) as tally:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        tally.count = sum(map(int, re.findall(r"(\d+) (?:passed|failed)", done.stdout)))
        failed = sum(map(int, re.findall(r"(\d+) failed", done.stdout)))
        tally.wrong = failed or int(done.returncode != 0)
        if tally.wrong:
            tally.faults.append({"kind": "pytest", "output": done.stdout[-2000:]})
    yield tally


def closed_solids(full: bool, seed: int) -> Iterator[Tally]:
    """Valid solids by OpenCASCADE: closed, with their mass and sides; 566 in full."""
    first = 1_000 * (seed - 1)
    for family, count in (valid.FAMILIES | valid.ODD).items():
        yield closed.taken(family, range(first, first + (count if full else 2)))


def piercing(full: bool, seed: int) -> Iterator[Tally]:
    """Bodies that pierce themselves, told with the place: 64 in full."""
    first = 1_000 * (seed - 1)
    for family, count in pierced.FAMILIES.items():
        yield pierced.taken(family, range(first, first + (count if full else 1)))


PARTS: dict[str, Part] = {
    "closed": closed_solids,
    "pierced": piercing,
    "shaking": shake,
    "unions": unite,
    "segments": shoot,
    "tracking": track,
    "refinement": refine,
    "sliding": slide,
    "turning": turn,
    "rule": pushed,
    "open": held_by_open_walls,
    "deforming": change_shape,
    "checkpoints": kept,
    "auto": chosen_steps,
    "faces": faces,
}


def main(arguments: list[str] | None = None) -> int:
    """Run the parts named, all of them if none is."""
    parser = argparse.ArgumentParser(prog="python -m tests.stress", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="name", help=f"of {', '.join(PARTS)}")
    parser.add_argument("--full", action="store_true", help="the full sizes")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/stress.json"))
    chosen = parser.parse_args(arguments)
    unknown = [name for name in chosen.names if name not in PARTS]
    if unknown:
        parser.error(f"no part is called {unknown[0]}; there are {', '.join(PARTS)}")
    tallies: list[Tally] = []
    for name in chosen.names or PARTS:
        for tally in PARTS[name](chosen.full, chosen.seed):
            print(tally.line(), flush=True)
            tallies.append(tally)
            write(tallies, chosen.out)
    wrong = sum(tally.wrong for tally in tallies)
    print(f"{sum(tally.count for tally in tallies):,} in all, {wrong:,} wrong and unflagged")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
