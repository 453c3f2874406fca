"""Embedding on a sphere (paper, section 2.2): the embedding tree."""

from dataclasses import dataclass

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidParameter
from isoembed.mesh.triangulation import frozen
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import StageRecorder


@dataclass(frozen=True)
class EmbeddingTree:
    """The vertices on the sphere, and the order and edges of their construction.

    Attributes
    ----------
    vertices : ndarray, shape (V, 3)
        Points on the sphere centered on the origin.
    layers : ndarray of int, shape (V,)
        Layer in which each vertex was placed; 0 for the three of the root.
    pivots : ndarray of int, shape (V, 2)
        Ends of the edge opposite to each vertex in the triangle that placed it.  -1 for the ends of the
        first edge.
    """

    vertices: Floats
    layers: Indices
    pivots: Indices


def embedding_tree(
    metric: PolyhedralMetric, radius: float, root: int, recorder: StageRecorder
) -> EmbeddingTree:
    """Place a metric of constant curvature on the sphere, triangle by triangle.

    The first edge is placed by Eqs. (xb)-(zb).  Every other vertex follows from a placed edge by the two
    lengths and the radius, Eqs. (sys1)-(sys3), on the side on which the two triangles are unfolded.  The
    tree grows breadth first, layer by layer.  Edges outside of the tree miss their lengths by the deviation
    of the metric from that of a sphere.

    Parameters
    ----------
    metric : PolyhedralMetric
        rho_{t_f}.
    radius : float
        r, Eq. (avg).
    root : int
        The first face.
    recorder : StageRecorder
        Recorder of the layers.

    Returns
    -------
    EmbeddingTree

    Raises
    ------
    InvalidParameter
        There is no face `root`.
    """
    triangulation = metric.triangulation
    faces, face_edges = triangulation.faces, triangulation.face_edges
    if not 0 <= root < len(faces):
        raise InvalidParameter(f"root is {root}, but the faces are numbered from 0 to {len(faces) - 1}")
    r, lengths = radius, metric.lengths
    x = np.zeros((triangulation.n_vertices, 3))
    layers = np.full(triangulation.n_vertices, -1)  # until a vertex is placed
    pivots = np.full((triangulation.n_vertices, 2), -1)
    visited = np.zeros(len(faces), dtype=bool)

    a, b, c = faces[root]
    x[a], x[b] = _first_edge(r, lengths[face_edges[root, 0]])
    x[c] = _opposite(
        r, x[[a]], x[[b]], lengths[face_edges[root, [2]]], lengths[face_edges[root, [1]]], np.array([1.0])
    )[0]
    pivots[c] = a, b
    layers[faces[root]] = 0
    visited[root] = True

    front, layer = np.array([root]), 0
    while len(front):
        layer += 1
        recorder.iterations += 1
        # Half-edges of neighbors across the front; the first one to reach a vertex places it.
        inside = (3 * front[:, None] + np.arange(3)).ravel()
        outside = triangulation.twins[inside]
        fresh = ~visited[outside // 3]
        inside, outside = inside[fresh], outside[fresh]
        _, first = np.unique(outside // 3, return_index=True)
        inside, outside = inside[first], outside[first]
        front = outside // 3
        visited[front] = True
        new = faces[front, (outside % 3 + 2) % 3]
        _, first = np.unique(np.where(layers[new] >= 0, -1, new), return_index=True)
        first = first[layers[new[first]] < 0]
        f, c = np.divmod(outside[first], 3)
        a, b, v = faces[f, c], faces[f, (c + 1) % 3], new[first]
        g, d = np.divmod(inside[first], 3)
        behind = x[faces[g, (d + 2) % 3]]
        side = -np.sign(
            np.einsum("ij,ij->i", np.cross(x[a], x[b]), behind)
        )  # unfolded, opposite to the known triangle
        x[v] = _opposite(
            r, x[a], x[b], lengths[face_edges[f, (c + 2) % 3]], lengths[face_edges[f, (c + 1) % 3]], side
        )
        layers[v], pivots[v] = layer, np.column_stack([a, b])
    return EmbeddingTree(frozen(x), frozen(layers), frozen(pivots))


def _first_edge(r: float, l: float) -> tuple[Floats, Floats]:
    """Both ends of the first edge, Eqs. (xb)-(zb), valid up to l = sqrt(2) r."""
    root = np.sqrt(max(l**2 * r**2 * (2 * r**2 - l**2), 0.0))
    a = np.array([r / 2, r / 2, r / np.sqrt(2)])
    b = np.array(
        [
            (r * (r**2 - l**2) + root) / (2 * r**2),  # (xb)
            (r * (r**2 - l**2) - root) / (2 * r**2),  # (yb)
            r / np.sqrt(2),  # (zb)
        ]
    )
    return a, b * r / np.linalg.norm(b)


def _opposite(r: float, a: Floats, b: Floats, l_ac: Floats, l_bc: Floats, side: Floats) -> Floats:
    """Solve (sys1)-(sys3): ``x . a = r^2 - l_ac^2 / 2``, ``x . b = r^2 - l_bc^2 / 2``, ``|x| = r``."""
    p, q = r**2 - l_ac**2 / 2, r**2 - l_bc**2 / 2
    normal = np.cross(a, b)
    square = np.einsum("ij,ij->i", normal, normal)  # r^4 - (a . b)^2
    dot = np.einsum("ij,ij->i", a, b)
    alpha, beta = (p * r**2 - q * dot) / square, (q * r**2 - p * dot) / square
    # On coarse triangulations, lengths without a point on the sphere get the nearest one.
    gamma = side * np.sqrt(np.maximum(r**2 - alpha * p - beta * q, 0.0) / square)
    x = alpha[:, None] * a + beta[:, None] * b + gamma[:, None] * normal
    return x * (r / np.linalg.norm(x, axis=1))[:, None]
