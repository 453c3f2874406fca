"""`isoembed.certify`: certificate of an embedding."""

from isoembed.embedding.embedding import Embedding, checked_embedding
from isoembed.proof.certificate import Certificate


def certify(embedding: Embedding) -> Certificate:
    """Prove that an exact realization of the lengths is near the vertices of an embedding.

    The certificate says how near, how far away any other is at least, and whether the faces cross.  It takes
    two factorizations of J J^T, and a search for self-intersections, once for each embedding.

    Parameters
    ----------
    embedding : Embedding

    Returns
    -------
    Certificate
        Why nothing is proven, if nothing is.  Of a `ConvexPolyhedron` a `ConvexCertificate`: the proof that
        this is the polyhedron of its metric up to a stated distance.  It takes the lengths on the triangles
        of `ConvexPolyhedron.core` as exact numbers; `ConvexPolyhedron.path_residuals` say how far they are
        from the given ones.  Of a `SheetEmbedding` with a boundary in a plane or with given heights a
        `CapCertificate`; of others with boundary, the proof that one of a family of exact surfaces is near;
        of those with more equations than unknowns, none.

    Raises
    ------
    InvalidParameter
        It is not an embedding.
    """
    return checked_embedding(embedding)._certificate
