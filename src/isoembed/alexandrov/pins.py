"""Choice of three vertices with fixed radii, to exclude translations of the apex; their directions."""

import numpy as np
from scipy.linalg import qr

from isoembed.alexandrov.ambient import ambient_lengths
from isoembed.alexandrov.loops import built
from isoembed.alexandrov.polytope import Polytope
from isoembed.arrays import Floats, Indices
from isoembed.linalg import Dissection


def independent_directions(p: Polytope, directions: Floats) -> Indices:
    """Pivots of a QR decomposition of the directions from the apex to the vertices, shape (3,).

    Vertices chosen by the angles between them could be coplanar with the apex: 68 + 146 + 146 degrees are a
    full turn.
    """
    # Unit vectors are scaled so that the farthest vertex comes first, whatever the rounding and numbering.
    longer = directions * (1 + 1e-3 * p.radii / p.radii.max())[:, None]
    _, pivots = qr(longer.T, mode="r", pivoting=True, check_finite=False)
    return np.sort(pivots[:3]).astype(np.int64)


def rough_directions(p: Polytope, dissection: Dissection) -> Floats:
    """Rough unit vectors from the apex, shape (V, 3).

    They are built pyramid by pyramid if errors do not grow too much.  Otherwise they are the positions of
    the vertices in the nested dissection, based on graph distances, which are meaningless for bodies with
    vertices of high degree.
    """
    tables = p.tables
    i, j = tables.ends
    lengths, radii = ambient_lengths(p.space, tables.lengths, p.radii[i], p.radii[j]), p.space.sn(p.radii)
    directions = built(tables.corners, tables.twins, lengths, radii)
    if radii.size <= 1000 or _closes(radii[:, None] * directions, i, j, lengths):
        return directions
    places = np.empty_like(dissection.position)
    places[dissection.labels] = dissection.position - dissection.position.mean(axis=0)
    sizes = np.linalg.norm(places, axis=1)[:, None]
    return places / np.where(sizes > 0, sizes, 1.0)  # zero for a vertex at the mean, never a pin


def _closes(points: Floats, i: Indices, j: Indices, lengths: Floats) -> bool:
    """Whether most edges, including those not used in the construction, nearly have their lengths."""
    residuals = np.abs(np.linalg.norm(points[i] - points[j], axis=1) - lengths)
    return bool(np.quantile(residuals / lengths, 0.9) < 0.01)
