"""Captions of pictures: number of faces, and the kind of surface whose integral is given."""

from isoembed.embedding.embedding import Embedding
from isoembed.surface.flat_faces import FlatFaces


def faces_counted(embedding: Embedding) -> str:
    """Number and kind of faces, as text."""
    faces = embedding.surface.flat_faces
    return f"{len(faces):,} {'faces' if isinstance(faces, FlatFaces) else 'triangles'}"


def has_own_lengths(embedding: Embedding) -> bool:
    """Whether the lengths are those of given vertices, so that there is no residual to show."""
    return not embedding.stages and embedding.residual <= 1e-14  # rounding


def of_integral(embedding: Embedding) -> str:
    """Text after "int H dA": " of the polyhedron" if it is the edge sum of a closed surface."""
    is_of_edges = embedding.triangulation.is_closed and has_own_lengths(embedding)
    return " of the polyhedron" if is_of_edges else ""
