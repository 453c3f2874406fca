"""Slices on spectral elements.

Spectral and discontinuous Galerkin codes have such data.  A point is searched in the elements whose bounding
boxes contain it: Newton's method inverts the map of the element, the polynomial through its nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial import legendre
from scipy.spatial import cKDTree

from isoembed.arrays import Floats, Indices, Mask
from isoembed.errors import InvalidParameter
from isoembed.relativity.spacetimes.cartesian_grid import ENTRY
from isoembed.relativity.spacetimes.checks import refuse_points
from isoembed.relativity.spacetimes.three_geometry import (
    ASSUMED,
    DerivedGeometry,
    InterpolatedGeometry,
    ThreeGeometry,
)
from isoembed.reprs import short_repr

BULGE = 0.25  # largest extent of an element beyond the bounding box of its nodes, relative to the box


@short_repr
@dataclass(frozen=True, eq=False)
class Element:
    """Spectral element of a slice.

    Attributes
    ----------
    nodes : tuple of three ndarray, of shapes (nx,), (ny,) and (nz,)
        Nodes between -1 and 1 along each axis of the reference cube.
    points : ndarray, shape (nx, ny, nz, 3)
        Positions of the nodes in the slice.
    gamma : ndarray, shape (nx, ny, nz, 6)
        ``gamma_ij`` at the nodes: xx, xy, xz, yy, yz, zz, in slice coordinates.
    K : ndarray, shape as gamma, optional
        ``K_ij`` at the nodes.
    """

    nodes: tuple[Floats, Floats, Floats]
    points: Floats
    gamma: Floats
    K: Floats | None = None

    def __post_init__(self) -> None:
        shape = tuple(len(along) for along in self.nodes)
        for name, last in (("points", 3), ("gamma", 6), ("K", 6)):
            array = getattr(self, name)
            if array is not None and array.shape != (*shape, last):
                raise InvalidParameter(
                    f"an element has {name} of the shape {array.shape}, not {(*shape, last)}"
                )


@short_repr
@dataclass(frozen=True, eq=False)
class ElementGrid(InterpolatedGeometry):
    """Slice given by its values at the nodes of elements.

    Attributes
    ----------
    elements : sequence of Element
        Elements, all with K_ij or none, in which case the slice is time-symmetric.

    Raises
    ------
    InvalidParameter
        There are no elements, or only some of them have K_ij; or a point at which a field is evaluated is in
        none of them.
    """

    elements: Sequence[Element]

    def __post_init__(self) -> None:
        object.__setattr__(self, "elements", tuple(self.elements))
        if len({element.K is None for element in self.elements}) != 1:
            raise InvalidParameter(
                "a slice must have at least one element, and all or none of the elements must have K_ij"
            )

    @property
    def time_symmetric(self) -> bool:
        """See `ThreeGeometry`."""
        return self.elements[0].K is None

    @property
    def notes(self) -> tuple[str, ...]:
        """See `ThreeGeometry`."""
        return (ASSUMED,) if self.time_symmetric else ()

    def _field(self, name: str, x: Floats) -> Floats:
        return np.asarray(getattr(_Polynomials(self, 0), name)(x))

    def error(self, quantity: Callable[[ThreeGeometry], Floats]) -> Floats:
        """See `ThreeGeometry`: the change without the two highest degrees along each axis.

        The elements converge exponentially if the slice is smooth, so that the actual truncation error is
        smaller.  The error of the simulation is not included.
        """
        return np.asarray(quantity(_Polynomials(self, 2)) - quantity(self))  # without the two highest degrees

    def least_diameter(self, x: Floats) -> float:
        """See `ThreeGeometry`: 12 mean distances between neighboring nodes."""
        there = [self.elements[k].points for k in np.unique(self.located(x)[0])]
        # With 8 nodes across a horizon none is found, with 9 some, with 12 all, to 4 digits or more.
        return 12 * max(
            float(np.linalg.norm(np.diff(points, axis=axis), axis=-1).mean(axis=axis).max())
            for points in there
            for axis in range(3)
            if points.shape[axis] > 1
        )

    def located(self, x: Floats) -> tuple[Indices, Floats]:
        """Elements that contain points, and the reference coordinates of the points.

        Parameters
        ----------
        x : ndarray, shape (n, 3)

        Returns
        -------
        element : ndarray of int, shape (n,)
        place : ndarray, shape (n, 3)

        Raises
        ------
        InvalidParameter
            A point is in no element.
        """
        key = x.tobytes()
        if key not in self._found:
            if len(self._found) == 4:  # size of the cache
                del self._found[next(iter(self._found))]
            self._found[key] = self._search(x)
        return self._found[key]

    @cached_property
    def _found(self) -> dict[bytes, tuple[Indices, Floats]]:
        """Cache of located points, as metric, gradient and K_ij are evaluated at the same points."""
        return {}

    @cached_property
    def _tree(self) -> cKDTree:
        """Tree of the nodes of all elements."""
        return cKDTree(np.concatenate([element.points.reshape(-1, 3) for element in self.elements]))

    @cached_property
    def _trees(self) -> list[cKDTree]:
        """Trees of the nodes of each element."""
        return [cKDTree(element.points.reshape(-1, 3)) for element in self.elements]

    def _search(self, x: Floats) -> tuple[Indices, Floats]:
        """Search in the element of the nearest node first, then in all whose boxes contain a point."""
        first = np.cumsum([0, *(element.points[..., 0].size for element in self.elements)])
        bad: Mask = np.any(~np.isfinite(x), axis=1)
        nearest = self._tree.query(np.where(bad[:, None], 0.0, x))[1]
        which = np.searchsorted(first, nearest, side="right") - 1
        which[bad] = -1
        place = np.full((len(x), 3), np.inf)
        for k in np.unique(which[~bad]):
            here = np.flatnonzero(which == k)
            place[here] = _inverted(self.elements[k], x[here], nearest[here] - first[k])
        left = np.flatnonzero(np.abs(place).max(axis=1, initial=0.0) > 1.0)
        for k, element in enumerate(self.elements):
            flat = element.points.reshape(-1, 3)
            low, high = flat.min(axis=0), flat.max(axis=0)
            room = BULGE * (high - low)
            in_box = np.all((x[left] >= low - room) & (x[left] <= high + room), axis=1)
            near = left[in_box & (which[left] != k)]
            if len(near):
                found = _inverted(element, x[near], self._trees[k].query(x[near])[1])
                better = np.abs(found).max(axis=1) < np.abs(place[near]).max(axis=1)
                which[near[better]], place[near[better]] = k, found[better]
        # Elements with non-polynomial maps have gaps between them.
        outside = ~(np.abs(place).max(axis=1, initial=0.0) <= 1.0 + 1e-3)
        refuse_points(outside, x, f"lies in none of the {len(self.elements)} elements of the slice")
        return which, place


@dataclass(frozen=True, eq=False)
class _Polynomials(DerivedGeometry):
    """Slice on elements, without the highest degrees of its polynomials."""

    grid: ElementGrid
    dropped: int

    def metric(self, x: Floats) -> Floats:
        out = np.empty((len(x), 6))
        for element, here, place in self._parts(x):
            out[here] = _interpolated(_weights(element, place, self.dropped), element.gamma)[0]
        return out[:, ENTRY]

    def gradient(self, x: Floats) -> Floats:
        out = np.empty((len(x), 3, 6))
        for element, here, place in self._parts(x):
            _, slopes = _interpolated(_weights(element, place, self.dropped), element.gamma)
            _, map_slopes = _interpolated(_weights(element, place, 0), element.points)
            out[here] = np.linalg.solve(map_slopes, slopes)
        return out[:, :, ENTRY]

    def extrinsic_curvature(self, x: Floats) -> Floats:
        out = np.zeros((len(x), 6))
        for element, here, place in self._parts(x):
            if element.K is not None:
                out[here] = _interpolated(_weights(element, place, self.dropped), element.K)[0]
        return out[:, ENTRY]

    def _parts(self, x: Floats) -> Iterator[tuple[Element, Indices, Floats]]:
        """Elements with the indices of the points inside and their reference coordinates."""
        which, place = self.grid.located(x)
        for k in np.unique(which):
            here = np.flatnonzero(which == k)
            yield self.grid.elements[k], here, place[here]


def _inverted(element: Element, x: Floats, nearest: Indices) -> Floats:
    """Reference coordinates (n, 3) of points (n, 3) in an element, from the nearest of its nodes (n,).

    They are infinite for points outside the element and its vicinity.
    """
    index = np.unravel_index(nearest, element.points.shape[:3])
    place = np.stack([nodes[i] for nodes, i in zip(element.nodes, index, strict=True)], axis=1)
    out, left = np.full(x.shape, np.inf), np.arange(len(x))
    for _ in range(30):  # Newton's method
        there, slopes = _interpolated(_weights(element, place, 0), element.points)
        step = _solved(slopes.transpose(0, 2, 1), x[left] - there)
        place = place + np.clip(step, -1.0, 1.0)
        found = np.abs(step).max(axis=1) < 1e-7  # the next step is rounding
        out[left[found]] = place[found]
        on = ~found & (np.abs(place).max(axis=1) < 2.0)  # otherwise the search has left the element
        left, place = left[on], place[on]
        if len(left) == 0:
            break
    return out


def _solved(matrices: Floats, right: Floats) -> Floats:
    """Solutions (n, 3) for matrices (n, 3, 3), which may be singular."""
    try:
        return np.asarray(np.linalg.solve(matrices, right[:, :, None])[:, :, 0], dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.einsum("nij,nj->ni", np.linalg.pinv(matrices), right)


def _interpolated(weights: tuple[list[Floats], list[Floats]], values: Floats) -> tuple[Floats, Floats]:
    """Interpolation (n, c) of values (nx, ny, nz, c), and derivatives (n, 3, c) in reference coordinates."""
    (x, y, z), (dx, dy, dz) = weights
    nx, ny, nz, c = values.shape
    flat = values.transpose(2, 0, 1, 3).reshape(nz, -1)
    at_z, slope_z = ((w @ flat).reshape(-1, nx, ny * c) for w in (z, dz))
    at_x, slope_x = ((w[:, None, :] @ at_z).reshape(-1, ny, c) for w in (x, dx))
    at_x_slope_z = (x[:, None, :] @ slope_z).reshape(-1, ny, c)
    parts = ((y, at_x), (y, slope_x), (dy, at_x), (y, at_x_slope_z))
    value, *slopes = ((w[:, None, :] @ part)[:, 0] for w, part in parts)
    return value, np.stack(slopes, axis=1)


def _weights(element: Element, place: Floats, dropped: int) -> tuple[list[Floats], list[Floats]]:
    """Weights (n, nx), (n, ny) and (n, nz) of nodal values, for a function and its derivatives."""
    modes = legendre.legvander(place, max(map(len, element.nodes)) - 1)
    of_values, of_slopes = [], []
    for k, nodes in enumerate(element.nodes):
        function, derivative = _modes(tuple(nodes), dropped)
        of_values.append(modes[:, k, : len(nodes)] @ function)
        of_slopes.append(modes[:, k, : len(nodes)] @ derivative)
    return of_values, of_slopes


@lru_cache(maxsize=256)
def _modes(nodes: tuple[float, ...], dropped: int) -> tuple[Floats, Floats]:
    """Matrices from nodal values to Legendre coefficients of a function and its derivative."""
    degree = len(nodes) - 1
    coefficients = np.linalg.inv(legendre.legvander(np.array(nodes), degree))
    coefficients[max(len(nodes) - dropped, 1) :] = 0.0
    derived = np.zeros_like(coefficients)
    derived[:degree] = legendre.legder(coefficients) if degree else 0.0
    return coefficients, derived
