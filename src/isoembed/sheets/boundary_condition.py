"""Boundary condition of a surface read from a file, for its derivatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import block_array, eye_array

from isoembed.arrays import Floats
from isoembed.errors import InvalidParameter
from isoembed.linalg import factor_general
from isoembed.mesh.triangulation import frozen
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.sheets.surface import SheetEmbedding


def with_boundary_condition(
    surface: SheetEmbedding, condition: str, heights: Floats | None = None
) -> SheetEmbedding:
    """Restore the boundary condition and tensions of a surface read from a file, as set by `embed`.

    Parameters
    ----------
    surface : SheetEmbedding
    condition : str
        ``"free"``, with the tensions that best balance the bending forces; ``"curve"``, ``"plane"`` or
        ``"heights"``.
    heights : ndarray, shape (B,), optional
        Heights of the boundary's vertices, up to a constant, for the last two.

    Raises
    ------
    InvalidParameter
        The boundary is not at these heights.
    """
    if heights is not None:
        loop = np.concatenate(surface.triangulation.boundaries)
        off = surface.vertices[loop, 2] - heights
        off = np.abs(off - off.mean())
        if off.max() > 1e-6 * surface.metric.mean_length:
            k = int(np.argmax(off))
            raise InvalidParameter(
                f"the boundary does not have the heights of {condition!r}: its vertex {loop[k]} is off "
                f"by {off[k]:.2g}"
            )
    surface = replace(surface, condition=condition, heights=heights)
    if condition != "free":
        return surface
    metric, unit = surface.metric.normalized, surface.metric.unit
    energy, lengths, x = BendingEnergy(metric), LengthConstraints(metric), surface.vertices / unit
    J, form = lengths.jacobian(x), 2 * energy.form
    K = block_array([[eye_array(x.size), J.T], [J, None]])
    solved = factor_general(K).solve(np.append((form @ x).ravel(), np.zeros(len(lengths.lengths))))
    left, tensions = solved[: x.size], -solved[x.size :]
    scale = max(float(form.diagonal().mean()), 1 / energy.area)
    return replace(surface, tensions=frozen(tensions / unit), imbalance=float(np.abs(left).max()) / scale)
