"""Surfaces of a film: those on the way to an answer, or a series."""

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
    """A surface on the way.

    Attributes
    ----------
    stage : str
        The stage of the method that reached it, `ANSWER` for the last one; or the heading of a series.
    t : float or None
        Position on the path of metrics: 1 is the uniform or the convex metric, 0 the given one.
    residual : float or None
        Largest length error in mean edge lengths, against the metric at this t.
    vertices : ndarray, shape (V, 3)
        In the unit of the given lengths, each surface turned onto the next.
    """

    stage: str
    t: float | None
    residual: float | None
    vertices: Floats

    def surface(self, embedding: Embedding) -> Embedding:
        """Surface of the frame, of which only the shape is of interest: it may be folded flat."""
        return embedding._shaped(self.vertices, self.stage)


def frames_of(surfaces: Sequence[Embedding], headings: Sequence[str]) -> tuple[Frame, ...]:
    """Frames of a series of surfaces on the same triangles, such as a sheet that swells.

    Parameters
    ----------
    surfaces : sequence of Embedding
        In the order of the film.
    headings : sequence of str
        One each.

    Returns
    -------
    tuple of Frame
        Each surface is turned onto the next, and mirrored if it has a boundary and is nearer then; for
        `write_animation` with the last surface.

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
            raise InvalidParameter(f"the triangles of surface {k} are not those of the last one")
        if frames:
            is_closed = surface.triangulation.is_closed
            vertices = (aligned if is_closed else aligned_image)(vertices, frames[-1].vertices)
        frames.append(Frame(headings[k], None, surface.residual, vertices))
    return tuple(reversed(frames))


class Film:
    """A listener that keeps the surfaces that a computation reaches.

    Examples
    --------
    ::

        film = Film()
        surface = isoembed.embed(metric, method="paper", progress=film)
        film.frames(surface)
    """

    def __init__(self) -> None:
        self._taken: list[Progress] = []

    def __call__(self, progress: Progress) -> None:
        """Take a snapshot in."""
        if progress.vertices is not None:
            self._taken.append(progress)

    def frames(self, embedding: Embedding) -> tuple[Frame, ...]:
        """The surfaces met on the way to this answer, with it as the last.

        Surfaces that can hardly be told from the next are left out.  A method that changes the triangles, or
        goes to its answer at once, leaves the answer alone.

        Parameters
        ----------
        embedding : Embedding
            What the computation returned.

        Returns
        -------
        tuple of Frame
        """
        following = Frame(ANSWER, 0.0, embedding.residual, embedding.vertices)
        frames, unit, space = [following], embedding.metric.unit, embedding.metric.normalized.space
        for taken in reversed(self._taken):
            if taken.vertices is None or taken.vertices.shape != embedding.vertices.shape:
                continue
            after = following.vertices / unit
            try:
                given = from_model(space, taken.vertices, "ambient")
                if embedding.triangulation.is_closed:
                    vertices = aligned(outward(embedding.faces, given, space), after, space)
                else:
                    vertices = aligned_image(given, after)
            except InvalidParameter:  # on the sphere not within the half that can be shown
                continue
            # two surfaces that look the same
            if (
                np.linalg.norm(vertices - after, axis=1).max()
                > 1e-3 * embedding.metric.normalized.mean_length
            ):
                following = Frame(taken.stage, taken.t, taken.residual, unit * vertices)
                frames.append(following)
        return tuple(reversed(frames))
