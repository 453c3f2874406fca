"""Search for all realizations of a metric within a distance of one (`isoembed.realizations`)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from isoembed.aim.realization_search import RealizationSearch
from isoembed.arrays import Floats, Mask
from isoembed.embedding.certify import certify
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.evidence import Evidence
from isoembed.mesh.triangulation import frozen
from isoembed.progress.stages import Log
from isoembed.reprs import short_repr
from isoembed.strict_json import plain
from isoembed.surface.rigidity import LengthSystem

FEWEST, MOST = 2, 8  # motions combined; 2^8 roots


@short_repr
@dataclass(frozen=True, eq=False)
class Realizations:
    """Surfaces with the same triangles and lengths near a given one, and the region searched.

    Attributes
    ----------
    about : Embedding
        The given surface, which is one of them, up to rounding, if it has the lengths.
    surfaces : tuple of Embedding
        In increasing order of `fine_roughness`.
    searched : ndarray of bool, shape (n,)
        Whether each was a center of the search.
    distance : float
        Largest displacement of a vertex from the given surface, in mean edge lengths.
    motions : int
        Largest number of motions combined.
    unsolved : int
        Number of omissions: surfaces that flex to first order, which cannot be centers, and systems of
        quadratic equations solved incompletely.
    """

    about: Embedding
    surfaces: tuple[Embedding, ...]
    searched: Mask
    distance: float
    motions: int
    unsolved: int

    @cached_property
    def distances(self) -> Floats:
        """Distances of the realizations from the surface, in mean edge lengths, shape (n,)."""
        return frozen(np.array([self.about.distance(each) for each in self.surfaces]))

    @cached_property
    def apart(self) -> Floats:
        """Distances between the realizations, in mean edge lengths, shape (n, n)."""
        found = np.zeros((len(self.surfaces), len(self.surfaces)))
        for i, surface in enumerate(self.surfaces):
            for j in range(i):
                found[i, j] = found[j, i] = surface.distance(self.surfaces[j])
        return frozen(found)

    @property
    def message(self) -> str:
        """Summary of the search and of the realizations found."""
        found, searched = len(self.surfaces), int(self.searched.sum())
        region = f"within {self.distance:g} mean edge lengths of the surface"
        if not found:
            message = f"no realization of these lengths was found {region}"
        else:
            message = (
                f"{found} realization{'s' if found > 1 else ''} of these lengths found {region}, with "
                f"searches from {searched} of them, breadth first and smoothest first"
            )
        message += f"; {self.evidence.basis}. Not searched: farther surfaces"
        if found > searched:
            message += f", the surroundings of {found - searched} of those found"
        if self.unsolved:
            message += f", and {self.unsolved} cases of a flexible surface or unsolved equations"
        return f"{message}; there may be others nearby that are not predicted"

    @property
    def evidence(self) -> Evidence:
        """Extent of the search, the evidence that there are no others."""
        return Evidence(
            "searched",
            f"search along combinations of up to {self.motions} motions to predicted realizations, at "
            "all roots of their quadratic equations",
        )

    @property
    def report(self) -> dict[str, Any]:
        """Report as a JSON object, with certificates."""
        found = {
            "message": self.message,
            **self.evidence.report,
            "region": {"distance": self.distance, "motions": self.motions, "unsolved": self.unsolved},
            "realizations": [
                {
                    "distance": distance,
                    "searched": bool(searched),
                    "residual": surface.residual,
                    "roughness": surface.surface.roughness,
                    "fine_roughness": surface.surface.fine_roughness,
                    "certificate": certify(surface).as_json(),
                }
                for surface, distance, searched in zip(
                    self.surfaces, self.distances, self.searched, strict=True
                )
            ],
            "apart": self.apart.tolist(),
        }
        return dict(plain(found))


def realizations(
    embedding: Embedding, *, distance: float = 0.12, motions: int = 5, surfaces: int = 8
) -> Realizations:
    """Search for realizations of a metric near one of them, or near an attempt.

    Parameters
    ----------
    embedding : Embedding
        A result of `embed`, or the `embedding` of a `NotEmbedded`.
    distance : float
        Largest displacement of a vertex, in mean edge lengths.
    motions : int
        Number of motions combined, from 2 to 8: their quadratic equations have 2^motions roots.
    surfaces : int
        Number of realizations to search from, including the given one, alternately smoothest first and
        breadth first.  If many vertices can be pushed in, there are more than can be found.

    Returns
    -------
    Realizations

    Raises
    ------
    InvalidParameter
        A parameter is out of range.
    InvalidMetric
        The surface has a boundary or handles.
    """
    embedding.triangulation.check_sphere(
        "realizations are sought of", "embed from several starts, with boundary='free', start=..."
    )
    if not 0 < distance < np.inf:
        raise InvalidParameter(f"the distance is {distance!r}, not a positive number of mean edge lengths")
    for name, value, lower, upper in (("motions", motions, FEWEST, MOST), ("surfaces", surfaces, 1, np.inf)):
        if not (isinstance(value, int) and lower <= value <= upper):
            wanted = f"from {lower} to {upper}" if upper < np.inf else f"of at least {lower}"
            raise InvalidParameter(f"the number of {name} is {value!r}, not an integer {wanted}")
    metric = embedding.metric
    with Log().stage("realizations") as recorder:
        system = LengthSystem(metric.triangulation, space=metric.normalized.space, work=recorder.work)
        search = RealizationSearch(
            metric.normalized, system, embedding.vertices / metric.unit, recorder, motions, distance
        )
        for _ in search.steps(surfaces):
            pass
    found = [
        Embedding(metric, metric.unit * each, method=embedding.method, tolerance=embedding.tolerance)
        for each in search.found
    ]
    order = sorted(range(len(found)), key=lambda i: found[i].surface.fine_roughness)
    return Realizations(
        embedding,
        tuple(found[i] for i in order),
        frozen(np.array([search.searched[i] for i in order], dtype=np.bool_)),
        float(distance),
        motions,
        search.flexible + search.incomplete,
    )
