"""``python -m tests.fuzz``: damage files and read them, many at a time.

Each job is a process that may die or hang: what it was reading then is kept like any other file
that was neither read nor refused with a message, and a fresh job goes on with the next.
"""

from __future__ import annotations

import argparse
import os
import queue
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

import numpy as np
from tests.fuzz.judge import READ, REFUSED, judged
from tests.fuzz.mutate import mutated
from tests.fuzz.seeds import write_seeds

_SECONDS, _MEMORY = "10", "1000"
_HANGS_AFTER = 90.0
"""Far beyond the bound on reading: the reading process itself hangs."""


def damaged(seeds: list[Path], number: int, seed: int, folder: Path) -> Path:
    """The file of a number, written to `folder` with what belongs to it."""
    rng = np.random.default_rng([seed, number])
    source = seeds[int(rng.integers(len(seeds)))]
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(source.parent, folder)
    parts = sorted(p for p in folder.iterdir() if p.suffix == source.suffix or rng.random() < 0.3)
    part = (
        parts[int(rng.integers(len(parts)))] if source.suffix != ".toml" else folder / source.name
    )
    part.write_bytes(mutated(part.read_bytes(), rng))
    return folder / source.name


def work(args: argparse.Namespace) -> None:
    """Read every `jobs`-th file from `first` on, saying of each number what came of it."""
    seeds = write_seeds(Path(args.folder) / "seeds", args.only)
    folder = Path(args.folder) / f"job{args.first % args.jobs}"
    for number in range(args.first, args.count, args.jobs):
        print(f"{number}\tbegun\t\t", flush=True)
        path = damaged(seeds, number, args.seed, folder)
        started = time.monotonic()
        result, said = judged(path)
        took = time.monotonic() - started
        print(f"{number}\t{result}\t{path.name}, {took:.1f} s\t{said}", flush=True)


class Job:
    """A working process and the lines it says."""

    def __init__(self, args: argparse.Namespace, first: int) -> None:
        self.number = first
        options = ["--count", str(args.count), "--jobs", str(args.jobs), "--seed", str(args.seed)]
        options += ["--folder", args.folder, "--first", str(first), "--only", args.only]
        env = {"CONTIGA_READ_SECONDS": _SECONDS, "CONTIGA_READ_MEMORY": _MEMORY, **os.environ}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.fuzz", *options],
            stdout=subprocess.PIPE,
            text=True,
            env=env,
        )
        self.lines: queue.Queue[str] = queue.Queue()
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.put(line)
        self.lines.put("")

    def line(self) -> list[str] | None:
        """The next line in pieces; None at the end."""
        line = self.lines.get(timeout=_HANGS_AFTER)
        return line.rstrip("\n").split("\t") if line else None


def follow(args: argparse.Namespace, first: int, counts: Counter[str]) -> None:
    """Run one job to the end, and again whenever it dies or hangs."""
    while first < args.count:
        job = Job(args, first)
        last = first - args.jobs
        try:
            while (pieces := job.line()) is not None:
                number, result, name, said = int(pieces[0]), *pieces[1:4]
                if result != "begun":
                    last = number
                    note(args, counts, number, result, f"{name}: {said}")
                job.number = number
            ended = job.process.wait()
            wrong = None if ended == 0 else f"the reading process ended with {ended}"
        except queue.Empty:
            job.process.kill()
            wrong = "the reading process hangs"
        first = last + args.jobs
        if wrong is None:
            return
        note(args, counts, first, wrong, "")
        first += args.jobs


def note(args: argparse.Namespace, counts: Counter[str], number: int, what: str, said: str) -> None:
    """Count a file, and keep it where it was neither read nor refused."""
    counts[what] += 1
    if what not in (READ, REFUSED):
        print(f"WRONG {number}: {what}: {said}", flush=True)
        kept = Path(args.folder) / "wrong" / str(number)
        damaged(write_seeds(Path(args.folder) / "seeds", args.only), number, args.seed, kept)
    if args.messages:
        with open(args.messages, "a", encoding="utf-8") as file:
            file.write(f"{number}\t{what}\t{said}\n")
    total = counts.total()
    if total % 1000 == 0:
        print(f"{total} files: {dict(counts)}", flush=True)


def main() -> int:
    """Exit code 1 where a file was neither read nor refused with a message."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="files to damage and read")
    parser.add_argument("--jobs", type=int, default=2, help="processes that read")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", default="out/fuzz", help="what is wrong is kept in it")
    parser.add_argument("--only", default="", help="only seeds whose name contains this")
    parser.add_argument("--messages", help="file for all that was said")
    parser.add_argument("--first", type=int, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.first is not None:
        work(args)
        return 0
    write_seeds(Path(args.folder) / "seeds", args.only)
    counts: Counter[str] = Counter()
    started = time.monotonic()
    threads = [
        threading.Thread(target=follow, args=(args, first, counts)) for first in range(args.jobs)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    wrong = sum(n for what, n in counts.items() if what not in (READ, REFUSED))
    took = time.monotonic() - started
    print(f"{counts.total()} files in {took:.0f} s: {dict(counts)}; {wrong} wrong")
    return 1 if wrong or counts.total() != args.count else 0


if __name__ == "__main__":
    sys.exit(main())
