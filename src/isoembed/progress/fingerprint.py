"""Fingerprint of a computation: decides whether a checkpoint belongs to it."""

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
    """Identity of the computation that a checkpoint belongs to.

    Attributes
    ----------
    metric : str
        A digest of its triangles and of its lengths over ``metric.unit``.
    method : str
        The method with its parameters, all that decide what it computes.
    tolerance : float
    version : str
        Of isoembed.
    """

    metric: str
    method: str
    tolerance: float
    version: str

    @classmethod
    def of(cls, tables: Iterable[NDArray], method: object, tolerance: float) -> Fingerprint:
        """Fingerprint of embedding a metric by a method.

        Parameters
        ----------
        tables : iterable of ndarray
            The ``tables`` of the metric.
        method : configured method
        tolerance : float
        """
        return cls(_digest(tables), described(method), float(tolerance), __version__)

    def check(self, found: Fingerprint | None) -> None:
        """Refuse the fingerprint of another computation.

        Raises
        ------
        InvalidParameter
            There is none, or the metric, the method, the tolerance or the version is another one.
        """
        if found is None:
            raise InvalidParameter("the checkpoint does not say which computation it belongs to")
        here, there = self, found
        differences = {
            "metric": "the checkpoint belongs to another metric: "
            "not all triangles and lengths are those given here",
            "method": f"the checkpoint was left by another method: {there.method}, not {here.method}",
            "tolerance": "the checkpoint was left under another tolerance: "
            f"{there.tolerance:g}, not {here.tolerance:g}",
            "version": f"the checkpoint was left by another version: isoembed {there.version}, "
            f"not {here.version}",
        }
        for name, sentence in differences.items():
            if getattr(there, name) != getattr(here, name):
                raise InvalidParameter(sentence)


def _digest(tables: Iterable[NDArray]) -> str:
    """SHA-256 of arrays of integers and floats, hexadecimal; the same on any machine."""
    digest = hashlib.sha256()
    for table in tables:
        kind = "<f8" if table.dtype.kind == "f" else "<i8"
        digest.update(f"{kind}{table.shape}".encode())
        digest.update(np.ascontiguousarray(table, dtype=kind).data)
    return digest.hexdigest()


def described(method: object) -> str:
    """A method in words: its name and its parameters, all that decide what it computes."""
    if not is_dataclass(method):
        return repr(method)
    shown = (field.name for field in fields(method) if field.repr)
    return f"{type(method).__name__}({', '.join(f'{name}={getattr(method, name)!r}' for name in shown)})"
