"""Quantities displayed by color: values at the vertices or faces, with label, scale and limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from isoembed.arrays import Floats
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.io.format import Polygons, flattened
from isoembed.io.surface import vertex_residuals
from isoembed.metric.curvature import area
from isoembed.progress.stages import Log
from isoembed.reprs import short_repr
from isoembed.similar_names import did_you_mean
from isoembed.surface.flat_faces import FlatFaces

if TYPE_CHECKING:
    from isoembed.embedding.comparison import Comparison
    from isoembed.surface.changes import Changes


EMPTY: Mapping[str, Quantity] = MappingProxyType({})
SMALLEST_RESIDUAL = 1e-17  # mean edge lengths: displayed in place of zero


@short_repr
@dataclass(frozen=True, eq=False)
class Quantity:
    """A scalar field on the vertices or the faces.

    Attributes
    ----------
    name : str
    label : str
        Label with the symbol, in TeX between dollar signs.
    values : ndarray, shape (V,), or one for each of the `Embedding.polygons`
        NaN where undefined.
    scale : {"linear", "log"}
    at : {"vertices", "faces"}
    """

    name: str
    label: str
    values: Floats
    scale: Literal["linear", "log"] = "linear"
    at: Literal["vertices", "faces"] = "vertices"

    @property
    def bounds(self) -> tuple[float, float]:
        """Limits of the color scale: the 1st and 99th percentiles of the values, approximately.

        On a logarithmic scale they are powers of ten.
        """
        values = self.values[np.isfinite(self.values)]
        if not values.size:
            return 0.0, 1.0
        if self.at == "faces":  # whole numbers, few of them
            return float(values.min() - 0.5), float(values.max() + 0.5)
        low, high = np.percentile(values, (1.0, 99.0))  # outliers do not determine the scale
        if self.scale == "log":
            first = np.floor(np.log10(low))
            return float(10**first), float(10 ** max(np.ceil(np.log10(high)), first + 1))
        middle = (low + high) / 2
        largest = float(np.abs(values).max())
        half = max(
            (high - low) / 2, 0.05 * abs(middle), 1e-6 * largest
        )  # a smaller range would show rounding errors as structure
        if half == 0:
            return 0.0, 1.0
        return float(middle - half), float(middle + half)


MEAN_CURVATURE, GAUSSIAN_CURVATURE = "mean curvature", "Gaussian curvature"
SIDES = "sides"


def mean_curvature(embedding: Embedding) -> Quantity:
    """Mean curvature H = (k1 + k2) / 2, from the dihedral angles."""
    return Quantity(MEAN_CURVATURE, "mean curvature  $H = (k_1 + k_2)/2$", embedding.mean_curvature)


def intrinsic_curvature(embedding: Embedding) -> Quantity:
    """Gaussian curvature K: deficit over circumcentric dual area, plus k; undefined on a boundary."""
    own = "$k$ + " if embedding.metric.curvature else ""
    label = f"Gaussian curvature  $K$ = {own}deficit / dual area"
    return Quantity(GAUSSIAN_CURVATURE, label, embedding.gaussian_curvature)


def residual(embedding: Embedding) -> Quantity:
    """Largest length error of the edges at each vertex, in mean edge lengths."""
    values = np.maximum(vertex_residuals(embedding), SMALLEST_RESIDUAL)
    return Quantity("residual", "largest length error, in mean edge lengths", values, "log")


def concavity(embedding: Embedding) -> Quantity:
    """Fraction of concave edges at each vertex; above 0.7 the vertex is partially inverted."""
    ends = embedding.metric.edges[embedding.surface.concave_edges].ravel()
    counts = np.bincount(ends, minlength=embedding.triangulation.n_vertices)
    return Quantity(
        "concave edges", "share of concave edges at a vertex", counts / embedding.triangulation.degrees
    )


def conformal_factor(embedding: Embedding) -> Quantity | None:
    """Log factor u of the centered discrete conformal map to the sphere of equal area, if it exists.

    A length on the sphere is the length on the surface times ``e^u`` (the chord in hyperbolic and spherical
    space); Springborn, Schroeder and Pinkall, ACM TOG 27 (2008).
    """
    t = embedding.triangulation
    if not t.is_sphere or t.n_faces == 2:  # a doubly covered triangle has no faces away from the pole
        return None
    from isoembed.metric.conformal_sphere import conformal_factors, conformal_sphere  # slow to import
    from isoembed.metric.delaunay import delaunay

    unit = delaunay(embedding.metric.normalized)
    with Log().stage("conformal map") as recorder:
        sphere = conformal_sphere(unit, recorder)
    if not sphere.exact:
        return None
    factors = conformal_factors(unit, sphere) + np.log(area(unit) / (4 * np.pi)) / 2
    return Quantity("conformal factor", "conformal factor  $u$  to the sphere of this area", factors)


def sides(embedding: Embedding) -> Quantity | None:
    """Number of sides of each face of a polyhedron; None for surfaces without polygonal faces.

    Collinear edges count as one side.
    """
    if not isinstance(embedding.surface.flat_faces, FlatFaces):
        return None
    counts = embedding.surface.flat_faces.sides.astype(np.float64)
    return Quantity(SIDES, "number of sides of a face", counts, at="faces")


def vertex_deviation(deviation: Changes) -> Quantity:
    """Deviation of the vertices due to length errors, relative to its root mean square (in the label)."""
    rms = deviation.report["vertices_rms"]
    label = f"deviation of vertices, over {rms:.2g}"
    return Quantity("deviation", label, deviation.vertices / (rms or 1.0))


def mean_curvature_difference(comparison: Comparison) -> Quantity:
    """Difference of H, second surface minus first, relative to its root mean square (in the label)."""
    differences = comparison.difference.mean_curvature
    rms = comparison.difference.report["mean_curvature_rms"]
    return Quantity(
        "difference of mean curvature", f"difference of $H$, over {rms:.2g}", differences / (rms or 1.0)
    )


QUANTITIES = {
    MEAN_CURVATURE: mean_curvature,
    GAUSSIAN_CURVATURE: intrinsic_curvature,
    "residual": residual,
    "concave edges": concavity,
    "conformal factor": conformal_factor,
    SIDES: sides,
}
"""Functions that compute quantities of an embedding, by name."""


def usual(embedding: Embedding) -> str:
    """Default quantity: number of sides on a polyhedron with few faces, otherwise the mean curvature."""
    faces = embedding.surface.flat_faces
    # Polyhedra with more faces look smooth.
    return SIDES if isinstance(faces, FlatFaces) and len(faces) <= 200 else MEAN_CURVATURE


def quantities(embedding: Embedding, given: Mapping[str, Quantity] = EMPTY) -> tuple[Quantity, ...]:
    """Quantities of a surface, the default one first.

    Parameters
    ----------
    embedding : Embedding
    given : mapping of str to Quantity
        Quantities by name that replace the computed ones.
    """
    names = sorted(QUANTITIES, key=usual(embedding).__ne__)
    all_found = (given.get(name) or QUANTITIES[name](embedding) for name in names)
    return tuple(found for found in all_found if found is not None)


def from_file(curvatures: Mapping[str, Floats]) -> dict[str, Quantity]:
    """Quantities for the curvatures (V,) stored in a surface file."""
    named = {MEAN_CURVATURE: "mean curvature  $H$", GAUSSIAN_CURVATURE: "Gaussian curvature  $K$"}
    return {
        name: Quantity(name, f"{label}, as in the file", curvatures[spelled(name).replace("-", "_")])
        for name, label in named.items()
        if spelled(name).replace("-", "_") in curvatures
    }


def spelled(name: str) -> str:
    """Command-line spelling of a quantity's name: ``gaussian-curvature``."""
    return name.lower().replace(" ", "-").replace("_", "-")


