"""A second process that compiles kernels while the first experiments run.

Compiling takes most of the first reproduction on a machine. Numba compiles one kernel at a time in
a process, but caches compiled kernels on disk for all processes: so another process runs late
experiments early and discards their results. It starts with the experiments that share the fewest
kernels with the first ones. Kernels that it has not reached are compiled when they are needed.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress

from contiga.arrays.threads import thread_count
from contiga_validation.engine.experiment import Experiment

MIN_EXPERIMENTS = 10
"""Number of experiments from which a second process pays."""
FIRST_TIMED_CHAPTER = 6
"""First chapter that measures times: the process must be done before."""
AHEAD_KEYS = ("5.1.2-surfaces", "meshes", "5.2.1-grouping", "5.4-area", "5.2.3-space")
"""Experiments that are run ahead, and "meshes" for the kernels on meshes."""

Wait = Callable[[], object]


@contextmanager
def compiling_ahead(experiments: Sequence[Experiment]) -> Iterator[Wait]:
    """Run the second process if it pays; yield a function that waits until it is done.

    It pays from `MIN_EXPERIMENTS` experiments and two threads on. At the end of the block it is
    killed.
    """
    if thread_count() < 2 or len(experiments) < MIN_EXPERIMENTS:
        yield lambda: None
        return
    code = "from contiga_validation.ahead import run_ahead; run_ahead()"
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield process.wait
    finally:
        process.kill()
        process.wait()


def run_ahead(keys: Sequence[str] = AHEAD_KEYS) -> None:
    """Run experiments to compile their kernels, in this process; errors are ignored.

    The real run reports them.
    """
    from contiga_validation.catalogue import experiments
    from contiga_validation.engine.drawing import png
    from contiga_validation.rivals.comparison import bodies
    from contiga_validation.thesis.chapter6 import simulations
    from contiga_validation.thesis.play import run_simulation

    by_key = {experiment.key: experiment for experiment in experiments()}
    for key in keys:
        with suppress(Exception):
            if key != "meshes":
                for picture in by_key[key].run().pictures:
                    png(picture)
                continue
            body = bodies()["torus"]
            mesh = body.tessellate(0.1 * body.size)
            mesh.project(mesh.vertices, start=mesh.project(mesh.vertices), mode="track")
            run_simulation(simulations()["tol 0.5"])
