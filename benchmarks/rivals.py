"""The libraries that the search is set beside, on the same surface and the same points."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

import numpy as np

import contiga as cg
from contiga.arrays.threads import thread_count
from contiga_validation.rivals.comparison import Fcpw

Query = Callable[[np.ndarray], object]


def missing(*modules: str) -> str | None:
    """What of these cannot be imported, said with how to install it; None where all can."""
    for module in modules:
        try:
            import_module(module)
        except ImportError as error:
            return f'{module} ({error}); pip install "contiga[bench]"'
    return None


def grid_mesh(patch: cg.NurbsSurface, side: int) -> cg.TriMesh:
    """Two triangles a cell of an even grid of parameters."""
    x = np.linspace(0.0, 1.0, side + 1)
    uv = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    i = np.arange(len(uv)).reshape(len(x), len(x))
    a, b, c, d = i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]
    triangles = [np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]
    return cg.TriMesh(patch.evaluate(uv), np.concatenate(triangles))


def splinepy_feet(patch: cg.NurbsSurface) -> Query:
    """splinepy's point inversion on all threads, its k-d tree planted once."""
    import splinepy

    net = patch.control_points.transpose(1, 0, 2).reshape(-1, 3)  # its first parameter runs first
    other = splinepy.NURBS(
        degrees=list(patch.degrees),
        knot_vectors=[list(k) for k in patch.knots],
        control_points=net,
        weights=patch.weights.T.reshape(-1, 1),
    )
    plant = patch.evaluate(np.array([[0.5, 0.5]]))
    other.proximities(plant, initial_guess_sample_resolutions=[48, 48], nthreads=1)
    return lambda p: other.proximities(
        p,
        initial_guess_sample_resolutions=[-1, -1],
        tolerance=1e-10,
        nthreads=thread_count(),
        return_verbose=True,
    )


def fcpw_feet(mesh: cg.TriMesh, n: int) -> Query:
    """FCPW's vectorised closest points of `n` points, given as it wants them: `for_fcpw`."""
    rival, radii = Fcpw(mesh), np.full(n, np.inf, dtype=np.float32)
    return lambda p: rival(p, radii)


def for_fcpw(p: np.ndarray) -> np.ndarray:
    """The points in single precision and Fortran order."""
    return np.asfortranarray(p, dtype=np.float32)
