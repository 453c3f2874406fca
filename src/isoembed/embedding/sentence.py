"""What an embedding has to say of itself in a sentence."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from isoembed.metric.curvature import deficits

if TYPE_CHECKING:
    from isoembed.embedding.embedding import Embedding


def sentence(surface: Embedding) -> str:
    """Whether the lengths are met, whether the surface may be crumpled, and which others there are."""
    e = int(np.argmax(surface.residuals))
    said = (
        f"the lengths {'are within' if surface.converged else 'miss'} the tolerance {surface.tolerance:.0e}: "
        f"the largest residual is {surface.residual:.1e} of the mean edge length, "
        f"at edge {e} {surface.metric.edges[e].tolist()}"
    )
    inverted = int(surface.inverted_vertices.sum())
    partially = int(surface.partially_inverted_vertices.sum())
    if (inverted or partially) and surface.rough_edges.any():
        said += (
            f"; {inverted} inverted and {partially} partially inverted vertices: the surface may be crumpled"
        )
    return said + "".join(_beside(surface, other) for other in surface.others)


def _beside(surface: Embedding, other: Embedding) -> str:
    """How another realization differs."""
    if other.concave_edges.any() and not surface.concave_edges.any():
        kind = "not convex"
    else:
        kind = "smoother" if other.fine_roughness < surface.fine_roughness else "rougher"
    said = (
        f"; these lengths have another realization too, {surface.distance(other):.1g} mean edge lengths "
        f"from this one and {kind}"
    )
    mirrored = mirrored_dents(surface, other)
    if mirrored:
        these = "one dent of one is a bump" if mirrored == 1 else f"{mirrored} dents of one are bumps"
        said += f", a mirror choice: {these} of the other"
    return said


def mirrored_dents(surface: Embedding, other: Embedding) -> int:
    """How many dents of the one are bumps of the other."""
    from isoembed.embedding.mirrored import mirrored_caps  # seldom needed

    curved = deficits(surface.metric.normalized)
    return len(mirrored_caps(surface.triangulation, curved, surface.mean_curvature, other.mean_curvature))
