"""Task that reads, embeds and reports one horizon of a series, starting from the previous one."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Literal

from numpy.typing import NDArray

from isoembed.arrays import Floats, Indices
from isoembed.errors import InvalidMetric, InvalidParameter, NotEmbedded
from isoembed.io.files import FileError
from isoembed.meshing.sphere import gauss_rule
from isoembed.meshing.surface_mesh import MIN_VERTICES, checked_count
from isoembed.relativity.energies.embedded_surface import EmbeddedSurface, embed_surface, embedded_report
from isoembed.relativity.energies.report import checked_report, unembedded_report
from isoembed.relativity.horizons.conformal_multipoles import checked_order, conformal_multipoles
from isoembed.relativity.horizons.coordinate_shape import CoordinateShape
from isoembed.relativity.horizons.found_horizon import FoundHorizon
from isoembed.relativity.horizons.horizon import OWN_METRIC, HorizonFacts, horizon_data
from isoembed.relativity.series.moment import Moment
from isoembed.relativity.series.sampled_values import values_digest
from isoembed.relativity.series.source import HeldShape, HeldSlice
from isoembed.relativity.spacetimes.checks import unit_vector
from isoembed.relativity.spacetimes.surface import Surface
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.runs.result import REFUSED, Result
from isoembed.smooth.start import Start
from isoembed.smooth.triangulation import MOST_VERTICES
from isoembed.space import EUCLIDEAN, Space

DIRECTIONS, FIELD = "directions", "field/"
MESH = ("vertices", "faces")
"""Names of the arrays of a mesh."""


@dataclass(frozen=True)
class HorizonOptions:
    """Options for all horizons of a series.

    Attributes
    ----------
    vertices : int
        Number of vertices of the initial and of the stored mesh.
    wang_yau : bool
        Whether to compute the least Wang-Yau energy.
    axis : three floats, optional
        Additional axis for the angular momentum.
    marginal : bool, optional
        Whether the surfaces are horizons; by default the expansion of each decides.
    space : Space or "hyperbolic"
        Reference space; see `isoembed.relativity.embed_surface`.
    multipoles : int, optional
        Largest degree l of multipoles (l, m) of horizons; see `isoembed.relativity.conformal_multipoles`.

    Raises
    ------
    InvalidParameter
        There are too few or too many vertices, the axis is invalid, or l is out of range.
    """

    vertices: int = 1000
    wang_yau: bool = False
    axis: tuple[float, float, float] | None = None
    marginal: bool | None = None
    space: Space | Literal["hyperbolic"] = EUCLIDEAN
    multipoles: int | None = None

    def __post_init__(self) -> None:
        checked_count("the number of vertices", self.vertices, MIN_VERTICES, MOST_VERTICES)
        if self.axis is not None:
            unit_vector("the axis", self.axis)
        if self.multipoles is not None:
            checked_order(self.multipoles)


@dataclass(frozen=True)
class HorizonTask:
    """Embedding of the horizon of a moment; see `isoembed.runs.Task`.

    The report is that of `isoembed.relativity.embed_surface` with ``horizon``, the data of the file and
    the expansion, and ``moment``.  The arrays are those of the mesh, its ``directions`` on the sphere,
    ``vertices``, ``faces`` and ``field/`` with each name of data at the vertices, and those of the
    `isoembed.smooth.Start` that the surface is for the next one, which has the same mesh.

    Attributes
    ----------
    moment : Moment
    options : HorizonOptions
    """

    moment: Moment
    options: HorizonOptions = HorizonOptions()

    @property
    def label(self) -> str:
        """See `isoembed.runs.Task`."""
        return self.moment.label

    @property
    def facts(self) -> dict[str, Any]:
        """See `isoembed.runs.Task`."""
        return {"name": self.moment.shape.name, "notes": [], "moment": self._when(None)}

    def digest(self) -> str:
        """Digest of the contents of the shape and the slice, of the time, and of the options.

        For objects in memory, values at fixed points are included, because functions may have changed.
        """
        moment = self.moment
        there = {
            "moment": [moment.series, moment.time, moment.iteration],
            "shape": _digest(moment.shape.digest),
            "slice": moment.slice and _digest(moment.slice.digest),
            **asdict(self.options),
        }
        if isinstance(moment.shape, HeldShape) or isinstance(moment.slice, HeldSlice):
            there["values"] = self._values_digest()
        if self.options.space == EUCLIDEAN:  # compatibility with results older than other spaces
            del there["space"]
        if self.options.multipoles is None:  # likewise
            del there["multipoles"]
        return hashlib.sha256(json.dumps(there, sort_keys=True).encode()).hexdigest()

    def compute(self, before: Result | None) -> Result:
        """See `isoembed.runs.Task`."""
        try:
            data, facts = self._horizon()
            try:
                surface, mesh = self._embedded(data, before)
            except NotEmbedded as error:
                return self._result(data, facts, unembedded_report(data, error), {})
            report = embedded_report(surface, surface.wang_yau if self.options.wang_yau else None)
            tables = surface.mesh_on(*mesh)
            arrays = {name if name in MESH else FIELD + name: values for name, values in tables.items()}
            arrays |= {DIRECTIONS: mesh[0], **Start.of(surface.embedding).arrays}
            return self._result(data, facts, report, arrays)
        except (FileError, InvalidMetric, InvalidParameter) as error:
            return Result.without_answer(self.label, REFUSED, str(error), **self.facts)

    def _values_digest(self) -> str:
        """Digest of values at fixed points, or of the error that `compute` will meet, too."""
        slice_ = self.moment.slice
        geometry = slice_.geometry if isinstance(slice_, HeldSlice) else None
        try:
            return values_digest(self.moment.shape.read(), geometry)
        except Exception as error:  # of a user's function
            return f"{type(error).__name__}: {error}"

    def _horizon(self) -> tuple[SurfaceData, HorizonFacts]:
        moment, options = self.moment, self.options
        found = moment.shape.read()
        name, geometry = moment.shape.name, None
        if moment.slice is not None:
            if isinstance(found, SurfaceData):
                raise InvalidParameter(f"{name} {OWN_METRIC}")
            geometry = moment.slice.read(*_box(found))
        return horizon_data(found, geometry, axis=options.axis, marginal=options.marginal, name=name)

    def _embedded(
        self, data: SurfaceData, before: Result | None
    ) -> tuple[EmbeddedSurface, tuple[Floats, Indices]]:
        """Embedding from the previous one of the series, on its mesh; if that fails, from a new mesh."""
        if before is not None and before.report["moment"]["series"] == self.moment.series:
            try:
                surface = embed_surface(data, space=self.options.space, start=Start.restored(before.arrays))
                return surface, (before.arrays[DIRECTIONS], before.arrays["faces"])
            except (NotEmbedded, InvalidParameter):  # the latter from unsuitable coordinates
                pass
        surface = embed_surface(data, space=self.options.space, vertices=self.options.vertices)
        mesh = surface.embedding.triangulated(self.options.vertices)
        return surface, (mesh.directions, mesh.faces)

    def _result(
        self, data: SurfaceData, facts: HorizonFacts, report: dict[str, Any], arrays: dict[str, NDArray[Any]]
    ) -> Result:
        moment, horizon = self._when(facts.points), facts.report
        # Time and iteration come from the series if they are not in the file.
        horizon |= {name: moment[name] for name in ("time", "iteration") if name in horizon}
        if self.options.multipoles is not None and data.marginal:
            found = conformal_multipoles(data, self.options.multipoles)
            report = {**report, "conformal_multipoles": found.report}
        report = checked_report(report, facts.curvature_check) | {"horizon": horizon, "moment": moment}
        return Result(self.label, report["status"], report, arrays)

    def _when(self, file: CoordinateShape | None) -> dict[str, Any]:
        """Series, time and iteration of the moment, from the file if necessary, and its sources."""
        moment = self.moment
        return {
            "series": moment.series,
            "time": file.time if file and moment.time is None else moment.time,
            "iteration": file.iteration if file and moment.iteration is None else moment.iteration,
            "shape": moment.shape.name,
            "slice": None if moment.slice is None else moment.slice.name,
        }


def mesh_of(result: Result) -> dict[str, NDArray[Any]]:
    """Mesh of an embedded horizon, as from `isoembed.relativity.EmbeddedSurface.mesh`."""
    return {
        name.removeprefix(FIELD): values
        for name, values in result.arrays.items()
        if name in MESH or name.startswith(FIELD)
    }


def _digest(digest: Callable[[], str]) -> str:
    """Digest, or the error without one, so that an unreadable file is another task once readable."""
    try:
        return digest()
    except FileError as error:
        return str(error)


def _box(found: CoordinateShape | Surface | FoundHorizon) -> tuple[Floats, Floats]:
    """Corners (3,) of a box with a margin around a horizon."""
    directions, _ = gauss_rule(24, 48)
    found = found.surface if isinstance(found, FoundHorizon) else found
    points = found.points(directions) if isinstance(found, Surface) else found.points
    low, high = points.min(axis=0), points.max(axis=0)
    room = 0.02 * (high - low)  # the surface may extend beyond its points
    return low - room, high + room
