"""`isoembed.report`: JSON report of an embedding."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from isoembed.embedding.embedding import Embedding, checked_embedding
from isoembed.embedding.mirrored import mirrored_dents
from isoembed.embedding.sensitivity import Sensitivity
from isoembed.metric.curvature import negative_deficits
from isoembed.proof.certificate import NOT_ASKED
from isoembed.strict_json import plain
from isoembed.version import __version__

MAX_REPORTED_ENTRIES = 800_000  # of J J^T, as for 20,000 vertices: larger ones are not factored for a report


def report(embedding: Embedding) -> dict[str, Any]:
    """Report of input, computation and results: the JSON object written by the command line.

    Infinite numbers (the volume of a body 1e150 across) are None.  So is the smallest singular value if J J^T
    is large, beyond 20,000 vertices or some 900 edges at one of them, as it would dominate the cost.  For the
    same reason there is no certificate beyond 30,000 vertices; call `certify` to compute it.  With
    `Embedding.length_errors` the report has the `Sensitivity.integral_deviation` under ``deviation``.

    Raises
    ------
    InvalidParameter
        The argument is not an embedding.
    """
    surface, triangulation = checked_embedding(embedding).surface, embedding.triangulation
    entries = np.sum(triangulation.degrees**2)  # of J J^T
    is_small = triangulation.is_sphere and entries <= MAX_REPORTED_ENTRIES
    certificate = NOT_ASKED
    if entries <= 1_200_000:  # of J J^T, as for 30,000 vertices
        certificate = embedding._certificate
    worst = int(np.argmax(embedding.residuals))
    found = {
        "status": embedding.status,
        "message": embedding.message,
        "method": embedding.method,
        "version": __version__,
        "tolerance": embedding.tolerance,
        "space": {"name": embedding.space.name, "curvature": embedding.space.curvature, "model": "conformal"},
        "input": {
            "vertices": triangulation.n_vertices,
            "edges": triangulation.n_edges,
            "faces": triangulation.n_faces,
            "mean_length": embedding.metric.mean_length,
            "negative_deficits": int(negative_deficits(embedding.metric).sum()),
            "precision": _precision(embedding),
        },
        "residual": {
            "max": embedding.residual,
            "mean": float(embedding.residuals.mean()),
            "std": float(embedding.residuals.std()),
            "edge": triangulation.edges[worst].tolist(),
            "given_length": embedding.metric.given_lengths[worst],
            "length": embedding.lengths[worst],
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
            "smallest_singular_value": Sensitivity(embedding).smallest_singular_value if is_small else None,
        },
        "other_realizations": [
            _merged(
                {
                    "distance": embedding.distance(other),
                    "roughness": other.surface.roughness,
                    "fine_roughness": other.surface.fine_roughness,
                    "mirrored": mirrored_dents(
                        embedding.metric, surface.mean_curvature, other.mean_curvature
                    ),
                },
                other._reported,
            )
            for other in embedding.others
        ],
        "uniqueness": embedding.uniqueness and embedding.uniqueness.report,
        "area": surface.area,
        "volume": surface.volume if triangulation.is_closed else None,
        "integrated_mean_curvature": surface.integrated_mean_curvature,
        "certificate": certificate.as_json(),
        "stages": [asdict(stage) for stage in embedding.stages],
    }
    if embedding.length_errors is not None:
        largest = float(embedding.length_errors.max()) or 1.0  # whose square may be beyond the range
        found["deviation"] = {
            "length_error_rms": largest * float(np.sqrt(np.mean((embedding.length_errors / largest) ** 2))),
            **Sensitivity(embedding).integral_deviation(embedding.length_errors).report,
        }
    return dict(plain(_merged(found, embedding._reported)))


def _merged(found: Mapping[str, Any], more: Mapping[str, Any]) -> dict[str, Any]:
    """Entries of both; mappings in both are merged, other values of the second take precedence."""
    together = {
        key: _merged(found[key], value) if isinstance(value, Mapping) and key in found else value
        for key, value in more.items()
    }
    return {**found, **together}


def _precision(embedding: Embedding) -> dict[str, Any] | None:
    """Precision of the coordinates or lengths from which the vertices come, and the resulting bend errors."""
    precision = embedding.metric.precision
    if precision is None:
        return None
    bends = embedding.surface.bend_errors
    return {
        "name": precision.name,
        "length_error": precision.length_error,
        "vertex_error": precision.vertex_error,
        "bend": {"median": float(np.median(bends)), "max": float(bends.max())},
    }
