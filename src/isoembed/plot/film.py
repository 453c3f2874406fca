"""Frames of a film: the intermediate surfaces of a computation, or a series."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.progress.stages import Progress
from isoembed.reprs import short_repr
from isoembed.space.models import from_model
from isoembed.surface.alignment import aligned, aligned_image
from isoembed.surface.measures import outward

ANSWER = "answer"


@short_repr
@dataclass(frozen=True, eq=False)
class Frame:
    """A frame of a film.

    Attributes
    ----------
    stage : str
        Stage of the method that reached the surface, `ANSWER` for the last one; or the heading in a series.
    t : float or None
        Position on the path of metrics: 1 is the uniform or the convex metric, 0 the given one.
    residual : float or None
        Largest length error in mean edge lengths, relative to the metric at this t.
    vertices : ndarray, shape (V, 3)
        Vertices in the unit of the given lengths, each surface aligned with the next.
    """

    stage: str
    t: float | None
    residual: float | None
    vertices: Floats

    def surface(self, embedding: Embedding) -> Embedding:
        """Surface of the frame, for its shape only: it may be folded flat."""
        return embedding._shaped(self.vertices, self.stage)


def frames_of(surfaces: Sequence[Embedding], headings: Sequence[str]) -> tuple[Frame, ...]:
    """Frames of a series of surfaces with the same triangles, such as a swelling sheet.

    Parameters
    ----------
    surfaces : sequence of Embedding
        Surfaces in the order of the film.
    headings : sequence of str
        One heading per surface.

    Returns
    -------
    tuple of Frame
        Frames for `write_animation` with the last surface.  Each surface is aligned with the next, by a
        reflection if it has a boundary and is nearer then.

    Raises
    ------
    InvalidParameter
        The numbers of surfaces and headings differ, or the triangles of a surface are not those of the last.
    """
    if len(surfaces) != len(headings):
        raise InvalidParameter(f"there are {len(surfaces)} surfaces, but {len(headings)} headings")
    frames: list[Frame] = []
    for k in reversed(range(len(surfaces))):
        surface, vertices = surfaces[k], surfaces[k].vertices
        if not np.array_equal(surface.faces, surfaces[-1].faces):
            raise InvalidParameter(f"surface {k} does not have the triangles of the last surface")
        if frames:
            is_closed = surface.triangulation.is_closed
            vertices = (aligned if is_closed else aligned_image)(vertices, frames[-1].vertices)
        frames.append(Frame(headings[k], None, surface.residual, vertices))
    return tuple(reversed(frames))


class Film:
    """A progress listener that stores the intermediate surfaces of a computation.

    Examples
    --------
    ::

        film = Film()
        surface = isoembed.embed(metric, method="paper", progress=film)
        film.frames(surface)
    """

    def __init__(self) -> None:
        self._snapshots: list[Progress] = []

    def __call__(self, progress: Progress) -> None:
        """Store a snapshot."""
        if progress.vertices is not None:
            self._snapshots.append(progress)

    def frames(self, embedding: Embedding) -> tuple[Frame, ...]:
        """Frames of the intermediate surfaces of a computation, ending with its result.

        Surfaces hardly distinguishable from the next are omitted.  A method that changes the triangles, or
        takes a single step, yields only the result.

        Parameters
        ----------
        embedding : Embedding
            Result of the computation.

        Returns
        -------
        tuple of Frame
        """
        following = Frame(ANSWER, 0.0, embedding.residual, embedding.vertices)
        frames, unit, space = [following], embedding.metric.unit, embedding.metric.normalized.space
        for snapshot in reversed(self._snapshots):
            if snapshot.vertices is None or snapshot.vertices.shape != embedding.vertices.shape:
                continue
            after = following.vertices / unit
            try:
                points = from_model(space, snapshot.vertices, "ambient")
                if embedding.triangulation.is_closed:
                    vertices = aligned(outward(embedding.faces, points, space), after, space)
                else:
                    vertices = aligned_image(points, after)
            except InvalidParameter:  # not within the drawable half of the sphere
                continue
            # Surfaces that look the same are omitted.
            if (
                np.linalg.norm(vertices - after, axis=1).max()
                > 1e-3 * embedding.metric.normalized.mean_length
            ):
                following = Frame(snapshot.stage, snapshot.t, snapshot.residual, unit * vertices)
                frames.append(following)
        return tuple(reversed(frames))