def quantity(embedding: Embedding, color: str | Quantity | ArrayLike) -> Quantity:
    """Quantity displayed by color, selected by name in any spelling, or given by its values.

    Parameters
    ----------
    embedding : Embedding
    color : str, Quantity, or array_like, shape (V,)
        If the named quantity is undefined for the surface, the values are NaN.

    Raises
    ------
    InvalidParameter
        The quantity is unknown, or the number of values is not that of the vertices or faces.
    """
    if not isinstance(color, str):
        return _own(embedding, color)
    name = color
    names = {spelled(each): each for each in QUANTITIES}
    if spelled(name) not in names:
        near = did_you_mean(spelled(name), names)
        raise InvalidParameter(
            f"there is no quantity {name!r} to show; there are {', '.join(QUANTITIES)}{near}"
        )
    name = names[spelled(name)]
    found = QUANTITIES[name](embedding)
    nowhere = np.full(embedding.triangulation.n_vertices, np.nan)
    return Quantity(name, f"this surface has no {name}", nowhere) if found is None else found


def _own(embedding: Embedding, color: Quantity | ArrayLike) -> Quantity:
    """Checked quantity given by the caller."""
    if not isinstance(color, Quantity):
        try:
            color = Quantity("values", "", np.asarray(color, dtype=np.float64))
        except (TypeError, ValueError):
            raise InvalidParameter(
                f"the color is of type {type(color).__name__}, not the name of a quantity, a Quantity, or "
                "one number for each vertex"
            ) from None
    places = embedding.triangulation.n_vertices if color.at == "vertices" else len(embedding.polygons)
    if np.shape(color.values) != (places,):
        raise InvalidParameter(
            f"the color has values of shape {np.shape(color.values)}, not ({places},): one for each of the "
            f"{color.at}"
        )
    return color


def face_means(values: Floats, faces: Polygons) -> Floats:
    """Mean of the defined values at the corners of each face, shape (F,)."""
    corners, sizes = flattened(faces)
    finite, begins = np.isfinite(values[corners]), np.cumsum(sizes) - sizes
    sums = np.add.reduceat(np.where(finite, values[corners], 0.0), begins)
    counts = np.add.reduceat(finite.astype(np.float64), begins)
    return sums / np.where(counts, counts, np.nan)
