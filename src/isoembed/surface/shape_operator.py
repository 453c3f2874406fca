"""Shape operator and Hessians at the vertices, by local fits.

Around each vertex the surface is the graph of a polynomial over the plane normal to the vertex normal, fitted
by weighted least squares to the vertices within three edges; functions are fitted over the same plane.
Quartic fits are third-order accurate in the edge length, and fourth-order where the neighbors are evenly
distributed; cubic fits are second-order accurate.
"""

import numpy as np

from isoembed.arrays import Floats
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import EUCLIDEAN, Space
from isoembed.space.models import to_model
from isoembed.surface.fit_loops import fit_tensors
from isoembed.surface.local_fit import Surroundings
from isoembed.surface.measures import edge_lengths, vertex_normals
from isoembed.surface.tangent_frames import directions


def shape_operators(
    triangulation: Triangulation, vertices: Floats, degree: int = 4, space: Space = EUCLIDEAN
) -> Floats:
    """Shape operators at the vertices, as symmetric tensors in R^3.

    Parameters
    ----------
    triangulation : Triangulation
        Oriented with outward normals; with inward normals, all signs change.
    vertices : ndarray, shape (V, 3)
    degree : int
        Degree of the polynomials, reduced at vertices with too few neighbors.
    space : Space
        Ambient space.  The tensors are in the frames of `isoembed.surface.tangent_frames`.

    Returns
    -------
    ndarray, shape (V, 3, 3)
        B, in the inverse unit of length: ``B n = 0``, and ``t . B t`` is the normal curvature along
        a unit tangent vector t, positive where the surface is convex.
    """
    nothing = np.empty((len(vertices), 0))
    return second_derivatives(triangulation, vertices, nothing, degree, space)[0]


def second_derivatives(
    triangulation: Triangulation,
    vertices: Floats,
    values: Floats,
    degree: int = 4,
    space: Space = EUCLIDEAN,
) -> tuple[Floats, Floats]:
    """Shape operators, and covariant Hessians of functions given at the vertices.

    Parameters
    ----------
    triangulation, vertices, degree, space
        As in `shape_operators`.
    values : ndarray, shape (V, m)

    Returns
    -------
    operators : ndarray, shape (V, 3, 3)
    hessians : ndarray, shape (V, m, 3, 3)
        Symmetric tensors in R^3 that vanish on the normal: ``t . h t`` is the second derivative along the
        geodesic with initial unit tangent vector t.
    """
    n = triangulation.n_vertices
    unit = edge_lengths(triangulation.edges, vertices).mean()
    origin = vertices.mean(axis=0) if space.is_euclidean else np.zeros(3)  # moving it would rotate the frames
    surface = Surroundings.of(triangulation, (vertices - origin) / unit, space.scaled(1 / unit))
    operators, hessians = np.zeros((n, 3, 3)), np.zeros((n, values.shape[1], 3, 3))
    columns = np.ascontiguousarray(values, dtype=np.float64)
    # at least 60 points: more than two rings, except at high degrees; the chunks bound the memory
    for first, near in surface.neighborhoods(60, 10_000):
        fit_tensors(first, *near, surface, columns, degree, operators, hessians)
    return operators / unit, hessians / unit / unit


def normal_curvatures(
    triangulation: Triangulation, vertices: Floats, operators: Floats, space: Space = EUCLIDEAN
) -> Floats:
    """Normal curvatures of the surface along the edges, (E,): means of those at the two ends.

    Computed from the `shape_operators`; with Hessians instead, second derivatives of a function.
    """
    ends = triangulation.edges.T
    normals = vertex_normals(triangulation.faces, to_model(space, vertices, "conformal"))
    curvatures = np.zeros(triangulation.n_edges)
    for here, there in (ends, ends[::-1]):
        # The angle between edge and tangent plane is half the angle spanned; the projection is shorter.
        along = directions(space, vertices[here], vertices[there])
        rise = np.einsum("ei,ei->e", along, normals[here])
        form = np.einsum("ei,eij,ej->e", along, operators[here], along)
        curvatures += form / np.maximum(1.0 - rise**2, 0.5) / 2  # steeper edges are at a spike
    return curvatures
