"""`isoembed.certify`: certificate of an embedding."""

from isoembed.embedding.embedding import Embedding, checked_embedding
from isoembed.proof.certificate import Certificate


def certify(embedding: Embedding) -> Certificate:
    """Prove that an exact realization of the lengths is near the vertices of an embedding.

    The certificate states bounds on its distance and on that of any other realization, and whether the faces
    cross.  It takes two factorizations of J J^T and a search for self-intersections, once per embedding.

    Parameters
    ----------
    embedding : Embedding

    Returns
    -------
    Certificate
        Certificate, with the reason if nothing is proven.  For a `ConvexPolyhedron`, a `ConvexCertificate`:
        proof that this is the polyhedron of its metric up to a stated distance.  The lengths on the triangles
        of `ConvexPolyhedron.core` are taken as exact; `ConvexPolyhedron.path_residuals` are their deviations
        from the given ones.  For a `SheetEmbedding` with a boundary in a plane or with given heights, a
        `CapCertificate`; for other surfaces with boundary, proof that one of a family of exact surfaces is
        near; for overdetermined problems, none.

    Raises
    ------
    InvalidParameter
        The argument is not an embedding.
    """
    return checked_embedding(embedding)._certificate
