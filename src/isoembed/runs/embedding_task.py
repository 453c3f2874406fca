"""Task that embeds one file."""

from __future__ import annotations

import hashlib
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from isoembed.embedding.embedding import Embedding
from isoembed.embedding.report import report
from isoembed.errors import InvalidMetric, InvalidParameter, MeshNote, NotEmbedded
from isoembed.io.digest import file_digest, unchanged
from isoembed.io.files import FileError
from isoembed.io.format import flattened
from isoembed.io.metric import read_metric
from isoembed.io.surface import polygon_faces, surface_data
from isoembed.method import Method, solve
from isoembed.progress.fingerprint import described
from isoembed.runs.result import REFUSED, Result
from isoembed.space import Space


@dataclass(frozen=True)
class EmbeddingTask:
    """A metric in a file, to be embedded.

    The arrays of the result are the ``vertices``, the concatenated ``corners`` of all faces and their
    ``sizes``, the vertex data ``mean_curvature`` and ``residual``, and the ``curvature`` of a curved space;
    see `isoembed.io.write_surface`.

    Attributes
    ----------
    label : str
    path : Path
    method : Method
    tolerance : float
    merge : float or None
    space : Space, str or None
        See `isoembed.io.read_metric`.
    length_error : float or None
        See `isoembed.embed`, or, for methods without length errors, `Embedding.with_length_errors`.
    """

    label: str
    path: Path
    method: Method
    tolerance: float
    merge: float | None = None
    space: Space | str | None = None
    length_error: float | None = None

    @property
    def facts(self) -> dict[str, Any]:
        """See `isoembed.runs.Task`."""
        return {"name": str(self.path)}

    def digest(self) -> str:
        """See `isoembed.runs.Task`."""
        parts: tuple[object, ...] = (
            file_digest(self.path),
            self.path.suffix,
            described(self.method),
            self.tolerance,
            self.merge,
        )
        parts += () if self.space is None else (self.space,)
        parts += () if self.length_error is None else ("length error", self.length_error)
        return hashlib.sha256(repr(parts).encode()).hexdigest()

    def compute(self, before: Result | None) -> Result:
        """See `isoembed.runs.Task`; the previous result is not used."""
        with warnings.catch_warnings(record=True) as notes:
            warnings.simplefilter("always", MeshNote)
            try:
                with unchanged(self.path):
                    metric = read_metric(
                        self.path,
                        merge=self.merge,
                        space=self.space,
                        any_surface=True,
                        length_errors=self.length_error,
                    )
                found = solve(metric, self.method, tolerance=self.tolerance)
            except NotEmbedded as error:
                report_entries = {**report(error.embedding), **error.report, **self.facts}
                return Result(self.label, error.embedding.status, report_entries)
            except (FileError, InvalidMetric, InvalidParameter) as error:
                return Result.without_answer(self.label, REFUSED, str(error), **self.facts)
        messages = [str(note.message) for note in notes if issubclass(note.category, MeshNote)]
        return Result(
            self.label, found.status, {**report(found), **self.facts, "notes": messages}, _arrays(found)
        )


def _arrays(found: Embedding) -> dict[str, Any]:
    corners, sizes = flattened(polygon_faces(found))
    return {**surface_data(found), "corners": corners, "sizes": sizes}
