"""A digest of texts and arrays, with their lengths, shapes and types."""

from __future__ import annotations

import hashlib
import pickle
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Digest:
    """SHA-256 of a sequence of texts and arrays; `hexdigest` returns it."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()
        self.hexdigest = self._hash.hexdigest

    def text(self, text: str) -> None:
        """Add a text and its length."""
        data = text.encode()
        self._hash.update(f"{len(data)}:".encode() + data)

    def arrays(self, label: str, *arrays: NDArray[Any] | None) -> None:
        """Add a label, the number of arrays, and each array with its shape and type, or None."""
        self.text(f"{label}, {len(arrays)}")
        for array in arrays:
            if array is None:
                self.text("none")
            else:
                contiguous = np.ascontiguousarray(array)
                self.text(f"{contiguous.shape} {contiguous.dtype.str}")
                self._hash.update(contiguous.tobytes())

    def add_value(self, value: Any) -> None:
        """Add an object of any kind by its pickle."""
        self.text(pickle.dumps(value, protocol=5).hex())
