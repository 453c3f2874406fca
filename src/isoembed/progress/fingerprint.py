"""Fingerprint of a computation, which decides whether a checkpoint belongs to it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, fields, is_dataclass

import numpy as np
from numpy.typing import NDArray

from isoembed.errors import InvalidParameter
from isoembed.version import __version__


@dataclass(frozen=True)
class Fingerprint:
    """Identity of a computation, stored in its checkpoints.

    Attributes
    ----------
    metric : str
        Digest of the triangles and of the lengths divided by ``metric.unit``.
    method : str
        Method with all parameters that affect the result.
    tolerance : float
    version : str
        Version of isoembed.
    """

    metric: str
    method: str
    tolerance: float
    version: str

    @classmethod
    def of(cls, tables: Iterable[NDArray], method: object, tolerance: float) -> Fingerprint:
        """Fingerprint of the embedding of a metric by a method.

        Parameters
        ----------
        tables : iterable of ndarray
            Attribute ``tables`` of the metric.
        method : configured method
        tolerance : float
        """
        return cls(_digest(tables), described(method), float(tolerance), __version__)

    def check(self, found: Fingerprint | None) -> None:
        """Raise an error unless a fingerprint belongs to this computation.

        Raises
        ------
        InvalidParameter
            The fingerprint is missing, or differs in metric, method, tolerance or version.
        """
        if found is None:
            raise InvalidParameter("the checkpoint does not say which computation it belongs to")
        here, there = self, found
        differences = {
            "metric": "the checkpoint belongs to another metric: its triangles or lengths differ",
            "method": f"the checkpoint was written by another method: {there.method}, not {here.method}",
            "tolerance": f"the checkpoint was written with another tolerance: {there.tolerance:g}, not "
            f"{here.tolerance:g}",
            "version": f"the checkpoint was written by another version: isoembed {there.version}, not "
            f"{here.version}",
        }
        for name, sentence in differences.items():
            if getattr(there, name) != getattr(here, name):
                raise InvalidParameter(sentence)


def _digest(tables: Iterable[NDArray]) -> str:
    """Hexadecimal SHA-256 digest of integer and float arrays, independent of the platform."""
    digest = hashlib.sha256()
    for table in tables:
        kind = "<f8" if table.dtype.kind == "f" else "<i8"
        digest.update(f"{kind}{table.shape}".encode())
        digest.update(np.ascontiguousarray(table, dtype=kind).data)
    return digest.hexdigest()


def described(method: object) -> str:
    """Name of a method with all parameters that affect the result."""
    if not is_dataclass(method):
        return repr(method)
    shown = (field.name for field in fields(method) if field.repr)
    return f"{type(method).__name__}({', '.join(f'{name}={getattr(method, name)!r}' for name in shown)})"
