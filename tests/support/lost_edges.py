"""Polyhedra that cannot be measured by all edges of the input."""

from dataclasses import replace

import numpy as np

import zoo
from isoembed import PolyhedralMetric, embed


def octahedron_with_a_lost_edge():
    """The regular octahedron, as if the triangles were too thin to find one of the given edges on them."""
    found = embed(PolyhedralMetric.from_mesh(*zoo.octahedron()), method="alexandrov")
    distances = found.edge_paths.distances.copy()
    distances[5] = np.nan
    return replace(found, edge_paths=replace(found.edge_paths, distances=distances), message="")
