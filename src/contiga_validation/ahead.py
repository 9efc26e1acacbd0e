"""Kernels compiled ahead by a second process, while the first experiments run.

Compiling takes most of the first reproduction on a machine. Numba compiles one kernel at a time in
a process, but keeps what is compiled on disk, for other processes too: so another process runs
late experiments early and throws their results away. It starts with those that share least with
the first experiments. What it has not come to when it is needed is compiled there.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress

from contiga.arrays.threads import thread_count
from contiga_validation.engine.experiment import Experiment

MANY = 10
"""Experiments below which a second process does not pay."""
BEFORE = 6
"""Chapter before which the process must be done: from there on times are measured."""
LATE = ("5.1.2-surfaces", "meshes", "5.2.1-grouping", "5.4-area", "5.2.3-space")
"""What is run ahead: experiments, and the kernels on meshes."""

Wait = Callable[[], object]


@contextmanager
def compiling_ahead(experiments: Sequence[Experiment]) -> Iterator[Wait]:
    """Run the second process if it pays; the function given waits until it is done."""
    if thread_count() < 2 or len(experiments) < MANY:
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


def run_ahead(keys: Sequence[str] = LATE) -> None:
    """Run experiments for their kernels only; what fails here fails where it is reported."""
    from contiga_validation.catalogue import experiments
    from contiga_validation.engine.drawing import png

    known = {experiment.key: experiment for experiment in experiments()}
    for key in keys:
        with suppress(Exception):
            if key == "meshes":
                _meshes()
                continue
            for picture in known[key].run().pictures:
                png(picture)


def _meshes() -> None:
    """The kernels on meshes, without those on exact geometry."""
    from contiga_validation.rivals.comparison import bodies
    from contiga_validation.thesis.chapter6 import simulations
    from contiga_validation.thesis.play import played

    body = bodies()["torus"]
    mesh = body.tessellate(0.1 * body.size)
    mesh.project(mesh.vertices, start=mesh.project(mesh.vertices), mode="track")
    played(simulations()["tol 0.5"])
