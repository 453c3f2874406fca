"""Captions of pictures: number of faces, and the surface that an integral belongs to."""

from isoembed.embedding.embedding import Embedding
from isoembed.surface.flat_faces import FlatFaces


def faces_counted(embedding: Embedding) -> str:
    """Number and kind of the faces."""
    faces = embedding.surface.flat_faces
    return f"{len(faces):,} {'faces' if isinstance(faces, FlatFaces) else 'triangles'}"


def has_own_lengths(embedding: Embedding) -> bool:
    """Whether nothing was computed and the lengths are those of the vertices: it has no residual to show."""
    return not embedding.stages and embedding.residual <= 1e-14  # rounding


def of_integral(embedding: Embedding) -> str:
    """Words after "int H dA": " of the polyhedron", where it is that of the edges of a closed surface."""
    is_of_edges = embedding.triangulation.is_closed and has_own_lengths(embedding)
    return " of the polyhedron" if is_of_edges else ""
