"""Whose a checkpoint is: it says what was being computed, and nothing else goes on from it."""

from __future__ import annotations

import hashlib
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from isoembed.errors import InvalidParameter
from isoembed.metric.glued import GluedMetric
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Checkpoint, Fingerprint
from isoembed.version import __version__


def origin(metric: PolyhedralMetric | GluedMetric, method: object, tolerance: float) -> Fingerprint:
    """Describe a computation by all that decides what its checkpoints mean.

    Parameters
    ----------
    metric : PolyhedralMetric or GluedMetric
    method : configured method
        Who factors its matrices is left out: every backend goes on from what another one left.
    tolerance : float
    """
    return Fingerprint(_digest(metric), _described(method), float(tolerance), __version__)


def check_fingerprint(checkpoint: Checkpoint, here: Fingerprint) -> None:
    """Refuse a checkpoint of something else.

    Raises
    ------
    InvalidParameter
        The metric, the method, the tolerance or the version is another one: the first that is.
    """
    there = checkpoint.origin
    if there is None:
        raise InvalidParameter("the checkpoint does not say which computation it belongs to")
    if there.metric != here.metric:
        raise InvalidParameter(
            "the checkpoint belongs to another metric: not all triangles and lengths are those given here"
        )
    if there.method != here.method:
        raise InvalidParameter(
            f"the checkpoint was left by another method: {there.method}, not {here.method}"
        )
    if there.tolerance != here.tolerance:
        raise InvalidParameter(
            f"the checkpoint was left under another tolerance: {there.tolerance:g}, not {here.tolerance:g}"
        )
    if there.version != here.version:
        raise InvalidParameter(
            f"the checkpoint was left by another version: isoembed {there.version}, not {here.version}"
        )


def _digest(metric: PolyhedralMetric | GluedMetric) -> str:
    """SHA-256 of the triangles and of the lengths in the metric's own unit, on any machine the same."""
    if isinstance(metric, PolyhedralMetric):
        tables: tuple[Any, ...] = (metric.faces, metric.lengths / metric.unit)
    else:
        tables = (metric.faces, metric.twins, metric.face_lengths / metric.unit)
    digest = hashlib.sha256()
    for table in tables:
        kind = "<f8" if table.dtype.kind == "f" else "<i8"
        digest.update(f"{kind}{table.shape}".encode())
        digest.update(np.ascontiguousarray(table, dtype=kind).data)
    return digest.hexdigest()


def _described(method: object) -> str:
    if not is_dataclass(method):
        return repr(method)
    shown = (field.name for field in fields(method) if field.repr and field.name != "backend")
    return f"{type(method).__name__}({', '.join(f'{name}={getattr(method, name)!r}' for name in shown)})"
