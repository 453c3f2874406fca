"""Base64 encoding of arrays in a browser page."""

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats


class Packed:
    """Concatenated little-endian arrays, aligned to four bytes."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def add(self, array: NDArray[Any]) -> dict[str, Any]:
        """Append an array of floats, in single precision, or of indices; return its location."""
        if array.dtype.kind == "f":
            kind = "f4"
        elif array.dtype == np.uint8:
            kind = "u1"
        else:
            kind = "u2" if array.max(initial=0) < 2**16 else "u4"
        self._bytes += bytes(-len(self._bytes) % 4)
        entry = {"at": len(self._bytes), "type": kind, "count": array.size}
        self._bytes += np.ascontiguousarray(array, dtype=f"<{kind}").tobytes()
        return entry

    def add_floats(self, values: Floats) -> dict[str, Any]:
        """Append floats of any magnitude in single precision; values are ``step`` times the entries."""
        finite = np.isfinite(values)
        step = float(np.abs(values[finite]).max(initial=0.0)) or 1.0
        return {**self.add(np.where(finite, values, np.nan) / step), "low": 0.0, "step": step}

    def add_short(self, values: Floats) -> dict[str, Any]:
        """Append floats as 16-bit integers; values are ``low + step * entry``, and 65535 denotes none."""
        finite = np.isfinite(values)
        low = float(values[finite].min(initial=np.inf)) if finite.any() else 0.0
        high = float(values[finite].max(initial=-np.inf)) if finite.any() else 0.0
        step = (high - low) / 65534 or 1.0
        entries = np.where(finite, np.rint((np.where(finite, values, low) - low) / step), 65535)
        return {**self.add(entries.astype(np.uint16)), "low": low, "step": step}

    @property
    def text(self) -> str:
        """Packed arrays in base64."""
        return base64.b64encode(self._bytes).decode("ascii")
