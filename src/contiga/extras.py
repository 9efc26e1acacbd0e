"""Packages that only some parts of contiga need, and the extra that installs each.

``pip install contiga`` brings numpy, numba and scipy: search, areas, laws, contact and simulations
in Python need no more. Features that need an optional package call `require`, which names the
missing extra.
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
"""The extra of each optional package, by the name of its import."""
PROJECT_OF = {
    "OCP": "cadquery-ocp-novtk",
    "sklearn": "scikit-learn",
    "objective_rating_metrics": "objective-rating-metrics",
    "imageio_ffmpeg": "imageio-ffmpeg",
}
"""The name of the project of a package, if it differs from its import."""


def require(purpose: str, *modules: str) -> None:
    """Check that packages are installed, without importing them.

    Parameters
    ----------
    purpose : feature that needs them; the message begins with it
    modules : keys of `EXTRA_OF`

    Raises
    ------
    MissingPackageError
        One or more are not installed; the message says how to install them.

    >>> require("drawing", "matplotlib")
    """
    missing = [module for module in modules if not _is_installed(module)]
    if missing:
        names = " and ".join(PROJECT_OF.get(module, module) for module in missing)
        extras = ",".join(dict.fromkeys(EXTRA_OF[module] for module in missing))
        verb = "is" if len(missing) == 1 else "are"
        raise MissingPackageError(
            f"{purpose} needs {names}, which {verb} not installed. "
            f'Install what is missing with: pip install "contiga[{extras}]"'
        )


def imported(purpose: str, module: str) -> Any:
    """Import and return a module of a package that no extra of contiga installs.

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
        reason = f"cannot be imported ({error})" if _is_installed(package) else "is not installed"
        raise MissingPackageError(
            f"{purpose} needs {package}, which {reason}. "
            f"Install what is missing with: pip install {package}"
        ) from error


def _is_installed(module: str) -> bool:
    if module in sys.modules:
        return sys.modules[module] is not None
    try:
        return find_spec(module) is not None
    except ImportError:  # an import hook refuses the name
        return False
