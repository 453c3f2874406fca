"""Buckling modes of a flat sheet: initial surfaces with two, three and more waves.

A sheet that is held flat is stretched in some places and compressed in others.  As it becomes thinner it
buckles, into one mode after the other: where w is normal to the plane, the forces of stretching are ``L w``,
those of bending ``2 epsilon Q w``, and they balance if ``-L w = 2 epsilon Q w``.  On a round disc with K < 0
the modes are pairs of equal epsilon, which differ by a turn, with two, three, ... waves.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import eigsh

from isoembed.arrays import Floats
from isoembed.progress.stages import StageRecorder
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.boundary_curve import height_with_area
from isoembed.sheets.elastic_sheet import ElasticSheet
from isoembed.sheets.least_bending import STIFFNESSES
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.sheets.multidimensional_scaling import scaled_distances
from isoembed.surface.vertex_system import HeldTriangle

MODES = 3
THIN = 0.2  # of the epsilon at which the flat sheet buckles: with more, another start may become flat
DESCENT = 20  # Newton steps in the plane, at most
SETTLED = 1e-3  # mean edge lengths: a shorter step ends them
APART = 0.9  # epsilon of a mode over that of the one before: nearer ones are the same mode, turned
SOUGHT = 4  # eigenvectors sought, times MODES
HELD = 1e-6  # of the bending form, which motions of the plane as a whole do not change


def buckled(
    energy: BendingEnergy, lengths: LengthConstraints, recorder: StageRecorder
) -> tuple[list[Floats], tuple[float, ...]]:
    """Buckled sheets, (V, 3), that have the area of the metric, and epsilons over the area to begin with.

    Those of the thickest sheets first.  None where no sheet lies flat without folds, or where it is not
    strained.
    """
    metric, t = lengths.metric, lengths.triangulation
    if t.genus or t.n_vertices <= SOUGHT * MODES:
        return [], STIFFNESSES
    flat = scaled_distances(metric)[:, ::-1] * [1.0, 1.0, 0.0]
    sheet = ElasticSheet(lengths, energy.form, HeldTriangle.of(flat, t.faces[0]), recorder)
    flat = sheet.relaxed(flat, STIFFNESSES[0] * energy.area, DESCENT, SETTLED)
    a, b, c = flat[t.faces].transpose(1, 0, 2)
    signed = np.cross(b - a, c - a)[:, 2]
    if signed.min() < 0 < signed.max():
        return [], STIFFNESSES
    stress = lengths.residuals(flat) / metric.lengths
    compression = csc_array(-(t.incidence @ diags_array(stress) @ t.incidence.T))
    weights = HELD * float(energy.form.diagonal().mean()) / energy.areas.mean() * energy.areas
    stiffness = csc_array(2 * energy.form + diags_array(weights))
    random = np.random.default_rng(0).normal(size=t.n_vertices)
    found, modes = eigsh(compression, SOUGHT * MODES, stiffness, which="LA", v0=random)
    starts: list[Floats] = []
    last = np.inf
    for k in np.argsort(-found):
        if len(starts) < MODES and STIFFNESSES[-1] * energy.area < found[k] < APART * last:
            last = float(found[k])
            shape = np.outer(modes[:, k] / np.abs(modes[:, k]).max(), [0.0, 0.0, 1.0])
            starts.append(flat + height_with_area(lengths, flat, shape) * shape)
    thin = tuple(s for s in STIFFNESSES if s * energy.area < THIN * found.max())
    return starts, thin or STIFFNESSES
