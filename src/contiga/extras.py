"""Packages that only some parts of contiga need, and the extra that installs each.

``pip install contiga`` brings numpy, numba and scipy: search, areas, laws, contact and simulations
in Python need no more. What does asks here first, so that its user is told what to install.
"""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from contiga.errors import MissingPackageError

EXTRA_OF = {
    "OCP": "cad",
    "rhino3dm": "cad",
    "meshio": "mesh",
    "h5py": "mesh",
    "pydantic": "case",
    "pint": "case",
    "typer": "case",
    "rich": "case",
    "plotly": "report",
    "matplotlib": "report",
    "sklearn": "cluster",
    "pandas": "pandas",
    "dask": "study",
    "distributed": "study",
    "optuna": "study",
    "mujoco": "mujoco",
    "objective_rating_metrics": "rating",
    "pyvista": "pyvista",
    "imageio_ffmpeg": "film",
}
"""The extra of each optional package, by the name it is imported by."""
PROJECT_OF = {
    "OCP": "cadquery-ocp-novtk",
    "sklearn": "scikit-learn",
    "objective_rating_metrics": "objective-rating-metrics",
    "imageio_ffmpeg": "imageio-ffmpeg",
}
"""The name it is installed by, where that is another."""


def require(purpose: str, *modules: str) -> None:
    """Make sure that packages are there, without importing them.

    Parameters
    ----------
    purpose : what they are needed for; the message begins with it
    modules : names of `EXTRA_OF`

    Raises
    ------
    MissingPackageError
        One or more are not installed; the message says how to install them.

    >>> require("drawing", "matplotlib")
    """
    missing = [module for module in modules if not _is_there(module)]
    if missing:
        names = " and ".join(PROJECT_OF.get(module, module) for module in missing)
        extras = ",".join(dict.fromkeys(EXTRA_OF[module] for module in missing))
        be = "is" if len(missing) == 1 else "are"
        raise MissingPackageError(
            f"{purpose} needs {names}, which {be} not installed. "
            f'Install what is missing with: pip install "contiga[{extras}]"'
        )


def imported(purpose: str, module: str) -> Any:
    """Import a module of a package that no extra of contiga installs.

    Raises
    ------
    MissingPackageError
        The package is not installed, or cannot be imported; the message names it.

    >>> imported("reading", "numpy").ndarray.__name__
    'ndarray'
    """
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        why = f"cannot be imported ({error})" if _is_there(package) else "is not installed"
        raise MissingPackageError(
            f"{purpose} needs {package}, which {why}. "
            f"Install what is missing with: pip install {package}"
        ) from error


def _is_there(module: str) -> bool:
    if module in sys.modules:
        return sys.modules[module] is not None
    try:
        return find_spec(module) is not None
    except ImportError:  # something stands in the way of all imports of that name
        return False
