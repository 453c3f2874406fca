"""Shape operator and Hessians at the vertices, by local fits.

About each vertex the surface is the graph of a polynomial over the plane across the vertex's normal, fitted
by weighted least squares to the vertices within three edges; functions are fitted over the same plane.
Quartics leave errors of third order in the edge length, and of fourth where the neighbors lie evenly; cubics
of second.
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
        Oriented so that its normals point outward; inward, all signs change.
    vertices : ndarray, shape (V, 3)
    degree : int
        Of the polynomials; lower at vertices that have too few neighbors for it.
    space : Space
        In which the vertices are.  The tensors are in the frames of `isoembed.surface.tangent_frames`.

    Returns
    -------
    ndarray, shape (V, 3, 3)
        B, in the unit of length to the power -1: ``B n = 0``, and ``t . B t`` is the normal curvature along
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
    """Shape operators, and the covariant Hessians of functions that are given at the vertices.

    Parameters
    ----------
    triangulation, vertices, degree, space
        As in `shape_operators`.
    values : ndarray, shape (V, m)

    Returns
    -------
    operators : ndarray, shape (V, 3, 3)
    hessians : ndarray, shape (V, m, 3, 3)
        Symmetric tensors in R^3 that take nothing from the normal: ``t . h t`` is the second derivative along
        the geodesic that starts along the unit tangent vector t.
    """
    n = triangulation.n_vertices
    unit = edge_lengths(triangulation.edges, vertices).mean()
    origin = vertices.mean(axis=0) if space.is_euclidean else np.zeros(3)  # to move it would turn the frames
    surface = Surroundings.of(triangulation, (vertices - origin) / unit, space.scaled(1 / unit))
    operators, hessians = np.zeros((n, 3, 3)), np.zeros((n, values.shape[1], 3, 3))
    columns = np.ascontiguousarray(values, dtype=np.float64)
    # points: more than two rings hold, but where degrees are high; the chunks bound the memory
    for first, near in surface.neighborhoods(60, 10_000):
        fit_tensors(first, *near, surface, columns, degree, operators, hessians)
    return operators / unit, hessians / unit / unit


def normal_curvatures(
    triangulation: Triangulation, vertices: Floats, operators: Floats, space: Space = EUCLIDEAN
) -> Floats:
    """Normal curvatures of the surface along the edges, (E,): the mean of those at the two ends.

    From the `shape_operators`; with Hessians in their place, these are a function's second derivatives.
    """
    ends = triangulation.edges.T
    normals = vertex_normals(triangulation.faces, to_model(space, vertices, "conformal"))
    curvatures = np.zeros(triangulation.n_edges)
    for here, there in (ends, ends[::-1]):
        # An edge leaves the tangent plane by half the angle that it spans; along the surface it is shorter.
        along = directions(space, vertices[here], vertices[there])
        rise = np.einsum("ei,ei->e", along, normals[here])
        form = np.einsum("ei,eij,ej->e", along, operators[here], along)
        curvatures += form / np.maximum(1.0 - rise**2, 0.5) / 2  # steeper edges cut through a tip
    return curvatures
