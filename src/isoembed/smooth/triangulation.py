"""Nearly equilateral triangulations of the sphere, of discs and of bands in a smooth metric."""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.mesh.checks import real_array
from isoembed.mesh.triangulation import Triangulation, frozen
from isoembed.meshing.metric_relaxation import MetricMesh, angles_from_lengths
from isoembed.meshing.sphere import angles_of, directions_at, fibonacci_lattice
from isoembed.meshing.spreading import WHOLE, Cells, Zone, cell_centers, roundest_axis
from isoembed.meshing.surface_mesh import MIN_VERTICES, checked_count
from isoembed.meshing.zone import ZoneLayout
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.reprs import short_repr
from isoembed.smooth.gaussian_curvature import gaussian_curvature
from isoembed.smooth.geodesics import definite_tensor, geodesic_lengths, in_own_unit
from isoembed.smooth.grid_metric import GridMetric, sampled_on_grid
from isoembed.smooth.pole_checks import check_disc, check_rings
from isoembed.smooth.two_metric import TwoMetric, area_density, check_two_metric
from isoembed.space import EUCLIDEAN, Space

MOST_VERTICES = 10_000_000  # more fit into no memory


@short_repr
@dataclass(frozen=True, eq=False)
class SphereMesh:
    """A triangulation of the sphere of directions, or of a zone, and the geodesic lengths of its edges.

    Attributes
    ----------
    directions : ndarray, shape (V, 3)
        Unit vectors; the triangles look outward.  Vertices on a boundary come first.
    metric : PolyhedralMetric
        The triangles with the lengths of the geodesics between their corners.
    """

    directions: Floats
    metric: PolyhedralMetric

    @property
    def faces(self) -> Indices:
        """(F, 3): the triangles."""
        return self.metric.faces

    @property
    def polar(self) -> tuple[Floats, Floats]:
        """Theta and phi (V,) of the vertices: on a disc, radius and angle of its polar coordinates."""
        return angles_of(self.directions)

    @cached_property
    def angles(self) -> tuple[float, float]:
        """The least and the largest angle of the triangles, in radians."""
        angles = angles_from_lengths(self.metric.normalized.face_lengths.ravel())
        return float(angles.min()), float(angles.max())

    def measured(self, metric: TwoMetric) -> PolyhedralMetric:
        """Copy with the lengths of the edges in another metric.

        Raises
        ------
        InvalidMetric
            That metric is not positive definite on an edge, or breaks a triangle inequality.
        """
        i, j = self.metric.edges.T
        lengths = geodesic_lengths(metric, self.directions[i], self.directions[j])
        return self.metric.on(self.metric.triangulation, lengths, self.metric.space)


def triangulate_metric(
    metric: TwoMetric,
    vertices: int | None = None,
    *,
    size: float | None = None,
    grading: float = 0.0,
    zone: tuple[float, float] = WHOLE,
    space: Space = EUCLIDEAN,
) -> SphereMesh:
    """Triangulate the sphere, a disc or a band with triangles that are nearly equilateral in a smooth metric.

    Parameters
    ----------
    metric : TwoMetric
    vertices : int, optional
        Exact number of vertices, at least 12 and at most ten million.
    size : float, optional
        Instead of their number: the mean edge length, in the metric's unit, met within two or three percent.
    grading : float
        How many vertices follow the curvature, against one that follows the area, if K > 0 everywhere: their
        density is 1 + grading abs(K) A / 4 pi, and each sharp tip gets its share.  0.1 suits metrics with
        tips; 0 makes all triangles alike.
    zone : tuple of float
        Range of theta, by default the whole sphere.  ``(0, stop)`` is a disc whose boundary is the circle
        theta = stop, with theta for the radius and phi for the angle of polar coordinates; a band has two
        boundaries.  The vertices of a boundary are on it.  The metric is evaluated a tenth of an edge beyond
        it, too, or farther where a boundary is concave.
    space : Space
        Its curvature is that of the triangles.

    Returns
    -------
    SphereMesh
        The same input gives the same mesh.

    Raises
    ------
    InvalidParameter
        Neither or both of `vertices` and `size` are given, there would be fewer than 12 vertices or more than
        ten million, or so few that triangles have no area, `size` is not positive, `grading` is negative, or
        `zone` is invalid.
    InvalidMetric
        The metric is not positive definite somewhere; the message names theta, phi and the value.  Or it is
        not smooth at the poles; the message states the defect.

    Notes
    -----
    A Fibonacci lattice with the wanted density, connected by the convex hull of its directions and Delaunay
    flips, is relaxed by its edge lengths: to optimal Delaunay triangulations, then to centroidal Voronoi
    tessellations, first everywhere, then with geodesic lengths about angles outside of 35-100 degrees, until
    there are none.  The best of all these meshes is returned; where the vertices are too few for the metric's
    sharpest features it misses the window.  Vertices on a boundary are spread evenly along it, and
    stay; cones over the boundaries, with legs so long that no flip touches them, make the mesh a sphere.
    """
    if (vertices is None) == (size is None):
        given = "neither" if size is None else "both"
        raise InvalidParameter(f"either vertices or size must be given, not {given}")
    if not (np.isfinite(grading) and grading >= 0.0):
        raise InvalidParameter(f"grading must be a number of at least 0, not {grading!r}")
    if size is not None and not (np.isfinite(size) and size > 0.0):
        raise InvalidParameter(f"size must be a positive number, not {size!r}")
    n = (
        None
        if vertices is None
        else checked_count("the number of vertices", vertices, MIN_VERTICES, MOST_VERTICES)
    )
    check_two_metric(metric)
    if zone != WHOLE:
        return _triangulated_zone(metric, n, size, grading, _checked_zone(zone), space)
    if not isinstance(metric, GridMetric):  # grids have been looked at
        _check_sphere(metric)
    unit, own = in_own_unit(metric)
    area, density = _densities(own, grading, n)
    if size is not None:
        n = _vertices_of_size(area, density, size, unit)
    assert n is not None
    u = Cells(area.values * density.values, area.axis).spread(fibonacci_lattice(n))
    start = MetricMesh.hull(u, partial(definite_tensor, own), partial(geodesic_lengths, own))
    return _measured(start.relaxed(density if grading else None), unit, space)


def _triangulated_zone(
    metric: TwoMetric, n: int | None, size: float | None, grading: float, zone: Zone, space: Space
) -> SphereMesh:
    """The mesh of a disc or a band."""
    start, stop = zone
    if not isinstance(metric, GridMetric):
        check_disc(metric, zone)
    middle = 0.5 * (start + stop)
    unit, own = in_own_unit(metric, directions_at(np.array([np.cos(middle)]), 0.0))
    tensor = partial(definite_tensor, own)

    def area(u: Floats) -> Floats:
        return area_density(tensor(u))

    total = Cells.of(area, (64, 64), zone=zone).integral()

    def density(u: Floats) -> Floats:
        if not grading:
            return np.ones(len(u))
        return 1.0 + grading * total / (4.0 * np.pi) * np.abs(gaussian_curvature(own, u))

    layout = ZoneLayout(zone, tensor, area, density)
    if size is not None:
        n = _checked_number(layout.vertices(size / unit / 1.02), size)
    assert n is not None
    mesh = layout.mesh(n, partial(geodesic_lengths, own))
    return _measured(mesh.relaxed(Cells.of(density, (256, 64), zone=zone) if grading else None), unit, space)


def _check_sphere(metric: TwoMetric) -> None:
    """Check a metric at both poles; of one that is smooth at theta = 0 only, name discs."""
    try:
        check_rings(metric)
    except InvalidMetric as error:
        try:
            check_disc(metric, (0.0, 1.0))
        except InvalidMetric:
            raise error from None
        raise InvalidMetric(
            f"{error}; a metric on a disc about theta = 0 takes triangulate_metric(..., zone=(0, stop))"
        ) from None


def _checked_zone(zone: tuple[float, float]) -> Zone:
    """Two angles in order.

    Raises
    ------
    InvalidParameter
        They are not.
    """
    angles = real_array(zone, "zone", "angle")
    start, stop = map(float, angles) if angles.shape == (2,) else (np.nan, np.nan)
    if not 0.0 <= start < stop <= np.pi:
        raise InvalidParameter(f"the zone must be two angles with 0 <= start < stop <= pi, not {zone}")
    return start, stop


def _measured(mesh: MetricMesh, unit: float, space: Space) -> SphereMesh:
    """A relaxed mesh without its cones, in the user's unit."""
    inside = ~mesh.is_cone
    u = mesh.u[: mesh.n_vertices]
    triangulation = Triangulation(mesh.tables.faces[inside])
    lengths = unit * mesh.tables.face_lengths[inside].ravel()[triangulation.edge_sides.max(axis=1)]
    try:
        return SphereMesh(frozen(u), PolyhedralMetric.on(triangulation, lengths, space))
    except InvalidMetric as error:
        raise InvalidParameter(f"{len(u)} vertices are too few for this metric: {error}") from None


def graded_mesh(metric: TwoMetric, vertices: int, space: Space = EUCLIDEAN) -> SphereMesh:
    """The mesh that embeddings begin with: of the metric on a grid, with more vertices where it is curved."""
    return triangulate_metric(sampled_on_grid(metric), vertices, grading=0.1, space=space)


def _densities(metric: TwoMetric, grading: float, n: int | None) -> tuple[Cells, Cells]:
    """The area over that of the unit sphere, and the wanted vertices per area up to a factor, on cells."""
    rows = int(np.clip(4.0 * np.sqrt(n or 10_000), 256, 1024))
    axis = roundest_axis(_great_circles(metric))
    area = Cells.of(lambda u: area_density(definite_tensor(metric, u)), (rows, rows // 2), axis)
    if not grading:
        return area, Cells(np.ones_like(area.values), axis)
    # The curvature costs much more to sample.
    K = Cells.of(lambda u: gaussian_curvature(metric, u), (256, 64), axis)
    density = 1.0 + grading * area.integral() / (4.0 * np.pi) * np.abs(
        K.at(cell_centers(area.values.shape, axis))
    )
    return area, Cells(density.reshape(area.values.shape), axis)


def _great_circles(metric: TwoMetric) -> Floats:
    """The lengths (3,) of the great circles about the Cartesian axes, up to a factor.

    On a surface of revolution those that meet at the axis are of one length.
    """
    a = 2.0 * np.pi / 64.0 * np.arange(64)
    length = np.empty(3)
    for k in range(3):
        e, f = np.roll(np.eye(3), -k - 1, axis=0)[:2]
        u, v = (
            np.outer(np.cos(a), e) + np.outer(np.sin(a), f),
            np.outer(np.cos(a), f) - np.outer(np.sin(a), e),
        )
        length[k] = np.sqrt(np.einsum("ni,nij,nj->n", v, definite_tensor(metric, u), v)).mean()
    return length


def _vertices_of_size(area: Cells, density: Cells, size: float, unit: float) -> int:
    """Number of vertices with the mean distance `size`, the cells being those of the metric in `unit`.

    N vertices of the density w have N w / int w dA in a unit of area, each with the area 3^(1/2) l^2 / 2 if
    the triangles were equilateral.
    """
    root = Cells(area.values * np.sqrt(density.values), area.axis).integral()
    whole = Cells(area.values * density.values, area.axis).integral()
    with np.errstate(over="ignore"):
        # Edges are 2 % longer than those of equilateral triangles.
        n = 2.0 + 2.0 / np.sqrt(3.0) * (1.02 * root * np.divide(unit, size)) ** 2 / whole
    return _checked_number(float(n), size)


def _checked_number(n: float, size: float) -> int:
    """The number of vertices that edges of a size make, refused where it is not within bounds."""
    minimum, maximum = MIN_VERTICES, MOST_VERTICES
    if not minimum - 0.5 <= n < maximum + 0.5:
        bound = f"least {minimum}" if n < minimum else f"most {maximum}"
        raise InvalidParameter(
            f"edges of the length {size:.6g} make {n:.3g} vertices, but there must be at {bound}"
        )
    return round(n)
