"""Smooth embedding of a surface of a slice, and its quasi-local energies."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric, InvalidParameter, NoMinimum, NotEmbedded
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity.energies.chen_wang_yau import ChenWangYau, chen_wang_yau
from isoembed.relativity.energies.energies import Energies
from isoembed.relativity.energies.smooth_energies import smooth_energies
from isoembed.relativity.energies.wang_yau_energy import wang_yau
from isoembed.relativity.energies.wang_yau_result import WangYau
from isoembed.relativity.horizons.horizon_shape import HorizonShape
from isoembed.relativity.horizons.spin import Spin, find_spin, spin_report, torques
from isoembed.relativity.spacetimes.surface_data import SurfaceData, momentum_of
from isoembed.reprs import html_table, short_repr
from isoembed.smooth.embedding import SmoothEmbedding
from isoembed.smooth.least_hyperbolic import LeastHyperbolic, least_hyperbolic
from isoembed.smooth.solve import embed_smooth
from isoembed.smooth.start import Start
from isoembed.smooth.two_metric import area_density, tensor_at
from isoembed.space import EUCLIDEAN, Space
from isoembed.space.models import to_model

NoWangYau = InvalidParameter | NotEmbedded | NoMinimum
"""Reasons for a missing Wang-Yau energy: missing data, no embedding in Minkowski space, or no minimum."""

CONVENTIONS = {
    "units": "geometric, G = c = 1, in the unit of the lengths",
    "integrated_mean_curvature": "int H dA with H = (k1 + k2)/2 in Euclidean space; int k0 dA is twice that",
    "dimensionless_spin": "J / M^2, M the Christodoulou mass",
    "hawking": "sqrt(A/16 pi) (1 - int (k^2 - p^2) dA / 16 pi)",
    "brown_york": "int (k0 - k) dA / 8 pi",
    "liu_yau": "int (k0 - sqrt(k^2 - p^2)) dA / 8 pi",
    "wang_yau": "least over tau of int k0 dA0 / 8 pi for q + d tau d tau, less its counterpart in spacetime",
}


IN_CURVED_SPACE = {
    "integrated_mean_curvature": "int H dA with H = (k1 + k2)/2 in the space; int k0 dA is twice that",
    "wang_yau": "int V (k0 - sqrt(k^2 - p^2)) dA / 8 pi for observers at rest, for tau = 0 alone",
}
"""Conventions that differ for a hyperbolic or spherical reference space."""


def conventions(space: Space) -> dict[str, str]:
    """Conventions of the numbers of a report, for a reference space."""
    return CONVENTIONS if space.is_euclidean else CONVENTIONS | IN_CURVED_SPACE


@short_repr
@dataclass(frozen=True)
class EmbeddedSurface:
    """Surface with its smooth embedding.

    Attributes
    ----------
    data : SurfaceData
    embedding : SmoothEmbedding
        Embedding of ``data.metric``.
    least : LeastHyperbolic, optional
        Least hyperbolic space of the metric, if ``space="hyperbolic"`` was requested.
    """

    data: SurfaceData
    embedding: SmoothEmbedding
    least: LeastHyperbolic | None = None

    def _shown(self) -> Iterator[tuple[str, object]]:
        yield "name", self.data.name
        yield "status", self.status
        yield "space", self.space
        yield "residual", self.embedding.residual

    def _repr_html_(self) -> str:
        return html_table(self) + html_table(self.energies)

    @property
    def status(self) -> str:
        """``"embedded"``, or ``"best fit"`` if the surface has the metric only approximately."""
        return "embedded" if self.embedding.converged else "best fit"

    @property
    def space(self) -> Space:
        """Reference space."""
        return self.embedding.space

    @cached_property
    def energies(self) -> Energies:
        """Area, int H dA and the quasi-local energies, each with its error."""
        return smooth_energies(
            self.data,
            self.embedding,
            self.spin if self.data.marginal else None,
            curvature_error=self.curvature_error,
        )

    @property
    def curvature_error(self) -> float:
        """Error of the curvature of the space: 0 if it was given."""
        return self.least.curvature_error if self.least else 0.0

    @cached_property
    def spin(self) -> Spin | None:
        """Angular momentum and its axis; None if K(., n) is not known."""
        return find_spin(self.data)

    @cached_property
    def wang_yau(self) -> WangYau | ChenWangYau | NoWangYau:
        """Least Wang-Yau energy, or the exception that explains why there is none.

        In hyperbolic and spherical space, slices of anti-de Sitter and de Sitter space, it is that of tau = 0
        (`isoembed.relativity.chen_wang_yau`), whose surface is the embedded one.
        """
        try:
            if self.space.is_euclidean:
                return wang_yau(self.data, "optimal", embedding=self.embedding)
            return chen_wang_yau(self.data, self.embedding, curvature_error=self.curvature_error)
        except (InvalidParameter, NotEmbedded, NoMinimum) as error:
            return error.with_traceback(None)  # the traceback would keep intermediate results alive

    @property
    def report(self) -> dict[str, Any]:
        """Plain numbers, for JSON: the energies and how the surface was embedded."""
        return embedded_report(self)

    def mesh(self, vertices: int) -> dict[str, NDArray[Any]]:
        """Triangulation of the embedded surface, with data at its vertices.

        Returns
        -------
        dict of str to ndarray
            ``vertices`` (V, 3) and ``faces`` (F, 3); in hyperbolic and spherical space the vertices are
            conformal coordinates, as in files, and the ``curvature`` of the space is included.  Further
            entries (V,): ``mean_curvature`` H, ``gaussian_curvature``, and ``residual``, the relative error
            of lengths.  If k is given, ``k`` and ``p`` in the slice, and the expansions of outgoing and
            ingoing light rays, ``theta_plus`` = k - p and ``theta_minus`` = -(k + p).  If there is a spin,
            ``angular_momentum_density``, K(phi, n) / 8 pi, where phi is the rotation about its axis in slice
            coordinates.  If the points in the slice are known, ``slice_coordinates`` (V, 3).
        """
        triangulation = self.embedding.triangulated(vertices)
        return self.mesh_on(triangulation.directions, triangulation.faces)

    def mesh_on(self, directions: Floats, faces: Indices) -> dict[str, NDArray[Any]]:
        """Mesh of `mesh` on a given triangulation of the sphere of directions.

        Parameters
        ----------
        directions : ndarray, shape (V, 3)
            Directions, for example of the mesh of a nearby surface, for vertex-wise comparison in a sequence.
        faces : ndarray of int, shape (F, 3)
        """
        u = directions
        tables = {
            "vertices": to_model(self.space, self.embedding.points(u), "conformal"),
            "faces": faces,
            "mean_curvature": self.embedding.mean_curvature(u),
            "gaussian_curvature": self.embedding.gaussian_curvature(u),
            "residual": 0.5 * self.embedding.strain(u),
        }
        if not self.space.is_euclidean:
            tables["curvature"] = np.array(self.space.curvature)
        if self.data.mean_curvature is not None:
            k = self.data.mean_curvature(u)
            p = momentum_of(self.data, u)
            tables |= {"k": k, "p": p, "theta_plus": k - p, "theta_minus": -(k + p)}
        if self.spin is not None and self.spin.axis is not None:
            tables["angular_momentum_density"] = torques(self.data, u) @ self.spin.axis / (8.0 * np.pi)
        if self.data.shape is not None:
            tables["slice_coordinates"] = self.data.shape(u)
        return tables


def embed_surface(
    data: SurfaceData,
    *,
    space: Space | Literal["hyperbolic"] = EUCLIDEAN,
    start: EmbeddedSurface | Start | None = None,
    vertices: int = 1000,
    tolerance: float = 1e-4,
    best_fit: bool = False,
) -> EmbeddedSurface:
    """Embed a surface of a slice in Euclidean space or another reference space, for its energies.

    Parameters
    ----------
    data : SurfaceData
    space : Space or "hyperbolic"
        Reference space, from `isoembed.Hyperbolic` or `isoembed.Spherical`; or ``"hyperbolic"`` for the space
        of least absolute curvature in which the metric embeds (see `isoembed.smooth.least_hyperbolic`),
        Euclidean if that is zero.
    start : EmbeddedSurface or isoembed.smooth.Start, optional
        Nearby surface, such as the previous one of a sequence, as initial guess; several times faster.
    vertices, tolerance, best_fit
        See `isoembed.smooth.embed_smooth`.

    Raises
    ------
    InvalidParameter, InvalidMetric, NotEmbedded
        See `isoembed.smooth.embed_smooth`.

    Notes
    -----
    Tolerances are adapted to the errors of lengths (``data.lengths_error``).
    """
    if not isinstance(data, SurfaceData):
        instead = "take its data()" if hasattr(data, "data") else "for a metric alone, SurfaceData(metric)"
        raise InvalidParameter(f"the data are a {type(data).__name__}, not SurfaceData: {instead}")
    if not (start is None or isinstance(start, EmbeddedSurface | Start)):
        raise InvalidParameter(f"start is a {type(start).__name__}, not an EmbeddedSurface or a Start")
    trace = np.trace(tensor_at(data.metric, np.eye(3)), axis1=1, axis2=2)
    if not np.all((trace > 1e-200) & (trace < 1e200)):  # otherwise squares of lengths underflow or overflow
        raise InvalidMetric(
            f"products of squared lengths of about {trace.max():.3g} overflow or underflow: use another unit"
        )
    least = None
    if space == "hyperbolic":
        least = _with_displacement(least_hyperbolic(data.metric), data)
        space = least.space
    elif not isinstance(space, Space):
        raise InvalidParameter(f'the space is {space!r}, not a Space or "hyperbolic"')
    uncertain = data.lengths_error
    embedding = embed_smooth(
        data.metric,
        space=space,
        start=start.embedding if isinstance(start, EmbeddedSurface) else start,
        shape=data.shape,
        vertices=vertices,
        # Short lengths have a larger error than points.
        tolerance=max(tolerance, 100.0 * uncertain.mean, 2.0 * uncertain.pointwise),
        # Rounding, or a hundredth of the error at points, which int H dA averages.
        accuracy=max(1e-12, uncertain.mean, 0.01 * uncertain.pointwise),
        best_fit=best_fit,
        lengths_error=uncertain.pointwise,
    )
    return EmbeddedSurface(data, embedding, least)


def _with_displacement(bound: LeastHyperbolic, data: SurfaceData) -> LeastHyperbolic:
    """Least hyperbolic space, with the displacement of a horizon added to the error of its curvature."""
    if not data.displacement:
        return bound
    u, weights = gauss_rule(24, 48)
    area = float(weights @ area_density(data.metric.tensor(u)))
    # A factor exp(f) of lengths, f of degree 2, changes K of a sphere to (K + 6 f / R^2) exp(-2 f).
    return replace(bound, error=bound.error + 8.0 * data.displacement * 4.0 * np.pi / area)


def space_report(space: Space, least: LeastHyperbolic | None = None) -> dict[str, Any]:
    """Plain numbers, for JSON: the reference space, and how it was determined."""
    found = (
        {
            "gaussian_curvature": least.gaussian_curvature,
            "of_revolution": least.of_revolution,
            "error": least.error,
            "explanation": least.explanation,
        }
        if least
        else None
    )
    return {"name": space.name, "curvature": space.curvature, **({"least": found} if found else {})}


def embedded_report(
    surface: EmbeddedSurface, wang_yau: WangYau | ChenWangYau | NoWangYau | None = None
) -> dict[str, Any]:
    """Report of an embedded surface, plain numbers for JSON.

    Parameters
    ----------
    surface : EmbeddedSurface
    wang_yau : WangYau, ChenWangYau or exception, optional
        `EmbeddedSurface.wang_yau`, if requested.
    """
    data, embedding = surface.data, surface.embedding
    energies, more, notes = surface.energies.report, dict[str, Any](), tuple[str, ...]()
    if isinstance(wang_yau, NoWangYau):
        more, notes = {"wang_yau": None}, (str(wang_yau),)
        energies["errors"]["wang_yau"] = None
    elif wang_yau is not None:
        energy, notes = wang_yau.energy, wang_yau.notes
        energies["errors"]["wang_yau"] = energy.error
        energies["error_estimate"] = max(energies["error_estimate"], energy.error)
        kind = "minimum" if isinstance(wang_yau, WangYau) else "rest_frame"
        more = {"wang_yau": energy.value, kind: wang_yau.report}
        if isinstance(wang_yau, WangYau):
            more["wang_yau_admissible"] = wang_yau.admissible > 0.0
    return {
        "status": surface.status,
        "name": data.name,
        **energies,
        **intrinsic_entries(data, surface.spin),
        "space": space_report(surface.space, surface.least),
        "embedding": {
            "degree": embedding.harmonics.degree,
            "order": embedding.harmonics.order,
            "residual": embedding.residual,
            "least_gaussian_curvature": embedding.least_curvature,
            "volume": embedding.volume,
        },
        "conventions": conventions(surface.space),
        **more,
        "notes": [*energies["notes"], *notes],
    }


def intrinsic_entries(data: SurfaceData, spin: Spin | None) -> dict[str, Any]:
    """Entries of the spin and, for a horizon, of its intrinsic shape."""
    shape = HorizonShape.of(data, spin).report if data.marginal else {}
    return {"spin": spin_report(data, spin), **shape}
