"""The report of an embedding, as the command writes it."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from isoembed.embedding.sentence import mirrored_dents
from isoembed.metric.curvature import negative_deficits
from isoembed.proof.certificate import NO_SPHERE, NOT_ASKED
from isoembed.strict_json import plain
from isoembed.surface.curvature import bend_errors
from isoembed.version import __version__

if TYPE_CHECKING:
    from isoembed.embedding.embedding import Embedding

MAX_REPORTED_ENTRIES = 800_000  # of J J^T, of 20,000 vertices: more are not factored only for a report


def report(surface: Embedding) -> dict[str, Any]:
    """The `Embedding.report`."""
    triangulation = surface.triangulation
    entries = np.sum(triangulation.degrees**2)  # of J J^T
    is_small = triangulation.is_sphere and entries <= MAX_REPORTED_ENTRIES
    certificate = NOT_ASKED
    if not triangulation.is_sphere:
        certificate = NO_SPHERE
    elif entries <= 1_200_000:  # of J J^T, of 30,000 vertices: for more, a report asks for no certificate
        certificate = surface.certificate
    found = {
        "status": surface.status,
        "message": surface.message,
        "method": surface.method,
        "version": __version__,
        "tolerance": surface.tolerance,
        "space": {"name": surface.space.name, "curvature": surface.space.curvature, "model": "conformal"},
        "input": {
            "vertices": triangulation.n_vertices,
            "edges": triangulation.n_edges,
            "faces": triangulation.n_faces,
            "negative_deficits": int(negative_deficits(surface.metric).sum()),
            "precision": _precision(surface),
        },
        "residual": {
            "max": surface.residual,
            "mean": float(surface.residuals.mean()),
            "std": float(surface.residuals.std()),
        },
        "convexity": {
            "concave_edges": int(surface.concave_edges.sum()),
            "inverted_vertices": int(surface.inverted_vertices.sum()),
            "partially_inverted_vertices": int(surface.partially_inverted_vertices.sum()),
        },
        "smoothness": {
            "bending_energy": surface.bending_energy,
            "roughness": surface.roughness,
            "fine_roughness": surface.fine_roughness,
            "rough_edges": int(surface.rough_edges.sum()),
            "smallest_singular_value": surface.smallest_singular_value if is_small else None,
        },
        "other_realizations": [
            {
                "distance": surface.distance(other),
                "roughness": other.roughness,
                "fine_roughness": other.fine_roughness,
                "mirrored": mirrored_dents(surface, other),
            }
            for other in surface.others
        ],
        "uniqueness": surface.uniqueness and surface.uniqueness.report,
        "area": surface.area,
        "volume": surface.volume if triangulation.is_closed else None,
        "integrated_mean_curvature": surface.integrated_mean_curvature,
        "certificate": certificate.as_json(),
        "stages": [asdict(stage) for stage in surface.stages],
    }
    if surface.length_errors is not None:
        found["deviation"] = {
            "length_error_rms": float(np.sqrt(np.mean(surface.length_errors**2))),
            **surface.integral_deviation(surface.length_errors).report,
        }
    return dict(plain(found))


def _precision(surface: Embedding) -> dict[str, Any] | None:
    """That of the coordinates that the lengths come from, and which bends it explains."""
    precision = surface.metric.precision
    if precision is None:
        return None
    bends = bend_errors(surface.triangulation, surface._normalized, surface._space, surface._vertex_error)
    return {
        "name": precision.name,
        "length_error": precision.length_error,
        "vertex_error": precision.vertex_error,
        "bend": {"median": float(np.median(bends)), "max": float(bends.max())},
    }
