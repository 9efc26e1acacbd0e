"""Findings about the parts of a case, collected while its files are read."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from contiga.errors import ContigaWarning
from contiga.simulation.checks.finding import Finding


@contextmanager
def warnings_as_findings(kind: str, name: str, findings: list[Finding]) -> Iterator[None]:
    """Append warnings of contiga from inside to `findings`, about a body or a slave.

    Other warnings are given again at the end. If an error is raised inside, all are dropped.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ContigaWarning)
        yield
    for warning in caught:
        if issubclass(warning.category, ContigaWarning):
            findings.append(
                Finding(
                    "file",
                    f"{kind} {name}",
                    str(warning.message).rstrip("."),
                    "Where that is not meant, choose what is read of it, or mend the file",
                )
            )
        else:
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )
