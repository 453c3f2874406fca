"""Fourth-order integrals over the smooth surface that a triangulation approximates.

Area, volume and the integral of H of a polyhedron are second-order approximations, in the edge length, of
those of the surface through its vertices.  The height of the surface over each triangle is, to leading order,

    f = 1/2 sum_{i<j} lambda_i lambda_j kappa_ij l_ij^2,

with the normal curvatures kappa_ij along its edges and barycentric coordinates lambda, and the polyhedron is
the surface displaced by -f along its normals.  Steiner's variations of the three integrals in f are the
corrections of the polyhedron's integrals; the next ones are of fourth order in the edge length.  Odd orders
cancel between neighboring triangles.  In space of curvature k the polyhedron has geodesic edges and totally
geodesic faces, and the variations are the same, except that ``det B - k`` replaces K in that of the integral
of H.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import EUCLIDEAN, Space
from isoembed.surface import curvature, measures
from isoembed.surface.bulges import Bulges
from isoembed.surface.chords import chord_lengths
from isoembed.surface.estimate import Estimate
from isoembed.surface.rigidity import LengthSystem
from isoembed.surface.shape_operator import normal_curvatures, second_derivatives
from isoembed.surface.smoothness import misfits
from isoembed.surface.surface import Surface
from isoembed.surface.tangent_frames import sides

Lengths = Literal["geodesic", "chord"]

QUARTIC, CUBIC = 4, 3  # degrees of the fits: the second only serves to estimate the error of the first


@dataclass(frozen=True, eq=False)
class SmoothIntegrals:
    r"""Integrals over a smooth surface approximated by a triangulation.

    Attributes
    ----------
    triangulation : Triangulation
        Oriented with outward normals.
    vertices : ndarray, shape (V, 3)
    lengths : "geodesic" or "chord"
        Kind of the edge lengths.  "chord": distances in space; the vertices are on the surface.  "geodesic":
        lengths of the surface's geodesics; the vertices are then near the surface, not on it.
    space : Space
        Ambient space; `of` takes it from a surface.

    Raises
    ------
    InvalidParameter
        `lengths` is invalid, or the vertices have another shape or are not finite.

    Notes
    -----
    Each integral is an `Estimate`.  Its error is

        \|sum d\| + 6 sqrt(sum d^2) + 1/10 sum \|c\| (kappa l)^2,

    where c is the correction of each triangle and d its difference between quartic and cubic fits of the
    curvatures.  The terms are the systematic and the random error of the fits, and the size of the next order
    of the expansion.  The error is not a bound.  On smooth surfaces resolved by the mesh it is 1 to 50 times
    the actual error, or more where errors happen to cancel; it is unreliable where curvatures change by their
    own size within an edge.  Where there are too few vertices for a fit, as in solids with a dozen, it is the
    integral times the fraction of the squared deficits at the vertices without fit.
    """

    triangulation: Triangulation
    vertices: Floats
    lengths: Lengths
    space: Space = EUCLIDEAN

    def __post_init__(self) -> None:
        if self.lengths not in ("geodesic", "chord"):
            raise InvalidParameter(f"the lengths must be 'geodesic' or 'chord', not {self.lengths!r}")
        object.__setattr__(
            self, "vertices", _checked(self.vertices, (self.triangulation.n_vertices, 3), "vertices")
        )

    @classmethod
    def of(cls, surface: Surface, lengths: Lengths) -> Self:
        """Integrals over the smooth surface approximated by a triangulated one, in its space.

        Parameters
        ----------
        surface : Surface
            Triangulated surface, such as `Embedding.surface`.
        lengths : "geodesic" or "chord"
        """
        return cls(surface.triangulation, surface.vertices, lengths, surface.space)

    @cached_property
    def integrated_mean_curvature(self) -> Estimate:
        """Integral of H = (k1 + k2) / 2 over the surface, in the unit of length.

        With the shape operator B in a triangle, ``T = (tr B) 1 - B``, ``K = det B``, and the derivatives g of
        f along the outward normal of an edge and f_t along the edge, it is

            1/2 sum_edges c theta + sum_faces [ K int f - 1/2 int T(grad f, grad f)
                + 1/4 tr B int |grad f|^2 + 1/4 sum_edges int (g f_t^2 + g^3 / 3) ds ],

        where c are the chords of the edges (their lengths if these are chords).  The surface displaced by
        phi = -f along its normals is the polyhedron, whose integral of H is larger by the following terms and
        is corrected by them:

        - ``int K phi``, the first variation of the integral of H (Steiner 1840; Reilly 1973).  In space of
          curvature k it is ``int (det B - k) phi``.
        - ``1/2 int T(grad phi, grad phi)``, half of the second one: K dA varies by ``-div(T grad phi) dA``.
        - ``1/4 int grad phi . grad |grad phi|^2``, the third order of ``H dA = -1/2 W div(grad phi / W)`` on
          a graph over a plane, W^2 = 1 + |grad phi|^2.  Integrated by parts over a triangle, where lap phi =
          tr B, it is ``-1/4 tr B int |grad phi|^2 + 1/4 sum_edges int (g phi_t^2 + g^3) ds``, g that of phi.
        - ``-1/6 int g^3 ds`` on both sides of each edge, where the slope g jumps: H integrated across it is
          half the angle, that is half the sum of ``arctan g = g - g^3 / 3``.
        - ``1/2 sum theta dl`` for geodesic lengths, too long for an inscribed polyhedron by dl: changes of
          the angles do not contribute, ``sum l dtheta = 0`` (Schlaefli 1858; Regge 1961; Rivin & Schlenker
          1999).  In space of curvature k the sum is ``-2 k dV``: the volume changes, too, by the effect of
          Newton's step on the lengths.

        On irregular triangulations, geodesic lengths change the dihedral angles by a tenth of their size from
        edge to edge, and a thousandth of the correction remains as a second-order error.  Correcting the
        lengths by `chord_lengths` and embedding them as chords, twice in succession, removes it.
        """
        t, points, unit, space = self.triangulation, self._points, self._unit, self._scaled_space
        theta = curvature.dihedral_angles(t, points, space)
        quartic, cubic = (
            bulges.integrated_mean_curvature
            - (theta * self._excess(bulges.operators) / 4)[t.face_edges].sum(axis=1)
            for bulges in (self._quartic, self._cubic)
        )
        sizes = self._quartic.integrated_mean_curvature_size
        raw = curvature.integrated_mean_curvature(t, points, space)
        raw -= space.curvature * self._shrinking
        return _scaled(self._estimate(raw, quartic, cubic, sizes), unit)

    @cached_property
    def area(self) -> Estimate:
        """Area of the surface, in the unit of length, squared.

        ``A + sum_faces [ tr B int f - 1/2 int |grad f|^2 ]`` for chords: the first variation and the flat
        part of the second.  The area of a geodesic triangle is ``1 + K sum l^2 / 24`` times that of the flat
        one with the same sides, and each of its angles is larger by a third of the integral of K (Gauss
        1827): for geodesic lengths, K follows from the angle deficits, without dihedral angles or fits.
        """
        return _scaled(
            self._estimate(float(self._flat_areas.sum()), *self._face_areas), self._unit, self._unit
        )

    @cached_property
    def volume(self) -> Estimate:
        """Enclosed volume, in the unit of length cubed: ``V + sum_faces int f``, for chord lengths.

        Raises
        ------
        InvalidParameter
            The lengths are geodesic: the vertices are not on the surface, and no local formula gives their
            distance from it.
        """
        if self.lengths != "chord":
            raise InvalidParameter("the volume requires vertices on the surface: lengths = 'chord'")
        heights = self._quartic.heights
        raw = measures.volume(self.triangulation.faces, self._points, self._scaled_space)
        estimate = self._estimate(raw, heights, self._cubic.heights, np.abs(heights))
        return _scaled(estimate, self._unit, self._unit, self._unit)

    def integral(self, values: ArrayLike) -> Estimate:
        """Integral of a function over the surface, from its values at the vertices.

        In each triangle, the mean of the values times the area of the surface over it, minus the error of
        linear interpolation, ``A / 24 sum_{i<j} f_ij l_ij^2``, where f_ij are the second derivatives of the
        function along the edges.

        The error estimate is at least 5/2 times the root sum of squares of `misfits`, each times a third of
        the area of the triangles at its vertex, as independent noise.

        Parameters
        ----------
        values : array_like, shape (V,)

        Returns
        -------
        Estimate
            In the unit of the values times that of length, squared.

        Raises
        ------
        InvalidParameter
            The values have another shape or are not finite.
        """
        t, points, space = self.triangulation, self._points, self._scaled_space
        array = _checked(values, (t.n_vertices,), "values")
        size = float(np.abs(array).max()) or 1.0
        data = array / size
        flat = self._flat_areas
        means = data[t.faces].mean(axis=1)
        squares = measures.edge_lengths(t.edges, points, space) ** 2
        corrections = []
        for degree in (QUARTIC, CUBIC):
            hessians = second_derivatives(t, points, data[:, None], degree, space)[1][:, 0]
            along = normal_curvatures(t, points, hessians, space) * squares
            corrections.append(flat / 24 * along[t.face_edges].sum(axis=1))
        quartic, cubic, sizes = self._face_areas
        estimate = self._estimate(
            float(flat @ means),
            means * quartic - corrections[0],
            means * cubic - corrections[1],
            np.abs(means) * sizes + np.abs(corrections[0]),
        )
        # 2.5 standard deviations of the noise
        noise = 2.5 * float(np.linalg.norm(self._cells * self.misfits(data)))
        estimate = Estimate(estimate.value, max(estimate.error, noise))
        return _scaled(estimate, size, self._unit, self._unit)

    def misfits(self, values: ArrayLike) -> Floats:
        """Differences of values (V,) from quartics fitted to their neighbors' values only, (V,).

        For a smooth function, the part not resolved by the triangulation; otherwise an estimate of noise, or
        of the error of a wrong value.
        """
        array = _checked(values, (self.triangulation.n_vertices,), "values")
        size = float(np.abs(array).max()) or 1.0
        columns = np.stack([array / size, *np.zeros((2, len(array)))], axis=1)
        return size * misfits(self.triangulation, self._points, columns, QUARTIC)[:, 0]

    def sum_at_vertices(self, values: Floats) -> float:
        """Sum of values (V,), each times a third of the area of the triangles at its vertex."""
        return float(self._cells @ values) * self._unit * self._unit

    @cached_property
    def _cells(self) -> Floats:
        """A third of the area of the triangles at each vertex, (V,)."""
        thirds = np.repeat(self._flat_areas / 3, 3)
        return np.asarray(np.bincount(self.triangulation.faces.ravel(), thirds), dtype=np.float64)

    @cached_property
    def _flat_areas(self) -> Floats:
        """Areas of the triangles (F,), in the unit squared."""
        return measures.triangle_areas(self.triangulation.faces, self._points, self._scaled_space)

    @cached_property
    def _unit(self) -> float:
        return float(measures.edge_lengths(self.triangulation.edges, self.vertices, self.space).mean())

    @cached_property
    def _scaled_space(self) -> Space:
        """Space in the unit."""
        return self.space if self.space.is_euclidean else self.space.scaled(1 / self._unit)

    @cached_property
    def _points(self) -> Floats:
        """Vertices in units of the mean edge length, which avoids under- and overflow."""
        return self.vertices / self._unit

    @cached_property
    def _quartic(self) -> Bulges:
        return Bulges.of(self.triangulation, self._points, QUARTIC, self._scaled_space)

    @cached_property
    def _unseen(self) -> float:
        """Uncertain fraction of an integral, as no quadric can be fitted around some vertices.

        An inscribed polyhedron is smaller than a round sphere by a quarter of the deficits at its vertices.
        """
        unfitted = ~self._quartic.operators.any(axis=(1, 2))
        deficits = _deficits(self.triangulation, self._points, self._scaled_space)
        return float(np.sum(deficits[unfitted] ** 2)) / (4 * np.pi)

    @cached_property
    def _cubic(self) -> Bulges:
        """Less accurate bulges, used only for the error estimate."""
        return Bulges.of(self.triangulation, self._points, CUBIC, self._scaled_space)

    @cached_property
    def _face_areas(self) -> tuple[Floats, Floats, Floats]:
        """Area of the surface minus that of the triangles, the same to lower accuracy, and its magnitude."""
        t, points = self.triangulation, self._points
        if self.lengths == "chord":
            return self._quartic.area, self._cubic.area, self._quartic.area_size
        flat, space = self._flat_areas, self._scaled_space
        squares = measures.edge_lengths(t.edges, points, space) ** 2
        moments = flat / 24 * squares[t.face_edges].sum(axis=1)
        around = np.bincount(t.faces.ravel(), np.repeat(flat, 3))
        K = 3 * _deficits(t, points, space) / around  # minus the curvature of space
        # Relative to the larger areas of the geodesic triangles, K is smaller.
        less = K * around / (around + K * np.bincount(t.faces.ravel(), np.repeat(moments, 3)))
        more = moments * K[t.faces].mean(axis=1)
        return more, moments * less[t.faces].mean(axis=1), np.abs(more)

    def _excess(self, operators: Floats) -> Floats:
        """Edge lengths minus the distances in space of the edges' ends on the surface, (E,)."""
        t, points, space = self.triangulation, self._points, self._scaled_space
        lengths = measures.edge_lengths(t.edges, points, space)
        if self.lengths == "chord":
            return np.zeros_like(lengths)
        return lengths - chord_lengths(t, points, lengths, operators, space)

    @cached_property
    def _shrinking(self) -> float:
        """Change of the volume from geodesic to chord lengths; 0, as not needed, in Euclidean space."""
        t, points, space = self.triangulation, self._points, self._scaled_space
        if space.is_euclidean or self.lengths == "chord":
            return 0.0
        lengths = measures.edge_lengths(t.edges, points, space)
        step = LengthSystem(t, space=space).step(points, lengths, self._excess(self._quartic.operators))
        return measures.volume(t.faces, points - step, space) - measures.volume(t.faces, points, space)

    def _estimate(self, raw: float, quartic: Floats, cubic: Floats, sizes: Floats) -> Estimate:
        difference = quartic - cubic
        # six faces around a vertex, whose fit errors are correlated
        error = abs(float(difference.sum())) + float(np.sqrt(36.0 * np.sum(difference**2)))
        # next order in (kappa l)^2
        error += 0.1 * float(sizes @ self._quartic.turns) + self._unseen * abs(raw)
        return Estimate(raw + float(quartic.sum()), error)


def _deficits(triangulation: Triangulation, points: Floats, space: Space) -> Floats:
    """Angle deficits: 2 pi minus the angles at each vertex, (V,)."""
    faces = triangulation.faces
    corners = points[faces.ravel()]
    ahead, behind = (
        sides(space, corners, points[faces[:, others]].reshape(-1, 3)) for others in ([1, 2, 0], [2, 0, 1])
    )
    across = np.linalg.norm(np.cross(ahead, behind), axis=1)
    angles = np.arctan2(across, np.einsum("vi,vi->v", ahead, behind))
    return np.asarray(2 * np.pi - np.bincount(faces.ravel(), angles))


def _checked(values: ArrayLike, shape: tuple[int, ...], name: str) -> Floats:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != shape:
        raise InvalidParameter(f"the {name} have shape {array.shape}, not {shape}")
    finite = np.isfinite(array).reshape(len(array), -1).all(axis=1)
    if not finite.all():
        v = int(np.argmin(finite))
        raise InvalidParameter(f"the {name} at vertex {v} are {array[v].tolist()}, which is not finite")
    return array


def _scaled(estimate: Estimate, *units: float) -> Estimate:
    for unit in units:  # one after the other: their product may overflow where the value does not
        estimate = estimate.scaled(unit)
    return estimate
