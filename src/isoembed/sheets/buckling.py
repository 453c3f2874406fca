"""Buckling modes of a flat sheet: initial surfaces with two, three and more waves.

A sheet constrained to a plane is stretched in some places and compressed in others.  With decreasing
thickness it buckles into successive modes: for a displacement w normal to the plane, the stretching forces
are ``L w``, the bending forces ``2 epsilon Q w``, and they balance if ``-L w = 2 epsilon Q w``.  On a round
disc with K < 0 the modes are pairs of equal epsilon that differ by a rotation, with two, three, ... waves.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import eigsh

from isoembed.arrays import Floats
from isoembed.progress.stages import StageRecorder
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.boundary_curve import height_with_area
from isoembed.sheets.least_bending import STIFFNESSES, elastic_sheet
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.sheets.multidimensional_scaling import scaled_distances

MODES = 3
SOUGHT = 4  # number of computed eigenvectors over MODES


def buckled(
    energy: BendingEnergy, lengths: LengthConstraints, recorder: StageRecorder
) -> tuple[list[Floats], tuple[float, ...]]:
    """Buckled sheets, (V, 3), with the area of the metric, and the epsilons over the area to continue with.

    The modes of the thickest sheets come first.  There are none if no sheet lies flat without folds, or if it
    is not strained.
    """
    metric, t = lengths.metric, lengths.triangulation
    if t.genus or t.n_vertices <= SOUGHT * MODES:
        return [], STIFFNESSES
    flat = scaled_distances(metric)[:, ::-1] * [1.0, 1.0, 0.0]
    sheet = elastic_sheet(energy, lengths, flat, recorder)
    flat = sheet.relaxed(flat, STIFFNESSES[0] * energy.area, 20, 1e-3)
    a, b, c = flat[t.faces].transpose(1, 0, 2)
    signed = np.cross(b - a, c - a)[:, 2]
    if signed.min() < 0 < signed.max():
        return [], STIFFNESSES
    stress = lengths.residuals(flat) / metric.lengths
    compression = csc_array(-(t.incidence @ diags_array(stress) @ t.incidence.T))
    # A small shift removes the rigid motions of the plane.
    weights = 1e-6 * float(energy.form.diagonal().mean()) / energy.areas.mean() * energy.areas
    stiffness = csc_array(2 * energy.form + diags_array(weights))
    random = np.random.default_rng(0).normal(size=t.n_vertices)
    found, modes = eigsh(compression, SOUGHT * MODES, stiffness, which="LA", v0=random)
    starts: list[Floats] = []
    last = np.inf
    for k in np.argsort(-found):
        # Closer epsilons belong to the same mode, rotated.
        if len(starts) < MODES and STIFFNESSES[-1] * energy.area < found[k] < 0.9 * last:
            last = float(found[k])
            shape = np.outer(modes[:, k] / np.abs(modes[:, k]).max(), [0.0, 0.0, 1.0])
            starts.append(flat + height_with_area(lengths, flat, shape) * shape)
    # Closer to the critical epsilon of the flat sheet, other starts may become flat.
    thin = tuple(s for s in STIFFNESSES if s * energy.area < 0.2 * found.max())
    return starts, thin or STIFFNESSES
